#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

void validate(const ImplicitStroke& stroke) {
  require_count("path", stroke.path.size(), 2, "points");
  require_finite("path", stroke.path);
  require_positive("inner", stroke.inner);
  require_distance_thresholds(stroke.inner, stroke.outer);
  require_finite("gauge", stroke.gauge);
  if (stroke.region == ImplicitRegion::capsule) {
    require_direction("half_axis", stroke.half_axis);
  } else if (stroke.half_axis != Vec3d{0, 0, 0} || stroke.gauge != 0) {
    throw InvalidInput("\"half_axis\" and \"gauge\" belong to \"region\": \"capsule\" only");
  }
}

Flow flow_of(const ImplicitStroke& stroke) {
  const bool capsule = stroke.region == ImplicitRegion::capsule;
  Flow flow;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
    const Vec3d displacement = stroke.path[i + 1] - stroke.path[i];
    if (displacement == Vec3d{0, 0, 0}) continue;
    Field field{stroke.path[i], Translation<double>{displacement}, Ball<double>{}, {stroke.inner, stroke.outer}};
    if (capsule) {
      field.motion = Translation<double>{displacement, unit(stroke.half_axis), stroke.gauge};
      field.region = Capsule<double>{stroke.half_axis};
    }
    flow.segments.push_back(carried_segment(std::move(field), displacement, stroke.time));
  }
  return flow;
}

void warn(const ImplicitStroke& stroke, Warnings& warnings) {
  warn_of_thin_shell(stroke.inner, stroke.outer, warnings);
}

}  // namespace knead::tool_detail
