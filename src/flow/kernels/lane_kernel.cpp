#include "flow/kernels/lane_kernel.h"

namespace knead::detail {

template BoundKernel<double> lane_kernel<double>(const Segment&, double, const SegmentMask&);

template BoundKernel<float> lane_kernel<float>(const Segment&, double, const SegmentMask&);

}  // namespace knead::detail
