#include "knead/tool/pose.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "knead/flow/advect.h"
#include "knead/math/box.h"
#include "knead/math/elementary.h"
#include "knead/mesh/body_points.h"
#include "knead/mesh/surface_tree.h"
#include "knead/tool/strain.h"

namespace knead::tool_detail {

namespace {

using namespace detail;

constexpr double kCellsOfSample = 0.4;      // the samples' greatest spacing, in that of the grid
constexpr double kSurfaceStiffness = 20;    // of samples on the surface, which is what is seen
constexpr std::size_t kPointsOfPart = 300;  // that ask for its motion; more where these lie farther apart than
constexpr double kCellsOfPart = 0.5;        // this, in the spacing of the grid
constexpr std::size_t kMaxPointsOfPart = 20000;
constexpr std::size_t kCheckedOfPart = 2000;  // points whose places are looked at
constexpr std::size_t kLookedAt = 400;        // points at which the flow's stretch is measured,
constexpr double kStretchTolerance = 1e-5;    // with path lines so exact, of the diagonal

std::vector<Vec3d> chosen(const std::vector<Vec3d>& points, const std::vector<std::uint32_t>& numbers) {
  std::vector<Vec3d> result;
  result.reserve(numbers.size());
  for (const std::uint32_t i : numbers) result.push_back(points[i]);
  return result;
}

// Unit normals of the surface at vertices; 0 where it has none.
std::vector<Vec3d> normals_of(const std::vector<std::uint32_t>& vertices, const LiveSurface& surface) {
  std::unordered_map<std::uint32_t, std::size_t> place;
  for (std::size_t i = 0; i < vertices.size(); ++i) place.emplace(vertices[i], i);
  std::vector<Vec3d> normals(vertices.size(), Vec3d{0, 0, 0});
  for (const Triangle& t : surface.triangles) {
    for (const std::uint32_t v : t) {
      const auto found = place.find(v);
      if (found == place.end()) continue;
      const Vec3d& a = surface.positions[t[0]];
      normals[found->second] += cross(surface.positions[t[1]] - a, surface.positions[t[2]] - a);
    }
  }
  for (Vec3d& n : normals) {
    if (norm(n) > 0) n = normalized(n);
  }
  return normals;
}

// A gradient as a map of the plane that two vectors span.
Mat3d restricted(const Mat3d& gradient, const Vec3d& s, const Vec3d& t) {
  const Vec3d a = gradient * s;
  const Vec3d b = gradient * t;
  return {{a.x, b.x, 0}, {a.y, b.y, 0}, {a.z, b.z, 0}};
}

}  // namespace

double diagonal_of(const LiveSurface& surface) {
  Box box;
  for (const Triangle& t : surface.triangles) {
    for (const std::uint32_t v : t) box.extend(surface.positions[v]);
  }
  if (surface.triangles.empty()) {
    for (const Vec3d& p : surface.positions) box.extend(p);
  }
  return norm(box.max - box.min);
}

PosedPart part_of(const std::vector<Vec3d>& all, double spacing) {
  PosedPart result;
  const std::size_t apart = points_apart(all, kCellsOfPart * spacing).size();
  result.points = chosen(all, spread_points(all, std::clamp(apart, kPointsOfPart, kMaxPointsOfPart)));
  result.checked = chosen(all, spread_points(all, kCheckedOfPart));
  return result;
}

BodySamples body_of(const LiveSurface& surface, double spacing, std::size_t inside, int threads,
                    std::vector<std::string>& warnings) {
  BodyPoints body = body_points(
      surface.positions, surface.triangles,
      {.inside = inside, .most_spacing = kCellsOfSample * spacing, .shell_depth = 0.25 * spacing, .threads = threads});
  if (!body.is_closed && !surface.triangles.empty()) {
    warnings.push_back("the surface is open: a shell below it is kept rigid in place of the body's inside");
  }
  BodySamples samples{std::move(body.points)};
  samples.stiffness.assign(samples.points.size(), kSurfaceStiffness);
  std::fill_n(samples.stiffness.begin(), body.inside, 1.0);
  return samples;
}

std::vector<std::uint32_t> nearest_of(std::span<const Vec3d> positions, const std::vector<Vec3d>& points) {
  std::vector<Triangle> corners;
  corners.reserve(positions.size());
  for (std::uint32_t i = 0; i < positions.size(); ++i) corners.push_back({i, i, i});
  const SurfaceTree tree(corners, positions);
  std::vector<std::uint32_t> result;
  result.reserve(points.size());
  for (const Vec3d& p : points) result.push_back(tree.closest(p)->triangle);
  return result;
}

PoseOutcome find_flow(PoseProblem problem, Flow& flow) {
  return PoseRun(std::move(problem)).go([&](const PotentialGrid& grid) {
    Segment segment;
    segment.grid = grid;
    flow.segments.push_back(std::move(segment));
    return true;
  });
}

void measure_stretch(const Flow& flow, const LiveSurface& surface, double diagonal, int threads, PoseResult& result) {
  const std::vector<std::uint32_t> vertices = spread_points(surface.positions, kLookedAt);
  const std::vector<Vec3d> points = chosen({surface.positions.begin(), surface.positions.end()}, vertices);
  const std::vector<Vec3d> normals = normals_of(vertices, surface);
  AdvectOptions options;
  options.tolerance = kStretchTolerance * diagonal;
  options.precision = Precision::float64;
  options.threads = threads;
  const std::vector<Mat3d> gradients = jacobians(flow, points, options);
  double sum = 0;
  std::size_t count = 0;
  const auto add = [&](double value) {
    result.greatest_stretch = std::max(result.greatest_stretch, value);
    result.least_stretch = std::min(result.least_stretch, value);
    sum += elementary::log(value) * elementary::log(value);
    ++count;
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& n = normals[i];
    const bool is_surface = norm(n) > 0;
    const Vec3d t = is_surface ? any_orthogonal(n) : Vec3d{0, 0, 0};
    const Stretches s = stretches_of(is_surface ? restricted(gradients[i], t, cross(n, t)) : gradients[i]);
    add(s.greatest);
    add(s.middle);
    if (!is_surface) add(s.least);
  }
  result.rms_log_stretch = std::sqrt(sum / static_cast<double>(count));
}

bool apply_grids(const Flow& flow, const LiveSurface& surface) {
  return std::all_of(flow.segments.begin(), flow.segments.end(),
                     [&](const Segment& segment) { return surface.apply(GridStroke{segment.grid}); });
}

}  // namespace knead::tool_detail
