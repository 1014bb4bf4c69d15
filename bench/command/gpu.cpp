// Measures advect() on a GPU.
#include "comparisons.h"

#include <fmt/format.h>

#include <optional>

#include "knead/editor/gpu.h"
#include "knead/error.h"
#include "output.h"
#include "scenes.h"
#include "yardsticks.h"

namespace knead::command {
namespace {

constexpr std::size_t kManyVertices = 10'000'000;
constexpr double kWarmUp = 0.5;  // seconds until a card has its clock: idle, an H100 runs at a fifth of it

struct GpuRow {
  const BenchScene* scene = nullptr;
  double first_seconds = 0;  // with the compilation of the shader
  double upload_seconds = 0;
  double seconds = 0;
  double download_seconds = 0;
  double steps_mean = 0;
  double vertex_steps_per_s = 0;
  double cpu_seconds = 0;    // all threads, points in blocks
  double ratio = 0;          // of the CPU's to the GPU's
  double peak_fraction = 0;  // of the GPU's multiply-adds
  double max_error = 0;
};

AdvectOptions on_all_threads(const BenchScene& scene) {
  AdvectOptions options = advect_options(scene);
  options.threads = AdvectOptions{}.threads;
  return options;
}

// Returns the additions, multiplications, divisions and roots for one evaluation of v, including steps and error
// estimates. They are counted in the CPU's kernels, which use the same formulas as the shaders.
double operations_to_an_evaluation(const BenchScene& scene, std::span<const Vec3d> sample) {
  const auto operations = static_cast<double>(bench::operations_of(scene.flow, sample, on_all_threads(scene)));
  std::vector<Vec3d> moved(sample.begin(), sample.end());
  return operations / static_cast<double>(advect(scene.flow, moved, on_all_threads(scene)).evaluations);
}

GpuRow measure(const BenchScene& scene, gpu::Gpu& gpu, double peak_gflops) {
  GpuRow row;
  row.scene = &scene;
  const AdvectOptions options = on_all_threads(scene);
  std::vector<Vec3d> sample = sample_of(scene.points, kErrorVertices);
  const double operations = operations_to_an_evaluation(scene, sample);
  const std::vector<Vec3d> expected = exact_positions(scene.flow, sample, scene.size);
  const Clock first;
  gpu.advect(scene.flow, sample, options);
  row.first_seconds = first.seconds();
  row.max_error = greatest_distance(sample, expected) / scene.size;

  std::optional<gpu::GpuPoints> points;
  AdvectResult result;
  row.upload_seconds = median_seconds([&] { points.reset(); }, [&] { points.emplace(gpu.upload(scene.points)); });
  const gpu::GpuPoints original = gpu.upload(scene.points);
  const auto rewind = [&] {
    gpu.assign(*points, original);
    gpu.collect(*points);
  };
  const auto run = [&] { result = gpu.advect(scene.flow, *points, options); };
  for (const Clock clock; clock.seconds() < kWarmUp;) {
    rewind();
    run();
  }
  row.seconds = median_seconds(rewind, run);
  std::vector<Vec3d> moved(scene.points.size());
  row.download_seconds = median_seconds([&] { gpu.download(*points, moved); });
  const auto steps = static_cast<double>(result.accepted_steps);
  row.steps_mean = steps / static_cast<double>(scene.points.size());
  row.vertex_steps_per_s = steps / row.seconds;
  row.peak_fraction = 1e-9 * operations * static_cast<double>(result.evaluations) / row.seconds / peak_gflops;

  const PointBlocks blocks = blocks_of(scene);
  PointBlocks moved_blocks = blocks;
  row.cpu_seconds =
      median_seconds([&] { moved_blocks = blocks; }, [&] { advect(scene.flow, moved_blocks, scene.points, options); });
  row.ratio = row.cpu_seconds / row.seconds;
  return row;
}

double per_segment(const GpuRow& row) {
  return 1e3 * row.seconds / static_cast<double>(row.scene->flow.segments.size());
}

Json json_of(const GpuRow& row) {
  return {{"scene", row.scene->name},
          {"tool", row.scene->tool},
          {"vertices", row.scene->points.size()},
          {"steps_mean", row.steps_mean},
          {"seconds", row.seconds},
          {"ms_per_segment", per_segment(row)},
          {"vertex_steps_per_s", row.vertex_steps_per_s},
          {"upload_seconds", row.upload_seconds},
          {"download_seconds", row.download_seconds},
          {"first_seconds", row.first_seconds},
          {"cpu_seconds", row.cpu_seconds},
          {"ratio", row.ratio},
          {"peak_fraction", row.peak_fraction},
          {"max_error", row.max_error}};
}

std::string gpu_heading() {
  return fmt::format("{:37} {:>9} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9} {:>9} {:>7} {:>7} {:>9}\n", "scene", "vertices",
                     "steps", "ms", "ms/segment", "M v-s/s", "ms up", "ms down", "ms first", "ratio", "peak", "error");
}

std::string text_of(const GpuRow& row) {
  return fmt::format("{:37} {:9} {:7.1f} {:9.2f} {:10.3f} {:9.1f} {:9.2f} {:9.2f} {:9.0f} {:7.2f} {:6.1f}% {:9.1e}\n",
                     row.scene->name + ", " + row.scene->tool, row.scene->points.size(), row.steps_mean,
                     1e3 * row.seconds, per_segment(row), 1e-6 * row.vertex_steps_per_s, 1e3 * row.upload_seconds,
                     1e3 * row.download_seconds, 1e3 * row.first_seconds, row.ratio, 100 * row.peak_fraction,
                     row.max_error);
}

}  // namespace

Json measure_on_gpu(std::vector<BenchScene> scenes, bool all, bool quiet) {
  gpu::Gpu gpu;
  if (all) scenes.push_back(grid_scene(scenes.back().name, scenes.back().points));
  if (all && !gpu.is_software()) {
    scenes.push_back(paper_knot(kManyVertices));
    scenes.push_back(grid_scene(scenes.back().name, scenes.back().points));
  }
  const double peak_gflops = gpu.multiply_add_gflops();
  Json rows = Json::array();
  if (!quiet)
    print(
        fmt::format("{}; multiply-adds: {:.0f} Gflop/s in float; the ratio is that of the CPU's time on {} threads\n{}",
                    gpu.description(), peak_gflops, hardware_threads(), gpu_heading()));
  for (const BenchScene& scene : scenes) {
    const GpuRow row = measure(scene, gpu, peak_gflops);
    rows.push_back(json_of(row));
    if (!quiet) print(text_of(row));
  }
  return {{"device", gpu.description()},
          {"is_software", gpu.is_software()},
          {"peak_gflops", peak_gflops},
          {"cpu_threads", hardware_threads()},
          {"rows", rows}};
}

}  // namespace knead::command
