// The table of all kernels for one type of pack in float and one in double. Internal to the flow room: included once by
// the source of every instruction set.
#pragma once

#include "knead/flow/kernel_driver.h"
#include "knead/flow/kernel_grid.h"
#include "knead/flow/kernel_pins.h"
#include "knead/flow/kernel_sum.h"

namespace knead::detail {

// Two packs at a time are faster for moving balls and point sets, by 5% and 16% with AVX2; for others they are not.
#if defined(__wasm__)
template <class P, template <class> class M, template <class> class R>
using StagePack = P;  // whose operations fill the registers already
#else
template <class P, template <class> class M, template <class> class R>
using StagePack =
    std::conditional_t<std::is_same_v<M<float>, Translation<float>> &&
                           (std::is_same_v<R<float>, Ball<float>> || std::is_same_v<R<float>, SetPoints<float>>),
                       Twin<P>, P>;
#endif

template <class P, class PD, template <class> class M, template <class> class R>
FieldKernel<typename P::Scalar> field_kernel() {
  using S = typename P::Scalar;
  using F = KernelField<S, M, R>;
  FieldKernel<S> kernel;
  kernel.stage = &stage<StagePack<P, M, R>, F, S>;
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

// PD: the pack of doubles that points are classified in.
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

}  // namespace knead::detail
