#include "knead/mesh/predicates.h"

#include <array>
#include <cmath>
#include <limits>

namespace knead {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon() / 2;  // the largest relative error of one rounding
constexpr double kBound2d = (3 + 16 * kEpsilon) * kEpsilon;              // Shewchuk's ccwerrboundA
constexpr double kBound3d = (7 + 56 * kEpsilon) * kEpsilon;              // and o3derrboundA

// A rounded result and its rounding error: their sum is exact.
struct Two {
  double head;
  double tail;
};

Two two_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

// Requires |a| >= |b|.
Two fast_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

Two two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// A number as the sum of doubles that do not overlap, from smallest to largest; none is zero.
template <std::size_t Capacity>
struct Expansion {
  std::array<double, Capacity> terms{};
  std::size_t size = 0;

  void append(double term) {
    if (term != 0) terms[size++] = term;
  }
  int sign() const { return size == 0 ? 0 : (terms[size - 1] > 0 ? 1 : -1); }
};

Expansion<2> difference(double a, double b) {
  const Two exact = two_sum(a, -b);
  Expansion<2> result;
  result.append(exact.tail);
  result.append(exact.head);
  return result;
}

// Shewchuk's Fast-Expansion-Sum: merges the terms of both by magnitude and adds them up.
template <std::size_t M, std::size_t N>
Expansion<M + N> operator+(const Expansion<M>& e, const Expansion<N>& f) {
  Expansion<M + N> result;
  Two sum{0, 0};
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < e.size || j < f.size) {
    const bool from_e = j == f.size || (i < e.size && std::abs(e.terms[i]) < std::abs(f.terms[j]));
    sum = two_sum(sum.head, from_e ? e.terms[i++] : f.terms[j++]);
    result.append(sum.tail);
  }
  result.append(sum.head);
  return result;
}

template <std::size_t N>
Expansion<N> operator-(Expansion<N> e) {
  for (std::size_t i = 0; i < e.size; ++i) e.terms[i] = -e.terms[i];
  return e;
}

// Shewchuk's Scale-Expansion.
template <std::size_t N>
Expansion<2 * N> operator*(const Expansion<N>& e, double factor) {
  Expansion<2 * N> result;
  double carry = 0;
  for (std::size_t i = 0; i < e.size; ++i) {
    const Two product = two_product(e.terms[i], factor);
    const Two low = two_sum(carry, product.tail);
    const Two high = fast_two_sum(product.head, low.head);
    result.append(low.tail);
    result.append(high.tail);
    carry = high.head;
  }
  result.append(carry);
  return result;
}

template <std::size_t N>
Expansion<4 * N> operator*(const Expansion<N>& e, const Expansion<2>& f) {
  if (f.size < 2) {  // most differences of coordinates are exact
    Expansion<4 * N> result;
    if (f.size == 0) return result;
    const Expansion<2 * N> product = e * f.terms[0];
    for (std::size_t i = 0; i < product.size; ++i) result.append(product.terms[i]);
    return result;
  }
  return e * f.terms[0] + e * f.terms[1];
}

struct ExactVector {
  Expansion<2> x, y, z;
};

ExactVector difference(const Vec3d& a, const Vec3d& b) {
  return {difference(a.x, b.x), difference(a.y, b.y), difference(a.z, b.z)};
}

Expansion<16> minor(const Expansion<2>& a, const Expansion<2>& b, const Expansion<2>& c, const Expansion<2>& d) {
  return a * d + -(b * c);
}

int exact_orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const ExactVector p = difference(b, a);
  const ExactVector q = difference(c, a);
  const ExactVector r = difference(d, a);
  return (minor(q.x, q.y, r.x, r.y) * p.z + minor(r.x, r.y, p.x, p.y) * q.z + minor(p.x, p.y, q.x, q.y) * r.z).sign();
}

// Returns whether a determinant, whose error is at most `bound`, has the right sign. The bound is 0 only if all
// products are 0. It is not finite if a coordinate is not, or if products are too large for exact numbers.
bool decides(double determinant, double bound) {
  return std::abs(determinant) > bound || bound == 0 || !std::isfinite(bound);
}

int sign(double x) { return static_cast<int>(x > 0) - static_cast<int>(x < 0); }

}  // namespace

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d p = b - a;
  const Vec3d q = c - a;
  const Vec3d r = d - a;
  const double qx_ry = q.x * r.y;
  const double qy_rx = q.y * r.x;
  const double rx_py = r.x * p.y;
  const double ry_px = r.y * p.x;
  const double px_qy = p.x * q.y;
  const double py_qx = p.y * q.x;
  const double determinant = p.z * (qx_ry - qy_rx) + q.z * (rx_py - ry_px) + r.z * (px_qy - py_qx);
  const double permanent = std::abs(p.z) * (std::abs(qx_ry) + std::abs(qy_rx)) +
                           std::abs(q.z) * (std::abs(rx_py) + std::abs(ry_px)) +
                           std::abs(r.z) * (std::abs(px_qy) + std::abs(py_qx));
  return decides(determinant, kBound3d * permanent) ? sign(determinant) : exact_orient3d(a, b, c, d);
}

int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis) {
  const std::size_t u = axis == 2 ? 0 : static_cast<std::size_t>(axis) + 1;
  const std::size_t v = axis == 0 ? 2 : static_cast<std::size_t>(axis) - 1;
  const double left = (b[u] - a[u]) * (c[v] - a[v]);
  const double right = (b[v] - a[v]) * (c[u] - a[u]);
  const double determinant = left - right;
  if (decides(determinant, kBound2d * (std::abs(left) + std::abs(right)))) return sign(determinant);
  return minor(difference(b[u], a[u]), difference(b[v], a[v]), difference(c[u], a[u]), difference(c[v], a[v])).sign();
}

}  // namespace knead
