// Numbers with their derivatives, the scalar of a field's numbers and of its evaluation; and fields of such numbers.
// Internal to the library.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/region.h"
#include "knead/vec.h"

namespace knead::detail {

inline constexpr std::size_t kTangents = 3;  // derivatives that are computed together

// A number and its derivatives with respect to the variables. Numbers are equal only if their derivatives are, so that
// a formula for a special value is not used where the value varies.
struct Varying {
  double v = 0;
  std::array<double, kTangents> g{};

  constexpr Varying() = default;
  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr explicit Varying(T value) : v(static_cast<double>(value)) {}
  constexpr Varying(double value, const std::array<double, kTangents>& derivatives) : v(value), g(derivatives) {}

  // f(a, b) with these partial derivatives.
  static Varying chain(double value, const Varying& a, double by_a, const Varying& b, double by_b) {
    Varying result(value);
    for (std::size_t k = 0; k < kTangents; ++k) result.g[k] = by_a * a.g[k] + by_b * b.g[k];
    return result;
  }
  static Varying chain(double value, const Varying& a, double by_a) {
    Varying result(value);
    for (std::size_t k = 0; k < kTangents; ++k) result.g[k] = by_a * a.g[k];
    return result;
  }

  friend Varying operator+(const Varying& a, const Varying& b) { return chain(a.v + b.v, a, 1, b, 1); }
  friend Varying operator-(const Varying& a, const Varying& b) { return chain(a.v - b.v, a, 1, b, -1); }
  friend Varying operator-(const Varying& a) { return chain(-a.v, a, -1); }
  friend Varying operator*(const Varying& a, const Varying& b) { return chain(a.v * b.v, a, b.v, b, a.v); }
  friend Varying operator/(const Varying& a, const Varying& b) {
    const double quotient = a.v / b.v;
    return chain(quotient, a, 1 / b.v, b, -quotient / b.v);
  }
  friend bool operator==(const Varying& a, const Varying& b) { return a.v == b.v && a.g == b.g; }
  friend bool operator<(const Varying& a, const Varying& b) { return a.v < b.v; }
  friend bool operator>(const Varying& a, const Varying& b) { return a.v > b.v; }
  friend bool operator<=(const Varying& a, const Varying& b) { return a.v <= b.v; }
  friend bool operator>=(const Varying& a, const Varying& b) { return a.v >= b.v; }
  // The derivative of a length is 0 at the origin, like that of its square.
  friend Varying sqrt(const Varying& a) {
    const double root = std::sqrt(a.v);
    return chain(root, a, root > 0 ? 0.5 / root : 0);
  }
  friend Varying select(bool first, const Varying& a, const Varying& b) { return first ? a : b; }
  friend Varying round_to_integer(const Varying& a) { return Varying(knead::round_to_integer(a.v)); }
  friend Varying inverse_root(const Varying& sum, int m) {
    const double y = knead::inverse_root(sum.v, m);
    return chain(y, sum, -y / (m * sum.v));
  }
};

using VaryingVec3 = Vec3<Varying>;

}  // namespace knead::detail

// The formulas of fields need these.
template <>
class std::numeric_limits<knead::detail::Varying> {
 public:
  static constexpr knead::detail::Varying max() { return knead::detail::Varying(numeric_limits<double>::max()); }
  static constexpr knead::detail::Varying epsilon() {
    return knead::detail::Varying(numeric_limits<double>::epsilon());
  }
};

namespace knead::detail {

inline Vec3d values_of(const VaryingVec3& p) { return {p.x.v, p.y.v, p.z.v}; }
inline Vec3d derivatives_of(const VaryingVec3& p, std::size_t k) { return {p.x.g[k], p.y.g[k], p.z.g[k]}; }

// A field whose numbers vary.
struct VaryingField {
  VaryingVec3 center;
  std::variant<Translation<Varying>, Rotation<Varying>, Twist<Varying>, Strain<Varying>> motion;
  std::variant<Ball<Varying>, Capsule<Varying>, HalfSpace<Varying>, PointSet<Varying>, Handles<Varying>> region;
  Thresholds<Varying> thresholds;
};

// Makes fields whose numbers are next(number), called in a fixed order of the numbers.
template <class Next>
class Varied {
 public:
  explicit Varied(Next& next) : next_(next) {}

  Varying operator()(double number) const { return next_(number); }
  VaryingVec3 operator()(const Vec3d& v) const {
    const Varying x = next_(v.x);
    const Varying y = next_(v.y);
    return {x, y, next_(v.z)};
  }
  VaryingField operator()(const Field& field) const {
    VaryingField result;
    result.center = (*this)(field.center);
    std::visit([&](const auto& motion) { take(motion, result); }, field.motion);
    std::visit([&](const auto& region) { take(region, result); }, field.region);
    result.thresholds.inner = next_(field.thresholds.inner);
    result.thresholds.outer = next_(field.thresholds.outer);
    result.thresholds.falloff = field.thresholds.falloff;
    result.thresholds.bump = next_(field.thresholds.bump);
    return result;
  }

 private:
  void take(const Translation<double>& motion, VaryingField& to) const {
    Translation<Varying> own{(*this)(motion.velocity)};
    own.axis = (*this)(motion.axis);
    own.gauge = next_(motion.gauge);
    to.motion = own;
  }
  void take(const Rotation<double>& motion, VaryingField& to) const {
    Rotation<Varying> own{(*this)(motion.axis)};
    own.rate = next_(motion.rate);
    own.gauge = next_(motion.gauge);
    own.zero_gauge = motion.zero_gauge;
    to.motion = own;
  }
  void take(const Twist<double>& motion, VaryingField& to) const {
    Twist<Varying> own{(*this)(motion.axis)};
    own.rate = next_(motion.rate);
    own.gauge = next_(motion.gauge);
    to.motion = own;
  }
  void take(const Strain<double>& motion, VaryingField& to) const {
    Strain<Varying> own;
    own.matrix.row0 = (*this)(motion.matrix.row0);
    own.matrix.row1 = (*this)(motion.matrix.row1);
    own.matrix.row2 = (*this)(motion.matrix.row2);
    to.motion = own;
  }
  void take(const Ball<double>& /*region*/, VaryingField& to) const { to.region = Ball<Varying>{}; }
  void take(const Capsule<double>& region, VaryingField& to) const {
    to.region = Capsule<Varying>{(*this)(region.half_axis)};
  }
  void take(const HalfSpace<double>& region, VaryingField& to) const {
    HalfSpace<Varying> own{(*this)(region.normal)};
    own.turn_axis = (*this)(region.turn_axis);
    own.turn_angle = next_(region.turn_angle);
    to.region = own;
  }
  void take(const PointSet<double>& region, VaryingField& to) const { to.region = set(region); }
  void take(const Handles<double>& region, VaryingField& to) const {
    Handles<Varying> own{set(region.full), set(region.zero)};
    own.sweep = (*this)(region.sweep);
    own.turn_axis = (*this)(region.turn_axis);
    own.turn_angle = next_(region.turn_angle);
    to.region = std::move(own);
  }
  template <class Own>  // CustomMotion, CustomRegion
  [[noreturn]] void take(const Own& /*own*/, VaryingField& /*to*/) const {
    throw InvalidInput("the derivatives of a custom motion or region are not known; use another field");
  }

  PointSet<Varying> set(const PointSet<double>& set) const {
    PointSet<Varying> own;
    own.exponent = set.exponent;
    for (const Vec3d& p : set.points) own.points.push_back((*this)(p));
    for (const std::vector<Vec3d>& curve : set.curves) {
      own.curves.emplace_back();
      for (const Vec3d& p : curve) own.curves.back().push_back((*this)(p));
    }
    return own;
  }

  Next& next_;
};

}  // namespace knead::detail
