// The tool "stretch": makes a ball longer along an axis and thinner across it.
#include <fmt/format.h>

#include "math/elementary.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(StretchStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"factor", Quantity::other, &s.factor, Presence::required, "longer along the axis; below 1 shorter"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::outer, &s.outer, Presence::required, kOuterHelp}};
}

void validate(const StretchStroke& stroke) {
  require_factor("factor", stroke.factor);
  require_distance_thresholds(stroke.inner, stroke.outer);
}

// ln(factor) (a a^T - (I - a a^T) / 2)
Flow flow_of(const StretchStroke& stroke) {
  const Vec3d a = unit(stroke.axis);
  const Mat3d shape = outer_product(a, a) * 1.5 + Mat3d{} * -0.5;
  const Strain<double> motion{shape * elementary::log(stroke.factor)};
  return {{resting_segment({stroke.center, motion, Ball<double>{}, {stroke.inner, stroke.outer}})}};
}

void warn(const StretchStroke& stroke, Warnings& warnings) {
  warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

void prolong(StretchStroke& stroke, double strength) { stroke.factor = elementary::pow(stroke.factor, strength); }

std::string words(const StretchStroke& stroke, const std::string& /*unit*/) {
  return fmt::format("Stretch {:+.1f}%", 100 * (stroke.factor - 1));
}

}  // namespace

constinit const detail::ToolRow<StretchStroke> StretchStroke::tool{.name = "stretch",
                                                                   .keys = keys,
                                                                   .validate = validate,
                                                                   .flow = flow_of,
                                                                   .warn = warn,
                                                                   .words = words,
                                                                   .prolong = prolong};

}  // namespace knead
