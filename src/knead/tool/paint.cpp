#include <fmt/format.h>

#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/check.h"
#include "knead/tool/tools.h"

namespace knead::tool_detail {

void validate(const PaintStroke& stroke) {
  require_positive("outer", stroke.outer);
  if (!std::isfinite(stroke.depth) || stroke.depth == 0) {
    throw InvalidInput(fmt::format(
        "\"depth\" must be a number other than 0 (greater pushes in, less pulls out), got {}", stroke.depth));
  }
  require_count("samples", stroke.samples.size(), 1, "samples");
  for (const PaintSample& sample : stroke.samples) {
    require_finite("point", sample.point);
    require_direction("normal", sample.normal);
  }
}

Flow flow_of(const PaintStroke& stroke) {
  Flow flow;
  for (const PaintSample& sample : stroke.samples) {
    const Vec3d displacement = unit(sample.normal) * -stroke.depth;
    flow.segments.push_back(carried_segment(
        {sample.point, Translation<double>{displacement}, Ball<double>{}, {0, stroke.outer}}, displacement));
  }
  return flow;
}

void warn(const PaintStroke& /*stroke*/, Warnings& /*warnings*/) {}

}  // namespace knead::tool_detail
