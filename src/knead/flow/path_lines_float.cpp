#include "knead/flow/path_lines.h"

namespace knead::detail {

template SegmentMover path_lines_in<float>(const Segment&, const AdvectOptions&);

}  // namespace knead::detail
