// Measures of fits, and the sentence that says which bound a fit misses.
#include "fit/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "mesh/body_points.h"

namespace knead::detail {

namespace {

constexpr std::size_t kReportGrain = 64;

struct PointDistance {
  Vec3d point;
  double distance = 0;

  bool operator<(const PointDistance& other) const { return distance < other.distance; }
};

void add_distances(std::span<const Vec3d> from, const SurfaceTree& to, const Measuring& measuring,
                   std::vector<PointDistance>& distances) {
  const std::size_t stride = measuring.max_samples == 0 ? 1 : from.size() / measuring.max_samples + 1;
  const std::size_t count = (from.size() + stride - 1) / stride;
  const std::size_t first = distances.size();
  distances.resize(first + count);
  parallel_for(count, kReportGrain, measuring.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(measuring.progress);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d& point = from[i * stride];
      distances[first + i] = {point, to.closest(point)->distance};
    }
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
  std::vector<PointDistance> distances;
  add_distances(a.positions, of_b, measuring, distances);
  add_distances(b.positions, tree_of(a), measuring, distances);
  FitDistance result;
  for (const PointDistance& d : distances) result.mean += d.distance;
  std::sort(distances.begin(), distances.end());
  result.mean /= static_cast<double>(distances.size()) * measuring.length;
  result.percentile_95 = distances[(distances.size() * 95 + 99) / 100 - 1].distance / measuring.length;
  result.max = distances.back().distance / measuring.length;
  result.farthest = distances.back().point;
  return result;
}

double mean_distance(std::span<const Vec3d> from, const SurfaceTree& to, const Measuring& measuring) {
  std::vector<PointDistance> distances;
  add_distances(from, to, measuring, distances);
  double sum = 0;
  for (const PointDistance& d : distances) sum += d.distance;
  return sum / (static_cast<double>(distances.size()) * measuring.length);
}

bool turn_outward(const Mesh& mesh, std::vector<Triangle>& triangles, int threads) {
  const Measures m = measure(mesh, threads);
  if (!m.closed() || !m.oriented() || m.volume >= 0) return false;
  for (Triangle& t : triangles) std::swap(t[1], t[2]);
  return true;
}

std::optional<double> volume_of(const Mesh& mesh, std::span<const Vec3d> positions, int threads) {
  const Measures m = measure(mesh, threads);
  if (!m.closed() || !m.oriented()) return std::nullopt;
  return std::abs(measure_volume_and_area(mesh, positions).volume);
}

std::optional<double> relative(const std::optional<double>& now, const std::optional<double>& before) {
  return now && before && *before != 0 ? std::optional(*now / *before - 1) : std::nullopt;
}

double mean_edge(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  double sum = 0;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) sum += norm(positions[t[(i + 1) % 3]] - positions[t[i]]);
  }
  return sum / (3 * static_cast<double>(triangles.size()));
}

void add_landmarks(std::span<const Vec3d> at, std::span<const FitPair> pairs, double diagonal, BodyFitReport& report) {
  double sum = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double distance = norm(at[i] - pairs[i].target) / diagonal;
    report.landmark_distance = std::max(report.landmark_distance, distance);
    sum += distance * distance;
  }
  if (!at.empty()) report.landmark_rms = std::sqrt(sum / static_cast<double>(at.size()));
}

double median_distance(std::span<const Vec3d> at, std::span<const FitPair> pairs) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < pairs.size(); ++i) distances.push_back(norm(at[i] - pairs[i].target));
  std::sort(distances.begin(), distances.end());
  return distances.empty() ? 0 : distances[distances.size() / 2];
}

GrowthRange growth_range(std::span<const Stroke> strokes, const std::vector<Vec3d>& points,
                         const Measuring& measuring) {
  Flow flow;
  for (const Stroke& stroke : strokes) {
    const Flow own = flow_of(stroke);
    flow.segments.insert(flow.segments.end(), own.segments.begin(), own.segments.end());
  }
  std::vector<Vec3d> chosen;
  for (const std::uint32_t i : spread_points(points, measuring.max_samples)) chosen.push_back(points[i]);
  AdvectOptions options;
  options.tolerance = absolute_tolerance(kDefaultRelativeTolerance, measuring.length);
  options.threads = measuring.threads;
  options.progress = measuring.progress;
  GrowthRange range{kInfinity, 0};
  for (const Mat3d& jacobian : jacobians(flow, chosen, options)) {
    const double det = determinant(jacobian);
    range.least = std::min(det, range.least);
    range.greatest = std::max(det, range.greatest);
  }
  return range;
}

}  // namespace knead::detail

namespace knead {

constexpr double kMaxMeanDistance = 3e-3;      // of surfaces that count as fitted, of the diagonal
constexpr double kMaxDistance = 3e-2;          // of any of their vertices: farther, a part of the shape is missing
constexpr double kMaxVolumeDifference = 1e-3;  // relative; a greater one hinders a fit that keeps the volume

std::string complaint_about(const BodyFitReport& report, const BodyFitOptions& options) {
  if (report.crossings_new > detail::max_new_crossings(report.crossings_before)) {
    return fmt::format("{} after the fit that did not before; give more pairs of landmarks where they cross",
                       report.crossings_new == 1 ? "1 pair of triangles crosses"
                                                 : fmt::format("{} pairs of triangles cross", report.crossings_new));
  }
  if (report.greatest_stretch > options.max_stretch) {
    return fmt::format(
        "a triangle is stretched by {:.3g}, more than {:g}; look at the result "
        "there, correct pairs of landmarks, or give more",
        report.greatest_stretch, options.max_stretch);
  }
  if (report.landmark_excess > kFitExact && report.reached < 1) {
    return fmt::format(
        "the landmarks came {:.0f}% of their way, then {}; the nearest sound state is written: correct pairs of "
        "landmarks there, or give more",
        100 * report.reached, report.obstacle);
  }
  if (report.landmark_excess > kFitExact) {
    return fmt::format(
        "a landmark is {:.2g} of the diagonal from its place; give fewer pairs, pairs that are farther "
        "apart, or a tolerance",
        report.landmark_distance);
  }
  const double apart = report.after_covered.value_or(report.after.mean);
  if (options.surface && apart > kMaxMeanDistance) {
    const bool differs =
        options.volume == FitVolume::keep && std::abs(report.volume_difference.value_or(0)) > kMaxVolumeDifference;
    return fmt::format("the surfaces are still {:.2g}% of the diagonal apart; give more pairs of landmarks{}",
                       100 * apart, differs ? ", or let the volume change, for the volumes differ" : "");
  }
  if (options.surface && !report.after_covered && report.after.max > kMaxDistance) {
    const Vec3d& p = report.after.farthest;
    return fmt::format(
        "the surfaces are {:.2g}% of the diagonal apart at ({:.4g}, {:.4g}, {:.4g}); give landmarks there",
        100 * report.after.max, p.x, p.y, p.z);
  }
  return {};
}

}  // namespace knead
