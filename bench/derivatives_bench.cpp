// Gradients with respect to the parameters of a session, a pull at a random place for each, and to the coefficients of
// a grid of 22^3 nodes with noise, over random points in a box. Times on one thread, in seconds and relative to the
// deformation in single precision: medians of several runs.
//   derivatives_bench [POINTS [TOLERANCE]]   by default 2,000, and the deformation's 1e-5
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "knead/flow.h"
#include "knead/replay.h"

namespace {

using namespace knead;

constexpr double kDeformTolerance = 1e-5;

class Random {
 public:
  double number(double least, double greatest) {
    return least + (greatest - least) * static_cast<double>(random_()) / 4294967296.0;
  }
  Vec3d place() {
    const double x = number(-1, 1);
    const double y = number(-1, 1);
    return {x, y, number(-1, 1)};
  }

 private:
  std::mt19937 random_{1};
};

Session make_session(std::size_t parameters, Random& random) {
  std::string names;
  std::string lines;
  for (std::size_t i = 0; i < parameters; ++i) {
    const Vec3d p = random.place();
    names += fmt::format("{}\"p{}\": {}", i == 0 ? "" : ", ", i, p.z + random.number(0.1, 0.2));
    lines +=
        fmt::format(R"({{"tool": "implicit", "path": [[{}, {}, {}], [{}, {}, "$p{}"]], "inner": 0.1, "outer": 0.4}})",
                    p.x, p.y, p.z, p.x + random.number(-0.2, 0.2), p.y, i) +
        "\n";
  }
  return parse_session(R"({"knead": 1, "parameters": {)" + names + "}}\n" + lines, "bench");
}

constexpr int kMaxRuns = 9;
constexpr double kSeconds = 3;  // after which no run begins

template <class Work>
double seconds_of(const Work& work) {
  std::vector<double> seconds;
  double sum = 0;
  for (int run = 0; run < kMaxRuns && sum < kSeconds; ++run) {
    const auto began = std::chrono::steady_clock::now();
    work();
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    sum += seconds.back();
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

std::vector<Vec3d> places(std::size_t count, Random& random) {
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(random.place());
  return result;
}

std::vector<Vec3d> deformed(const Flow& flow, std::vector<Vec3d> points) {
  AdvectOptions options;
  options.tolerance = absolute_tolerance(kDeformTolerance, reference_length(points));
  options.threads = 1;
  advect(flow, points, options);
  return points;
}

// `size`: of the coefficients, in units of the squared spacing.
void measure_grid(double size, std::size_t count, double tolerance) {
  Random random;
  PotentialGrid grid;
  grid.spacing = 0.1;
  grid.origin = {-1.05, -1.05, -1.05};
  grid.counts = {22, 22, 22};
  std::vector<Vec3d> noise = places(22 * 22 * 22, random);
  for (Vec3d& a : noise) a = a * (size * grid.spacing * grid.spacing);
  grid.coefficients = SharedVectors(std::move(noise));
  Flow flow;
  flow.segments.emplace_back().grid = grid;
  const std::vector<Vec3d> points = places(count, random);
  const std::vector<Vec3d> gradient = places(count, random);
  const std::vector<Vec3d> moved = deformed(flow, points);
  double path = 0;
  for (std::size_t i = 0; i < count; ++i) path += norm(moved[i] - points[i]) / static_cast<double>(count);
  const double deform = seconds_of([&] { deformed(flow, points); });
  const DerivativeOptions options{.relative_tolerance = tolerance, .threads = 1};
  const double vjp = seconds_of([&] { coefficient_vjp(flow, points, gradient, options); });
  fmt::print("grid, paths of {:.1f} spacings: deform {:.4f} s, vjp {:.3f} s ({:.1f})\n", path / grid.spacing, deform,
             vjp, vjp / deform);
}

void measure(std::size_t parameters, std::size_t count, double tolerance) {
  Random random;
  const Session session = make_session(parameters, random);
  const std::vector<Vec3d> points = places(count, random);
  const std::vector<Vec3d> gradient = places(count, random);
  const double deform = seconds_of([&] { deformed(flow_of(session), points); });
  std::optional<SessionDerivatives> derivatives;
  const double prepare = seconds_of([&] { derivatives.emplace(session, SessionPart{}, 1); });
  const DerivativeOptions options{.relative_tolerance = tolerance, .threads = 1};
  const double jvp = seconds_of([&] { derivatives->jvp(points, std::vector<double>(parameters, 1), options); });
  const double vjp = seconds_of([&] { derivatives->vjp(points, gradient, options); });
  fmt::print(
      "{:4} parameters: deform {:.4f} s, prepare {:.3f} s ({:.0f}), jvp {:.3f} s ({:.0f}), vjp {:.3f} s ({:.0f})\n",
      parameters, deform, prepare, prepare / deform, jvp, jvp / deform, vjp, vjp / deform);
}

}  // namespace

int main(int argc, char** argv) {
  const auto count = static_cast<std::size_t>(argc > 1 ? std::atoi(argv[1]) : 2000);
  const double tolerance = argc > 2 ? std::atof(argv[2]) : kDeformTolerance;
  for (const std::size_t parameters : {1U, 64U, 256U}) measure(parameters, count, tolerance);
  for (const double size : {0.3, 1.0, 3.0}) measure_grid(size, count, tolerance);
}
