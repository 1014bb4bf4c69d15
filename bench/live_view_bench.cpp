// The interactive picture: what moving vertices costs, and drawing. Medians; the picture is 1280 x 800.
//   live_view_bench [MESH]   of a file instead of a sphere of 438,000 vertices
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <vector>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace {

using namespace knead;
using namespace knead::render;

constexpr int kWidth = 1280;
constexpr int kHeight = 800;
constexpr int kRepetitions = 15;

double milliseconds(const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < kRepetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(times.begin(), times.begin() + kRepetitions / 2, times.end());
  return times[kRepetitions / 2];
}

void measure_moves(const Mesh& mesh, LiveView& view) {
  const auto count = static_cast<std::uint32_t>(mesh.vertex_count());
  for (const int threads : {1, 0}) {
    for (const std::uint32_t parts : {1u, 10u, 100u}) {
      const VertexRange range{count / 3, count / 3 + count / parts};
      const VertexRange touched = parts == 1 ? VertexRange{0, count} : range;
      const double time = milliseconds([&] { view.move(mesh.positions, {&touched, 1}, threads); });
      fmt::print("move {:3} % of the vertices, {} threads: {:8.3f} ms, {:9} bytes in {} ranges\n", 100 / parts,
                 threads == 0 ? hardware_threads() : threads, time, view.counts().bytes, view.counts().ranges);
    }
  }
  const std::vector<float> none(count, 0.0f);
  const std::vector<float> half(count, 0.5f);
  bool flip = false;
  fmt::print("influence of all vertices:              {:8.3f} ms\n",
             milliseconds([&] { view.set_influence((flip = !flip) ? half : none); }));
}

Mesh ball_at(const Vec3d& center, double radius) {
  Mesh ball = make_shape(ShapeKind::sphere, 1002);
  for (Vec3d& p : ball.positions) p = center + p * radius;
  return ball;
}

// A picture is made, and read back so that it is finished; the reading is also measured, by an empty view.
void measure_drawing(const Mesh& mesh, int samples) {
  LiveView view(samples);
  LiveScene scene;
  const Box box = bounding_box(mesh.positions);
  scene.camera = fit_camera(box, {-0.4, -0.3, -1}, {0, 1, 0}, static_cast<double>(kWidth) / kHeight);
  const auto report = [&](const char* what) {
    fmt::print("draw, {} samples, {:22} {:8.2f} ms\n", samples, what,
               milliseconds([&] { view.picture(scene, kWidth, kHeight); }));
  };
  report("nothing");
  fmt::print("set the shape                           {:8.1f} ms\n", milliseconds([&] { view.set_shape(mesh); }));
  report("clay");
  scene.material = Material::matcap;
  report("matcap");
  scene.material = Material::flat;
  report("flat");
  scene.material = Material::matcap;
  scene.clip = Clip{{0, 0, 1}, box.center().z, {}};
  report("matcap, cut");
  scene.clip.reset();
  const double size = box.diagonal();
  scene.surfaces = {{ball_at(box.center(), 0.25 * size), kInnerRed}, {ball_at(box.center(), 0.4 * size), kOuterGreen}};
  report("matcap, two balls");
  scene.surfaces.clear();
  scene.wireframe = true;
  report("matcap, wireframe");
}

}  // namespace

int main(int argc, char** argv) {
  const Mesh mesh = argc > 1 ? read_shape(argv[1]).mesh : make_shape(ShapeKind::sphere, 438'000);
  const gl::OffscreenContext context;
  fmt::print("{}; {} vertices, {} x {}\n", context.description(), mesh.vertex_count(), kWidth, kHeight);
  {
    LiveView view;
    view.set_shape(mesh);
    measure_moves(mesh, view);
  }
  for (const int samples : {1, 4}) measure_drawing(mesh, samples);
}
