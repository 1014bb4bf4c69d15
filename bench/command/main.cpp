// knead-bench, which `knead bench` starts: measures how fast this machine deforms shapes, compared with a plain version
// of the paper's method.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "command.h"
#include "comparisons.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "output.h"
#include "scenes.h"
#include "yardsticks.h"

namespace knead::command {
namespace {

// The plain version and the errors are measured on this many vertices, evenly chosen, because they are much slower.
constexpr std::size_t kReferenceVertices = 8000;

struct Row {
  const BenchScene* scene = nullptr;
  std::size_t touched = 0;
  double steps_mean = 0;
  double seconds = 0;
  double vertex_steps_per_s = 0;
  double reference_vertex_steps_per_s = 0;
  double ratio = 0;
  double peak_fraction = 0;
  double max_error = 0;
  double reference_max_error = 0;
};

void measure_errors(const BenchScene& scene, Row& row) {
  const std::vector<Vec3d> sample = sample_of(scene.points, kErrorVertices);
  const std::vector<Vec3d> expected = exact_positions(scene.flow, sample, scene.size);
  std::vector<Vec3d> found = sample;
  advect(scene.flow, found, advect_options(scene));
  row.max_error = greatest_distance(found, expected) / scene.size;
  found = sample;
  bench::advect_reference(scene.flow, found, scene.tolerance * scene.size);
  row.reference_max_error = greatest_distance(found, expected) / scene.size;
}

Row measure(const BenchScene& scene, double gflops) {
  Row row{&scene};
  AdvectResult result;
  const PointBlocks blocks = blocks_of(scene);
  PointBlocks moved_blocks = blocks;
  row.seconds = median_seconds([&] { moved_blocks = blocks; },
                               [&] { result = advect(scene.flow, moved_blocks, scene.points, advect_options(scene)); });
  std::vector<Vec3d> moved = scene.points;
  moved_blocks.update(moved);
  const auto count = static_cast<double>(scene.points.size());
  for (std::size_t i = 0; i < moved.size(); ++i) row.touched += moved[i] == scene.points[i] ? 0 : 1;
  const auto steps = static_cast<double>(result.accepted_steps);
  row.steps_mean = steps / count;
  row.vertex_steps_per_s = steps / row.seconds;

  const std::vector<Vec3d> sample = sample_of(scene.points, kReferenceVertices);
  bench::ReferenceResult reference;
  const double reference_seconds = median_seconds([&] {
    moved = sample;
    reference = bench::advect_reference(scene.flow, moved, scene.tolerance * scene.size);
  });
  row.reference_vertex_steps_per_s = static_cast<double>(reference.accepted_steps) / reference_seconds;
  row.ratio = reference_seconds / static_cast<double>(sample.size()) / (row.seconds / count);

  const auto operations = static_cast<double>(bench::operations_of(scene.flow, sample, advect_options(scene)));
  row.peak_fraction = 1e-9 * operations * count / static_cast<double>(sample.size()) / row.seconds / gflops;
  measure_errors(scene, row);
  return row;
}

Json json_of(const Row& row) {
  const BenchScene& scene = *row.scene;
  return {{"scene", scene.name},
          {"tool", scene.tool},
          {"precision", scene.precision == Precision::float32 ? "float" : "double"},
          {"threads", scene.threads},
          {"vertices", scene.points.size()},
          {"touched", row.touched},
          {"steps_mean", row.steps_mean},
          {"seconds", row.seconds},
          {"steps_per_s", row.steps_mean / row.seconds},
          {"vertex_steps_per_s", row.vertex_steps_per_s},
          {"reference_vertex_steps_per_s", row.reference_vertex_steps_per_s},
          {"ratio", row.ratio},
          {"peak_fraction", row.peak_fraction},
          {"max_error", row.max_error},
          {"reference_max_error", row.reference_max_error}};
}

std::string heading() {
  return fmt::format("{:30} {:8} {:7} {:>7} {:>9} {:>9} {:>7} {:>9} {:>9} {:>9} {:>7} {:>6} {:>9}\n", "scene", "tool",
                     "", "threads", "vertices", "touched", "steps", "steps/s", "M v-s/s", "reference", "ratio", "peak",
                     "error");
}

std::string text_of(const Row& row) {
  const BenchScene& scene = *row.scene;
  return fmt::format("{:30} {:8} {:7} {:7} {:9} {:9} {:7.1f} {:9.1f} {:9.2f} {:9.2f} {:7.1f} {:5.1f}% {:9.1e}\n",
                     scene.name, scene.tool, scene.precision == Precision::float32 ? "float" : "double", scene.threads,
                     scene.points.size(), row.touched, row.steps_mean, row.steps_mean / row.seconds,
                     1e-6 * row.vertex_steps_per_s, 1e-6 * row.reference_vertex_steps_per_s, row.ratio,
                     100 * row.peak_fraction, row.max_error);
}

// The folder with scans of the paper's shapes, if there is one.
std::string mesh_folder() {
  const char* given = std::getenv("KNEAD_MESHES");
  return given != nullptr ? given : "../shared/meshes";
}

Mesh read_mesh(const std::string& path) {
  Mesh mesh = read_shape(path).mesh;
  if (mesh.positions.empty()) throw InvalidInput(path + ": has no vertices; give a shape that has some");
  return mesh;
}

struct Scenes {
  std::vector<BenchScene> own;
  std::vector<PeerScene> peers;
};

Scenes scenes_of(const BenchOptions& options) {
  if (options.meshes.empty()) return {standard_scenes(mesh_folder()), standard_peer_scenes(mesh_folder())};
  Scenes scenes;
  for (const std::string& path : options.meshes) {
    const Mesh mesh = read_mesh(path);
    scenes.own.push_back(paper_scene(path, mesh.positions));
    for (PeerScene& scene : peer_scenes(path, mesh)) scenes.peers.push_back(std::move(scene));
  }
  return scenes;
}

// Prints each row as soon as it is measured, unless quiet.
Json measure_rows(const std::vector<BenchScene>& scenes, double floats, double doubles, bool quiet) {
  Json rows = Json::array();
  if (!quiet) print(heading());
  for (const BenchScene& scene : scenes) {
    const double peak = scene.precision == Precision::float32 ? floats : doubles;
    const Row row = measure(scene, peak * scene.threads);
    rows.push_back(json_of(row));
    if (!quiet) print(text_of(row));
  }
  return rows;
}

Json measure_all_peers(const std::vector<PeerScene>& scenes, bool quiet) {
  Json rows = Json::array();
  if (!quiet && !scenes.empty()) print(peers_heading());
  for (const PeerScene& scene : scenes) {
    for (const PeerRow& row : measure_peers(scene)) {
      rows.push_back(json_of(row));
      if (!quiet) print(text_of(row));
    }
  }
  return rows;
}

std::vector<BenchScene> integrator_scenes_of(const BenchOptions& options) {
  std::string name;
  if (options.meshes.empty()) {
    const std::vector<Vec3d> points = standard_points(mesh_folder(), name);
    return integrator_scenes(name, points);
  }
  std::vector<BenchScene> scenes;
  for (const std::string& path : options.meshes) {
    for (BenchScene& scene : integrator_scenes(path, read_mesh(path).positions)) scenes.push_back(std::move(scene));
  }
  return scenes;
}

Json measure_all_integrators(const std::vector<BenchScene>& scenes, bool quiet) {
  Json integrators = Json::array();
  Json times_to_error = Json::array();
  std::vector<IntegratorRun> all;
  for (const BenchScene& scene : scenes) {
    const std::vector<IntegratorRun> runs = measure_integrators(scene);
    for (const IntegratorRun& run : runs) integrators.push_back(json_of(run));
    if (!quiet) print(text_of(runs));
    all.insert(all.end(), runs.begin(), runs.end());
  }
  const std::vector<TimesToAccuracy> times = times_to_accuracy(all);
  for (const TimesToAccuracy& row : times) times_to_error.push_back(json_of(row));
  if (!quiet) print(text_of(times));
  return {{"integrators", integrators},
          {"times_to_error", times_to_error},
          {"soonest_by_default", to_string(soonest_by_default(times))}};
}

#ifdef KNEAD_HAS_GPU
// Returns the paper's scenes, on its four shapes or on those that the options name.
std::vector<BenchScene> paper_scenes_of(const BenchOptions& options) {
  constexpr std::size_t kPaperScenes = 4;  // the first of the standard ones
  std::vector<BenchScene> scenes;
  if (options.vertices) scenes.push_back(paper_knot(*options.vertices));
  if (options.meshes.empty() && !options.vertices) {
    scenes = standard_scenes(mesh_folder());
    scenes.resize(kPaperScenes);
  }
  for (const std::string& path : options.meshes) scenes.push_back(paper_scene(path, read_mesh(path).positions));
  return scenes;
}
#endif

void run_bench(const BenchOptions& options) {
  const bool quiet = options.common.json;
  check_backend(options.backend);
  if (options.vertices && options.backend != "gpu") throw UsageError("--vertices is for --backend gpu; leave it out");
#ifdef KNEAD_HAS_GPU  // else check_backend has refused it
  if (options.backend == "gpu") {
    if (options.integrators) throw UsageError("--integrators are measured on the CPU; leave --backend out");
    const bool all = options.meshes.empty() && !options.vertices;
    const Json json = measure_on_gpu(paper_scenes_of(options), all, quiet);
    if (quiet) print(to_indented_text(json));
    return;
  }
#endif
  if (options.integrators) {
    const Json json = measure_all_integrators(integrator_scenes_of(options), quiet);
    if (quiet) print(to_indented_text(json));
    return;
  }
  const Scenes scenes = scenes_of(options);
  const int threads = hardware_threads();
  const double floats = bench::fma_gflops(Precision::float32, 1);
  const double doubles = bench::fma_gflops(Precision::float64, 1);
  const double scaling = bench::fma_gflops(Precision::float32, threads) / floats;
  const double copied = bench::copy_gigabytes_per_second();
  if (!quiet) {
    print(fmt::format(
        "one core: {:.0f} Gflop/s of multiply-adds in float, {:.0f} in double; {} threads: {:.2f} times that; "
        "memory {:.1f} GB/s\n",
        floats, doubles, threads, scaling, copied));
  }
  const Json json{{"simd", simd_name()},
                  {"threads", threads},
                  {"fma_gflops", floats},
                  {"fma_scaling", scaling},
                  {"copy_gigabytes_per_s", copied},
                  {"rows", measure_rows(scenes.own, floats, doubles, quiet)},
                  {"peers", measure_all_peers(scenes.peers, quiet)}};
  if (quiet) print(to_indented_text(json));
}

}  // namespace
}  // namespace knead::command

int main(int argc, char** argv) {
  std::string word = "bench";
  std::vector<char*> words(argv, argv + argc);
  words.insert(words.begin() + std::min(argc, 1), word.data());
  return knead::command::run_program(static_cast<int>(words.size()), words.data(),
                                     {knead::command::bench_subcommand(knead::command::run_bench)});
}
