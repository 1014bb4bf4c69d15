// A long session: what a stroke costs after many others.
//   long_session_bench [STROKES [THREADS]]   by default 32,000 strokes, with 1 thread, 2 and all of them
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "knead/editor/workbench.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace {

using namespace knead;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kVertices = 16'384;
constexpr int kParts = 4;

double seconds_since(Clock::time_point began) { return std::chrono::duration<double>(Clock::now() - began).count(); }

// Small strokes all over a sphere of radius 1.
SessionStroke stroke_number(std::size_t i) {
  const double a = 2.399963 * static_cast<double>(i);  // the golden angle
  const double z = 1 - 2 * std::fmod(0.6180339887 * static_cast<double>(i), 1);
  const double r = std::sqrt(1 - z * z);
  const Vec3d p{r * std::cos(a), r * std::sin(a), z};
  return {ImplicitStroke{{p, p * 1.002}, 0.02, 0.1}};
}

// The seconds of each part of the work; each should take as long as the first.
void print(const char* what, std::size_t threads, const std::vector<double>& seconds) {
  fmt::print("{:28} {:2} threads:", what, threads);
  for (const double part : seconds) fmt::print(" {:7.3f} s", part);
  fmt::print("   last / first {:.2f}\n", seconds.back() / seconds.front());
}

void replay_parts(const Mesh& mesh, std::size_t strokes, int threads) {
  std::vector<double> seconds;
  for (int part = 1; part <= kParts; ++part) {
    Session session;
    for (std::size_t i = 0; i < strokes / kParts; ++i) session.strokes.push_back(stroke_number(i));
    ReplayOptions options;
    options.motion.threads = threads;
    const auto began = Clock::now();
    replay(mesh, session, options);
    seconds.push_back(seconds_since(began));
  }
  print("replay", static_cast<std::size_t>(threads), seconds);
}

// Drags of ten batches, as Studio makes them.
void drags(const Mesh& mesh, std::size_t batches, int threads) {
  constexpr std::size_t kBatches = 10;
  Workbench bench(mesh, {}, {}, threads);
  std::vector<double> seconds;
  for (int part = 0; part < kParts; ++part) {
    const auto began = Clock::now();
    for (std::size_t i = 0; i < batches / kParts / kBatches; ++i) {
      SessionStroke stroke = stroke_number(i);
      auto& path = std::get<ImplicitStroke>(stroke.stroke).path;
      for (std::size_t k = 0; k < kBatches; ++k) {
        if (k > 0) path.push_back(path.back() * 1.0002);
        bench.set_live({stroke});
      }
      bench.finish();
    }
    seconds.push_back(seconds_since(began));
  }
  print("drags of ten batches", static_cast<std::size_t>(threads), seconds);
  const auto undoing = Clock::now();
  std::size_t undone = 0;
  for (; undone < 100 && bench.can_undo(); ++undone) bench.undo();
  fmt::print("{:28} {:7.3f} ms each; kept: {} states, {} MB\n", "the last hundred undone",
             1000 * seconds_since(undoing) / static_cast<double>(undone), bench.undo_memory().states,
             bench.undo_memory().bytes / 1'000'000);
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t strokes = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 32'000;
  std::vector<int> threads{1, 2};
  if (hardware_threads() > 2) threads.push_back(hardware_threads());
  if (argc > 2) threads = {std::atoi(argv[2])};
  const Mesh mesh = make_shape(ShapeKind::sphere, kVertices);
  fmt::print("{} strokes on {} vertices, in {} parts\n", strokes, mesh.vertex_count(), kParts);
  for (const int count : threads) {
    replay_parts(mesh, strokes, count);
    drags(mesh, strokes, count);
  }
}
