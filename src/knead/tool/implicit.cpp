#include <cmath>

#include "knead/math/error.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(ImplicitStroke& s) {
  constexpr std::string_view kCapsule = R"("region": "capsule")";
  const bool capsule = s.region == ImplicitRegion::capsule;
  return {{"path", Quantity::finite, &s.path},
          {"inner", Quantity::positive, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"region", Quantity::other, choice(s.region, {"ball", "capsule"}), Presence::optional},
          {"half_axis", Quantity::direction, capsule ? &s.half_axis : nullptr, Presence::required, {}, kCapsule},
          {"gauge", Quantity::finite, capsule ? &s.gauge : nullptr, Presence::optional, {}, kCapsule},
          {"time", Quantity::other, choice(s.time, {"swept", "blended"}), Presence::optional}};
}

void validate(const ImplicitStroke& stroke) {
  require_count("path", stroke.path.size(), 2, "points");
  require_distance_thresholds(stroke.inner, stroke.outer);
  if (stroke.time == TimeLaw::pinned) throw InvalidInput("\"time\" must be \"swept\" or \"blended\"");
  if (stroke.region == ImplicitRegion::ball && (stroke.half_axis != Vec3d{0, 0, 0} || stroke.gauge != 0)) {
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
  warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

void prolong(ImplicitStroke& stroke, double strength) { prolong_path(stroke.path, strength); }

}  // namespace

const Tool& ImplicitStroke::tool() {
  static const Tool kTool =
      describe<ImplicitStroke>("implicit", {keys, validate, flow_of, warn, nullptr, nullptr, prolong});
  return kTool;
}

}  // namespace knead
