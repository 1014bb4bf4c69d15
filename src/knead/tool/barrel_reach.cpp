#include "knead/tool/barrel_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "knead/math/elementary.h"

namespace knead::tool_detail {

namespace {

using Corners = std::array<Vec3d, 3>;  // of a triangle

// A triangle cut by a plane has at most four corners.
struct Polygon {
  std::array<Vec3d, 4> corners;
  int count = 0;

  void add(const Vec3d& p) { corners[count++] = p; }
};

// The part of the triangle, given relative to the centre, with normal.d <= outer; empty where none of it is below.
Polygon clip(const Corners& triangle, const Vec3d& normal, double outer) {
  Polygon result;
  std::array<double, 3> above{};
  for (std::size_t i = 0; i < 3; ++i) above[i] = dot(normal, triangle[i]) - outer;
  if (!(std::min({above[0], above[1], above[2]}) < 0)) return result;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (above[i] <= 0) result.add(triangle[i]);
    if ((above[i] < 0 && above[j] > 0) || (above[i] > 0 && above[j] < 0)) {
      result.add(triangle[i] + (triangle[j] - triangle[i]) * (above[i] / (above[i] - above[j])));
    }
  }
  return result;
}

// d without its part along the axis, rounded as advect rounds it when it decides whether a point belongs.
Vec3d across_axis(const Vec3d& d, const Vec3d& axis) { return d - axis * dot(axis, d); }

double distance_to_segment(const Vec3d& a, const Vec3d& b) {
  const Vec3d e = b - a;
  const double length2 = norm2(e);
  const double along = length2 > 0 ? std::clamp(-dot(e, a) / length2, 0.0, 1.0) : 0.0;
  return norm(a + e * along);
}

// Whether the axis meets the polygon, given its corners across the axis: they wind about the axis in one sense. Seen
// edge-on it is as near as its edges, and the signs are noise.
bool is_pierced(const Polygon& across, const Vec3d& axis, double farthest) {
  constexpr double kEdgeOn = 1e-12;
  bool positive = false;
  bool negative = false;
  double area = 0;
  for (int i = 0; i < across.count; ++i) {
    const double turn = dot(axis, cross(across.corners[i], across.corners[(i + 1) % across.count]));
    positive = positive || turn > 0;
    negative = negative || turn < 0;
    area += turn;
  }
  return positive != negative && std::abs(area) > kEdgeOn * farthest * farthest;
}

Reach distances(Polygon polygon, const Vec3d& axis) {
  for (int i = 0; i < polygon.count; ++i) polygon.corners[i] = across_axis(polygon.corners[i], axis);
  Reach result{std::numeric_limits<double>::infinity(), 0};
  for (int i = 0; i < polygon.count; ++i) {
    const double length = norm(polygon.corners[i]);
    result.max = std::max(result.max, length);
    result.min = std::min(
        {result.min, length, distance_to_segment(polygon.corners[i], polygon.corners[(i + 1) % polygon.count])});
  }
  if (is_pierced(polygon, axis, result.max)) result.min = 0;
  return result;
}

}  // namespace

std::optional<Reach> reach_of(const Barrel& barrel, const Vec3d& normal, std::span<const Vec3d> positions,
                              const Triangle& triangle) {
  const Corners corners{positions[triangle[0]] - barrel.center, positions[triangle[1]] - barrel.center,
                        positions[triangle[2]] - barrel.center};
  const Polygon polygon = clip(corners, normal, barrel.outer);
  if (polygon.count == 0) return std::nullopt;
  return distances(polygon, barrel.normal);
}

std::vector<Reach> merged(std::vector<Reach> all) {
  std::sort(all.begin(), all.end(), [](const Reach& a, const Reach& b) { return a.min < b.min; });
  std::vector<Reach> result;
  for (const Reach& reach : all) {
    if (result.empty() || reach.min > result.back().max) {
      result.push_back(reach);
    } else {
      result.back().max = std::max(result.back().max, reach.max);
    }
  }
  return result;
}

std::vector<Reach> merged_reaches(const Barrel& barrel, std::span<const Vec3d> positions,
                                  std::span<const Triangle> triangles) {
  std::vector<Reach> all;
  for (const Triangle& triangle : triangles) {
    if (const auto reach = reach_of(barrel, barrel.normal, positions, triangle)) all.push_back(*reach);
  }
  return merged(std::move(all));
}

std::optional<double> short_number_between(double low, double high, double target, Round round, int digits) {
  const int exponent = elementary::decimal_exponent(std::max(target, std::numeric_limits<double>::min()));
  for (; digits <= 15; ++digits) {
    const double scale = elementary::power_of_ten(digits - 1 - exponent);
    const double steps = target * scale;
    const double value = (round == Round::up     ? std::floor(steps) + 1
                          : round == Round::down ? std::ceil(steps) - 1
                                                 : std::floor(steps + 0.5)) /
                         scale;
    if (low < value && value < high) return value;
  }
  return std::nullopt;
}

}  // namespace knead::tool_detail
