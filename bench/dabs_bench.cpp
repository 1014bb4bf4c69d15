// Painting beside a drag of the ball with the same reach: what a dab costs on a small shape and on a large one.
//   dabs_bench [VERTICES...]   by default spheres of 16,000 and 500,000 vertices
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/mesh.h"
#include "knead/replay.h"

namespace {

using namespace knead;

constexpr double kReach = 0.07;  // of a sphere of radius 1
constexpr double kArc = 0.93;    // of the path, an angle: 106 dabs
constexpr int kPoints = 51;      // of the painted path
constexpr int kSegments = 100;   // of the ball
constexpr int kRuns = 9;

std::vector<Vec3d> arc(int points, double angle) {
  std::vector<Vec3d> path;
  for (int i = 0; i < points; ++i) {
    const double a = 0.3 + angle * i / (points - 1);
    path.push_back({std::cos(a), std::sin(a), 0.1});
  }
  return path;
}

double milliseconds_of(const Mesh& mesh, const Stroke& stroke) {
  Session session;
  session.strokes = {{stroke}};
  const auto began = std::chrono::steady_clock::now();
  replay(mesh, session, {});
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void compare(std::size_t vertices) {
  const Mesh mesh = make_shape(ShapeKind::sphere, vertices);
  PaintStroke painted;
  painted.outer = kReach;
  painted.depth = 0.1 * kReach;
  painted.path = arc(kPoints, kArc);
  PaintStroke first = painted;  // of the same stroke: what it takes to begin, with the tree of the surface
  first.path = arc(2, 1e-6);
  const ImplicitStroke dragged{arc(kSegments + 1, kArc), 0.1 * kReach, kReach};
  const std::size_t dabs = paint_dabs(painted).aims.size();
  std::vector<double> paint;
  std::vector<double> begin;
  std::vector<double> drag;
  std::vector<double> ratio;
  for (int i = 0; i < kRuns; ++i) {
    paint.push_back(milliseconds_of(mesh, painted));
    begin.push_back(milliseconds_of(mesh, first));
    drag.push_back(milliseconds_of(mesh, dragged));
    const double dab = (paint.back() - begin.back()) / static_cast<double>(dabs - 1);
    ratio.push_back(dab / (drag.back() / kSegments));
  }
  fmt::print("{:>8} {:>6} {:>10.1f} {:>10.1f} {:>14.1f} {:>18.2f}\n", mesh.vertex_count(), dabs, median(paint),
             median(begin), median(drag), median(ratio));
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::size_t> sizes{16'000, 500'000};
  if (argc > 1) sizes.clear();
  for (int i = 1; i < argc; ++i) sizes.push_back(std::strtoull(argv[i], nullptr, 10));
  fmt::print("{:>8} {:>6} {:>10} {:>10} {:>14} {:>18}\n", "vertices", "dabs", "paint, ms", "one dab, ms", "ball, ms",
             "further dab/segment");
  for (const std::size_t vertices : sizes) compare(vertices);
}
