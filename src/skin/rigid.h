// Rigid motions as quaternions, and the screw between two of them. Internal to the skin module.
#pragma once

#include "knead/fit.h"
#include "knead/vec.h"
#include "math/geometry.h"

namespace knead::detail {

// p -> turn * p + offset.
struct Rigid {
  Quaternion turn{};
  Vec3d offset{0, 0, 0};

  Vec3d operator()(const Vec3d& p) const { return turn * p + offset; }
};

// a after b.
inline Rigid operator*(const Rigid& a, const Rigid& b) { return {a.turn * b.turn, a.turn * b.offset + a.offset}; }
inline Rigid inverse(const Rigid& a) {
  const Quaternion back = inverse(a.turn);
  return {back, -(back * a.offset)};
}

// A turn about an axis and a slide along it, which together are a rigid motion.
struct Screw {
  Vec3d axis{0, 0, 1};
  Vec3d center{0, 0, 0};  // the point of the axis nearest to the origin that was given
  double angle = 0;       // radians, from 0 to pi
  Vec3d slide{0, 0, 0};   // along the axis; without a turn in any direction

  // Returns a part of the motion, from 0 to 1.
  Rigid at(double part) const;
};

// Returns a transform times a point, the product a after b, and the inverse.
inline Vec3d apply(const BoneTransform& a, const Vec3d& p) { return a.linear * p + a.offset; }
inline BoneTransform after(const BoneTransform& a, const BoneTransform& b) {
  return {a.linear * b.linear, a.linear * b.offset + a.offset};
}
inline BoneTransform inverse(const BoneTransform& a) {
  const Mat3d back = inverse(a.linear);
  return {back, -(back * a.offset)};
}

// Returns the rotation nearest to a matrix with a positive determinant.
Quaternion turn_of(const Mat3d& m);

// Returns the motion of each bone from rest to the pose, as a transform of the shape's coordinates.
std::vector<BoneTransform> motions_of(const Skin& skin, const SkinPose& pose);

// Returns the rigid part of a motion: the nearest rotation, and the translation that moves `at` as the motion does.
Rigid rigid_part(const BoneTransform& motion, const Vec3d& at);

// Returns the screw of a motion, with the point of the axis nearest to `near` as its centre.
Screw screw_of(const Rigid& motion, const Vec3d& near);

// Returns the angle of a turn, radians from 0 to pi.
double angle_of(const Quaternion& turn);

}  // namespace knead::detail
