#include "knead/flow/lane_kernel.h"

namespace knead::detail {

template BoundKernel<float> lane_kernel<float>(const Segment&, double, const SegmentMask&);

}  // namespace knead::detail
