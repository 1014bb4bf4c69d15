// Large point sets. First their region field: evaluated by the short lists that hold within a block of space (the
// flow's own), against brute force over all points; float, one core. Then flows as stamping makes them: 400 short
// segments about 300 contacts over a unit sphere. Processor time, medians of several repetitions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "knead/field/packed_set.h"
#include "knead/flow/advect.h"
#include "knead/flow/point_tree.h"
#include "knead/mesh/shapes.h"

namespace {

using namespace knead;

double seconds_of(clockid_t clock, const std::function<void()>& work) {
  const auto now = [clock] {
    timespec time{};
    ::clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double begin = now();
  work();
  return now() - begin;
}

double median_seconds(const std::function<void()>& work, int repetitions) {
  std::vector<double> times(static_cast<std::size_t>(repetitions));
  for (double& time : times) time = seconds_of(CLOCK_PROCESS_CPUTIME_ID, work);
  std::nth_element(times.begin(), times.begin() + repetitions / 2, times.end());
  return times[static_cast<std::size_t>(repetitions / 2)];
}

Vec3d random_in_cube(std::mt19937& engine) {
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const double x = coordinate(engine);
  const double y = coordinate(engine);
  return {x, y, coordinate(engine)};
}

struct Scene {
  std::string name;
  PointSet<double> set;
  double outer = 0;   // blocks are about places with r < outer
  double radius = 0;  // of a block
};

// A block of space, the list that holds there, and some places in it.
struct Block {
  PackedSet<float> list;
  PackedSet<double> list_in_double;
  std::vector<Vec3d> places;
};

template <class S>
PackedSet<S> packed_list(const std::vector<detail::WeightedPoint>& list, int exponent) {
  PointPacks<S> points;
  for (const detail::WeightedPoint& p : list) points.push_back(Vec3<S>(p.p), static_cast<S>(p.weight));
  return {std::make_shared<const PointPacks<S>>(std::move(points)), std::make_shared<const Curves<S>>(), exponent};
}

detail::ListDemand demand_at(const Scene& scene, const PackedSet<double>& whole, const Vec3d& center) {
  // The bound of r^-m; errors of r and of grad r come out below 1e-4.
  constexpr double kErrorOfSum = 8e-4;
  const double nearest = std::sqrt(least_squared_distance(whole, center));
  const RegionValue<double> r = evaluate(whole, center, 0.0);
  return {center, scene.radius,       r.value,    r.gradient, nearest, r.value * (1 + scene.radius / nearest),
          true,   scene.set.exponent, kErrorOfSum};
}

std::vector<detail::ListDemand> random_blocks(const Scene& scene, const PackedSet<double>& whole) {
  constexpr std::size_t kBlocks = 100;
  std::mt19937 engine(1);
  std::vector<detail::ListDemand> blocks;
  while (blocks.size() < kBlocks) {
    const detail::ListDemand demand = demand_at(scene, whole, random_in_cube(engine) * 1.4);
    if (demand.r < scene.outer) blocks.push_back(demand);
  }
  return blocks;
}

void compare(const Scene& scene) {
  constexpr int kPlaces = 64;
  const PackedSet<double> whole = packed<double>(scene.set);
  const PackedSet<float> whole_in_float = packed<float>(scene.set);
  const detail::PointTree tree(scene.set.points);
  const std::vector<detail::ListDemand> demands = random_blocks(scene, whole);
  std::mt19937 engine(2);
  std::vector<Block> blocks;
  std::size_t length = 0;
  for (const detail::ListDemand& demand : demands) {
    std::vector<detail::WeightedPoint> list;
    tree.list(demand, list);
    length += list.size();
    const int m = scene.set.exponent;
    blocks.push_back({packed_list<float>(list, m), packed_list<double>(list, m), {}});
    for (int i = 0; i < kPlaces; ++i) {
      blocks.back().places.push_back(demand.center + random_in_cube(engine) * (scene.radius / std::sqrt(3.0)));
    }
  }
  double error_of_r = 0;
  double error_of_gradient = 0;
  float sink = 0;
  for (const Block& block : blocks) {
    for (const Vec3d& d : block.places) {
      const RegionValue<double> exact = evaluate(whole, d, 0.0);
      const RegionValue<double> found = evaluate(block.list_in_double, d, 0.0);
      error_of_r = std::max(error_of_r, std::abs(found.value / exact.value - 1));
      error_of_gradient = std::max(error_of_gradient, norm(found.gradient - exact.gradient));
    }
  }
  const auto ns = [&](const std::function<void()>& work) {
    return median_seconds(work, 7) * 1e9 / static_cast<double>(blocks.size() * kPlaces);
  };
  const double by_list = ns([&] {
    for (const Block& block : blocks) {
      for (const Vec3d& d : block.places) sink += evaluate(block.list, Vec3f(d), 0.0F).value;
    }
  });
  const double brute = ns([&] {
    for (const Block& block : blocks) {
      for (const Vec3d& d : block.places) sink += evaluate(whole_in_float, Vec3f(d), 0.0F).value;
    }
  });
  const double to_list = median_seconds(
      [&] {
        std::vector<detail::WeightedPoint> list;
        for (const detail::ListDemand& demand : demands) tree.list(demand, list);
      },
      7);
  const double count = static_cast<double>(blocks.size());
  fmt::print("| {} | {} | {:.0f} | {:.0f} | {:.0f} | {:.1f} | {:.1e} | {:.1e} | {:.0f} |\n", scene.name,
             scene.set.exponent, static_cast<double>(length) / count, brute, by_list, brute / by_list, error_of_r,
             error_of_gradient, to_list * 1e6 / count);
  if (!std::isfinite(sink)) fmt::print("not finite\n");
  std::fflush(stdout);
}

PointSet<double> in_cube(int count) {
  std::mt19937 engine(3);
  PointSet<double> set;
  for (int i = 0; i < count; ++i) set.points.push_back(random_in_cube(engine));
  return set;
}

PointSet<double> on_sphere(int count) {
  PointSet<double> set;
  set.points = make_shape(ShapeKind::sphere, count).positions;
  return set;
}

// Contacts on a square patch at the sphere's top, pressed in by `segments` steps.
Flow stamping_flow(int contacts, int segments) {
  constexpr double kStep = 0.0005;
  const int side = static_cast<int>(std::lround(std::sqrt(contacts)));
  const int rows = (contacts + side - 1) / side;
  PointSet<double> set;
  set.exponent = 16;
  for (int i = 0; i < contacts; ++i) {
    const int row = i / side;
    const double x = 0.8 * ((i - row * side + 0.5) / side - 0.5);
    const double y = 0.8 * ((row + 0.5) / rows - 0.5);
    set.points.push_back({x, y, 0});
  }
  Flow flow;
  for (int i = 0; i < segments; ++i) {
    Segment segment;
    segment.displacement = {0, 0, -kStep};
    segment.fields = {
        {{0, 0, 0.98 - i * kStep}, Translation<double>{segment.displacement}, set, Thresholds<double>{0, 0.8}}};
    flow.segments.push_back(std::move(segment));
  }
  return flow;
}

void stamp(int contacts, int threads) {
  constexpr int kSegments = 400;
  const Flow flow = stamping_flow(contacts, kSegments);
  std::vector<Vec3d> points = make_shape(ShapeKind::sphere, 100'000).positions;
  AdvectOptions options;
  options.tolerance = 1e-5 * 2 * std::sqrt(3.0);  // 1e-5 of the box diagonal, the command's default
  options.threads = threads;
  AdvectResult result;
  double processor = 0;
  const double wall = seconds_of(CLOCK_MONOTONIC, [&] {
    processor = seconds_of(CLOCK_PROCESS_CPUTIME_ID, [&] { result = advect(flow, points, options); });
  });
  fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.1f} |\n", contacts, threads, wall, processor,
             static_cast<double>(result.accepted_steps) * 1e-6);
  std::fflush(stdout);
}

}  // namespace

int main() {
  fmt::print(
      "Region field of 10,000 points\n\n| points | m | list | brute force, ns | list, ns | ratio | error of r | of "
      "grad r | making a list, us |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  compare({"in a cube, outer 1 spacing", in_cube(10'000), 0.1, 0.01});
  compare({"on a sphere, outer 3 spacings", on_sphere(10'000), 0.1, 0.01});
  compare({"on a sphere, outer 8 spacings", on_sphere(10'000), 0.3, 0.02});
  fmt::print(
      "\n400 segments over a sphere of 100k vertices\n\n| contacts | threads | s | processor s | M vertex-steps |\n"
      "| ---: | ---: | ---: | ---: | ---: |\n");
  for (const int contacts : {100, 300, 1000}) stamp(contacts, 1);
  stamp(300, 2);
}
