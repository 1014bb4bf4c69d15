// The speed of advect(): one stroke of a tool over a sphere, one thread. Vertex-steps per second count accepted
// steps of path lines, as the paper's benchmark does (its section 6: 1.0e6 per second and CPU in 2006).
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "knead/flow.h"
#include "knead/mesh.h"

namespace {

using namespace knead;

Segment swept(const Region& region, Thresholds<double> thresholds) {
  Segment segment;
  const Vec3d by{0.2, 0.1, 0.3};
  segment.fields = {{{0, 0, 0.9}, Translation<double>{by}, region, thresholds}};
  segment.displacement = by;
  return segment;
}

void run(benchmark::State& state, const Segment& segment, const AdvectOptions& options) {
  const std::vector<Vec3d> points = make_shape(ShapeKind::sphere, 40'000).positions;
  const Flow flow{{segment}};
  std::uint64_t steps = 0;
  std::uint64_t evaluations = 0;
  for (auto iteration : state) {
    std::vector<Vec3d> moved = points;
    const AdvectResult result = advect(flow, moved, options);
    steps += result.accepted_steps;
    evaluations += result.evaluations;
    benchmark::DoNotOptimize(moved.data());
  }
  state.counters["vertex_steps_per_s"] = benchmark::Counter(static_cast<double>(steps), benchmark::Counter::kIsRate);
  state.counters["s_per_evaluation"] =
      benchmark::Counter(static_cast<double>(evaluations), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["steps_per_vertex"] =
      static_cast<double>(steps) / static_cast<double>(points.size() * state.iterations());
}

AdvectOptions options_with(Integrator integrator, Precision precision) {
  AdvectOptions options;
  options.tolerance = 2 * 1.7320508 * 1e-5;  // 1e-5 of the box diagonal
  options.integrator = integrator;
  options.precision = precision;
  options.threads = 1;
  return options;
}

// Everybody in the intermediate region: the paper's benchmark scenes.
void whole_sphere(benchmark::State& state, Integrator integrator, Precision precision) {
  run(state, swept(Ball<double>{}, {0.1, 2.5}), options_with(integrator, precision));
}
BENCHMARK_CAPTURE(whole_sphere, tsit5_float, Integrator::tsitouras, Precision::float32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_sphere, tsit5_double, Integrator::tsitouras, Precision::float64)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_sphere, rk4_float, Integrator::rk4, Precision::float32)->Unit(benchmark::kMillisecond);

// A brush that touches 4% of the vertices.
void local_brush(benchmark::State& state) {
  run(state, swept(Ball<double>{}, {0.05, 0.3}), options_with(Integrator::tsitouras, Precision::float32));
}
BENCHMARK(local_brush)->Unit(benchmark::kMillisecond);

void capsule(benchmark::State& state) {
  run(state, swept(Capsule<double>{{0.5, 0, 0}}, {0.1, 0.8}), options_with(Integrator::tsitouras, Precision::float32));
}
BENCHMARK(capsule)->Unit(benchmark::kMillisecond);

void point_set(benchmark::State& state) {
  PointSet<double> set;
  for (int i = 0; i < state.range(0); ++i) {
    const double at = static_cast<double>(i) / static_cast<double>(state.range(0));
    set.points.push_back({at - 0.5, 0.3 * at * at, 0});
  }
  run(state, swept(set, {0, 0.5}), options_with(Integrator::tsitouras, Precision::float32));
}
BENCHMARK(point_set)->Arg(10)->Arg(100)->Unit(benchmark::kMillisecond);

// A rotation that fades, on a grid of 14 x 14 x 14 nodes, through all of the sphere.
void grid(benchmark::State& state, Precision precision) {
  constexpr int kNodes = 14;
  Segment segment;
  segment.grid.spacing = 0.26;
  segment.grid.counts = {kNodes, kNodes, kNodes};
  segment.grid.origin = Vec3d{1, 1, 1} * (-0.5 * (kNodes - 1) * segment.grid.spacing);
  std::vector<Vec3d> coefficients;
  for (int n = 0; n < kNodes * kNodes * kNodes; ++n) {
    const Vec3d node{1.0 * (n % kNodes), 1.0 * (n / kNodes % kNodes), 1.0 * (n / (kNodes * kNodes))};
    const Vec3d x = segment.grid.origin + node * segment.grid.spacing;
    coefficients.push_back(Vec3d{0, 0, -0.1} * ((x.x * x.x + x.y * x.y) * std::exp(-2 * norm2(x))));
  }
  segment.grid.coefficients = SharedVectors(std::move(coefficients));
  run(state, segment, options_with(Integrator::tsitouras, precision));
}
BENCHMARK_CAPTURE(grid, float, Precision::float32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(grid, double, Precision::float64)->Unit(benchmark::kMillisecond);

}  // namespace
