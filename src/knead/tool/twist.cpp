#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(TwistStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"rate_deg", Quantity::rate, &s.rate_deg, Presence::required, "degrees for one unit of length"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"normal", Quantity::direction, &s.normal, Presence::optional},
          {"gauge", Quantity::finite, &s.gauge, Presence::optional},
          {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional, "of the barrel"}};
}

// The rate has the unit of an angle for one of length, so the angle between the thresholds has the limit.
void validate(const TwistStroke& stroke) {
  require_thresholds(stroke.inner, stroke.outer);
  const double degrees = std::abs(stroke.rate_deg) * std::min(1.0, stroke.outer - stroke.inner);
  if (degrees <= kMostDegrees) return;
  throw InvalidInput(fmt::format(
      "\"rate_deg\" turns by {:g} degrees from \"inner\" to \"outer\"; at most 360000 are possible", degrees));
}

bool reads_surface(const TwistStroke& stroke) { return stroke.radius_auto; }

Flow flow_of(const TwistStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = stroke.normal ? unit(*stroke.normal) : axis;
  const Twist<double> motion{axis, stroke.rate_deg * kRadiansPerDegree, stroke.gauge};
  Segment segment = resting_segment({stroke.center, motion, HalfSpace<double>{normal}, {stroke.inner, stroke.outer}});
  if (stroke.radius) segment.barrel = SegmentBarrel{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

}  // namespace

const Tool& TwistStroke::tool() {
  static const Tool kTool = describe<TwistStroke>("twist", {keys, validate, flow_of, nullptr, reads_surface});
  return kTool;
}

}  // namespace knead
