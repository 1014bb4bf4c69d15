#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/edges.h"

namespace knead {

namespace {

void check_faces(const Mesh& mesh) {
  const auto& begin = mesh.face_begin;
  if (begin.empty() || begin.front() != 0) throw InvalidInput("a mesh's \"face_begin\" must begin with 0");
  for (std::size_t f = 0; f + 1 < begin.size(); ++f) {
    if (begin[f] > begin[f + 1]) {
      throw InvalidInput(fmt::format("face {} of a mesh begins after it ends; let \"face_begin\" never decrease", f));
    }
  }
  if (begin.back() != mesh.corner_vertex.size()) {
    throw InvalidInput(
        fmt::format("the last face of a mesh ends at corner {} of {}; let \"face_begin\" end with their "
                    "number",
                    begin.back(), mesh.corner_vertex.size()));
  }
  std::uint32_t largest = 0;
  for (const std::uint32_t v : mesh.corner_vertex) largest = std::max(largest, v);
  if (mesh.corner_vertex.empty() || largest < mesh.positions.size()) return;
  for (std::size_t c = 0; c < mesh.corner_vertex.size(); ++c) {
    if (mesh.corner_vertex[c] < mesh.positions.size()) continue;
    throw InvalidInput(fmt::format("corner {} of a mesh names vertex {}, but there are only {} vertices; correct it", c,
                                   mesh.corner_vertex[c], mesh.positions.size()));
  }
}

void check_places(std::span<const Vec3d> positions) {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (is_finite(positions[v])) continue;
    throw InvalidInput(fmt::format("vertex {} of a mesh has a coordinate that is not finite; place or remove it", v));
  }
}

}  // namespace

void require_faces(const Mesh& mesh, std::span<const Vec3d> positions) {
  check_faces(mesh);
  if (positions.size() != mesh.vertex_count()) {
    throw InvalidInput(fmt::format("{} positions for a mesh of {} vertices; give one for each", positions.size(),
                                   mesh.vertex_count()));
  }
}

void require_sound(const Mesh& mesh, std::span<const Vec3d> positions) {
  require_faces(mesh, positions);
  check_places(positions);
}

void validate(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  for (const Attribute& attribute : mesh.attributes) {
    const std::size_t count = mesh.element_count(attribute.domain);
    if (attribute.components > 0 && attribute.values.size() == count * static_cast<std::size_t>(attribute.components)) {
      continue;
    }
    throw InvalidInput(fmt::format("the attribute \"{}\" of a mesh has {} numbers for {} elements of {} components",
                                   attribute.name, attribute.values.size(), count, attribute.components));
  }
}

namespace {

struct Point2 {
  double x = 0;
  double y = 0;
  friend bool operator==(const Point2&, const Point2&) = default;
};

// Returns twice the signed area of the triangle a b c.
double orient(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The polygon projected along the largest component of its normal, counter-clockwise.
std::vector<Point2> flatten(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon) {
  const Vec3d n = polygon_normal(positions, polygon);
  const Vec3d size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  const std::size_t u = n[axis] >= 0 ? (axis + 1) % 3 : (axis + 2) % 3;
  const std::size_t v = n[axis] >= 0 ? (axis + 2) % 3 : (axis + 1) % 3;
  std::vector<Point2> points;
  points.reserve(polygon.size());
  for (const std::uint32_t vertex : polygon) points.push_back({positions[vertex][u], positions[vertex][v]});
  return points;
}

bool is_convex(const std::vector<Point2>& points) {
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (orient(points[(i + n - 1) % n], points[i], points[(i + 1) % n]) < 0) return false;
  }
  return true;
}

void add_fan(std::span<const std::uint32_t> polygon, std::vector<Triangle>& triangles) {
  for (std::size_t i = 2; i < polygon.size(); ++i) triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
}

// Ear clipping: repeatedly cuts off a corner whose triangle contains no other corner. The remaining corners form a
// ring.
class EarClipper {
 public:
  EarClipper(std::vector<Point2> points, std::span<const std::uint32_t> polygon)
      : points_(std::move(points)), polygon_(polygon), next_(points_.size()), previous_(points_.size()) {
    const std::size_t n = points_.size();
    for (std::size_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
  }

  void clip(std::vector<Triangle>& triangles) {
    std::size_t left = points_.size();
    std::size_t corner = 1;
    std::size_t refused = 0;  // consecutive corners that are not ears
    while (left > 3) {
      if (refused < left && tests_ < kMaxTests && !is_ear(corner)) {
        ++refused;
        corner = next_[corner];
        continue;
      }
      cut(corner, triangles);
      corner = next_[corner];
      --left;
      refused = 0;
    }
    cut(corner, triangles);
  }

 private:
  static constexpr std::size_t kMaxTests = 10'000'000;

  // Returns true for a convex corner whose triangle contains no other corner. Corners at the position of one of its own
  // are ignored: they come from polygons with a bridge to a hole.
  bool is_ear(std::size_t corner) {
    const Point2& a = points_[previous_[corner]];
    const Point2& b = points_[corner];
    const Point2& c = points_[next_[corner]];
    if (orient(a, b, c) <= 0) return false;
    for (std::size_t i = next_[next_[corner]]; i != previous_[corner]; i = next_[i]) {
      ++tests_;
      const Point2& p = points_[i];
      if (p == a || p == b || p == c) continue;
      if (orient(a, b, p) >= 0 && orient(b, c, p) >= 0 && orient(c, a, p) >= 0) return false;
    }
    return true;
  }

  void cut(std::size_t corner, std::vector<Triangle>& triangles) {
    triangles.push_back({polygon_[previous_[corner]], polygon_[corner], polygon_[next_[corner]]});
    next_[previous_[corner]] = next_[corner];
    previous_[next_[corner]] = previous_[corner];
  }

  std::vector<Point2> points_;
  std::span<const std::uint32_t> polygon_;
  std::vector<std::size_t> next_;
  std::vector<std::size_t> previous_;
  std::size_t tests_ = 0;
};

}  // namespace

Vec3d polygon_normal(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon) {
  Vec3d sum;
  if (polygon.size() < 3) return sum;
  const Vec3d& origin = positions[polygon[0]];
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    sum += cross(positions[polygon[i - 1]] - origin, positions[polygon[i]] - origin);
  }
  return sum;
}

void triangulate_polygon(std::span<const Vec3d> positions, std::span<const std::uint32_t> polygon,
                         std::vector<Triangle>& triangles) {
  if (polygon.size() == 3) return add_fan(polygon, triangles);
  std::vector<Point2> points = flatten(positions, polygon);
  if (is_convex(points)) return add_fan(polygon, triangles);
  EarClipper(std::move(points), polygon).clip(triangles);
}

std::vector<Triangle> triangulate(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.corner_vertex.size());
  for_each_triangle(mesh, mesh.positions, [&](const Triangle& t) { triangles.push_back(t); });
  return triangles;
}

std::vector<std::uint32_t> triangle_faces(const Mesh& mesh) {
  require_sound(mesh, mesh.positions);
  std::vector<std::uint32_t> faces;
  faces.reserve(mesh.corner_vertex.size());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t i = 2; i < mesh.face(f).size(); ++i) faces.push_back(static_cast<std::uint32_t>(f));
  }
  return faces;
}

void check_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) {
      if (v >= positions.size()) {
        throw InvalidInput("triangle " + std::to_string(t) + " uses vertex " + std::to_string(v) + "; there are " +
                           std::to_string(positions.size()) + ", numbered from 0");
      }
      if (!is_finite(positions[v])) {
        throw InvalidInput("triangle " + std::to_string(t) + " uses vertex " + std::to_string(v) +
                           ", which has a coordinate that is not finite; place or remove it");
      }
    }
  }
}

namespace {

// Calls visit(use) for every use of an edge, in the order of corners.
template <class Visit>
void for_each_use(const Mesh& mesh, Visit visit) {
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::uint32_t begin = mesh.face_begin[f];
    const std::uint32_t end = mesh.face_begin[f + 1];
    for (std::uint32_t corner = begin; corner < end; ++corner) {
      const std::uint32_t next = corner + 1 < end ? corner + 1 : begin;
      const std::uint32_t a = mesh.corner_vertex[corner];
      const std::uint32_t b = mesh.corner_vertex[next];
      if (a != b) visit(EdgeUse{std::min(a, b), std::max(a, b), corner, next, a < b});
    }
  }
}

// A use of an edge at a given smaller vertex: twice the larger vertex, plus 1 if the face runs from small to large.
using HalfUse = std::uint64_t;

// Uses that are sorted together at least; of large meshes an eighth.
constexpr std::size_t kMaxHalfUses = std::size_t{1} << 24;  // 134 MB
constexpr std::size_t kMaxEdgeUses = 1'000'000;

// Calls visit(uses, ends) for parts of the vertices, as long as it returns true: make(use) for each use at each of them
// as the smaller vertex, in the order of vertices, then of corners; and where the uses of each vertex end.
template <class Use, class Make, class Visit>
void visit_parts(const Mesh& mesh, std::size_t least, const Make& make, const Visit& visit) {
  std::vector<std::uint32_t> end(mesh.vertex_count(), 0);  // of the uses at each smaller vertex
  for_each_use(mesh, [&](const EdgeUse& use) { ++end[use.low]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  const std::size_t all = end.empty() ? 0 : end.back();
  const std::size_t most = std::max(all / 8, least);
  std::vector<Use> uses;
  for (std::size_t first = 0, done = 0; done < all;) {
    // The vertices from `first` on whose uses fit into a part, at least one.
    const auto after = std::upper_bound(end.begin() + static_cast<std::ptrdiff_t>(first) + 1, end.end(), done + most);
    const auto last = static_cast<std::size_t>(after - end.begin());  // not among them
    std::vector<std::uint32_t> cursor(last - first);
    for (std::size_t v = first; v < last; ++v) {
      cursor[v - first] = static_cast<std::uint32_t>((v == 0 ? 0 : end[v - 1]) - done);
    }
    uses.resize(end[last - 1] - done);
    for_each_use(mesh, [&](const EdgeUse& use) {
      if (first <= use.low && use.low < last) uses[cursor[use.low - first]++] = make(use);
    });
    if (!visit(std::span<Use>(uses), std::span<const std::uint32_t>(cursor))) return;
    done = end[last - 1];
    first = last;
  }
}

// Returns true if each edge is used more than once, and its uses in the two directions differ by at most one.
bool all_balanced(std::span<HalfUse> uses) {
  std::sort(uses.begin(), uses.end());
  for (std::size_t begin = 0; begin < uses.size();) {
    std::ptrdiff_t upward = 0;
    std::size_t end = begin;
    for (; end < uses.size() && uses[end] / 2 == uses[begin] / 2; ++end) upward += uses[end] % 2 == 1 ? 1 : -1;
    if (end - begin == 1 || std::abs(upward) > 1) return false;
    begin = end;
  }
  return true;
}

// Sorts the uses at each smaller vertex, which are together, by edge, then by corner; visits each edge.
void visit_edges(std::span<EdgeUse> uses, const std::function<void(std::span<const EdgeUse>)>& visit) {
  const auto earlier = [](const EdgeUse& a, const EdgeUse& b) {
    return a.high != b.high ? a.high < b.high : a.corner < b.corner;
  };
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin;
    while (end < uses.size() && uses[end].low == uses[begin].low) ++end;
    std::sort(uses.begin() + static_cast<std::ptrdiff_t>(begin), uses.begin() + static_cast<std::ptrdiff_t>(end),
              earlier);
    while (begin < end) {
      std::size_t next = begin + 1;
      while (next < end && uses[next].high == uses[begin].high) ++next;
      visit(uses.subspan(begin, next - begin));
      begin = next;
    }
  }
}

}  // namespace

bool is_closed_and_oriented(const Mesh& mesh) {
  bool balanced = true;
  const auto half_use = [](const EdgeUse& use) { return HalfUse{use.high} * 2 + (use.upward ? 1 : 0); };
  visit_parts<HalfUse>(mesh, kMaxHalfUses, half_use, [&](std::span<HalfUse> uses, std::span<const std::uint32_t> ends) {
    std::size_t begin = 0;
    for (const std::uint32_t end : ends) {
      balanced = balanced && all_balanced(uses.subspan(begin, end - begin));
      begin = end;
    }
    return balanced;
  });
  return balanced && mesh.face_count() > 0;
}

void for_each_edge(const Mesh& mesh, const std::function<void(std::span<const EdgeUse>)>& visit) {
  visit_parts<EdgeUse>(
      mesh, kMaxEdgeUses, [](const EdgeUse& use) { return use; },
      [&](std::span<EdgeUse> uses, std::span<const std::uint32_t>) {
        visit_edges(uses, visit);
        return true;
      });
}

}  // namespace knead
