// The tool "implicit": a ball or capsule along a path.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "knead/error.h"
#include "strokes/describe.h"
#include "strokes/suffix.h"

namespace knead {

namespace {

using namespace detail;

std::vector<StrokeKey> keys(ImplicitStroke& s) {
  constexpr std::string_view kCapsule = R"("region": "capsule")";
  const bool capsule = s.region == ImplicitRegion::capsule;
  const bool wide = s.falloff == kWideFalloff;
  return {{"path", Quantity::finite, &s.path},
          {"inner", Quantity::positive, wide ? nullptr : &s.inner, Presence::required, kInnerHelp, kNotWide},
          {"outer", wide ? Quantity::other : Quantity::outer, &s.outer, wide ? Presence::optional : Presence::required,
           kOuterHelp},
          {"bump", Quantity::positive, wide ? &s.bump : nullptr, Presence::required, kBumpHelp, kWide},
          {"core", Quantity::other, wide ? &s.core : nullptr, Presence::optional, {}, kWide},
          {"region", Quantity::other, choice(s.region, {"ball", "capsule"}), Presence::optional},
          {"half_axis", Quantity::direction, capsule ? &s.half_axis : nullptr, Presence::required, {}, kCapsule},
          {"gauge", Quantity::finite, capsule ? &s.gauge : nullptr, Presence::optional, {}, kCapsule},
          {"time", Quantity::other, choice(s.time, {"swept", "blended"}), Presence::optional},
          {"taper", Quantity::other, &s.taper, Presence::optional, "how much thinner the tool is at the path's end"}};
}

void validate(const ImplicitStroke& stroke) {
  require_count("path", stroke.path.size(), 2, "points");
  if (stroke.falloff == kWideFalloff) {
    require_wide_thresholds(thresholds_of(stroke));
    if (stroke.region != ImplicitRegion::ball) {
      throw InvalidInput(R"("falloff": "wide" needs "region": "ball")");
    }
  } else {
    require_distance_thresholds(stroke.inner, stroke.outer);
  }
  if (!(stroke.taper >= 0 && stroke.taper <= 1)) {
    throw InvalidInput(fmt::format("\"taper\" must be a number from 0 to 1, got {}", stroke.taper));
  }
  if (stroke.time == TimeLaw::pinned) throw InvalidInput("\"time\" must be \"swept\" or \"blended\"");
  if (stroke.region == ImplicitRegion::ball && (stroke.half_axis != Vec3d{0, 0, 0} || stroke.gauge != 0)) {
    throw InvalidInput("\"half_axis\" and \"gauge\" belong to \"region\": \"capsule\" only");
  }
}

constexpr double kTaperStep = 0.9;      // of the radii of a segment to those of the one before
constexpr double kMinTaper = 0.05;      // of the radii to those at the path's beginning
constexpr std::size_t kTaperCuts = 29;  // about so many segments from 1 to kMinTaper

// Moves the tool from one place to another, its radii multiplied by the factor.
Segment segment_of(const ImplicitStroke& stroke, const Vec3d& from, const Vec3d& to, double factor) {
  const Vec3d displacement = to - from;
  const auto [inner, outer, falloff, bump] = thresholds_of(stroke);
  Field field{from,
              Translation<double>{displacement},
              Ball<double>{},
              {inner * factor, outer * factor, falloff, bump * factor}};
  if (stroke.region == ImplicitRegion::capsule) {
    field.motion = Translation<double>{displacement, unit(stroke.half_axis), stroke.gauge};
    field.region = Capsule<double>{stroke.half_axis};
  }
  return transported_segment(std::move(field), displacement, stroke.time);
}

// Cuts a piece along which the radii fall from the factor `first` to `last`. Each segment has the factor of its middle.
void add_tapered(const ImplicitStroke& stroke, const Vec3d& from, const Vec3d& to, double first, double last,
                 Flow& flow) {
  Vec3d at = from;
  double factor = first;
  while (true) {
    const double next = factor > kMinTaper ? std::max(kTaperStep * factor, last) : last;
    const Vec3d end = next == last ? to : from + (to - from) * ((first - next) / (first - last));
    flow.segments.push_back(segment_of(stroke, at, end, std::max(0.5 * (factor + next), kMinTaper)));
    if (next == last) return;
    at = end;
    factor = next;
  }
}

Flow flow_of(const ImplicitStroke& stroke) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) length += norm(stroke.path[i + 1] - stroke.path[i]);
  Flow flow;
  double passed = 0;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
    const Vec3d& from = stroke.path[i];
    const Vec3d& to = stroke.path[i + 1];
    if (from == to) continue;
    const double first = 1 - stroke.taper * (passed / length);
    passed = std::min(passed + norm(to - from), length);
    if (stroke.taper == 0) {
      flow.segments.push_back(segment_of(stroke, from, to, 1));
    } else {
      add_tapered(stroke, from, to, first, 1 - stroke.taper * (passed / length), flow);
    }
  }
  return flow;
}

void warn(const ImplicitStroke& stroke, Warnings& warnings) { warn_of_thin_shell(thresholds_of(stroke), warnings); }

// A tapered path ends at its tip.
void prolong(ImplicitStroke& stroke, double strength) {
  if (stroke.taper == 0) prolong_path(stroke.path, strength);
}

std::string words(const ImplicitStroke& stroke, const std::string& unit) {
  const char* const verb = stroke.falloff != kWideFalloff ? "Pull " : stroke.taper > 0 ? "Snakehook " : "Move ";
  return verb + length_text(norm(stroke.path.back() - stroke.path.front()), unit);
}

using PulledPath = Growing<ImplicitStroke, &ImplicitStroke::path, 1>;

// Another end of a tapered path changes the radii of all its segments.
std::size_t segments(const ImplicitStroke& stroke, const Mesh* mesh) {
  return PulledPath::segments(stroke, mesh) + (stroke.taper == 0 ? 0 : kTaperCuts);
}

bool grows(const ImplicitStroke& before, const ImplicitStroke& now) {
  return now.taper == 0 && PulledPath::grows(before, now);
}

bool continues(const ImplicitStroke& last, const ImplicitStroke& next) {
  return next.taper == 0 && PulledPath::continues(last, next);
}

std::vector<Stroke> pieces(const ImplicitStroke& stroke) {
  return stroke.taper == 0 ? PulledPath::pieces(stroke) : std::vector<Stroke>{stroke};
}

}  // namespace

constinit const detail::ToolRow<ImplicitStroke> ImplicitStroke::tool{.name = "implicit",
                                                                     .keys = keys,
                                                                     .validate = validate,
                                                                     .flow = flow_of,
                                                                     .segments = segments,
                                                                     .warn = warn,
                                                                     .words = words,
                                                                     .prolong = prolong,
                                                                     .path = &ImplicitStroke::path,
                                                                     .grows = grows,
                                                                     .rest = PulledPath::rest,
                                                                     .continues = continues,
                                                                     .join = PulledPath::join,
                                                                     .pieces = pieces};

}  // namespace knead
