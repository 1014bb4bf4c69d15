// Moving points and replaying a session: what the faces, the report and the copies of a replay cost.
//   deform_bench                 a local pull on a ball of 438,000 vertices; medians of nine runs in turn
//   deform_bench SHAPE SESSION   for bench/python_bench.py: reads the name of a job from each line of standard input
//   and
//                                prints its milliseconds, and those of processor time
// The job `advect` moves the points in place by the session's flow, as Python's knead.deform does; `replay` applies the
// session to the mesh.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "knead/io/shape_file.h"
#include "knead/mesh/shapes.h"
#include "knead/session/replay.h"

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

void compare() {
  Session session;
  ImplicitStroke pull;
  pull.path = {{0, 1, 0}, {0, 1.3, 0}};
  pull.inner = 0.07;
  pull.outer = 0.4;
  session.strokes = {{pull}};
  Jobs jobs(make_shape(ShapeKind::sphere, 438'000), std::move(session));
  std::vector<double> advected;
  std::vector<double> replayed;
  for (int round = 0; round < 9; ++round) {
    advected.push_back(jobs.advect().milliseconds);
    replayed.push_back(jobs.replay().milliseconds);
  }
  fmt::print("a local pull on 438,000 vertices: advect {:.1f} ms, replay {:.1f} ms\n", median(advected),
             median(replayed));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) {
    answer_lines({read_shape(argv[1]).mesh, read_session(argv[2])});
  } else {
    compare();
  }
  return 0;
}
