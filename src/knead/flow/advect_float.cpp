#include "knead/flow/advect_segment.h"

namespace knead::detail {

template AdvectResult advect_segment<float>(const Segment&, std::span<Vec3d>, const AdvectOptions&);

}  // namespace knead::detail
