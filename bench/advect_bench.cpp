// How fast points are moved: one stroke of a tool over a sphere, one thread. Vertex-steps per second count accepted
// steps of path lines, as the paper's benchmark does (its section 6: 1.0e6 per second and CPU in 2006).
#include <benchmark/benchmark.h>

#include <vector>

#include "knead/flow/advect.h"
#include "knead/mesh/shapes.h"

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
  for (auto iteration : state) {
    std::vector<Vec3d> moved = points;
    steps += advect(flow, moved, options).accepted_steps;
    benchmark::DoNotOptimize(moved.data());
  }
  state.counters["vertex_steps_per_s"] = benchmark::Counter(static_cast<double>(steps), benchmark::Counter::kIsRate);
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
BENCHMARK_CAPTURE(whole_sphere, dp54_float, Integrator::dormand_prince, Precision::float32)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_sphere, dp54_double, Integrator::dormand_prince, Precision::float64)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_sphere, tsit5_float, Integrator::tsitouras, Precision::float32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_sphere, bs32_float, Integrator::bogacki_shampine, Precision::float32)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_sphere, rk4_float, Integrator::rk4, Precision::float32)->Unit(benchmark::kMillisecond);

// A brush that touches 4% of the vertices.
void local_brush(benchmark::State& state, Precision precision) {
  run(state, swept(Ball<double>{}, {0.05, 0.3}), options_with(Integrator::dormand_prince, precision));
}
BENCHMARK_CAPTURE(local_brush, dp54_float, Precision::float32)->Unit(benchmark::kMillisecond);

void capsule(benchmark::State& state) {
  run(state, swept(Capsule<double>{{0.5, 0, 0}}, {0.1, 0.8}),
      options_with(Integrator::dormand_prince, Precision::float32));
}
BENCHMARK(capsule)->Unit(benchmark::kMillisecond);

void point_set(benchmark::State& state) {
  PointSet<double> set;
  for (int i = 0; i < state.range(0); ++i) {
    const double at = static_cast<double>(i) / static_cast<double>(state.range(0));
    set.points.push_back({at - 0.5, 0.3 * at * at, 0});
  }
  run(state, swept(set, {0, 0.5}), options_with(Integrator::dormand_prince, Precision::float32));
}
BENCHMARK(point_set)->Arg(10)->Arg(100)->Unit(benchmark::kMillisecond);

}  // namespace
