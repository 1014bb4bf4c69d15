// The tool "pose" as grids, one for each step of its motion.
#include "strokes/pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/elementary.h"
#include "mesh/body_points.h"
#include "pose/sound_steps.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

constexpr double kMaxStretch = 6;  // of a triangle
constexpr double kMinDetail = 0.025;
constexpr std::size_t kUsualUnknowns = 4500;  // at most, for a pose without a detail
constexpr double kThinDetail = 0.02;          // the least that the thickness of the parts gives,
constexpr double kThickDetail = 0.075;        // the most,
constexpr double kDetailOfThickness = 0.25;   // and the fraction of the thickness
constexpr double kCoarserDetail = 1.5;        // factor of a second detail, if the pose falls short with the first
constexpr double kSamePlace = 1e-6;           // of the diagonal
constexpr double kSpacingOfGap = 1.25;        // at most: a wider spacing cannot separate moving from holding parts

std::vector<Vec3d> all_points_of(const PosePart& part, std::span<const Vec3d> positions) {
  std::vector<Vec3d> all = part.points;
  for (const VertexRange& range : part.vertices) {
    require_vertex("vertices", positions, range.last);
    all.insert(all.end(), positions.begin() + range.first, positions.begin() + range.last + 1);
  }
  return all;
}

PosedPart posed(const PosePart& part, std::span<const Vec3d> positions, double spacing) {
  PosedPart result = part_of(all_points_of(part, positions), spacing);
  if (part.rotation) {
    result.axis = detail::unit(part.rotation->axis);
    result.center = part.rotation->center;
    result.angle = part.rotation->angle_deg * detail::kRadiansPerDegree;
  }
  if (part.translation) result.translation = *part.translation;
  return result;
}

PosedPin posed(const PosePin& pin, std::span<const Vec3d> positions, double diagonal) {
  if (pin.vertex) require_vertex("pin", positions, *pin.vertex);
  PosedPin result;
  result.path = {pin.vertex ? positions[*pin.vertex] : *pin.point};
  result.size = pin.size * diagonal;
  for (const Vec3d& place : pin.path) {
    if (result.path.size() > 1 || norm(place - result.path.front()) > kSamePlace * diagonal)
      result.path.push_back(place);
  }
  if (pin.turns_freely) return result;
  result.turn = Vec3d{0, 0, 0};
  if (pin.rotation) {
    result.turn = detail::unit(pin.rotation->axis) * (pin.rotation->angle_deg * detail::kRadiansPerDegree);
  }
  return result;
}

// Two pins in each other's patch move together, or tear the shape.
void require_apart(const std::vector<PosedPin>& pins) {
  for (std::size_t i = 0; i < pins.size(); ++i) {
    for (std::size_t j = i + 1; j < pins.size(); ++j) {
      const Vec3d apart = pins[i].path.front() - pins[j].path.front();
      const Vec3d motion = (pins[i].path.back() - pins[j].path.back()) - apart;
      if (norm(apart) < 0.5 * (pins[i].size + pins[j].size) && norm(motion) > norm(apart)) {
        throw InvalidInput(
            fmt::format("\"parts\": two pins are {:.3g} apart and go different ways, by {:.3g}; remove one, move them "
                        "together, or give smaller \"size\"s",
                        norm(apart), norm(motion)));
      }
    }
  }
}

// Gives each sample the stiffness of the nearest vertex.
void stiffen(const PoseStroke& stroke, std::span<const Vec3d> positions, BodySamples& body) {
  if (stroke.stiffness.empty()) return;
  std::vector<double> of_vertex(positions.size(), 1.0);
  for (const PoseStiffness& region : stroke.stiffness) {
    for (const VertexRange& range : region.vertices) {
      require_vertex("vertices", positions, range.last);
      std::fill(of_vertex.begin() + range.first, of_vertex.begin() + range.last + 1, region.value);
    }
  }
  const std::vector<std::uint32_t> nearest = nearest_of(positions, body.points);
  for (std::size_t i = 0; i < nearest.size(); ++i) body.stiffness[i] *= of_vertex[nearest[i]];
}

// Returns the distance of a moving part from a holding one; infinite if there are no such parts.
double least_gap(const PoseStroke& stroke, std::span<const Vec3d> positions) {
  std::vector<Vec3d> held;
  std::vector<Vec3d> moved;
  for (const PoseItem& item : stroke.parts) {
    const auto* const part = std::get_if<PosePart>(&item);
    if (part == nullptr) continue;
    const std::vector<Vec3d> all = all_points_of(*part, positions);
    std::vector<Vec3d>& to = part->hold ? held : moved;
    to.insert(to.end(), all.begin(), all.end());
  }
  if (held.empty() || moved.empty()) return kInfinity;
  const std::vector<std::uint32_t> nearest = nearest_of(held, moved);
  double least = kInfinity;
  for (std::size_t i = 0; i < moved.size(); ++i) least = std::min(least, norm(held[nearest[i]] - moved[i]));
  return least;
}

// Marks the samples that rest: those whose nearest vertex belongs to a holding part.
void mark_held(const PoseStroke& stroke, std::span<const Vec3d> positions, BodySamples& body) {
  std::vector<bool> holds(positions.size(), false);
  for (const PoseItem& item : stroke.parts) {
    const auto* const part = std::get_if<PosePart>(&item);
    if (part == nullptr || !part->hold) continue;
    for (const VertexRange& range : part->vertices) {
      std::fill(holds.begin() + range.first, holds.begin() + range.last + 1, true);
    }
  }
  if (std::find(holds.begin(), holds.end(), true) == holds.end()) return;
  for (const std::uint32_t vertex : nearest_of(positions, body.points)) body.held.push_back(holds[vertex]);
}

// Refuses places far from the shape, which are mistakes.
void require_near(const Vec3d& p, const LiveSurface& surface, double diagonal) {
  constexpr double kFar = 10;  // diagonals
  const Vec3d& there = surface.positions[surface.triangles.empty() ? 0 : surface.triangles.front()[0]];
  if (norm(p - there) <= kFar * diagonal) return;
  throw InvalidInput(
      fmt::format("\"parts\": the place [{}, {}, {}] is far from the shape; was the session made for "
                  "another shape?",
                  p.x, p.y, p.z));
}

// Returns the points of a moving part, or the vertices around a moving pin; none for a part or pin that holds.
std::vector<Vec3d> moving_points(const PoseItem& item, std::span<const Vec3d> positions, double diagonal) {
  if (const auto* part = std::get_if<PosePart>(&item)) {
    return part->hold ? std::vector<Vec3d>{} : all_points_of(*part, positions);
  }
  constexpr double kSizes = 2;  // of the pin
  const auto& pin = std::get<PosePin>(item);
  std::vector<Vec3d> result;
  if (pin.hold) return result;
  if (pin.vertex) require_vertex("pin", positions, *pin.vertex);
  const Vec3d& place = pin.vertex ? positions[*pin.vertex] : *pin.point;
  std::copy_if(positions.begin(), positions.end(), std::back_inserter(result),
               [&](const Vec3d& p) { return norm(p - place) <= kSizes * pin.size * diagonal; });
  return result;
}

// Returns the median length inside the body, along the normals, at points of its surface; infinite if there is none.
double thickness_at(const std::vector<Vec3d>& points, const LiveSurface& surface, const SurfaceTree& tree,
                    double diagonal) {
  constexpr std::size_t kRays = 200;
  constexpr double kBelow = 1e-6;  // of the diagonal: where a ray starts
  std::vector<double> lengths;
  for (const std::uint32_t i : spread_points(points, kRays)) {
    const SurfacePoint near = *tree.closest(points[i]);
    const Triangle& t = surface.triangles[near.triangle];
    const Vec3d& a = surface.positions[t[0]];
    const Vec3d normal = cross(surface.positions[t[1]] - a, surface.positions[t[2]] - a);
    if (!(norm(normal) > 0)) continue;
    const Vec3d inward = -normalized(normal);
    const std::optional<RayHit> hit = tree.first_hit(near.point + inward * (kBelow * diagonal), inward);
    if (hit && hit->leaves) lengths.push_back(hit->t);
  }
  if (lengths.empty()) return kInfinity;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

// Probes of the space about points of a cloud: small triangles, which the flow deforms as it does the space.
LiveSurface with_probes(const LiveSurface& cloud, double diagonal, std::vector<Vec3d>& places,
                        std::vector<Triangle>& triangles) {
  constexpr std::size_t kProbes = 400;
  constexpr double kSize = 1e-3;  // of the diagonal
  for (const std::uint32_t i : spread_points(cloud.positions, kProbes)) {
    const auto first = static_cast<std::uint32_t>(places.size());
    const Vec3d& p = cloud.positions[i];
    const double size = kSize * diagonal;
    for (const Vec3d& by : {Vec3d{0, 0, 0}, Vec3d{size, 0, 0}, Vec3d{0, size, 0}, Vec3d{0, 0, size}}) {
      places.push_back(p + by);
    }
    for (std::uint32_t k = 0; k < 3; ++k) triangles.push_back({first, first + 1 + k, first + 1 + (k + 1) % 3});
  }
  LiveSurface surface;
  surface.positions = places;
  surface.triangles = triangles;
  return surface;
}

// Returns a sentence on how the pose missed its targets; empty if it reached them.
std::string shortfall_of(const PoseOutcome& outcome, double distance, double tolerance) {
  if (outcome.reached < 1) {
    return fmt::format(
        "the pose came {:.0f}% of its way: beyond that {}; let what is beside the parts move along, or "
        "move them less",
        std::floor(100 * outcome.reached), outcome.problem);
  }
  if (distance <= tolerance) return {};
  return fmt::format(
      "a part or pin ends {:.2g} of the shape's size from its place, more than the tolerance of {:g}; let "
      "what is beside it move along, or move it less",
      distance, tolerance);
}

struct SolvedPose {
  Flow flow;
  PoseOutcome outcome;
  std::vector<std::string> warnings;
};

SolvedPose solve_pose(const PoseStroke& stroke, const LiveSurface& surface, int threads) {
  SolvedPose solved;
  PoseProblem problem = problem_of(stroke, surface, kSamplesInside, kMinDetail, threads, solved.warnings);
  const double diagonal = problem.diagonal;
  std::vector<Vec3d> places;
  std::vector<Triangle> probes;
  const LiveSurface& judged = surface.triangles.empty() ? with_probes(surface, diagonal, places, probes) : surface;
  AdvectOptions motion;
  motion.tolerance = absolute_tolerance(kDefaultRelativeTolerance, diagonal);
  motion.threads = threads;
  motion.progress = surface.progress;
  SoundSurface sound(judged.positions, judged.triangles, kMaxStretch, motion);
  problem.judge = [&](const PotentialGrid& grid) { return sound.take(grid); };
  solved.outcome = find_flow(std::move(problem), solved.flow);
  return solved;
}

// Poses without a detail: if the automatic detail falls short, tries a coarser one, and keeps the better result.
SolvedPose solve_as_far_as_possible(const PoseStroke& stroke, const LiveSurface& surface, int threads) {
  SolvedPose solved = solve_pose(stroke, surface, threads);
  if (solved.outcome.reached >= 1 || stroke.detail > 0) return solved;
  PoseStroke coarser = stroke;
  coarser.detail = std::min(kThickDetail, kCoarserDetail * usual_detail(stroke, surface));
  try {
    SolvedPose other = solve_pose(coarser, surface, threads);
    if (other.outcome.reached > solved.outcome.reached) return other;
  } catch (const InvalidInput&) {  // its equations cannot be solved
  }
  return solved;
}

constexpr double kCellsOfSample = 0.4;      // the samples' greatest spacing, in that of the grid
constexpr double kSurfaceStiffness = 20;    // of samples on the surface, which is visible
constexpr std::size_t kPointsOfPart = 300;  // points with a wanted velocity; more if these lie farther apart than
constexpr double kCellsOfPart = 0.5;        // this, in the spacing of the grid
constexpr std::size_t kMaxPointsOfPart = 20000;
constexpr std::size_t kCheckedOfPart = 2000;  // points whose distances from their targets are measured
constexpr std::size_t kLookedAt = 400;        // points at which the flow's stretch is measured
constexpr double kStretchTolerance = 1e-5;    // of path lines for this, of the diagonal

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

double detail::usual_detail(const PoseStroke& stroke, const LiveSurface& surface) {
  if (surface.triangles.empty()) return kThickDetail;
  const double diagonal = diagonal_of(surface);
  const SurfaceTree tree(surface.triangles, surface.positions);
  double thickness = kInfinity;
  for (const PoseItem& item : stroke.parts) {
    thickness =
        std::min(thickness, thickness_at(moving_points(item, surface.positions, diagonal), surface, tree, diagonal));
  }
  return std::clamp(kDetailOfThickness * thickness / diagonal, kThinDetail, kThickDetail);
}

PoseProblem detail::problem_of(const PoseStroke& stroke, const LiveSurface& surface, std::size_t inside,
                               double least_detail, int threads, std::vector<std::string>& warnings) {
  PoseProblem problem;
  problem.threads = threads;
  problem.progress = surface.progress;
  if (surface.positions.empty()) throw InvalidInput("\"parts\": the shape has no vertices that could be posed");
  problem.diagonal = diagonal_of(surface);
  if (!(problem.diagonal > 0)) throw InvalidInput("\"parts\": the shape has no extent, so that nothing can be posed");
  const double detail = stroke.detail > 0 ? stroke.detail : usual_detail(stroke, surface);
  problem.most_spacing = (stroke.detail > 0 ? detail : kThickDetail) * problem.diagonal;
  if (!(stroke.detail > 0)) problem.max_unknowns = kUsualUnknowns;
  problem.tolerance = stroke.tolerance * problem.diagonal;
  problem.spacing = std::min(detail * problem.diagonal, std::max(least_detail * problem.diagonal,
                                                                 kSpacingOfGap * least_gap(stroke, surface.positions)));
  for (const PoseItem& item : stroke.parts) {
    if (const auto* part = std::get_if<PosePart>(&item)) {
      problem.parts.push_back(posed(*part, surface.positions, problem.spacing));
    } else {
      problem.pins.push_back(posed(std::get<PosePin>(item), surface.positions, problem.diagonal));
    }
  }
  for (const PosedPart& part : problem.parts) {
    for (const Vec3d& p : part.points) require_near(p, surface, problem.diagonal);
  }
  for (const PosedPin& pin : problem.pins) require_near(pin.path.front(), surface, problem.diagonal);
  require_apart(problem.pins);
  problem.body = body_of(surface, problem.spacing, inside, threads, warnings);
  stiffen(stroke, surface.positions, problem.body);
  mark_held(stroke, surface.positions, problem.body);
  return problem;
}

void require_vertex(std::string_view key, std::span<const Vec3d> positions, std::uint32_t vertex) {
  if (vertex < positions.size()) return;
  throw InvalidInput(
      fmt::format("\"{}\" names vertex {}, but the shape has {}, numbered from 0; was the session "
                  "made for another shape?",
                  key, vertex, positions.size()));
}

PoseResult pose_on(const PoseStroke& stroke, const LiveSurface& surface, int threads) {
  validate(stroke);
  SolvedPose solved = solve_as_far_as_possible(stroke, surface, threads);
  const Flow& flow = solved.flow;
  const PoseOutcome& outcome = solved.outcome;
  const double diagonal = diagonal_of(surface);
  PoseResult result;
  result.warnings = std::move(solved.warnings);
  result.part_distance = outcome.part_distance / diagonal;
  result.unknowns = outcome.unknowns;
  result.segments = outcome.segments;
  measure_stretch(flow, surface, diagonal, threads, result);
  result.reached = outcome.reached;
  result.shortfall = shortfall_of(outcome, result.part_distance, stroke.tolerance);
  result.stopped = !apply_grids(flow, surface);
  if (result.stopped) return result;
  if (stroke.exact && outcome.part_distance > 0) {
    PinsStroke last;
    last.points = outcome.reached_points;
    last.to = outcome.places;
    last.radius_auto = true;
    result.stopped = !surface.apply(last);
    result.part_distance = 0;
  }
  return result;
}

}  // namespace knead

namespace knead::detail {

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

}  // namespace knead::detail
