// A smooth curve through the points of a path. Internal to the tool room.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "knead/math/vec3.h"

namespace knead::tool_detail {

// The curve through all points, in order: a cubic Hermite curve with centripetal parameters (Yuksel, Schaefer and
// Keyser 2011) and tangents of the parabolas through three neighbours, so that few points of a smooth curve give nearly
// the curve that many of them give (third order). A point that repeats the one before counts once.
class PathCurve {
 public:
  explicit PathCurve(std::span<const Vec3d> points);  // 1 or more

  double length() const { return lengths_.back(); }

  // The point at that arc length from the beginning, clamped to [0, length()].
  Vec3d at(double length) const;

 private:
  Vec3d on_piece(std::size_t piece, double fraction) const;

  std::vector<Vec3d> points_;
  std::vector<double> knots_;
  std::vector<Vec3d> tangents_;  // per unit of the knots
  std::vector<double> lengths_;  // at the ends of equal parts of every piece
};

}  // namespace knead::tool_detail
