// A bundle's path lines with the field that they follow. Internal to the flow room: part of the one source of all
// kernels.
#pragma once

#include "knead/flow/kernel_points.h"
#include "knead/flow/step_rule.h"

namespace knead::detail {

template <class P>
KNEAD_INLINE P norm_of(const Vec3<P>& a) {
  return sqrt(norm2(a));
}

template <class P>
KNEAD_INLINE auto equal(const Vec3<P>& a, const Vec3<P>& b) {
  return (a.x == b.x) & (a.y == b.y) & (a.z == b.z);
}

template <class P>
KNEAD_INLINE Vec3<P> select_each(const typename P::Mask& mask, const Vec3<P>& a, const Vec3<P>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

// The lanes of the pack that begins at lane i which are in use.
template <class P>
KNEAD_INLINE std::uint32_t lanes_in_use(std::size_t i, int count) {
  const std::size_t rest = static_cast<std::size_t>(count) - i;
  const std::uint32_t all = static_cast<std::uint32_t>((std::uint64_t{1} << P::kSize) - 1);
  return rest >= P::kSize ? all : (std::uint32_t{1} << rest) - 1;
}

template <class P>
class BundleField {
  using S = typename P::Scalar;

 public:
  BundleField(const SegmentTask<S>& segment, Bundle<S>& bundle) : segment_(segment), bundle_(bundle) {
    if (segment.kernel.limit == nullptr) return;
    fill(limits_.speed, S(0), kBundle);
    if (!is_limited_by_place()) return;
    fill(limits_.reach, segment.reach, kBundle);
    fill(limits_.time, std::numeric_limits<S>::max(), kBundle);
  }

  std::uint64_t evaluations() const { return evaluations_; }

  // Counts only the lanes that are asked for: how many a path line takes depends on it alone.
  void evaluate(const Stage<S>& stage) {
    segment_.kernel.stage(segment_.field, bundle_, stage);
    evaluations_ += static_cast<std::uint64_t>(bundle_.asked.count());
  }
  void count_evaluations(int more) { evaluations_ += static_cast<std::uint64_t>(more); }

  void follow() {
    if (segment_.kernel.follow != nullptr) count_evaluations(segment_.kernel.follow(segment_.field, bundle_));
  }

  void find_limits(bool from_start) {
    if (segment_.kernel.limit != nullptr) segment_.kernel.limit(segment_.field, bundle_, from_start, limits_);
  }

  KNEAD_INLINE bool is_limited_by_place() const { return is_limited() && segment_.kernel.limits_place; }
  KNEAD_INLINE bool is_limited() const { return segment_.kernel.limit != nullptr; }
  KNEAD_INLINE P hidden_speed(std::size_t i) const { return P::load(limits_.speed + i); }
  KNEAD_INLINE P longest_time(std::size_t i) const { return P::load(limits_.time + i); }
  KNEAD_INLINE P reach(std::size_t i) const {
    return is_limited_by_place() ? P::load(limits_.reach + i) : P(segment_.reach);
  }
  KNEAD_INLINE P by_reach(std::size_t i) const {
    return is_limited_by_place() ? P(1) / P::load(limits_.reach + i) : P(S(1) / segment_.reach);
  }

  // From the slope k_0.
  KNEAD_INLINE P longest_step(std::size_t i) const {
    const Vec3<P> relative = load<P>(bundle_.k[0], i) - Vec3<P>(segment_.tool_velocity);
    P speed = maximum(norm_of(relative), P(segment_.tool_speed));
    if (!is_limited()) return step_rule::longest_step(speed, P(segment_.reach));
    speed = speed + hidden_speed(i);
    if (!is_limited_by_place()) return step_rule::longest_step(speed, P(segment_.reach));
    return minimum(step_rule::longest_step(speed, reach(i)), longest_time(i));
  }

  // Lanes where v is 0 for another reason than that a tool is just arriving.
  KNEAD_INLINE std::uint32_t resting(std::size_t i) const {
    std::uint32_t rests = bits(equal(load<P>(bundle_.k[0], i), Vec3<P>{P(0), P(0), P(0)}));
    for (std::size_t k = 0; rests != 0 && k < P::kSize; ++k) {
      if (bundle_.at_contact[i + k] != 0) rests &= ~(std::uint32_t{1} << k);
    }
    return rests;
  }

  // Lanes that rest in the rigid core of the tool.
  KNEAD_INLINE std::uint32_t carried(std::size_t i) const {
    if (!segment_.carries) return 0;
    return bits(equal(load<P>(bundle_.k[0], i), Vec3<P>(segment_.tool_velocity)));
  }

 private:
  const SegmentTask<S>& segment_;
  Bundle<S>& bundle_;
  std::uint64_t evaluations_ = 0;
  alignas(64) StepLimits<S> limits_;
};

}  // namespace knead::detail
