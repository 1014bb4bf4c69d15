#include "knead/mesh/triangulate.h"

#include <cmath>
#include <string>

#include "knead/math/error.h"
#include "knead/mesh/check.h"

namespace knead {
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
      if (refused < left && tests_ < kMostTests && !is_ear(corner)) {
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
  static constexpr std::size_t kMostTests = 10'000'000;

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

}  // namespace knead
