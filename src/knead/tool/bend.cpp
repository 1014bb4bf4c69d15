#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/describe.h"
#include "knead/tool/pose.h"

namespace knead {

namespace tool_detail {

Thresholds<double> bend_thresholds(const BendStroke& stroke) {
  if (const auto* given = std::get_if<BendThresholds>(&stroke.extent)) {
    return {given->inner, given->outer, stroke.falloff};
  }
  const auto& extent = std::get<BendWidth>(stroke.extent);
  const double fraction = extent.center_fraction.value_or(falloff_facts(stroke.falloff).half);
  return {-fraction * extent.width, (1 - fraction) * extent.width, stroke.falloff};
}

void move_center(BendStroke& stroke, int falloff) {
  auto* const zone = std::get_if<BendThresholds>(&stroke.extent);
  if (zone == nullptr) return;
  const double moved = falloff_facts(falloff).half - falloff_facts(stroke.falloff).half;
  const double shift = moved * (zone->outer - zone->inner);
  stroke.center += unit(stroke.normal) * shift;
  zone->inner -= shift;
  zone->outer -= shift;
}

}  // namespace tool_detail

namespace {

using namespace tool_detail;

// |a x n| and |a.n| of unit vectors below which they count as parallel, and as perpendicular.
constexpr double kParallel = 1e-9;
constexpr double kPerpendicular = 1e-3;

std::vector<StrokeKey> keys(BendStroke& s) {
  auto* const width = std::get_if<BendWidth>(&s.extent);
  auto* const zone = std::get_if<BendThresholds>(&s.extent);
  return {
      {"center", Quantity::finite, &s.center},
      {"axis", Quantity::direction, &s.axis},
      {"normal", Quantity::direction, &s.normal},
      {"angle_deg", Quantity::angle, &s.angle_deg, Presence::required, "rotation of the part that moves"},
      {"width", Quantity::positive, width != nullptr ? &width->width : nullptr, Presence::required,
       "of the zone that bends"},
      {"center_fraction", Quantity::finite, width != nullptr ? &width->center_fraction : nullptr, Presence::optional},
      {"inner", Quantity::other, zone != nullptr ? &zone->inner : nullptr, Presence::required,
       "where the part that moves begins"},
      {"outer", Quantity::other, zone != nullptr ? &zone->outer : nullptr, Presence::required,
       "where the part that stays begins"},
      {"gauge", Quantity::finite, &s.gauge, Presence::optional},
      {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional, "of the barrel"}};
}

void prepare(BendStroke& stroke, const HasKey& has) {
  const bool by_width = has("width") || has("center_fraction");
  const bool by_thresholds = has("inner") || has("outer");
  if (by_width == by_thresholds) {
    throw InvalidInput(std::string(R"(a bend has either "width" (and "center_fraction") or "inner" and "outer", )") +
                       (by_width ? "not both" : "got neither"));
  }
  if (by_thresholds) stroke.extent = BendThresholds{};
}

void validate(const BendStroke& stroke) {
  if (norm(cross(unit(stroke.axis), unit(stroke.normal))) < kParallel) {
    throw InvalidInput("\"normal\" must not be parallel to \"axis\": a bend turns it about the axis");
  }
  const Thresholds<double> thresholds = bend_thresholds(stroke);
  require_thresholds(thresholds.inner, thresholds.outer);
}

bool reads_surface(const BendStroke& stroke) {
  return stroke.radius_auto || std::abs(stroke.angle_deg) > kMostOfPlainBend;
}

Flow flow_of(const BendStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = unit(stroke.normal);
  const double angle = stroke.angle_deg * kRadiansPerDegree;
  const Rotation<double> motion{axis, angle, stroke.gauge, RotationGauge::axial};
  const HalfSpace<double> region{normal, axis, 0.5 * angle};
  Segment segment = resting_segment({stroke.center, motion, region, bend_thresholds(stroke)});
  if (stroke.radius) segment.barrel = SegmentBarrel{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

void warn(const BendStroke& stroke, Warnings& warnings) {
  if (std::abs(dot(unit(stroke.axis), unit(stroke.normal))) > kPerpendicular) {
    warnings.push_back(
        "\"normal\" is not perpendicular to \"axis\", so the bend is skewed; make it perpendicular for a plain bend");
  }
}

}  // namespace

const Tool& BendStroke::tool() {
  static const Tool kTool = describe<BendStroke>("bend", {keys, validate, flow_of, warn, reads_surface, prepare});
  return kTool;
}

}  // namespace knead
