#include "knead/tool/path_curve.h"

#include <algorithm>
#include <cmath>

namespace knead::tool_detail {

namespace {

constexpr std::size_t kPartsPerPiece = 16;

// The derivative at the point i of the parabola through three neighbours among which it is; for two points, the line.
Vec3d parabola_tangent(const std::vector<Vec3d>& points, const std::vector<double>& knots, std::size_t i) {
  const std::size_t last = points.size() - 1;
  if (last == 0) return {0, 0, 0};
  if (last == 1) return (points[1] - points[0]) / (knots[1] - knots[0]);
  const std::size_t a = std::clamp<std::size_t>(i, 1, last - 1) - 1;
  const double h0 = knots[a + 1] - knots[a];
  const double h1 = knots[a + 2] - knots[a + 1];
  const Vec3d slope0 = (points[a + 1] - points[a]) / h0;
  const Vec3d slope1 = (points[a + 2] - points[a + 1]) / h1;
  const Vec3d half_curvature = (slope1 - slope0) / (h0 + h1);
  return slope0 + half_curvature * (2 * knots[i] - knots[a] - knots[a + 1]);
}

}  // namespace

PathCurve::PathCurve(std::span<const Vec3d> points) : points_(points.begin(), points.end()) {
  points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
  knots_.push_back(0);
  for (std::size_t i = 1; i < points_.size(); ++i) {
    knots_.push_back(knots_.back() + std::sqrt(norm(points_[i] - points_[i - 1])));
  }
  for (std::size_t i = 0; i < points_.size(); ++i) tangents_.push_back(parabola_tangent(points_, knots_, i));
  lengths_.push_back(0);
  Vec3d previous = points_.front();
  for (std::size_t piece = 0; piece + 1 < points_.size(); ++piece) {
    for (std::size_t part = 1; part <= kPartsPerPiece; ++part) {
      const Vec3d p = on_piece(piece, static_cast<double>(part) / kPartsPerPiece);
      lengths_.push_back(lengths_.back() + norm(p - previous));
      previous = p;
    }
  }
}

Vec3d PathCurve::at(double length) const {
  if (points_.size() == 1 || length <= 0) return points_.front();
  if (length >= lengths_.back()) return points_.back();
  const auto after = std::upper_bound(lengths_.begin(), lengths_.end(), length);
  const auto part = static_cast<std::size_t>(after - lengths_.begin()) - 1;
  const double within = (length - lengths_[part]) / (lengths_[part + 1] - lengths_[part]);
  return on_piece(part / kPartsPerPiece, (static_cast<double>(part % kPartsPerPiece) + within) / kPartsPerPiece);
}

Vec3d PathCurve::on_piece(std::size_t piece, double fraction) const {
  const double h = knots_[piece + 1] - knots_[piece];
  const double s = fraction;
  const double rest = 1 - s;
  return points_[piece] * (rest * rest * (1 + 2 * s)) + points_[piece + 1] * (s * s * (3 - 2 * s)) +
         (tangents_[piece] * rest - tangents_[piece + 1] * s) * (h * s * rest);
}

}  // namespace knead::tool_detail
