// Rigid motions: nearest rotations, and screws.
#include "skin/rigid.h"

#include "math/elementary.h"

namespace knead::detail {

namespace {

constexpr double kNoTurn = 1e-9;  // sine of half an angle: below it a motion only slides

Quaternion quaternion_of(const Mat3d& r) {
  // Of the four forms the one without cancellation.
  const double t = trace(r);
  if (t > 0) {
    const double s = 2 * std::sqrt(t + 1);
    return {s / 4, Vec3d{r.row2.y - r.row1.z, r.row0.z - r.row2.x, r.row1.x - r.row0.y} / s};
  }
  const std::array<double, 3> diagonal{r.row0.x, r.row1.y, r.row2.z};
  const auto row = [&](std::size_t i) { return i == 0 ? r.row0 : i == 1 ? r.row1 : r.row2; };
  std::size_t i = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (diagonal[k] > diagonal[i]) i = k;
  }
  const std::size_t j = (i + 1) % 3;
  const std::size_t k = (i + 2) % 3;
  const double s = 2 * std::sqrt(1 + diagonal[i] - diagonal[j] - diagonal[k]);
  Quaternion q;
  q.w = (row(k)[j] - row(j)[k]) / s;
  q.v[i] = s / 4;
  q.v[j] = (row(j)[i] + row(i)[j]) / s;
  q.v[k] = (row(k)[i] + row(i)[k]) / s;
  return q;
}

}  // namespace

Quaternion turn_of(const Mat3d& m) {
  const Quaternion q = quaternion_of(nearest_rotation(m));
  const double size = std::sqrt(q.w * q.w + dot(q.v, q.v));
  return {q.w / size, q.v / size};
}

double angle_of(const Quaternion& turn) { return 2 * elementary::atan2(norm(turn.v), std::abs(turn.w)); }

std::vector<BoneTransform> motions_of(const Skin& skin, const SkinPose& pose) {
  std::vector<BoneTransform> motions;
  motions.reserve(pose.size());
  for (std::size_t b = 0; b < pose.size(); ++b) {
    // A bone at rest moves nothing: its points stay bit-identical.
    motions.push_back(pose[b] == skin.rest[b] ? BoneTransform{} : after(pose[b], inverse(skin.rest[b])));
  }
  return motions;
}

Rigid rigid_part(const BoneTransform& motion, const Vec3d& at) {
  const Quaternion turn = turn_of(motion.linear);
  return {turn, apply(motion, at) - turn * at};
}

Screw screw_of(const Rigid& motion, const Vec3d& near) {
  Screw screw;
  const Quaternion q = motion.turn.w < 0 ? Quaternion{-motion.turn.w, -motion.turn.v} : motion.turn;
  const double sine = norm(q.v);
  const Vec3d shift = motion(near) - near;
  screw.center = near;
  if (sine < kNoTurn) {
    screw.slide = shift;
    return screw;
  }
  screw.axis = q.v / sine;
  screw.angle = angle_of(q);
  screw.slide = screw.axis * dot(shift, screw.axis);
  const Vec3d across = shift - screw.slide;
  // The centre is as far as a chord of that angle needs.
  screw.center = near + (across + cross(screw.axis, across) * (q.w / sine)) * 0.5;
  return screw;
}

Rigid Screw::at(double part) const {
  const SinCos<double> half = sincos(0.5 * angle * part);
  const Quaternion turn{half.cos, axis * half.sin};
  return {turn, center - turn * center + slide * part};
}

}  // namespace knead::detail
