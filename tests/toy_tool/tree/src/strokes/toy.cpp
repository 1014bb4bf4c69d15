// A toy tool: pushes a ball once.
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(ToyStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"push", Quantity::direction, &s.push},
          {"outer", Quantity::outer, &s.outer, Presence::required, kOuterHelp},
          {"sharpness", Quantity::other, &s.sharpness, Presence::optional, "inner over outer radius"}};
}

void validate(const ToyStroke& stroke) { require_distance_thresholds(stroke.sharpness * stroke.outer, stroke.outer); }

Flow flow_of(const ToyStroke& stroke) {
  const Thresholds<double> thresholds{stroke.sharpness * stroke.outer, stroke.outer};
  return {{transported_segment({stroke.center, Translation<double>{stroke.push}, Ball<double>{}, thresholds},
                               stroke.push)}};
}

}  // namespace

constinit const detail::ToolRow<ToyStroke> ToyStroke::tool{
    .name = "toy", .keys = keys, .validate = validate, .flow = flow_of};

}  // namespace knead
