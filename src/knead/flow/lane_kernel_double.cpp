#include "knead/flow/lane_kernel.h"

namespace knead::detail {

template BoundKernel<double> lane_kernel<double>(const Segment&, double, const SegmentMask&);

}  // namespace knead::detail
