// Clay that grows: volume on purpose, within a tool (docs/decisions/0035-volume-on-purpose.md).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "knead/error.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/tools.h"
#include "knead/vec.h"
#include "mesh/body_points.h"
#include "pose/near_rigid.h"
#include "strokes/describe.h"
#include "strokes/pose.h"

namespace knead {

namespace {

using namespace detail;
using namespace tool_detail;

constexpr double kSpacings = 8;          // of the grid, in the radius; fewer where a path is long, down to
constexpr double kLeastSpacings = 6;     // these
constexpr std::size_t kUnknowns = 6000;  // that count as many
constexpr double kFull = 0.8;            // of the radius: farther away the body does not grow
constexpr double kCellsOfSample = 0.5;   // the samples' spacing, in that of the grid
constexpr double kSurfaceStiffness = 4;
constexpr double kGrowthWeight = 10;  // of the growth that is wanted, beside strain
constexpr double kStepLength = 0.5;   // of the grid's spacing, at most
constexpr double kStepGrowth = 0.25;  // of log det J, at most
constexpr std::size_t kMaxSteps = 60;
constexpr double kTolerance = 1e-6;    // of path lines, of the radius
constexpr double kMostTaken = 0.5;     // of the volume that grows
constexpr double kLeastFlux = 0.02;    // of the growth inside that must come out through the surface
constexpr double kExactVolume = 1e-7;  // of the volume
constexpr int kCorrections = 6;

double distance_to_piece(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double square = norm2(ab);
  const double t = square > 0 ? std::clamp(dot(p - a, ab) / square, 0.0, 1.0) : 0.0;
  return norm(p - (a + ab * t));
}

// What is within the radius of the stroke's path.
struct InflateTool {
  const std::vector<Vec3d>& path;
  double radius = 0;

  template <class Visit>
  void for_each_piece(const Visit& visit) const {
    for (std::size_t i = 0; i + 1 < std::max<std::size_t>(path.size(), 2); ++i) {
      visit(path[i], path[std::min(i + 1, path.size() - 1)]);
    }
  }

  double distance(const Vec3d& p) const {
    double least = norm(p - path.front());
    for_each_piece([&](const Vec3d& a, const Vec3d& b) { least = std::min(least, distance_to_piece(p, a, b)); });
    return least;
  }

  // Whether a box is within it: within one piece, which is convex, if its corners are.
  bool holds(const Box& box) const {
    bool result = false;
    for_each_piece([&](const Vec3d& a, const Vec3d& b) {
      bool holds = true;
      for (std::size_t corner = 0; corner < 8 && holds; ++corner) {
        const Vec3d p{(corner & 1U) != 0 ? box.max.x : box.min.x, (corner & 2U) != 0 ? box.max.y : box.min.y,
                      (corner & 4U) != 0 ? box.max.z : box.min.z};
        holds = distance_to_piece(p, a, b) <= radius;
      }
      result = result || holds;
    });
    return result;
  }

  // How fast the body grows at a distance, of the rate at the path.
  double rate(double distance) const {
    const double s = distance / (kFull * radius);
    const double rest = std::max(0.0, 1 - s * s);
    return rest * rest * rest;
  }

  Box box() const {
    Box box;
    for (const Vec3d& p : path) {
      box.extend(p - Vec3d{radius, radius, radius});
      box.extend(p + Vec3d{radius, radius, radius});
    }
    return box;
  }
};

// A sum that does not depend on the order of the numbers.
double sum_of(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

// The part of the surface that the tool can move: corners of its triangles.
class Skin {
 public:
  Skin(const LiveSurface& surface, const InflateTool& tool) : origin_(tool.path.front()) {
    std::vector<std::uint32_t> number(surface.positions.size());
    std::vector<bool> is_near(surface.positions.size());
    for (std::size_t i = 0; i < is_near.size(); ++i) is_near[i] = tool.distance(surface.positions[i]) <= tool.radius;
    for (const Triangle& t : surface.triangles) {
      if (std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return is_near[v]; })) continue;
      Triangle own = t;
      for (std::uint32_t& v : own) {
        if (number[v] == 0) {
          points.push_back(surface.positions[v]);
          number[v] = static_cast<std::uint32_t>(points.size());
        }
        v = number[v] - 1;
      }
      triangles_.push_back(own);
    }
  }

  bool empty() const { return triangles_.empty(); }

  // Six times the volume of a triangle's cone, times the sign of the surface.
  double volume_between(const std::vector<Vec3d>& before, const std::vector<Vec3d>& after) const {
    std::vector<double> parts;
    parts.reserve(triangles_.size());
    for (const auto& [a, b, c] : triangles_) {
      parts.push_back(cone(after[a], after[b], after[c]) - cone(before[a], before[b], before[c]));
    }
    return sum_of(std::move(parts)) / 6;
  }

  // Volume for a time through the surface.
  double flux(const std::vector<Vec3d>& velocities) const {
    std::vector<double> parts;
    parts.reserve(triangles_.size());
    for (const auto& [a, b, c] : triangles_) {
      const Vec3d area = cross(points[b] - points[a], points[c] - points[a]);
      parts.push_back(dot(velocities[a] + velocities[b] + velocities[c], area));
    }
    return sum_of(std::move(parts)) / 6;
  }

  std::vector<Vec3d> points;

 private:
  double cone(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
    return dot(a - origin_, cross(b - origin_, c - origin_));
  }

  Vec3d origin_;
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

class Inflation {
 public:
  Inflation(const InflateStroke& stroke, const LiveSurface& surface, int threads)
      : stroke_(stroke),
        tool_{stroke.points, stroke.radius},
        surface_(surface),
        threads_(threads),
        skin_(surface, tool_) {
    if (surface.triangles.empty()) throw InvalidInput("\"tool\": only a surface can be inflated, and a cloud has none");
    find_spacing();
    find_body();
  }

  // Adds a segment for each step.
  void run(Flow& flow) {
    double left = stroke_.volume;
    std::size_t steps = 1;
    for (std::size_t i = 0; i < steps; ++i) {
      PotentialGrid grid = NearRigidSystem(lattice_, body_, {}, threads_, surface_.progress).solve({});
      const std::vector<Vec3d> v = velocities(flow_of(grid), skin_.points, 0);
      const double flux = skin_.flux(v);
      require_flux(std::abs(flux));
      if (i == 0) steps = count_steps(stroke_.volume / flux, greatest_norm(v));
      const double share = left / static_cast<double>(steps - i);
      grid = with_volume(grid, share, share / flux);
      const std::vector<Vec3d> before = skin_.points;
      move(grid, skin_.points);
      move(grid, body_.points);
      left -= orientation_ * skin_.volume_between(before, skin_.points);
      Segment segment;
      segment.grid = std::move(grid);
      flow.segments.push_back(std::move(segment));
    }
  }

 private:
  void find_spacing() {
    BodySamples samples{{stroke_.points.front()}};
    samples.growth = {0};
    tool_.for_each_piece([&](const Vec3d& a, const Vec3d& b) {
      const double pieces = std::ceil(norm(b - a) * kSpacings / stroke_.radius) + 1;
      for (double i = 0; i <= pieces; ++i) samples.around.push_back(a + (b - a) * (i / pieces));
    });
    const std::vector<Vec3d> middles = std::move(samples.around);
    for (double spacings = kSpacings;; spacings -= 0.5) {
      lattice_ = {stroke_.points.front(), stroke_.radius / spacings};
      samples.around.clear();
      for (const Vec3d& p : middles) add_around(p, samples.around);
      samples.reach = [this](const Box& box) { return tool_.holds(box); };
      const std::size_t unknowns = count_unknowns(lattice_, samples, {});
      if (unknowns <= kUnknowns) return;
      if (spacings > kLeastSpacings) continue;
      throw InvalidInput(
          "\"points\": the path is too long for this \"radius\"; divide it into several strokes, or make it larger");
    }
  }

  // The cells of the tool about a place of its path.
  void add_around(const Vec3d& middle, std::vector<Vec3d>& around) const {
    const double h = lattice_.spacing;
    const int most = static_cast<int>(stroke_.radius / h);
    for (int z = -most; z <= most; ++z) {
      for (int y = -most; y <= most; ++y) {
        for (int x = -most; x <= most; ++x) {
          const Vec3d off = Vec3d(x, y, z) * h;
          if (norm(off) <= stroke_.radius) around.push_back(middle + off);
        }
      }
    }
  }

  void find_body() {
    const double apart = kCellsOfSample * lattice_.spacing;
    BodyPoints body = body_points(surface_.positions, surface_.triangles,
                                  {.most_spacing = apart, .threads = threads_, .within = tool_.box()});
    for (std::size_t i = 0; i < body.points.size(); ++i) {
      const double distance = tool_.distance(body.points[i]);
      if (distance > stroke_.radius) continue;
      body_.points.push_back(body.points[i]);
      body_.stiffness.push_back(i < body.inside ? 1 : kSurfaceStiffness);
      body_.growth.push_back(tool_.rate(distance));
      if (i < body.inside) inside_ += apart * apart * apart * body_.growth.back();
    }
    if (!(inside_ > 0)) {
      throw InvalidInput("\"points\": nothing of the shape's inside is within \"radius\" of them; nothing can grow");
    }
    if (-stroke_.volume > kMostTaken * inside_) {
      throw InvalidInput(fmt::format("\"volume\": at most {:.3g} can be taken away here, got {:.3g}",
                                     kMostTaken * inside_, -stroke_.volume));
    }
    body_.growth_weight = kGrowthWeight;
    body_.reach = [this](const Box& box) { return tool_.holds(box); };
    tool_.for_each_piece([&](const Vec3d& a, const Vec3d& b) {
      const double pieces = std::ceil(norm(b - a) * kSpacings / stroke_.radius) + 1;
      for (double i = 0; i <= pieces; ++i) add_around(a + (b - a) * (i / pieces), body_.around);
    });
  }

  void require_flux(double flux) const {
    if (flux > kLeastFlux * inside_) return;
    throw InvalidInput("\"points\": no surface is within \"radius\" of them through which the shape could grow");
  }

  std::size_t count_steps(double by, double speed) {
    if (by * stroke_.volume < 0) orientation_ = -1;  // the triangles look inward
    const double greatest = *std::max_element(body_.growth.begin(), body_.growth.end());
    const double steps = std::max({1.0, std::ceil(std::abs(by) * speed / (kStepLength * lattice_.spacing)),
                                   std::ceil(std::abs(by) * greatest / kStepGrowth)});
    if (steps <= static_cast<double>(kMaxSteps)) return static_cast<std::size_t>(steps);
    throw InvalidInput(
        fmt::format("\"volume\": at most about {:.2g} can grow here at once, got {:.3g}; make \"radius\" larger",
                    std::abs(stroke_.volume) * static_cast<double>(kMaxSteps) / steps, stroke_.volume));
  }

  // The multiple of the grid, about `by`, with which the volume changes by this much.
  PotentialGrid with_volume(const PotentialGrid& grid, double volume, double by) const {
    by = std::abs(by) * (volume < 0 ? -1 : 1);
    PotentialGrid result = multiplied(grid, by);
    for (int i = 0; i < kCorrections; ++i) {
      std::vector<Vec3d> after = skin_.points;
      move(result, after);
      const double change = orientation_ * skin_.volume_between(skin_.points, after);
      if (std::abs(change - volume) <= kExactVolume * std::abs(volume) || change * volume <= 0) break;
      by *= std::clamp(volume / change, 0.5, 2.0);
      result = multiplied(grid, by);
    }
    return result;
  }

  void move(const PotentialGrid& grid, std::vector<Vec3d>& points) const {
    AdvectOptions options;
    options.tolerance = kTolerance * stroke_.radius;
    options.precision = Precision::float64;
    options.threads = threads_;
    options.progress = nullptr;
    stop_if_cancelled(surface_.progress);
    advect(flow_of(grid), points, options);
  }

  const InflateStroke& stroke_;
  InflateTool tool_;
  const LiveSurface& surface_;
  int threads_;
  Skin skin_;
  Lattice lattice_;
  BodySamples body_;
  double inside_ = 0;       // the integral of the growth
  double orientation_ = 1;  // of the triangles
};

}  // namespace

bool inflate_on(const InflateStroke& stroke, const LiveSurface& surface, int threads) {
  validate(stroke);
  if (stroke.volume == 0) return true;
  Flow flow;
  Inflation(stroke, surface, threads).run(flow);
  return apply_grids(flow, surface);
}

// The description of the tool "inflate".

namespace {

constexpr std::size_t kMaxPoints = 10'000;

std::vector<StrokeKey> keys(InflateStroke& s) {
  return {{"points", Quantity::finite, &s.points, Presence::not_empty},
          {"radius", Quantity::positive, &s.radius, Presence::required, "nothing farther from the path moves"},
          {"volume", Quantity::finite, &s.volume, Presence::required,
           "what the shape gains, as a cube of its units of length; below 0: what it loses"}};
}

void validate(const InflateStroke& stroke) {
  require_count("points", stroke.points.size(), 1, "points");
  if (stroke.points.size() > kMaxPoints) {
    throw InvalidInput(fmt::format("\"points\" must hold at most {} points, got {}", kMaxPoints, stroke.points.size()));
  }
}

void prolong(InflateStroke& stroke, double strength) { stroke.volume *= strength; }

}  // namespace

const Tool& InflateStroke::tool() {
  static const Tool kTool =
      describe<InflateStroke>("inflate", {keys, validate, nullptr, nullptr, nullptr, nullptr, prolong});
  return kTool;
}

}  // namespace knead
