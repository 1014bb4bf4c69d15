// What the crash journal costs while a person drags: a batch at every pointer sample.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <vector>

#include "knead/mesh/shapes.h"
#include "knead/session/journal.h"

namespace {

using namespace knead;

Journal new_journal(const std::filesystem::path& root) {
  ShapeFile shape;
  shape.mesh = make_shape(ShapeKind::sphere, 1000);
  return Journal::create(root, shape, "bench");
}

ImplicitStroke drag(std::size_t pieces) {
  ImplicitStroke stroke;
  stroke.path = {{0.1234567891234, 0.3, 1.0 / 3}};
  for (std::size_t i = 0; i < pieces; ++i) {
    stroke.path.push_back(stroke.path.back() + Vec3d{0.0123456789, 0.1 / 7, 1e-3 / 3});
  }
  stroke.inner = 0.1;
  stroke.outer = 0.3;
  return stroke;
}

// A drag of one batch a sample, each its own piece of the path; synced at the end of every 100.
void append_piece(benchmark::State& state) {
  const std::filesystem::path root = std::filesystem::temp_directory_path() / "knead_journal_bench";
  Journal journal = new_journal(root);
  const std::vector<SessionStroke> piece{{drag(1)}};
  std::size_t batches = 0;
  for (auto iteration : state) {
    journal.append(piece);
    if (++batches % 100 == 0) journal.sync();
  }
  journal.discard();
}
BENCHMARK(append_piece)->Unit(benchmark::kMicrosecond);

// A drag that changes its one stroke, of so many pieces by now.
void replace_drag(benchmark::State& state) {
  const std::filesystem::path root = std::filesystem::temp_directory_path() / "knead_journal_bench";
  Journal journal = new_journal(root);
  const std::vector<SessionStroke> stroke{{drag(static_cast<std::size_t>(state.range(0)))}};
  journal.append(stroke);
  for (auto iteration : state) journal.replace(1, stroke);
  journal.discard();
}
BENCHMARK(replace_drag)->Arg(1)->Arg(10)->Arg(100)->Unit(benchmark::kMicrosecond);

}  // namespace
