// Kernels of pins (method, section 9): path lines side by side in the sum of the pins' kernels. Internal: part of the
// one source of all kernels.
#pragma once

#include "flow/kernels/kernel_stage.h"

namespace knead::detail {

inline constexpr int kPinsAtOnce = 128;  // from which those that may reach a bundle are chosen

// The places of a bundle's path lines in a stage, in units of the radius, and the velocities found so far.
template <class S>
struct alignas(64) PinPlaces {
  Lanes3<S> at;
  S t[kBundle];
  Lanes3<S> velocity;
  Lanes3<S> potential;  // under a mask only
};

// Chooses the pins of a list that reach the box of all path lines. A path line's sum does not depend on its neighbours,
// because a pin that does not reach it adds 0.
template <class S>
class PinsNear {
 public:
  KNEAD_INLINE PinsNear(const PinPlaces<S>& places, std::size_t count) {
    for (int axis = 0; axis < 3; ++axis) find_range(places.at[axis], count, low_[axis], high_[axis]);
    find_range(places.t, count, first_, last_);
  }

  // Returns whether all path lines are at the same time().
  KNEAD_INLINE bool is_one_time() const { return first_ == last_; }
  KNEAD_INLINE S time() const { return first_; }

  // Writes the numbers of the pins from `begin` to `end` that reach the box, and returns their count.
  KNEAD_INLINE int choose(const PinNumbers<S>& pins, int begin, int end, int* numbers) const {
    int count = 0;
    for (int i = begin; i < end; ++i) {
      numbers[count] = i;
      count += reaches(pins[i]) ? 1 : 0;
    }
    return count;
  }

 private:
  KNEAD_INLINE static void find_range(const S* numbers, std::size_t count, S& low, S& high) {
    low = high = numbers[0];
    for (std::size_t i = 1; i < count; ++i) {
      low = numbers[i] < low ? numbers[i] : low;
      high = numbers[i] > high ? numbers[i] : high;
    }
  }

  // Returns whether the pin's box, with the radius and a margin for rounding, meets that of the path lines.
  KNEAD_INLINE bool reaches(const S* pin) const {
    const S reach = S(1.0001);
    for (int axis = 0; axis < 3; ++axis) {
      const S a = pin[axis] + pin[3 + axis] * first_;
      const S b = pin[axis] + pin[3 + axis] * last_;
      if ((a < b ? a : b) - reach > high_[axis] || (a < b ? b : a) + reach < low_[axis]) return false;
    }
    return true;
  }

  S low_[3];
  S high_[3];
  S first_{0};
  S last_{0};
};

// The same vector in every lane.
template <class P, class S>
KNEAD_INLINE Vec3<P> each_lane(const S* v) {
  return {P(v[0]), P(v[1]), P(v[2])};
}

// The places of points in units of the radius, their times, and the times in the polynomials' interval [-1, 1].
template <class P>
struct PinPlace {
  Vec3<P> x;
  P t;
  P s;
};

// One pin, and the polynomials of its strengths.
template <class S>
struct PinStrength {
  const S* pin;
  const S* powers;
  int degree;
};

// The sum of the pins; the potential only under a mask.
template <class P>
struct PinSum {
  Vec3<P> velocity;
  Vec3<P> potential;
};

// Adds the kernel of one pin to v, and to the vector potential A (in units of the radius) under a mask:
// v = (1 - r)^4 ((1 + 4 r - 20 r^2) a + 15 (a.y) y), A = (1 + 5 r) (1 - r)^5 a x y / 2, y from the pin, r = |y|.
template <class P, bool masked, class S>
KNEAD_INLINE void add_pin(const PinStrength<S>& of, const PinPlace<P>& place, PinSum<P>& sum) {
  const Vec3<P> y = neg_mul_add(each_lane<P>(of.pin + 3), place.t, place.x - each_lane<P>(of.pin));
  Vec3<P> a = each_lane<P>(of.powers + 3 * of.degree);
  for (int power = of.degree - 1; power >= 0; --power) a = mul_add(a, place.s, each_lane<P>(of.powers + 3 * power));
  const P r = sqrt(norm2(y));
  const P rest = maximum(P(1) - r, P(0));
  const P square = rest * rest;
  const P fourth = square * square;
  sum.velocity = mul_add(a, fourth * mul_add(r, mul_add(r, P(-20), P(4)), P(1)), sum.velocity);
  sum.velocity = mul_add(y, fourth * (P(15) * dot(a, y)), sum.velocity);
  if constexpr (masked) sum.potential = mul_add(cross(a, y), fourth * rest * mul_add(r, P(2.5), P(0.5)), sum.potential);
}

template <class P, bool masked, class S>
KNEAD_INLINE void find_places(const PinKernelField<S>& field, const Bundle<S>& bundle, const Stage<S>& stage,
                              PinPlaces<S>& places) {
  const P per_radius(field.per_radius);
  const Vec3<P> zero{P(0), P(0), P(0)};
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    const StagePlace<P> place = place_in<P>(bundle, stage, i);
    store(place.at * per_radius, places.at, i);
    place.t.store(places.t + i);
    store(zero, places.velocity, i);
    if constexpr (masked) store(zero, places.potential, i);
  }
}

// The same of a turn: v = (1 - r)^3 ((1 - 9/5 r) rate x y + (1 - 7/3 r) S y + 4/3 (y.S y) y / r), S the strain;
// A = (1 - r)^3 ((1 - 9/5 r) (rate.y) y + (1 - r) (S y) x y / 3).
template <class P, bool masked, class S>
KNEAD_INLINE void add_turn(const PinStrength<S>& of, const PinPlace<P>& place, PinSum<P>& sum) {
  const Vec3<P> y = neg_mul_add(each_lane<P>(of.pin + 3), place.t, place.x - each_lane<P>(of.pin));
  const P r = sqrt(norm2(y));
  const P rest = maximum(P(1) - r, P(0));
  const P cube = rest * (rest * rest);
  const S* const highest = of.powers + 9 * of.degree;
  Vec3<P> rate = each_lane<P>(highest);
  Vec3<P> own = each_lane<P>(highest + 3);
  Vec3<P> across = each_lane<P>(highest + 6);
  for (int power = of.degree - 1; power >= 0; --power) {
    const S* const lower = of.powers + 9 * power;
    rate = mul_add(rate, place.s, each_lane<P>(lower));
    own = mul_add(own, place.s, each_lane<P>(lower + 3));
    across = mul_add(across, place.s, each_lane<P>(lower + 6));
  }
  const Vec3<P> strained{mul_add(own.x, y.x, mul_add(across.x, y.y, across.y * y.z)),
                         mul_add(across.x, y.x, mul_add(own.y, y.y, across.z * y.z)),
                         mul_add(across.y, y.x, mul_add(across.z, y.y, own.z * y.z))};
  const P turning = cube * mul_add(r, P(S(-1.8)), P(1));
  const P along = cube * P(S(4) / S(3)) * dot(y, strained) / maximum(r, P(kMinDistance<S>));
  sum.velocity = mul_add(cross(rate, y), turning, sum.velocity);
  sum.velocity = mul_add(strained, cube * mul_add(r, P(S(-7) / S(3)), P(1)), sum.velocity);
  sum.velocity = mul_add(y, along, sum.velocity);
  if constexpr (masked) {
    sum.potential = mul_add(y, turning * dot(rate, y), sum.potential);
    sum.potential = mul_add(cross(strained, y), cube * rest * P(S(1) / S(3)), sum.potential);
  }
}

// Evaluates `width` polynomials as add_pin() and add_turn() do: in packs, with the same rounding.
template <class P, int width, class S>
KNEAD_INLINE void evaluate_powers(const S* powers, int degree, S s, S* values) {
  for (int i = 0; i < width; ++i) {
    P value(powers[width * degree + i]);
    for (int power = degree - 1; power >= 0; --power) value = mul_add(value, P(s), P(powers[width * power + i]));
    alignas(64) S lanes[P::kSize];
    value.store(lanes);
    values[i] = lanes[0];
  }
}

// Adds the pins, or the turns, of a list that may reach a path line. Path lines at the same time, such as most in their
// first step, share the polynomials' values.
template <class P, bool masked, bool turns, class S>
KNEAD_INLINE void add_near(const PinKernelField<S>& field, const PinNumbers<S>& pins, const PinsNear<S>& near,
                           PinPlaces<S>& places, std::size_t lanes) {
  constexpr int kWidth = turns ? 9 : 3;
  const bool shares = near.is_one_time() && lanes > P::kSize;
  for (int begin = 0; begin < pins.count; begin += kPinsAtOnce) {
    int numbers[kPinsAtOnce];
    S values[kPinsAtOnce * kWidth];
    const int rest = pins.count - begin;
    const int count = near.choose(pins, begin, begin + (rest < kPinsAtOnce ? rest : kPinsAtOnce), numbers);
    for (int k = 0; shares && k < count; ++k) {
      const S s = (near.time() - field.middle) * field.per_half;
      evaluate_powers<P, kWidth>(pins[numbers[k]] + 6, field.degree, s, values + kWidth * k);
    }
    for (std::size_t i = 0; count > 0 && i < lanes; i += P::kSize) {
      const P t = P::load(places.t + i);
      const PinPlace<P> place{load<P>(places.at, i), t, (t - P(field.middle)) * P(field.per_half)};
      PinSum<P> sum;
      sum.velocity = load<P>(places.velocity, i);
      if constexpr (masked) sum.potential = load<P>(places.potential, i);
      for (int k = 0; k < count; ++k) {
        const S* const pin = pins[numbers[k]];
        const PinStrength<S> of =
            shares ? PinStrength<S>{pin, values + kWidth * k, 0} : PinStrength<S>{pin, pin + 6, field.degree};
        if constexpr (turns) {
          add_turn<P, masked>(of, place, sum);
        } else {
          add_pin<P, masked>(of, place, sum);
        }
      }
      store(sum.velocity, places.velocity, i);
      if constexpr (masked) store(sum.potential, places.potential, i);
    }
  }
}

template <class P, bool masked, class S>
[[gnu::flatten]] void pin_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const PinKernelField<S> field = *static_cast<const PinKernelField<S>*>(data);
  const auto lanes = static_cast<std::size_t>(bundle.count);
  PinPlaces<S> places;  // NOLINT(cppcoreguidelines-pro-type-member-init): find_places writes all that is read
  find_places<P, masked>(field, bundle, stage, places);
  const PinsNear<S> near(places, lanes);
  add_near<P, masked, false>(field, field.pins, near, places, lanes);
  add_near<P, masked, true>(field, field.turns, near, places, lanes);
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    Vec3<P> v = load<P>(places.velocity, i);
    if constexpr (masked) {
      const Vec3<P> y = load<P>(places.at, i) * P(S(1) / field.per_radius);
      const MaskValue<P> m = evaluate_mask(field.mask, y);
      v = mul_add(v, m.value, cross(m.gradient, load<P>(places.potential, i)) * P(S(1) / field.per_radius));
    }
    store(v, bundle.k[stage.out], i);
  }
}

// Points that a pin reaches at the segment's beginning are inside; those that one may reach later are pending.
template <class P, class S>
[[gnu::flatten]] Classified classify_by_pins(const void* data, const BlockTask& task) {
  const auto& field = *static_cast<const PinKernelField<S>*>(data);
  const double duration = field.end >= field.begin ? field.end - field.begin : field.begin - field.end;
  Classified result;
  for (std::size_t i = 0; i < kBlock; i += P::kSize) {
    const std::uint32_t members = static_cast<std::uint32_t>(task.members >> i) & ((std::uint64_t{1} << P::kSize) - 1);
    const Vec3<P> x = load<P>(task.points, i) - Vec3<P>(field.center);
    std::uint32_t inside = 0;
    std::uint32_t near = 0;
    for (int k = 0; k < field.pins.count && (members & ~inside) != 0; ++k) {
      const ExactPin& pin = field.exact[k];
      const double far = field.radius + pin.speed * duration * (1 + 1e-9);
      const P square = norm2(x - Vec3<P>(pin.place + pin.by * field.begin));
      inside |= bits(square < P(field.radius * field.radius));
      near |= bits(square < P(far * far));
    }
    result.inside |= std::uint64_t{inside & members} << i;
    result.pending |= std::uint64_t{near & ~inside & members} << i;
  }
  return result;
}

template <class P, class PD, bool masked>
FieldKernel<typename P::Scalar> pin_kernel() {
  using S = typename P::Scalar;
  FieldKernel<S> kernel;
  kernel.stage = &pin_stage<P, masked, S>;
  kernel.classify = &classify_by_pins<PD, S>;
  if (masked) kernel.limit = &limit_by_mask<P, PinKernelField<S>, S>;
  kernel.limits_place = masked;
  return kernel;
}

}  // namespace knead::detail
