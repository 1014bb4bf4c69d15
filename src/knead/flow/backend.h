// A function that moves points: advect() or another one of its type.
#pragma once

#include <functional>
#include <span>

#include "knead/flow/advect.h"

namespace knead {

// Moves points as advect(flow, points, options) does, for example on a GPU (gpu/gpu.h). Points that no tool reaches
// keep their bits; the others agree with advect up to the tolerance, not to the bit. An empty function stands for
// advect.
using Backend = std::function<AdvectResult(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options)>;

}  // namespace knead
