// Pins spread evenly over a sphere of radius 1: what it takes to solve their equations, and to move a sphere's
// vertices.
//   pins_bench [VERTICES]   by default 173,000
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/stroke.h"

namespace {

using namespace knead;

constexpr double kGoldenAngle = 2.399963229728653;
constexpr int kRuns = 3;

// Pins, of which all move along a smooth field by about `way`, or the first one alone does.
PinsStroke make_pins(int count, double way, bool one_moves) {
  PinsStroke stroke;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count;
    const double across = std::sqrt(1 - z * z);
    const Vec3d p{across * std::cos(i * kGoldenAngle), across * std::sin(i * kGoldenAngle), z};
    const Vec3d by{std::sin(3 * p.y), std::cos(2 * p.z), p.x * p.y};
    stroke.points.push_back(p);
    stroke.to.push_back(i == 0 || !one_moves ? p + by * way : p);
  }
  stroke.radius_auto = true;
  return stroke;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

struct Measured {
  double milliseconds = 0;
  double evaluations = 0;
};

Measured measure(const Flow& flow, const std::vector<Vec3d>& points, double tolerance) {
  AdvectOptions options;
  options.tolerance = tolerance;
  std::vector<double> times;
  Measured result;
  for (int run = 0; run < kRuns; ++run) {
    PointBlocks blocks(points);
    const auto began = std::chrono::steady_clock::now();
    result.evaluations = static_cast<double>(advect(flow, blocks, points, options).evaluations);
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count());
  }
  result.milliseconds = median(times);
  return result;
}

// Pins within the radius of a point, on average.
double pins_near(const PinsStroke& stroke, double radius, const std::vector<Vec3d>& points) {
  const std::size_t stride = points.size() / 500 + 1;
  double near = 0;
  double looked_at = 0;
  for (std::size_t i = 0; i < points.size(); i += stride, ++looked_at) {
    for (const Vec3d& pin : stroke.points) near += norm(points[i] - pin) < radius ? 1 : 0;
  }
  return near / looked_at;
}

void show(const PinsStroke& stroke, const char* what, double tolerance, const std::vector<Vec3d>& points) {
  const Flow flow = flow_of(stroke);
  const double radius = flow.segments[0].fields[0].thresholds.outer;
  const double solving = measure(flow, {{100, 0, 0}}, tolerance).milliseconds;  // a point that no pin reaches
  const Measured all = measure(flow, points, tolerance);
  const double moving = std::max(all.milliseconds - solving, 0.0);
  fmt::print("{:>5} {:>6.2f}  {:<20} {:>7.0e} {:>10.1f} {:>10.1f} {:>8.1f} {:>8.2f}\n", stroke.points.size(), radius,
             what, tolerance, solving, moving, all.evaluations / static_cast<double>(points.size()),
             moving * 1e6 / (all.evaluations * pins_near(stroke, radius, points)));
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t vertices = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 173'000;
  const std::vector<Vec3d> points = make_shape(ShapeKind::sphere, vertices).positions;
  fmt::print("a sphere of {} vertices; times in ms, medians of {}; ns: for a point, pin near and evaluation\n",
             vertices, kRuns);
  fmt::print(" pins radius  ways                 tolerance solving     moving  evals a point   ns\n");
  show(make_pins(20, 0.02, true), "one moves by 0.02", 2e-5, points);
  show(make_pins(20, 0.2, false), "all by about 0.2", 2e-5, points);
  show(make_pins(20, 0.2, false), "all by about 0.2", 2e-10, points);
  show(make_pins(200, 0.05, false), "all by about 0.05", 2e-5, points);
  show(make_pins(2000, 0.02, false), "all by about 0.02", 2e-5, points);
  show(make_pins(2000, 0.05, false), "all by about 0.05", 2e-5, points);
}
