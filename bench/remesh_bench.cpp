// How long it takes to remesh one stroke that touches about 100,000 edges, and how long the structure beneath it takes,
// beside OpenMesh's where that is found: making it of the triangles that the stroke touches, and splitting 30,000
// edges. The times of these two, and every "CPU", are processor times of all threads.
#include <benchmark/benchmark.h>

#include <array>
#include <ctime>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/flow/reach.h"
#include "knead/math/box.h"
#include "knead/mesh/edges.h"
#include "knead/mesh/shapes.h"
#include "knead/remesh/patch.h"
#include "knead/remesh/remesh.h"
#include "knead/remesh/surface.h"
#include "knead/tool/stroke.h"

#ifdef KNEAD_HAS_OPENMESH
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#endif

namespace {

using namespace knead;
using remesh_detail::kNone;
using remesh_detail::Patch;
using remesh_detail::Surface;

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
    for_each_edge(edge_uses(mesh), [&](std::span<const EdgeUse> uses) {
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
  const FlowReach reach(pull().flow);
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

const Patch& patch() {
  static const Patch kPatch =
      remesh_detail::take_patch(pull().mesh, pull().after, Deformation{pull().deformation.carry}, pull().options);
  return kPatch;
}

void take_out(benchmark::State& state) {
  for (auto iteration : state) {
    const Patch result =
        remesh_detail::take_patch(pull().mesh, pull().after, Deformation{pull().deformation.carry}, pull().options);
    benchmark::DoNotOptimize(result.surface.corner.data());
  }
}
BENCHMARK(take_out)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

// The ends of the edges that are split, spread over the patch.
constexpr std::size_t kSplits = 30'000;

std::vector<std::uint32_t> split_edges() {
  const Surface& s = patch().surface;
  std::vector<std::uint32_t> inner;
  for (std::uint32_t e = 0; e < s.halfedge.size(); ++e) {
    if (s.opposite[s.halfedge[e]] != kNone) inner.push_back(e);
  }
  const std::size_t stride = inner.size() / kSplits;
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < kSplits && stride > 0; ++i) chosen.push_back(inner[i * stride]);
  return chosen;
}

// Runs work(structure) on a fresh structure each time; only work counts, in processor time, of one thread.
template <class Make, class Work>
void timed(benchmark::State& state, Make make, Work work) {
  for (auto iteration : state) {
    auto structure = make();
    const std::clock_t begin = std::clock();
    work(structure);
    state.SetIterationTime(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    benchmark::DoNotOptimize(&structure);
  }
  state.counters["edges"] = static_cast<double>(patch().surface.halfedge.size());
}

// What connect() begins with: corners and places.
Surface unconnected() {
  Surface s;
  s.corner = patch().surface.corner;
  s.face_source = patch().surface.face_source;
  s.before = patch().surface.before;
  s.after = patch().surface.after;
  return s;
}

void connect_ours(benchmark::State& state) {
  timed(state, unconnected, [](Surface& s) { connect(s); });
}
BENCHMARK(connect_ours)->Unit(benchmark::kMillisecond)->UseManualTime();

void split_ours(benchmark::State& state) {
  const std::vector<std::uint32_t> edges = split_edges();
  timed(
      state, [] { return patch().surface; },
      [&](Surface& s) {
        for (const std::uint32_t e : edges) {
          const std::uint32_t h = s.halfedge[e];
          const std::uint32_t a = s.origin(h);
          const std::uint32_t b = s.target(h);
          split(s, h, (s.before[a] + s.before[b]) * 0.5, (s.after[a] + s.after[b]) * 0.5);
        }
      });
}
BENCHMARK(split_ours)->Unit(benchmark::kMillisecond)->UseManualTime();

#ifdef KNEAD_HAS_OPENMESH
struct Traits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};
using OpenMeshSurface = OpenMesh::TriMesh_ArrayKernelT<Traits>;

OpenMesh::Vec3d to_openmesh(const Vec3d& p) { return {p.x, p.y, p.z}; }

// The same triangles, with the place after the deformation as a property.
struct OpenMeshPatch {
  OpenMeshSurface mesh;
  OpenMesh::VPropHandleT<OpenMesh::Vec3d> after;

  OpenMeshPatch() { mesh.add_property(after); }

  void connect() {
    const Surface& s = patch().surface;
    mesh.reserve(s.vertex_count(), s.halfedge.size(), s.face_count());
    for (std::size_t v = 0; v < s.vertex_count(); ++v) {
      mesh.property(after, mesh.add_vertex(to_openmesh(s.before[v]))) = to_openmesh(s.after[v]);
    }
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      const auto [a, b, c] = s.triangle(f);
      mesh.add_face(OpenMesh::VertexHandle(static_cast<int>(a)), OpenMesh::VertexHandle(static_cast<int>(b)),
                    OpenMesh::VertexHandle(static_cast<int>(c)));
    }
  }
};

void connect_openmesh(benchmark::State& state) {
  timed(
      state, [] { return OpenMeshPatch{}; }, [](OpenMeshPatch& p) { p.connect(); });
}
BENCHMARK(connect_openmesh)->Unit(benchmark::kMillisecond)->UseManualTime();

void split_openmesh(benchmark::State& state) {
  OpenMeshPatch connected;
  connected.connect();
  std::vector<OpenMesh::EdgeHandle> edges;
  for (const std::uint32_t e : split_edges()) {
    const std::uint32_t h = patch().surface.halfedge[e];
    edges.push_back(connected.mesh.edge_handle(
        connected.mesh.find_halfedge(OpenMesh::VertexHandle(static_cast<int>(patch().surface.origin(h))),
                                     OpenMesh::VertexHandle(static_cast<int>(patch().surface.target(h))))));
  }
  timed(
      state, [&] { return connected; },
      [&](OpenMeshPatch& p) {
        for (const OpenMesh::EdgeHandle e : edges) {
          const auto h = p.mesh.halfedge_handle(e, 0);
          const auto a = p.mesh.from_vertex_handle(h);
          const auto b = p.mesh.to_vertex_handle(h);
          const auto m = p.mesh.add_vertex((p.mesh.point(a) + p.mesh.point(b)) * 0.5);
          p.mesh.property(p.after, m) = (p.mesh.property(p.after, a) + p.mesh.property(p.after, b)) * 0.5;
          p.mesh.split(e, m);
        }
      });
}
BENCHMARK(split_openmesh)->Unit(benchmark::kMillisecond)->UseManualTime();
#endif

}  // namespace
