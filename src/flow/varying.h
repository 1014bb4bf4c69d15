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

// The functions of a number that follows its derivatives, for the formulas of fields. Own::chain(value, a, by_a, b,
// by_b) returns f(a, b) with these partial derivatives.
template <class Own>
struct DerivativeRules {
  friend Own operator+(const Own& a, const Own& b) { return Own::chain(a.v + b.v, a, 1, b, 1); }
  friend Own operator-(const Own& a, const Own& b) { return Own::chain(a.v - b.v, a, 1, b, -1); }
  friend Own operator-(const Own& a) { return Own::chain(-a.v, a, -1); }
  friend Own operator*(const Own& a, const Own& b) { return Own::chain(a.v * b.v, a, b.v, b, a.v); }
  friend Own operator/(const Own& a, const Own& b) {
    const double quotient = a.v / b.v;
    return Own::chain(quotient, a, 1 / b.v, b, -quotient / b.v);
  }
  friend bool operator<(const Own& a, const Own& b) { return a.v < b.v; }
  friend bool operator>(const Own& a, const Own& b) { return a.v > b.v; }
  friend bool operator<=(const Own& a, const Own& b) { return a.v <= b.v; }
  friend bool operator>=(const Own& a, const Own& b) { return a.v >= b.v; }
  // The derivative of a length is 0 at the origin, like that of its square.
  friend Own sqrt(const Own& a) {
    const double root = std::sqrt(a.v);
    return Own::chain(root, a, root > 0 ? 0.5 / root : 0);
  }
  friend Own select(bool first, const Own& a, const Own& b) { return first ? a : b; }
  friend Own round_to_integer(const Own& a) { return Own(knead::round_to_integer(a.v)); }
  friend Own inverse_root(const Own& sum, int m) {
    const double y = knead::inverse_root(sum.v, m);
    return Own::chain(y, sum, -y / (m * sum.v));
  }
};

// A number and its derivatives with respect to `count` variables. Numbers are equal only if their derivatives are, so
// that a formula for a special value is not used where the value varies. Tag: only makes different types.
template <std::size_t count, class Tag = void>
struct VaryingOf : DerivativeRules<VaryingOf<count, Tag>> {
  double v = 0;
  std::array<double, count> g{};

  constexpr VaryingOf() = default;
  template <class T>
  requires std::is_arithmetic_v<T>
  constexpr explicit VaryingOf(T value) : v(static_cast<double>(value)) {}
  constexpr VaryingOf(double value, const std::array<double, count>& derivatives) : v(value), g(derivatives) {}
  // Keeps the first derivatives.
  template <std::size_t n, class Other>
  requires(n >= count) constexpr explicit VaryingOf(const VaryingOf<n, Other>& a) : v(a.v) {
    for (std::size_t k = 0; k < count; ++k) g[k] = a.g[k];
  }

  static VaryingOf chain(double value, const VaryingOf& a, double by_a, const VaryingOf& b, double by_b) {
    VaryingOf result(value);
    for (std::size_t k = 0; k < count; ++k) result.g[k] = by_a * a.g[k] + by_b * b.g[k];
    return result;
  }
  static VaryingOf chain(double value, const VaryingOf& a, double by_a) {
    VaryingOf result(value);
    for (std::size_t k = 0; k < count; ++k) result.g[k] = by_a * a.g[k];
    return result;
  }

  friend bool operator==(const VaryingOf& a, const VaryingOf& b) { return a.v == b.v && a.g == b.g; }
};

using Varying = VaryingOf<kTangents>;
using VaryingVec3 = Vec3<Varying>;

}  // namespace knead::detail

// The formulas of fields need these.
template <std::size_t variables, class Tag>
class std::numeric_limits<knead::detail::VaryingOf<variables, Tag>> {
 public:
  using Number = knead::detail::VaryingOf<variables, Tag>;
  static constexpr Number max() { return Number(numeric_limits<double>::max()); }
  static constexpr Number epsilon() { return Number(numeric_limits<double>::epsilon()); }
};

namespace knead::detail {

inline Vec3d values_of(const VaryingVec3& p) { return {p.x.v, p.y.v, p.z.v}; }
inline Vec3d derivatives_of(const VaryingVec3& p, std::size_t k) { return {p.x.g[k], p.y.g[k], p.z.g[k]}; }

// A field whose numbers vary: Varying, or taped.
template <class S>
struct VaryingField {
  Vec3<S> center;
  std::variant<Translation<S>, Rotation<S>, Twist<S>, Strain<S>> motion;
  std::variant<Ball<S>, Capsule<S>, HalfSpace<S>, PointSet<S>, Handles<S>> region;
  Thresholds<S> thresholds;
};

// Makes fields whose numbers are next(number), called in a fixed order of the numbers.
template <class Next>
class Varied {
 public:
  using S = std::invoke_result_t<Next&, double>;
  using OwnField = VaryingField<S>;

  explicit Varied(Next& next) : next_(next) {}

  S operator()(double number) const { return next_(number); }
  Vec3<S> operator()(const Vec3d& v) const {
    const S x = next_(v.x);
    const S y = next_(v.y);
    return {x, y, next_(v.z)};
  }
  OwnField operator()(const Field& field) const {
    OwnField result;
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
  void take(const Translation<double>& motion, OwnField& to) const {
    Translation<S> own{(*this)(motion.velocity)};
    own.axis = (*this)(motion.axis);
    own.gauge = next_(motion.gauge);
    to.motion = own;
  }
  void take(const Rotation<double>& motion, OwnField& to) const {
    Rotation<S> own{(*this)(motion.axis)};
    own.rate = next_(motion.rate);
    own.gauge = next_(motion.gauge);
    own.zero_gauge = motion.zero_gauge;
    to.motion = own;
  }
  void take(const Twist<double>& motion, OwnField& to) const {
    Twist<S> own{(*this)(motion.axis)};
    own.rate = next_(motion.rate);
    own.gauge = next_(motion.gauge);
    to.motion = own;
  }
  void take(const Strain<double>& motion, OwnField& to) const {
    Strain<S> own;
    own.matrix.row0 = (*this)(motion.matrix.row0);
    own.matrix.row1 = (*this)(motion.matrix.row1);
    own.matrix.row2 = (*this)(motion.matrix.row2);
    to.motion = own;
  }
  void take(const Ball<double>& /*region*/, OwnField& to) const { to.region = Ball<S>{}; }
  void take(const Capsule<double>& region, OwnField& to) const { to.region = Capsule<S>{(*this)(region.half_axis)}; }
  void take(const HalfSpace<double>& region, OwnField& to) const {
    HalfSpace<S> own{(*this)(region.normal)};
    own.turn_axis = (*this)(region.turn_axis);
    own.turn_angle = next_(region.turn_angle);
    to.region = own;
  }
  void take(const PointSet<double>& region, OwnField& to) const { to.region = set(region); }
  void take(const Handles<double>& region, OwnField& to) const {
    Handles<S> own{set(region.full), set(region.zero)};
    own.sweep = (*this)(region.sweep);
    own.turn_axis = (*this)(region.turn_axis);
    own.turn_angle = next_(region.turn_angle);
    to.region = std::move(own);
  }
  template <class Own>  // CustomMotion, CustomRegion
  [[noreturn]] void take(const Own& /*own*/, OwnField& /*to*/) const {
    throw InvalidInput("the derivatives of a custom motion or region are not known; use another field");
  }

  PointSet<S> set(const PointSet<double>& set) const {
    PointSet<S> own;
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
