// Colors of every number type.
#pragma once

#include <algorithm>
#include <cmath>

#include "knead/mesh/mesh.h"

namespace knead::io_detail {

// What a value of a color is multiplied with to be from 0 to 1.
inline double unit_scale(NumberType type) {
  if (type == NumberType::uint8) return 1.0 / 255;
  return type == NumberType::uint16 ? 1.0 / 65535 : 1.0;
}

// A value of a color as a whole number from 0 to 255.
inline double as_byte(double value, NumberType type) {
  return type == NumberType::uint8 ? value : std::round(std::clamp(value * unit_scale(type), 0.0, 1.0) * 255);
}

}  // namespace knead::io_detail
