// Moving points, replaying a session, and its frames: what the faces, the report, the copies and the files cost.
//   deform_bench [SHAPE]         a local pull on a shape, or on a ball of 438,000 vertices; medians of nine runs
//   deform_bench SHAPE SESSION   for bench/python_bench.py: reads names of jobs from standard input, a line each
// With a session it prints the milliseconds of each job, and those of processor time. The job `advect` moves the points
// in place by the session's flow, as Python's knead.deform does; `replay` applies the session to the mesh.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"

namespace {

using namespace knead;

struct Times {
  double milliseconds = 0;
  double of_processor = 0;
};

template <class Job>
Times timed(const Job& job) {
  const auto began = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  job();
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - began;
  return {spent.count(), 1000.0 * static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC};
}

class Jobs {
 public:
  Jobs(Mesh mesh, Session session)
      : mesh_(std::make_shared<const Mesh>(std::move(mesh))), session_(std::move(session)) {}

  Times advect() {
    points_ = mesh_->positions;
    return timed([&] { knead::advect(flow_of(session_), points_, advect_options({}, reference_length(points_))); });
  }
  Times replay() {
    return timed([&] { knead::replay(mesh_, session_, {}); });
  }

 private:
  std::shared_ptr<const Mesh> mesh_;
  Session session_;
  std::vector<Vec3d> points_;
};

void answer_lines(Jobs jobs) {
  for (std::string name; std::getline(std::cin, name);) {
    const Times times = name == "replay" ? jobs.replay() : jobs.advect();
    fmt::print("{} {}\n", times.milliseconds, times.of_processor);
    std::fflush(stdout);
  }
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// The pull of python_bench.py.
Session local_pull(const Mesh& mesh) {
  const double diagonal = bounding_box(mesh.positions).diagonal();
  const Vec3d tip = *std::max_element(mesh.positions.begin(), mesh.positions.end(),
                                      [](const Vec3d& a, const Vec3d& b) { return a.y < b.y; });
  ImplicitStroke pull{{tip, tip + Vec3d{0, 0.08 * diagonal, 0}}, 0.02 * diagonal, 0.12 * diagonal};
  Session session;
  session.strokes = {{std::move(pull)}};
  return session;
}

void compare(const ShapeFile& shape) {
  const Session session = local_pull(shape.mesh);
  Jobs jobs(shape.mesh, session);
  const std::filesystem::path path = std::filesystem::temp_directory_path() / fmt::format("knead_{}.pc2", ::getpid());
  const std::string bytes(32 + 24 * shape.mesh.vertex_count() * 3 * sizeof(float), 'x');
  std::vector<double> advected;
  std::vector<double> replayed;
  std::vector<double> framed;
  std::vector<double> animated;
  std::vector<double> written;
  const auto frames = [&](const std::function<void(const ReplayFrame&)>& deliver) {
    ReplayOptions options;
    options.frames.count = 24;
    options.frames.deliver = deliver;
    knead::replay(borrow(shape.mesh), session, options);
  };
  for (int round = 0; round < 9; ++round) {
    advected.push_back(jobs.advect().milliseconds);
    replayed.push_back(jobs.replay().milliseconds);
    framed.push_back(timed([&] { frames([](const ReplayFrame&) {}); }).milliseconds);
    animated.push_back(timed([&] { frames(animation_writer(path, shape, false, {24, 24})); }).milliseconds);
    written.push_back(timed([&] { write_file_atomically(path, bytes); }).milliseconds);
  }
  std::filesystem::remove(path);
  fmt::print(
      "a local pull on {} vertices: advect {:.1f} ms, replay {:.1f} ms, 24 frames {:.1f} ms, as PC2 {:.1f} ms; writing "
      "so many bytes {:.1f} ms\n",
      shape.mesh.vertex_count(), median(advected), median(replayed), median(framed), median(animated), median(written));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) {
    answer_lines({read_shape(argv[1]).mesh, read_session(argv[2])});
  } else {
    compare(argc == 2 ? read_shape(argv[1])
                      : parse_shape(serialize_mesh("ply", make_shape(ShapeKind::sphere, 438'000)), "ply", "ball"));
  }
  return 0;
}
