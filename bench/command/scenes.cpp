// Makes the scenes of `knead bench`, and measures functions.
#include "scenes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"
#include "output.h"

namespace knead::command {
namespace {

constexpr int kSegments = 20;

BenchScene scene_of(std::string name, std::string tool, std::vector<Vec3d> points) {
  BenchScene scene;
  scene.name = std::move(name);
  scene.tool = std::move(tool);
  scene.size = bounding_box(points).diagonal();
  scene.points = std::move(points);
  return scene;
}

// Returns a gentle arc of the given length, a multiple of `size`.
std::vector<Vec3d> path_of(const Vec3d& from, double length) {
  std::vector<Vec3d> path{from};
  for (int i = 0; i < kSegments; ++i) {
    const Vec3d way = normalized(Vec3d{1, 0.5 * (1 - 2.0 * i / kSegments), 0.2});
    path.push_back(path.back() + way * (length / kSegments));
  }
  return path;
}

// Returns one stroke that reaches most of the shape for each tool except the pulling ball.
std::vector<BenchScene> tool_scenes(const std::string& name, const std::vector<Vec3d>& points) {
  const Box box = bounding_box(points);
  const Vec3d c = box.center();
  const double d = box.diagonal();
  const Vec3d x{1, 0, 0};
  const Vec3d y{0, 1, 0};
  ImplicitStroke capsule{path_of(c, 0.25 * d), 0.07 * d, 0.9 * d};
  capsule.region = ImplicitRegion::capsule;
  capsule.half_axis = Vec3d{0, 0.1, 0.1} * d;
  ImplicitStroke wide{path_of(c, 0.25 * d), 0, 0.965 * d};
  wide.falloff = kWideFalloff;
  wide.bump = wide.outer / 4;
  PointsStroke set;
  for (const double dx : {-0.1, 0.1}) {
    for (const double dy : {-0.1, 0.1}) {
      for (const double dz : {-0.1, 0.1}) set.points.push_back(c + Vec3d{dx, dy, dz} * d);
    }
  }
  set.outer = 0.8 * d;
  set.displacements = {x * (0.05 * d), y * (0.05 * d)};
  const std::vector<std::pair<std::string, Stroke>> strokes{
      {"wide ball", wide},
      {"capsule", capsule},
      {"rotate", RotateStroke{c, {1, 1, 0}, 60, 0.05 * d, 0.8 * d, 1}},
      {"stretch", StretchStroke{c, {1, 1, 0}, 1.5, 0.05 * d, 0.8 * d}},
      {"twist", TwistStroke{c, x, 60 / d, -0.4 * d, 0.4 * d, Vec3d{1, 0.2, 0}, 1}},
      {"bend", BendStroke{c, y, x, 40, BendWidth{0.8 * d}}},
      {"points", set}};
  std::vector<BenchScene> scenes;
  for (const auto& [tool, stroke] : strokes) {
    BenchScene& scene = scenes.emplace_back(scene_of(name, tool, points));
    scene.flow = flow_of(stroke);
  }
  return scenes;
}

std::vector<Vec3d> points_of(const std::filesystem::path& file, std::size_t vertices, std::string& name) {
  if (std::filesystem::exists(file)) {
    name = file.filename().string();
    return read_shape(file).mesh.positions;
  }
  name = "knot " + std::to_string(vertices);
  return make_shape(ShapeKind::knot, vertices).positions;
}

// Returns a scene with a brush that reaches little of the shape.
BenchScene brush_scene(const std::string& name, const std::vector<Vec3d>& points) {
  BenchScene scene = scene_of(name, "brush", points);
  const Vec3d corner = scene.points[scene.points.size() / 2];
  scene.flow = flow_of(ImplicitStroke{path_of(corner, 0.25 * scene.size), 0.0227 * scene.size, 0.142 * scene.size});
  return scene;
}

// Returns a scene with one short step of a brush on a fine shape; it reaches about 9000 vertices of any number.
BenchScene small_brush(std::size_t vertices) {
  constexpr std::size_t kTouched = 9000;
  BenchScene scene =
      scene_of("knot " + std::to_string(vertices), "brush", make_shape(ShapeKind::knot, vertices).positions);
  const Vec3d c = scene.points[scene.points.size() / 3];
  std::vector<double> distances;
  for (const Vec3d& p : scene.points) distances.push_back(norm(p - c));
  std::nth_element(distances.begin(), distances.begin() + kTouched, distances.end());
  const double outer = distances[kTouched];
  scene.flow = flow_of(ImplicitStroke{{c, c + Vec3d{0.03, 0.03, 0.03} * outer}, 0.16 * outer, outer});
  return scene;
}

}  // namespace

BenchScene paper_scene(const std::string& name, std::vector<Vec3d> points) {
  BenchScene scene = scene_of(name, "ball", std::move(points));
  const Vec3d c = bounding_box(scene.points).center();
  scene.flow = flow_of(ImplicitStroke{path_of(c, 0.25 * scene.size), 0.071 * scene.size, 0.965 * scene.size});
  return scene;
}

BenchScene grid_scene(const std::string& name, std::vector<Vec3d> points) {
  constexpr int kGrids = 10;
  constexpr int kMargin = 3;  // nodes
  BenchScene scene = scene_of(name, "grid", std::move(points));
  const Box box = bounding_box(scene.points);
  PotentialGrid grid;
  grid.spacing = 0.05 * scene.size;
  grid.origin = box.min - Vec3d{1, 1, 1} * (kMargin * grid.spacing);
  const Vec3d extent = box.max - box.min;
  const auto nodes = [&](double length) { return static_cast<int>(length / grid.spacing) + 2 * kMargin + 1; };
  grid.counts = {nodes(extent.x), nodes(extent.y), nodes(extent.z)};
  const double wave = 2 * std::numbers::pi / scene.size;
  const double height = 0.1 * scene.size / kGrids / wave;
  std::vector<Vec3d> coefficients;
  for (int k = 0; k < grid.counts[2]; ++k) {
    for (int j = 0; j < grid.counts[1]; ++j) {
      for (int i = 0; i < grid.counts[0]; ++i) {
        coefficients.push_back(Vec3d{std::sin(wave * grid.spacing * j), std::sin(wave * grid.spacing * k),
                                     std::sin(wave * grid.spacing * i)} *
                               height);
      }
    }
  }
  grid.coefficients = SharedVectors(std::move(coefficients));
  Segment segment;
  segment.grid = std::move(grid);
  scene.flow.segments.assign(kGrids, segment);
  return scene;
}

BenchScene paper_knot(std::size_t vertices) {
  return paper_scene("knot " + std::to_string(vertices), make_shape(ShapeKind::knot, vertices).positions);
}

std::vector<BenchScene> scenes_of_all_tools(const std::string& name, const std::vector<Vec3d>& points) {
  std::vector<BenchScene> scenes{paper_scene(name, points), brush_scene(name, points)};
  for (BenchScene& scene : tool_scenes(name, points)) scenes.push_back(std::move(scene));
  return scenes;
}

std::vector<Vec3d> standard_points(const std::string& folder, std::string& name) {
  return points_of(std::filesystem::path(folder) / "armadillo_173k_constructed.ply", 172'974, name);
}

std::vector<BenchScene> standard_scenes(const std::string& folder) {
  const std::filesystem::path path(folder);
  const std::vector<std::pair<std::string, std::size_t>> shapes{{"bust_nefertiti_35k.ply", 30'696},
                                                                {"hand_53k_open.ply", 36'619},
                                                                {"armadillo_173k_constructed.ply", 172'974},
                                                                {"dragon_438k_constructed.ply", 437'645}};
  std::vector<BenchScene> scenes;
  for (const auto& [file, vertices] : shapes) {
    std::string name;
    std::vector<Vec3d> points = points_of(path / file, vertices, name);
    scenes.push_back(paper_scene(name, std::move(points)));
  }
  BenchScene accurate = scenes[1];
  accurate.precision = Precision::float64;
  accurate.tolerance = 1e-9;
  BenchScene threaded = scenes[2];
  threaded.threads = hardware_threads();
  BenchScene brush = brush_scene(scenes[3].name, scenes[3].points);
  scenes.push_back(std::move(accurate));
  scenes.push_back(std::move(threaded));
  scenes.push_back(std::move(brush));
  for (const std::size_t vertices : {40'000, 4'000'000}) scenes.push_back(small_brush(vertices));
  std::vector<BenchScene> tools = tool_scenes(scenes[1].name, scenes[1].points);
  for (BenchScene& scene : tools) scenes.push_back(std::move(scene));
  return scenes;
}

AdvectOptions advect_options(const BenchScene& scene) {
  AdvectOptions options;
  options.tolerance = scene.tolerance * scene.size;
  options.precision = scene.precision;
  options.threads = scene.threads;
  return options;
}

// A run that is cancelled at once copies the groups that it would move.
PointBlocks blocks_of(const BenchScene& scene) {
  PointBlocks blocks(scene.points);
  Progress progress;
  progress.cancel = true;
  AdvectOptions options = advect_options(scene);
  options.progress = &progress;
  advect(scene.flow, blocks, scene.points, options);
  return blocks;
}

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
  constexpr double kMaxSeconds = 2;
  constexpr double kMinSeconds = 0.05;
  constexpr std::size_t kMaxRuns = 25;
  std::vector<double> times;
  double sum = 0;
  do {
    prepare();
    const Clock clock;
    run();
    times.push_back(clock.seconds());
    sum += times.back();
  } while (sum < kMaxSeconds && (times.size() < 3 || (sum < kMinSeconds && times.size() < kMaxRuns)));
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
