// Dual numbers (field/dual.h), and what tests of derivatives look at.
#pragma once

#include <cmath>

#include "field/dual.h"

namespace knead::test {

using knead::Dual;
using knead::values;
using knead::variables;

inline double divergence(const Vec3<Dual>& a) { return a.x.g.x + a.y.g.y + a.z.g.z; }

inline Vec3d curl(const Vec3<Dual>& a) { return {a.z.g.y - a.y.g.z, a.x.g.z - a.z.g.x, a.y.g.x - a.x.g.y}; }

// The greatest absolute entry of the Jacobian.
inline double jacobian_size(const Vec3<Dual>& a) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) size = std::fmax(size, std::abs(a[i].g[j]));
  }
  return size;
}

inline double jacobian_difference(const Vec3<Dual>& a, const Vec3<Dual>& b) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) size = std::fmax(size, std::abs(a[i].g[j] - b[i].g[j]));
  }
  return size;
}

}  // namespace knead::test
