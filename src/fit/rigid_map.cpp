#include "fit/rigid_map.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace knead::fit_detail {

namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

// One Jacobi rotation that makes the entry (p, q) of a symmetric matrix 0; `vectors` turn with it.
void rotate(Matrix4& m, Matrix4& vectors, std::size_t p, std::size_t q) {
  const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
  const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(1 + theta * theta));
  const double c = 1 / std::sqrt(1 + t * t);
  const double s = t * c;
  for (std::size_t k = 0; k < 4; ++k) {
    const double a = m[k][p];
    m[k][p] = c * a - s * m[k][q];
    m[k][q] = s * a + c * m[k][q];
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const double a = m[p][k];
    m[p][k] = c * a - s * m[q][k];
    m[q][k] = s * a + c * m[q][k];
    const double v = vectors[k][p];
    vectors[k][p] = c * v - s * vectors[k][q];
    vectors[k][q] = s * v + c * vectors[k][q];
  }
}

// The unit eigenvector of the greatest eigenvalue.
std::array<double, 4> greatest_vector(Matrix4 m) {
  constexpr int kSweeps = 12;
  constexpr double kSmall = 1e-15;  // of the diagonal
  Matrix4 vectors{};
  double size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    vectors[i][i] = 1;
    size = std::fmax(size, std::abs(m[i][i]));
  }
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool is_done = true;
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (!(std::abs(m[p][q]) > kSmall * size)) continue;
        rotate(m, vectors, p, q);
        is_done = false;
      }
    }
    if (is_done) break;
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) best = m[i][i] > m[best][best] ? i : best;
  return {vectors[0][best], vectors[1][best], vectors[2][best], vectors[3][best]};
}

Vec3d mean_of(std::span<const Vec3d> points, std::span<const double> weights) {
  Vec3d sum{0, 0, 0};
  double weight = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    sum += (points[i] - points[0]) * w;
    weight += w;
  }
  return points[0] + sum / weight;
}

}  // namespace

Turn operator*(const Turn& a, const Turn& b) {
  return {a.w * b.w - dot(a.v, b.v), b.v * a.w + a.v * b.w + cross(a.v, b.v)};
}

Vec3d operator*(const Turn& turn, const Vec3d& p) {
  const Vec3d t = cross(turn.v, p) * 2.0;
  return p + t * turn.w + cross(turn.v, t);
}

Turn part_of(const Turn& turn, double part) {
  const double sign = turn.w < 0 ? -1 : 1;
  const double w = 1 - part + part * sign * turn.w;
  const Vec3d v = turn.v * (part * sign);
  const double size = std::sqrt(w * w + norm2(v));
  return {w / size, v / size};
}

Turn nearest_turn(const Mat3d& sum) {
  const Vec3d& x = sum.row0;
  const Vec3d& y = sum.row1;
  const Vec3d& z = sum.row2;
  // Horn 1987, with the rows of `sum` belonging to the places.
  const Vec3d skew{z.y - y.z, x.z - z.x, y.x - x.y};
  const Matrix4 m{{{x.x + y.y + z.z, skew.x, skew.y, skew.z},
                   {skew.x, x.x - y.y - z.z, x.y + y.x, x.z + z.x},
                   {skew.y, x.y + y.x, y.y - x.x - z.z, y.z + z.y},
                   {skew.z, x.z + z.x, y.z + z.y, z.z - x.x - y.y}}};
  const std::array<double, 4> q = greatest_vector(m);
  const double sign = q[0] < 0 ? -1 : 1;
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {sign * q[0] / size, Vec3d{q[1], q[2], q[3]} * (sign / size)};
}

RigidMap nearest_rigid(std::span<const Vec3d> from, std::span<const Vec3d> to, std::span<const double> weights) {
  RigidMap map{{}, mean_of(from, weights), mean_of(to, weights)};
  Mat3d sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  for (std::size_t i = 0; i < from.size(); ++i) {
    sum = sum + outer_product(to[i] - map.to, (from[i] - map.from) * (weights.empty() ? 1 : weights[i]));
  }
  map.turn = nearest_turn(sum);
  return map;
}

double rms_of(const RigidMap& map, std::span<const Vec3d> from, std::span<const Vec3d> to) {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += norm2(map(from[i]) - to[i]);
  return std::sqrt(sum / static_cast<double>(from.size()));
}

}  // namespace knead::fit_detail
