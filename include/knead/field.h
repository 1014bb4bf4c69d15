// The velocity field of one tool: blends (paper, Eq. 5), inner motions, masks, grids of potentials, and the formula
// v = curl(w A) that combines them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "knead/region.h"
#include "knead/vec.h"

namespace knead {

// The shape of a blend: its degree n. w falls from 1 at s = 0 to 0 at s = 1, where s = (r - inner) / (outer - inner).
//   n = 3:       w = (1 - s^3)^3
//   n = 4 to 7:  w = (1 - b)^2; b is the Bernstein polynomial of degree n whose coefficients are 0, 0, 0, 1, 1, ...
// 4 is the paper's blend. w has two continuous derivatives for each n, so the velocity has one. A greater n makes w
// fall closer to the inner region.
inline constexpr int kMinFalloff = 3;
inline constexpr int kDefaultFalloff = 4;
inline constexpr int kGreatestFalloff = 7;

// The falloff of pins: with w = (1 + 5 s)(1 - s)^5 a moving ball is the divergence-free kernel of a pin (method,
// section 9; knead/flow.h). w has two continuous derivatives for inner = 0.
inline constexpr int kPinFalloff = 0;
// With these weights the rotation and the strain of a ball are the kernels of a pin's turn: w = (1 - 9/5 s)(1 - s)^3
// for a rotation with gauge 0 and RotationGauge::radial, w = (1 - s)^4 for a strain (docs/mathematics.md).
inline constexpr int kPinRotationFalloff = 1;
inline constexpr int kPinStrainFalloff = 2;

// The wide falloff, for balls only: the volume that a moving ball displaces flows back far around it, and not close to
// it (docs/mathematics.md). `bump` = a is the radius of the part that moves along, `outer` = R the radius of the part
// that flows back, inner < a < R:
//   w = ((1 - r^2/R^2)^3 - (1 - r^2/a^2)^3) a^2 R^2 / (3 r^2 (R^2 - a^2)), each bracket 0 where it is negative.
// That is for inner = 0; else w is 1 up to `inner`. w has two continuous derivatives, and is 0 from R on.
inline constexpr int kWideFalloff = 8;

// Constants of the weight of one falloff.
struct FalloffFacts {
  double half;       // the s at which w = 1/2
  double slope;      // the greatest |dw/ds|, rounded up
  double curvature;  // the greatest |d2w/ds2|, rounded up
};

// Of the falloffs 3 to 7.
inline constexpr std::array<FalloffFacts, 5> kFalloffFacts{{{0.5908801132751771, 2.0091, 8.74},
                                                            {0.4867502159528536, 2.0642, 6.95},
                                                            {0.3856147369212866, 2.3897, 10.05},
                                                            {0.3196550856881648, 2.7577, 14.55},
                                                            {0.273098635829133, 3.1415, 19.94}}};

// Returns the facts of a falloff from 3 to 7.
constexpr const FalloffFacts& falloff_facts(int falloff) {
  return kFalloffFacts[static_cast<std::size_t>(falloff - kMinFalloff)];
}

// The values inner < outer of the region field r between which a field is blended, and the shape of the blend.
template <class S>
struct Thresholds {
  S inner{0};
  S outer{1};
  int falloff = kDefaultFalloff;
  S bump{0};  // of the wide falloff

  template <class U>
  explicit operator Thresholds<U>() const {
    return {static_cast<U>(inner), static_cast<U>(outer), falloff, static_cast<U>(bump)};
  }
  friend bool operator==(const Thresholds&, const Thresholds&) = default;
};

// The weight of the inner motion at one point.
template <class T>
struct Weight {
  T value{};       // w, 1 in the inner region, 0 in the outer one
  T derivative{};  // dw/dr, exactly 0 in both
};

// A factor that outweighs rounding, so that a weight is exactly 1 up to `inner`, or exactly 0 from `outer` on.
template <class S>
constexpr S rounded_up() {
  return S(1) + S(4) * std::numeric_limits<S>::epsilon();
}

// Returns w and (dw/dr) / r of the wide falloff with an inner region. All lengths are in units of `bump`; c is inner.
// g is the profile of v across the motion: g = alpha G(s) - beta G(s') with G(s) = (1 - s^2)^2. For the bump
// s = (r - c) / (1 - c), for the flow back s' = (r - c) / (outer - c). w is 2/r^2 times the integral of g r dr.
template <class T, class S>
Weight<T> wide_weight_around_core(const T& square, const Thresholds<S>& thresholds) {
  using std::sqrt;
  const S c = thresholds.inner / thresholds.bump * rounded_up<S>();
  const S outer = thresholds.outer / thresholds.bump / rounded_up<S>();
  const S near = S(1) - c;
  const S far = outer - c;
  const auto flux = [c](S width) { return c * c + width * (c * S(16.0 / 15) + width * S(1.0 / 3)); };
  const S beta = flux(near) / (flux(far) - flux(near));
  const S alpha = S(1) + beta;
  const S per_square = S(1) / (thresholds.bump * thresholds.bump);
  const T y = square * T(per_square);
  const T r = sqrt(y);
  const T s = maximum((r - T(c)) * T(S(1) / near), T(0));
  const T part = maximum((r - T(c)) * T(S(1) / far), T(0));
  // The integral of 2 (1 - G) r dr up to s.
  const auto deficit = [c](const T& at, S width) {
    const T cubic = T(c) * (T(S(4.0 / 3)) - at * at * T(S(0.4)));
    return at * at * at * T(width) * (cubic + at * T(width) * (T(1) - at * at * T(S(1.0 / 3))));
  };
  const auto loss = [](const T& at) { return at * at * (T(2) - at * at); };  // 1 - G
  const T inverse = T(1) / maximum(y, T(c * c));
  const T missing = (deficit(s, near) * T(alpha) - deficit(part, far) * T(beta)) * inverse;  // 1 - w
  const T slope = missing - loss(s) * T(alpha) + loss(part) * T(beta);                       // g - w
  const T rest = maximum((T(outer) - r) * T(S(1) / far), T(0));
  const T chord = rest * (T(2) - rest);  // 1 - part^2
  const T cubic = T(S(2) * c) * (T(S(4.0 / 3)) - rest + rest * rest * T(S(0.2)));
  const T tail =
      rest * rest * rest * T(far) * (cubic + T(far * S(1.0 / 3)) * (T(2) - rest) * (T(2) - rest) * (T(2) - rest));
  const T value = tail * inverse * T(beta);
  const auto inside = r < T(1);
  return {select(inside, T(1) - missing, value),
          select(inside, slope, -chord * chord * T(beta) - value) * inverse * T(S(2) * per_square)};
}

// Returns w and (dw/dr) / r of the wide falloff at r^2 = square, exactly 0 from `outer` on. Without an inner region
// they are polynomials of y = r^2/a^2 within the bump, written so that nothing cancels.
template <class T, class S>
Weight<T> wide_weight(const T& square, const Thresholds<S>& thresholds) {
  if (thresholds.inner > S(0)) return wide_weight_around_core(square, thresholds);
  const S per_square = S(1) / (thresholds.bump * thresholds.bump);
  const S ratio = thresholds.bump / thresholds.outer;
  const S k = ratio * ratio;
  const S linear = S(1) + k;
  const S quadratic = (S(1) + k * linear) * S(1.0 / 3);
  const T y = square * T(per_square);
  const T inverse = T(1) / maximum(y, T(1));
  const T rest = maximum(neg_mul_add(y, T(k * rounded_up<S>() * rounded_up<S>()), T(1)), T(0));
  const T part = rest * inverse;
  const T base = part * rest * T(S(1.0 / 3) / (S(1) - k));
  const auto inside = y < T(1);
  return {select(inside, mul_add(y, mul_add(y, T(quadratic), T(-linear)), T(1)), base * rest),
          select(inside, mul_add(y, T(S(4) * quadratic * per_square), T(S(-2) * linear * per_square)),
                 base * mul_add(part, T(S(-2) * per_square), T(S(-6) * k * per_square)))};
}

// Returns w and dw/dr at r of a falloff other than 4, from the rest q = 1 - s and inverse = -dq/dr. For n from 4 on,
// 1 - b = q^(n-2) (q^2 + n s q + n (n - 1) / 2 s^2), whose derivative by s is -n (n - 1) (n - 2) / 2 s^2 q^(n-3). Not
// inlined, so that it hardly changes the code of the default.
template <class T, class S>
[[gnu::noinline]] Weight<T> weight_of_falloff(T r, T rest, S inverse, const Thresholds<S>& thresholds) {
  const int falloff = thresholds.falloff;
  const T s = T(1) - rest;
  if (falloff == kWideFalloff) {
    const Weight<T> w = wide_weight(r * r, thresholds);
    return {w.value, w.derivative * r};
  }
  if (falloff == kPinFalloff) {
    const T fourth = integer_power(rest, 4);
    return {fourth * rest * mul_add(T(5), s, T(1)), fourth * s * T(S(-30) * inverse)};
  }
  if (falloff == kPinRotationFalloff) {
    const T square = rest * rest;
    return {square * rest * (T(1) - s * T(S(1.8))), square * (s * T(S(7.2)) - T(S(4.8))) * T(inverse)};
  }
  if (falloff == kPinStrainFalloff) {
    const T cube = rest * rest * rest;
    return {cube * rest, cube * T(S(-4) * inverse)};
  }
  if (falloff == 3) {
    const T complement = rest * mul_add(rest, rest - T(3), T(3));  // 1 - s^3
    const T square = complement * complement;
    return {square * complement, square * (s * s) * T(S(-9) * inverse)};
  }
  const T power = integer_power(rest, falloff - 3);
  const auto n = static_cast<S>(falloff);
  const T sum = mul_add(rest, mul_add(T(n), s, rest), s * s * T(n * (n - S(1)) * S(0.5)));
  const T complement = power * rest * sum;
  return {complement * complement, complement * (s * s * power) * T(-n * (n - S(1)) * (n - S(2)) * inverse)};
}

// Returns w and dw/dr at r; s is clamped to [0, 1]. For the default, in terms of the rest q = 1 - s:
// 1 - b = q^2 (6 - 8 q + 3 q^2), which does not cancel near s = 1. The factor of q is rounded up, so that q is exactly
// 1 wherever r <= inner.
template <class T, class S>
Weight<T> blend_weight(const T& r, const Thresholds<S>& thresholds) {
  const S inverse = rounded_up<S>() / (thresholds.outer - thresholds.inner);
  const T rest = minimum(maximum((T(thresholds.outer) - r) * T(inverse), T(0)), T(1));
  if (thresholds.falloff != kDefaultFalloff) [[unlikely]]
    return weight_of_falloff(r, rest, inverse, thresholds);
  const T s = T(1) - rest;
  const T complement = rest * rest * mul_add(rest, mul_add(T(3), rest, T(-8)), T(6));
  return {complement * complement, complement * (s * s * rest) * T(S(-24) * inverse)};
}

// Inner motions: the velocity u of the inner region and a vector potential A with curl A = u (method, section 1).
//
// An inner motion is a function of d = x - c, the position relative to the tool's centre. Adding a gradient to A does
// not change u, but changes the flow in the intermediate region: `gauge` = lambda selects A = lambda A_1 + (1 - lambda)
// A_0. A_1 = (e grad f - f grad e)/2 comes from the paper's scalar fields e and f; A_0 reduces the flow along the axis.
// S is the scalar of the stored numbers, T that of the evaluation: S, a dual number or a SIMD pack.

// Velocity and vector potential at one point.
template <class T>
struct MotionValue {
  Vec3<T> velocity;   // u
  Vec3<T> potential;  // A, curl A = u
};

// u = velocity (paper, Eq. 6). A_1 = u x d / 2. With a unit `axis` (a capsule's) A_0 = u_par x d / 2 + ((a x u_perp).d)
// a. The axis is not used if gauge is 1.
template <class S>
struct Translation {
  Vec3<S> velocity;
  Vec3<S> axis{};
  S gauge{1};

  template <class U>
  explicit operator Translation<U>() const {
    return {Vec3<U>(velocity), Vec3<U>(axis), static_cast<U>(gauge)};
  }
  friend bool operator==(const Translation&, const Translation&) = default;
};

// The A_0 of a rotation:
//   radial: omega (a.d) d, for a ball: no counter-rotation at all;
//   axial:  -omega/2 |d_perp|^2 a, for a bend: nothing flows along the axis.
enum class RotationGauge { radial, axial };

// u = rate axis x d (paper, Eq. 7, where the rate is 2); rate in radians per unit time, axis a unit vector.
// A_1 = rate/2 ((a.d) d_perp - |d_perp|^2 a / 2).
template <class S>
struct Rotation {
  Vec3<S> axis;
  S rate{0};
  S gauge{1};
  RotationGauge zero_gauge = RotationGauge::axial;

  template <class U>
  explicit operator Rotation<U>() const {
    return {Vec3<U>(axis), static_cast<U>(rate), static_cast<U>(gauge), zero_gauge};
  }
  friend bool operator==(const Rotation&, const Rotation&) = default;
};

// u = rate (a.d) a x d (paper, section 4.5, where the rate is 4); rate in radians per length and unit time.
// A_1 = rate/4 ((a.d)^2 d_perp - |d_perp|^2 (a.d) a), A_0 = -rate/2 (a.d) |d_perp|^2 a.
template <class S>
struct Twist {
  Vec3<S> axis;
  S rate{0};
  S gauge{1};

  template <class U>
  explicit operator Twist<U>() const {
    return {Vec3<U>(axis), static_cast<U>(rate), static_cast<U>(gauge)};
  }
  friend bool operator==(const Twist&, const Twist&) = default;
};

// u = matrix d, matrix traceless; A = (u x d) / 3.
template <class S>
struct Strain {
  Mat3<S> matrix;

  template <class U>
  explicit operator Strain<U>() const {
    return {Mat3<U>(matrix)};
  }
  friend bool operator==(const Strain&, const Strain&) = default;
};

// An inner motion of the caller's own: `evaluate` returns u and A at d = x - c, in double. The caller guarantees
// curl A = u; the resulting field is divergence-free for any A. The function is called from several threads at once.
struct CustomMotion {
  std::shared_ptr<const std::function<MotionValue<double>(const Vec3d& d)>> evaluate;

  friend bool operator==(const CustomMotion&, const CustomMotion&) = default;
};

// Any inner motion.
using Motion = std::variant<Translation<double>, Rotation<double>, Twist<double>, Strain<double>, CustomMotion>;

// Returns u and A of the translation at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Translation<S>& motion, const Vec3<T>& d) {
  const Vec3<S> parallel = motion.axis * dot(motion.axis, motion.velocity);
  const Vec3<S> perpendicular = motion.velocity - parallel;
  const Vec3<S> half = (parallel + perpendicular * motion.gauge) * S(0.5);
  const Vec3<S> across = cross(motion.axis, perpendicular) * (S(1) - motion.gauge);
  const Vec3<T> along = Vec3<T>(motion.axis) * dot(Vec3<T>(across), d);
  return {Vec3<T>(motion.velocity), cross(Vec3<T>(half), d) + along};
}

// Returns u and A of the rotation at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Rotation<S>& motion, const Vec3<T>& d) {
  const Vec3<T> a(motion.axis);
  const T height = dot(a, d);
  const Vec3<T> d_perp = d - a * height;
  const S rest = S(1) - motion.gauge;
  const bool radial = motion.zero_gauge == RotationGauge::radial;
  const S across = motion.rate * (motion.gauge * S(0.5) + (radial ? rest : S(0)));
  const S along_rho = motion.rate * (-motion.gauge * S(0.25) - (radial ? S(0) : rest * S(0.5)));
  const S along_height = motion.rate * (radial ? rest : S(0));
  const T along = T(along_rho) * norm2(d_perp) + T(along_height) * height * height;
  return {cross(a, d) * T(motion.rate), d_perp * (T(across) * height) + a * along};
}

// Returns u and A of the twist at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Twist<S>& motion, const Vec3<T>& d) {
  const Vec3<T> a(motion.axis);
  const T height = dot(a, d);
  const Vec3<T> d_perp = d - a * height;
  const S across = motion.rate * motion.gauge * S(0.25);
  const S along = motion.rate * (-motion.gauge * S(0.25) - (S(1) - motion.gauge) * S(0.5));
  return {cross(a, d) * (T(motion.rate) * height),
          d_perp * (T(across) * height * height) + a * (T(along) * norm2(d_perp) * height)};
}

// Returns u and A of the strain at d = x - c.
template <class T, class S>
MotionValue<T> evaluate(const Strain<S>& motion, const Vec3<T>& d) {
  const Vec3<T> u{dot(Vec3<T>(motion.matrix.row0), d), dot(Vec3<T>(motion.matrix.row1), d),
                  dot(Vec3<T>(motion.matrix.row2), d)};
  return {u, cross(u, d) * T(S(1) / S(3))};
}

// Returns u and A of the caller's motion at d = x - c.
template <std::floating_point T>
MotionValue<T> evaluate(const CustomMotion& motion, const Vec3<T>& d) {
  const MotionValue<double> value = (*motion.evaluate)(Vec3d(d));
  return {Vec3<T>(value.velocity), Vec3<T>(value.potential)};
}

// Masks: a number m(x) at each point of space, 0 where the shape is fixed and 1 where it is free.
//
// A mask multiplies the vector potential, so a masked field is divergence-free too (method, section 10):
// v = curl(m w A) = m w u + (m dw/dr grad r + w grad m) x A. m is C2: it is a cubic B-spline on a regular grid.

namespace detail {
struct MaskGrid;
}

// m and its gradient at one point.
template <class T>
struct MaskValue {
  T value{1};
  Vec3<T> gradient;
};

// A mask that is fixed in space. A value: copies share memory that never changes.
class Mask {
 public:
  Mask() = default;  // 1 everywhere

  // Makes the mask of some points. `values` are from 0 (free) to 1 (masked: m = 0 around the point), rounded to 1/255;
  // empty: 1 for all. Around a point with the value 1, m = 0 and grad m = 0 exactly at the point, m < 0.25 within 0.25
  // width, and m = 1 beyond 1.5 width, along the axes of coordinates beyond 1 width. Where points overlap, the largest
  // value at each node of the grid counts. Takes about 0.2 ms for 100 scattered points. threads as for parallel_for.
  // Throws InvalidInput for numbers out of range, and for a width that is too small for the extent of the points.
  Mask(std::span<const Vec3d> points, std::span<const double> values, double width, int threads = 0);

  // Returns whether m is 1 everywhere because there are no masked points.
  bool is_empty() const { return grid_ == nullptr; }
  // Returns the width of the border, 0 if the mask is empty.
  double width() const;
  // Returns a box beyond which m is 1.
  Box box() const;
  // Returns m and its gradient. Costs about 0.1 us.
  MaskValue<double> at(const Vec3d& x) const;
  // Returns whether m is exactly 0 at x and around it, so that x never moves.
  bool holds(const Vec3d& x) const;

  // Returns whether one is a copy of the other, or both are empty.
  bool shares(const Mask& other) const { return grid_ == other.grid_; }

  // Returns the grid. The mask must not be empty.
  const detail::MaskGrid& grid() const { return *grid_; }

  friend bool operator==(const Mask& a, const Mask& b);

 private:
  std::shared_ptr<const detail::MaskGrid> grid_;
};

// Returns the ascending indices of points that give the same mask as all of them, bit for bit: one for each cell of the
// grid that contains a masked point. Throws as the constructor.
std::vector<std::uint32_t> representative_points(std::span<const Vec3d> points, std::span<const double> values,
                                                 double width);

// A list of items. A value: copies share memory that never changes.
template <class T>
class SharedList {
 public:
  SharedList() = default;  // no items
  explicit SharedList(std::vector<T> items) : items_(std::make_shared<const std::vector<T>>(std::move(items))) {}

  // Returns whether the list has no items.
  bool empty() const { return size() == 0; }
  // Returns the number of items.
  std::size_t size() const { return items_ == nullptr ? 0 : items_->size(); }
  // Returns the contiguous items; null if there are none.
  const T* data() const { return items_ == nullptr ? nullptr : items_->data(); }
  const T& operator[](std::size_t i) const { return (*items_)[i]; }
  // Returns the first item.
  const T* begin() const { return data(); }
  // Returns the end of the items.
  const T* end() const { return data() + size(); }

  friend bool operator==(const SharedList& a, const SharedList& b) {
    if (a.items_ == b.items_ || a.size() != b.size()) return a.size() == b.size();
    return a.empty() || *a.items_ == *b.items_;
  }

 private:
  std::shared_ptr<const std::vector<T>> items_;
};

// The coefficients of a grid.
using SharedVectors = SharedList<Vec3d>;
// The growth of a grid.
using SharedNumbers = SharedList<double>;

// The vector potential A(x, t) = sum over the nodes k of a_k(t) B((x - origin) / spacing - k), where B is the tensor
// product of cubic B-splines: 0 from 2 spacings on along an axis. A is C2, so v = curl A is C1, its divergence is
// exactly 0, and v is exactly 0 beyond 2 spacings from the nodes with a_k other than 0. a_k(t) is coefficients[k], or
// (1 - t) coefficients[k] + t end_coefficients[k] where there are some.
// With `growth` v = curl A + grad p, p(x) = sum over k of growth[k] B((x - origin) / spacing - k). v is still C1 and
// its flow a diffeomorphism, but it changes volumes on purpose: along a path line d/dt log det J = div v = div grad p.
struct PotentialGrid {
  Vec3d origin{0, 0, 0};             // of the node (0, 0, 0)
  double spacing = 1;                // a length above 0
  std::array<int, 3> counts{};       // of nodes along x, y and z: 1 or more
  SharedVectors coefficients;        // of all nodes: node (i, j, k) is number i + counts[0] (j + counts[1] k)
  SharedVectors end_coefficients{};  // none, or as many: those at t = 1
  SharedNumbers growth{};            // none, or as many

  // Returns whether there are no coefficients, so that nothing moves.
  bool is_empty() const { return coefficients.empty(); }

  friend bool operator==(const PotentialGrid&, const PotentialGrid&) = default;
};

// Returns the grid of the velocity factor v.
PotentialGrid multiplied(PotentialGrid grid, double factor);

// The velocity field of one tool: v = curl(w A) = w u + (dw/dr) grad r x A (method, section 1).
//
// v is divergence-free for any A. It is C1 where the region field is C2, equals the inner motion where r < inner, and
// is exactly 0 where r >= outer. A field is data: an inner motion in a region around a centre, blended between the
// thresholds. It is evaluated at positions relative to its centre.
struct Field {
  Vec3d center;  // c at t = 0
  Motion motion;
  Region region;
  Thresholds<double> thresholds;

  friend bool operator==(const Field&, const Field&) = default;
};

// Returns v at d = x - c(t) for an inner motion and the value of a region there: the one formula that everything
// evaluates.
template <class T, class M, class S>
Vec3<T> velocity_where(const RegionValue<T>& r, const M& motion, const Thresholds<S>& thresholds, const Vec3<T>& d) {
  const Weight<T> w = blend_weight(r.value, thresholds);
  const MotionValue<T> inner = evaluate(motion, d);
  return mul_add(inner.velocity, w.value, cross(r.gradient, inner.potential) * w.derivative);
}

// Returns v under a mask: curl(m w (A - offset)) = m w u + (m dw/dr grad r + w grad m) x (A - offset).
template <class T, class M, class S>
Vec3<T> masked_velocity_where(const RegionValue<T>& r, const M& motion, const Thresholds<S>& thresholds,
                              const Vec3<T>& d, const MaskValue<T>& mask, const Vec3<S>& offset) {
  const Weight<T> w = blend_weight(r.value, thresholds);
  const MotionValue<T> inner = evaluate(motion, d);
  const Vec3<T> across = mul_add(mask.gradient, w.value, r.gradient * (w.derivative * mask.value));
  return mul_add(inner.velocity, w.value * mask.value, cross(across, inner.potential - Vec3<T>(offset)));
}

// The least divisor in a ball's formula, used at its centre, where the dividend is 0. Its square is above 0, because
// the derivative of a dual number is divided by it.
template <class S>
inline constexpr S kMinDistance = sizeof(S) == sizeof(float) ? S(1e-18) : S(1e-150);

// Returns w and (dw/dr) / r of a ball at r^2 = square.
template <class T, class S>
Weight<T> ball_weight(const T& square, const Thresholds<S>& thresholds) {
  using std::sqrt;
  if (thresholds.falloff == kWideFalloff) [[unlikely]]
    return wide_weight(square, thresholds);
  const T r = sqrt(square);
  const Weight<T> w = blend_weight(r, thresholds);
  return {w.value, w.derivative / maximum(r, T(kMinDistance<S>))};
}

// Returns v at d = x - c(t) for a ball, where r = |d|: grad r x A = d x A / r, and for translations and strains
// d x (u x d) = u |d|^2 - d (u.d).
template <class T, class M, class S>
Vec3<T> velocity(const M& motion, const Ball<S>& /*region*/, const Thresholds<S>& thresholds, const Vec3<T>& d,
                 const T& /*t*/) {
  const T square = norm2(d);
  const auto [weight, pull] = ball_weight(square, thresholds);
  if constexpr (std::is_same_v<M, Translation<S>>) {
    if (motion.gauge == S(1)) {
      const Vec3<T> u(motion.velocity);
      const T half = pull * T(S(0.5));
      return neg_mul_add(d, half * dot(u, d), u * mul_add(half, square, weight));
    }
  }
  const MotionValue<T> inner = evaluate(motion, d);
  if constexpr (std::is_same_v<M, Strain<S>>) {
    const Vec3<T>& u = inner.velocity;
    const T third = pull * T(S(1) / S(3));
    return neg_mul_add(d, third * dot(u, d), u * mul_add(third, square, weight));
  }
  return mul_add(cross(d, inner.potential), pull, inner.velocity * weight);
}

// Returns v at d = x - c(t) for any region.
template <class T, class M, class R, class S>
Vec3<T> velocity(const M& motion, const R& region, const Thresholds<S>& thresholds, const Vec3<T>& d, const T& t) {
  return velocity_where(evaluate(region, d, t), motion, thresholds, d);
}

// Returns v at d = x - c(t), in double.
inline Vec3d velocity(const Field& field, const Vec3d& d, double t = 0) {
  return std::visit(
      [&](const auto& motion, const auto& region) { return velocity(motion, region, field.thresholds, d, t); },
      field.motion, field.region);
}

// Returns r and grad r at d = x - c(t), in double.
inline RegionValue<double> region_value(const Field& field, const Vec3d& d, double t = 0) {
  return std::visit([&](const auto& region) { return evaluate(region, d, t); }, field.region);
}

}  // namespace knead
