// Depth maps of what casts shadows, as directional lights see it. Drawn on the CPU: the triangles are about as small as
// a texel, and a software driver takes twenty times as long for them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/render/occluder.h"

namespace knead::render {

// From renderer units to 0..1 in a light's map, by columns (four of three numbers); the third is the depth, 0 nearest
// to the light.
using LightMatrix = std::array<float, 12>;

// Returns one map of size * size depths for each light, by rows: 0 to 65535, which is also where there is nothing.
// Triangles are pushed back by one and a half times their slope over a texel. Points are squares with this half side.
std::vector<std::uint16_t> draw_shadow_maps(const Occluder& occluder, std::span<const LightMatrix> lights, int size,
                                            double point_radius);

}  // namespace knead::render
