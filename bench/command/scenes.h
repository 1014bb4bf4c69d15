// The scenes that `knead bench` measures, and the functions that all its parts use to measure.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "knead/flow.h"

namespace knead::command {

struct BenchScene {
  std::string name;  // of the shape
  std::string tool;
  Precision precision = Precision::float32;
  double tolerance = 1e-5;  // of the box diagonal
  int threads = 1;
  std::vector<Vec3d> points;
  double size = 1;  // the box diagonal
  Flow flow;
};

// Returns the paper's benchmark (its section 6): a ball that contains all vertices and pulls by up to a quarter of the
// box diagonal in 20 segments.
BenchScene paper_scene(const std::string& name, std::vector<Vec3d> points);

// Returns the same on a procedural knot of about `vertices` vertices. Throws InvalidInput as make_shape does.
BenchScene paper_knot(std::size_t vertices);

// Returns ten segments of a grid of potentials, as poses have them, that moves all points by a tenth of the box
// diagonal.
BenchScene grid_scene(const std::string& name, std::vector<Vec3d> points);

// Returns scenes on one shape: the paper's benchmark, a local brush, and one stroke of each other tool.
std::vector<BenchScene> scenes_of_all_tools(const std::string& name, const std::vector<Vec3d>& points);

// Returns the vertices of the third of the shapes below; sets `name` to its name.
std::vector<Vec3d> standard_points(const std::string& folder, std::string& name);

// Returns scenes on the paper's four shapes: scans of about their size from the folder, or procedural shapes of the
// same number of vertices if there are none. Some shapes also get scenes with double precision, all threads, a local
// brush, and each other tool.
std::vector<BenchScene> standard_scenes(const std::string& folder);

// Returns how the scene's flow is to be computed, by all methods that are compared.
AdvectOptions advect_options(const BenchScene& scene);

// Returns the scene's points in blocks that are ready, as after a first stroke at the same place.
PointBlocks blocks_of(const BenchScene& scene);

// Of the vertices that errors are measured at.
inline constexpr std::size_t kErrorVertices = 1000;

// Returns about `count` of the points, evenly chosen; all if there are fewer.
std::vector<Vec3d> sample_of(const std::vector<Vec3d>& points, std::size_t count);

// Returns the median of three runs; of up to 25 if they take less than 0.05 s in all, of fewer if they take over 2 s.
double median_seconds(const std::function<void()>& run);

// Does the same, and calls `prepare` before each run; its time does not count.
double median_seconds(const std::function<void()>& prepare, const std::function<void()>& run);

// Returns the points at the flow's end, with an error of 1e-12 of `size` for each path line and segment.
std::vector<Vec3d> exact_positions(const Flow& flow, std::vector<Vec3d> points, double size);

// Returns the greatest distance between a[i] and b[i].
double greatest_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b);

}  // namespace knead::command
