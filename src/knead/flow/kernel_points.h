// The points of a group's blocks, into a bundle and back. Internal to the flow room: part of the one source of all
// kernels.
#pragma once

#include <algorithm>

#include "knead/flow/kernel_classify.h"

namespace knead::detail {

template <class T>
KNEAD_INLINE void fill(T* to, T value, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) to[k] = value;
}

template <class P>
class BundlePoints {
  using S = typename P::Scalar;

 public:
  BundlePoints(const SegmentTask<S>& segment, const GroupTask<S>& group)
      : segment_(segment), group_(group), bundle_(*group.bundle) {}

  void clear() {
    bundle_.count = 0;
    bundle_.piece_count = 0;
  }

  void decide(const BlockTask& task, Classified& found) {
    for (std::size_t i = 0; i < kBlock; ++i) {
      if ((found.undecided >> i & 1) == 0) continue;
      const Vec3d x{task.points.x[i], task.points.y[i], task.points.z[i]};
      const void* cell = nullptr;
      const double t = segment_.next_contact(segment_.contact_data, x, static_cast<double>(segment_.begin), cell);
      if (t > 1) continue;
      task.start[i] = t;
      found.later |= std::uint64_t{1} << i;
    }
  }

  // Appends the points of a block to the bundle, in runs of neighbours.
  void append(std::size_t first, const double* start, const Classified& found) {
    const std::uint64_t taken = found.inside | found.later;
    for (std::uint64_t rest = taken; rest != 0;) {
      const auto begin = static_cast<std::size_t>(__builtin_ctzll(rest));
      const std::uint64_t gaps = ~(rest >> begin);  // shifted in zeros are gaps too
      const std::size_t count = gaps == 0 ? kBlock : static_cast<std::size_t>(__builtin_ctzll(gaps));
      append_run(first + begin, count);
      rest = begin + count == kBlock ? 0 : rest >> (begin + count) << (begin + count);
    }
    if (found.later == 0) return;
    std::size_t lane = static_cast<std::size_t>(bundle_.count) - static_cast<std::size_t>(__builtin_popcountll(taken));
    for (std::size_t i = 0; i < kBlock; ++i) {
      if ((taken >> i & 1) == 0) continue;
      if ((found.later >> i & 1) != 0) {
        bundle_.t[lane] = static_cast<S>(start[i]);
        bundle_.at_contact[lane] = 1;
      }
      ++lane;
    }
  }

  std::size_t point_of(std::size_t slot) const {
    int k = 0;
    while (slot >= bundle_.pieces[k].lane + std::size_t{bundle_.pieces[k].count}) ++k;
    return bundle_.pieces[k].point + slot - bundle_.pieces[k].lane;
  }

  // Adds the results to the points. What has not moved has moved by -0, which changes no bits.
  void scatter(bool in_one_step) {
    const double most = greatest_result();
    for (int k = 0; k < bundle_.piece_count; ++k) {
      const Piece& piece = bundle_.pieces[k];
      note_moved(piece.point, most);
      std::uint32_t* const steps = group_.steps + piece.point;
      with_count(piece.count, [&](std::size_t n) {
        add_to(group_.points.x + piece.point, bundle_.result[0] + piece.lane, n);
        add_to(group_.points.y + piece.point, bundle_.result[1] + piece.lane, n);
        add_to(group_.points.z + piece.point, bundle_.result[2] + piece.lane, n);
        for (std::size_t i = 0; in_one_step && i < n; ++i) ++steps[i];
      });
      for (std::size_t i = 0; !in_one_step && i < piece.count; ++i) {
        steps[i] += static_cast<std::uint32_t>(bundle_.result_steps[piece.lane + i]);
      }
    }
  }

  void note_moved(std::size_t point, double by) {
    double& moved = group_.moved[point / kBlock];
    moved = by > moved ? by : moved;
  }

 private:
  void append_run(std::size_t point, std::size_t count) {
    const auto lane = static_cast<std::size_t>(bundle_.count);
    const Vec3d center = segment_.center;
    const S begin = segment_.begin;
    with_count(count, [&](std::size_t n) {
      copy(group_.points.x + point, center.x, bundle_.base[0] + lane, n);
      copy(group_.points.y + point, center.y, bundle_.base[1] + lane, n);
      copy(group_.points.z + point, center.z, bundle_.base[2] + lane, n);
      fill(bundle_.t + lane, begin, n);
      fill(bundle_.at_contact + lane, std::uint8_t{0}, n);
    });
    for (std::size_t k = 0; segment_.kernel.by_lanes && k < count; ++k) {
      const std::size_t i = point + k;
      bundle_.origins[lane + k] = {{group_.points.x[i], group_.points.y[i], group_.points.z[i]}, nullptr};
    }
    bundle_.pieces[bundle_.piece_count++] = {static_cast<std::uint16_t>(lane), static_cast<std::uint16_t>(point),
                                             static_cast<std::uint16_t>(count)};
    bundle_.count += static_cast<int>(count);
  }

  // Calls body with the count, for whole blocks as a constant: loops without a beginning and an end of their own.
  template <class Body>
  KNEAD_INLINE static void with_count(std::size_t count, const Body& body) {
    count == kBlock ? body(kBlock) : body(count);
  }

  KNEAD_INLINE static void copy(const double* from, double origin, S* __restrict to, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) to[k] = static_cast<S>(from[k] - origin);
  }

  KNEAD_INLINE static void add_to(double* __restrict to, const S* by, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) to[i] += static_cast<double>(by[i]);
  }

  // The greatest coordinate of a result.
  double greatest_result() const {
    P greatest(0);
    S most = 0;
    const Piece& last = bundle_.pieces[bundle_.piece_count - 1];
    const std::size_t count = std::size_t{last.lane} + last.count;
    for (int axis = 0; axis < 3; ++axis) {
      const S* const by = bundle_.result[axis];
      std::size_t i = 0;
      for (; i + P::kSize <= count; i += P::kSize) {
        const P result = P::load(by + i);
        greatest = maximum(greatest, maximum(result, -result));
      }
      for (; i < count; ++i) most = std::max(most, by[i] < S(0) ? -by[i] : by[i]);
    }
    S lane[P::kSize];
    greatest.store(lane);
    for (const S size : lane) most = std::max(most, size);
    return static_cast<double>(most);
  }

  const SegmentTask<S>& segment_;
  const GroupTask<S>& group_;
  Bundle<S>& bundle_;
};

}  // namespace knead::detail
