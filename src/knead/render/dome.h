// The studio's light: a soft sky, a large key light, a fill and a rim, as many directional lights.
#pragma once

#include <vector>

#include "knead/render/view.h"

namespace knead::render {

// Light arriving from a direction. The irradiance of all lights on a plane facing up, with nothing in between, is
// about 1.
struct Light {
  Vec3f direction;  // unit, towards the light
  Vec3f radiance;   // linear red, green, blue; the share of this light included
};

// Returns `count` lights, at least 2, that are an even sample of the studio.
std::vector<Light> studio_lights(const View& view, int count);

}  // namespace knead::render
