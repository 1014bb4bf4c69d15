// The integration of a group's path lines, a bundle at a time, and the table of all kernels. Included once by the
// source of every instruction set.
#pragma once

#include <algorithm>
#include <limits>

#include "flow/kernels/kernel_grid.h"
#include "flow/kernels/kernel_jacobian.h"
#include "flow/kernels/kernel_pins.h"
#include "flow/kernels/kernel_points.h"

namespace knead::detail {

template <class P>
class GroupMover {
  using S = typename P::Scalar;

 public:
  GroupMover(const SegmentTask<S>& segment, const GroupTask<S>& group)
      : segment_(segment), group_(group), bundle_(*group.bundle), points_(segment, group), field_(segment, bundle_) {}

  GroupCounts run() {
    points_.clear();
    append_blocks();
    flush();
    counts_.evaluations = field_.evaluations();
    return counts_;
  }

 private:
  static constexpr int kBlocksAhead = kBundle / kBlock;  // that are prefetched: those of the next bundle

  Coordinates points_from(std::size_t first) const {
    return {group_.points.x + first, group_.points.y + first, group_.points.z + first};
  }

  void append_blocks() {
    alignas(64) double start[kBlock];
    for (int i = 0; i < group_.block_count; ++i) {
      const std::size_t first = group_.blocks[i] * kBlock;
      if (i + kBlocksAhead < group_.block_count) points_.prefetch(group_.blocks[i + kBlocksAhead] * kBlock);
      const bool between = !segment_.kernel.by_lanes && (group_.between >> group_.blocks[i] & 1) != 0;
      const BlockTask task{points_from(first), group_.members[group_.blocks[i]], start};
      Classified found;
      if (between) {
        found.inside = task.members;
      } else {
        found = segment_.kernel.classify(segment_.field, task);
      }
      if (found.pending != 0) points_.decide(task, found);
      points_.note_moved(first, found.moved);
      if ((found.inside | found.later) == 0) continue;
      if (bundle_.count + kBlock > kBundle) flush();
      if (!counts_.complete) return;
      points_.append(first, start, found);
    }
  }

  void flush() {
    if (bundle_.count == 0) return;
    const bool all = cross_in_one_step();
    if (!all) integrate();
    points_.scatter(all);
    points_.clear();
  }

  std::size_t lanes() const { return static_cast<std::size_t>(bundle_.count); }

  // Moves the path lines for which the whole segment is one accurate step, and leaves the others in the bundle. Returns
  // whether none are left.
  bool cross_in_one_step() {
    done_ = WholeSegment<P>(segment_, bundle_, field_).run();
    const int done = done_.count();
    counts_.accepted += static_cast<std::uint64_t>(done);
    if (done == bundle_.count) return true;
    fill(bundle_.result_steps, S(1), lanes());  // those of the others are overwritten later
    slots_are_lanes_ = true;
    if (done > 0) drop_done();
    fill(bundle_.steps, S(0), lanes());
    return false;
  }

  // Removes the finished lanes from the bundle.
  void drop_done() {
    std::uint16_t kept[kBundle];
    const std::size_t count = done_.list_others(lanes(), kept);
    for (int axis = 0; axis < 3; ++axis) {
      squeeze(bundle_.base[axis], kept, count);
      squeeze(bundle_.moved[axis], kept, count);
      squeeze(bundle_.k[0][axis], kept, count);
    }
    squeeze(bundle_.t, kept, count);
    squeeze(bundle_.trial, kept, count);
    squeeze(bundle_.steps, kept, count);
    pick(bundle_.at_contact, kept, count);
    if (slots_are_lanes_) {
      for (std::size_t k = 0; k < count; ++k) bundle_.slot[k] = kept[k];
      slots_are_lanes_ = false;
    } else {
      pick(bundle_.slot, kept, count);
    }
    if (segment_.kernel.by_lanes) {
      pick(bundle_.origins, kept, count);
      pick(bundle_.width, kept, count);
    }
    bundle_.count = static_cast<int>(count);
  }

  // Moves the numbers of some lanes to the first places.
  template <class T>
  KNEAD_INLINE static void pick(T* numbers, const std::uint16_t* lanes, std::size_t count) {
    for (std::size_t to = 0; to < count; ++to) numbers[to] = numbers[lanes[to]];
  }

  // The same for all lanes that are not done; `kept` lists them.
  KNEAD_INLINE void squeeze(S* numbers, const std::uint16_t* kept, std::size_t count) const {
    if constexpr (requires(P pack) { store_lanes(pack, 0U, numbers); }) {
      std::size_t to = 0;
      for (std::size_t i = 0; i < lanes(); i += P::kSize) {
        const std::uint32_t rest = lanes_in_use<P>(i, bundle_.count) & ~done_.bits(i, P::kSize);
        to += store_lanes(P::load(numbers + i), rest, numbers + to);
      }
    } else {
      pick(numbers, kept, count);
    }
  }

  // Moves all that is left of the bundle, by steps whose error is estimated.
  void integrate() {
    for (int axis = 0; axis < 3; ++axis) fill(bundle_.moved[axis], S(-0.0), kBundle);
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const P time = P(segment_.end) - P::load(bundle_.t + i);
      maximum(time, -time).store(bundle_.trial + i);
    }
    const Method<S>& method = *segment_.method;
    for (int round = 0;; ++round) {
      settle();
      if (bundle_.asked.count() == 0) return;
      if (round == kStepLimit || !counts_.complete || group_.stop.is_stopped(field_.evaluations())) {
        counts_.complete = false;
        return;
      }
      field_.find_limits(false);
      for (std::size_t i = 0; i < lanes(); i += P::kSize) choose_step(i);
      for (int k = 1; k < method.stage_count; ++k) field_.evaluate(method.stages[k]);
      for (std::size_t i = 0; i < lanes(); i += P::kSize) finish_step(i);
      fill(bundle_.at_contact, std::uint8_t{0}, lanes());
      field_.follow();
      if (!method.first_same_as_last) field_.evaluate(Stage<S>{});
    }
  }

  // Finishes the lanes that need no step, and removes finished ones when they are many. Asks for those that have not
  // arrived yet.
  void settle() {
    done_.clear();
    bundle_.asked.clear();
    for (std::size_t i = 0; i < lanes(); i += P::kSize) {
      const std::uint32_t used = lanes_in_use<P>(i, bundle_.count);
      std::uint32_t done = bits(P::load(bundle_.t + i) == P(segment_.end));
      const std::uint32_t candidates = (field_.resting(i) | field_.carried(i)) & used & ~done;
      for (std::size_t k = 0; candidates != 0 && k < P::kSize; ++k) {
        if ((candidates >> k & 1) != 0 && !goes_on(i + k)) done |= std::uint32_t{1} << k;
      }
      done_.add(i, done & used);
      bundle_.asked.add(i, ~done & used);
    }
    const int active = bundle_.asked.count();
    if (active == 0) {
      keep_results();
    } else if (active <= bundle_.count - std::max(static_cast<int>(P::kSize), bundle_.count / 4)) {
      keep_results();
      drop_done();
      bundle_.asked.fill(lanes());
    }
  }

  // Returns whether the tool will move a resting lane again, and sets its time to when. A lane that rests in the tool's
  // frame is moved with the tool exactly.
  bool goes_on(std::size_t lane) {
    const std::size_t point = points_.point_of(slots_are_lanes_ ? lane : bundle_.slot[lane]);
    double* const to[3] = {group_.points.x + point, group_.points.y + point, group_.points.z + point};
    const S t = bundle_.t[lane];
    bundle_.t[lane] = segment_.end;
    bool carried = segment_.carries;
    for (int axis = 0; axis < 3; ++axis) {
      carried = carried && bundle_.k[0][axis][lane] == segment_.tool_velocity[static_cast<std::size_t>(axis)];
    }
    if (carried) {
      const double rest = static_cast<double>(segment_.end) - static_cast<double>(t);
      for (int axis = 0; axis < 3; ++axis) {
        const double by = segment_.displacement[static_cast<std::size_t>(axis)] * rest;
        *to[axis] += by;
        const double before = bundle_.moved[axis][lane];
        points_.note_moved(point, (by < 0 ? -by : by) + (before < 0 ? -before : before));
      }
      return false;
    }
    const Vec3d x{*to[0] + bundle_.moved[0][lane], *to[1] + bundle_.moved[1][lane], *to[2] + bundle_.moved[2][lane]};
    const double contact =
        segment_.next_contact(segment_.contact_data, x, static_cast<double>(t), bundle_.origins[lane].cell);
    if (contact > 1) return false;
    bundle_.t[lane] = static_cast<S>(contact);
    bundle_.at_contact[lane] = 1;
    return bundle_.t[lane] != segment_.end;
  }

  // Finds the lanes' next step; 0 for finished ones.
  KNEAD_INLINE void choose_step(std::size_t i) {
    const P time = P(segment_.end) - P::load(bundle_.t + i);
    const P longest = field_.longest_step(i);
    const P shortest = step_rule::shortest_step(longest, P(kShortestPart<S>));
    const P h = step_rule::chosen_step(P::load(bundle_.trial + i), shortest, longest, maximum(time, -time));
    shortest.store(bundle_.shortest + i);
    (segment_.end >= segment_.begin ? h : -h).store(bundle_.h + i);
  }

  // Accepts the step where its error is small enough.
  KNEAD_INLINE void finish_step(std::size_t i) {
    const Method<S>& method = *segment_.method;
    const P signed_h = P::load(bundle_.h + i);
    const P h = maximum(signed_h, -signed_h);
    const P t = P::load(bundle_.t + i);
    const P end(segment_.end);
    const P remaining = maximum(end - t, t - end);
    const P by_tolerance(S(1) / segment_.tolerance);
    const Vec3<P> slope = combine<P>(bundle_, method.slope, i);
    const P shortest = P::load(bundle_.shortest + i);
    P error2 = norm2(combine<P>(bundle_, method.error, i) * by_tolerance);
    if (method.extrapolates) error2 = step_rule::extrapolated_error2(error2, h, shortest, P(S(kShortestPart<S>)));
    const P noise2 = norm2(slope * (by_tolerance * P(S(kRoundingOfSlope) * std::numeric_limits<S>::epsilon())));
    const auto active = remaining > P(0);
    const auto accept = ((error2 <= P(1) + noise2) | (h <= shortest)) & active;
    const auto arrived = accept & (h >= remaining);
    const Vec3<P> moved = load<P>(bundle_.moved, i);
    store(select(accept, mul_add(slope, signed_h, moved), moved), bundle_.moved, i);
    select(arrived, end, select(accept, t + signed_h, t)).store(bundle_.t + i);
    (P::load(bundle_.steps + i) + select(accept, P(1), P(0))).store(bundle_.steps + i);
    const std::uint32_t used = lanes_in_use<P>(i, bundle_.count) & bits(active);
    count_steps(used, bits(accept));
    if ((bits(error2 < P(std::numeric_limits<S>::max())) & used) != used) counts_.complete = false;
    if ((bits(arrived) & used) == used) return;  // all are finished
    (h * step_rule::step_factor(error2, method.error_order)).store(bundle_.trial + i);
    if (method.first_same_as_last) {
      const Vec3<P> last = load<P>(bundle_.k[method.stage_count - 1], i);
      store(select(accept, last, load<P>(bundle_.k[0], i)), bundle_.k[0], i);
      select(accept, P::load(bundle_.last_width + i), P::load(bundle_.width + i)).store(bundle_.width + i);
    }
  }

  void count_steps(std::uint32_t active, std::uint32_t accepted) {
    const int taken = __builtin_popcount(active & accepted);
    counts_.accepted += static_cast<std::uint64_t>(taken);
    counts_.rejected += static_cast<std::uint64_t>(__builtin_popcount(active) - taken);
  }

  // Writes the results of the lanes that are done.
  void keep_results() {
    if (slots_are_lanes_) {  // those of the others are overwritten later
      for (int axis = 0; axis < 3; ++axis) copy_numbers(bundle_.moved[axis], bundle_.result[axis]);
      copy_numbers(bundle_.steps, bundle_.result_steps);
      return;
    }
    std::uint16_t done[kBundle];
    const std::size_t count = done_.list(done);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t lane = done[k];
      const std::size_t slot = bundle_.slot[lane];
      for (int axis = 0; axis < 3; ++axis) bundle_.result[axis][slot] = bundle_.moved[axis][lane];
      bundle_.result_steps[slot] = bundle_.steps[lane];
    }
  }

  void copy_numbers(const S* from, S* to) const {
    for (std::size_t i = 0; i < lanes(); i += P::kSize) P::load(from + i).store(to + i);
  }

  const SegmentTask<S>& segment_;
  const GroupTask<S>& group_;
  Bundle<S>& bundle_;
  BundlePoints<P> points_;
  BundleField<P> field_;
  GroupCounts counts_;
  LaneSet done_;
  bool slots_are_lanes_ = true;
};

// The number of packs that a stage evaluates together: four with the 32 registers of AVX-512, otherwise two. Sets need
// the bits of all lanes, and have two.
#if defined(__wasm__)
template <class P, template <class> class R>
using StagePack = P;  // one fills the registers
#else
template <class P, template <class> class R>
using StagePack = std::conditional_t<sizeof(P) == 64 && !std::is_same_v<R<float>, SetPoints<float>>,
                                     PackPair<PackPair<P>>, PackPair<P>>;
#endif

template <class P, class PD, template <class> class M, template <class> class R>
FieldKernel<typename P::Scalar> field_kernel() {
  using S = typename P::Scalar;
  using F = KernelField<S, M, R>;
  FieldKernel<S> kernel;
  kernel.stage = &stage<StagePack<P, R>, F, S>;
  kernel.classify = &classify<PD, F, false>;
  if constexpr (std::is_same_v<R<S>, HalfSpace<S>>) kernel.limit = &limit_by_turning<P, F, S>;
  return kernel;
}

template <class P, class PD, template <class> class M, template <class> class R>
FieldKernel<typename P::Scalar> masked_kernel() {
  using S = typename P::Scalar;
  using F = MaskedKernelField<S, M, R>;
  FieldKernel<S> kernel;
  kernel.stage = &masked_stage<P, F, S>;
  kernel.classify = &classify<PD, F, true>;
  kernel.limit = &limit_by_mask<P, F, S>;
  if constexpr (std::is_same_v<R<S>, HalfSpace<S>>) kernel.limit = &limit_by_mask_and_turning<P, F, S>;
  kernel.limits_place = true;
  return kernel;
}

template <class P, class PD, template <class> class M>
void add_motion(Kernels<typename P::Scalar>& kernels, MotionKind kind) {
  kernels.fields[kind][kBall] = field_kernel<P, PD, M, Ball>();
  kernels.fields[kind][kCapsule] = field_kernel<P, PD, M, Capsule>();
  kernels.fields[kind][kHalfSpace] = field_kernel<P, PD, M, HalfSpace>();
  kernels.fields[kind][kSet] = field_kernel<P, PD, M, SetPoints>();
  kernels.masked[kind][kBall] = masked_kernel<P, PD, M, Ball>();
  kernels.masked[kind][kCapsule] = masked_kernel<P, PD, M, Capsule>();
  kernels.masked[kind][kHalfSpace] = masked_kernel<P, PD, M, HalfSpace>();
  kernels.masked[kind][kSet] = masked_kernel<P, PD, M, SetPoints>();
}

template <class P>
GroupCounts move_group(const SegmentTask<typename P::Scalar>& segment, const GroupTask<typename P::Scalar>& group) {
  return GroupMover<P>(segment, group).run();
}

// PD: the pack of doubles in which points are classified.
template <class P, class PD>
Kernels<typename P::Scalar> kernels_of() {
  Kernels<typename P::Scalar> kernels;
  add_motion<P, PD, Translation>(kernels, kTranslation);
  add_motion<P, PD, Rotation>(kernels, kRotation);
  add_motion<P, PD, Twist>(kernels, kTwist);
  add_motion<P, PD, Strain>(kernels, kStrain);
  kernels.pins = pin_kernel<P, PD, false>();
  kernels.masked_pins = pin_kernel<P, PD, true>();
  kernels.grid = grid_kernel<P, PD, false>();
  kernels.masked_grid = grid_kernel<P, PD, true>();
  kernels.sum = sum_kernel<P>();
  kernels.move = &move_group<P>;
  return kernels;
}

template <class Float, class Double>
KernelTable table_of(const char* name) {
  return {name,
          kernels_of<Float, Double>(),
          kernels_of<Double, Double>(),
          jacobian_kernels_of<Double, 0>(),
          jacobian_kernels_of<Double, 1>(),
          jacobian_kernels_of<Double, kTangents>()};
}

}  // namespace knead::detail
