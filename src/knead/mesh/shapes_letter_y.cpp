// The letter Y: a stem and two arms as strips of the plane, extruded with rounded edges.
#include "knead/mesh/shapes_solids.h"

namespace knead::shapes_detail {
namespace {

constexpr double kHalfWidth = 0.085;  // of a stroke
constexpr double kHalfHeight = 0.4;
constexpr double kHalfThickness = 0.1;
constexpr double kRounding = 0.02;
constexpr double kArmEnd = 0.2944;  // x of the middle of an arm at its end: puts the outer corners at x = 0.4

// Every part is thinner by the radius of the rounding.
double stem(double x, double y) {
  return blend_max(std::abs(x) - (kHalfWidth - kRounding), std::max(-y - (kHalfHeight - kRounding), y), kRounding);
}

// The strip from the origin to (side * kArmEnd, kHalfHeight), cut level at the end.
double arm(double x, double y, double side) {
  const double length = std::sqrt(kArmEnd * kArmEnd + kHalfHeight * kHalfHeight);
  const double dx = side * kArmEnd / length;
  const double dy = kHalfHeight / length;
  const double across = std::abs(dy * x - dx * y) - (kHalfWidth - kRounding);
  return blend_max(across, std::max(y - (kHalfHeight - kRounding), -(dx * x + dy * y)), kRounding);
}

double letter_y(const Vec3d& p) {
  const double arms = blend_min(arm(p.x, p.y, -1), arm(p.x, p.y, 1), 0.03);
  const double outline = blend_min(stem(p.x, p.y), arms, 0.03);
  const double height = std::abs(p.z) - (kHalfThickness - kRounding);
  const double out = std::fmax(outline, 0);
  const double up = std::fmax(height, 0);
  return std::min(std::max(outline, height), 0.0) + std::sqrt(out * out + up * up) - kRounding;
}

}  // namespace

Solid letter_y_solid() { return {letter_y, {{-0.5, -0.5, -0.2}, {0.5, 0.5, 0.2}}, 0.985}; }

}  // namespace knead::shapes_detail
