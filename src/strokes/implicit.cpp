// The tool "implicit": a ball or capsule along a path.
#include "knead/error.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"

namespace knead {

namespace {

using namespace tool_detail;

std::vector<StrokeKey> keys(ImplicitStroke& s) {
  constexpr std::string_view kCapsule = R"("region": "capsule")";
  const bool capsule = s.region == ImplicitRegion::capsule;
  return {{"path", Quantity::finite, &s.path},
          {"inner", Quantity::positive, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::outer, &s.outer, Presence::required, kOuterHelp},
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
    flow.segments.push_back(transported_segment(std::move(field), displacement, stroke.time));
  }
  return flow;
}

void warn(const ImplicitStroke& stroke, Warnings& warnings) {
  warn_of_thin_shell({stroke.inner, stroke.outer, stroke.falloff}, warnings);
}

void prolong(ImplicitStroke& stroke, double strength) { prolong_path(stroke.path, strength); }

std::string words(const ImplicitStroke& stroke, const std::string& unit) {
  return "Pull " + length_text(norm(stroke.path.back() - stroke.path.front()), unit);
}

using PulledPath = Growing<ImplicitStroke, &ImplicitStroke::path, 1>;

}  // namespace

constinit const tool_detail::ToolRow<ImplicitStroke> ImplicitStroke::tool{.name = "implicit",
                                                                          .keys = keys,
                                                                          .validate = validate,
                                                                          .flow = flow_of,
                                                                          .segments = PulledPath::segments,
                                                                          .warn = warn,
                                                                          .words = words,
                                                                          .prolong = prolong,
                                                                          .path = &ImplicitStroke::path,
                                                                          .grows = PulledPath::grows,
                                                                          .rest = PulledPath::rest,
                                                                          .continues = PulledPath::continues,
                                                                          .join = PulledPath::join,
                                                                          .pieces = PulledPath::pieces};

}  // namespace knead
