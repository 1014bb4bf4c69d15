// The zones of bends and twists, and the widths that a shape needs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>
#include "math/elementary.h"

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/vec.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

constexpr std::size_t kSlices = 256;
// Widths of a bend over angle times extent (method, section 10): at the first it stretches about 2 times, at the second
// 3 times.
constexpr double kSafeWidth = 2.4;
constexpr double kMinWidth = 1.6;
// A twist with this shear stretches 2 times, as a bend of kSafeWidth does.
constexpr double kSafeShear = 1.5;
// A part as wide along the axis of its bend as this many times its thickness is stretched least with gauge 0, one as
// wide as thick with gauge 1, and between the two with a gauge between them.
constexpr double kWidthOfZeroGauge = 4;
// A gauge this much above that deserves a warning, in a zone up to this multiple of the safe width.
constexpr double kFarGauge = 0.5;
constexpr double kWideZone = 2;
constexpr int kMaxRounds = 64;  // of widening; each takes in at least one slice

// Returns the greatest slope of the motion, divided by angle / width: in a bend that of w, in a twist that of r w.
double steepness(const StrokeZone& zone, int falloff) {
  if (zone.bends()) return falloff_facts(falloff).slope;
  constexpr int kSamplesOfZone = 256;
  double most = 0;
  for (int i = 0; i <= kSamplesOfZone; ++i) {
    const double r = zone.between.inner + zone.width() * i / kSamplesOfZone;
    const Weight<double> w = blend_weight(r, Thresholds<double>{zone.between.inner, zone.between.outer, falloff});
    most = std::max(most, std::abs(w.value + r * w.derivative));
  }
  return most;
}

// Returns the angle over the zone that stretches as much with the default falloff; the constants above are for that.
double default_angle(const StrokeZone& zone) {
  return zone.angle * steepness(zone, zone.between.falloff) / steepness(zone, kDefaultFalloff);
}

// A point in the coordinates of a profile.
struct ZonePlace {
  double r = 0;
  double distance = 0;  // as the profile counts it
  double along = 0;     // the axis of a bend
  double from_line = 0;
};

ZonePlace place_of(const ZoneProfile& profile, const Vec3d& p) {
  const Vec3d d = p - profile.center;
  const double r = dot(profile.normal, d);
  const double from_line = norm(d - profile.normal * r);
  if (profile.side == Vec3d{0, 0, 0}) return {r, from_line, 0, from_line};
  return {r, std::abs(dot(profile.side, d)), std::abs(dot(cross(profile.side, profile.normal), d)), from_line};
}

bool counts(const ZoneProfile& profile, const ZonePlace& place) {
  return !profile.radius || place.from_line <= *profile.radius;
}

void add(ZoneProfile& profile, const ZonePlace& place) {
  if (!counts(profile, place)) return;
  const double slice = (place.r - profile.first) / profile.height;
  const auto last = static_cast<double>(profile.extents.size() - 1);
  const auto i = static_cast<std::size_t>(std::clamp(slice, 0.0, last));
  profile.extents[i] = std::max(profile.extents[i], place.distance);
  profile.along[i] = std::max(profile.along[i], place.along);
}

// Adds an edge where it goes from slice to slice, unless its ends are in neighbouring slices: they are added as points.
void add_edge(ZoneProfile& profile, const Vec3d& a, const Vec3d& b) {
  const double from = dot(profile.normal, a - profile.center);
  const double to = dot(profile.normal, b - profile.center);
  if (from > to) return add_edge(profile, b, a);
  if (to - from <= profile.height) return;
  const double first = std::floor((from - profile.first) / profile.height) + 1;
  for (double slice = first; profile.first + slice * profile.height < to; ++slice) {
    const double r = profile.first + slice * profile.height;
    ZonePlace place = place_of(profile, a + (b - a) * ((r - from) / (to - from)));
    for (const double here : {r - 0.5 * profile.height, r + 0.5 * profile.height}) {
      place.r = here;
      add(profile, place);
    }
  }
}

// The greatest distances of a part of a shape.
struct Reach {
  double distance = 0;
  double along = 0;
};

// Returns those of the parts between two heights, also of those that come there while a bend's zone turns.
Reach reach_within(const ZoneProfile& profile, double inner, double outer, double turn) {
  Reach most;
  for (std::size_t i = 0; i < profile.extents.size(); ++i) {
    const double extent = profile.extents[i];
    const double begin = profile.first + static_cast<double>(i) * profile.height;
    if (begin > outer + extent * turn || begin + profile.height < inner - extent * turn) continue;
    most.distance = std::max(most.distance, extent);
    most.along = std::max(most.along, profile.along[i]);
  }
  return most;
}

// Against the zone the regions turn by half the angle.
double turn_of(const StrokeZone& zone) {
  return zone.bends() ? sincos(std::min(0.5 * zone.angle, 0.5 * std::numbers::pi)).sin : 0;
}

Reach reach_of(const StrokeZone& zone, const ZoneProfile& profile) {
  // A twist shears its whole inner region.
  const double inner = zone.bends() ? zone.between.inner : -kInfinity;
  const double shift = dot(zone.normal, zone.center - profile.center);
  return reach_within(profile, inner + shift, zone.between.outer + shift, turn_of(zone));
}

// To two digits, which is enough and short in a session.
double gauge_of(const Reach& reach) {
  if (!(reach.distance > 0)) return 1;
  const double gauge = (kWidthOfZeroGauge - reach.along / reach.distance) / (kWidthOfZeroGauge - 1);
  return std::round(100 * std::clamp(gauge, 0.0, 1.0)) / 100;
}

double safe_width(const StrokeZone& zone, double extent) {
  return zone.bends() ? kSafeWidth * default_angle(zone) * extent : default_angle(zone) * extent / kSafeShear;
}

// The same zone with another width.
StrokeZone widened(const StrokeZone& zone, double width) {
  StrokeZone wider = zone;
  const double factor = width / zone.width();
  wider.between = {zone.between.inner * factor, zone.between.outer * factor, zone.between.falloff};
  if (zone.radius) wider.center += zone.normal * (zone.between.outer - wider.between.outer);
  return wider;
}

// Widening includes more of the shape, which may be wider there; it ends at the end of the shape.
StrokeZone with_safe_width(StrokeZone zone, const ZoneProfile& profile) {
  for (int round = 0; round < kMaxRounds; ++round) {
    const double width = safe_width(zone, reach_of(zone, profile).distance);
    if (width <= zone.width() * (1 + 1e-12)) break;
    zone = widened(zone, width);
  }
  return zone;
}

bool fits(const StrokeZone& zone, const ZoneProfile& profile) {
  if (profile.extents.empty() || !(norm(zone.normal - profile.normal) < 1e-9)) return false;
  if (!(norm(zone.side - profile.side) < 1e-9) || zone.radius != profile.radius) return false;
  const Vec3d d = zone.center - profile.center;
  return norm(d - zone.normal * dot(zone.normal, d)) <= 1e-9 * (profile.height * static_cast<double>(kSlices));
}

double stretch_of_shear(double gamma) { return 0.5 * gamma + std::sqrt(1 + 0.25 * gamma * gamma); }

// Returns the `outer` of a stroke if it is a distance from its tool; else null.
double* outer_of(Stroke& stroke) {
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    if (key.quantity == Quantity::outer) return std::get<double*>(key.value);
  }
  return nullptr;
}

std::vector<Vec3d> resting(const Stroke& stroke, std::span<const Vec3d> points, int threads) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  if (points.empty() || !(box.diagonal() > 0)) return {};
  std::vector<Vec3d> moved(points.begin(), points.end());
  AdvectOptions options;
  options.tolerance = absolute_tolerance(kDefaultRelativeTolerance, box.diagonal());
  options.threads = threads;
  if (advect(flow_of(stroke), moved, options).status != AdvectStatus::done) return {};
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (moved[i] == points[i]) result.push_back(points[i]);
  }
  return result;
}

bool misses_all(const Stroke& stroke, std::span<const Vec3d> points, int threads) {
  const FlowSupport support(flow_of(stroke));
  std::atomic<bool> misses{true};
  parallel_for(points.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && misses; ++i) {
      if (support.may_move(points[i], 0)) misses = false;
    }
  });
  return misses;
}

}  // namespace

double detail::rounded_down(double x) {
  if (!(x > 0)) return 0;
  const double scale = elementary::power_of_ten(2 - elementary::decimal_exponent(x));
  return scale >= 1 ? std::floor(x * scale) / scale : std::floor(x * scale) * std::round(1 / scale);
}

std::optional<StrokeZone> detail::zone_of(const Stroke& stroke) {
  return with_row(stroke, [](const auto& row, const auto& own) -> std::optional<StrokeZone> {
    if (row.zone == nullptr) return std::nullopt;
    StrokeZone zone;
    row.zone(own, zone);
    return zone;
  });
}

ZoneProfile zone_profile(const Stroke& stroke, std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  check_triangles(triangles, positions);
  const std::optional<StrokeZone> zone = zone_of(stroke);
  if (!zone || positions.empty()) return {};
  ZoneProfile profile{zone->center, zone->normal, zone->side, zone->radius};
  double least = kInfinity;
  double most = -least;
  for (const Vec3d& p : positions) {
    const ZonePlace place = place_of(profile, p);
    if (!counts(profile, place)) continue;
    least = std::min(least, place.r);
    most = std::max(most, place.r);
  }
  if (!(most > least)) return {};
  profile.first = least;
  profile.height = (most - least) / static_cast<double>(kSlices);
  profile.extents.assign(kSlices, -1);
  profile.along.assign(kSlices, 0);
  for (const Vec3d& p : positions) add(profile, place_of(profile, p));
  for (const auto& [a, b, c] : triangles) {
    add_edge(profile, positions[a], positions[b]);
    add_edge(profile, positions[b], positions[c]);
    add_edge(profile, positions[c], positions[a]);
  }
  return profile;
}

std::optional<ZoneCheck> check_zone(const Stroke& stroke, const ZoneProfile& profile) {
  const std::optional<StrokeZone> zone = zone_of(stroke);
  if (!zone || !fits(*zone, profile)) return std::nullopt;
  ZoneCheck check;
  check.width = zone->width();
  check.extent = reach_of(*zone, profile).distance;
  const StrokeZone safe = with_safe_width(*zone, profile);
  check.safe = safe.width();
  if (zone->bends()) {
    check.gauge = gauge_of(reach_of(safe, profile));
    check.is_too_thin = check.width < kMinWidth * default_angle(*zone) * check.extent;
  } else {
    check.stretch = stretch_of_shear(default_angle(*zone) / check.width * check.extent);
    check.is_too_thin = check.stretch > kStrongStretch;
  }
  return check;
}

Stroke with_safe_zone(const Stroke& stroke, const ZoneProfile& profile) {
  const std::optional<StrokeZone> zone = zone_of(stroke);
  if (!zone || !fits(*zone, profile)) return stroke;
  StrokeZone safe = with_safe_width(*zone, profile);
  if (zone->bends() && zone->gauge == 1) safe.gauge = gauge_of(reach_of(safe, profile));
  if (safe.width() == zone->width() && safe.gauge == zone->gauge) return stroke;
  Stroke result = stroke;
  with_row(result, [&](const auto& row, auto& own) { row.set_zone(own, safe); });
  return result;
}

double most_turn_of_an_edge_deg(const Stroke& stroke, std::span<const Vec3d> positions,
                                std::span<const Triangle> triangles) {
  const std::optional<StrokeZone> zone = zone_of(stroke);
  if (!zone || !(zone->width() > 0)) return 0;
  const auto height = [&](const Vec3d& p) {
    const Vec3d d = p - zone->center;
    const double r = dot(d, zone->normal);
    const bool is_within = !zone->radius || norm2(d - zone->normal * r) <= *zone->radius * *zone->radius;
    return is_within ? std::clamp(r, zone->between.inner, zone->between.outer)
                     : std::numeric_limits<double>::quiet_NaN();
  };
  double most = 0;
  for (const Triangle& t : triangles) {
    const std::array<double, 3> heights{height(positions[t[0]]), height(positions[t[1]]), height(positions[t[2]])};
    for (std::size_t k = 0; k < 3; ++k) {
      const double reach = std::abs(heights[k] - heights[(k + 1) % 3]);
      if (reach > most) most = reach;  // false for NaN
    }
  }
  return zone->angle * most / zone->width() / kRadiansPerDegree;
}

std::optional<std::string> zone_warning(const Stroke& stroke, const ZoneProfile& profile) {
  const std::optional<ZoneCheck> check = check_zone(stroke, profile);
  if (!check) return std::nullopt;
  const StrokeZone zone = *zone_of(stroke);
  if (!check->is_too_thin) {
    const bool is_far = zone.bends() && zone.gauge - check->gauge > kFarGauge;
    if (!is_far || check->width > kWideZone * safe_width(zone, check->extent)) return std::nullopt;
    return fmt::format(
        "a \"gauge\" of {:.3g} stretches a part so wide along the axis of the bend far at its sides; use {:.3g}",
        zone.gauge, check->gauge);
  }
  const double degrees = zone.degrees;
  if (check->stretch > 0) {
    return fmt::format(
        "the twist stretches a part that reaches {:.3g} from its line about {:.2g} times; use a \"rate_deg\" of {:.3g} "
        "or less",
        check->extent, check->stretch, std::abs(degrees) * check->width / check->safe);
  }
  return fmt::format(
      "the zone of the bend is {:.3g} wide, too thin for {:.4g} degrees and a part that reaches {:.3g} from its axis: "
      "the part is stretched more than 3 times and may become a sheet; make the zone {:.3g} wide or wider, or bend "
      "less",
      check->width, degrees, check->extent, check->safe);
}

std::optional<double> widest_outer(const Stroke& stroke, std::span<const Vec3d> boundary, int threads) {
  constexpr double least_gain = 1.05;
  constexpr int most_doublings = 40;
  constexpr int halvings = 12;
  Stroke wider = stroke;
  double* const outer = outer_of(wider);
  if (outer == nullptr) return std::nullopt;
  const double now = *outer;
  const std::vector<Vec3d> rest = resting(stroke, boundary, threads);
  const auto fits = [&](double tried) {
    *outer = tried;
    return misses_all(wider, rest, threads);
  };
  if (rest.empty() || !fits(least_gain * now)) return std::nullopt;
  double good = least_gain * now;
  double bad = 2 * now;
  for (int i = 0; i < most_doublings && fits(bad); ++i) {
    good = bad;
    bad *= 2;
  }
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (good + bad);
    (fits(middle) ? good : bad) = middle;
  }
  const double result = rounded_down(good);
  return result < least_gain * now ? std::nullopt : std::optional(result);
}

}  // namespace knead
