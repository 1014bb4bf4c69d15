// Meshes as triangles for the GPU: smooth groups, normals, colours, wires.
#include "render/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

#include "knead/mesh.h"
#include "mesh/edges.h"

namespace knead::render {

PlacedFaces place_faces(const Mesh& mesh, const Placement& placement) {
  PlacedFaces data;
  data.positions.reserve(mesh.vertex_count());
  for (const Vec3d& p : mesh.positions) data.positions.push_back(placement.apply(p));
  data.normals.reserve(mesh.face_count());
  data.corner_face.reserve(mesh.corner_vertex.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    data.corner_face.insert(data.corner_face.end(), face.size(), static_cast<std::uint32_t>(f));
    const Vec3d normal = face.size() < 3 ? Vec3d{} : polygon_normal(data.positions, face);
    const double length = norm(normal);
    data.normals.push_back(length > 0 && std::isfinite(length) ? Vec3f(normal / length) : Vec3f{});
  }
  return data;
}

std::vector<Triangle> corner_triangles(const Mesh& mesh, const PlacedFaces& faces) {
  std::vector<Triangle> result;
  result.reserve(mesh.face_count());
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> local;
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (faces.normals[f] == Vec3f{}) continue;
    const std::uint32_t first = mesh.face_begin[f];
    const auto face = mesh.face(f);
    if (face.size() == 3) {
      result.push_back({first, first + 1, first + 2});
      continue;
    }
    points.clear();
    for (const std::uint32_t v : face) points.push_back(faces.positions[v]);
    local.resize(face.size());
    std::iota(local.begin(), local.end(), 0u);
    triangles.clear();
    triangulate_polygon(points, local, triangles);
    for (const Triangle& t : triangles) result.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return result;
}

std::pair<std::uint32_t, std::uint32_t> around(const Mesh& mesh, const PlacedFaces& faces, std::uint32_t corner) {
  const std::uint32_t f = faces.corner_face[corner];
  const std::uint32_t begin = mesh.face_begin[f];
  const std::uint32_t end = mesh.face_begin[f + 1];
  return {mesh.corner_vertex[corner == begin ? end - 1 : corner - 1],
          mesh.corner_vertex[corner + 1 == end ? begin : corner + 1]};
}

namespace {

// Calls visit(corner, vertex, normal) for the corners of the faces that are not left out.
template <class Visit>
void visit_corners(const Mesh& mesh, const PlacedFaces& faces, const Visit& visit) {
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3f normal = faces.normals[f];
    if (normal == Vec3f{}) continue;
    for (std::uint32_t c = mesh.face_begin[f]; c < mesh.face_begin[f + 1]; ++c) visit(c, mesh.corner_vertex[c], normal);
  }
}

// Returns one corner of each vertex around which no two faces bend by more than the angle; kNoVertex for others. Most
// vertices are like this, and their edges need not be tested.
std::vector<std::uint32_t> corners_of_even_vertices(const Mesh& mesh, const PlacedFaces& faces, double crease_angle) {
  std::vector<std::uint32_t> corners(mesh.vertex_count(), kNoVertex);
  if (crease_angle < 0) return corners;
  std::vector<Vec3f> sums(mesh.vertex_count());
  visit_corners(mesh, faces, [&](std::uint32_t corner, std::uint32_t v, const Vec3f& normal) {
    sums[v] += normal;
    corners[v] = corner;
  });
  const auto cosine = static_cast<float>(std::cos(0.5 * std::min(crease_angle, std::numbers::pi)));
  for (Vec3f& sum : sums) sum = sum / std::max(norm(sum), 1e-6F);
  visit_corners(mesh, faces, [&](std::uint32_t, std::uint32_t v, const Vec3f& normal) {
    if (dot(normal, sums[v]) < cosine) corners[v] = kNoVertex;
  });
  return corners;
}

// The corners at each of the other vertices: list[begin[v]] to list[begin[v + 1]].
struct Incidence {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> list;
};

Incidence incidence(const Mesh& mesh, const PlacedFaces& faces, const std::vector<std::uint32_t>& even) {
  Incidence result;
  result.begin.assign(mesh.vertex_count() + 1, 0);
  visit_corners(mesh, faces, [&](std::uint32_t, std::uint32_t v, const Vec3f&) {
    if (even[v] == kNoVertex) ++result.begin[v + 1];
  });
  std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
  result.list.resize(result.begin.back());
  if (result.list.empty()) return result;
  std::vector<std::uint32_t> next(result.begin.begin(), result.begin.end() - 1);
  visit_corners(mesh, faces, [&](std::uint32_t corner, std::uint32_t v, const Vec3f&) {
    if (even[v] == kNoVertex) result.list[next[v]++] = corner;
  });
  return result;
}

// Sorts the corners around single vertices into smooth groups; keeps its scratch memory.
class CreaseSplitter {
 public:
  CreaseSplitter(const Mesh& mesh, const PlacedFaces& data, double crease_angle)
      : mesh_(mesh), data_(data), split_all_(crease_angle < 0), cosine_(std::cos(std::max(0.0, crease_angle))) {}

  // The group of each corner, named by one of its members (an index into corners).
  const std::vector<std::uint32_t>& groups(std::span<const std::uint32_t> corners) {
    parent_.resize(corners.size());
    std::iota(parent_.begin(), parent_.end(), 0u);
    if (split_all_) return parent_;
    neighbors_.clear();
    for (std::uint32_t i = 0; i < corners.size(); ++i) add_neighbors(corners[i], i);
    std::sort(neighbors_.begin(), neighbors_.end());
    for (std::size_t i = 1; i < neighbors_.size(); ++i) {
      if (neighbors_[i].first != neighbors_[i - 1].first) continue;
      const std::uint32_t a = neighbors_[i - 1].second;
      const std::uint32_t b = neighbors_[i].second;
      if (dot(normal(corners[a]), normal(corners[b])) >= cosine_) parent_[root(a)] = root(b);
    }
    for (std::uint32_t i = 0; i < corners.size(); ++i) parent_[i] = root(i);
    return parent_;
  }

 private:
  const Vec3f& normal(std::uint32_t corner) const { return data_.normals[data_.corner_face[corner]]; }

  void add_neighbors(std::uint32_t corner, std::uint32_t index) {
    const auto [previous, next] = around(mesh_, data_, corner);
    neighbors_.emplace_back(previous, index);
    neighbors_.emplace_back(next, index);
  }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  const Mesh& mesh_;
  const PlacedFaces& data_;
  bool split_all_;
  double cosine_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> neighbors_;
};

// The angle of (x, y), where y is not negative, within 1e-5: Abramowitz and Stegun, "Handbook of mathematical
// functions" (1964), 4.4.49.
double angle_of(double y, double x) {
  const double size = std::abs(x);
  const double r = std::min(size, y) / std::max(std::max(size, y), 1e-300);
  const double s = r * r;
  const double low = r * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))));
  const double acute = y > size ? 0.5 * std::numbers::pi - low : low;
  return x < 0 ? std::numbers::pi - acute : acute;
}

// Adds to each drawn vertex the normals of its faces, each as long as the angle of the face's corner.
void add_weighted_normals(const Mesh& mesh, const PlacedFaces& faces, const SmoothGroups& groups,
                          std::vector<Vec3f>& sums) {
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (faces.normals[f] == Vec3f{}) continue;
    const auto face = mesh.face(f);
    Vec3d before = faces.positions[face.back()] - faces.positions[face.front()];
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint32_t next = face[i + 1 < face.size() ? i + 1 : 0];
      const Vec3d after = faces.positions[next] - faces.positions[face[i]];
      const double angle = angle_of(norm(cross(after, before)), dot(after, before));
      sums[groups.corner_vertex[mesh.face_begin[f] + i]] += faces.normals[f] * static_cast<float>(angle + 1e-9);
      before = -after;
    }
  }
}

// Appends a vertex per smooth group.
void add_vertices(const Mesh& mesh, const PlacedFaces& faces, const std::vector<Bytes4>& colors,
                  const SmoothGroups& groups, DrawSurface& surface) {
  std::vector<Vec3f> sums(groups.corner.size());
  add_weighted_normals(mesh, faces, groups, sums);
  surface.vertices.reserve(groups.corner.size());
  for (std::size_t drawn = 0; drawn < sums.size(); ++drawn) {
    const std::uint32_t corner = groups.corner[drawn];
    const std::uint32_t v = mesh.corner_vertex[corner];
    const float length = norm(sums[drawn]);
    const Vec3f normal = length > 1e-12F ? sums[drawn] / length : faces.normals[faces.corner_face[corner]];
    surface.vertices.push_back({Vec3f(faces.positions[v]), normal, colors.empty() ? to_bytes({}) : colors[v]});
  }
}

// Adds a triangle with its own vertices, which have the distances from the polygon's edges.
void add_wire_triangle(const std::array<std::uint32_t, 3>& local, const std::array<std::uint32_t, 3>& drawn,
                       std::size_t face_size, DrawSurface& surface) {
  const auto real = [&](std::uint32_t a, std::uint32_t b) {
    return (a + 1) % face_size == b || (b + 1) % face_size == a;
  };
  const std::array<bool, 3> edges{real(local[1], local[2]), real(local[2], local[0]), real(local[0], local[1])};
  for (std::size_t k = 0; k < 3; ++k) {
    DrawVertex vertex = surface.vertices[drawn[k]];
    for (std::size_t e = 0; e < 3; ++e) vertex.edge[e] = !edges[e] || e == k ? 255 : 0;
    surface.indices.push_back(static_cast<std::uint32_t>(surface.vertices.size()));
    surface.vertices.push_back(vertex);
  }
}

void add_triangles(const Mesh& mesh, const PlacedFaces& faces, const std::vector<std::uint32_t>& corner_vertex,
                   bool wireframe, DrawSurface& surface) {
  const std::vector<Triangle> triangles = corner_triangles(mesh, faces);
  surface.indices.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    const Triangle drawn{corner_vertex[t[0]], corner_vertex[t[1]], corner_vertex[t[2]]};
    if (!wireframe) {
      surface.indices.insert(surface.indices.end(), drawn.begin(), drawn.end());
      continue;
    }
    const std::uint32_t f = faces.corner_face[t[0]];
    const std::uint32_t first = mesh.face_begin[f];
    add_wire_triangle({t[0] - first, t[1] - first, t[2] - first}, drawn, mesh.face(f).size(), surface);
  }
}

// Returns a number that two edges share with a probability of 2^-64: the finalizer of SplitMix64 (Steele and others
// 2014).
std::uint64_t edge_number(std::uint32_t a, std::uint32_t b) {
  std::uint64_t x = (std::uint64_t{a} << 32 | b) + 0x9e3779b97f4a7c15;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
  x = (x ^ x >> 27) * 0x94d049bb133111eb;
  return x ^ x >> 31;
}

// Returns whether the mesh is closed and turned outwards. Closed: each edge occurs equally often in both directions, so
// that the sum of edge numbers, with the sign of the direction, is 0. Turned outwards: the volume of every connected
// part is positive.
bool is_solid(const Mesh& mesh, const std::vector<Vec3d>& positions) {
  DisjointSets parts(positions.size());
  std::uint64_t open = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint32_t a = face[i];
      const std::uint32_t b = face[i + 1 < face.size() ? i + 1 : 0];
      open += a < b ? edge_number(a, b) : 0 - edge_number(b, a);
      if (i > 0) parts.join(a, face[0]);
    }
  }
  if (open != 0) return false;
  std::vector<double> volumes(positions.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 2; i < face.size(); ++i) {
      volumes[parts.find(face[0])] += dot(positions[face[0]], cross(positions[face[i - 1]], positions[face[i]]));
    }
  }
  for (std::uint32_t v = 0; v < volumes.size(); ++v) {
    if (parts.find(v) == v && !(volumes[v] >= 0)) return false;
  }
  return true;
}

void add_points(const Mesh& mesh, const std::vector<Bytes4>& colors, const Placement& placement, DrawSurface& surface) {
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3d p = placement.apply(mesh.positions[v]);
    if (is_finite(p)) surface.vertices.push_back({Vec3f(p), {}, colors.empty() ? to_bytes({}) : colors[v]});
  }
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::isnan(value) ? 0 : std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

}  // namespace

SmoothGroups smooth_groups(const Mesh& mesh, const PlacedFaces& faces, double crease_angle) {
  const std::vector<std::uint32_t> even = corners_of_even_vertices(mesh, faces, crease_angle);
  const Incidence at = incidence(mesh, faces, even);
  CreaseSplitter splitter(mesh, faces, crease_angle);
  SmoothGroups result;
  result.corner_vertex.assign(mesh.corner_vertex.size(), kNoVertex);
  result.begin.assign(1, 0);
  result.begin.reserve(mesh.vertex_count() + 1);
  result.corner.reserve(mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (even[v] != kNoVertex) result.corner.push_back(even[v]);
    const std::span<const std::uint32_t> corners(at.list.data() + at.begin[v], at.begin[v + 1] - at.begin[v]);
    const auto& groups = splitter.groups(corners);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (groups[i] != i) continue;
      result.corner_vertex[corners[i]] = static_cast<std::uint32_t>(result.corner.size());
      result.corner.push_back(corners[i]);
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      result.corner_vertex[corners[i]] = result.corner_vertex[corners[groups[i]]];
    }
    result.begin.push_back(static_cast<std::uint32_t>(result.corner.size()));
  }
  visit_corners(mesh, faces, [&](std::uint32_t corner, std::uint32_t v, const Vec3f&) {
    if (even[v] != kNoVertex) result.corner_vertex[corner] = result.begin[v];
  });
  return result;
}

Bytes4 to_bytes(const Color& color) {
  return {to_byte(color.red), to_byte(color.green), to_byte(color.blue), to_byte(color.alpha)};
}

std::vector<Bytes4> colors_of(const Shape& shape) {
  const std::size_t count = shape.mesh->vertex_count();
  if (shape.vertex_colors.size() == count) {
    std::vector<Bytes4> colors;
    for (const Color& color : shape.vertex_colors) colors.push_back(to_bytes(color));
    return colors;
  }
  std::vector<Bytes4> colors(count, to_bytes(shape.color));
  const Attribute* attribute = shape.use_mesh_colors ? shape.mesh->find_attribute("color") : nullptr;
  if (attribute == nullptr || attribute->domain != Domain::vertex || attribute->components < 3) return colors;
  const auto step = static_cast<std::size_t>(attribute->components);
  if (attribute->values.size() != step * count) return colors;
  const double scale = color_scale(*attribute);
  for (std::size_t v = 0; v < count; ++v) {
    for (std::size_t k = 0; k < 3; ++k) colors[v][k] = to_byte(attribute->values[step * v + k] * scale);
  }
  return colors;
}

DrawSurface make_surface(const Mesh& mesh, const std::vector<Bytes4>& vertex_colors, const Placement& placement,
                         const SurfaceOptions& options) {
  DrawSurface surface;
  if (mesh.face_count() == 0) {
    add_points(mesh, vertex_colors, placement, surface);
    return surface;
  }
  const PlacedFaces faces = place_faces(mesh, placement);
  const SmoothGroups groups = smooth_groups(mesh, faces, options.crease_angle);
  add_vertices(mesh, faces, vertex_colors, groups, surface);
  add_triangles(mesh, faces, groups.corner_vertex, options.wireframe, surface);
  surface.is_solid = is_solid(mesh, faces.positions);
  return surface;
}

}  // namespace knead::render
