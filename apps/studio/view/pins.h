// How pins are seen.
#pragma once

#include <optional>
#include <vector>

#include "knead/render.h"
#include "studio.h"

namespace knead::studio {

inline constexpr render::Color kPlaced{0.95f, 0.55f, 0.10f, 1};    // what is placed
inline constexpr render::Color kLitHandle{1.0f, 0.85f, 0.25f, 1};  // what the pointer is on

// Blue pins hold, white ones are free, selected and dragged ones are orange; images are smaller.
void add_pins(const Studio& studio, std::vector<render::Line>& lines);

// The pin at the pointer, else the last one, about to be moved a little up in the picture.
std::optional<PinsStroke> hovering_pins(const Studio& studio);

}  // namespace knead::studio
