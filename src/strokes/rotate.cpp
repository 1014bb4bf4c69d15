// The tool "rotate": turns a ball about its centre.
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(RotateStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"angle_deg", Quantity::angle, &s.angle_deg, Presence::required, "rotation of the inner region"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::outer, &s.outer, Presence::required, kOuterHelp},
          {"gauge", Quantity::finite, &s.gauge, Presence::optional}};
}

void validate(const RotateStroke& stroke) { require_distance_thresholds(stroke.inner, stroke.outer); }

Flow flow_of(const RotateStroke& stroke) {
  const Rotation<double> motion{unit(stroke.axis), stroke.angle_deg * kRadiansPerDegree, stroke.gauge,
                                RotationGauge::radial};
  return {{resting_segment({stroke.center, motion, Ball<double>{}, {stroke.inner, stroke.outer}})}};
}

// With gauge 0 nothing turns back.
void warn(const RotateStroke& stroke, Warnings& warnings) {
  if (stroke.gauge != 0) warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

std::string words(const RotateStroke& stroke, const std::string& /*unit*/) {
  return "Rotate " + degrees_text(stroke.angle_deg);
}

}  // namespace

constinit const detail::ToolRow<RotateStroke> RotateStroke::tool{
    .name = "rotate", .keys = keys, .validate = validate, .flow = flow_of, .warn = warn, .words = words};

}  // namespace knead
