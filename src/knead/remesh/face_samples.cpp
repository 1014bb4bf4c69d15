#include "knead/remesh/face_samples.h"

#include <algorithm>
#include <cmath>

namespace knead::remesh_detail {

namespace {

constexpr int kDeepest = 8;  // how often a face is divided into four

std::array<std::array<Vec3d, 3>, 4> quarters(const std::array<Vec3d, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3d ab = (a + b) * 0.5;
  const Vec3d bc = (b + c) * 0.5;
  const Vec3d ca = (c + a) * 0.5;
  return {{{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}};
}

Vec3d center_of(const std::array<Vec3d, 3>& corners) { return (corners[0] + corners[1] + corners[2]) / 3.0; }

}  // namespace

void FaceSamples::add(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after) {
  const double limit = 0.5 * deformation_.feature;
  const double longest2 =
      std::max({norm2(before[1] - before[0]), norm2(before[2] - before[1]), norm2(before[0] - before[2])});
  if (longest2 > limit * limit) divide(face, before, after, 0);
}

void FaceSamples::divide(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after,
                         int depth) {
  const Vec3d center = center_of(before);
  const double radius =
      std::sqrt(std::max({norm2(before[0] - center), norm2(before[1] - center), norm2(before[2] - center)}));
  if (deformation_.may_move && !deformation_.may_move(center, radius)) return;
  if (radius < 0.25 * deformation_.feature || depth == kDeepest) {
    faces_.push_back(face);
    before_.push_back(center);
    after_.push_back(center_of(after));
    return;
  }
  const auto parts_before = quarters(before);
  const auto parts_after = quarters(after);
  for (std::size_t i = 0; i < 4; ++i) divide(face, parts_before[i], parts_after[i], depth + 1);
}

std::vector<std::uint32_t> FaceSamples::deviating_faces(double distance) const {
  std::vector<Vec3d> carried = before_;
  deformation_.carry(carried);
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < carried.size(); ++i) {
    // A sample that does not move is right, whatever the rounding of the centre of the face.
    const bool rests = carried[i] == before_[i] && norm(after_[i] - before_[i]) <= distance;
    if (rests || norm(carried[i] - after_[i]) <= distance) continue;
    if (found.empty() || found.back() != faces_[i]) found.push_back(faces_[i]);
  }
  return found;
}

}  // namespace knead::remesh_detail
