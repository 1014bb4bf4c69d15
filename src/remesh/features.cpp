// What remeshing keeps: authored normals, creases, seams and the flat faces of parts.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>

#include "knead/mesh.h"
#include "math/elementary.h"
#include "mesh/edges.h"
#include "remesh/facets.h"
#include "remesh/patch.h"
#include "remesh/surface.h"

namespace knead::detail {

namespace {

constexpr std::size_t kMinCreaseEdges = 5;
const double kClearlySharpCosine = 0.5;                                // of 60 degrees between normals
const double kStraightCosine = elementary::cos(std::numbers::pi / 4);  // the largest turn of a crease at a vertex
constexpr std::size_t kFaceGrain = 8192;

// Where the authored normals are in the values of the surface.
struct NormalColumn {
  Domain domain = Domain::vertex;
  std::size_t offset = 0;  // in a row
};

std::optional<NormalColumn> find_normals(const Mesh& mesh) {
  std::size_t vertex_offset = 0;
  std::size_t corner_offset = 0;
  for (const Attribute& attribute : mesh.attributes) {
    std::size_t& offset = attribute.domain == Domain::vertex ? vertex_offset : corner_offset;
    if (attribute.domain == Domain::face) continue;
    if (attribute.name == "normal" && attribute.components == 3) return NormalColumn{attribute.domain, offset};
    offset += static_cast<std::size_t>(attribute.components);
  }
  return std::nullopt;
}

Vec3d normal_of(const Values& values, std::size_t i, std::size_t offset) {
  const auto row = values.of(i);
  return {row[offset], row[offset + 1], row[offset + 2]};
}

void set_normal(Values& values, std::size_t i, std::size_t offset, const Vec3d& n) {
  const auto row = values.of(i);
  for (std::size_t axis = 0; axis < 3; ++axis) row[offset + axis] = n[axis];
}

// Gives one number to all corners at a vertex that have the same normal.
void share_corner_normals(const Surface& s, std::size_t offset, std::vector<Vec3d>& normals,
                          std::vector<std::uint32_t>& corner_normal) {
  std::vector<std::vector<std::uint32_t>> of_vertex(s.vertex_count());
  corner_normal.assign(s.corner.size(), kNoNormal);
  for (std::uint32_t c = 0; c < s.corner.size(); ++c) {
    const Vec3d n = normal_of(s.corner_values, c, offset);
    std::vector<std::uint32_t>& known = of_vertex[s.corner[c]];
    const auto found = std::find_if(known.begin(), known.end(), [&](std::uint32_t i) { return normals[i] == n; });
    if (found != known.end()) {
      corner_normal[c] = *found;
      continue;
    }
    corner_normal[c] = static_cast<std::uint32_t>(normals.size());
    known.push_back(corner_normal[c]);
    normals.push_back(n);
  }
}

// Returns the normal of each face; for a thin face, the normal of its neighbour at the longest edge.
std::vector<Vec3d> reliable_normals(const Surface& s, const Progress* progress) {
  std::vector<Vec3d> normals(s.face_count());
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    stop_if_cancelled(progress);
    std::size_t face = f;
    if (quality(s, face, s.before) < kMinReliableQuality) {
      const std::uint32_t beyond = s.opposite[longest_edge(s, face, s.before)];
      if (beyond != kNone) face = beyond / 3;
    }
    const Vec3d n = area_vector(s, face, s.before);
    const double size = norm(n);
    if (size > 0) normals[f] = n / size;
  }
  return normals;
}

bool differ_at_corners(const Surface& s, std::uint32_t h, std::uint32_t o) {
  const auto same = [&](std::uint32_t a, std::uint32_t b) {
    const auto x = s.corner_values.of(a);
    return std::equal(x.begin(), x.end(), s.corner_values.of(b).begin());
  };
  return !same(h, Surface::next(o)) || !same(Surface::next(h), o);
}

// Returns true if the faces have different labels: those in the options, or integer attributes.
bool differ_in_label(const Mesh& mesh, const RemeshOptions& options, std::uint32_t f, std::uint32_t g) {
  if (f == g) return false;
  if (!options.face_labels.empty() && options.face_labels[f] != options.face_labels[g]) return true;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_label = attribute.domain == Domain::face && attribute.type != NumberType::float32 &&
                          attribute.type != NumberType::float64;
    const auto n = static_cast<std::ptrdiff_t>(attribute.components);
    if (is_label && !std::equal(attribute.values.begin() + f * n, attribute.values.begin() + (f + 1) * n,
                                attribute.values.begin() + g * n)) {
      return true;
    }
  }
  return false;
}

// Returns true if another sharp edge at v continues the edge of h, with a turn of at most 45 degrees.
bool is_continued(const Surface& s, const std::vector<bool>& sharp, std::uint32_t h, std::uint32_t v) {
  const std::uint32_t w = s.origin(h) == v ? s.target(h) : s.origin(h);
  const Vec3d along = s.before[v] - s.before[w];
  bool found = false;
  s.for_each_outgoing(v, [&](std::uint32_t e) {
    const std::uint32_t x = s.target(e);
    if (!sharp[s.edge[e]] || x == w) return;
    const Vec3d on = s.before[x] - s.before[v];
    found = found || dot(along, on) >= kStraightCosine * norm(along) * norm(on);
  });
  return found;
}

// Returns one half-edge for each crease edge of a rough or curved surface: a sharp edge that another one continues at
// one end at least, in a connected set of enough edges, a third of them clearly sharp. Other sharp edges are noise.
std::vector<std::uint32_t> find_long_creases(const Surface& s, double angle_deg, const Progress* progress) {
  const std::vector<Vec3d> normals = reliable_normals(s, progress);
  const auto cosine = [&](std::uint32_t h) { return dot(normals[h / 3], normals[s.opposite[h] / 3]); };
  const double sharp_cosine = elementary::cos(angle_deg * std::numbers::pi / 180);
  std::vector<bool> sharp(s.halfedge.size(), false);
  std::vector<std::uint32_t> found;
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    stop_if_cancelled(progress);
    if (s.opposite[h] == kNone || s.opposite[h] < h || cosine(h) >= sharp_cosine) continue;
    found.push_back(h);
    sharp[s.edge[h]] = true;
  }
  std::erase_if(found, [&](std::uint32_t h) {
    return !is_continued(s, sharp, h, s.origin(h)) && !is_continued(s, sharp, h, s.target(h));
  });
  DisjointSets sets(s.vertex_count());
  for (const std::uint32_t h : found) sets.join(s.origin(h), s.target(h));
  std::vector<std::size_t> size(s.vertex_count(), 0);
  std::vector<std::size_t> clear(s.vertex_count(), 0);
  for (const std::uint32_t h : found) {
    ++size[sets.find(s.origin(h))];
    if (cosine(h) < kClearlySharpCosine) ++clear[sets.find(s.origin(h))];
  }
  std::erase_if(found, [&](std::uint32_t h) {
    const std::uint32_t set = sets.find(s.origin(h));
    return size[set] < kMinCreaseEdges || 3 * clear[set] < size[set];
  });
  return found;
}

// Returns the half-edge from v to w, or kNone.
std::uint32_t halfedge_between(const Surface& s, std::uint32_t v, std::uint32_t w) {
  std::uint32_t found = kNone;
  s.for_each_outgoing(v, [&](std::uint32_t h) {
    if (s.target(h) == w) found = h;
    if (s.apex(h) == w && s.opposite[Surface::previous(h)] == kNone) found = Surface::previous(h);
  });
  return found;
}

// Marks the edges that bend, and finds the flat faces of parts.
void mark_planes(const Mesh& mesh, const Progress* progress, Surface& s) {
  const std::vector<Bend> bends = find_bends(s, kDefaultCreaseDeg, plane_tolerance(mesh.positions), progress);
  std::vector<std::uint8_t> creases(bends.size());
  for (std::size_t e = 0; e < bends.size(); ++e) {
    creases[e] = (s.edge_flags[e] & kCrease) != 0 ? 1 : 0;
    if (bends[e] != Bend::flat) s.set_edge(s.halfedge[e], kBend);
  }
  const std::vector<std::uint8_t> of_part = add_edges_of_parts(s, bends, creases);
  s.of_part.assign(mesh.face_count(), 0);
  for (std::size_t f = 0; f < of_part.size(); ++f) s.of_part[s.face_source[f]] |= of_part[f];
}

// Calls visit(t) for each triangle of the mesh that has three different corners.
template <class Visit>
void for_each_proper_triangle(const Mesh& mesh, const Progress* progress, Visit visit) {
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) {
    stop_if_cancelled(progress);
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) visit(t);
  });
}

// Returns the normal of a triangle, or zero if its quality is below 6 degrees or its height below `min_height`.
Vec3f sound_normal(const Mesh& mesh, const Triangle& t, double min_height) {
  const Vec3d& a = mesh.positions[t[0]];
  const std::array<Vec3d, 3> sides{mesh.positions[t[1]] - a, mesh.positions[t[2]] - a,
                                   mesh.positions[t[2]] - mesh.positions[t[1]]};
  const Vec3d normal = cross(sides[0], sides[1]);
  const double size2 = norm2(normal);
  const std::array<double, 3> lengths2{norm2(sides[0]), norm2(sides[1]), norm2(sides[2])};
  const auto [shortest2, longest2] = std::minmax({lengths2[0], lengths2[1], lengths2[2]});
  const double twice_cosine = lengths2[0] + lengths2[1] + lengths2[2] - 2 * shortest2;  // times the two longer sides
  const bool is_sound = size2 > kMinReliableQuality * kMinReliableQuality * twice_cosine * twice_cosine &&
                        size2 > min_height * min_height * longest2;
  return Vec3f(is_sound ? normal / std::sqrt(size2) : Vec3d{});
}

// The triangles at each vertex, in ascending order.
struct TriangleStars {
  std::vector<std::uint32_t> begin;  // of each vertex, and one more
  std::vector<std::uint32_t> triangles;

  TriangleStars(std::span<const Triangle> all, std::size_t vertices)
      : begin(vertices + 1, 0), triangles(3 * all.size()) {
    for (const Triangle& t : all) {
      for (const std::uint32_t v : t) ++begin[v];
    }
    std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), 0U);
    for (std::uint32_t t = 0; t < all.size(); ++t) {
      for (const std::uint32_t v : all[t]) triangles[begin[v]++] = t;
    }
    std::copy_backward(begin.begin(), begin.end() - 1, begin.end());
    begin.front() = 0;
  }
};

// Returns 1 for each rough vertex. A vertex is smooth if all triangles around it are sound, and the normals of any two
// differ by less than the angle, but by more than a tenth of a degree. So both ends of a sharp edge are rough, both
// ends of an edge between triangles in one plane, and all corners of a thin triangle.
std::vector<std::uint8_t> find_rough_vertices(const Mesh& mesh, double angle_deg, double tolerance, int threads,
                                              const Progress* progress) {
  constexpr double margin_deg = 0.1;  // far above rounding errors
  constexpr std::size_t kMaxTriangles = 32;
  std::vector<std::uint8_t> rough(mesh.vertex_count(), 1);
  if (!(angle_deg > 2 * margin_deg && angle_deg <= 180)) return rough;
  const auto min_cosine = static_cast<float>(elementary::cos((angle_deg - margin_deg) * std::numbers::pi / 180));
  const auto max_cosine = static_cast<float>(elementary::cos(margin_deg * std::numbers::pi / 180));
  const std::vector<Triangle> triangles = triangulate(mesh);
  const double min_height = 2 * tolerance / elementary::sin(margin_deg * std::numbers::pi / 180);
  std::vector<Vec3f> normals(triangles.size());
  parallel_for(triangles.size(), kFaceGrain, threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    for (std::size_t t = begin; t < end; ++t) normals[t] = sound_normal(mesh, triangles[t], min_height);
  });
  const TriangleStars stars(triangles, mesh.vertex_count());
  const auto are_rough = [&](std::uint32_t f, std::uint32_t g) {
    const float cosine = dot(normals[f], normals[g]);
    return !(cosine > min_cosine) || cosine > max_cosine;
  };
  parallel_for(mesh.vertex_count(), kFaceGrain, threads, [&](std::size_t first, std::size_t last) {
    stop_if_cancelled(progress);
    for (std::size_t v = first; v < last; ++v) {
      const std::span<const std::uint32_t> star(stars.triangles.data() + stars.begin[v],
                                                stars.begin[v + 1] - stars.begin[v]);
      bool is_rough = star.size() > kMaxTriangles;
      for (std::size_t i = 0; i < star.size() && !is_rough; ++i) {
        is_rough = !(norm2(normals[star[i]]) > 0);
        for (std::size_t k = 0; k < i && !is_rough; ++k) is_rough = are_rough(star[i], star[k]);
      }
      rough[v] = is_rough ? 1 : 0;
    }
  });
  return rough;
}

}  // namespace

void turn_normals(const Mesh& mesh, Surface& s) {
  const std::optional<NormalColumn> column = find_normals(mesh);
  if (!column) return;
  Mesh refined;
  refined.positions = s.before;
  refined.corner_vertex = s.corner;
  refined.face_begin.resize(s.face_count() + 1);
  for (std::size_t f = 0; f <= s.face_count(); ++f) refined.face_begin[f] = static_cast<std::uint32_t>(3 * f);
  std::vector<Vec3d> normals;
  std::vector<std::uint32_t> corner_normal = s.corner;
  if (column->domain == Domain::vertex) {
    for (std::size_t v = 0; v < s.vertex_count(); ++v) normals.push_back(normal_of(s.vertex_values, v, column->offset));
  } else {
    share_corner_normals(s, column->offset, normals, corner_normal);
  }
  normals = transport_normals(refined, s.after, normals, corner_normal);
  if (column->domain == Domain::vertex) {
    for (std::size_t v = 0; v < s.vertex_count(); ++v) set_normal(s.vertex_values, v, column->offset, normals[v]);
  } else {
    for (std::size_t c = 0; c < s.corner.size(); ++c) {
      set_normal(s.corner_values, c, column->offset, normals[corner_normal[c]]);
    }
  }
}

void normalise_normals(const Mesh& mesh, Surface& s) {
  const std::optional<NormalColumn> column = find_normals(mesh);
  if (!column) return;
  Values& values = column->domain == Domain::vertex ? s.vertex_values : s.corner_values;
  const std::size_t count = values.stride > 0 ? values.numbers.size() / values.stride : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d n = normal_of(values, i, column->offset);
    const double length = norm(n);
    // Lengths that are 1 to the rounding of float stay.
    if (length > 0 && std::abs(length - 1) > 1e-5) set_normal(values, i, column->offset, n / length);
  }
}

std::vector<MeshEdge> find_crease_edges(const Surface& s, double angle_deg, double tolerance,
                                        const Progress* progress) {
  std::vector<std::uint8_t> creases(s.halfedge.size(), 0);
  for (const std::uint32_t h : find_long_creases(s, angle_deg, progress)) creases[s.edge[h]] = 1;
  add_edges_of_parts(s, find_bends(s, angle_deg, tolerance, progress), creases);
  std::vector<MeshEdge> edges;
  for (std::size_t e = 0; e < creases.size(); ++e) {
    const std::uint32_t h = s.halfedge[e];
    if (creases[e] != 0) edges.push_back({std::min(s.origin(h), s.target(h)), std::max(s.origin(h), s.target(h))});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

void mark_features(const Mesh& mesh, const RemeshOptions& options, std::span<const std::uint32_t> patch_number,
                   Patch& patch) {
  Surface& s = patch.surface;
  const bool has_face_values = std::any_of(mesh.attributes.begin(), mesh.attributes.end(),
                                           [](const Attribute& a) { return a.domain == Domain::face; });
  for (const MeshEdge& edge : options.creases) {
    const std::uint32_t v = patch_number[edge[0]];
    const std::uint32_t w = patch_number[edge[1]];
    const std::uint32_t h = v == kNone || w == kNone ? kNone : halfedge_between(s, v, w);
    if (h == kNone) {
      patch.other_creases.push_back(edge);
    } else {
      s.set_edge(h, kFeature);
      s.set_edge(h, kCrease);
    }
  }
  mark_planes(mesh, options.progress, s);
  if (s.corner_values.stride == 0 && options.face_labels.empty() && !has_face_values) return;
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    const std::uint32_t o = s.opposite[h];
    if (o == kNone || o < h) continue;
    if (differ_at_corners(s, h, o) || differ_in_label(mesh, options, s.face_source[h / 3], s.face_source[o / 3])) {
      s.set_edge(h, kFeature);
      s.set_edge(h, kSeam);
    }
  }
}

// Connects the triangles at rough vertices only: creases lie between two rough vertices, and all faces at such an edge
// are connected.
std::vector<MeshEdge> find_creases_unless_cancelled(const Mesh& mesh, double angle_deg, int threads,
                                                    const Progress* progress) {
  const double tolerance = plane_tolerance(mesh.positions);
  const std::vector<std::uint8_t> rough = find_rough_vertices(mesh, angle_deg, tolerance, threads, progress);
  std::vector<bool> used(mesh.vertex_count(), false);
  Surface surface;
  for_each_proper_triangle(mesh, progress, [&](const Triangle& t) {
    if ((rough[t[0]] | rough[t[1]] | rough[t[2]]) == 0) return;
    surface.corner.insert(surface.corner.end(), t.begin(), t.end());
    surface.face_source.push_back(0);
    for (const std::uint32_t v : t) used[v] = true;
  });
  std::vector<std::uint32_t> vertices;  // of the surface
  std::vector<std::uint32_t> number(mesh.vertex_count(), kNone);
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    number[v] = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(v);
    surface.before.push_back(mesh.positions[v]);
  }
  surface.after = surface.before;
  for (std::uint32_t& v : surface.corner) v = number[v];
  connect(surface, progress);
  std::vector<MeshEdge> creases = find_crease_edges(surface, angle_deg, tolerance, progress);
  for (MeshEdge& edge : creases) edge = {vertices[edge[0]], vertices[edge[1]]};
  return creases;
}

}  // namespace knead::detail

std::vector<knead::MeshEdge> knead::find_creases(const Mesh& mesh, double angle_deg) {
  validate(mesh);
  return detail::find_creases_unless_cancelled(mesh, angle_deg, 0, nullptr);
}
