// The shapes with rings: cylinder, torus, knot.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/solids.h"

namespace knead::shapes_detail {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::size_t rounded(double x, std::size_t least) {
  return std::max(least, static_cast<std::size_t>(std::fmax(0, std::floor(x + 0.5))));
}

double ratio(std::size_t a, std::size_t b) { return static_cast<double>(a) / static_cast<double>(b); }

// A closed curve with two unit vectors orthogonal to it at each point.
struct Spine {
  std::vector<Vec3d> points;
  std::vector<Vec3d> first;
  std::vector<Vec3d> second;
};

// Returns the tube of the given radius about a spine, with `around` vertices in each ring.
Mesh tube(const Spine& spine, std::size_t around, double radius) {
  Mesh mesh;
  const std::size_t along = spine.points.size();
  for (std::size_t i = 0; i < along; ++i) {
    for (std::size_t j = 0; j < around; ++j) {
      const auto [s, c] = sincos(kTurn * ratio(j, around));
      mesh.positions.push_back(spine.points[i] + (spine.first[i] * c + spine.second[i] * s) * radius);
    }
  }
  for (std::size_t i = 0; i < along; ++i) {
    const std::size_t here = i * around;
    const std::size_t there = (i + 1) % along * around;
    for (std::size_t j = 0; j < around; ++j) {
      const std::size_t k = (j + 1) % around;
      add_quad(mesh, here + j, here + k, there + k, there + j);
    }
  }
  return mesh;
}

// The numbers of vertices along and around a tube that make its quadrilaterals about square.
struct TubeGrid {
  std::size_t along;
  std::size_t around;
};
TubeGrid tube_grid(std::size_t vertices, double length, double radius) {
  const double wish = static_cast<double>(vertices);
  const std::size_t around = rounded(std::sqrt(wish * kTurn * radius / length), 4);
  return {rounded(wish / static_cast<double>(around), 3), around};
}

Vec3d knot_point(double t) {
  const auto [s2, c2] = sincos(2 * t);
  const auto [s3, c3] = sincos(3 * t);
  return {(2 + c3) * c2, (2 + c3) * s2, s3};
}

Vec3d knot_tangent(double t) {
  const auto [s2, c2] = sincos(2 * t);
  const auto [s3, c3] = sincos(3 * t);
  return normalized(Vec3d{-3 * s3 * c2 - 2 * (2 + c3) * s2, -3 * s3 * s2 + 2 * (2 + c3) * c2, 3 * c3});
}

// Returns the lengths of the knot from t = 0 to each of n + 1 parameters, by chords.
std::vector<double> knot_lengths(std::size_t n) {
  std::vector<double> lengths{0};
  for (std::size_t i = 0; i < n; ++i) {
    lengths.push_back(lengths.back() + norm(knot_point(kTurn * ratio(i + 1, n)) - knot_point(kTurn * ratio(i, n))));
  }
  return lengths;
}

// Returns the parameters of `count` points evenly spaced along the knot.
std::vector<double> even_parameters(const std::vector<double>& lengths, std::size_t count) {
  std::vector<double> parameters;
  const std::size_t n = lengths.size() - 1;
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double length = lengths.back() * ratio(i, count);
    while (lengths[k + 1] < length) ++k;
    const double within = (length - lengths[k]) / (lengths[k + 1] - lengths[k]);
    parameters.push_back(kTurn * (static_cast<double>(k) + within) / static_cast<double>(n));
  }
  return parameters;
}

// Returns v transported from one point of a curve to the next without rotation about the curve, by two reflections
// (Wang, Juettler, Zheng and Liu 2008).
Vec3d carried(const Vec3d& v, const Vec3d& step, const Vec3d& tangent, const Vec3d& next_tangent) {
  const auto reflected = [](const Vec3d& u, const Vec3d& n) { return u - n * (2 * dot(u, n) / norm2(n)); };
  return reflected(reflected(v, step), next_tangent - reflected(tangent, step));
}

// Returns the angle of the unit vector (c, s), from -pi to pi. Each round makes the error smaller than its cube. It
// calls only sincos, which gives the same bits everywhere.
double angle_of(double c, double s) {
  double angle = 0;
  for (int i = 0; i < 40; ++i) {
    const auto turned = sincos(angle);
    angle += s * turned.cos - c * turned.sin;
  }
  return angle;
}

// Transported frames do not close by themselves; the missing angle is spread evenly over the curve.
Spine knot_spine(const std::vector<double>& parameters) {
  const std::size_t n = parameters.size();
  Spine spine;
  std::vector<Vec3d> tangents;
  for (const double t : parameters) {
    spine.points.push_back(knot_point(t));
    tangents.push_back(knot_tangent(t));
  }
  std::vector<Vec3d> frames{any_orthogonal(tangents[0])};
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    frames.push_back(carried(frames[i], spine.points[j] - spine.points[i], tangents[i], tangents[j]));
  }
  const double missing = angle_of(dot(frames[n], frames[0]), dot(cross(frames[n], frames[0]), tangents[0]));
  for (std::size_t i = 0; i < n; ++i) {
    const auto [s, c] = sincos(missing * ratio(i, n));
    const Vec3d across = cross(tangents[i], frames[i]);
    spine.first.push_back(frames[i] * c + across * s);
    spine.second.push_back(across * c - frames[i] * s);
  }
  return spine;
}

struct CylinderGrid {
  std::size_t rings;  // around the centre of a cap; the cap has 6 * rings vertices at its rim
  std::size_t rows;   // along the side
};

// The rows follow from the rings. In all 6 m (rows + 1) + 2 (1 + 3 m (m - 1)) vertices.
CylinderGrid cylinder_grid(std::size_t vertices) {
  const double wish = static_cast<double>(vertices);
  const double side = 36 / std::numbers::pi;  // rows for each ring that make squares: 6 / (pi / 6 m)
  const std::size_t m = rounded(std::sqrt(wish / (6 * side + 6)), 1);
  const double rings = static_cast<double>(m);
  const double caps = 2 + 6 * rings * (rings - 1);
  return {m, rounded((wish - caps) / (6 * rings) - 1, 1)};
}

constexpr double kCylinderRadius = 0.5;

// Adds six sectors of a disk at z = height. Ring k has 6 k vertices; those of the outermost begin at `rim`.
void add_cap(Mesh& mesh, std::size_t rings, double height, std::size_t rim, bool up) {
  std::vector<std::size_t> start{mesh.vertex_count()};
  mesh.positions.emplace_back(0, 0, height);
  for (std::size_t k = 1; k < rings; ++k) {
    start.push_back(mesh.vertex_count());
    for (std::size_t i = 0; i < 6 * k; ++i) {
      const auto [s, c] = sincos(kTurn * ratio(i, 6 * k));
      mesh.positions.push_back(Vec3d{c, s, 0} * (kCylinderRadius * ratio(k, rings)) + Vec3d{0, 0, height});
    }
  }
  start.push_back(rim);
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) { add_triangle(mesh, a, up ? b : c, up ? c : b); };
  for (std::size_t k = 1; k <= rings; ++k) {
    const auto inner = [&](std::size_t i) { return k == 1 ? start[0] : start[k - 1] + i % (6 * (k - 1)); };
    const auto outer = [&](std::size_t i) { return start[k] + i % (6 * k); };
    for (std::size_t sector = 0; sector < 6; ++sector) {
      const std::size_t o = sector * k;
      const std::size_t n = sector * (k - 1);
      for (std::size_t i = 0; i < k; ++i) {
        add(inner(n + i), outer(o + i), outer(o + i + 1));
        if (i + 1 < k) add(inner(n + i), outer(o + i + 1), inner(n + i + 1));
      }
    }
  }
}

}  // namespace

void add_triangle(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c) {
  mesh.add_face(
      std::array{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
}

void add_quad(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
  const auto& p = mesh.positions;
  if (norm2(p[c] - p[a]) <= norm2(p[d] - p[b])) {
    add_triangle(mesh, a, b, c);
    add_triangle(mesh, a, c, d);
  } else {
    add_triangle(mesh, b, c, d);
    add_triangle(mesh, b, d, a);
  }
}

Mesh make_cylinder(std::size_t vertices) {
  const CylinderGrid grid = cylinder_grid(vertices);
  const std::size_t around = 6 * grid.rings;
  Mesh mesh;
  for (std::size_t row = 0; row <= grid.rows; ++row) {
    for (std::size_t i = 0; i < around; ++i) {
      const auto [s, c] = sincos(kTurn * ratio(i, around));
      mesh.positions.emplace_back(kCylinderRadius * c, kCylinderRadius * s, 6 * ratio(row, grid.rows) - 3);
    }
  }
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t i = 0; i < around; ++i) {
      const std::size_t k = (i + 1) % around;
      const std::size_t here = row * around;
      add_quad(mesh, here + i, here + k, here + around + k, here + around + i);
    }
  }
  add_cap(mesh, grid.rings, -3, 0, false);
  add_cap(mesh, grid.rings, 3, grid.rows * around, true);
  return mesh;
}

Mesh make_torus(std::size_t vertices) {
  const TubeGrid grid = tube_grid(vertices, kTurn, 0.3);
  Spine spine;
  for (std::size_t i = 0; i < grid.along; ++i) {
    const auto [s, c] = sincos(kTurn * ratio(i, grid.along));
    spine.points.emplace_back(c, s, 0);
    spine.first.emplace_back(c, s, 0);
    spine.second.emplace_back(0, 0, -1);
  }
  return tube(spine, grid.around, 0.3);
}

Mesh make_knot(std::size_t vertices) {
  const std::vector<double> lengths = knot_lengths(4096);
  const TubeGrid grid = tube_grid(vertices, lengths.back(), 0.45);
  return tube(knot_spine(even_parameters(lengths, grid.along)), grid.around, 0.45);
}

}  // namespace knead::shapes_detail

// The hand: bones, muscles and pads are cones with round ends, blended smoothly.
namespace knead {
namespace {

using shapes_detail::Ball;
using shapes_detail::blend_max;
using shapes_detail::blend_min;
using shapes_detail::Cone;
using shapes_detail::distance;

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

}  // namespace

namespace shapes_detail {

Solid hand_solid() { return {hand, {{-0.55, -1.0, -0.22}, {0.8, 1.0, 0.34}}, 3.69}; }

}  // namespace shapes_detail
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

// A standing person, its arms apart: cones with round ends, blended smoothly.

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

}  // namespace

namespace shapes_detail {

Solid figure_solid() { return {figure, {{-0.95, -1.03, -0.2}, {0.95, 1.02, 0.26}}, 3.1}; }

}  // namespace shapes_detail

}  // namespace knead
