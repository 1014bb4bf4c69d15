#include "gestures/parts.h"

#include <algorithm>
#include <map>

#include "knead/remesh.h"
#include "knead/vec.h"

namespace knead::studio {

namespace {

// Vertices that remeshing has made: of a part yet to be found.
constexpr std::uint8_t kUnknown = 255;

std::uint32_t source_of(const ShapeState& state, std::uint32_t vertex) {
  return state.provenance ? state.provenance->vertex_source[vertex] : vertex;
}

// Gives unknown vertices the part of a neighbour, from neighbour to neighbour.
void spread(const Mesh& mesh, std::vector<std::uint8_t>& marks) {
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      const auto known = std::find_if(face.begin(), face.end(), [&](std::uint32_t v) { return marks[v] != kUnknown; });
      if (known == face.end()) continue;
      for (const std::uint32_t v : face) {
        if (marks[v] != kUnknown) continue;
        marks[v] = marks[*known];
        has_changed = true;
      }
    }
  }
  std::replace(marks.begin(), marks.end(), kUnknown, std::uint8_t{0});
}

std::vector<std::uint8_t> taken_over(const std::vector<std::uint8_t>& marks, const ShapeState& from,
                                     const ShapeState& to) {
  std::vector<std::uint8_t> of_source;
  for (std::uint32_t v = 0; v < marks.size(); ++v) {
    const std::uint32_t source = source_of(from, v);
    if (source == kNewVertex) continue;
    if (source >= of_source.size()) of_source.resize(source + 1, kUnknown);
    of_source[source] = marks[v];
  }
  std::vector<std::uint8_t> result(to.positions.size(), kUnknown);
  for (std::uint32_t v = 0; v < result.size(); ++v) {
    const std::uint32_t source = source_of(to, v);
    if (source < of_source.size()) result[v] = of_source[source];
  }
  spread(*to.mesh, result);
  return result;
}

void place_gizmo(PartMarks& parts) {
  parts.placement = parts.selected ? joint_of(parts, *parts.selected, parts.at) : std::nullopt;
}

void begin_marking(const ShapeState& state, PartMarks& parts) {
  follow(parts, state);
  if (parts.of_vertex.empty()) parts.of_vertex.resize(state.positions.size());
  parts.at = state;
  parts.seats.clear();
}

}  // namespace

std::optional<std::size_t> part_of(const PartMarks& parts, std::uint32_t vertex) {
  if (vertex >= parts.of_vertex.size() || parts.of_vertex[vertex] == 0) return std::nullopt;
  return parts.of_vertex[vertex] - 1u;
}

std::optional<std::size_t> add_part(std::span<const std::uint32_t> vertices, const ShapeState& state,
                                    PartMarks& parts) {
  if (vertices.empty() || parts.holds.size() == kMaxParts) return std::nullopt;
  parts.holds.push_back(true);
  parts.stiffness.push_back(1);
  mark(vertices, parts.holds.size() - 1, state, parts);
  remove_empty_parts(parts);
  select_part(parts.holds.size() - 1, parts);
  return parts.selected;
}

void mark(std::span<const std::uint32_t> vertices, std::optional<std::size_t> part, const ShapeState& state,
          PartMarks& parts) {
  begin_marking(state, parts);
  const std::uint8_t number = part ? static_cast<std::uint8_t>(*part + 1) : std::uint8_t{0};
  for (const std::uint32_t v : vertices) parts.of_vertex[v] = number;
  place_gizmo(parts);
}

void remove_part(std::size_t part, PartMarks& parts) {
  parts.seats.clear();
  for (std::uint8_t& number : parts.of_vertex) {
    if (number == part + 1) {
      number = 0;
    } else if (number > part + 1) {
      --number;
    }
  }
  parts.holds.erase(parts.holds.begin() + static_cast<std::ptrdiff_t>(part));
  parts.stiffness.erase(parts.stiffness.begin() + static_cast<std::ptrdiff_t>(part));
  if (parts.selected == part) parts.selected.reset();
  if (parts.selected && *parts.selected > part) --*parts.selected;
  if (parts.holds.empty()) parts = {};
  place_gizmo(parts);
}

void remove_empty_parts(PartMarks& parts) {
  for (std::size_t part = parts.holds.size(); part-- > 0;) {
    const auto number = static_cast<std::uint8_t>(part + 1);
    const bool is_empty = std::find(parts.of_vertex.begin(), parts.of_vertex.end(), number) == parts.of_vertex.end();
    if (is_empty) remove_part(part, parts);
  }
}

void select_part(std::optional<std::size_t> part, PartMarks& parts) {
  parts.selected = part;
  place_gizmo(parts);
}

void follow(PartMarks& parts, const ShapeState& state) {
  if (parts.of_vertex.empty() || (parts.at.is_same(state) && !parts.is_ahead)) return;
  parts.is_ahead = false;
  if (parts.at.mesh != state.mesh) {
    std::erase_if(parts.seats, [](const PartMarks::PinVertex& one) { return one.mesh.expired(); });
    const auto known = std::find_if(parts.seats.begin(), parts.seats.end(),
                                    [&](const PartMarks::PinVertex& one) { return one.mesh.lock() == state.mesh; });
    std::vector<std::uint8_t> next =
        known != parts.seats.end() ? known->of_vertex : taken_over(parts.of_vertex, parts.at, state);
    const bool is_kept = std::any_of(parts.seats.begin(), parts.seats.end(),
                                     [&](const PartMarks::PinVertex& one) { return one.mesh.lock() == parts.at.mesh; });
    if (!is_kept) parts.seats.push_back({parts.at.mesh, parts.of_vertex});
    parts.of_vertex = std::move(next);
  }
  parts.at = state;
  place_gizmo(parts);
}

std::vector<std::uint32_t> vertices_of(const PartMarks& parts, std::size_t part) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < parts.of_vertex.size(); ++v) {
    if (parts.of_vertex[v] == part + 1) vertices.push_back(v);
  }
  return vertices;
}

std::optional<Placement> joint_of(const PartMarks& parts, std::size_t part, const ShapeState& state) {
  const std::vector<std::uint32_t> vertices = vertices_of(parts, part);
  if (vertices.empty()) return std::nullopt;
  Vec3d middle{0, 0, 0};
  for (const std::uint32_t v : vertices) middle += state.positions[v];
  middle = middle / static_cast<double>(vertices.size());
  Vec3d border{0, 0, 0};
  std::size_t count = 0;
  const Mesh& mesh = *state.mesh;
  const auto is_inside = [&](std::uint32_t v) { return parts.of_vertex[v] == part + 1; };
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const auto inside = std::count_if(face.begin(), face.end(), is_inside);
    if (inside == 0 || inside == static_cast<std::ptrdiff_t>(face.size())) continue;
    for (const std::uint32_t v : face) {
      if (!is_inside(v)) continue;
      border += state.positions[v];
      ++count;
    }
  }
  Placement joint{middle};
  if (count == 0) return joint;
  joint.center = border / static_cast<double>(count);
  const Vec3d along = middle - joint.center;
  if (!(norm2(along) > 0)) return joint;
  joint.z = normalized(along);
  joint.x = any_orthogonal(joint.z);
  joint.y = cross(joint.z, joint.x);
  return joint;
}

}  // namespace knead::studio
