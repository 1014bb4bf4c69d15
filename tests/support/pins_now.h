// Pins at one moment, from the method's section 9 alone: the kernel as curl curl(phi a), and the equations by
// elimination. Slow, and written to be compared with.
#pragma once

#include <cmath>
#include <vector>

#include "knead/vec.h"

namespace knead::oracle {

// curl curl(phi a), 1 at the pin, with Wendland's phi = (1 - r)^6 (35 r^2 + 18 r + 3) / 3 and its derivatives
// phi' = r f, phi'' = f + r f'.
inline Vec3d pin_kernel(const Vec3d& d, double radius, const Vec3d& a) {
  const Vec3d x = d / radius;
  const double r = norm(x);
  if (r >= 1) return {0, 0, 0};
  const double fourth = (1 - r) * (1 - r) * (1 - r) * (1 - r);
  const double f = -56.0 / 3 * (1 + 5 * r) * fourth * (1 - r);
  const double f_slope = -56.0 / 3 * (5 * fourth * (1 - r) - 5 * (1 + 5 * r) * fourth);
  const Vec3d hessian_a = a * f + (r > 0 ? x * (dot(x, a) * f_slope / r) : Vec3d{0, 0, 0});
  const double laplacian = 3 * f + r * f_slope;
  return (hessian_a - a * laplacian) * (3.0 / 112);
}

// The pins that are at from + t by, and the velocity that takes each with its own.
class PinsNow {
 public:
  PinsNow(const std::vector<Vec3d>& from, const std::vector<Vec3d>& by, double radius, double t)
      : radius_(radius), places_(from), a_(from.size()) {
    for (std::size_t i = 0; i < from.size(); ++i) places_[i] += by[i] * t;
    const std::size_t n = 3 * from.size();
    std::vector<std::vector<double>> m(n, std::vector<double>(n + 1));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        Vec3d e{0, 0, 0};
        e[j % 3] = 1;
        m[i][j] = pin_kernel(places_[i / 3] - places_[j / 3], radius, e)[i % 3];
      }
      m[i][n] = by[i / 3][i % 3];
    }
    eliminate(m);
    for (std::size_t i = 0; i < n; ++i) a_[i / 3][i % 3] = m[i][n] / m[i][i];
  }

  Vec3d velocity(const Vec3d& x) const {
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 0; i < a_.size(); ++i) sum += pin_kernel(x - places_[i], radius_, a_[i]);
    return sum;
  }

 private:
  // Leaves the diagonal and the right side.
  static void eliminate(std::vector<std::vector<double>>& m) {
    const std::size_t n = m.size();
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t i = 0; i < n; ++i) {
        if (i == k) continue;
        const double factor = m[i][k] / m[k][k];
        for (std::size_t j = k; j <= n; ++j) m[i][j] -= factor * m[k][j];
      }
    }
  }

  double radius_;
  std::vector<Vec3d> places_;
  std::vector<Vec3d> a_;
};

}  // namespace knead::oracle
