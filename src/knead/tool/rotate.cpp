#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

void validate(const RotateStroke& stroke) {
  require_finite("center", stroke.center);
  require_direction("axis", stroke.axis);
  require_angle("angle_deg", stroke.angle_deg);
  require_distance_thresholds(stroke.inner, stroke.outer);
  require_finite("gauge", stroke.gauge);
}

Flow flow_of(const RotateStroke& stroke) {
  const Rotation<double> motion{unit(stroke.axis), stroke.angle_deg * kRadiansPerDegree, stroke.gauge,
                                RotationGauge::radial};
  return {{resting_segment({stroke.center, motion, Ball<double>{}, {stroke.inner, stroke.outer}})}};
}

// With gauge 0 nothing turns back.
void warn(const RotateStroke& stroke, Warnings& warnings) {
  if (stroke.gauge != 0) warn_of_thin_shell(stroke.inner, stroke.outer, warnings);
}

}  // namespace knead::tool_detail
