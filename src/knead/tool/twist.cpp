#include "knead/tool/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(TwistStroke& s) {
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"rate_deg", Quantity::angle, &s.rate_deg, Presence::required, "degrees for one unit of length"},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"normal", Quantity::direction, &s.normal, Presence::optional},
          {"gauge", Quantity::finite, &s.gauge, Presence::optional},
          {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional, "of the barrel"}};
}

void validate(const TwistStroke& stroke) { require_thresholds(stroke.inner, stroke.outer); }

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
