#include "knead/tool/barrel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "knead/field/region.h"
#include "knead/tool/tools.h"

namespace knead {

namespace {

using Corners = std::array<Vec3d, 3>;  // of a triangle

// A triangle cut by a plane has at most four corners.
struct Polygon {
  std::array<Vec3d, 4> corners;
  int count = 0;

  void add(const Vec3d& p) { corners[count++] = p; }
};

// The distances from the axis that a polygon covers.
struct Interval {
  double min = 0;
  double max = 0;
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

Interval distances(Polygon polygon, const Vec3d& axis) {
  for (int i = 0; i < polygon.count; ++i) polygon.corners[i] = across_axis(polygon.corners[i], axis);
  Interval result{std::numeric_limits<double>::infinity(), 0};
  for (int i = 0; i < polygon.count; ++i) {
    const double length = norm(polygon.corners[i]);
    result.max = std::max(result.max, length);
    result.min = std::min(
        {result.min, length, distance_to_segment(polygon.corners[i], polygon.corners[(i + 1) % polygon.count])});
  }
  if (is_pierced(polygon, axis, result.max)) result.min = 0;
  return result;
}

Corners about(const Vec3d& center, std::span<const Vec3d> positions, const Triangle& triangle) {
  return {positions[triangle[0]] - center, positions[triangle[1]] - center, positions[triangle[2]] - center};
}

bool crosses(const Polygon& polygon, const Barrel& barrel) {
  if (polygon.count == 0) return false;
  const Interval interval = distances(polygon, barrel.normal);
  return interval.min <= barrel.radius && barrel.radius < interval.max;
}

// The union of the intervals [min, max), by increasing min, no two touching.
std::vector<Interval> merged_intervals(const Barrel& barrel, std::span<const Vec3d> positions,
                                       std::span<const Triangle> triangles) {
  std::vector<Interval> all;
  for (const Triangle& triangle : triangles) {
    const Polygon polygon = clip(about(barrel.center, positions, triangle), barrel.normal, barrel.outer);
    if (polygon.count > 0) all.push_back(distances(polygon, barrel.normal));
  }
  std::sort(all.begin(), all.end(), [](const Interval& a, const Interval& b) { return a.min < b.min; });
  std::vector<Interval> merged;
  for (const Interval& interval : all) {
    if (merged.empty() || interval.min > merged.back().max) {
      merged.push_back(interval);
    } else {
      merged.back().max = std::max(merged.back().max, interval.max);
    }
  }
  return merged;
}

// A short number strictly between low and high, near the end `target` of the two: rounded away from it to six digits,
// or more where the gap is narrow. Nothing where the gap holds no number.
std::optional<double> between(double low, double high, bool near_low) {
  const double target = near_low ? low : high;
  const double exponent = std::floor(std::log10(std::max(target, std::numeric_limits<double>::min())));
  for (int digits = 6; digits <= 15; ++digits) {
    const double scale = std::pow(10.0, digits - 1 - exponent);
    const double steps = near_low ? std::floor(target * scale) + 1 : std::ceil(target * scale) - 1;
    const double value = steps / scale;
    if (low < value && value < high) return value;
  }
  return std::nullopt;
}

void suggest(const std::vector<Interval>& merged, double radius, BarrelCheck& check) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  while (at + 1 < merged.size() && merged[at + 1].min <= radius) ++at;
  for (std::size_t i = at; i > 0 && !check.smaller; --i) {
    check.smaller = between(merged[i - 1].max, merged[i].min, false);
  }
  for (std::size_t i = at; i < merged.size() && !check.larger; ++i) {
    check.larger = between(merged[i].max, i + 1 < merged.size() ? merged[i + 1].min : kInfinity, true);
  }
}

// n(1) of a bend; a twist's normal rests.
Vec3d last_normal(const Field& field) { return normal_at(std::get<HalfSpace<double>>(field.region), 1.0); }

}  // namespace

std::optional<Barrel> barrel_of(const Stroke& stroke) {
  const auto* twist = std::get_if<TwistStroke>(&stroke);
  const auto* bend = std::get_if<BendStroke>(&stroke);
  if ((twist == nullptr || !twist->radius) && (bend == nullptr || !bend->radius)) return std::nullopt;
  const Flow flow = flow_of(stroke);
  const Segment& segment = flow.segments.front();
  const Field& field = segment.fields.front();
  return Barrel{segment.cylinder->point, segment.cylinder->direction, segment.cylinder->radius, field.thresholds.outer,
                last_normal(field)};
}

BarrelCheck check_barrel(const Barrel& barrel, std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  BarrelCheck check;
  const bool turns = barrel.last_normal != barrel.normal;
  for (const Triangle& triangle : triangles) {
    const Corners corners = about(barrel.center, positions, triangle);
    if (crosses(clip(corners, barrel.normal, barrel.outer), barrel)) {
      ++check.crossing;
    } else if (turns && crosses(clip(corners, barrel.last_normal, barrel.outer), barrel)) {
      ++check.later;
    }
  }
  if (check.crossing > 0) suggest(merged_intervals(barrel, positions, triangles), barrel.radius, check);
  return check;
}

std::optional<double> nearest_radius(const BarrelCheck& check, double radius) {
  if (!check.smaller) return check.larger;
  if (!check.larger) return check.smaller;
  return radius - *check.smaller < *check.larger - radius ? check.smaller : check.larger;
}

}  // namespace knead
