// A standing person, its arms apart: cones with round ends, blended smoothly.
#include <array>

#include "knead/mesh/shapes_solids.h"

namespace knead {
namespace {

using shapes_detail::Ball;
using shapes_detail::blend_max;
using shapes_detail::blend_min;
using shapes_detail::Cone;
using shapes_detail::distance;

// A limb: cones between neighbouring balls.
template <std::size_t n>
double limb(const std::array<Ball, n>& joints, const Vec3d& p) {
  double d = distance(Cone{joints[0], joints[1]}, p);
  for (std::size_t i = 1; i + 1 < n; ++i) d = blend_min(d, distance(Cone{joints[i], joints[i + 1]}, p), 0.03);
  return d;
}

constexpr std::array<Ball, 4> kArm{
    {{{0.21, 0.475, 0}, 0.082}, {{0.49, 0.235, -0.01}, 0.06}, {{0.75, 0, 0.03}, 0.043}, {{0.86, -0.1, 0.045}, 0.05}}};
constexpr Cone kThumb{{{0.775, -0.02, 0.055}, 0.03}, {{0.835, -0.035, 0.12}, 0.024}};
constexpr std::array<Ball, 3> kLeg{
    {{{0.105, -0.06, 0}, 0.125}, {{0.15, -0.5, 0.015}, 0.085}, {{0.175, -0.9, -0.015}, 0.058}}};
constexpr Cone kFoot{{{0.175, -0.945, -0.03}, 0.06}, {{0.2, -0.96, 0.16}, 0.045}};
constexpr std::array<Ball, 2> kSide{{{{0.085, 0.0, 0}, 0.135}, {{0.09, 0.4, 0.005}, 0.14}}};
constexpr std::array<Ball, 2> kShoulder{{{{0.05, 0.44, 0}, 0.12}, {{0.19, 0.485, 0}, 0.085}}};
constexpr Cone kNeck{{{0, 0.5, -0.005}, 0.08}, {{0, 0.68, 0.01}, 0.066}};
constexpr Cone kHead{{{0, 0.855, 0}, 0.13}, {{0, 0.755, 0.035}, 0.095}};

// What lies on the side of +x.
double half(const Vec3d& p) {
  double d = blend_min(limb(kSide, p), limb(kShoulder, p), 0.08);
  d = blend_min(d, blend_min(limb(kArm, p), distance(kThumb, p), 0.03), 0.07);
  return blend_min(d, blend_min(limb(kLeg, p), distance(kFoot, p), 0.05), 0.08);
}

double figure(const Vec3d& p) {
  const double d = blend_min(half(p), half({-p.x, p.y, p.z}), 0.06);
  const double top = blend_min(distance(kNeck, p), distance(kHead, p), 0.05);
  return blend_max(blend_min(d, top, 0.07), -0.99 - p.y, 0.03);
}

}  // namespace

namespace shapes_detail {

Solid figure_solid() { return {figure, {{-0.95, -1.03, -0.2}, {0.95, 1.02, 0.26}}, 3.1}; }

}  // namespace shapes_detail

}  // namespace knead
