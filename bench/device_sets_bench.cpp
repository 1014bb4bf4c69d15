// Large point sets on a GPU, beside the CPU: ten thousand points on a unit sphere pushed by a hundredth of
// the outer threshold, through the vertices of a sphere just within. Processor time, which on Mesa's software driver is
// that of the shaders; the second call, when they are compiled.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>
#include <vector>

#include "knead/gpu/gpu.h"
#include "knead/mesh/shapes.h"

namespace {

using namespace knead;

constexpr std::size_t kPoints = 10'000;
constexpr double kWithin = 0.99;  // of the set's radius

double processor_seconds(const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double begin = now();
  work();
  return now() - begin;
}

double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, norm(a[i] - b[i]));
  return most;
}

void compare(gpu::Gpu& gpu, int exponent, double spacings) {
  PointSet<double> set;
  set.points = make_shape(ShapeKind::sphere, kPoints).positions;
  set.exponent = exponent;
  std::vector<Vec3d> vertices = set.points;
  for (Vec3d& p : vertices) p *= kWithin;
  const double spacing = std::sqrt(4 * std::numbers::pi / static_cast<double>(set.points.size()));
  const double outer = spacings * spacing;
  Segment segment;
  segment.displacement = {0, 0, 0.01 * outer};
  segment.fields = {{{0, 0, 0}, Translation<double>{segment.displacement}, set, Thresholds<double>{0, outer}}};
  const Flow flow{{segment}};
  AdvectOptions options;
  options.tolerance = 1e-5 * 2 * std::sqrt(3.0);  // 1e-5 of the box diagonal, the command's default
  AdvectOptions exactly = options;
  exactly.tolerance = 1e-10;
  exactly.precision = Precision::float64;
  std::vector<Vec3d> exact = vertices;
  advect(flow, exact, exactly);
  std::vector<Vec3d> by_cpu = vertices;
  const double cpu = processor_seconds([&] { advect(flow, by_cpu, options); });
  std::vector<Vec3d> by_gpu = vertices;
  double seconds = 0;
  try {
    for (int call = 0; call < 2; ++call) {
      by_gpu = vertices;
      seconds = processor_seconds([&] { gpu.advect(flow, by_gpu, options); });
    }
    fmt::print("m = {:2}, outer {:2} spacings: GPU {:6.2f} s, CPU {:6.3f} s; off by {:.1e} and {:.1e}\n", exponent,
               spacings, seconds, cpu, greatest_distance(by_gpu, exact), greatest_distance(by_cpu, exact));
  } catch (const GpuError& error) {
    fmt::print("m = {:2}, outer {:2} spacings: {}\n", exponent, spacings, error.what());
  }
}

}  // namespace

int main() {
  try {
    gpu::Gpu gpu;
    fmt::print("{}\n", gpu.description());
    for (const int exponent : {8, 16}) {
      for (const double spacings : {1.0, 3.0, 8.0}) compare(gpu, exponent, spacings);
    }
  } catch (const GpuError& error) {
    fmt::print("{}\n", error.what());
  }
}
