#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

namespace {

// |a x n| and |a.n| of unit vectors below which they count as parallel, and as perpendicular.
constexpr double kParallel = 1e-9;
constexpr double kPerpendicular = 1e-3;

}  // namespace

void validate(const BendStroke& stroke) {
  require_finite("center", stroke.center);
  require_direction("axis", stroke.axis);
  require_direction("normal", stroke.normal);
  if (norm(cross(unit(stroke.axis), unit(stroke.normal))) < kParallel) {
    throw InvalidInput("\"normal\" must not be parallel to \"axis\": a bend turns it about the axis");
  }
  require_angle("angle_deg", stroke.angle_deg);
  if (const auto* extent = std::get_if<BendWidth>(&stroke.extent)) {
    require_positive("width", extent->width);
    require_finite("center_fraction", extent->center_fraction);
  }
  const Thresholds<double> thresholds = bend_thresholds(stroke);
  require_thresholds(thresholds.inner, thresholds.outer);
  require_finite("gauge", stroke.gauge);
  require_radius(stroke.radius, stroke.radius_auto);
}

Thresholds<double> bend_thresholds(const BendStroke& stroke) {
  if (const auto* thresholds = std::get_if<Thresholds<double>>(&stroke.extent)) return *thresholds;
  const auto& extent = std::get<BendWidth>(stroke.extent);
  return {-extent.center_fraction * extent.width, (1 - extent.center_fraction) * extent.width};
}

Flow flow_of(const BendStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = unit(stroke.normal);
  const double angle = stroke.angle_deg * kRadiansPerDegree;
  const Rotation<double> motion{axis, angle, stroke.gauge, RotationGauge::axial};
  const HalfSpace<double> region{normal, axis, 0.5 * angle};
  Segment segment = resting_segment({stroke.center, motion, region, bend_thresholds(stroke)});
  require_known_radius(stroke.radius_auto);
  if (stroke.radius) segment.cylinder = Cylinder{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

void warn(const BendStroke& stroke, Warnings& warnings) {
  if (std::abs(dot(unit(stroke.axis), unit(stroke.normal))) > kPerpendicular) {
    warnings.push_back(
        "\"normal\" is not perpendicular to \"axis\", so the bend is skewed; make it perpendicular for a plain bend");
  }
}

}  // namespace knead::tool_detail
