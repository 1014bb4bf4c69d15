#include "fit/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/error.h"

namespace knead::fit_detail {

namespace {

constexpr std::size_t kGrain = 64;

void add_distances(std::span<const Vec3d> from, const SurfaceTree& to, const Measuring& measuring,
                   std::vector<double>& distances) {
  const std::size_t stride = measuring.most == 0 ? 1 : from.size() / measuring.most + 1;
  const std::size_t count = (from.size() + stride - 1) / stride;
  const std::size_t first = distances.size();
  distances.resize(first + count);
  parallel_for(count, kGrain, measuring.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(measuring.progress);
    for (std::size_t i = begin; i < end; ++i) distances[first + i] = to.closest(from[i * stride])->distance;
  });
}

}  // namespace

SurfaceTree tree_of(const MeasuredShape& shape) {
  if (!shape.triangles.empty()) return {shape.triangles, shape.positions};
  std::vector<Triangle> points;
  for (std::uint32_t i = 0; i < shape.positions.size(); ++i) points.push_back({i, i, i});
  return {points, shape.positions};
}

FitDistance distance_of(const MeasuredShape& a, const MeasuredShape& b, const SurfaceTree& of_b,
                        const Measuring& measuring) {
  std::vector<double> distances;
  add_distances(a.positions, of_b, measuring, distances);
  add_distances(b.positions, tree_of(a), measuring, distances);
  FitDistance result;
  for (const double distance : distances) result.mean += distance;
  std::sort(distances.begin(), distances.end());
  result.mean /= static_cast<double>(distances.size()) * measuring.length;
  result.percentile_95 = distances[(distances.size() * 95 + 99) / 100 - 1] / measuring.length;
  result.max = distances.back() / measuring.length;
  return result;
}

StretchOfShape stretch_of(std::span<const Triangle> triangles, std::span<const Vec3d> rest,
                          std::span<const Vec3d> now) {
  constexpr double kNoArea = 1e-24;  // squared area over the longest edge's fourth power
  std::vector<double> stretches;
  double sum = 0;
  for (const Triangle& t : triangles) {
    const Vec3d a = rest[t[1]] - rest[t[0]];
    const Vec3d b = rest[t[2]] - rest[t[0]];
    const double area2 = norm2(cross(a, b));
    const double edge = std::max({norm2(a), norm2(b), norm2(b - a)});
    if (!(area2 > kNoArea * edge * edge)) continue;
    const Vec3d c = now[t[1]] - now[t[0]];
    const Vec3d d = now[t[2]] - now[t[0]];
    // Of the matrix that takes one metric to the other.
    const double trace = (norm2(b) * norm2(c) - 2 * dot(a, b) * dot(c, d) + norm2(a) * norm2(d)) / area2;
    const double product = norm2(cross(c, d)) / area2;
    const double greater = 0.5 * (trace + std::sqrt(std::max(0.0, trace * trace - 4 * product)));
    const double less = product / greater;
    stretches.push_back(std::sqrt(std::max(greater, 1 / less)));
    const double x = 0.5 * std::log(greater);
    const double y = 0.5 * std::log(less);
    sum += x * x + y * y;
  }
  StretchOfShape result;
  if (stretches.empty()) return result;
  result.rms_log = std::sqrt(sum / (2 * static_cast<double>(stretches.size())));
  std::sort(stretches.begin(), stretches.end());
  result.greatest = stretches.back();
  result.most_99 = stretches[(stretches.size() * 99 + 99) / 100 - 1];
  return result;
}

std::size_t count_new(const Crossings& pairs, const Crossings& before) {
  return static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return !std::binary_search(before.begin(), before.end(), pair);
  }));
}

}  // namespace knead::fit_detail

namespace knead {

std::string complaint_about(const BodyFitReport& report, const BodyFitOptions& options) {
  if (report.crossings_new > 0) {
    return fmt::format(
        "{} pairs of triangles cross after the fit that did not before; give more pairs of landmarks "
        "where they cross",
        report.crossings_new);
  }
  if (report.greatest_stretch > options.max_stretch) {
    return fmt::format(
        "a triangle is stretched by {:.3g}, more than {:g}; look at the result "
        "there, correct pairs of landmarks, or give more",
        report.greatest_stretch, options.max_stretch);
  }
  if (report.landmark_excess > kFitExact) {
    return fmt::format(
        "a landmark is {:.2g} of the diagonal from its place; give fewer pairs, pairs that are farther "
        "apart, or a tolerance",
        report.landmark_distance);
  }
  return {};
}

}  // namespace knead
