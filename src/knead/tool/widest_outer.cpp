#include <algorithm>
#include <atomic>
#include <cmath>
#include <variant>

#include "knead/flow/advect.h"
#include "knead/flow/reach.h"
#include "knead/math/box.h"
#include "knead/math/elementary.h"
#include "knead/math/error.h"
#include "knead/math/parallel.h"
#include "knead/tool/strain.h"

namespace knead {

namespace {

// Of a stroke whose `outer` is a distance from its tool; else null.
double* outer_of(Stroke& stroke) {
  if (auto* implicit = std::get_if<ImplicitStroke>(&stroke)) return &implicit->outer;
  if (auto* points = std::get_if<PointsStroke>(&stroke)) return &points->outer;
  if (auto* rotate = std::get_if<RotateStroke>(&stroke)) return &rotate->outer;
  if (auto* stretch = std::get_if<StretchStroke>(&stroke)) return &stretch->outer;
  return nullptr;
}

std::vector<Vec3d> resting(const Stroke& stroke, std::span<const Vec3d> points, int threads) {
  Box box;
  for (const Vec3d& p : points) box.extend(p);
  if (points.empty() || !(box.diagonal() > 0)) return {};
  std::vector<Vec3d> moved(points.begin(), points.end());
  AdvectOptions options;
  options.tolerance = absolute_tolerance(kDefaultRelativeTolerance, box.diagonal());
  options.threads = threads;
  if (advect(flow_of(stroke), moved, options).status != AdvectStatus::done) return {};
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (moved[i] == points[i]) result.push_back(points[i]);
  }
  return result;
}

bool misses_all(const Stroke& stroke, std::span<const Vec3d> points, int threads) {
  const FlowReach reach(flow_of(stroke));
  std::atomic<bool> misses{true};
  parallel_for(points.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && misses; ++i) {
      if (reach.may_move(points[i], 0)) misses = false;
    }
  });
  return misses;
}

double rounded_down(double x) {
  const double scale = elementary::power_of_ten(2 - elementary::decimal_exponent(x));
  return scale >= 1 ? std::floor(x * scale) / scale : std::floor(x * scale) * std::round(1 / scale);
}

}  // namespace

std::optional<double> widest_outer(const Stroke& stroke, std::span<const Vec3d> boundary, int threads) {
  constexpr double least_gain = 1.05;
  constexpr int most_doublings = 40;
  constexpr int halvings = 12;
  Stroke wider = stroke;
  double* const outer = outer_of(wider);
  if (outer == nullptr) return std::nullopt;
  const double now = *outer;
  const std::vector<Vec3d> rest = resting(stroke, boundary, threads);
  const auto fits = [&](double tried) {
    *outer = tried;
    return misses_all(wider, rest, threads);
  };
  if (rest.empty() || !fits(least_gain * now)) return std::nullopt;
  double good = least_gain * now;
  double bad = 2 * now;
  for (int i = 0; i < most_doublings && fits(bad); ++i) {
    good = bad;
    bad *= 2;
  }
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (good + bad);
    (fits(middle) ? good : bad) = middle;
  }
  const double result = rounded_down(good);
  return result < least_gain * now ? std::nullopt : std::optional(result);
}

}  // namespace knead
