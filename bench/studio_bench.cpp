// A drag in Studio, from the pointer to the vertices that are drawn: moved by the CPU and sent, or moved where they are
// drawn from; the preview of its frames; and its pictures of 1280 x 800, with the tool's two balls. Medians over one
// second of a drag.
//   studio_bench [MESH]   by default a ball of 438,000 vertices
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/editor/workbench.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "view/shown_shape.h"

namespace {

using namespace knead;
using namespace knead::studio;

constexpr int kBatches = 60;

struct Scene {
  const char* name;
  double inner;  // diagonals
  double outer;
};

struct Figures {
  double median = 0;  // milliseconds
  double most = 0;
  std::size_t bytes = 0;  // sent in a batch, at most
};

std::vector<ImplicitStroke> strokes_of(const Scene& scene, const Box& box) {
  ImplicitStroke stroke{{box.center()}, scene.inner * box.diagonal(), scene.outer * box.diagonal()};
  std::vector<ImplicitStroke> result;
  for (int i = 1; i <= kBatches; ++i) {
    const double t = static_cast<double>(i) / kBatches;
    stroke.path.push_back(box.center() + Vec3d{0.2 * t, 0.06 * t * t, 0.03 * t} * box.diagonal());
    result.push_back(stroke);
  }
  return result;
}

// batch(i) does the i-th and returns the bytes that it sent.
Figures measured(const std::function<std::size_t(std::size_t)>& batch) {
  Figures figures;
  std::vector<double> times;
  for (std::size_t i = 0; i < kBatches; ++i) {
    const auto began = std::chrono::steady_clock::now();
    const std::size_t sent = batch(i);
    glFinish();
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count());
    if (i > 0) figures.bytes = std::max(figures.bytes, sent);  // the first compiles shaders
  }
  times.erase(times.begin());
  std::sort(times.begin(), times.end());
  figures.median = times[times.size() / 2];
  figures.most = times.back();
  return figures;
}

Figures by_cpu(const Mesh& mesh, const std::vector<ImplicitStroke>& strokes) {
  Workbench bench(mesh);
  bench.prepare();
  render::LiveView view(1);
  ShownShape shape;
  const double diagonal = bounding_box(mesh.positions).diagonal();
  shape.follow(bench.state(), nullptr, diagonal, view);
  return measured([&](std::size_t i) {
    bench.set_live({{strokes[i]}});
    shape.follow(bench.state(), nullptr, diagonal, view);
    return view.counts().bytes;
  });
}

Figures by_gpu(const Mesh& mesh, const std::vector<ImplicitStroke>& strokes, std::uint64_t& reads) {
  const Workbench bench(mesh);
  render::LiveView view(1);
  GpuPreview gpu;
  const double diagonal = bounding_box(mesh.positions).diagonal();
  gpu.follow(bench.state(), nullptr, diagonal, view);
  PendingStrokes pending{bench.state(), {}};
  const std::uint64_t before = gpu.transfers().read;
  const Figures figures = measured([&](std::size_t i) {
    const std::size_t sent = gpu.transfers().bytes_sent;
    pending.strokes = {{strokes[i]}};
    gpu.follow(pending.start, &pending, diagonal, view);
    return gpu.transfers().bytes_sent - sent;
  });
  reads = gpu.transfers().read - before;
  return figures;
}

// Pictures as Studio begins with them.
Figures by_pictures(const Mesh& mesh, const Scene& drag, const std::vector<ImplicitStroke>& strokes,
                    Fineness fineness) {
  constexpr int width = 1280;
  constexpr int height = 800;
  Workbench bench(mesh);
  bench.prepare();
  render::LiveView view;
  ShownShape shape;
  const Box box = bounding_box(mesh.positions);
  const double diagonal = box.diagonal();
  shape.follow(bench.state(), nullptr, diagonal, view);
  GLuint color = 0;
  glGenRenderbuffers(1, &color);
  glBindRenderbuffer(GL_RENDERBUFFER, color);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  GLuint target = 0;
  glGenFramebuffers(1, &target);
  glBindFramebuffer(GL_FRAMEBUFFER, target);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
  render::LiveScene scene;
  scene.camera = render::fit_camera(box, {-0.4, -0.3, -1}, {0, 1, 0}, static_cast<double>(width) / height);
  scene.material = render::Material::matcap;
  scene.relief.cavity = true;
  set_fineness(scene, fineness);
  const auto ball = [&](double radius, const render::Color& glass) {
    Mesh shown = make_shape(ShapeKind::sphere, 1002);
    for (Vec3d& p : shown.positions) p = box.center() + p * (radius * diagonal);
    scene.surfaces.push_back({shown, glass});
  };
  ball(drag.inner, render::kInnerRed);
  ball(drag.outer, render::kOuterGreen);
  return measured([&](std::size_t i) {
    bench.set_live({{strokes[i]}});
    shape.follow(bench.state(), nullptr, diagonal, view);
    const Vec3d step = strokes[i].path.back() - (i > 0 ? strokes[i - 1].path.back() : box.center());
    for (render::TranslucentSurface& glass : scene.surfaces) {
      for (Vec3d& p : glass.mesh.positions) p += step;
    }
    view.draw(scene, width, height);
    return view.counts().bytes;
  });
}

// The frames of the whole drag are looked at, one after the other.
Figures by_frames(const Mesh& mesh, const ImplicitStroke& stroke) {
  ReplayOptions options;
  options.frames.count = kBatches;
  std::vector<ShapeState> frames;
  options.frames.deliver = [&](const ReplayFrame& frame) {
    frames.push_back(frame.shape.state(frames.empty() ? ShapeState{} : frames.back()));
  };
  Session session;
  session.strokes = {{stroke}};
  replay(borrow(mesh), session, options);
  render::LiveView view(1);
  ShownShape shape;
  const double diagonal = bounding_box(mesh.positions).diagonal();
  return measured([&](std::size_t i) {
    shape.follow(frames[i], nullptr, diagonal, view);
    return view.counts().bytes;
  });
}

void print(const char* drag, const char* mover, const Figures& figures) {
  fmt::print("{:22} {:4}: median {:7.2f} ms, most {:7.2f}; at most {:9} bytes sent\n", drag, mover, figures.median,
             figures.most, figures.bytes);
}

}  // namespace

int main(int argc, char** argv) {
  const Mesh mesh = argc > 1 ? read_shape(argv[1]).mesh : make_shape(ShapeKind::sphere, 438'000);
  const gl::OffscreenContext context;
  fmt::print("{}; {} vertices\n", context.description(), mesh.vertex_count());
  const Scene scenes[] = {
      {"whole shape between", 0.02, 1.2}, {"a third of the shape", 0.05, 0.35}, {"a brush", 0.02, 0.08}};
  for (const Scene& scene : scenes) {
    const std::vector<ImplicitStroke> strokes = strokes_of(scene, bounding_box(mesh.positions));
    print(scene.name, "CPU", by_cpu(mesh, strokes));
    std::uint64_t reads = 0;
    print(scene.name, "GPU", by_gpu(mesh, strokes, reads));
    fmt::print("{:22}       {} times read back\n", "", reads);
    print(scene.name, "seen", by_frames(mesh, strokes.back()));
    for (const auto& [name, fineness] :
         {std::pair{"smooth", Fineness::smooth}, {"plain", Fineness::plain}, {"coarse", Fineness::coarse}}) {
      const Figures pictures = by_pictures(mesh, scene, strokes, fineness);
      fmt::print("{:22}       drawn {:6}: median {:.1f} ms, most {:.1f}\n", "", name, pictures.median, pictures.most);
    }
  }
}
