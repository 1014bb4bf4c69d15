// The time for remeshing one stroke that touches about 100,000 edges. Every "CPU" is the processor time of all
// threads.
#include <benchmark/benchmark.h>

#include <vector>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"
#include "mesh/edges.h"

namespace {

using namespace knead;

// A part of a fine sphere, pulled out.
struct Pull {
  Mesh mesh = make_shape(ShapeKind::sphere, 200'000);
  Flow flow;
  AdvectOptions move;
  std::vector<Vec3d> after = mesh.positions;
  Deformation deformation;
  RemeshOptions options;

  Pull() {
    ImplicitStroke stroke;
    stroke.path = {{0, 0, 0.9}, {0, 0, 1.3}};
    stroke.inner = 0.3;
    stroke.outer = 0.78;
    flow = flow_of(stroke);
    move.tolerance = 1e-5 * bounding_box(mesh.positions).diagonal();
    advect(flow, after, move);
    deformation.carry = [this](std::span<Vec3d> points) { advect(flow, points, move); };
    options.targets = resolve({}, mesh);
  }

  double touched_edges() const {
    double count = 0;
    for_each_edge(mesh, [&](std::span<const EdgeUse> uses) {
      const auto is_moved = [&](std::uint32_t v) { return after[v] != mesh.positions[v]; };
      if (is_moved(uses[0].low) || is_moved(uses[0].high)) ++count;
    });
    return count;
  }
};

const Pull& pull() {
  static const Pull kPull;
  return kPull;
}

void move_vertices(benchmark::State& state) {
  for (auto iteration : state) {
    std::vector<Vec3d> points = pull().mesh.positions;
    advect(pull().flow, points, pull().move);
    benchmark::DoNotOptimize(points.data());
  }
}
BENCHMARK(move_vertices)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

// With `improve` as at the defaults; without: edges are split, volume is compensated, crossings are looked for.
void remesh_stroke(benchmark::State& state, bool improve) {
  const FlowSupport reach(pull().flow);
  Deformation deformation = pull().deformation;
  deformation.may_move = [&](const Vec3d& center, double radius) { return reach.may_move(center, radius); };
  deformation.feature = reach.smallest_feature();
  RemeshOptions options = pull().options;
  if (!improve) options.targets.iterations = 0;
  std::size_t vertices = 0;
  std::size_t splits = 0;
  for (auto iteration : state) {
    const Remeshed result = remesh(pull().mesh, pull().after, deformation, options);
    vertices = result.mesh.vertex_count();
    splits = result.counts.splits;
  }
  state.counters["touched_edges"] = pull().touched_edges();
  state.counters["splits"] = static_cast<double>(splits);
  state.counters["vertices"] = static_cast<double>(vertices);
}
BENCHMARK_CAPTURE(remesh_stroke, split_only, false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(remesh_stroke, all, true)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

}  // namespace
