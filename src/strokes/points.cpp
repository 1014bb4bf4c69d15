// The tool "points": a moving set of points and curves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "knead/error.h"
#include "knead/field.h"
#include "strokes/connected_parts.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"

namespace knead {

namespace {

using namespace detail;

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

// Returns the curve relative to c. Points that repeat the one before, also those that single precision cannot
// distinguish, are left out, unless less than a curve would remain.
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

// Returns the greatest distance of the set from its centre.
double radius_of(const Field& field) {
  const auto& set = std::get<PointSet<double>>(field.region);
  double radius2 = 0;
  for (const Vec3d& p : set.points) radius2 = std::max(radius2, norm2(p));
  for (const std::vector<Vec3d>& curve : set.curves) {
    for (const Vec3d& p : curve) radius2 = std::max(radius2, norm2(p));
  }
  return std::sqrt(radius2);
}

// Returns the greatest distance of the parts' centres from the common centre.
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
          {"outer", Quantity::outer, &s.outer, Presence::required, kOuterHelp},
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

std::string words(const PointsStroke& stroke, const std::string& unit) {
  Vec3d by{};
  for (const Vec3d& displacement : stroke.displacements) by += displacement;
  return fmt::format("Move {} {}", stroke.points.empty() ? "a curve" : "points", length_text(norm(by), unit));
}

// Returns a stroke for each displacement. Their flows are that of the whole up to rounding: its centres are added up in
// another way.
std::vector<Stroke> pieces(const PointsStroke& stroke) {
  std::vector<Stroke> pieces;
  PointsStroke piece = stroke;
  for (const Vec3d& displacement : stroke.displacements) {
    piece.displacements = {displacement};
    pieces.emplace_back(piece);
    for (Vec3d& p : piece.points) p += displacement;
    for (auto& curve : piece.curves) {
      for (Vec3d& p : curve) p += displacement;
    }
  }
  return pieces;
}

using Displacements = Growing<PointsStroke, &PointsStroke::displacements>;

}  // namespace

constinit const detail::ToolRow<PointsStroke> PointsStroke::tool{.name = "points",
                                                                 .keys = keys,
                                                                 .prepare = prepare,
                                                                 .validate = validate,
                                                                 .flow = flow_of,
                                                                 .segments = Displacements::segments,
                                                                 .warn = warn,
                                                                 .words = words,
                                                                 .prolong = prolong,
                                                                 .grows = Displacements::grows,
                                                                 .pieces = pieces};

}  // namespace knead
