// How thick a shape is across the line of a curve stroke, and how long it becomes with another thickness.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "flow/curve_map.h"
#include "knead/error.h"
#include "math/elementary.h"
#include "strokes/curve.h"

namespace knead::detail {

namespace {

using SectionPoint = std::array<double, 2>;

// Twice the area of a triangle, above 0 if it turns left.
double left_turn(const SectionPoint& a, const SectionPoint& b, const SectionPoint& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Returns the convex hull counterclockwise (Andrew's monotone chain).
std::vector<SectionPoint> hull_of(std::vector<SectionPoint> points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<SectionPoint> hull;
  for (const bool upper : {false, true}) {
    const std::size_t first = hull.size();
    for (const SectionPoint& p : points) {
      while (hull.size() >= first + 2 && left_turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();
    if (!upper) std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Returns the least distance of two parallel lines that enclose the points: one of them holds an edge of the hull.
double least_width(std::vector<SectionPoint> points) {
  const std::vector<SectionPoint> hull = hull_of(std::move(points));
  if (hull.size() < 3) return 0;
  double least = kInfinity;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const SectionPoint& a = hull[i];
    const SectionPoint& b = hull[(i + 1) % hull.size()];
    double from = 0;
    double to = 0;
    for (const SectionPoint& p : hull) {
      const double area = left_turn(a, b, p);
      from = std::min(from, area);
      to = std::max(to, area);
    }
    least = std::min(least, (to - from) / elementary::hypot(b[0] - a[0], b[1] - a[1]));
  }
  return least;
}

double width_along_axis(const std::vector<SectionPoint>& points) {
  const auto [least, most] = std::minmax_element(
      points.begin(), points.end(), [](const SectionPoint& a, const SectionPoint& b) { return a[1] < b[1]; });
  return points.empty() ? 0 : (*most)[1] - (*least)[1];
}

// The shape's vertices about the line; nothing where they rest, or have no place.
std::vector<std::optional<CurvePoint<double>>> places_on_line(const CurveMotion& line,
                                                              std::span<const Vec3d> positions) {
  const CurveTable<double> table(line, 0.0);
  std::vector<std::optional<CurvePoint<double>>> places;
  places.reserve(positions.size());
  for (const Vec3d& x : positions) {
    auto& place = places.emplace_back(table.find(x - line.place));
    if (place && line.radius && elementary::hypot(place->across[0], place->across[1]) > *line.radius) place.reset();
  }
  return places;
}

// Returns the places across the line of what the surface has between two lengths: its vertices there, and where its
// edges enter.
std::vector<SectionPoint> section_between(const std::vector<std::optional<CurvePoint<double>>>& places,
                                          std::span<const Triangle> triangles, double from, double to) {
  std::vector<SectionPoint> points;
  for (const auto& place : places) {
    if (place && place->s >= from && place->s <= to) points.push_back({place->across[0], place->across[1]});
  }
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& a = places[t[i]];
      const auto& b = places[t[(i + 1) % 3]];
      if (!a || !b) continue;
      for (const double s : {from, to}) {
        if ((a->s < s) == (b->s < s)) continue;
        const double f = (s - a->s) / (b->s - a->s);
        points.push_back({std::lerp(a->across[0], b->across[0], f), std::lerp(a->across[1], b->across[1], f)});
      }
    }
  }
  return points;
}

// Returns by how much the shape becomes longer along the line; the lengths along it go from `first` to `last`.
double gained_length(const CurveMotion& motion, double first, double last) {
  constexpr int kPieces = 256;
  const CurveTable<double> table(motion, 1.0);
  double length = 0;
  Vec3d before;
  for (int i = 0; i <= kPieces; ++i) {
    Vec3d at;
    table.place(CurvePoint<double>{std::lerp(first, last, static_cast<double>(i) / kPieces), {}}, at);
    if (i > 0) length += norm(at - before);
    before = at;
  }
  return length - (last - first);
}

}  // namespace

void find_thickness(CurveStroke& stroke, const LiveSurface& surface, std::vector<std::string>& remarks) {
  constexpr double kWidthOfEnd = 1e-6;  // of the length: rounding of an end face
  CurveStroke line = stroke;
  line.thickness.reset();
  line.thicker_by = 0;
  const CurveMotion rest = motion_of(line);
  const auto places = places_on_line(rest, surface.positions);
  if (!stroke.thickness_before) {
    const double ramp = kArcRamp * rest.spacing();
    const double from = stroke.taper ? rest.length * (1 - kWidthOfEnd) : ramp;
    const double to = stroke.taper ? rest.length * (1 + kWidthOfEnd) : rest.length - ramp;
    const std::vector<SectionPoint> section = section_between(places, surface.triangles, from, to);
    const double thickness = stroke.axis ? width_along_axis(section) : least_width(section);
    if (!(thickness > 0)) {
      throw InvalidInput(
          fmt::format("\"from\": the shape has no thickness {}; give a line that ends in the shape, or "
                      "\"thickness_before\"",
                      stroke.taper ? "at the line's end" : "between the line's ends"));
    }
    stroke.thickness_before = thickness;
  }
  double first = kInfinity;
  double last = -kInfinity;
  for (const auto& place : places) {
    if (place) first = std::min(first, place->s), last = std::max(last, place->s);
  }
  if (!(first < last)) return;
  const double longer = gained_length(motion_of(stroke), first, last);
  const double before = *stroke.thickness_before;
  remarks.push_back(fmt::format(
      "the thickness {} is {:.4g} and becomes {:.4g}; {}", stroke.taper ? "at the line's end" : "along the line",
      before, stroke.thickness.value_or(before + stroke.thicker_by),
      stroke.keep == CurveKeeps::length
          ? std::string("the length stays")
          : fmt::format("the shape becomes {:.4g} {}", std::abs(longer), longer < 0 ? "shorter" : "longer")));
}

}  // namespace knead::detail
