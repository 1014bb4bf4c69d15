// Measures of meshes: boxes, counts of elements, volume and area, and triangles that a deformation turned over.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "math/elementary.h"
#include "mesh/edges.h"

namespace knead {
namespace {

constexpr double kStrayExtents = 10;         // points farther away, in extents of the others, lie astray
constexpr std::size_t kPointsPerStray = 20;  // at most one of so many points may lie astray on each side

// Keeps the `count` least values in a heap whose first value is the greatest.
void keep_least(std::vector<double>& heap, double value, std::size_t count) {
  if (heap.size() == count) {
    if (!(value < heap.front())) return;
    std::pop_heap(heap.begin(), heap.end());
    heap.pop_back();
  }
  heap.push_back(value);
  std::push_heap(heap.begin(), heap.end());
}

std::vector<std::uint8_t> used_vertices(const Mesh& mesh) {
  std::vector<std::uint8_t> used(mesh.vertex_count());  // bytes, since bits cost more to set
  for (const std::uint32_t v : mesh.corner_vertex) used[v] = 1;
  return used;
}

// The sides of a triangle and twice its area.
struct TriangleSides {
  Vec3d ab, bc, ca;
  double area = 0;

  TriangleSides(const Vec3d& a, const Vec3d& b, const Vec3d& c)
      : ab(b - a), bc(c - b), ca(a - c), area(norm(cross(ab, ca))) {}

  bool is_degenerate() const { return !(area > 1e-12 * std::max({norm2(ab), norm2(bc), norm2(ca)})); }

  // The tangent of the smallest angle is the area divided by this. That angle is at most 60 degrees and lies between
  // the two longest sides, whose dot product is the largest of the three.
  double largest_product() const { return std::max({-dot(ca, ab), -dot(ab, bc), -dot(bc, ca)}); }
};

void count_triangles(const Mesh& mesh, Measures& m) {
  m.triangles = 0;
  m.degenerate_triangles = 0;
  m.smallest_angle_deg.reset();
  double tangent = kInfinity;
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) {
    ++m.triangles;
    const TriangleSides sides(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    if (sides.is_degenerate()) {
      ++m.degenerate_triangles;
    } else {
      tangent = std::min(tangent, sides.area / sides.largest_product());
    }
  });
  if (m.degenerate_triangles < m.triangles) m.smallest_angle_deg = elementary::atan(tangent) * 180 / std::numbers::pi;
}

// An end of a boundary edge. The edge is named by the corner at which its face begins it, the fan by its first corner.
struct BoundaryEnd {
  std::uint32_t edge = 0;
  std::uint32_t fan = 0;
};

// The counts at the vertices of one part of the mesh.
struct StarCounts {
  std::size_t unused_vertices = 0;
  std::size_t nonmanifold_vertices = 0;
  std::size_t edges = 0;
  std::size_t boundary_edges = 0;
  std::size_t nonmanifold_edges = 0;
  std::size_t misoriented_edges = 0;
  std::vector<BoundaryEnd> boundary;
};

// Counts the edges and fans at vertices. A fan continues across edges that have two faces.
class StarCounter {
 public:
  explicit StarCounter(StarCounts& counts) : counts_(counts) {}

  void add(std::uint32_t vertex, std::span<const StarCorner> star) {
    if (add_closed_fan(vertex, star)) return;
    counts_.unused_vertices += star.empty() ? 1 : 0;
    read_uses(vertex, star);
    fans_.reset(star.size());
    alone_.clear();
    std::size_t next = 0;
    for (std::size_t begin = 0; begin < uses_.size(); begin = next) {
      while (next < uses_.size() && uses_[next].other == uses_[begin].other) ++next;
      const std::span<const Use> edge(uses_.data() + begin, next - begin);
      if (vertex < edge[0].other) count_edge(edge);
      if (edge.size() == 2) fans_.join(edge[0].place, edge[1].place);
      if (edge.size() == 1) alone_.push_back(edge[0]);
    }
    std::size_t fans = 0;
    for (std::uint32_t i = 0; i < star.size(); ++i) fans += fans_.find(i) == i ? 1 : 0;
    counts_.nonmanifold_vertices += fans > 1 ? 1 : 0;
    for (const Use& use : alone_) {
      const std::uint32_t edge = use.leaves ? star[use.place].corner : star[use.place].previous;
      counts_.boundary.push_back({edge, star[fans_.find(use.place)].corner});
    }
  }

 private:
  // Counts the edges of an ordinary vertex: all its faces form one fan, and each edge has one face on either side.
  // Returns false for any other vertex, and counts nothing. Most vertices are ordinary.
  bool add_closed_fan(std::uint32_t vertex, std::span<const StarCorner> star) {
    std::size_t edges = 0;
    std::size_t at = 0;
    for (std::size_t step = 1; step <= star.size(); ++step) {
      const std::uint32_t other = star[at].next_vertex;
      for (at = 0; at < star.size() && star[at].previous_vertex != other;) ++at;
      const bool is_round = at == 0;  // after exactly star.size() steps, each face has been met once
      if (at == star.size() || other == vertex || is_round != (step == star.size())) return false;
      edges += vertex < other ? 1 : 0;
    }
    counts_.edges += edges;
    return !star.empty();
  }

  // The use of an edge by a face at the vertex.
  struct Use {
    std::uint32_t other = 0;  // the other vertex
    std::uint32_t place = 0;  // in the star
    bool leaves = false;      // the face runs from the vertex to the other
  };

  void read_uses(std::uint32_t vertex, std::span<const StarCorner> star) {
    uses_.clear();
    for (std::uint32_t i = 0; i < star.size(); ++i) {
      if (star[i].next_vertex != vertex) uses_.push_back({star[i].next_vertex, i, true});
      if (star[i].previous_vertex != vertex) uses_.push_back({star[i].previous_vertex, i, false});
    }
    std::sort(uses_.begin(), uses_.end(), [](const Use& a, const Use& b) { return a.other < b.other; });
  }

  void count_edge(std::span<const Use> edge) {
    ++counts_.edges;
    if (edge.size() == 1) ++counts_.boundary_edges;
    const std::ptrdiff_t leaving = std::count_if(edge.begin(), edge.end(), [](const Use& use) { return use.leaves; });
    if (std::abs(2 * leaving - std::ssize(edge)) > 1) ++counts_.misoriented_edges;
    if (edge.size() > 2) ++counts_.nonmanifold_edges;
  }

  StarCounts& counts_;
  std::vector<Use> uses_;
  std::vector<Use> alone_;  // of boundary edges
  DisjointSets fans_;       // of the corners of the star
};

// Counts boundary loops: boundary edges that meet in one fan belong to the same loop. `ends`: two for each edge.
std::size_t count_boundary_loops(std::vector<BoundaryEnd> ends) {
  std::sort(ends.begin(), ends.end(), [](const BoundaryEnd& a, const BoundaryEnd& b) { return a.edge < b.edge; });
  std::vector<std::uint32_t> fans;
  fans.reserve(ends.size());
  for (const BoundaryEnd& end : ends) fans.push_back(end.fan);
  std::sort(fans.begin(), fans.end());
  fans.erase(std::unique(fans.begin(), fans.end()), fans.end());
  const auto place = [&](std::uint32_t fan) {
    return static_cast<std::uint32_t>(std::lower_bound(fans.begin(), fans.end(), fan) - fans.begin());
  };
  DisjointSets loops(fans.size());
  for (std::size_t i = 0; i < ends.size(); i += 2) loops.join(place(ends[i].fan), place(ends[i + 1].fan));
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < fans.size(); ++i) count += loops.find(i) == i ? 1 : 0;
  return count;
}

// Adds the counts of edges, vertices and boundary loops.
void count_stars(const Mesh& mesh, int threads, Measures& m) {
  const CornerParts parts(mesh, threads);
  std::vector<StarCounts> counts(parts.count());
  parallel_for(parts.count(), 1, threads, [&](std::size_t part, std::size_t) {
    StarCounter counter(counts[part]);
    parts.visit_stars(part, [&](std::uint32_t vertex, std::span<const StarCorner> star) { counter.add(vertex, star); });
  });
  std::vector<BoundaryEnd> boundary;
  for (const StarCounts& of_part : counts) {
    m.unused_vertices += of_part.unused_vertices;
    m.nonmanifold_vertices += of_part.nonmanifold_vertices;
    m.edges += of_part.edges;
    m.boundary_edges += of_part.boundary_edges;
    m.nonmanifold_edges += of_part.nonmanifold_edges;
    m.misoriented_edges += of_part.misoriented_edges;
    boundary.insert(boundary.end(), of_part.boundary.begin(), of_part.boundary.end());
  }
  m.boundary_loops = count_boundary_loops(std::move(boundary));
}

std::size_t count_components(const Mesh& mesh, std::size_t unused_vertices) {
  DisjointSets sets(mesh.vertex_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    for (std::size_t i = 1; i < face.size(); ++i) sets.join(face[0], face[i]);
  }
  std::size_t roots = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) roots += sets.find(v) == v ? 1 : 0;
  return roots - unused_vertices;  // each unused vertex is a set of its own
}

VolumeAndArea volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions, const Box& box) {
  const Vec3d origin = box.empty() ? Vec3d{} : box.center();
  double volume6 = 0;
  double area2 = 0;
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) {
    const Vec3d a = positions[t[0]] - origin;
    const Vec3d b = positions[t[1]] - origin;
    const Vec3d c = positions[t[2]] - origin;
    volume6 += dot(a, cross(b, c));
    area2 += norm(cross(b - a, c - a));
  });
  return {volume6 / 6, area2 / 2};
}

// Adds the box, the volume and the area.
void add_sizes(const Mesh& mesh, Measures& m) {
  m.box = m.unused_vertices > 0 ? shape_box(mesh) : bounding_box(mesh.positions);
  const VolumeAndArea sums = volume_and_area(mesh, mesh.positions, m.box);
  m.volume = sums.volume;
  m.area = sums.area;
}

// Returns the triangles that oppose the normals of their vertices.
std::vector<Triangle> opposing(const Mesh& mesh, std::span<const Triangle> triangles,
                               std::span<const Vec3d> positions) {
  std::vector<Triangle> result;
  if (triangles.empty()) return result;
  std::vector<std::uint32_t> vertices;
  for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const std::vector<Vec3d> normals = normals_of(mesh, positions, vertices);
  const auto normal_of = [&](std::uint32_t v) {
    return normals[static_cast<std::size_t>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin())];
  };
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(result), [&](const Triangle& t) {
    const Vec3d& a = positions[t[0]];
    const Vec3d sum = normal_of(t[0]) + normal_of(t[1]) + normal_of(t[2]);
    return dot(cross(positions[t[1]] - a, positions[t[2]] - a), sum) < 0;
  });
  return result;
}

// Finds the tame vertices: all normals of faces and triangles around one are within 45 degrees of the first one, less a
// margin far above rounding errors. A triangle with three tame vertices cannot oppose their normals: these are sums of
// face normals, each within 90 degrees of its own. Most vertices of most shapes are tame, which saves the cost of their
// normals.
class TameVertices {
 public:
  explicit TameVertices(std::size_t count) : first_(count), tame_(count, 1) {}

  void add(const Vec3d& normal, std::span<const std::uint32_t> vertices) {
    const double size2 = norm2(normal);
    const bool sound = size2 > 1e-140;  // the area is not 0, and squares do not underflow
    for (const std::uint32_t v : vertices) {
      if (sound && first_[v] == Vec3f{}) first_[v] = Vec3f(normal / std::sqrt(size2));
      const double along = dot(Vec3d(first_[v]), normal);
      if (!(sound && along > 0 && along * along > 0.51 * size2)) tame_[v] = 0;
    }
  }

  bool are_all(const Triangle& t) const { return tame_[t[0]] + tame_[t[1]] + tame_[t[2]] == 3; }

 private:
  std::vector<Vec3f> first_;  // unit normals
  std::vector<unsigned char> tame_;
};

// Returns the flags with those of all other vertices of the same faces set, too.
std::vector<std::uint8_t> with_neighbours(const Mesh& mesh, const std::vector<std::uint8_t>& flags) {
  std::vector<std::uint8_t> result = flags;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    if (std::none_of(face.begin(), face.end(), [&](std::uint32_t v) { return flags[v] != 0; })) continue;
    for (const std::uint32_t v : face) result[v] = 1;
  }
  return result;
}

// Looks at the faces of the vertices with a flag.
TameVertices find_tame(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after,
                       const std::vector<std::uint8_t>& flags) {
  TameVertices tame(mesh.vertex_count());
  std::vector<Triangle> parts;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::span<const std::uint32_t> face = mesh.face(f);
    if (std::none_of(face.begin(), face.end(), [&](std::uint32_t v) { return flags[v] != 0; })) continue;
    tame.add(polygon_normal(after, face), face);
    if (face.size() <= 3) continue;
    parts.clear();
    triangulate_polygon(before, face, parts);
    for (const Triangle& t : parts) tame.add(polygon_normal(after, t), t);
  }
  return tame;
}

// Returns the triangles that may oppose the normals of their vertices after, but not before. A triangle none of whose
// neighbours changed cannot.
std::vector<Triangle> suspects(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  std::vector<std::uint8_t> changed(mesh.vertex_count());
  for (std::size_t v = 0; v < changed.size(); ++v) changed[v] = before[v] == after[v] ? 0 : 1;
  changed = with_neighbours(mesh, changed);
  const TameVertices tame = find_tame(mesh, before, after, with_neighbours(mesh, changed));
  std::vector<Triangle> result;
  for_each_triangle(mesh, before, [&](const Triangle& t) {
    if (changed[t[0]] + changed[t[1]] + changed[t[2]] > 0 && !tame.are_all(t)) result.push_back(t);
  });
  return result;
}

Mesh triangles_of(const Mesh& mesh) {
  Mesh result;
  result.positions = mesh.positions;
  for (const Triangle& t : triangulate(mesh)) result.add_face(t);
  return result;
}

// Returns a normal, not of unit length; zero for a triangle without area.
Vec3d triangle_normal(const Mesh& mesh, std::uint32_t triangle) {
  const std::span<const std::uint32_t> t = mesh.face(triangle);
  const Vec3d& a = mesh.positions[t[0]];
  const Vec3d& b = mesh.positions[t[1]];
  const Vec3d& c = mesh.positions[t[2]];
  return is_degenerate(a, b, c) ? Vec3d{} : cross(b - a, c - a);
}

}  // namespace

void CloudBox::add(std::span<const Vec3d> points) {
  points_ += points.size();
  const auto is_full = [](const std::vector<double>& end) { return end.size() == kMaxStrays + 1; };
  Box inner;  // most points are within it and change nothing
  for (const Vec3d& p : points) {
    if (contains(inner, p)) continue;
    whole_.extend(p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      keep_least(ends_[2 * axis], p[axis], kMaxStrays + 1);
      keep_least(ends_[2 * axis + 1], -p[axis], kMaxStrays + 1);
    }
    if (!std::all_of(ends_.begin(), ends_.end(), is_full)) continue;
    inner.min = {ends_[0].front(), ends_[2].front(), ends_[4].front()};
    inner.max = {-ends_[1].front(), -ends_[3].front(), -ends_[5].front()};
  }
}

Box CloudBox::box() const {
  const std::size_t strays = std::min(kMaxStrays, points_ / kPointsPerStray);
  if (strays == 0) return whole_;
  std::array<std::vector<double>, 6> ends = ends_;
  double extent = 0;  // of the points without `strays` of them at each end
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side : {0, 1}) std::sort(ends[2 * axis + side].begin(), ends[2 * axis + side].end());
    extent = std::max(extent, -ends[2 * axis + 1][strays] - ends[2 * axis][strays]);
  }
  if (!(extent > 0)) return whole_;
  // The end of a side is the outermost value near the one that lies `strays` places inside.
  const auto end_of = [&](const std::vector<double>& values) {
    return *std::lower_bound(values.begin(), values.end(), values[strays] - kStrayExtents * extent);
  };
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = end_of(ends[2 * axis]);
    box.max[axis] = -end_of(ends[2 * axis + 1]);
  }
  return box;
}

Box shape_box(const Mesh& mesh) { return shape_box(mesh, mesh.positions); }

Box shape_box(const Mesh& mesh, std::span<const Vec3d> positions) {
  if (mesh.face_count() == 0) {
    CloudBox cloud;
    cloud.add(positions);
    return cloud.box();
  }
  const std::vector<std::uint8_t> used = used_vertices(mesh);
  Box box;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (used[v] != 0) box.extend(positions[v]);
  }
  return box;
}

std::string stray_note(const Mesh& mesh) {
  Box box = shape_box(mesh);
  const double margin = box.diagonal();
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  std::size_t count = 0;
  std::size_t first = 0;
  for (std::size_t v = mesh.vertex_count(); v > 0; --v) {
    if (contains(box, mesh.positions[v - 1])) continue;
    ++count;
    first = v - 1;
  }
  if (count == 0) return {};
  const Vec3d& p = mesh.positions[first];
  const std::string place = fmt::format("vertex {} at {:.6g} {:.6g} {:.6g}", first, p.x, p.y, p.z);
  const std::string which = count == 1 ? place : fmt::format("{} vertices ({} is the first)", count, place);
  const char* why = mesh.face_count() > 0 ? "far from the shape, in no face" : "far from all others";
  const char* lie = count == 1 ? "lies" : "lie";
  return fmt::format("{} {} {}; the box, and lengths that are relative to it, leave out such vertices", which, lie,
                     why);
}

bool is_degenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return TriangleSides(a, b, c).is_degenerate(); }

Measures measure(const Mesh& mesh, int threads) {
  validate(mesh);
  Measures m;
  m.vertices = mesh.vertex_count();
  m.faces = mesh.face_count();
  count_stars(mesh, threads, m);
  const std::array<std::function<void()>, 3> rest{[&] { m.components = count_components(mesh, m.unused_vertices); },
                                                  [&] { count_triangles(mesh, m); }, [&] { add_sizes(mesh, m); }};
  parallel_for(rest.size(), 1, threads, [&](std::size_t i, std::size_t) { rest[i](); });
  m.euler = static_cast<std::int64_t>(m.vertices - m.unused_vertices) - static_cast<std::int64_t>(m.edges) +
            static_cast<std::int64_t>(m.faces);
  return m;
}

Measures measure(const Mesh& mesh, const Measures& same_faces, int threads) {
  require_sound(mesh, mesh.positions);
  Measures m = same_faces;
  const std::array<std::function<void()>, 2> rest{[&] { count_triangles(mesh, m); }, [&] { add_sizes(mesh, m); }};
  parallel_for(rest.size(), 1, threads, [&](std::size_t i, std::size_t) { rest[i](); });
  return m;
}

VolumeAndArea measure_volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions) {
  require_sound(mesh, positions);
  return volume_and_area(mesh, positions, shape_box(mesh, positions));
}

std::optional<double> volume_change(const VolumeAndArea& before, double after) {
  constexpr double kRoundingError = 1e-12;  // relative to area^1.5, a few times the volume of a ball with this area
  if (!(std::abs(before.volume) > kRoundingError * before.area * std::sqrt(before.area))) return std::nullopt;
  return after / before.volume - 1;
}

std::vector<std::string> describe_defects(const Measures& m) {
  std::vector<std::string> list;
  const auto say = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) list.push_back(fmt::format("{} {}", count, count == 1 ? one : many));
  };
  if (m.faces > 0) say(m.unused_vertices, "vertex is in no face", "vertices are in no face");
  say(m.boundary_edges, "edge has only one face (the mesh is open)", "edges have only one face (the mesh is open)");
  say(m.nonmanifold_edges, "edge has more than two faces", "edges have more than two faces");
  say(m.nonmanifold_vertices, "vertex joins several fans of faces", "vertices join several fans of faces");
  say(m.misoriented_edges, "edge has faces that disagree which side is outside",
      "edges have faces that disagree which side is outside");
  say(m.degenerate_triangles, "triangle has no area", "triangles have no area");
  return list;
}

std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after) {
  require_faces(mesh, before);
  if (after.size() != before.size()) require_faces(mesh, after);  // throws
  const std::vector<Triangle> candidates = opposing(mesh, suspects(mesh, before, after), after);
  return candidates.size() - opposing(mesh, candidates, before).size();
}

std::size_t count_folded_edges(const Mesh& mesh) {
  const double cosine = elementary::cos(170 * std::numbers::pi / 180);
  const Mesh triangles = triangles_of(mesh);
  std::size_t folded = 0;
  for_each_edge(triangles, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2 || edge[0].upward == edge[1].upward) return;
    const Vec3d n = triangle_normal(triangles, edge[0].corner / 3);
    const Vec3d m = triangle_normal(triangles, edge[1].corner / 3);
    if (dot(n, m) < cosine * norm(n) * norm(m)) ++folded;
  });
  return folded;
}

}  // namespace knead
