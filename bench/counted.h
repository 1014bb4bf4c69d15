// A double that counts what is done with it.
#pragma once

#include <cmath>
#include <cstdint>

#include "knead/field/field.h"

namespace knead::bench {

struct Counted {
  double v = 0;
  inline static std::uint64_t operations = 0;  // + - * / and sqrt since it was last set to 0

  constexpr Counted() = default;
  constexpr explicit Counted(double value) : v(value) {}

  friend Counted operator+(const Counted& a, const Counted& b) { return count(a.v + b.v); }
  friend Counted operator-(const Counted& a, const Counted& b) { return count(a.v - b.v); }
  friend Counted operator-(const Counted& a) { return Counted(-a.v); }
  friend Counted operator*(const Counted& a, const Counted& b) { return count(a.v * b.v); }
  friend Counted operator/(const Counted& a, const Counted& b) { return count(a.v / b.v); }
  friend constexpr bool operator==(const Counted& a, const Counted& b) { return a.v == b.v; }
  friend bool operator<(const Counted& a, const Counted& b) { return a.v < b.v; }
  friend bool operator>(const Counted& a, const Counted& b) { return a.v > b.v; }
  friend bool operator>=(const Counted& a, const Counted& b) { return a.v >= b.v; }

  friend Counted sqrt(const Counted& a) { return count(std::sqrt(a.v)); }
  friend Counted select(bool mask, const Counted& a, const Counted& b) { return mask ? a : b; }
  friend Counted round_to_integer(const Counted& a) { return Counted(knead::round_to_integer(a.v)); }
  friend Counted inverse_root(const Counted& sum, int m) {
    for (int q = 1; 2 * q <= m; q *= 2) ++operations;
    return Counted(knead::inverse_root(sum.v, m));
  }

 private:
  static Counted count(double value) {
    ++operations;
    return Counted(value);
  }
};

// How many operations v takes at d = x - c: once, without those of the step around it. 0 for fields with parts of the
// caller's own.
inline std::uint64_t operations_of(const Field& field, const Vec3d& d) {
  Counted::operations = 0;
  std::visit(
      [&](const auto& motion, const auto& region) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(motion)>, CustomMotion> &&
                      !std::is_same_v<std::decay_t<decltype(region)>, CustomRegion>) {
          velocity(motion, region, field.thresholds, Vec3<Counted>(d), Counted(0.5));
        }
      },
      field.motion, field.region);
  return Counted::operations;
}

}  // namespace knead::bench
