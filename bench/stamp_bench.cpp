// What stamping does, in figures: a row for each scene, the convergence over the step, and the time of 100 steps.
// Usage: stamp_bench [FOLDER]; the folder holds the meshes of the scenes that need one, which are left out without it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/io/shape_file.h"
#include "knead/mesh/measures.h"
#include "knead/mesh/normals.h"
#include "knead/mesh/polygonise.h"
#include "knead/mesh/self_intersections.h"
#include "knead/mesh/shapes.h"
#include "knead/mesh/surface_tree.h"
#include "knead/tool/stamp.h"

namespace {

using namespace knead;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Scene {
  std::string name;
  Mesh shape;
  Mesh tool;
  StampStroke stroke;
};

struct Outcome {
  StampResult result;
  std::vector<Vec3d> positions;
  std::size_t segments = 0;
  double seconds = 0;
  double advect_seconds = 0;
  double processor_seconds = 0;  // of all threads
};

Outcome run(const Scene& scene) {
  Outcome outcome;
  outcome.positions = scene.shape.positions;
  const std::vector<Triangle> triangles = triangulate(scene.shape);
  AdvectOptions options;
  options.tolerance = 1e-5 * bounding_box(outcome.positions).diagonal();
  LiveSurface surface;
  surface.positions = outcome.positions;
  surface.triangles = triangles;
  surface.apply = [&](const Stroke& stroke) {
    const double begin = seconds_now();
    const Flow flow = flow_of(stroke);
    advect(flow, outcome.positions, options);
    outcome.segments += flow.segments.size();
    outcome.advect_seconds += seconds_now() - begin;
    return true;
  };
  const double begin = seconds_now();
  const std::clock_t processor_begin = std::clock();
  outcome.result = stamp(scene.stroke, scene.tool, surface);
  outcome.processor_seconds = static_cast<double>(std::clock() - processor_begin) / CLOCKS_PER_SEC;
  outcome.seconds = seconds_now() - begin;
  return outcome;
}

// Of the tool's vertices that look along the last motion (to 25 degrees) and have come to lie inside the old shape, the
// distances from the new surface, sorted.
std::vector<double> gaps(const Scene& scene, const Outcome& outcome) {
  const std::vector<Triangle> triangles = triangulate(scene.shape);
  const SurfaceTree before(triangles, scene.shape.positions);
  const SurfaceTree after(triangles, outcome.positions);
  const std::vector<Vec3d>& path = scene.stroke.path;
  const Vec3d direction = normalized(path.back() - path[path.size() - 2]);
  Mesh tool = scene.tool;
  for (Vec3d& p : tool.positions) p = scene.stroke.pose * p + path.back();
  const std::vector<Vec3d> normals = vertex_normals(tool);
  std::vector<double> distances;
  for (std::size_t i = 0; i < tool.positions.size(); ++i) {
    if (dot(normals[i], direction) < 0.9) continue;
    const auto way_out = before.first_hit(tool.positions[i], -direction);
    if (way_out && way_out->leaves) distances.push_back(after.closest(tool.positions[i])->distance);
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double x : values) sum += x;
  return values.empty() ? std::nan("") : sum / static_cast<double>(values.size());
}

double largest_stretch(const Scene& scene, const Outcome& outcome) {
  double largest = 0;
  for (const Triangle& t : triangulate(scene.shape)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto length = [&](const std::vector<Vec3d>& p) { return norm(p[t[k]] - p[t[(k + 1) % 3]]); };
      if (length(scene.shape.positions) > 0) {
        largest = std::max(largest, length(outcome.positions) / length(scene.shape.positions));
      }
    }
  }
  return largest;
}

// The edges whose two triangles meet at more than 40 degrees, and of these the ones that still do at more than 20.
struct Creases {
  std::size_t before = 0;
  std::size_t kept = 0;
};

Creases count_creases(const Scene& scene, const Outcome& outcome) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Triangle>> triangles_at;
  for (const Triangle& t : triangulate(scene.shape)) {
    for (std::size_t k = 0; k < 3; ++k) triangles_at[std::minmax(t[k], t[(k + 1) % 3])].push_back(t);
  }
  const auto cosine = [](const std::vector<Triangle>& pair, const std::vector<Vec3d>& p) {
    const auto normal = [&](const Triangle& t) { return normalized(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])); };
    return dot(normal(pair[0]), normal(pair[1]));
  };
  Creases creases;
  for (const auto& [edge, pair] : triangles_at) {
    if (pair.size() != 2 || cosine(pair, scene.shape.positions) > std::cos(40 * 0.0174533)) continue;
    ++creases.before;
    if (cosine(pair, outcome.positions) < std::cos(20 * 0.0174533)) ++creases.kept;
  }
  return creases;
}

void print_head() {
  fmt::print(
      "| scene | step | segments | gap mean | gap 95% | penetration | of the diagonal | volume | crossings | stretch "
      "| creases kept | s | s in advect |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
}

void print_row(const Scene& scene) {
  const Outcome outcome = run(scene);
  const std::vector<double> distances = gaps(scene, outcome);
  const double diagonal = bounding_box(scene.shape.positions).diagonal();
  const double volume = measure_volume_and_area(scene.shape, outcome.positions).volume /
                            measure_volume_and_area(scene.shape, scene.shape.positions).volume -
                        1;
  const Creases creases = count_creases(scene, outcome);
  fmt::print(
      "| {} | {:.4g} | {} | {:.4f} | {:.4f} | {:.4f} | {:.2f}% | {:.1e} | {} | {:.1f} | {} of {} | {:.2f} | {:.2f} |\n",
      scene.name, outcome.result.step, outcome.segments, mean(distances),
      distances.empty() ? std::nan("") : distances[distances.size() * 95 / 100], outcome.result.penetration,
      100 * outcome.result.penetration / diagonal, volume,
      self_intersections(triangulate(scene.shape), outcome.positions).count, largest_stretch(scene, outcome),
      creases.kept, creases.before, outcome.seconds, outcome.advect_seconds);
  for (const std::string& warning : outcome.result.warnings) fmt::print("|  | {} |\n", warning);
  std::fflush(stdout);
}

// The letter O, or with a bar across: half extent 0.38, thickness 0.2, strokes 0.16 wide.
Mesh letter_o(bool with_bar) {
  const auto solid = [with_bar](const Vec3d& p) {
    double outline = std::abs(std::sqrt(p.x * p.x + p.y * p.y) - 0.3) - 0.06;
    if (with_bar) outline = std::min(outline, std::max(std::abs(p.y) - 0.06, std::abs(p.x) - 0.3));
    const double height = std::abs(p.z) - 0.08;
    const double out = std::max(outline, 0.0);
    const double up = std::max(height, 0.0);
    return std::min(std::max(outline, height), 0.0) + std::sqrt(out * out + up * up) - 0.02;
  };
  return polygonise(solid, {{-0.5, -0.5, -0.2}, {0.5, 0.5, 0.2}}, {.cell = 0.012, .lipschitz = 1});
}

Scene onto_sphere(const std::string& name, Mesh tool, std::vector<Vec3d> path) {
  Scene scene{name, make_shape(ShapeKind::sphere, 64000), std::move(tool), {}};
  scene.stroke.path = std::move(path);
  scene.stroke.outer = 0.6;
  return scene;
}

Mesh letter_y() { return make_shape(ShapeKind::letter_y, 10000); }

Scene pressed_letter() { return onto_sphere("letter Y, 0.2 deep", letter_y(), {{0, 0, 1.12}, {0, 0, 0.9}}); }

Scene pressed_ball() {
  Scene scene = onto_sphere("ball of 0.4, 0.2 deep", make_shape(ShapeKind::sphere, 10000), {{0, 0, 1.42}, {0, 0, 1.2}});
  scene.stroke.pose = {{0.4, 0, 0}, {0, 0.4, 0}, {0, 0, 0.4}};
  return scene;
}

std::vector<Scene> made_scenes() {
  return {pressed_letter(),
          pressed_ball(),
          onto_sphere("letter O", letter_o(false), {{0, 0, 1.12}, {0, 0, 0.9}}),
          onto_sphere("letter O with a bar", letter_o(true), {{0, 0, 1.12}, {0, 0, 0.9}}),
          onto_sphere("Y, 45 degrees oblique", letter_y(), {{-0.22, 0, 1.12}, {0, 0, 0.9}}),
          onto_sphere("Y, from the side", letter_y(), {{1.5, 0, 0.6}, {0.9, 0, 0.6}}),
          onto_sphere("Y, 0.2 deep and out obliquely", letter_y(), {{0, 0, 1.12}, {0, 0, 0.9}, {0.3, 0, 1.2}}),
          onto_sphere("Y, 0.15 deep and 0.1 aside", letter_y(), {{0, 0, 1.12}, {0, 0, 0.95}, {0.1, 0, 0.95}}),
          onto_sphere("Y, 0.15 deep and 0.3 aside", letter_y(), {{0, 0, 1.12}, {0, 0, 0.95}, {0.3, 0, 0.95}})};
}

Scene with_files(const std::string& name, Mesh shape, Mesh tool, const Mat3d& pose, std::vector<Vec3d> path) {
  Scene scene{name, std::move(shape), std::move(tool), {}};
  scene.stroke.pose = pose;
  scene.stroke.path = std::move(path);
  return scene;
}

std::vector<Scene> scenes_of(const std::filesystem::path& folder) {
  const auto read = [&](const char* name) { return read_shape(folder / name).mesh; };
  Mesh crater = make_shape(ShapeKind::crater, 100000);
  for (Vec3d& p : crater.positions) p = p * 5.0;
  return {with_files("hand into the fan disc", read("fandisk_6k.ply"), make_shape(ShapeKind::hand, 10000),
                     {{-2, 0, 0}, {0, 2, 0}, {0, 0, -2}}, {{2.9, 15.4, 0.7}, {2.9, 15.4, 0.05}}),
          with_files("armadillo into the crater", crater, read("armadillo_43k.ply"),
                     {{10, 0, 0}, {0, -10, 0}, {0, 0, -10}}, {{12.5, 12.5, 8}, {12.5, 12.5, 2.25}}),
          with_files("armadillo into the mountain", read("mountain_26k_open.ply"), read("armadillo_43k.ply"),
                     {{10, 0, 0}, {0, 0, -10}, {0, 10, 0}}, {{9, 23, 6}, {9, 15.8, 6}})};
}

// 100 steps of a tool of 20,000 triangles on a shape of 100,000 vertices: a median of three.
void print_time(const std::string& name, Scene scene) {
  scene.shape = make_shape(ShapeKind::sphere, 100000);
  std::vector<Outcome> outcomes;
  for (int i = 0; i < 3; ++i) outcomes.push_back(run(scene));
  std::sort(outcomes.begin(), outcomes.end(), [](const Outcome& a, const Outcome& b) { return a.seconds < b.seconds; });
  const Outcome& median = outcomes[1];
  fmt::print(
      "{}: {} triangles, {} vertices, {} steps, {} segments: {:.2f} s, of it contacts {:.2f} s; {:.2f} s of processor "
      "time\n",
      name, scene.tool.face_count(), scene.shape.vertex_count(), median.result.steps, median.segments, median.seconds,
      median.seconds - median.advect_seconds, median.processor_seconds);
}

void print_times() {
  for (Scene scene : {pressed_letter(), pressed_ball()}) {
    const std::string name = scene.name + ", in 100 steps";
    scene.stroke.step = 0.2201 / 100;
    print_time(name, std::move(scene));
  }
}

}  // namespace

int main(int argc, char** argv) {
  print_head();
  for (const Scene& scene : made_scenes()) print_row(scene);
  if (argc > 1) {
    for (const Scene& scene : scenes_of(argv[1])) print_row(scene);
  }
  fmt::print("\nOver the step:\n\n");
  print_head();
  for (Scene scene : {pressed_letter(), pressed_ball()}) {
    for (const double step : {0.048, 0.024, 0.012, 0.006}) {
      scene.stroke.step = step;
      print_row(scene);
    }
  }
  fmt::print("\n");
  print_times();
}
