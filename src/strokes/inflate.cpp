// The tool "inflate": clay that grows, volume on purpose (docs/decisions/0035-volume-on-purpose.md).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "strokes/describe.h"
#include "strokes/pose.h"

namespace knead {

namespace {

using namespace detail;

constexpr double kSpacingsOfRadius = 12;  // of the grid, in the radius
constexpr double kBeyondNode = 3.5;       // spacings: farther away a node moves nothing
constexpr double kLayer = 1.0 / 3;        // of the radius: the depth to either side in which the surface is pushed
constexpr double kMaxNodes = 1e6;
constexpr double kStepLength = 0.1;   // of the radius, at most
constexpr std::size_t kMinSteps = 3;  // each with the grid elsewhere, so that no pattern of its nodes is seen
constexpr std::size_t kMaxSteps = 60;
constexpr double kVolumeTolerance = 1e-6;  // of path lines, of the radius
constexpr double kMaxTaken = 0.5;          // of the volume that grows
constexpr double kMaxInflateStretch = 6;
constexpr double kMinFlux = 2;          // of the integral of rate S, divided by the square of the radius
constexpr double kExactVolume = 1e-7;   // of the volume
constexpr double kExactDepth = 1e-3;    // of the depth
constexpr double kMaxShortfall = 5e-3;  // of what is wanted
constexpr int kCorrections = 6;
constexpr std::size_t kMaxPoints = 10'000;
constexpr std::size_t kPiecesOfBox = 16;

// The space within the radius of the stroke's path.
class InflateTool {
 public:
  // The path must outlive it.
  InflateTool(const std::vector<Vec3d>& path, double radius) : radius_(radius), path_(path) {
    const Vec3d by{radius, radius, radius};
    for (std::size_t first = 0; first < path.size(); first += kPiecesOfBox) {
      Box& box = boxes_.emplace_back();
      for (std::size_t i = first; i < std::min(first + kPiecesOfBox + 1, path.size()); ++i) {
        box.extend(path[i] - by);
        box.extend(path[i] + by);
      }
    }
  }

  // Returns the distance from the path; infinity far beyond the radius.
  double distance(const Vec3d& p) const {
    double least = kInfinity;
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      if (!contains(boxes_[b], p)) continue;
      for (std::size_t i = b * kPiecesOfBox; i < std::min((b + 1) * kPiecesOfBox, path_.size()); ++i) {
        least = std::min(least, distance_to_segment(p, path_[i], path_[std::min(i + 1, path_.size() - 1)]));
      }
    }
    return least;
  }

  bool reaches(const Vec3d& p) const { return distance(p) <= radius_; }

  // Returns the rate of growth at a distance, relative to that at the path.
  double rate(double distance) const {
    const double s = distance / (radius_ * (1 - kBeyondNode / kSpacingsOfRadius));
    const double rest = std::max(0.0, 1 - s * s);
    return rest * rest;
  }

  Box box() const {
    Box all;
    for (const Box& box : boxes_) {
      all.extend(box.min);
      all.extend(box.max);
    }
    return all;
  }

 private:
  double radius_;
  const std::vector<Vec3d>& path_;
  std::vector<Box> boxes_;  // of pieces that follow each other
};

// A sum that does not depend on the order of the numbers.
double sum_of(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

// The part of the surface that the tool can move: corners of its triangles.
class MovedSurface {
 public:
  MovedSurface(std::span<const Vec3d> positions, std::span<const Triangle> triangles, const InflateTool& tool) {
    std::vector<std::uint32_t> number(positions.size());
    std::vector<bool> is_near(positions.size());
    for (std::size_t i = 0; i < is_near.size(); ++i) is_near[i] = tool.reaches(positions[i]);
    for (const Triangle& t : triangles) {
      if (std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_near[v]; })) continue;
      Triangle own = t;
      for (std::uint32_t& v : own) {
        if (number[v] == 0) {
          points.push_back(positions[v]);
          vertices.push_back(v);
          number[v] = static_cast<std::uint32_t>(points.size());
        }
        v = number[v] - 1;
      }
      triangles_.push_back(own);
    }
  }

  bool empty() const { return triangles_.empty(); }

  // Returns the growth of the volume, times the sign of the surface.
  double volume_between(const std::vector<Vec3d>& before, const std::vector<Vec3d>& after) const {
    std::vector<double> parts;
    parts.reserve(triangles_.size());
    for (const auto& [a, b, c] : triangles_) {
      parts.push_back(cone(after[a], after[b], after[c]) - cone(before[a], before[b], before[c]));
    }
    return sum_of(std::move(parts)) / 6;
  }

  // Returns the volume that flows through the surface per unit of time.
  double flux(const std::vector<Vec3d>& velocities) const {
    std::vector<double> parts;
    parts.reserve(triangles_.size());
    for (const auto& [a, b, c] : triangles_) {
      const Vec3d area = cross(points[b] - points[a], points[c] - points[a]);
      parts.push_back(dot(velocities[a] + velocities[b] + velocities[c], area));
    }
    return sum_of(std::move(parts)) / 6;
  }

  // Returns the greatest factor by which a triangle is stretched or compressed.
  double stretch_from(const std::vector<Vec3d>& before) const {
    return surface_stretch(triangles_, before, points).worst();
  }

  std::vector<Vec3d> points;
  std::vector<std::uint32_t> vertices;  // their numbers

 private:
  // Six times the volume of a triangle's cone.
  static double cone(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return dot(a, cross(b, c)); }

  std::vector<Triangle> triangles_;
};

Flow flow_of(PotentialGrid grid) {
  Segment segment;
  segment.grid = std::move(grid);
  return {{std::move(segment)}};
}

double greatest_norm(const std::vector<Vec3d>& vectors) {
  double greatest = 0;
  for (const Vec3d& v : vectors) greatest = std::max(greatest, norm(v));
  return greatest;
}

// Pushes the surface outwards: v = grad p with p = -rate S, where S falls from 1 inside to 0 outside within a layer
// about the surface. Works relative to the first point of the stroke, so that rounding does not depend on where the
// shape is.
class Inflation {
 public:
  Inflation(const InflateStroke& stroke, const LiveSurface& surface, int threads)
      : origin_(stroke.points.front()),
        stroke_(relative(stroke)),
        tool_(stroke_.points, stroke_.radius),
        surface_(surface),
        threads_(threads),
        positions_(surface.positions.begin(), surface.positions.end()),
        moved_(relative(positions_, origin_), surface.triangles, tool_),
        rest_(moved_.points) {
    if (surface.triangles.empty()) throw InvalidInput("\"tool\": only a surface can be inflated, and a cloud has none");
  }

  // Adds a segment for each step.
  void run(Flow& flow) {
    SurfaceTree tree(surface_.triangles, positions_);
    double done = 0;
    std::size_t steps = 1;
    for (std::size_t i = 0; i < steps; ++i) {
      if (i > 0) tree.refit(positions_, tool_.box());
      PotentialGrid grid = outward(tree, static_cast<double>(i) / static_cast<double>(steps));
      const std::vector<Vec3d> v = velocities(flow_of(grid), moved_.points, 0);
      const double flux = moved_.flux(v);
      require_flux(std::abs(flux), done);
      if (flux < 0) orientation_ = -1;  // the triangles look inward
      const double rate = stroke_.depth ? greatest_norm(v) : std::abs(flux);
      if (i == 0) steps = count_steps(std::abs(wanted()) / rate * greatest_norm(v));
      const double share = wanted() * static_cast<double>(i + 1) / static_cast<double>(steps) - done;
      grid = with_change(grid, done, share, share / rate);
      move(grid, moved_.points);
      for (std::size_t k = 0; k < moved_.points.size(); ++k) positions_[moved_.vertices[k]] = moved_.points[k];
      done = change_to(moved_.points);
      Segment segment;
      segment.grid = std::move(grid);
      segment.grid.origin += origin_;
      flow.segments.push_back(std::move(segment));
    }
    if (std::abs(done - wanted()) > kMaxShortfall * std::abs(wanted())) refuse_more_than(std::abs(done));
    const double stretch = moved_.stretch_from(rest_);
    if (stretch > kMaxInflateStretch) {
      throw InvalidInput(
          fmt::format("\"{0}\": {1:.3g} stretches the surface {2:.1f} times; make \"radius\" larger, or \"{0}\" less",
                      key(), wanted(), stretch));
    }
  }

 private:
  // The number that says how much, and its key.
  double wanted() const { return stroke_.depth.value_or(stroke_.volume); }
  const char* key() const { return stroke_.depth ? "depth" : "volume"; }

  static InflateStroke relative(InflateStroke stroke) {
    relative(stroke.points, Vec3d(stroke.points.front()));
    return stroke;
  }

  static std::vector<Vec3d>& relative(std::vector<Vec3d>& points, const Vec3d& origin) {
    for (Vec3d& p : points) p -= origin;
    return points;
  }

  // Returns the grid of p, moved by a part of its spacing.
  PotentialGrid outward(const SurfaceTree& tree, double part) {
    const double h = stroke_.radius / kSpacingsOfRadius;
    const Box box = tool_.box();
    PotentialGrid grid;
    grid.spacing = h;
    double nodes = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      grid.origin[axis] = (std::floor(box.min[axis] / h) + part) * h;
      const double count = std::ceil((box.max[axis] - grid.origin[axis]) / h) + 1;
      nodes *= count;
      grid.counts[axis] = static_cast<int>(std::min(count, kMaxNodes));
    }
    if (nodes > kMaxNodes) {
      throw InvalidInput(
          "\"points\": the path is too long for this \"radius\"; divide it into several strokes, or make it larger");
    }
    std::vector<double> growth(static_cast<std::size_t>(nodes));
    const int columns = grid.counts[0];
    const int rows = grid.counts[1];
    parallel_for(growth.size(), 64, threads_, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(surface_.progress);
      for (std::size_t i = begin; i < end; ++i) {
        const auto at = static_cast<int>(i);
        const std::array<int, 3> node{at % columns, at / columns % rows, at / columns / rows};
        const Vec3d p = grid.origin + Vec3d(node[0], node[1], node[2]) * h;
        const double rate = tool_.rate(tool_.distance(p));
        if (rate > 0) growth[i] = -rate * share_inside(tree, p);
      }
    });
    if (part == 0) inside_ = -std::accumulate(growth.begin(), growth.end(), 0.0) * h * h * h;
    grid.coefficients = SharedVectors(std::vector<Vec3d>(growth.size()));
    grid.growth = SharedNumbers(std::move(growth));
    return grid;
  }

  // Returns S.
  double share_inside(const SurfaceTree& tree, const Vec3d& p) const {
    const double depth = kLayer * stroke_.radius;
    const std::optional<SurfacePoint> nearest = tree.closest(p, depth);
    const double s = nearest ? nearest->distance / depth : 1;
    const double beyond = 0.25 * s * (3 - s * s);
    return is_inside(tree, p) ? 0.5 + beyond : 0.5 - beyond;
  }

  // Two of three rays say so: small holes change nothing.
  static bool is_inside(const SurfaceTree& tree, const Vec3d& p) {
    static constexpr std::array<Vec3d, 3> kDirections{
        {{0.573, -0.609, 0.548}, {0.740, 0.672, -0.028}, {-0.351, 0.422, 0.836}}};
    int votes = 0;
    for (const Vec3d& direction : kDirections) {
      int winding = 0;
      for (const RayHit& hit : tree.hits(p, direction)) winding += hit.leaves ? 1 : -1;
      votes += winding != 0 ? 1 : 0;
    }
    return votes >= 2;
  }

  // The volume that grows inside must leave through the surface; near the end of the tool little can.
  void require_flux(double flux, double grown) const {
    if (!(inside_ > 0)) {
      throw InvalidInput("\"points\": nothing of the shape's inside is within \"radius\" of them; nothing can grow");
    }
    if (-stroke_.volume > kMaxTaken * inside_) {
      throw InvalidInput(fmt::format("\"volume\": at most {:.3g} can be taken away here, got {:.3g}",
                                     rounded_down(kMaxTaken * inside_), -stroke_.volume));
    }
    if (flux * stroke_.radius * stroke_.radius > kMinFlux * inside_) return;
    if (grown == 0) {
      throw InvalidInput("\"points\": no surface is within \"radius\" of them through which the shape could grow");
    }
    refuse_more_than(std::abs(grown));
  }

  [[noreturn]] void refuse_more_than(double possible) const {
    throw InvalidInput(fmt::format("\"{}\": at most about {:.2g} is possible here, got {:.3g}; make \"radius\" larger",
                                   key(), 0.9 * possible, wanted()));
  }

  // `way`: that of the fastest vertex.
  std::size_t count_steps(double way) const {
    const double steps = std::max(static_cast<double>(kMinSteps), std::ceil(way / (kStepLength * stroke_.radius)));
    if (steps <= static_cast<double>(kMaxSteps)) return static_cast<std::size_t>(steps);
    refuse_more_than(std::abs(wanted()) * static_cast<double>(kMaxSteps) / steps);
  }

  // Returns by how much the volume has changed since the beginning, or how far the surface has moved.
  double change_to(const std::vector<Vec3d>& points) const {
    if (!stroke_.depth) return orientation_ * moved_.volume_between(rest_, points);
    double greatest = 0;
    for (std::size_t i = 0; i < rest_.size(); ++i) greatest = std::max(greatest, norm(points[i] - rest_[i]));
    return std::copysign(greatest, *stroke_.depth);
  }

  // Returns the multiple of the grid, about `by`, that adds the share to what is done.
  PotentialGrid with_change(const PotentialGrid& grid, double done, double share, double by) const {
    PotentialGrid result = multiplied(grid, by);
    const double tolerance = stroke_.depth ? kExactDepth : kExactVolume;
    for (int i = 0; i < kCorrections; ++i) {
      std::vector<Vec3d> after = moved_.points;
      move(result, after);
      const double change = change_to(after) - done;
      if (std::abs(change - share) <= tolerance * std::abs(share) || change * share <= 0) break;
      by *= std::clamp(share / change, 0.5, 2.0);
      result = multiplied(grid, by);
    }
    return result;
  }

  void move(const PotentialGrid& grid, std::vector<Vec3d>& points) const {
    AdvectOptions options;
    options.tolerance = kVolumeTolerance * stroke_.radius;
    options.precision = Precision::float64;
    options.threads = threads_;
    options.progress = nullptr;
    stop_if_cancelled(surface_.progress);
    advect(flow_of(grid), points, options);
  }

  Vec3d origin_;
  InflateStroke stroke_;
  InflateTool tool_;
  const LiveSurface& surface_;
  int threads_;
  std::vector<Vec3d> positions_;  // of all vertices, as they are after the steps so far
  MovedSurface moved_;
  std::vector<Vec3d> rest_;  // its points before the first step
  double inside_ = 0;        // the integral of rate S before the first step
  double orientation_ = 1;   // of the triangles
};

std::vector<StrokeKey> keys(InflateStroke& s) {
  return {{"points", Quantity::finite, &s.points, Presence::not_empty},
          {"radius", Quantity::positive, &s.radius, Presence::required, "nothing farther from the path moves"},
          {"volume", Quantity::finite, &s.volume, Presence::optional,
           "what the shape gains, as a cube of its units of length; below 0: what it loses"},
          {"depth", Quantity::finite, &s.depth, Presence::optional,
           "how far the surface moves at most, in the place of the volume; below 0: inwards"}};
}

void prepare(InflateStroke& /*stroke*/, const HasKey& has) {
  if (!has("volume") && !has("depth")) throw InvalidInput("\"depth\" or \"volume\" is missing");
}

void validate(const InflateStroke& stroke) {
  if (stroke.depth && stroke.volume != 0) {
    throw InvalidInput("\"depth\" stands in the place of \"volume\"; leave one out");
  }
  require_count("points", stroke.points.size(), 1, "points");
  if (stroke.points.size() > kMaxPoints) {
    throw InvalidInput(fmt::format("\"points\" must hold at most {} points, got {}", kMaxPoints, stroke.points.size()));
  }
}

void prolong(InflateStroke& stroke, double strength) {
  stroke.volume *= strength;
  if (stroke.depth) *stroke.depth *= strength;
}

void resolve(const InflateStroke& stroke, SurfaceRun& run) { inflate_on(stroke, run.surface, run.threads); }

std::size_t segments(const InflateStroke& /*stroke*/, const Mesh* /*mesh*/) { return 4; }

// A volume in percent of the tool's ball.
std::string words(const InflateStroke& stroke, const std::string& unit) {
  if (stroke.depth) {
    return fmt::format("{} by {}", *stroke.depth < 0 ? "Shrink" : "Inflate",
                       length_text(std::abs(*stroke.depth), unit));
  }
  const double ball = 4 * std::numbers::pi / 3 * stroke.radius * stroke.radius * stroke.radius;
  return fmt::format("{} by {:.2g}%", stroke.volume < 0 ? "Shrink" : "Inflate", 100 * std::abs(stroke.volume) / ball);
}

}  // namespace

bool inflate_on(const InflateStroke& stroke, const LiveSurface& surface, int threads) {
  validate(stroke);
  if (stroke.volume == 0 && stroke.depth.value_or(0) == 0) return true;
  Flow flow;
  Inflation(stroke, surface, threads).run(flow);
  return apply_grids(flow, surface);
}

// The description of the tool "inflate".

constinit const detail::ToolRow<InflateStroke> InflateStroke::tool{.name = "inflate",
                                                                   .keys = keys,
                                                                   .prepare = prepare,
                                                                   .validate = validate,
                                                                   .resolve = resolve,
                                                                   .segments = segments,
                                                                   .words = words,
                                                                   .prolong = prolong};

}  // namespace knead
