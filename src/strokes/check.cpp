#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "knead/error.h"
#include "knead/field.h"
#include "strokes/continued.h"
#include "strokes/describe.h"

namespace knead::tool_detail {

namespace {

void require(bool good, std::string_view key, const std::string& expected, double got) {
  if (!good) throw InvalidInput(fmt::format("\"{}\" must be {}, got {}", key, expected, got));
}

}  // namespace

void require_finite(std::string_view key, double value) {
  require(std::isfinite(value), key, "a finite number", value);
}

void require_finite(std::string_view key, const Vec3d& value) {
  if (is_finite(value)) return;
  throw InvalidInput(
      fmt::format("\"{}\" must be three finite numbers, got [{}, {}, {}]", key, value.x, value.y, value.z));
}

void require_finite(std::string_view key, const std::vector<Vec3d>& values) {
  for (const Vec3d& value : values) require_finite(key, value);
}

void require_positive(std::string_view key, double value) {
  require(std::isfinite(value) && value > 0, key, "a number greater than 0", value);
}

void require_factor(std::string_view key, double value) {
  require(value >= 1e-6 && value <= 1e6, key, "a number greater than 0, from 1e-6 to 1e6", value);
}

void require_direction(std::string_view key, const Vec3d& value) {
  require_finite(key, value);
  if (value == Vec3d{0, 0, 0}) {
    throw InvalidInput(fmt::format("\"{}\" must be a vector of any length but 0, got [0, 0, 0]", key));
  }
}

void require_angle(std::string_view key, double degrees) {
  require(std::abs(degrees) <= kMaxDegrees, key, "a number of degrees from -360000 to 360000", degrees);
}

void require_count(std::string_view key, std::size_t count, std::size_t least, std::string_view what) {
  if (count >= least) return;
  throw InvalidInput(fmt::format("\"{}\" must hold {} or more {}, got {}", key, least, what, count));
}

void require_falloff(std::string_view key, int value) {
  if (value >= kMinFalloff && value <= kGreatestFalloff) return;
  throw InvalidInput(
      fmt::format("\"{}\" must be a whole number from {} to {}, got {}", key, kMinFalloff, kGreatestFalloff, value));
}

void require_even(std::string_view key, int value, int least) {
  if (value >= least && value % 2 == 0) return;
  throw InvalidInput(fmt::format("\"{}\" must be an even number, {} or more, got {}", key, least, value));
}

void require_thresholds(double inner, double outer) {
  require_finite("inner", inner);
  require_finite("outer", outer);
  require(inner < outer, "outer", fmt::format("a number greater than \"inner\" ({})", inner), outer);
}

void require_distance_thresholds(double inner, double outer) {
  require_positive("outer", outer);
  require(std::isfinite(inner) && inner >= 0, "inner", "a number that is 0 or greater", inner);
  require_thresholds(inner, outer);
}

Vec3d unit(const Vec3d& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  return normalized(v / largest);
}

}  // namespace knead::tool_detail

namespace knead {

namespace {

using namespace tool_detail;

void validate_curve(const std::vector<Vec3d>& curve) {
  require_count("curves", curve.size(), 2, "points in each curve");
  require_finite("curves", curve);
  if (std::all_of(curve.begin(), curve.end(), [&](const Vec3d& p) { return p == curve.front(); })) {
    throw InvalidInput("\"curves\" must hold curves of a length greater than 0; give a single point in \"points\"");
  }
}

std::vector<Part> parts_of(const PointsStroke& stroke) {
  if (stroke.center == PointsCenter::parts) return connected_parts(stroke.points, stroke.curves, stroke.outer);
  Part all{std::vector<std::uint32_t>(stroke.points.size()), std::vector<std::uint32_t>(stroke.curves.size())};
  std::iota(all.points.begin(), all.points.end(), 0U);
  std::iota(all.curves.begin(), all.curves.end(), 0U);
  return {std::move(all)};
}

// A point weighs 1, a curve its length / outer at its own centroid: so the barycentre of points alone is their mean,
// and that of curves alone does not depend on how finely they are cut. Relative to the first element, so that nothing
// is lost far from the origin.
Vec3d barycentre(const PointsStroke& stroke, const Part& part) {
  const Vec3d origin =
      part.points.empty() ? stroke.curves[part.curves.front()].front() : stroke.points[part.points.front()];
  double weight = 0;
  Vec3d sum{0, 0, 0};
  for (const std::uint32_t i : part.points) {
    weight += 1;
    sum += stroke.points[i] - origin;
  }
  for (const std::uint32_t k : part.curves) {
    const std::vector<Vec3d>& curve = stroke.curves[k];
    for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
      const double share = norm(curve[i + 1] - curve[i]) / stroke.outer;
      weight += share;
      sum += ((curve[i] - origin) + (curve[i + 1] - origin)) * (0.5 * share);
    }
  }
  return origin + sum / weight;
}

// The curve relative to c; a point that repeats the one before is left out, also where single precision cannot tell
// the two apart, unless that would leave no curve.
std::vector<Vec3d> curve_about(const std::vector<Vec3d>& curve, const Vec3d& c) {
  std::vector<Vec3d> exact;
  exact.reserve(curve.size());
  for (const Vec3d& p : curve) exact.push_back(p - c);
  exact.erase(std::unique(exact.begin(), exact.end()), exact.end());
  std::vector<Vec3d> result = exact;
  const auto same = [](const Vec3d& p, const Vec3d& q) { return Vec3f(p) == Vec3f(q); };
  result.erase(std::unique(result.begin(), result.end(), same), result.end());
  return result.size() < 2 ? exact : result;
}

Field field_of(const PointsStroke& stroke, const Part& part) {
  const Vec3d c = barycentre(stroke, part);
  PointSet<double> region;
  region.exponent = stroke.exponent;
  for (const std::uint32_t i : part.points) region.points.push_back(stroke.points[i] - c);
  for (const std::uint32_t k : part.curves) region.curves.push_back(curve_about(stroke.curves[k], c));
  return {c, Translation<double>{}, std::move(region), {stroke.inner, stroke.outer}};
}

// The greatest distance of the set from its centre.
double radius_of(const Field& field) {
  const auto& set = std::get<PointSet<double>>(field.region);
  double radius2 = 0;
  for (const Vec3d& p : set.points) radius2 = std::max(radius2, norm2(p));
  for (const std::vector<Vec3d>& curve : set.curves) {
    for (const Vec3d& p : curve) radius2 = std::max(radius2, norm2(p));
  }
  return std::sqrt(radius2);
}

// How far the parts lie from the one centre of all, at most.
double farthest_part(const PointsStroke& stroke, const std::vector<Part>& parts) {
  const Vec3d center = barycentre(stroke, parts_of(stroke).front());
  double farthest = 0;
  for (const Part& part : parts) farthest = std::max(farthest, norm(barycentre(stroke, part) - center));
  return farthest;
}

void warn_of_swirl(const PointsStroke& stroke, Warnings& warnings) {
  const std::vector<Part> parts = connected_parts(stroke.points, stroke.curves, stroke.outer);
  if (parts.size() < 2) return;
  warnings.push_back(
      fmt::format("the set falls into {} parts but has one centre, so each swirls at up to {:.2g} times the tool's "
                  "speed; leave \"center\" at \"parts\", or make \"outer\" larger",
                  parts.size(), farthest_part(stroke, parts) / stroke.outer));
}

std::vector<StrokeKey> keys(PointsStroke& s) {
  return {{"points", Quantity::finite, &s.points, Presence::optional},
          {"curves", Quantity::other, &s.curves, Presence::optional},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"displacements", Quantity::displacement, &s.displacements},
          {"exponent", Quantity::other, &s.exponent, Presence::optional},
          {"inner", Quantity::other, &s.inner, Presence::optional, kInnerHelp},
          {"center", Quantity::other, choice(s.center, {"parts", "barycentre"}), Presence::optional}};
}

void prepare(PointsStroke& /*stroke*/, const HasKey& has) {
  if (has("points") || has("curves")) return;
  throw InvalidInput(R"("points" or "curves" is missing; a points stroke needs one of them or both)");
}

void validate(const PointsStroke& stroke) {
  if (stroke.points.empty() && stroke.curves.empty()) {
    throw InvalidInput("\"points\" and \"curves\" must hold 1 or more points or curves in all, got none");
  }
  for (const std::vector<Vec3d>& curve : stroke.curves) validate_curve(curve);
  require_distance_thresholds(stroke.inner, stroke.outer);
  require_count("displacements", stroke.displacements.size(), 1, "vectors");
  require_even("exponent", stroke.exponent, 2);
}

Flow flow_of(const PointsStroke& stroke) {
  std::vector<Field> fields;
  for (const Part& part : parts_of(stroke)) fields.push_back(field_of(stroke, part));
  Flow flow;
  for (const Vec3d& displacement : stroke.displacements) {
    for (Field& field : fields) field.motion = Translation<double>{displacement};
    Segment segment;
    segment.fields = fields;
    segment.displacement = displacement;
    flow.segments.push_back(std::move(segment));
    for (Field& field : fields) field.center += displacement;
  }
  return flow;
}

void warn(const PointsStroke& stroke, Warnings& warnings) {
  warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
  double largest = 0;
  for (const Part& part : parts_of(stroke)) largest = std::max(largest, radius_of(field_of(stroke, part)));
  const double return_flow = largest / (2 * stroke.outer);
  if (return_flow > kStrongReturn) {
    warnings.push_back(
        fmt::format("the set is {:.3g} wide, and its flow returns past the rim at about {:.2g} times the tool's speed; "
                    "make \"outer\" larger, or the set smaller",
                    2 * largest, return_flow));
  }
  if (stroke.center == PointsCenter::barycentre) warn_of_swirl(stroke, warnings);
}

void prolong(PointsStroke& stroke, double strength) {
  std::vector<Vec3d> path{{0, 0, 0}};
  for (const Vec3d& displacement : stroke.displacements) path.push_back(path.back() + displacement);
  const Vec3d end = path.back();
  prolong_path(path, strength);
  if (path.size() > stroke.displacements.size() + 1) stroke.displacements.push_back(path.back() - end);
}

}  // namespace

const Tool& PointsStroke::tool() {
  static const Tool kTool =
      describe<PointsStroke>("points", {keys, validate, flow_of, warn, nullptr, prepare, prolong});
  return kTool;
}

}  // namespace knead
