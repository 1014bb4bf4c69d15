#include "knead/flow/advect.h"

#include "knead/flow/advect_segment.h"
#include "knead/math/error.h"

namespace knead {

AdvectResult& AdvectResult::operator+=(const AdvectResult& other) {
  if (status == AdvectStatus::done) status = other.status;
  accepted_steps += other.accepted_steps;
  rejected_steps += other.rejected_steps;
  evaluations += other.evaluations;
  return *this;
}

AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
  validate(flow);
  if (!(options.tolerance > 0)) throw InvalidInput("the tolerance must be a positive length");
  if (!options.steps.empty() && options.steps.size() != points.size()) {
    throw InvalidInput("steps must be empty or hold one number per point");
  }
  AdvectResult result;
  for (const Segment& segment : flow.segments) {
    result += options.precision == Precision::float32 ? detail::advect_segment<float>(segment, points, options)
                                                      : detail::advect_segment<double>(segment, points, options);
    if (result.status != AdvectStatus::done) break;
  }
  return result;
}

}  // namespace knead
