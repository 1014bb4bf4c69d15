// The tool "twist": turns a part about its length, farther along it by more.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/error.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

double rate_of(const TwistStroke& stroke) {
  return stroke.angle_deg ? *stroke.angle_deg / (stroke.inner - stroke.outer) : stroke.rate_deg;
}

std::vector<StrokeKey> keys(TwistStroke& s) {
  constexpr std::string_view kEither = "a twist without \"angle_deg\"";
  return {{"center", Quantity::finite, &s.center},
          {"axis", Quantity::direction, &s.axis},
          {"rate_deg", Quantity::rate, s.angle_deg ? nullptr : &s.rate_deg, Presence::required,
           "degrees for one unit of length", kEither},
          {"angle_deg", Quantity::angle, s.angle_deg ? &*s.angle_deg : nullptr, Presence::required,
           "from outer to inner", "a twist without \"rate_deg\""},
          {"inner", Quantity::other, &s.inner, Presence::required, kInnerHelp},
          {"outer", Quantity::other, &s.outer, Presence::required, kOuterHelp},
          {"normal", Quantity::direction, &s.normal, Presence::optional},
          {"gauge", Quantity::finite, &s.gauge, Presence::optional},
          {"radius", Quantity::positive, AutoNumber{&s.radius, &s.radius_auto}, Presence::optional,
           "of the limit cylinder"}};
}

void prepare(TwistStroke& stroke, const HasKey& has) {
  if (has("angle_deg") && !has("rate_deg")) stroke.angle_deg = 0;
}

// The rate has the unit of an angle for one of length, so the angle between the thresholds has the limit.
void validate(const TwistStroke& stroke) {
  require_thresholds(stroke.inner, stroke.outer);
  const double degrees = std::abs(rate_of(stroke)) * std::min(1.0, stroke.outer - stroke.inner);
  if (degrees <= kMaxDegrees) return;
  throw InvalidInput(fmt::format(
      "\"rate_deg\" turns by {:g} degrees from \"inner\" to \"outer\"; at most 360000 are possible", degrees));
}

bool reads_surface(const TwistStroke& stroke) { return stroke.radius_auto; }

Flow flow_of(const TwistStroke& stroke) {
  const Vec3d axis = unit(stroke.axis);
  const Vec3d normal = stroke.normal ? unit(*stroke.normal) : axis;
  const Twist<double> motion{axis, rate_of(stroke) * kRadiansPerDegree, stroke.gauge};
  Segment segment = resting_segment({stroke.center, motion, HalfSpace<double>{normal}, {stroke.inner, stroke.outer}});
  if (stroke.radius) segment.limit_cylinder = LimitCylinder{stroke.center, normal, *stroke.radius};
  return {{std::move(segment)}};
}

std::string words(const TwistStroke& stroke, const std::string& /*unit*/) {
  return "Twist " + degrees_text(rate_of(stroke) * (stroke.inner - stroke.outer));
}

void zone(const TwistStroke& stroke, StrokeZone& zone) {
  zone.center = stroke.center;
  zone.normal = unit(stroke.normal.value_or(stroke.axis));
  zone.radius = stroke.radius;
  zone.between = {stroke.inner, stroke.outer, stroke.falloff};
  zone.angle = std::abs(rate_of(stroke)) * kRadiansPerDegree * zone.width();
  zone.degrees = rate_of(stroke);
}

// The angle over the zone stays.
void set_zone(TwistStroke& stroke, const StrokeZone& zone) {
  if (!stroke.angle_deg) stroke.rate_deg *= (stroke.outer - stroke.inner) / zone.width();
  stroke.center = zone.center;
  stroke.inner = zone.between.inner;
  stroke.outer = zone.between.outer;
}

void resolve(const TwistStroke& stroke, SurfaceRun& run) { resolve_radius(stroke, run); }

}  // namespace

constinit const detail::ToolRow<TwistStroke> TwistStroke::tool{.name = "twist",
                                                               .keys = keys,
                                                               .prepare = prepare,
                                                               .validate = validate,
                                                               .reads_surface = reads_surface,
                                                               .resolve = resolve,
                                                               .flow = flow_of,
                                                               .words = words,
                                                               .zone = zone,
                                                               .set_zone = set_zone};

}  // namespace knead
