#include <cmath>

#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

void validate(const StretchStroke& stroke) {
  require_finite("center", stroke.center);
  require_direction("axis", stroke.axis);
  require_factor("factor", stroke.factor);
  require_distance_thresholds(stroke.inner, stroke.outer);
}

// ln(factor) (a a^T - (I - a a^T) / 2)
Flow flow_of(const StretchStroke& stroke) {
  const Vec3d a = unit(stroke.axis);
  const Mat3d shape = outer_product(a, a) * 1.5 + Mat3d{} * -0.5;
  const Strain<double> motion{shape * std::log(stroke.factor)};
  return {{resting_segment({stroke.center, motion, Ball<double>{}, {stroke.inner, stroke.outer}})}};
}

void warn(const StretchStroke& stroke, Warnings& warnings) { warn_of_thin_shell(stroke.inner, stroke.outer, warnings); }

}  // namespace knead::tool_detail
