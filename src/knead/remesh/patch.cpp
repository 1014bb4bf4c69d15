#include "knead/remesh/patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "knead/math/scalar.h"
#include "knead/mesh/measures.h"
#include "knead/remesh/face_samples.h"

namespace knead::remesh_detail {

namespace {

bool same_bits(const Vec3d& a, const Vec3d& b) {
  using Bits = std::array<std::uint64_t, 3>;
  return bit_cast<Bits>(a) == bit_cast<Bits>(b);
}

// Returns whether a mask holds all vertices of the face.
bool stays(std::span<const std::uint32_t> face, const RemeshOptions& options) {
  return !options.held.empty() &&
         std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return options.held[v] != 0; });
}

bool repeats_a_vertex(std::span<const std::uint32_t> face) {
  for (std::size_t i = 0; i < face.size(); ++i) {
    for (std::size_t j = i + 1; j < face.size(); ++j) {
      if (face[i] == face[j]) return true;
    }
  }
  return false;
}

// Returns whether the face can be cut into triangles with an area. One that runs round a hole passes the ends of a
// bridge twice; there its triangles meet.
bool is_sound(std::span<const Vec3d> positions, std::span<const std::uint32_t> face) {
  if (face.size() < 3) return false;
  if (!repeats_a_vertex(face)) return true;
  std::vector<Triangle> parts;
  triangulate_polygon(positions, face, parts);
  return std::none_of(parts.begin(), parts.end(), [&](const Triangle& t) {
    return repeats_a_vertex(t) || is_degenerate(positions[t[0]], positions[t[1]], positions[t[2]]);
  });
}

// Returns a flag for each face of the mesh: true if the patch holds it.
std::vector<bool> find_faces(const Mesh& before, const std::vector<bool>& moved, const Deformation& deformation,
                             const RemeshOptions& options) {
  const bool whole = options.whole;
  const std::size_t faces = before.face_count();
  std::vector<bool> touched(faces, whole);
  FaceSamples large(deformation, options.progress);
  const bool search = std::isfinite(deformation.feature) && !whole;
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < faces && !whole; ++f) {
    stop_if_cancelled(options.progress);
    const auto face = before.face(f);
    touched[f] = std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return moved[v]; });
    if (touched[f] || !search || face.size() < 3) continue;
    parts.clear();
    triangulate_polygon(before.positions, face, parts);
    for (const Triangle& t : parts) {
      const std::array<Vec3d, 3> corners{before.positions[t[0]], before.positions[t[1]], before.positions[t[2]]};
      large.add(static_cast<std::uint32_t>(f), corners, corners);
    }
  }
  const std::optional<std::vector<std::uint32_t>> deviating = large.deviating_faces(0);
  if (!deviating) large.refuse(options.targets.max_vertices);
  for (const std::uint32_t f : *deviating) touched[f] = true;
  std::vector<bool> near(before.vertex_count(), false);
  for (std::size_t f = 0; f < faces; ++f) {
    if (!touched[f]) continue;
    for (const std::uint32_t v : before.face(f)) near[v] = true;
  }
  std::vector<bool> held(faces, false);
  for (std::size_t f = 0; f < faces; ++f) {
    const auto face = before.face(f);
    const bool is_near = std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return near[v]; });
    held[f] = is_near && !stays(face, options) && is_sound(before.positions, face);
  }
  return held;
}

struct Columns {
  std::vector<const Attribute*> attributes;
  std::size_t stride = 0;
};

Columns columns_of(const Mesh& mesh, Domain domain) {
  Columns columns;
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain != domain) continue;
    columns.attributes.push_back(&attribute);
    columns.stride += static_cast<std::size_t>(attribute.components);
  }
  return columns;
}

void append_row(const Columns& columns, std::size_t element, Values& values) {
  for (const Attribute* attribute : columns.attributes) {
    const auto n = static_cast<std::size_t>(attribute->components);
    const auto from = attribute->values.begin() + static_cast<std::ptrdiff_t>(element * n);
    values.numbers.insert(values.numbers.end(), from, from + static_cast<std::ptrdiff_t>(n));
  }
}

// Returns the number in the patch of each vertex of the mesh, in the order of the mesh; kNone outside the patch.
std::vector<std::uint32_t> number_vertices(const Mesh& mesh, Patch& patch) {
  std::vector<std::uint32_t> number(mesh.vertex_count(), kNone);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (!patch.holds_face[f]) continue;
    for (const std::uint32_t v : mesh.face(f)) number[v] = 0;
  }
  for (std::uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kNone) continue;
    number[v] = static_cast<std::uint32_t>(patch.vertex_source.size());
    patch.vertex_source.push_back(v);
  }
  return number;
}

void take_faces(const Mesh& mesh, const std::vector<std::uint32_t>& number, const Progress* progress, Patch& patch) {
  Surface& s = patch.surface;
  const Columns columns = columns_of(mesh, Domain::corner);
  s.corner_values.stride = columns.stride;
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    stop_if_cancelled(progress);
    if (!patch.holds_face[f]) continue;
    const auto face = mesh.face(f);
    parts.clear();
    triangulate_polygon(mesh.positions, face, parts);
    for (const Triangle& t : parts) {
      s.face_source.push_back(static_cast<std::uint32_t>(f));
      patch.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
      for (const std::uint32_t v : t) {
        s.corner.push_back(number[v]);
        const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
        append_row(columns, mesh.face_begin[f] + at, s.corner_values);
      }
    }
  }
}

// Fixes vertices that faces outside the patch use, and locks edges between two of them. Fixes those that are held.
void fix_border(const Mesh& mesh, const std::vector<std::uint32_t>& number, std::span<const std::uint8_t> held,
                Patch& patch) {
  Surface& s = patch.surface;
  std::vector<bool> on_border(s.vertex_count(), false);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (patch.holds_face[f]) continue;
    for (const std::uint32_t v : mesh.face(f)) {
      if (number[v] != kNone) on_border[number[v]] = true;
    }
  }
  for (std::size_t v = 0; v < on_border.size(); ++v) {
    const bool is_held = !held.empty() && held[patch.vertex_source[v]] != 0;
    if (on_border[v] || is_held) s.set(static_cast<std::uint32_t>(v), kFixed);
  }
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (on_border[s.origin(h)] && on_border[s.target(h)]) s.set_edge(h, kLocked);
  }
}

// Marks the moved vertices and their neighbours as the region to improve, or all vertices if `whole`.
void mark_region(const std::vector<bool>& moved, bool whole, Patch& patch) {
  Surface& s = patch.surface;
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    if (moved[patch.vertex_source[v]]) s.set(static_cast<std::uint32_t>(v), kMoved);
  }
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    bool in_region = whole || s.has(v, kMoved);
    s.for_each_outgoing(
        v, [&](std::uint32_t h) { in_region = in_region || s.has(s.target(h), kMoved) || s.has(s.apex(h), kMoved); });
    if (in_region) s.set(v, kRegion);
  }
}

}  // namespace

Patch take_patch(const Mesh& before, std::span<const Vec3d> after, const Deformation& deformation,
                 const RemeshOptions& options) {
  std::vector<bool> moved(before.vertex_count());
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] = !same_bits(before.positions[v], after[v]);
  Patch patch;
  patch.holds_face = find_faces(before, moved, deformation, options);
  stop_if_cancelled(options.progress);
  const std::vector<std::uint32_t> number = number_vertices(before, patch);
  stop_if_cancelled(options.progress);
  Surface& s = patch.surface;
  const Columns columns = columns_of(before, Domain::vertex);
  s.vertex_values.stride = columns.stride;
  for (const std::uint32_t v : patch.vertex_source) {
    s.before.push_back(before.positions[v]);
    s.after.push_back(after[v]);
    append_row(columns, v, s.vertex_values);
  }
  take_faces(before, number, options.progress, patch);
  stop_if_cancelled(options.progress);
  connect(s, options.progress);
  stop_if_cancelled(options.progress);
  fix_border(before, number, options.held, patch);
  stop_if_cancelled(options.progress);
  mark_region(moved, options.whole, patch);
  mark_features(before, options, number, patch);
  return patch;
}

}  // namespace knead::remesh_detail
