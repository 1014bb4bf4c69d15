// How far the triangles of a surface are stretched from one shape to another.
#include <algorithm>
#include <array>
#include <cmath>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"

namespace knead {

namespace {

constexpr double kNoArea = 1e-12;  // height over longest edge of a triangle, squared

// The squared singular values of the linear map from one triangle to another: the eigenvalues of G0^-1 G1, with the
// Gram matrices of two edges before and after.
struct SquaredStretches {
  double greater;
  double less;
};

std::optional<SquaredStretches> squared_stretches(const std::array<Vec3d, 3>& rest, const std::array<Vec3d, 3>& now) {
  const Vec3d e = rest[1] - rest[0];
  const Vec3d f = rest[2] - rest[0];
  const Vec3d g = now[1] - now[0];
  const Vec3d h = now[2] - now[0];
  const double ee = norm2(e);
  const double ff = norm2(f);
  const double area2 = norm2(cross(e, f));
  const double longest = std::max({ee, ff, norm2(f - e)});
  if (!(area2 > kNoArea * longest * longest)) return std::nullopt;
  const double half_trace = 0.5 * (ff * norm2(g) - 2 * dot(e, f) * dot(g, h) + ee * norm2(h)) / area2;
  const double determinant = norm2(cross(g, h)) / area2;
  const double greater = half_trace + std::sqrt(std::max(half_trace * half_trace - determinant, 0.0));
  return SquaredStretches{greater, greater > 0 ? determinant / greater : 0};
}

}  // namespace

std::optional<double> triangle_stretch(const std::array<Vec3d, 3>& rest, const std::array<Vec3d, 3>& now) {
  const auto squares = squared_stretches(rest, now);
  return squares ? std::optional(std::sqrt(squares->greater)) : std::nullopt;
}

SurfaceStretch surface_stretch(std::span<const Triangle> triangles, std::span<const Vec3d> rest,
                               std::span<const Vec3d> now) {
  constexpr double kFlat = 1e-30;  // squared: what is pressed flat counts as this in the logarithms
  SurfaceStretch result;
  std::vector<double> worst;
  double sum = 0;
  double most_so_far = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    const auto squares = squared_stretches({rest[a], rest[b], rest[c]}, {now[a], now[b], now[c]});
    if (!squares) continue;
    const SurfaceStretch own{std::sqrt(squares->greater), std::sqrt(squares->less)};
    result.greatest = std::max(result.greatest, own.greatest);
    result.least = std::min(result.least, own.least);
    if (own.worst() > most_so_far) {
      most_so_far = own.worst();
      result.worst_triangle = i;
    }
    worst.push_back(own.worst());
    for (const double square : {squares->greater, squares->less}) {
      const double x = 0.5 * elementary::log(std::max(square, kFlat));
      sum += x * x;
    }
  }
  if (worst.empty()) return result;
  result.rms_log = std::sqrt(sum / (2 * static_cast<double>(worst.size())));
  const auto most = worst.begin() + static_cast<std::ptrdiff_t>((worst.size() * 99 + 99) / 100 - 1);
  std::nth_element(worst.begin(), most, worst.end());
  result.percentile_99 = *most;
  return result;
}

std::vector<float> vertex_stretches(std::span<const Triangle> triangles, std::span<const Vec3d> rest,
                                    std::span<const Vec3d> now) {
  if (rest.size() != now.size()) throw InvalidInput("give as many places at rest as now");
  check_triangles(triangles, rest);
  check_triangles(triangles, now);
  std::vector<float> result(now.size());
  for (const auto& [a, b, c] : triangles) {
    const auto stretch = triangle_stretch({rest[a], rest[b], rest[c]}, {now[a], now[b], now[c]});
    if (!stretch) continue;
    for (const std::uint32_t v : {a, b, c}) result[v] = std::max(result[v], static_cast<float>(*stretch));
  }
  for (float& value : result) {
    if (value == 0) value = 1;
  }
  return result;
}

}  // namespace knead
