// Kernels of fields: v, the limits of steps, and the classification of points by closed forms and times of arrival.
// Internal: part of the one source of all kernels.
#pragma once

#include <limits>

#include "field/point_sums.h"
#include "flow/kernels/kernel.h"
#include "flow/kernels/kernel_velocity.h"
#include "flow/kernels/pack.h"
#include "flow/step_rule.h"
#include "knead/field.h"

namespace knead::detail {

// S^(-1/m), as inverse_root of one number (knead/region.h); every lane stops on its own.
template <class P>
requires requires { typename P::Mask; }
KNEAD_INLINE P inverse_root(const P& sum, int m) {
  P y = P(1) / sum;
  int q = 1;
  for (; 2 * q <= m; q *= 2) y = sqrt(y);
  if (q == m) return y;
  y = select(sum < P(1), sqrt(y), y);
  const P inverse(1.0 / m);
  for (int i = 0; i < 64; ++i) {
    const P next = mul_add(y * neg_mul_add(sum, integer_power(y, m), P(1)), inverse, y);
    const auto rises = next > y;
    if (bits(rises) == 0) break;
    y = select(rises, next, y);
  }
  return y;
}

template <class P, class S>
KNEAD_INLINE Vec3<P> offset_from(const SetPoints<S>& set, int i, const Vec3<P>& d) {
  return Vec3<P>(d.x - P(set.numbers[i]), d.y - P(set.numbers[set.count + i]), d.z - P(set.numbers[2 * set.count + i]));
}

template <class P, class S>
KNEAD_INLINE PowerSums<P> power_sums(const SetPoints<S>& set, const Vec3<P>& d, const P& scale2) {
  PowerSums<P> sums;
  sums.value = P(0);
  sums.gradient = {P(0), P(0), P(0)};
  for (int i = 0; i < set.count; ++i) {
    const Vec3<P> offset = offset_from(set, i, d);
    const P ratio = scale2 / norm2(offset);
    const P term = integer_power(ratio, set.exponent / 2);
    sums.value = sums.value + term;
    sums.gradient = mul_add(offset, term * ratio, sums.gradient);
  }
  return sums;
}

template <class P, class S>
KNEAD_INLINE RegionValue<P> region_of(const SetPoints<S>& set, const PowerSums<P>& sums, const P& scale) {
  const P root = inverse_root(sums.value, set.exponent);
  return {scale * root, sums.gradient * (root / (sums.value * scale))};
}

// r and grad r in the unit of the least distance, with which nothing overflows.
template <class P, class S>
KNEAD_INLINE RegionValue<P> evaluate_near(const SetPoints<S>& set, const Vec3<P>& d) {
  P scale2 = norm2(offset_from(set, 0, d));
  for (int i = 1; i < set.count; ++i) scale2 = minimum(scale2, norm2(offset_from(set, i, d)));
  const auto is_apart = scale2 > P(0);
  scale2 = select(is_apart, scale2, P(1));
  const RegionValue<P> r = region_of(set, power_sums(set, d, scale2), sqrt(scale2));
  return {select(is_apart, r.value, P(0)), select(is_apart, r.gradient, Vec3<P>{P(0), P(0), P(0)})};
}

// r and grad r of a set of few points, in the unit of the thresholds; as above for lanes where that overflows.
template <class P, class S>
KNEAD_INLINE RegionValue<P> evaluate(const SetPoints<S>& set, const Vec3<P>& d, const P& /*t*/) {
  const PowerSums<P> sums = power_sums(set, d, P(set.scale * set.scale));
  const P most(std::sqrt(std::numeric_limits<S>::max()));
  const auto good = (sums.value < most) & (sums.value > P(1) / most);
  const RegionValue<P> r = region_of(set, sums, P(set.scale));
  if (bits(!good) == 0) return r;
  const RegionValue<P> near = evaluate_near(set, d);
  return {select(good, r.value, near.value), select(good, r.gradient, near.gradient)};
}

template <class P>
KNEAD_INLINE Vec3<P> load(const Lanes3<typename P::Scalar>& from, std::size_t i) {
  return {P::load(from[0] + i), P::load(from[1] + i), P::load(from[2] + i)};
}

template <class P>
KNEAD_INLINE void store(const Vec3<P>& v, Lanes3<typename P::Scalar>& to, std::size_t i) {
  v.x.store(to[0] + i);
  v.y.store(to[1] + i);
  v.z.store(to[2] + i);
}

// sum_j weights_j k_(slopes_j).
template <class P, class S>
KNEAD_INLINE Vec3<P> combine(const Bundle<S>& bundle, const Stage<S>& stage, std::size_t i) {
  Vec3<P> sum = load<P>(bundle.k[stage.slopes[0]], i) * P(stage.weights[0]);
  for (int j = 1; j < stage.count; ++j) {
    sum = mul_add(load<P>(bundle.k[stage.slopes[j]], i), P(stage.weights[j]), sum);
  }
  return sum;
}

// The places and times of a pack's lanes in a stage.
template <class P>
struct StagePlace {
  Vec3<P> at;  // from the field's centre at t = 0
  P t;
};

template <class P, class S>
KNEAD_INLINE StagePlace<P> place_in(const Bundle<S>& bundle, const Stage<S>& stage, std::size_t i) {
  StagePlace<P> place{load<P>(bundle.base, i), P::load(bundle.t + i)};
  if (!stage.from_start) place.at = place.at + load<P>(bundle.moved, i);
  if (stage.count == 0) return place;
  const P h = P::load(bundle.h + i);
  place.at = mul_add(combine<P>(bundle, stage, i), h, place.at);
  place.t = mul_add(h, P(stage.c), place.t);
  return place;
}

// The number of slopes of a stage from the start, if its loop over the lanes is compiled for it. Only translations have
// such loops, for the attempts to cross a whole segment, which saves 5% to 10% of the time in float.
inline constexpr int kAnySlopes = -1;

// A stage for the default falloff, the wide one without a core, or any; chosen before the loop, so that the choice
// costs nothing.
inline constexpr int kAnyFalloff = -1;

template <class P, class Field, int falloff, int slopes, class S>
[[gnu::flatten]] void stage_of(const void* data, Bundle<S>& bundle, const Stage<S>& given) {
  Field field = *static_cast<const Field*>(data);  // copies, which the stores below cannot change
  Stage<S> stage = given;
  if constexpr (falloff != kAnyFalloff) field.thresholds.falloff = falloff;
  if constexpr (falloff == kWideFalloff) field.thresholds.inner = S(0);
  if constexpr (slopes != kAnySlopes) {
    stage.count = slopes;
    stage.from_start = true;
  }
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    const auto [at, t] = place_in<P>(bundle, stage, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, at);
    store(velocity(field.motion, field.region, field.thresholds, d, t), bundle.k[stage.out], i);
  }
}

template <class P, class Field, int falloff, class S>
void stage_with(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  if constexpr (std::is_same_v<decltype(Field::motion), Translation<S>>) {
    if (stage.from_start && stage.count == 0) return stage_of<P, Field, falloff, 0>(data, bundle, stage);
    if (stage.from_start && stage.count == 1) return stage_of<P, Field, falloff, 1>(data, bundle, stage);
    if (stage.from_start && stage.count == 2) return stage_of<P, Field, falloff, 2>(data, bundle, stage);
  }
  stage_of<P, Field, falloff, kAnySlopes>(data, bundle, stage);
}

template <class P, class Field, class S>
void stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const auto& thresholds = static_cast<const Field*>(data)->thresholds;
  if (thresholds.falloff == kDefaultFalloff) return stage_with<P, Field, kDefaultFalloff>(data, bundle, stage);
  if constexpr (std::is_same_v<decltype(Field::region), Ball<S>>) {
    const bool is_wide = thresholds.falloff == kWideFalloff && thresholds.inner == S(0);
    if (is_wide) return stage_with<P, Field, kWideFalloff>(data, bundle, stage);
  }
  stage_of<P, Field, kAnyFalloff, kAnySlopes>(data, bundle, stage);
}

// The same under a mask.
template <class P, class Field, bool by_default, class S>
[[gnu::flatten]] void masked_stage_of(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  Field field = *static_cast<const Field*>(data);
  if constexpr (by_default) field.thresholds.falloff = kDefaultFalloff;
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    const auto [y, t] = place_in<P>(bundle, stage, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, y);
    const RegionValue<P> r = evaluate(field.region, d, t);
    const MaskValue<P> m = evaluate_mask(field.mask, y);
    store(masked_velocity_where(r, field.motion, field.thresholds, d, m, field.offset), bundle.k[stage.out], i);
  }
}

template <class P, class Field, class S>
void masked_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const bool by_default = static_cast<const Field*>(data)->thresholds.falloff == kDefaultFalloff;
  by_default ? masked_stage_of<P, Field, true>(data, bundle, stage)
             : masked_stage_of<P, Field, false>(data, bundle, stage);
}

// Returns the longest step that passes at most kMaskReach of the width of the mask's border.
template <class P, class S>
KNEAD_INLINE P longest_time_under(const MaskView<S>& mask, const Vec3<P>& y, const Vec3<P>& slope) {
  const P reach = maximum(clearance(mask, y), P(S(kMaskReach)) * P(mask.width));
  return step_rule::longest_step(sqrt(norm2(slope)), reach);
}

template <class P, class Field, class S>
[[gnu::flatten]] void limit_by_mask(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const Field field = *static_cast<const Field*>(data);
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    Vec3<P> y = load<P>(bundle.base, i);
    if (!from_start) y = y + load<P>(bundle.moved, i);
    longest_time_under(field.mask, y, load<P>(bundle.k[0], i)).store(limits.time + i);
  }
}

// |dr/dt| of a turning half-space at a resting point.
template <class P, class Field, class S>
[[gnu::flatten]] void limit_by_turning(const void* data, const Bundle<S>& bundle, bool from_start,
                                       StepLimits<S>& limits) {
  const Field field = *static_cast<const Field*>(data);
  const auto count = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < count; i += P::kSize) {
    const P t = P::load(bundle.t + i);
    Vec3<P> at = load<P>(bundle.base, i);
    if (!from_start) at = at + load<P>(bundle.moved, i);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, at);
    const Vec3<P> n = normal_at(field.region, t);
    const P speed = P(field.region.turn_angle) * dot(cross(Vec3<P>(field.region.turn_axis), n), d);
    maximum(speed, -speed).store(limits.speed + i);
  }
}

template <class P, class Field, class S>
void limit_by_mask_and_turning(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  limit_by_mask<P, Field, S>(data, bundle, from_start, limits);
  limit_by_turning<P, Field, S>(data, bundle, from_start, limits);
}

// The classification of a block's points, in double (method, section 3, "Exact facts").

template <class P>
KNEAD_INLINE Vec3<P> load(const Coordinates& from, std::size_t i) {
  return {P::load(from.x + i), P::load(from.y + i), P::load(from.z + i)};
}

// d turned about the unit axis by the angle, minus d; without cancellation for small angles.
template <class P>
KNEAD_INLINE Vec3<P> turn_displacement(const Vec3<P>& d, const Vec3<P>& axis, const P& given_angle) {
  const P turns = round_to_integer(given_angle * P(0.15915494309189535));
  const P reduced = neg_mul_add(turns, P(6.283185307179586), given_angle);
  const P most(1e4);  // for sincos; far up a twist angles are greater
  const P angle = select(given_angle > most, reduced, select(given_angle < -most, reduced, given_angle));
  const P half_sine = sincos(angle * P(0.5)).sin;
  const Vec3<P> d_perp = neg_mul_add(axis, dot(axis, d), d);
  return neg_mul_add(d_perp, half_sine * half_sine * P(2), cross(axis, d) * sincos(angle).sin);
}

// The maximum over the angles from phi0 to phi1 of n(phi).d, n turning about the unit axis; as in closed_form.cpp.
template <class P>
KNEAD_INLINE P greatest_over_turn(const Vec3<P>& n, const Vec3<P>& axis, const Vec3<P>& d, const P& phi0,
                                  const P& phi1) {
  const P level = dot(axis, n) * dot(axis, d);
  const P cosine = dot(n, d) - level;
  const P sine = dot(cross(axis, n), d);
  const P amplitude = sqrt(mul_add(cosine, cosine, sine * sine));
  const SinCos<P> low = sincos(minimum(phi0, phi1));
  const SinCos<P> high = sincos(maximum(phi0, phi1));
  const P rise = mul_sub(sine, low.cos, cosine * low.sin);
  const P fall = mul_sub(sine, high.cos, cosine * high.sin);
  const P span = maximum(phi1 - phi0, phi0 - phi1);
  const P ends = maximum(mul_add(cosine, low.cos, sine * low.sin), mul_add(cosine, high.cos, sine * high.sin));
  const P inner = select(rise > P(0), select(fall < P(0), amplitude, ends), ends);
  return level + select(span >= P(3.14159265358979), amplitude, inner);
}

// The number by which points are classified: r, or its square for a ball and a capsule, which is faster.
template <class P, template <class> class M, template <class> class R, class S>
KNEAD_INLINE P measure(const KernelField<S, M, R>& field, const Vec3<P>& d, const P& t) {
  return evaluate(field.exact_region, d, t).value;
}

template <class P, template <class> class M, class S>
KNEAD_INLINE P measure(const KernelField<S, M, Ball>& /*field*/, const Vec3<P>& d, const P& /*t*/) {
  return norm2(d);
}

template <class P, template <class> class M, class S>
KNEAD_INLINE P measure(const KernelField<S, M, Capsule>& field, const Vec3<P>& d, const P& /*t*/) {
  return norm2(from_axis(field.exact_region, d));
}

// For a set, whose r is slow to evaluate, returns a number below outer if the support may contain the point during the
// segment.
template <class P, template <class> class M, class S>
KNEAD_INLINE P measure(const KernelField<S, M, SetPoints>& field, const Vec3<P>& d, const P& /*t*/) {
  const SetPoints<double>& set = field.exact_region;
  const Vec3<P> from = d - Vec3<P>(set.middle);
  const Vec3<P> path(set.path);
  const P along = minimum(maximum(dot(from, path) * P(set.per_path2), P(0)), P(1));
  return select(norm2(neg_mul_add(path, along, from)) < P(set.radius * set.radius), P(-1e300), P(1e300));
}

// The measure() of a value of r.
template <class P, class F>
KNEAD_INLINE P bound_of(const F& /*field*/, double r) {
  return P(r);
}

template <class P>
KNEAD_INLINE P square_of_bound(double r) {
  return P(r > 0 ? r * r : -1.0);
}

template <class P, template <class> class M, class S>
KNEAD_INLINE P bound_of(const KernelField<S, M, Ball>& /*field*/, double r) {
  return square_of_bound<P>(r);
}

template <class P, template <class> class M, class S>
KNEAD_INLINE P bound_of(const KernelField<S, M, Capsule>& /*field*/, double r) {
  return square_of_bound<P>(r);
}

// The displacement of points in closed form, and the lanes for which it is known.
template <class P>
struct Known {
  Vec3<P> displacement;
  std::uint32_t lanes = 0;
};

// A point of the inner region rests in the tool's frame.
template <class P, template <class> class R, class S>
KNEAD_INLINE Known<P> closed_form(const KernelField<S, Translation, R>& field, const Vec3<P>& /*d*/, const P& r) {
  const Vec3<P> by(field.exact_displacement * (field.end - field.begin));
  if (!(field.exact_motion.velocity == field.exact_displacement)) return {by, 0};
  const bool signed_r = std::is_same_v<R<S>, HalfSpace<S>>;
  if (!signed_r && field.exact_thresholds.inner <= 0) return {by, 0};
  return {by, bits(r < bound_of<P>(field, field.exact_thresholds.inner))};
}

template <class P, class S>
KNEAD_INLINE Known<P> closed_form(const KernelField<S, Translation, SetPoints>& /*field*/, const Vec3<P>& /*d*/,
                                  const P& /*r*/) {
  return {{}, 0};
}

template <class P, class S>
KNEAD_INLINE Known<P> closed_form(const KernelField<S, Rotation, Ball>& field, const Vec3<P>& d, const P& r2) {
  const Rotation<double>& motion = field.exact_motion;
  if (!(field.exact_displacement == Vec3d{}) || motion.zero_gauge != RotationGauge::radial) return {{}, 0};
  const Vec3<P> axis(motion.axis);
  const P r = sqrt(r2);
  const Weight<P> w = blend_weight(r, field.exact_thresholds);
  const P height = dot(axis, d);
  const P rho2 = norm2(neg_mul_add(axis, height, d));
  const P shape = mul_add(height, height, P(0.5) * rho2) / maximum(r, P(1e-300));
  const P counter = w.derivative * shape * P(0.5 * motion.gauge);
  const P angle = (w.value + counter) * P(motion.rate * (field.end - field.begin));
  return {turn_displacement(d, axis, angle), ~0U};
}

// Returns which of the points that turn about the axis by `angle` over the unit of time stay in the inner region. In
// the frame of such a point n turns by turn_angle - angle, about the same axis.
template <class P, class F>
KNEAD_INLINE std::uint32_t stay_inside(const F& field, const Vec3<P>& d, const P& angle) {
  const HalfSpace<double>& region = field.exact_region;
  const Vec3d& axis = field.exact_motion.axis;
  double turn = 0;
  if (region.turn_angle != 0) {
    const double along = dot(region.turn_axis, axis);
    if (along < 1 - 1e-14 && along > -1 + 1e-14) return 0;  // about another axis
    turn = along > 0 ? region.turn_angle : -region.turn_angle;
  }
  const double phi0 = field.begin * turn;
  const P phi1 = mul_add(P(turn) - angle, P(field.end - field.begin), P(phi0));
  const P greatest = greatest_over_turn(Vec3<P>(region.normal), Vec3<P>(axis), d, P(phi0), phi1);
  return bits(greatest < P(field.exact_thresholds.inner));
}

template <class P, class S>
KNEAD_INLINE Known<P> closed_form(const KernelField<S, Rotation, HalfSpace>& field, const Vec3<P>& d, const P& r) {
  if (!(field.exact_displacement == Vec3d{})) return {{}, 0};
  if (bits(r < P(field.exact_thresholds.inner)) == 0) return {{}, 0};
  const double rate = field.exact_motion.rate;
  const P angle(rate * (field.end - field.begin));
  return {turn_displacement(d, Vec3<P>(field.exact_motion.axis), angle), stay_inside(field, d, P(rate))};
}

template <class P, class S>
KNEAD_INLINE Known<P> closed_form(const KernelField<S, Twist, HalfSpace>& field, const Vec3<P>& d, const P& r) {
  const Twist<double>& motion = field.exact_motion;
  const HalfSpace<double>& region = field.exact_region;
  if (!(field.exact_displacement == Vec3d{}) || region.turn_angle != 0) return {{}, 0};
  const Vec3<P> axis(motion.axis);
  const P height = dot(axis, d);
  const P duration(field.end - field.begin);
  const double along = dot(region.normal, motion.axis);
  const Vec3d across = cross(region.normal, motion.axis);
  if (norm2(across) > 1e-24) {
    if (bits(r < P(field.exact_thresholds.inner)) == 0) return {{}, 0};
    const P rate = P(motion.rate) * height;
    return {turn_displacement(d, axis, rate * duration), stay_inside(field, d, rate)};
  }
  const Weight<P> w = blend_weight(r, field.exact_thresholds);
  const P counter = w.derivative * height * P(0.25 * motion.gauge * along);
  return {turn_displacement(d, axis, P(motion.rate) * height * (w.value + counter) * duration), ~0U};
}

// |exp(t M) d|^2 is convex in t for a symmetric M: its greatest value is at an end.
template <class P, class S>
KNEAD_INLINE Known<P> closed_form(const KernelField<S, Strain, Ball>& field, const Vec3<P>& d, const P& r2) {
  const Mat3d& m = field.exact_motion.matrix;
  const bool symmetric = m.row0.y == m.row1.x && m.row0.z == m.row2.x && m.row1.z == m.row2.y;
  if (!symmetric || !(field.exact_displacement == Vec3d{})) return {{}, 0};
  const P inner2 = bound_of<P>(field, field.exact_thresholds.inner);
  const auto begins_inside = r2 < inner2;
  if (bits(begins_inside) == 0) return {{}, 0};
  const Mat3d& e = field.whole_strain;
  const Vec3<P> moved{dot(Vec3<P>(e.row0), d), dot(Vec3<P>(e.row1), d), dot(Vec3<P>(e.row2), d)};
  return {moved - d, bits(begins_inside) & bits(norm2(moved) < inner2)};
}

template <class P, class F>
KNEAD_INLINE Known<P> closed_form(const F& /*field*/, const Vec3<P>& /*d*/, const P& /*r*/) {
  return {{}, 0};
}

// The time at which the support reaches a resting point that is outside at the segment's beginning.
template <class P>
struct Arrival {
  P after;                    // since the segment's beginning; beyond its end: never
  std::uint32_t pending = 0;  // lanes that the support may reach at an unknown time
};

template <class P, template <class> class M, class S>
KNEAD_INLINE Arrival<P> arrival(const KernelField<S, M, Ball>& field, const Vec3<P>& d, const P& /*r*/) {
  const double direction = field.end >= field.begin ? -1.0 : 1.0;  // the point's, relative to the tool
  const Vec3<P> velocity(field.exact_displacement * direction);
  const double outer = field.exact_thresholds.outer;
  const P a = norm2(velocity);
  const P b = -dot(d, velocity);
  const P c = norm2(d) - P(outer * outer);
  const P discriminant = mul_sub(b, b, a * c);
  const P after = maximum(c / (b + sqrt(maximum(discriminant, P(0)))), P(0));
  const P never(4);
  return {select(b > P(0), select(discriminant >= P(0), after, never), never), 0};
}

// r falls at most as fast as the point moves in the tool's frame.
template <class P, class F>
KNEAD_INLINE Arrival<P> arrival(const F& field, const Vec3<P>& d, const P& measure) {
  const bool is_square = std::is_same_v<decltype(F::exact_region), Capsule<double>>;
  const P r = is_square ? sqrt(measure) : measure;
  double speed2 = norm2(field.exact_displacement);
  P turning(0);
  if constexpr (requires { field.exact_region.turn_angle; }) {
    const Vec3<P> lever = cross(Vec3<P>(field.exact_region.turn_axis), d);
    turning = sqrt(norm2(lever)) *
              P(field.exact_region.turn_angle < 0 ? -field.exact_region.turn_angle : field.exact_region.turn_angle);
  }
  const double duration = field.end >= field.begin ? field.end - field.begin : field.begin - field.end;
  const P most = (sqrt(P(speed2)) + turning) * P(duration * (1 + 1e-9));
  return {P(4), bits(r - most < P(field.exact_thresholds.outer))};
}

// Adds the displacement to the points of the pack at i whose lane's bit is set.
template <class P>
KNEAD_INLINE void add_where(std::uint32_t lanes, const Vec3<P>& displacement, const BlockTask& task, std::size_t i,
                            double& most) {
  double by[3][P::kSize];
  displacement.x.store(by[0]);
  displacement.y.store(by[1]);
  displacement.z.store(by[2]);
  double* const to[3] = {task.points.x + i, task.points.y + i, task.points.z + i};
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < P::kSize; ++k) {
      const double add = (lanes >> k & 1) != 0 ? by[axis][k] : 0.0;
      to[axis][k] = add == 0 ? to[axis][k] : to[axis][k] + add;
      const double size = add < 0 ? -add : add;
      most = size > most ? size : most;
    }
  }
}

// Under a mask no motion is known in closed form.
template <class P, class Field, bool masked>
[[gnu::flatten]] Classified classify(const void* data, const BlockTask& task) {
  const typename Field::Plain& field = *static_cast<const Field*>(data);  // the overloads take this type
  const P begin(field.begin);
  const double duration = field.end >= field.begin ? field.end - field.begin : field.begin - field.end;
  Classified result;
  for (std::size_t i = 0; i < kBlock; i += P::kSize) {
    const std::uint32_t members = static_cast<std::uint32_t>(task.members >> i) & ((std::uint64_t{1} << P::kSize) - 1);
    if (members == 0) continue;
    const Vec3<P> x = load<P>(task.points, i);
    const Vec3<P> d = x - Vec3<P>(field.center) - Vec3<P>(field.exact_displacement * field.begin);
    const P r = measure(field, d, begin);
    const std::uint32_t inside = bits(r < bound_of<P>(field, field.exact_thresholds.outer)) & members;
    const std::uint32_t outside = members & ~inside;
    if (outside != 0) {
      const Arrival<P> at = arrival(field, d, r);
      const std::uint32_t later = outside & bits(at.after < P(duration));
      if (later != 0) {
        const double direction = field.end >= field.begin ? 1.0 : -1.0;
        mul_add(at.after, P(direction), begin).store(task.start + i);
        result.later |= std::uint64_t{later} << i;
      }
      result.pending |= std::uint64_t{outside & at.pending} << i;
    }
    if (inside == 0) continue;
    Known<P> known;
    if constexpr (!masked) {
      if (task.moves) known = closed_form(field, d, r);
    }
    const std::uint32_t closed = known.lanes & inside;
    if (closed != 0) {
      result.inside |= std::uint64_t{inside & ~closed} << i;
      add_where(closed, known.displacement, task, i, result.moved);
    } else {
      result.inside |= std::uint64_t{inside} << i;
    }
  }
  return result;
}

}  // namespace knead::detail
