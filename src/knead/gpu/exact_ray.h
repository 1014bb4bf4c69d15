// A ray and a triangle, decided exactly. Internal to the gpu room.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "knead/math/vec3.h"

namespace knead::gpu {

// The room mesh's TriangleRay once more, which this room does not include: the same bits, as tests check. S. Woop, C.
// Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, with exact signs in place of inclusive
// ones. Coordinates are finite; those that are not 0 lie between 1e-75 and 1e75 in magnitude.
class ExactRay {
 public:
  ExactRay(const Vec3d& origin, const Vec3d& direction);

  struct Meeting {
    double t = 0;         // of any sign
    bool leaves = false;  // to the side of the triangle's normal
  };
  std::optional<Meeting> meet(const std::array<Vec3d, 3>& corners) const;

  // The coordinate that is the largest of the direction, and the shear that makes the ray that axis: what is taken from
  // the next coordinate and the one after it for each unit of this, and the scale along it.
  int axis() const { return static_cast<int>(axis_); }
  const Vec3d& shear() const { return shear_; }

 private:
  Vec3d sheared(const Vec3d& p) const;

  Vec3d origin_;
  Vec3d shear_;
  std::size_t axis_ = 0;
  bool is_mirrored_ = false;  // the direction is negative along the axis
};

}  // namespace knead::gpu
