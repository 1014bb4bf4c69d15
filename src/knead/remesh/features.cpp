#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "knead/math/elementary.h"
#include "knead/mesh/edges.h"
#include "knead/remesh/patch.h"
#include "knead/remesh/shape.h"

namespace knead::remesh_detail {

namespace {

constexpr std::size_t kFewestEdges = 5;                                // smallest number of edges of a crease
const double kClearlySharpCosine = 0.5;                                // of 60 degrees between normals
const double kStraightCosine = elementary::cos(std::numbers::pi / 4);  // the largest turn of a crease at a vertex

// Returns the normal of each face; for a thin face, the normal of its neighbour at the longest edge.
std::vector<Vec3d> reliable_normals(const Surface& s, const Progress* progress) {
  std::vector<Vec3d> normals(s.face_count());
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    stop_if_cancelled(progress);
    std::size_t face = f;
    if (quality(s, face, s.before) < kThin) {
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

// Returns true if another sharp edge at v continues the edge of h about straight.
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

// Returns one half-edge for each edge of a crease: a sharp edge that another one continues at one end at least, in a
// connected set of enough edges, a third of them clearly sharp. Other sharp edges are noise of a rough surface.
std::vector<std::uint32_t> find_crease_halfedges(const Surface& s, double angle_deg, const Progress* progress) {
  const std::vector<Vec3d> normals = reliable_normals(s, progress);
  const auto cosine = [&](std::uint32_t h) { return dot(normals[h / 3], normals[s.opposite[h] / 3]); };
  const double most = elementary::cos(angle_deg * std::numbers::pi / 180);
  std::vector<bool> sharp(s.halfedge.size(), false);
  std::vector<std::uint32_t> found;
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    stop_if_cancelled(progress);
    if (s.opposite[h] == kNone || s.opposite[h] < h || cosine(h) >= most) continue;
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
    return size[set] < kFewestEdges || 3 * clear[set] < size[set];
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

}  // namespace

std::vector<MeshEdge> find_crease_edges(const Surface& s, double angle_deg, const Progress* progress) {
  std::vector<MeshEdge> edges;
  for (const std::uint32_t h : find_crease_halfedges(s, angle_deg, progress)) {
    edges.push_back({std::min(s.origin(h), s.target(h)), std::max(s.origin(h), s.target(h))});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

void mark_features(const Mesh& mesh, const RemeshOptions& options, std::span<const std::uint32_t> patch_number,
                   Patch& patch) {
  Surface& s = patch.surface;
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
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    const std::uint32_t o = s.opposite[h];
    if (o == kNone || o < h) continue;
    if (differ_at_corners(s, h, o) || differ_in_label(mesh, options, s.face_source[h / 3], s.face_source[o / 3])) {
      s.set_edge(h, kFeature);
      s.set_edge(h, kSeam);
    }
  }
}

std::vector<MeshEdge> find_creases_unless_cancelled(const Mesh& mesh, double angle_deg, const Progress* progress) {
  Surface surface;
  surface.before = mesh.positions;
  surface.after = mesh.positions;
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) {
    stop_if_cancelled(progress);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
    surface.corner.insert(surface.corner.end(), t.begin(), t.end());
    surface.face_source.push_back(0);
  });
  connect(surface, progress);
  return find_crease_edges(surface, angle_deg, progress);
}

}  // namespace knead::remesh_detail

namespace knead {

std::vector<MeshEdge> find_creases(const Mesh& mesh, double angle_deg) {
  validate(mesh);
  return remesh_detail::find_creases_unless_cancelled(mesh, angle_deg, nullptr);
}

}  // namespace knead
