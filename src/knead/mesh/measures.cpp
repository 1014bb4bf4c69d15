#include "knead/mesh/measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/math/elementary.h"
#include "knead/mesh/check.h"
#include "knead/mesh/edges.h"
#include "knead/mesh/triangulate.h"

namespace knead {
namespace {

// Returns the tangent of the smallest angle of a triangle. That angle is at most 60 degrees and lies between the two
// longest edges, whose dot product is the largest of the three.
double smallest_tangent(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a;
  const Vec3d bc = c - b;
  const Vec3d ca = a - c;
  return norm(cross(ab, ca)) / std::max({-dot(ca, ab), -dot(ab, bc), -dot(bc, ca)});
}

void count_triangles(const Mesh& mesh, Measures& m) {
  m.triangles = 0;
  m.degenerate_triangles = 0;
  m.smallest_angle_deg.reset();
  double tangent = Box::kInfinity;
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) {
    ++m.triangles;
    const Vec3d& a = mesh.positions[t[0]];
    const Vec3d& b = mesh.positions[t[1]];
    const Vec3d& c = mesh.positions[t[2]];
    if (is_degenerate(a, b, c)) {
      ++m.degenerate_triangles;
    } else {
      tangent = std::min(tangent, smallest_tangent(a, b, c));
    }
  });
  if (m.degenerate_triangles < m.triangles) m.smallest_angle_deg = elementary::atan(tangent) * 180 / std::numbers::pi;
}

// Puts the corners at a vertex that belong to one fan into one set. A fan continues across edges that have two faces.
void join_fans(std::span<const EdgeUse> edge, DisjointSets& fans) {
  const auto corner_at_low = [](const EdgeUse& use) { return use.upward ? use.corner : use.next_corner; };
  const auto corner_at_high = [](const EdgeUse& use) { return use.upward ? use.next_corner : use.corner; };
  if (edge.size() != 2) return;
  fans.join(corner_at_low(edge[0]), corner_at_low(edge[1]));
  fans.join(corner_at_high(edge[0]), corner_at_high(edge[1]));
}

// Counts boundary loops: boundary edges that meet in one fan belong to the same loop.
std::size_t count_boundary_loops(std::span<const EdgeUse> boundary, DisjointSets& fans) {
  std::vector<std::uint32_t> ends;  // the fans that boundary edges meet
  for (const EdgeUse& edge : boundary) {
    ends.push_back(fans.find(edge.corner));
    ends.push_back(fans.find(edge.next_corner));
  }
  std::vector<std::uint32_t> sorted = ends;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  const auto place = [&](std::uint32_t fan) {
    return static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), fan) - sorted.begin());
  };
  DisjointSets loops(sorted.size());
  for (std::size_t i = 0; i < ends.size(); i += 2) loops.join(place(ends[i]), place(ends[i + 1]));
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < sorted.size(); ++i) count += loops.find(i) == i ? 1 : 0;
  return count;
}

void count_edge(std::span<const EdgeUse> edge, Measures& m) {
  ++m.edges;
  if (edge.size() == 1) ++m.boundary_edges;
  const std::ptrdiff_t upward = std::count_if(edge.begin(), edge.end(), [](const EdgeUse& use) { return use.upward; });
  if (std::abs(2 * upward - std::ssize(edge)) > 1) ++m.misoriented_edges;
  if (edge.size() > 2) ++m.nonmanifold_edges;
}

void count_vertices(const Mesh& mesh, DisjointSets& fans, Measures& m) {
  constexpr std::uint32_t none = 0xffffffffu;
  std::vector<std::uint32_t> first_fan(mesh.vertex_count(), none);
  std::vector<bool> nonmanifold(mesh.vertex_count(), false);
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    const std::uint32_t v = mesh.corner_vertex[c];
    const std::uint32_t fan = fans.find(static_cast<std::uint32_t>(c));
    if (first_fan[v] == none) first_fan[v] = fan;
    if (first_fan[v] != fan) nonmanifold[v] = true;
  }
  m.unused_vertices = static_cast<std::size_t>(std::count(first_fan.begin(), first_fan.end(), none));
  m.nonmanifold_vertices = static_cast<std::size_t>(std::count(nonmanifold.begin(), nonmanifold.end(), true));
}

std::size_t count_components(const Mesh& mesh, std::size_t unused_vertices) {
  DisjointSets sets(mesh.vertex_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (const std::uint32_t v : mesh.face(f)) sets.join(mesh.face(f)[0], v);
  }
  std::size_t roots = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) roots += sets.find(v) == v ? 1 : 0;
  return roots - unused_vertices;  // each unused vertex is a set of its own
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

VolumeAndArea volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions) {
  const Box box = shape_box(mesh, positions);
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

// Adds what depends on the positions to the measures of the faces.
Measures with_sizes(const Mesh& mesh, Measures m) {
  m.box = shape_box(mesh);
  count_triangles(mesh, m);
  const VolumeAndArea sums = volume_and_area(mesh, mesh.positions);
  m.volume = sums.volume;
  m.area = sums.area;
  return m;
}

}  // namespace

bool is_degenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double longest2 = std::max({norm2(b - a), norm2(c - b), norm2(a - c)});
  return !(norm(cross(b - a, c - a)) > 1e-12 * longest2);
}

Measures measure(const Mesh& mesh) {
  validate(mesh);
  Measures m;
  m.vertices = mesh.vertex_count();
  m.faces = mesh.face_count();
  DisjointSets fans(mesh.corner_vertex.size());
  std::vector<EdgeUse> boundary;
  for_each_edge(mesh, [&](std::span<const EdgeUse> edge) {
    count_edge(edge, m);
    join_fans(edge, fans);
    if (edge.size() == 1) boundary.push_back(edge[0]);
  });
  count_vertices(mesh, fans, m);
  m.boundary_loops = count_boundary_loops(boundary, fans);
  m.components = count_components(mesh, m.unused_vertices);
  m.euler = static_cast<std::int64_t>(m.vertices - m.unused_vertices) - static_cast<std::int64_t>(m.edges) +
            static_cast<std::int64_t>(m.faces);
  return with_sizes(mesh, m);
}

Measures measure(const Mesh& mesh, const Measures& same_faces) {
  require_sound(mesh, mesh.positions);
  return with_sizes(mesh, same_faces);
}

VolumeAndArea measure_volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions) {
  require_sound(mesh, positions);
  return volume_and_area(mesh, positions);
}

std::vector<std::string> describe_oddities(const Measures& m) {
  std::vector<std::string> list;
  const auto say = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) list.push_back(counted(count, one, many));
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

}  // namespace knead
