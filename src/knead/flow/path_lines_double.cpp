#include "knead/flow/path_lines.h"

namespace knead::detail {

template SegmentMover path_lines_in<double>(const Segment&, const AdvectOptions&);

}  // namespace knead::detail
