// What readers and writers of meshes share; see mesh_builder.h.
#include "io/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#include "io/codec.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

bool is_unit_color(const Attribute& color) {
  if (color.name != "color" || color.type == NumberType::uint8 || color.type == NumberType::uint16) return true;
  if (color.values.empty()) return true;
  return !is_integer(color.type) &&
         std::all_of(color.values.begin(), color.values.end(), [](double c) { return c >= 0 && c <= 1; });
}

void make_unit_color(Attribute& color) {
  const double scale = color_scale(color);
  const bool is_whole =
      std::all_of(color.values.begin(), color.values.end(), [](double c) { return c == std::floor(c); });
  const bool keeps_numbers = scale < 1 && is_whole;  // as bytes or shorts
  for (double& c : color.values) c = keeps_numbers ? std::clamp(c, 0.0, 1 / scale) : std::clamp(c * scale, 0.0, 1.0);
  color.type = !keeps_numbers                           ? NumberType::float32
               : scale == unit_scale(NumberType::uint8) ? NumberType::uint8
                                                        : NumberType::uint16;
}

std::uint64_t hash_of(const Vec3d& p) {
  std::uint64_t hash = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    hash ^= bit_cast<std::uint64_t>(p[axis] + 0.0);  // -0 becomes 0
    hash *= 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

constexpr std::uint64_t kHashHalf = 0xffffffff00000000u;

// Calls keep(from, to) for each row that stays, `to` its number without the others.
template <class Keep>
void for_each_kept(std::span<const std::uint32_t> unplaced, std::size_t rows, Keep keep) {
  std::size_t to = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    if (!is_unplaced(unplaced, row, to)) keep(row, to++);
  }
}

using SeamKey = std::array<double, 9>;

SeamKey seam_key(const Vec3d& before, const Vec3d& after, const Vec3d& normal) {
  return {before.x, before.y, before.z, after.x, after.y, after.z, normal.x, normal.y, normal.z};
}

// For each vertex the first one that has its position, before and after, and its normal.
std::vector<std::uint32_t> seam_leaders(std::span<const Vec3d> before, std::span<const Vec3d> after,
                                        std::span<const Vec3d> normals) {
  const auto key = [&](std::uint32_t i) { return seam_key(before[i], after[i], normals[i]); };
  std::vector<std::uint32_t> order(before.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const SeamKey a = key(i);
    const SeamKey b = key(j);
    return a != b ? a < b : i < j;
  });
  std::vector<std::uint32_t> leaders(before.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool follows = k > 0 && key(order[k]) == key(order[k - 1]);
    leaders[order[k]] = follows ? leaders[order[k - 1]] : order[k];
  }
  return leaders;
}

std::vector<Vec3d> transport_vertex_normals(const Mesh& mesh, std::span<const Vec3d> positions,
                                            const std::vector<Vec3d>& normals) {
  const std::vector<std::uint32_t> leaders = seam_leaders(mesh.positions, positions, normals);
  std::vector<std::uint32_t> corner_normal;
  corner_normal.reserve(mesh.corner_vertex.size());
  for (const std::uint32_t vertex : mesh.corner_vertex) corner_normal.push_back(leaders[vertex]);
  std::vector<Vec3d> moved = transport_normals(mesh, positions, normals, corner_normal);
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = moved[leaders[i]];
  return moved;
}

// The attribute "tangent" of vertices: x, y, z and a handedness.
void turn_tangents(const Mesh& before, std::span<const Vec3d> positions, std::span<const Vec3d> normals, Mesh& after) {
  for (Attribute& attribute : after.attributes) {
    if (attribute.name != "tangent" || attribute.domain != Domain::vertex || attribute.components != 4) continue;
    std::vector<Vec3d> tangents(normals.size());
    for (std::size_t i = 0; i < tangents.size(); ++i) {
      tangents[i] = {attribute.values[4 * i], attribute.values[4 * i + 1], attribute.values[4 * i + 2]};
    }
    tangents = transport_tangents(before, positions, tangents, normals);
    for (std::size_t i = 0; i < tangents.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) attribute.values[4 * i + axis] = tangents[i][axis];
    }
  }
}

}  // namespace

bool has_unit_colors(const Mesh& mesh) {
  return std::all_of(mesh.attributes.begin(), mesh.attributes.end(), is_unit_color);
}

Mesh with_unit_colors(Mesh mesh) {
  for (Attribute& attribute : mesh.attributes) {
    if (!is_unit_color(attribute)) make_unit_color(attribute);
  }
  return mesh;
}

std::optional<Attribute> merge_corners(const Mesh& mesh, const Attribute& attribute) {
  const std::size_t n = static_cast<std::size_t>(attribute.components);
  Attribute merged{attribute.name, Domain::vertex, attribute.type, attribute.components, {}};
  merged.values.resize(mesh.vertex_count() * n, 0.0);
  std::vector<bool> known(mesh.vertex_count(), false);
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    const double* from = attribute.values.data() + c * n;
    double* to = merged.values.data() + mesh.corner_vertex[c] * n;
    if (known[mesh.corner_vertex[c]] && !std::equal(from, from + n, to)) return std::nullopt;
    std::copy(from, from + n, to);
    known[mesh.corner_vertex[c]] = true;
  }
  return merged;
}

std::optional<Attribute> vertex_attribute(const Mesh& mesh, const std::string& name, int components) {
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.name != name || attribute.components != components) continue;
    if (attribute.domain == Domain::vertex) return attribute;
    if (attribute.domain != Domain::corner) continue;
    if (std::optional<Attribute> merged = merge_corners(mesh, attribute)) return merged;
  }
  return std::nullopt;
}

std::uint32_t Welder::vertex_at(const Vec3d& p) {
  if (2 * positions_.size() >= slots_.size()) grow();
  const std::uint64_t hash = hash_of(p);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash & mask;; slot = (slot + 1) & mask) {
    const std::uint32_t vertex = static_cast<std::uint32_t>(slots_[slot]);
    if (slots_[slot] == kEmpty) {
      const std::uint32_t added = static_cast<std::uint32_t>(positions_.size());
      slots_[slot] = (hash & kHashHalf) | added;
      positions_.push_back(p);
      return added;
    }
    if (((slots_[slot] ^ hash) & kHashHalf) == 0 && positions_[vertex] == p) return vertex;
  }
}

void Welder::grow() {
  slots_.assign(4 * slots_.size(), kEmpty);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const std::uint64_t hash = hash_of(positions_[i]);
    std::size_t slot = hash & mask;
    while (slots_[slot] != kEmpty) slot = (slot + 1) & mask;
    slots_[slot] = (hash & kHashHalf) | i;
  }
}

std::vector<bool> used_vertices(const Mesh& mesh) {
  std::vector<bool> used(mesh.vertex_count(), false);
  for (const std::uint32_t v : mesh.corner_vertex) used[v] = true;
  return used;
}

std::vector<std::uint32_t> vertices_in_no_face(const Mesh& mesh) {
  const std::vector<bool> used = used_vertices(mesh);
  std::vector<std::uint32_t> unused;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!used[v]) unused.push_back(v);
  }
  return unused;
}

void FiniteValues::append_note(std::vector<std::string>& notes) const {
  if (replaced_ == 0) return;
  notes.push_back(counted(replaced_, "attribute value is not finite and is read as 0",
                          "attribute values are not finite and are read as 0"));
}

void Unplaced::add(std::size_t row, std::size_t byte) {
  if (!rows.empty() && rows.back() == row) return;
  rows.push_back(static_cast<std::uint32_t>(row));
  begin.push_back(byte);
}

std::optional<std::size_t> first_used(const Unplaced& unplaced, const Mesh& mesh) {
  if (unplaced.rows.empty()) return std::nullopt;
  const std::vector<bool> used = used_vertices(mesh);
  for (std::size_t i = 0; i < unplaced.rows.size(); ++i) {
    if (used[unplaced.rows[i]]) return i;
  }
  return std::nullopt;
}

void remove_unplaced(const Unplaced& unplaced, Mesh& mesh) {
  if (unplaced.rows.empty()) return;
  const std::size_t rows = mesh.vertex_count();
  const std::size_t kept = rows - unplaced.rows.size();
  std::vector<std::uint32_t> number(mesh.corner_vertex.empty() ? 0 : rows, 0);
  for_each_kept(unplaced.rows, rows, [&](std::size_t from, std::size_t to) {
    mesh.positions[to] = mesh.positions[from];
    if (!number.empty()) number[from] = static_cast<std::uint32_t>(to);
  });
  mesh.positions.resize(kept);
  for (std::uint32_t& v : mesh.corner_vertex) v = number[v];
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.domain != Domain::vertex) continue;
    const std::size_t n = static_cast<std::size_t>(attribute.components);
    for_each_kept(unplaced.rows, rows, [&](std::size_t from, std::size_t to) {
      for (std::size_t c = 0; c < n; ++c) attribute.values[to * n + c] = attribute.values[from * n + c];
    });
    attribute.values.resize(kept * n);
  }
}

std::vector<Vec3d> by_row(std::span<const Vec3d> values, std::span<const std::uint32_t> unplaced) {
  std::vector<Vec3d> rows(values.size() + unplaced.size());
  for_each_kept(unplaced, rows.size(), [&](std::size_t from, std::size_t to) { rows[from] = values[to]; });
  return rows;
}

std::string unplaced_note(std::size_t count) {
  if (count == 0) return {};
  return counted(count, "vertex has coordinates that are not finite; it is kept in the file and does not move",
                 "vertices have coordinates that are not finite; they are kept in the file and do not move");
}

std::string unplaced_loss(std::size_t count) {
  if (count == 0) return {};
  return counted(count, "vertex whose coordinates are not finite is left out",
                 "vertices whose coordinates are not finite are left out");
}

std::vector<Vec3d> moved_normals(const ShapeFile& source, std::span<const Vec3d> positions,
                                 const WriteOptions& options) {
  const Codec* const codec = source.layout == nullptr ? nullptr : find_codec(source.format);
  if (codec != nullptr && codec->moved_corner_normals != nullptr) return codec->moved_corner_normals(source, positions);
  const std::vector<Vec3d> normals = vertex_normals_of(source);
  if (normals.empty()) return {};
  if (source.mesh.face_count() > 0) return transport_vertex_normals(source.mesh, positions, normals);
  return {options.normals.begin(), options.normals.end()};
}

void put_values(Mesh& mesh, std::span<const Attribute> attributes, std::span<const std::uint32_t> vertices) {
  for (const Attribute& changed : attributes) {
    const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                    [&](const Attribute& attribute) { return attribute.name == changed.name; });
    if (found == mesh.attributes.end()) continue;
    for (std::size_t k = 0; k < vertices.size(); ++k) found->values[vertices[k]] = changed.values[k];
  }
}

Mesh moved_mesh(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options) {
  Mesh mesh = source.mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  put_values(mesh, options.attributes, options.changed);
  const std::vector<Vec3d> normals = moved_normals(source, positions, options);
  if (normals.empty()) return mesh;
  turn_tangents(source.mesh, positions, normals, mesh);
  for (Attribute& attribute : mesh.attributes) {
    if (attribute.name != "normal") continue;
    for (std::size_t i = 0; i < attribute.values.size() / 3; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) attribute.values[3 * i + axis] = normals[i][axis];
    }
    break;
  }
  return mesh;
}

}  // namespace knead::detail
