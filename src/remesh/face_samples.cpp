// Samples inside large faces show what a deformation smaller than a face does there.
#include "remesh/face_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace knead::detail {

namespace {

constexpr int kMaxDepth = 8;             // how often a face is divided into four
constexpr double kMaxSamples = 1 << 20;  // 50 MB
constexpr std::size_t kFirstBatch = 16;  // shows what carrying the others costs

std::array<std::array<Vec3d, 3>, 4> quarters(const std::array<Vec3d, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3d ab = (a + b) * 0.5;
  const Vec3d bc = (b + c) * 0.5;
  const Vec3d ca = (c + a) * 0.5;
  return {{{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}};
}

Vec3d center_of(const std::array<Vec3d, 3>& corners) { return (corners[0] + corners[1] + corners[2]) / 3.0; }

}  // namespace

FaceSamples::FaceSamples(const Deformation& deformation, const Progress* progress)
    : deformation_(deformation), progress_(progress), max_samples_(std::min(kMaxSamples, points_left())) {}

double FaceSamples::points_left() const { return deformation_.points_left ? deformation_.points_left() : kInfinity; }

void FaceSamples::refuse(std::size_t max_vertices) const {
  throw RemeshLimit(fmt::format(
      "the faces are large beside the smallest detail of this stroke ({:.2g}): to look for it inside them is more work "
      "than \"max_vertices\" ({}) allows; refine the shape first (knead remesh --max-edge), or use a larger "
      "\"max_vertices\"",
      deformation_.feature, max_vertices));
}

bool FaceSamples::is_large(const std::array<Vec3d, 3>& before) const {
  const double limit = 0.5 * deformation_.feature;
  const double longest2 =
      std::max({norm2(before[1] - before[0]), norm2(before[2] - before[1]), norm2(before[0] - before[2])});
  return longest2 > limit * limit;
}

void FaceSamples::add(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after) {
  if (is_large(before)) divide(face, before, after, 0);
}

void FaceSamples::divide(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after,
                         int depth) {
  stop_if_cancelled(progress_);
  if (static_cast<double>(before_.size()) > max_samples_) return;
  const Vec3d center = center_of(before);
  const double radius =
      std::sqrt(std::max({norm2(before[0] - center), norm2(before[1] - center), norm2(before[2] - center)}));
  if (deformation_.may_move && !deformation_.may_move(center, radius)) return;
  const double feature = deformation_.feature_near ? deformation_.feature_near(center, radius) : deformation_.feature;
  if (radius < 0.25 * feature || depth == kMaxDepth) {
    faces_.push_back(face);
    before_.push_back(center);
    after_.push_back(center_of(after));
    return;
  }
  const auto parts_before = quarters(before);
  const auto parts_after = quarters(after);
  for (std::size_t i = 0; i < 4; ++i) divide(face, parts_before[i], parts_after[i], depth + 1);
}

std::optional<std::vector<std::uint32_t>> FaceSamples::deviating_faces(double distance,
                                                                       const DistanceOf& distance_of) const {
  if (static_cast<double>(before_.size()) > max_samples_) return std::nullopt;
  std::vector<Vec3d> carried = before_;
  std::size_t batch = kFirstBatch;
  for (std::span<Vec3d> left = carried; !left.empty(); batch *= 2) {
    if (static_cast<double>(left.size()) > points_left()) return std::nullopt;
    const std::size_t count = std::min(batch, left.size());
    deformation_.carry(left.first(count));
    left = left.subspan(count);
  }
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < carried.size(); ++i) {
    // A sample that does not move is correct, although the centre of the face is rounded.
    const bool rests = carried[i] == before_[i] && norm(after_[i] - before_[i]) <= distance;
    if (rests || distance_of(faces_[i], carried[i] - after_[i]) <= distance) continue;
    if (found.empty() || found.back() != faces_[i]) found.push_back(faces_[i]);
  }
  return found;
}

}  // namespace knead::detail
