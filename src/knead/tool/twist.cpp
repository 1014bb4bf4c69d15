#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

void validate(const TwistStroke& stroke) {
  require_finite("center", stroke.center);
  require_direction("axis", stroke.axis);
  require_angle("rate_deg", stroke.rate_deg);
  require_thresholds(stroke.inner, stroke.outer);
  if (stroke.normal) require_direction("normal", *stroke.normal);
  require_finite("gauge", stroke.gauge);
  require_radius(stroke.radius, stroke.radius_auto);
}

Flow flow_of(const TwistStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = stroke.normal ? unit(*stroke.normal) : axis;
  const Twist<double> motion{axis, stroke.rate_deg * kRadiansPerDegree, stroke.gauge};
  Segment segment = resting_segment({stroke.center, motion, HalfSpace<double>{normal}, {stroke.inner, stroke.outer}});
  require_known_radius(stroke.radius_auto);
  if (stroke.radius) segment.cylinder = Cylinder{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

void warn(const TwistStroke& /*stroke*/, Warnings& /*warnings*/) {}

}  // namespace knead::tool_detail
