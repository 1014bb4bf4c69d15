// Private to shapes: the hand and the letter Y as signed distance bounds.
#pragma once

#include <algorithm>
#include <cmath>

#include "knead/math/box.h"

namespace knead::shapes_detail {

// A function that is negative inside, has Lipschitz constant 1 and is zero on a surface within the box.
struct Solid {
  double (*distance)(const Vec3d& p) = nullptr;
  Box box;
  double area = 0;  // of the surface, to about 5%
};

Solid hand_solid();
Solid letter_y_solid();

// Returns the smaller of two distances, rounded off if they differ by less than `width`. Its gradient is a mean of
// theirs.
inline double blend_min(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width * 0.25;
}

inline double blend_max(double a, double b, double width) { return -blend_min(-a, -b, width); }

}  // namespace knead::shapes_detail
