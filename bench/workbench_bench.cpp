// A drag on a large shape, as Studio does it: what one batch of the pointer costs, without and with a mask.
//   workbench_bench [MESH]   by default a ball of 438,000 vertices
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <numbers>
#include <vector>

#include "knead/editor/workbench.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace {

using namespace knead;

constexpr int kBatches = 60;  // one second of a drag

double milliseconds_since(std::chrono::steady_clock::time_point began) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
}

struct Figures {
  double median = 0;
  double most = 0;
};

Figures figures(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values[values.size() / 2], values.back()};
}

// The half of the vertices beyond the middle of the drag, with a border of 0.05 diagonals.
MaskStroke half(const Mesh& mesh) {
  const Box box = bounding_box(mesh.positions);
  MaskStroke stroke;
  stroke.width = 0.05 * box.diagonal();
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.positions[v].x >= box.center().x) stroke.vertices.push_back({v, v});
  }
  return stroke;
}

// What it costs to make that mask.
void mask(const ShapeFile& shape) {
  Workbench bench(shape.mesh);
  const auto began = std::chrono::steady_clock::now();
  bench.set_live({{half(shape.mesh)}});
  const double made = milliseconds_since(began);
  fmt::print("{:22} made in {:.2f} ms\n", "a mask of one half", made);
}

// A second of a drag by 0.2 diagonals.
struct Drag {
  const char* name;
  double inner = 0;  // thresholds, in diagonals
  double outer = 0;
  Vec3d start{};                      // from the middle of the box, in diagonals
  std::vector<RigidMotion> images{};  // about the middle of the box: of every piece, after it
  bool masked = false;                // one half of the shape
};

std::vector<SessionStroke> strokes_of(const Drag& drag, const ImplicitStroke& stroke) {
  if (drag.images.empty()) return {{stroke}};
  std::vector<SessionStroke> strokes;
  for (std::size_t i = 0; i + 1 < stroke.path.size(); ++i) {
    ImplicitStroke piece = stroke;
    piece.path = {stroke.path[i], stroke.path[i + 1]};
    strokes.push_back({piece});
    for (const RigidMotion& image : drag.images) strokes.push_back({transformed(piece, image)});
  }
  return strokes;
}

// Where the pointer has gone in a part of the drag.
Vec3d dragged(double t, double diagonal) { return Vec3d{0.2 * t, 0.06 * t * t, 0.03 * t} * diagonal; }

// Prints what the batches of a drag cost; `strokes` gives the gesture at each of them.
template <class Strokes>
void measure(const char* name, Workbench& bench, const ShapeFile& shape, const Strokes& strokes) {
  bench.prepare();
  const auto folder = std::filesystem::temp_directory_path() / "knead_workbench_bench";
  Journal journal = Journal::create(folder, shape, "bench");
  std::vector<double> batches;
  std::vector<double> lines;
  for (int i = 0; i < kBatches; ++i) {
    const std::vector<SessionStroke> gesture = strokes(static_cast<double>(i + 1) / kBatches);
    const auto began = std::chrono::steady_clock::now();
    const WorkResult result = bench.set_live(gesture);
    batches.push_back(milliseconds_since(began));
    const auto writing = std::chrono::steady_clock::now();
    journal.replace(result.lines.undone, result.lines.appended);
    lines.push_back(milliseconds_since(writing));
  }
  const auto finishing = std::chrono::steady_clock::now();
  bench.finish();
  const double finished = milliseconds_since(finishing);
  const auto undoing = std::chrono::steady_clock::now();
  bench.undo();
  const double undone = milliseconds_since(undoing);
  journal.discard();
  std::filesystem::remove_all(folder);
  const Figures batch = figures(batches);
  const Figures line = figures(lines);
  fmt::print(
      "{:22} batch median {:6.2f} ms, most {:6.2f}; journal median {:.4f} ms, most {:.4f}; finish {:.2f}, undo "
      "{:.2f}\n",
      name, batch.median, batch.most, line.median, line.most, finished, undone);
}

void run(const Drag& drag, const ShapeFile& shape) {
  const Box box = bounding_box(shape.mesh.positions);
  const double diagonal = box.diagonal();
  const Vec3d start = box.center() + drag.start * diagonal;
  Workbench bench(shape.mesh);
  if (drag.masked) {
    bench.set_live({{half(shape.mesh)}});
    bench.finish();
  }
  ImplicitStroke stroke{{start}, drag.inner * diagonal, drag.outer * diagonal};
  measure(drag.name, bench, shape, [&](double t) {
    stroke.path.push_back(start + dragged(t, diagonal));
    return strokes_of(drag, stroke);
  });
}

// One of 20 pins that are spread over the shape goes, with the automatic radius; the others hold.
void run_pins(const ShapeFile& shape) {
  constexpr std::size_t kPins = 20;
  const std::vector<Vec3d>& positions = shape.mesh.positions;
  PinsStroke stroke;
  stroke.radius_auto = true;
  std::vector<double> distances(positions.size(), std::numeric_limits<double>::infinity());
  while (stroke.points.size() < kPins) {
    const auto farthest = std::max_element(distances.begin(), distances.end()) - distances.begin();
    stroke.points.push_back(positions[static_cast<std::size_t>(farthest)]);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      distances[i] = std::min(distances[i], norm(positions[i] - stroke.points.back()));
    }
  }
  stroke.to = stroke.points;
  const double diagonal = bounding_box(positions).diagonal();
  Workbench bench(shape.mesh);
  measure("one of 20 pins", bench, shape, [&](double t) {
    stroke.to.back() = stroke.points.back() + dragged(t, diagonal);
    return std::vector<SessionStroke>{{stroke}};
  });
}

// The images in three mirrors.
std::vector<RigidMotion> mirrors(const Vec3d& center) {
  std::vector<RigidMotion> images;
  for (unsigned mask = 1; mask < 8; ++mask) {
    RigidMotion image;
    for (unsigned axis = 0; axis < 3; ++axis) {
      Vec3d normal{0, 0, 0};
      normal[axis] = 1;
      if ((mask >> axis & 1U) != 0) image = image * reflection_in(center, normal);
    }
    images.push_back(image);
  }
  return images;
}

std::vector<RigidMotion> turns(const Vec3d& center, int count) {
  std::vector<RigidMotion> images;
  for (int k = 1; k < count; ++k) {
    images.push_back(rotation_about(center, {0, 1, 0}, 2 * std::numbers::pi * k / count));
  }
  return images;
}

}  // namespace

int main(int argc, char** argv) {
  const ShapeFile shape =
      argc > 1 ? read_shape(argv[1])
               : parse_shape(serialize_mesh("ply", make_shape(ShapeKind::sphere, 438'000)), "ply", "ball");
  fmt::print("{} vertices\n", shape.mesh.vertex_count());
  const Vec3d center = bounding_box(shape.mesh.positions).center();
  const Vec3d beside{0.15, 0.1, 0.1};
  run({"whole shape between", 0.02, 1.2}, shape);
  run({"a third of the shape", 0.05, 0.35}, shape);
  run({"a brush", 0.02, 0.08}, shape);
  run({"Studio's first ball", 0.042, 0.12, beside}, shape);
  run({"the same, mirror x3", 0.042, 0.12, beside, mirrors(center)}, shape);
  run({"the same, radial 8", 0.042, 0.12, beside, turns(center, 8)}, shape);
  run_pins(shape);
  mask(shape);
  run({.name = "whole shape, masked", .inner = 0.02, .outer = 1.2, .masked = true}, shape);
  run({.name = "a third, masked", .inner = 0.05, .outer = 0.35, .masked = true}, shape);
  run({.name = "a brush, masked", .inner = 0.02, .outer = 0.08, .masked = true}, shape);
}
