// The shapes that are given by a distance: hand, figure and letter Y. Their parts are blended smoothly.
#include <algorithm>
#include <array>
#include <cmath>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/polygonise.h"

namespace knead {
namespace {

struct Ball {
  Vec3d center;
  double radius = 0;
};

// The convex hull of two balls; neither contains the other.
struct Cone {
  Ball a;
  Ball b;
};

// Returns the exact distance (Quilez, "Round cone").
double distance(const Cone& cone, const Vec3d& p) {
  const Vec3d ba = cone.b.center - cone.a.center;
  const double l2 = norm2(ba);
  const double rr = cone.a.radius - cone.b.radius;
  const double a2 = l2 - rr * rr;
  const Vec3d pa = p - cone.a.center;
  const double y = dot(pa, ba);
  const double z = y - l2;
  const double x2 = norm2(pa * l2 - ba * y);
  const double y2 = y * y * l2;
  const double z2 = z * z * l2;
  const double k = (rr < 0 ? -1.0 : 1.0) * rr * rr * x2;
  if ((z < 0 ? -1.0 : 1.0) * a2 * z2 > k) return std::sqrt(x2 + z2) / l2 - cone.b.radius;
  if ((y < 0 ? -1.0 : 1.0) * a2 * y2 < k) return std::sqrt(x2 + y2) / l2 - cone.a.radius;
  return (std::sqrt(x2 * a2 / l2) + y * rr) / l2 - cone.a.radius;
}

double distance(const Ball& ball, const Vec3d& p) { return norm(p - ball.center) - ball.radius; }

// Returns the smaller of two distances, rounded off if they differ by less than `width`. Its gradient is a mean of
// theirs.
double blend_min(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width * 0.25;
}

double blend_max(double a, double b, double width) { return -blend_min(-a, -b, width); }

// The hand: bones, muscles and pads are cones with round ends.

constexpr double kNowhere = 1e9;

// The joints of a finger from knuckle to tip, and its radius at each.
using Joints = std::array<Ball, 4>;

constexpr std::array<Joints, 4> kFingers{{
    {{{{0.305, 0.070, -0.006}, 0.093},
      {{0.344, 0.408, -0.005}, 0.086},
      {{0.368, 0.632, 0.015}, 0.075},
      {{0.381, 0.761, 0.035}, 0.062}}},
    {{{{0.100, 0.100, -0.014}, 0.095},
      {{0.107, 0.480, -0.015}, 0.089},
      {{0.112, 0.730, 0.005}, 0.077},
      {{0.115, 0.876, 0.025}, 0.063}}},
    {{{{-0.100, 0.060, -0.010}, 0.091},
      {{-0.138, 0.413, -0.010}, 0.084},
      {{-0.163, 0.647, 0.010}, 0.073},
      {{-0.175, 0.785, 0.030}, 0.060}}},
    {{{{-0.300, -0.020, 0.002}, 0.081},
      {{-0.366, 0.242, 0.005}, 0.073},
      {{-0.405, 0.402, 0.020}, 0.063},
      {{-0.430, 0.509, 0.035}, 0.053}}},
}};

constexpr std::array<Ball, 3> kThumb{
    {{{0.430, -0.190, 0.130}, 0.112}, {{0.590, 0.050, 0.190}, 0.092}, {{0.670, 0.215, 0.215}, 0.066}}};

Ball shifted(const Ball& ball, double z, double grow) { return {ball.center + Vec3d{0, 0, z}, ball.radius + grow}; }

Ball between(const Ball& a, const Ball& b, double t) {
  return {a.center * (1 - t) + b.center * t, a.radius * (1 - t) + b.radius * t};
}

// A soft cushion on the palm side of a bone.
double pad(const Ball& a, const Ball& b, const Vec3d& p) {
  return distance({shifted(between(a, b, 0.3), 0.022, -0.015), shifted(between(a, b, 0.7), 0.022, -0.015)}, p);
}

double finger(const Joints& j, const Vec3d& p) {
  double d = distance({j[0], j[1]}, p);
  d = blend_min(d, distance({j[1], j[2]}, p), 0.02);
  d = blend_min(d, distance({j[2], j[3]}, p), 0.02);
  for (std::size_t i = 1; i < 3; ++i) {  // the knuckles, on the back
    d = blend_min(d, distance(shifted(j[i], -0.018, -0.014), p), 0.03);
  }
  for (std::size_t i = 0; i < 3; ++i) d = blend_min(d, pad(j[i], j[i + 1], p), 0.04);
  return d;
}

double thumb(const Vec3d& p) {
  double d = blend_min(distance({kThumb[0], kThumb[1]}, p), distance({kThumb[1], kThumb[2]}, p), 0.02);
  d = blend_min(d, distance(shifted(kThumb[1], -0.016, -0.012), p), 0.03);
  const Ball heel{between(kThumb[1], kThumb[2], 0.35).center + Vec3d{-0.012, 0, 0.014}, 0.074};
  return blend_min(d, distance({heel, {kThumb[2].center + Vec3d{-0.01, -0.01, 0.008}, 0.06}}, p), 0.04);
}

// From the wrist to each knuckle, and the knuckle's back.
double metacarpals(const Vec3d& p) {
  constexpr std::array<Vec3d, 4> kCarpals{
      {{0.165, -0.57, 0.0}, {0.06, -0.58, -0.01}, {-0.05, -0.58, -0.01}, {-0.155, -0.57, 0.0}}};
  double d = kNowhere;
  for (std::size_t i = 0; i < 4; ++i) {
    const Ball& knuckle = kFingers[i][0];
    d = blend_min(d, distance({{kCarpals[i], 0.118}, shifted(knuckle, 0.004, 0)}, p), 0.08);
    d = blend_min(d, distance(shifted(knuckle, -0.018, -0.018), p), 0.08);
  }
  return d;
}

double palm(const Vec3d& p) {
  constexpr Cone kUnderFingers{{{0.26, -0.06, 0.035}, 0.080}, {{-0.25, -0.13, 0.035}, 0.075}};
  constexpr Cone kBallOfThumb{{{0.19, -0.48, 0.06}, 0.130}, {{0.36, -0.26, 0.105}, 0.120}};
  constexpr Cone kHeel{{{-0.19, -0.48, 0.05}, 0.108}, {{-0.29, -0.16, 0.035}, 0.090}};
  const double d = blend_min(metacarpals(p), distance(kUnderFingers, p), 0.10);
  return blend_min(blend_min(d, distance(kBallOfThumb, p), 0.12), distance(kHeel, p), 0.10);
}

double wrist(const Vec3d& p) {
  constexpr Cone kLeft{{{-0.13, -0.6, 0}, 0.112}, {{-0.13, -1.2, -0.01}, 0.118}};
  constexpr Cone kRight{{{0.13, -0.6, 0}, 0.112}, {{0.13, -1.2, -0.01}, 0.118}};
  constexpr Cone kMiddle{{{0, -0.6, 0}, 0.130}, {{0, -1.2, -0.01}, 0.142}};
  return blend_min(blend_min(distance(kLeft, p), distance(kRight, p), 0.10), distance(kMiddle, p), 0.10);
}

// Returns the distance of a finger. If its bounding ball is at least `enough` away, returns that lower bound instead.
double finger_within(const Joints& j, const Vec3d& p, double enough) {
  const double bound = norm(p - j[1].center) - 0.52;
  return bound < enough ? finger(j, p) : bound;
}

double fingers_within(const Vec3d& p, double enough) {
  double d = kNowhere;
  for (const Joints& j : kFingers) d = blend_min(d, finger_within(j, p, std::min(d + 0.03, enough)), 0.03);
  return d;
}

// Adds wrist and thumb only if they are near enough to change the result.
double body(const Vec3d& p) {
  double d = palm(p);
  if (p.y + 0.46 < d + 0.14) d = blend_min(d, wrist(p), 0.14);
  const Ball about_thumb{{0.53, -0.02, 0.17}, 0.4};
  return distance(about_thumb, p) < d + 0.08 ? blend_min(d, thumb(p), 0.08) : d;
}

double body_within(const Vec3d& p, double enough) {
  const double bound = p.y - 0.35;  // the thumb's tip
  return bound < enough ? body(p) : bound;
}

// The nearer of fingers and body is computed first; for the other a bound is often enough: farther than 0.09 away it
// has no effect on the blend.
double hand(const Vec3d& p) {
  const bool finger_first = p.y > 0.4;
  const double near = finger_first ? fingers_within(p, kNowhere) : body(p);
  const double other = finger_first ? body_within(p, near + 0.09) : fingers_within(p, near + 0.09);
  return blend_max(blend_min(near, other, 0.08), -0.95 - p.y, 0.06);
}

// The figure: a standing person, its arms apart.

template <std::size_t n>
double limb(const std::array<Ball, n>& joints, const Vec3d& p) {
  double d = distance(Cone{joints[0], joints[1]}, p);
  for (std::size_t i = 1; i + 1 < n; ++i) d = blend_min(d, distance(Cone{joints[i], joints[i + 1]}, p), 0.03);
  return d;
}

constexpr std::array<Ball, 4> kArm{
    {{{0.21, 0.475, 0}, 0.082}, {{0.49, 0.235, -0.01}, 0.06}, {{0.75, 0, 0.03}, 0.043}, {{0.86, -0.1, 0.045}, 0.05}}};
constexpr Cone kThumbSide{{{0.775, -0.02, 0.055}, 0.03}, {{0.835, -0.035, 0.12}, 0.024}};
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
  d = blend_min(d, blend_min(limb(kArm, p), distance(kThumbSide, p), 0.03), 0.07);
  return blend_min(d, blend_min(limb(kLeg, p), distance(kFoot, p), 0.05), 0.08);
}

double figure(const Vec3d& p) {
  const double d = blend_min(half(p), half({-p.x, p.y, p.z}), 0.06);
  const double top = blend_min(distance(kNeck, p), distance(kHead, p), 0.05);
  return blend_max(blend_min(d, top, 0.07), -0.99 - p.y, 0.03);
}

// The letter Y: a stem and two arms as strips of the plane, extruded with rounded edges.

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

Solid hand_solid() { return {hand, {{-0.55, -1.0, -0.22}, {0.8, 1.0, 0.34}}, 3.69}; }
Solid figure_solid() { return {figure, {{-0.95, -1.03, -0.2}, {0.95, 1.02, 0.26}}, 3.1}; }
Solid letter_y_solid() { return {letter_y, {{-0.5, -0.5, -0.2}, {0.5, 0.5, 0.2}}, 0.985}; }

std::span<const Finger> hand_fingers() {
  static const std::array<Finger, 5> fingers{{
      {"thumb", {0.484, -0.108, 0.150}, normalized(Vec3d{0.498, 0.849, 0.176}), 0.453, 0.119},
      {"index", {0.333, 0.313, -0.005}, normalized(Vec3d{0.107, 0.991, 0.082}), 0.520, 0.108},
      {"middle", {0.1045, 0.343, -0.015}, normalized(Vec3d{0.020, 0.998, 0.067}), 0.603, 0.113},
      {"ring", {-0.125, 0.293, -0.010}, normalized(Vec3d{-0.102, 0.992, 0.073}), 0.562, 0.107},
      {"little", {-0.330, 0.101, 0.003}, normalized(Vec3d{-0.237, 0.969, 0.068}), 0.480, 0.096},
  }};
  return fingers;
}

}  // namespace knead
