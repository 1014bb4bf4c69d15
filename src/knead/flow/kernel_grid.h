// Potential grids: path lines side by side in v = curl A (field/grid_view.h). Internal to the flow room: part of the
// one source of all kernels.
//
// The lanes of a pack that lie in one cell read its numbers once, in every lane the same. Where there are several
// cells, all lanes are summed for each of them, and each lane keeps the sums of its own: what is done for a lane does
// not depend on its neighbours.
#pragma once

#include "knead/flow/kernel_stage.h"

namespace knead::detail {

// Calls body(node, mask) for each used cell that lanes of a pack lie in: its first node, and the lanes in it.
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

template <class P>
KNEAD_INLINE Vec3<P> select_vector(const typename P::Mask& mask, const Vec3<P>& a, const Vec3<P>& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}

// v, and A under a mask, of the lanes.
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
    result.velocity = select_vector(here, sum.velocity, result.velocity);
    if constexpr (with_potential) result.potential = select_vector(here, sum.potential, result.potential);
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

// Where v depends on the time it may still grow: up to what it is at the segment's end.
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

// Points in used cells; all others rest, and are never reached.
template <class P, class S>
[[gnu::flatten]] Classified classify_by_grid(const void* data, const BlockTask& task) {
  const auto& field = *static_cast<const GridKernelField<S>*>(data);
  Classified result;
  for (std::size_t i = 0; i < kBlock; i += P::kSize) {
    const std::uint32_t members = static_cast<std::uint32_t>(task.members >> i) & ((std::uint64_t{1} << P::kSize) - 1);
    if (members == 0) continue;
    const Vec3<P> x{P::load(task.points.x + i), P::load(task.points.y + i), P::load(task.points.z + i)};
    const GridPlace<P> place = place_in(field.exact_grid, x - Vec3<P>(field.center));
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

}  // namespace knead::detail
