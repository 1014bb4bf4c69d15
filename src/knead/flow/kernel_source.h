// The table of all kernels for one type of pack in float and one in double. Internal to the flow room: included once by
// the source of every instruction set.
#pragma once

#include "knead/flow/kernel_driver.h"

namespace knead::detail {

template <class P, class PD, template <class> class M, template <class> class R>
FieldKernel<typename P::Scalar> field_kernel() {
  using S = typename P::Scalar;
  using F = KernelField<S, M, R>;
  FieldKernel<S> kernel;
  kernel.stage = &stage<P, F, S>;
  kernel.classify = &classify<PD, F>;
  if constexpr (std::is_same_v<R<S>, HalfSpace<S>>) kernel.limit = &limit_by_turning<P, F, S>;
  return kernel;
}

template <class P, class PD, template <class> class M>
void add_motion(FieldKernel<typename P::Scalar> (&row)[kRegionKinds]) {
  row[kBall] = field_kernel<P, PD, M, Ball>();
  row[kCapsule] = field_kernel<P, PD, M, Capsule>();
  row[kHalfSpace] = field_kernel<P, PD, M, HalfSpace>();
  row[kSet] = field_kernel<P, PD, M, SetPoints>();
}

template <class P>
GroupCounts move_group(const SegmentTask<typename P::Scalar>& segment, const GroupTask<typename P::Scalar>& group) {
  return GroupMover<P>(segment, group).run();
}

// PD: the pack of doubles that points are classified in.
template <class P, class PD>
Kernels<typename P::Scalar> kernels_of() {
  Kernels<typename P::Scalar> kernels;
  add_motion<P, PD, Translation>(kernels.fields[kTranslation]);
  add_motion<P, PD, Rotation>(kernels.fields[kRotation]);
  add_motion<P, PD, Twist>(kernels.fields[kTwist]);
  add_motion<P, PD, Strain>(kernels.fields[kStrain]);
  kernels.move = &move_group<P>;
  return kernels;
}

}  // namespace knead::detail
