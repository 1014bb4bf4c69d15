// Kernels of potential grids (field/grid.h) and of sums of segments. Internal: part of the one source of all kernels.
//
// Grids: the lanes of a pack that lie in one cell read its numbers once, the same in every lane. If there are several
// cells, all lanes are summed for each cell, and each lane keeps the sums of its own cell, so that the operations of a
// lane do not depend on its neighbours.
//
// Sums: a part evaluates to the bits that it has alone, and to exactly 0 beyond its support. Neighbours decide whether
// it is evaluated there, but not the sum. The additions form a butterfly, so that v at the mirror image of a point is
// the mirror image of v, bit for bit, if this is true of the parts.
#pragma once

#include <limits>

#include "flow/kernels/kernel_points.h"
#include "flow/kernels/kernel_stage.h"

namespace knead::detail {

// Calls body(node, mask) for each used cell of a pack's lanes: its first node, and the lanes in it.
template <class P, class S, class Body>
KNEAD_INLINE void for_each_cell(const GridView<S>& grid, const Vec3<P>& cell, std::uint32_t lanes, const Body& body) {
  using L = typename P::Scalar;
  alignas(64) L index[3][P::kSize];
  cell.x.store(index[0]);
  cell.y.store(index[1]);
  cell.z.store(index[2]);
  while (lanes != 0) {
    const auto lane = static_cast<std::size_t>(__builtin_ctz(lanes));
    const L x = index[0][lane];
    const L y = index[1][lane];
    const L z = index[2][lane];
    const auto here = (cell.x == P(x)) & (cell.y == P(y)) & (cell.z == P(z));
    lanes &= ~bits(here);
    const std::ptrdiff_t node = node_of(grid, static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
    if (grid.used[node] != 0) body(node, here);
  }
}

// Returns v of the lanes, and A if requested.
template <bool with_potential, class P, class S>
KNEAD_INLINE GridValue<P> evaluate_grid(const GridView<S>& grid, const Vec3<P>& y, const P& t, std::uint32_t lanes) {
  const GridPlace<P> place = place_in(grid, y);
  const GridWeights<P> weights = weights_at(place.within);
  GridValue<P> result;
  for_each_cell(grid, place.cell, lanes, [&](std::ptrdiff_t node, const auto& here) {
    GridValue<P> sum = sum_cell<with_potential>(grid, grid.numbers + 3 * node, weights);
    if (grid.end_numbers != nullptr) {
      const GridValue<P> end = sum_cell<with_potential>(grid, grid.end_numbers + 3 * node, weights);
      sum.velocity = mul_add(end.velocity - sum.velocity, t, sum.velocity);
      if constexpr (with_potential) sum.potential = mul_add(end.potential - sum.potential, t, sum.potential);
    }
    if (grid.growth != nullptr) add_growth(grid, grid.growth + node, weights, sum);
    result.velocity = select(here, sum.velocity, result.velocity);
    if constexpr (with_potential) result.potential = select(here, sum.potential, result.potential);
  });
  if constexpr (with_potential) result.potential = result.potential * P(grid.spacing);
  return result;
}

template <class P, bool masked, class S>
[[gnu::flatten]] void grid_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const GridKernelField<S> field = *static_cast<const GridKernelField<S>*>(data);
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    const std::uint32_t asked = bundle.asked.bits(i, P::kSize);
    if (asked == 0) continue;
    const auto [y, t] = place_in<P>(bundle, stage, i);
    const GridValue<P> value = evaluate_grid<masked>(field.grid, y, t, asked);
    Vec3<P> v = value.velocity;
    if constexpr (masked) {
      const MaskValue<P> m = evaluate_mask(field.mask, y);
      v = mul_add(v, m.value, cross(m.gradient, value.potential));
    }
    store(v, bundle.k[stage.out], i);
  }
}

// v that depends on the time may grow, up to v at the segment's end.
template <class P, bool masked, class S>
[[gnu::flatten]] void limit_grid(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const GridKernelField<S> field = *static_cast<const GridKernelField<S>*>(data);
  if constexpr (masked) limit_by_mask<P, GridKernelField<S>, S>(data, bundle, from_start, limits);
  if (field.grid.end_numbers == nullptr) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    Vec3<P> y = load<P>(bundle.base, i);
    if (!from_start) y = y + load<P>(bundle.moved, i);
    const GridValue<P> end = evaluate_grid<false>(field.grid, y, P(field.end), bundle.asked.bits(i, P::kSize));
    sqrt(norm2(end.velocity)).store(limits.speed + i);
  }
}

// Points in used cells are inside; all others rest and never move.
template <class P, class S>
[[gnu::flatten]] Classified classify_by_grid(const void* data, const BlockTask& task) {
  const auto& field = *static_cast<const GridKernelField<S>*>(data);
  Classified result;
  for (std::size_t i = 0; i < kBlock; i += P::kSize) {
    const std::uint32_t members = static_cast<std::uint32_t>(task.members >> i) & ((std::uint64_t{1} << P::kSize) - 1);
    if (members == 0) continue;
    const GridPlace<P> place = place_in(field.exact_grid, load<P>(task.points, i) - Vec3<P>(field.center));
    std::uint32_t inside = 0;
    for_each_cell(field.exact_grid, place.cell, members,
                  [&](std::ptrdiff_t /*node*/, const auto& here) { inside |= bits(here); });
    result.inside |= std::uint64_t{inside & members} << i;
  }
  return result;
}

template <class P, class PD, bool masked>
FieldKernel<typename P::Scalar> grid_kernel() {
  using S = typename P::Scalar;
  FieldKernel<S> kernel;
  kernel.stage = &grid_stage<P, masked, S>;
  kernel.classify = &classify_by_grid<PD, S>;
  kernel.limit = &limit_grid<P, masked, S>;
  kernel.limits_place = masked;
  return kernel;
}

// Loads three numbers of each lane of a pack: the vector, or from 3, 6 or 9 on a row of the matrix.
template <class P, std::size_t n>
KNEAD_INLINE Vec3<P> load_three(const JacobianBundle<n>& from, std::size_t first, std::size_t i) {
  return {P::load(from.of[first] + i), P::load(from.of[first + 1] + i), P::load(from.of[first + 2] + i)};
}

template <class P, std::size_t n>
KNEAD_INLINE void store_three(const Vec3<P>& v, JacobianBundle<n>& to, std::size_t first, std::size_t i) {
  v.x.store(to.of[first] + i);
  v.y.store(to.of[first + 1] + i);
  v.z.store(to.of[first + 2] + i);
}

// place_of(y, i): the cells of a pack's places, and the positions in them.
template <class P, class PlaceOf>
KNEAD_INLINE void find_grid_gradients(const GridKernelField<double>& field, const JacobianBundle<0>& places,
                                      const double* times, std::uint32_t asked, JacobianBundle<0>& slopes,
                                      const PlaceOf& place_of) {
  const GridView<double>& grid = field.grid;
  for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
    const std::uint32_t lanes = asked >> i & lanes_in_use<P>(i, kJacobianLanes);
    if (lanes == 0) continue;
    const P t = P::load(times + i);
    const GridPlace<P> place = place_of(load_three<P>(places, 0, i) - Vec3<P>(field.center), i);
    GridSlope<P> slope;
    for_each_cell(grid, place.cell, lanes, [&](std::ptrdiff_t node, const auto& here) {
      const GridSlope<P> sum = slope_in_cell(grid, node, place.within, t);
      slope.velocity = select(here, sum.velocity, slope.velocity);
      for (std::size_t row = 0; row < 3; ++row) slope.rows[row] = select(here, sum.rows[row], slope.rows[row]);
    });
    store_three(slope.velocity, slopes, 0, i);
    for (std::size_t row = 0; row < 3; ++row) store_three(slope.rows[row], slopes, 3 + 3 * row, i);
  }
}

template <class P>
void find_grid_gradients(const void* data, const JacobianBundle<0>& places, const double* times, std::uint32_t asked,
                         JacobianBundle<0>& slopes) {
  const auto& field = *static_cast<const GridKernelField<double>*>(data);
  find_grid_gradients<P>(field, places, times, asked, slopes,
                         [&](const Vec3<P>& y, std::size_t /*i*/) { return place_in(field.grid, y); });
}

// Returns the distance of a place from a part's support; negative inside.
template <class P, class S>
KNEAD_INLINE P gap_from(const SumPart<S>& part, const Vec3<P>& y, const P& t) {
  if (part.in_space) return dot(Vec3<P>(part.middle), y) - P(part.extent);
  const Vec3<P> d = neg_mul_add(Vec3<P>(part.by), t, y - Vec3<P>(part.middle));
  return sqrt(norm2(d)) - P(part.extent);
}

// Writes the motion and the time of the lanes in a stage to bundle.own.
template <class P, class S>
KNEAD_INLINE void place_lanes(const Bundle<S>& bundle, const Stage<S>& stage) {
  Bundle<S>& own = *bundle.own;
  own.count = bundle.count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    Vec3<P> moved{P(0), P(0), P(0)};
    P t = P::load(bundle.t + i);
    if (!stage.from_start) moved = load<P>(bundle.moved, i);
    if (stage.count > 0) {
      const P h = P::load(bundle.h + i);
      moved = mul_add(combine<P>(bundle, stage, i), h, moved);
      t = mul_add(h, P(stage.c), t);
    }
    store(moved, own.moved, i);
    t.store(own.t + i);
  }
}

// Prepares bundle.own for a part, and asks for the lanes that it may move. Returns whether there are any.
template <class P, class S>
KNEAD_INLINE bool ask_part(const SumPart<S>& part, const Bundle<S>& bundle) {
  Bundle<S>& own = *bundle.own;
  own.asked.clear();
  const Vec3<P> zero{P(0), P(0), P(0)};
  for (std::size_t i = 0; i < static_cast<std::size_t>(bundle.count); i += P::kSize) {
    const Vec3<P> base = load<P>(bundle.base, i);
    store(base - Vec3<P>(part.center), own.base, i);
    store(zero, own.k[0], i);
    const P gap = gap_from(part, base + load<P>(own.moved, i), P::load(own.t + i));
    own.asked.add(i, bits(gap < P(0)) & bundle.asked.bits(i, P::kSize));
  }
  if (own.asked.count() == 0) return false;
  for (std::size_t i = 0; part.kernel.by_lanes && i < static_cast<std::size_t>(bundle.count); ++i) {
    own.origins[i] = {bundle.origins[i].x0, nullptr};
  }
  return true;
}

// Writes the part's v in the asked lanes to own.k[0].
template <class S>
KNEAD_INLINE void evaluate_part(const SumPart<S>& part, Bundle<S>& own) {
  if (part.kernel.follow != nullptr) {
    part.kernel.follow(part.field, own);  // beyond all cells k_0 stays 0
  } else {
    part.kernel.stage(part.field, own, Stage<S>{});
  }
}

template <class P, class S>
[[gnu::flatten]] void sum_stage(const void* data, Bundle<S>& bundle, const Stage<S>& stage) {
  const auto& field = *static_cast<const SumKernelField<S>*>(data);
  const auto lanes = static_cast<std::size_t>(bundle.count);
  alignas(64) Lanes3<S> slopes[kMaxSummed];
  place_lanes<P>(bundle, stage);
  for (int k = 0; k < field.count; ++k) {
    if (ask_part<P>(field.parts[k], bundle)) evaluate_part(field.parts[k], *bundle.own);
    for (std::size_t i = 0; i < lanes; i += P::kSize) store(load<P>(bundle.own->k[0], i), slopes[k], i);
  }
  // Adds neighbours, then pairs of them, and so on, the order of images in one, two and three planes. Finally adds 0,
  // because a part that was not evaluated leaves 0, and one that was evaluated may leave -0.
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    for (int stride = 1; stride < field.count; stride *= 2) {
      for (int k = 0; k + stride < field.count; k += 2 * stride) {
        store(load<P>(slopes[k], i) + load<P>(slopes[k + stride], i), slopes[k], i);
      }
    }
    store(load<P>(slopes[0], i) + Vec3<P>{P(0), P(0), P(0)}, bundle.k[stage.out], i);
  }
}

// The limits of one part's own field.
template <class P, class S>
KNEAD_INLINE void limit_part(const SumPart<S>& part, const Bundle<S>& bundle, StepLimits<S>& limits) {
  const auto lanes = static_cast<std::size_t>(bundle.count);
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    P(0).store(limits.speed + i);
    P(part.reach).store(limits.reach + i);
    P(std::numeric_limits<S>::max()).store(limits.time + i);
  }
  if (part.kernel.limit == nullptr || !ask_part<P>(part, bundle)) return;
  Bundle<S>& own = *bundle.own;
  if (part.finds_width) part.kernel.stage(part.field, own, Stage<S>{});
  for (std::size_t i = 0; i < lanes; i += P::kSize) store(load<P>(bundle.k[0], i), own.k[0], i);
  part.kernel.limit(part.field, own, false, limits);
}

// The strictest part limits a step; a part at a distance allows a step that is longer by the distance. The mover
// divides the speed by the reach, so `speed` is chosen such that this is the greatest rate of a part.
template <class P, class S>
[[gnu::flatten]] void limit_sum(const void* data, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) {
  const auto& field = *static_cast<const SumKernelField<S>*>(data);
  const auto lanes = static_cast<std::size_t>(bundle.count);
  Stage<S> here;
  here.from_start = from_start;
  place_lanes<P>(bundle, here);
  alignas(64) StepLimits<S> part_limits;
  for (int k = 0; k < field.count; ++k) {
    const SumPart<S>& part = field.parts[k];
    limit_part<P>(part, bundle, part_limits);
    for (std::size_t i = 0; i < lanes; i += P::kSize) {
      const P t = P::load(bundle.own->t + i);
      const P gap = gap_from(part, load<P>(bundle.base, i) + load<P>(bundle.own->moved, i), t);
      const P reach = P::load(part_limits.reach + i) + maximum(gap, P(0));
      const P relative = sqrt(norm2(load<P>(bundle.k[0], i) - Vec3<P>(part.tool_velocity)));
      const P rate = (maximum(relative, P(part.tool_speed)) + P::load(part_limits.speed + i)) / reach;
      const P time = P::load(part_limits.time + i);
      (k == 0 ? rate : maximum(rate, P::load(limits.speed + i))).store(limits.speed + i);
      (k == 0 ? reach : minimum(reach, P::load(limits.reach + i))).store(limits.reach + i);
      (k == 0 ? time : minimum(time, P::load(limits.time + i))).store(limits.time + i);
    }
  }
  for (std::size_t i = 0; i < lanes; i += P::kSize) {
    const P speed = sqrt(norm2(load<P>(bundle.k[0], i)));
    mul_sub(P::load(limits.speed + i), P::load(limits.reach + i), speed).store(limits.speed + i);
  }
}

template <class P>
FieldKernel<typename P::Scalar> sum_kernel() {
  using S = typename P::Scalar;
  FieldKernel<S> kernel;
  kernel.stage = &sum_stage<P, S>;
  kernel.limit = &limit_sum<P, S>;
  kernel.limits_place = true;
  return kernel;
}

}  // namespace knead::detail
