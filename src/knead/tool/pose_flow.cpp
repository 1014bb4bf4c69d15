#include "knead/tool/pose.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "knead/math/box.h"
#include "knead/mesh/body_points.h"
#include "knead/mesh/surface_tree.h"
#include "knead/tool/strain.h"

namespace knead::tool_detail {

namespace {

using namespace detail;

constexpr double kCellsOfSample = 0.6;      // the samples' greatest spacing, in that of the grid
constexpr double kSurfaceStiffness = 20;    // of samples on the surface, which is what is seen
constexpr std::size_t kPointsOfPart = 300;  // that ask for its motion; more where these lie farther apart than
constexpr double kCellsOfPart = 0.5;        // this, in the spacing of the grid
constexpr std::size_t kMaxPointsOfPart = 3000;
constexpr std::size_t kCheckedOfPart = 2000;  // points whose places are looked at
constexpr std::size_t kLookedAt = 400;        // points at which the flow's stretch is measured

std::vector<Vec3d> chosen(const std::vector<Vec3d>& points, const std::vector<std::uint32_t>& numbers) {
  std::vector<Vec3d> result;
  result.reserve(numbers.size());
  for (const std::uint32_t i : numbers) result.push_back(points[i]);
  return result;
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
  std::vector<Vec3d> points;
  for (const std::uint32_t i : spread_points(surface.positions, kLookedAt)) points.push_back(surface.positions[i]);
  double sum = 0;
  for (const Stretches& s : stretches_of(flow, points, {.length = diagonal, .threads = threads})) {
    result.greatest_stretch = std::max(result.greatest_stretch, s.greatest);
    result.least_stretch = std::min(result.least_stretch, s.least);
    for (const double value : {s.greatest, s.middle, s.least}) sum += std::log(value) * std::log(value);
  }
  result.rms_log_stretch = std::sqrt(sum / static_cast<double>(3 * points.size()));
}

bool apply_grids(const Flow& flow, const LiveSurface& surface) {
  return std::all_of(flow.segments.begin(), flow.segments.end(),
                     [&](const Segment& segment) { return surface.apply(GridStroke{segment.grid}); });
}

}  // namespace knead::tool_detail
