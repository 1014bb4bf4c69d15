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

// At least `count` lights, a multiple of `groups`. The lights i with i % groups = g are for every g an even sample of
// the whole, so that neighbouring samples of one pixel may each look at another group.
std::vector<Light> studio_lights(const View& view, int count, int groups);

}  // namespace knead::render
