// A material as a picture of a ball of it.
#pragma once

#include <vector>

#include "knead/render/surface.h"

namespace knead::render {

// size * size pixels, rows from the bottom up: what the ball in this square looks like from the front, for a white
// material; beyond its outline the colours of the outline. Valid: size >= 2.
std::vector<Bytes4> matcap_picture(int size);

}  // namespace knead::render
