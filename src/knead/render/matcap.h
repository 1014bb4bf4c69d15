// The pictures of balls that matcaps are.
#pragma once

#include <vector>

#include "knead/render/scene.h"
#include "knead/render/surface.h"

namespace knead::render {

// Returns size * size pixels, rows from the bottom up: what a ball that fills this square looks like from the front.
// Beyond its outline stand the colours of the outline. Valid: size >= 2.
std::vector<Bytes4> matcap_picture(Matcap matcap, int size);

}  // namespace knead::render
