// What moves points: a function of advect's type.
#pragma once

#include <functional>
#include <span>

#include "knead/flow/advect.h"

namespace knead {

// As advect(flow, points, options), elsewhere: on a GPU (gpu/gpu.h), say. Points that no tool touches keep
// their bits; others are where advect puts them up to the tolerance, not to the bit. An empty one stands for advect.
using Backend = std::function<AdvectResult(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options)>;

}  // namespace knead
