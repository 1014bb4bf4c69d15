// A drag on a large shape, as Studio does it: what one batch of the pointer costs.
//   workbench_bench [MESH]   by default a ball of 438,000 vertices
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "knead/io/shape_file.h"
#include "knead/mesh/shapes.h"
#include "knead/session/journal.h"
#include "knead/session/workbench.h"

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

// A second of a drag by 0.2 diagonals with a ball of these thresholds, in diagonals.
void drag(const char* name, const ShapeFile& shape, double inner, double outer) {
  const Box box = bounding_box(shape.mesh.positions);
  const double diagonal = box.diagonal();
  Workbench bench(shape.mesh);
  bench.prepare();
  const auto folder = std::filesystem::temp_directory_path() / "knead_workbench_bench";
  Journal journal = Journal::create(folder, shape, "bench");
  ImplicitStroke stroke{{box.center()}, inner * diagonal, outer * diagonal};
  std::vector<double> batches;
  std::vector<double> lines;
  for (int i = 0; i < kBatches; ++i) {
    const double t = static_cast<double>(i + 1) / kBatches;
    stroke.path.push_back(box.center() + Vec3d{0.2 * t, 0.06 * t * t, 0.03 * t} * diagonal);
    const auto began = std::chrono::steady_clock::now();
    const WorkResult result = bench.set_live({{stroke}});
    batches.push_back(milliseconds_since(began));
    const auto writing = std::chrono::steady_clock::now();
    journal.replace(result.lines.taken_back, result.lines.appended);
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

}  // namespace

int main(int argc, char** argv) {
  const ShapeFile shape =
      argc > 1 ? read_shape(argv[1])
               : parse_shape(serialize_mesh("ply", make_shape(ShapeKind::sphere, 438'000)), "ply", "ball");
  fmt::print("{} vertices\n", shape.mesh.vertex_count());
  drag("whole shape between", shape, 0.02, 1.2);
  drag("a third of the shape", shape, 0.05, 0.35);
  drag("a brush", shape, 0.02, 0.08);
}
