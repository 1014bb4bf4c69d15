// A ray and triangles, decided exactly.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "knead/math/box.h"
#include "knead/math/vec3.h"

namespace knead {

// A ray, prepared to be held against many triangles.
//
// Corners are sheared so that the ray becomes the z axis; the same corner always falls on the same place, and on which
// side of the axis an edge passes is decided exactly there, with an axis that stands for one beside it where the edge
// meets it. So of the triangles around an edge or a vertex the ray meets those that a ray just beside it does. (S.
// Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, with exact signs in place of
// inclusive ones.) Coordinates are finite; those that are not 0 lie between 1e-75 and 1e75 in magnitude.
class TriangleRay {
 public:
  TriangleRay(const Vec3d& origin, const Vec3d& direction);

  struct Meeting {
    double t = 0;         // of any sign
    bool leaves = false;  // to the side of the triangle's normal
  };
  std::optional<Meeting> meet(const std::array<Vec3d, 3>& corners) const;

  // The coordinate that is the largest of the direction: what becomes z.
  std::size_t axis() const { return axes_[2]; }

  // The least t >= 0 within the box, widened by slack; infinity where there is none, and for an empty box.
  double entry(const Box& box, double slack) const {
    const double pad = slack + reach_;
    double first = 0;
    double last = Box::kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
      const double low = (box.min[k] - origin_[k] - pad) * inverse_[k];
      const double high = (box.max[k] - origin_[k] + pad) * inverse_[k];
      first = std::max(first, inverse_[k] > 0 ? low : high);
      last = std::min(last, inverse_[k] > 0 ? high : low);
    }
    return first <= last * (1 + 1e-14) ? first * (1 - 1e-14) : Box::kInfinity;
  }

 private:
  Vec3d sheared(const Vec3d& p) const;

  Vec3d origin_;
  Vec3d inverse_;
  std::array<std::size_t, 3> axes_{};  // which coordinates become x, y and z
  Vec3d shear_;
  double reach_ = 0;  // of rounding in the origin
};

}  // namespace knead
