#include "bench_measure.h"

#include <algorithm>

#include "work.h"

namespace knead::command {

std::vector<Vec3d> sample_of(const std::vector<Vec3d>& points, std::size_t count) {
  std::vector<Vec3d> sample;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / count);
  for (std::size_t i = 0; i < points.size(); i += stride) sample.push_back(points[i]);
  return sample;
}

double median_seconds(const std::function<void()>& run) {
  return median_seconds([] {}, run);
}

double median_seconds(const std::function<void()>& prepare, const std::function<void()>& run) {
  constexpr double kLongest = 2;
  constexpr double kShortest = 0.05;
  constexpr std::size_t kMax = 25;
  std::vector<double> times;
  double sum = 0;
  do {
    prepare();
    const Clock clock;
    run();
    times.push_back(clock.seconds());
    sum += times.back();
  } while (sum < kLongest && (times.size() < 3 || (sum < kShortest && times.size() < kMax)));
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

std::vector<Vec3d> exact_positions(const Flow& flow, std::vector<Vec3d> points, double size) {
  AdvectOptions options;
  options.tolerance = 1e-12 * size;
  options.precision = Precision::float64;
  options.integrator = Integrator::tsitouras;
  advect(flow, points, options);
  return points;
}

double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double greatest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) greatest = std::max(greatest, norm(a[i] - b[i]));
  return greatest;
}

}  // namespace knead::command
