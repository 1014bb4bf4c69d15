// Measures of a surface with their derivatives with respect to its points, by a tape of the formulas.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "flow/taped.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/replay.h"

namespace knead {
namespace {

using detail::Tape;
using detail::Taped;
using Point = Vec3<Taped>;

void require(std::span<const Vec3d> points, std::span<const Triangle> triangles,
             std::span<const std::uint32_t> vertices = {}) {
  require_finite(points);
  const auto check = [&](std::uint32_t vertex) {
    if (vertex < points.size()) return;
    throw InvalidInput(fmt::format("vertex {} does not exist; there are {}", vertex, points.size()));
  };
  for (const Triangle& triangle : triangles) std::for_each(triangle.begin(), triangle.end(), check);
  std::for_each(vertices.begin(), vertices.end(), check);
}

// The points of one value, as variables of a tape.
class Variables {
 public:
  Variables(std::span<const Vec3d> points, Tape& tape) : points_(points), tape_(tape) { tape_.clear(); }

  const Point& operator[](std::uint32_t vertex) {
    const auto found = std::find(vertices_.begin(), vertices_.end(), vertex);
    if (found != vertices_.end()) return own_[static_cast<std::size_t>(found - vertices_.begin())];
    vertices_.push_back(vertex);
    const Vec3d& p = points_[vertex];
    return own_.emplace_back(tape_.variable(p.x), tape_.variable(p.y), tape_.variable(p.z));
  }

  std::array<Point, 3> operator[](const Triangle& t) {
    const Point a = (*this)[t[0]];
    const Point b = (*this)[t[1]];
    return {a, b, (*this)[t[2]]};
  }

  // Calls add(vertex, derivative) for each point of the value.
  template <class Add>
  void differentiate(const Taped& value, const Add& add) {
    tape_.add(value, 1);
    tape_.carry_back(0);
    for (std::size_t i = 0; i < own_.size(); ++i) {
      add(vertices_[i], Vec3d{tape_.derivative(own_[i].x), tape_.derivative(own_[i].y), tape_.derivative(own_[i].z)});
    }
  }

 private:
  std::span<const Vec3d> points_;
  Tape& tape_;
  std::vector<std::uint32_t> vertices_;
  std::vector<Point> own_;
};

// The sum over the triangles of formula(corners).
template <class Formula>
SurfaceMeasures sum_over(std::span<const Vec3d> points, std::span<const Triangle> triangles, const Formula& formula) {
  SurfaceMeasures result{{0}, {points.size()}, {}, std::vector<Vec3d>(points.size()), points.size()};
  for (std::uint32_t i = 0; i < points.size(); ++i) result.vertices.push_back(i);
  Tape tape;
  for (const Triangle& triangle : triangles) {
    Variables own(points, tape);
    const Taped value = formula(own[triangle]);
    result.values[0] += value.v;
    own.differentiate(value, [&](std::uint32_t i, const Vec3d& by_point) { result.derivatives[i] += by_point; });
  }
  return result;
}

// One value for each vertex: formula(vertex, variables).
template <class Formula>
SurfaceMeasures at_each(std::span<const Vec3d> points, std::span<const std::uint32_t> vertices,
                        const Formula& formula) {
  SurfaceMeasures result;
  result.points = points.size();
  Tape tape;
  for (const std::uint32_t vertex : vertices) {
    Variables own(points, tape);
    const Taped value = formula(vertex, own);
    result.values.push_back(value.v);
    own.differentiate(value, [&](std::uint32_t i, const Vec3d& by_point) {
      result.vertices.push_back(i);
      result.derivatives.push_back(by_point);
    });
    result.ends.push_back(result.vertices.size());
  }
  return result;
}

Point doubled_area_vector(const std::array<Point, 3>& corners) {
  return cross(corners[1] - corners[0], corners[2] - corners[0]);
}

// The triangles around each vertex, turned so that it comes first.
std::vector<std::vector<Triangle>> fans_of(std::size_t points, std::span<const Triangle> triangles) {
  std::vector<std::vector<Triangle>> fans(points);
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) fans[t[i]].push_back({t[i], t[(i + 1) % 3], t[(i + 2) % 3]});
  }
  return fans;
}

Point unit_normal(std::uint32_t vertex, const std::vector<Triangle>& fan, Variables& own) {
  Point sum;
  for (const Triangle& t : fan) sum += doubled_area_vector(own[t]);
  if (!(norm2(sum).v > 0)) throw InvalidInput(fmt::format("vertex {} has no face with an area around it", vertex));
  return sum / norm(sum);
}

void require_closed(std::span<const Triangle> triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> forth;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> back;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      forth.emplace_back(t[i], t[(i + 1) % 3]);
      back.emplace_back(t[(i + 1) % 3], t[i]);
    }
  }
  std::sort(forth.begin(), forth.end());
  std::sort(back.begin(), back.end());
  const auto open = std::mismatch(forth.begin(), forth.end(), back.begin());
  if (open.first == forth.end()) return;
  const auto& [a, b] = std::min(*open.first, *open.second);
  throw InvalidInput(
      fmt::format("the surface is open, or its faces disagree which side is outside, at the edge of the vertices {} "
                  "and {}; it has no volume",
                  a, b));
}

Taped signed_curvature(std::uint32_t vertex, const std::vector<Triangle>& fan, Variables& own) {
  std::set<std::uint32_t> after;
  std::set<std::uint32_t> before;
  for (const Triangle& t : fan) {
    after.insert(t[1]);
    before.insert(t[2]);
  }
  if (fan.empty() || after != before) {
    throw InvalidInput(fmt::format("vertex {} lies at a border, where a surface has no curvature", vertex));
  }
  const Point normal = unit_normal(vertex, fan, own);
  Point laplacian;
  Taped area(0);
  for (const Triangle& t : fan) {
    const auto [a, b, c] = own[t];
    const Taped doubled = norm(doubled_area_vector({a, b, c}));
    if (!(doubled.v > 0)) throw InvalidInput(fmt::format("a face at vertex {} has no area", vertex));
    laplacian += ((b - a) * dot(a - c, b - c) + (c - a) * dot(a - b, c - b)) / (doubled * Taped(2));
    area = area + doubled / Taped(6);
  }
  return dot(laplacian, normal) / (area * Taped(-2));
}

}  // namespace

std::vector<double> SurfaceMeasures::jvp(std::span<const Vec3d> tangents) const {
  if (tangents.size() != points) {
    throw InvalidInput(
        fmt::format("tangents must have a vector for each of {} points, got {}", points, tangents.size()));
  }
  std::vector<double> result(values.size(), 0);
  for (std::size_t i = 0, k = 0; i < values.size(); ++i) {
    for (; k < ends[i]; ++k) result[i] += dot(derivatives[k], tangents[vertices[k]]);
  }
  return result;
}

std::vector<Vec3d> SurfaceMeasures::vjp(std::span<const double> weights) const {
  if (weights.size() != values.size()) {
    throw InvalidInput(
        fmt::format("weights must have a number for each of {} values, got {}", values.size(), weights.size()));
  }
  std::vector<Vec3d> result(points);
  for (std::size_t i = 0, k = 0; i < values.size(); ++i) {
    for (; k < ends[i]; ++k) result[vertices[k]] += derivatives[k] * weights[i];
  }
  return result;
}

SurfaceMeasures volume_of(std::span<const Vec3d> points, std::span<const Triangle> triangles) {
  require(points, triangles);
  require_closed(triangles);
  // About the middle of the box, so that a shape far away does not lose digits.
  const Vec3d middle = points.empty() ? Vec3d{} : bounding_box(points).center();
  return sum_over(points, triangles, [&](const std::array<Point, 3>& p) {
    const Point center(middle);
    return dot(p[0] - center, cross(p[1] - center, p[2] - center)) / Taped(6);
  });
}

SurfaceMeasures area_of(std::span<const Vec3d> points, std::span<const Triangle> triangles) {
  require(points, triangles);
  return sum_over(points, triangles,
                  [](const std::array<Point, 3>& p) { return norm(doubled_area_vector(p)) / Taped(2); });
}

SurfaceMeasures thickness_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices) {
  require(points, triangles, vertices);
  const std::vector<std::vector<Triangle>> fans = fans_of(points.size(), triangles);
  const SurfaceTree tree(triangles, points);
  return at_each(points, vertices, [&](std::uint32_t vertex, Variables& own) {
    const Point inwards = -unit_normal(vertex, fans[vertex], own);
    for (const RayHit& hit : tree.hits(points[vertex], {inwards.x.v, inwards.y.v, inwards.z.v})) {
      const Triangle& t = triangles[hit.triangle];
      if (std::find(t.begin(), t.end(), vertex) != t.end()) continue;
      const std::array<Point, 3> other = own[t];
      const Point plane = doubled_area_vector(other);
      return dot(other[0] - own[vertex], plane) / dot(inwards, plane);
    }
    throw InvalidInput(
        fmt::format("behind vertex {} there is no other side; close the surface, or turn its faces", vertex));
  });
}

SurfaceMeasures curvature_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices) {
  require(points, triangles, vertices);
  const std::vector<std::vector<Triangle>> fans = fans_of(points.size(), triangles);
  return at_each(points, vertices,
                 [&](std::uint32_t vertex, Variables& own) { return signed_curvature(vertex, fans[vertex], own); });
}

SurfaceMeasures patch_distance(std::span<const Vec3d> points, std::span<const std::uint32_t> vertices,
                               std::span<const Triangle> patch) {
  require(points, patch, vertices);
  if (patch.empty()) throw InvalidInput("the patch has no faces");
  const SurfaceTree tree(patch, points);
  return at_each(points, vertices, [&](std::uint32_t vertex, Variables& own) {
    const SurfacePoint nearest = *tree.closest(points[vertex]);
    const std::array<Point, 3> corners = own[patch[nearest.triangle]];
    Point there;  // its weights do not count: it is the nearest
    for (std::size_t i = 0; i < 3; ++i) there += corners[i] * Taped(nearest.barycentric[i]);
    return norm(own[vertex] - there);
  });
}

}  // namespace knead
