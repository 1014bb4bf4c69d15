// The flow of a lattice: grids of potentials, one for each step, that take the surface in the box as near to the places
// where the lattice's displacements would have it as a divergence-free flow can. The inside gives way.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "flow/lattice_map.h"
#include "flow/path_jacobian.h"
#include "knead/error.h"
#include "knead/vec.h"
#include "math/geometry.h"
#include "mesh/body_points.h"
#include "pose/near_rigid.h"
#include "pose/pose_motion.h"
#include "pose/sound_steps.h"
#include "strokes/lattice.h"
#include "strokes/pose.h"

namespace knead::detail {

namespace {

using namespace detail;

constexpr double kSpacingsOfCell = 2.5;  // of the grid, in the least distance of control points; fewer where there
constexpr std::size_t kMaxLatticeUnknowns = 5000;  // would be more unknowns than so many
constexpr double kMaxNodesOfBox = 20'000;          // bounds the time of counting unknowns
constexpr double kWider = 1.05;
constexpr double kSamplesApart = 0.7;  // of the grid's spacing
constexpr double kSpacingsOfStep = 1;
constexpr double kMaxLatticeSteps = 100;
// The weights of the places of surface samples, beside the difference of strains. Straight ways to the places would
// squeeze what turns: first the body goes about there, led by its strains, then nearer. A higher last weight dents flat
// faces where the displacements change the volume.
constexpr double kFollowsWeakly = 0.005;
constexpr double kFollows = 1;
constexpr double kMaxLatticeStretch = 6;  // of a triangle
constexpr double kMaxSampleStrain = 1;    // wanted at a sample
constexpr double kMinDeterminant = 1e-2;  // of the lattice's map where its strain counts
constexpr double kJacobianTolerance = 1e-4;
constexpr double kMinGain = 0.99;        // what a correction must leave at most, of the distance before
constexpr double kPathTolerance = 1e-6;  // of the box's diagonal
constexpr double kNear = 0.01;           // of the greatest displacement: what is nearer is not told

// How far points are from their places.
struct Distances {
  double mean = 0;
  double most = 0;
};

Distances distances_between(std::span<const Vec3d> points, std::span<const Vec3d> places) {
  Distances result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = norm(points[i] - places[i]);
    result.mean += distance / static_cast<double>(points.size());
    result.most = std::max(result.most, distance);
  }
  return result;
}

Segment with_lattice(const LatticeStroke& stroke) {
  Segment segment;
  segment.lattice = motion_of(stroke);
  return segment;
}

class LatticeFlow {
 public:
  LatticeFlow(const LatticeStroke& stroke, SurfaceRun& run)
      : is_rigid_(stroke.mode == LatticeMode::rigid),
        run_(run),
        closed_(closed_faces(motion_of(stroke))),
        segment_(with_lattice(stroke)),
        sound_(run.surface.positions, run.surface.triangles, kMaxLatticeStretch, path_options()) {
    for (const Vec3d& d : stroke.displacements) greatest_ = std::max(greatest_, norm(d));
    find_body();
  }

  bool is_empty() const { return rows_.points.empty() || greatest_ == 0; }

  // Returns a segment for each step. Where a step would spoil the surface, the motion ends before it, and the run's
  // shortfall says so.
  Flow find() {
    if (distance().most > kMaxLatticeSteps * kSpacingsOfStep * spacing_) {
      throw InvalidInput(fmt::format(
          "\"displacements\" go {:.0f} times as far as control points are apart; make the distances of control points "
          "larger, or divide the stroke into several",
          distance().most / (spacing_ * kSpacingsOfCell)));
    }
    rows_.weight = kFollowsWeakly;
    const SoundReach reach = go();
    if (!reach.problem.empty()) {
      run_.reached = reach.time;
      run_.shortfall = fmt::format(
          "\"displacements\": the shape came {:.0f}% of its way: beyond that {}; make them less, or let neighbouring "
          "control points move alike",
          std::floor(100 * reach.time), reach.problem);
    } else if (!is_rigid_) {
      const double before = distance().mean;
      const std::size_t segments = flow_.segments.size();
      rows_.weight = kFollows;
      go();
      if (distance().mean >= kMinGain * before) flow_.segments.resize(segments);
    }
    return std::move(flow_);
  }

  // Says how near the shape's own points come to their places.
  void tell(const std::vector<Vec3d>& before, std::span<const Vec3d> after) const {
    const LatticeMap map(segment_);
    std::vector<Vec3d> points;
    std::vector<Vec3d> places;
    for (std::size_t i = 0; i < before.size(); ++i) {
      Vec3d place = before[i];
      if (!map.move(place)) continue;
      points.push_back(after[i]);
      places.push_back(place);
    }
    const Distances off = distances_between(points, places);
    if (run_.reached < 1 || !(off.most > kNear * greatest_)) return;
    run_.remarks.push_back(
        fmt::format("{}: the shape comes within {:.2g} of where they would have it, in the mean {:.2g}; the greatest "
                    "of them is {:.2g}",
                    is_rigid_ ? "a body that strains little cannot follow the displacements"
                              : "the displacements change the volume",
                    off.most, off.mean, greatest_));
  }

 private:
  // Finds the finest grid whose unknowns are not too many, and the samples that it needs.
  void find_body() {
    const LatticeMotion& lattice = segment_.lattice;
    body_.accepts = [this](const Box& support) { return is_reached(support); };
    double least = kInfinity;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least = std::min(least, lattice.lengths[axis] / (lattice.counts[axis] - 1));
    }
    spacing_ = least / kSpacingsOfCell;
    const auto nodes_of_box = [&] {
      double product = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) product *= lattice.lengths[axis] / spacing_ + 3;
      return product;
    };
    while (nodes_of_box() > kMaxNodesOfBox) spacing_ *= kWider;
    sample();
    const double first = spacing_;
    while (count_unknowns({lattice.origin, spacing_}, body_, {}) > kMaxLatticeUnknowns) spacing_ *= kWider;
    if (spacing_ != first) sample();
  }

  // Takes the samples of the body that are in the box: those inside, then those of the surface, which are the rows.
  void sample() {
    const LatticeMap map(segment_);
    const BodyPoints body = body_points(
        run_.surface.positions, run_.surface.triangles,
        {.most_spacing = kSamplesApart * spacing_, .threads = run_.threads, .within = bounding_box(segment_.lattice)});
    body_.points.clear();
    places_.clear();
    left_.clear();
    for (std::size_t i = 0; i < body.points.size(); ++i) {
      Vec3d place = body.points[i];
      Mat3d jacobian;
      if (!map.move(place, jacobian)) continue;
      body_.points.push_back(body.points[i]);
      left_.push_back(determinant(jacobian) > kMinDeterminant ? std::optional(inverse(jacobian)) : std::nullopt);
      if (i >= body.inside) places_.push_back(place);
    }
    set_rows();
  }

  void set_rows() { rows_.points.assign(body_.points.end() - std::ssize(places_), body_.points.end()); }

  // Returns whether a node with this support may move: closed faces rest.
  bool is_reached(const Box& support) const {
    const LatticeMotion& lattice = segment_.lattice;
    const Vec3d middle = lattice.axes * (support.center() - lattice.origin);
    const Vec3d half = (support.max - support.min) * 0.5;
    const std::array<Vec3d, 3> axes{lattice.axes.row0, lattice.axes.row1, lattice.axes.row2};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec3d& a = axes[axis];
      const double by = std::abs(a.x) * half.x + std::abs(a.y) * half.y + std::abs(a.z) * half.z;
      if (closed_[axis][0] && middle[axis] - by < 0) return false;
      if (closed_[axis][1] && middle[axis] + by > lattice.lengths[axis]) return false;
    }
    return true;
  }

  Distances distance() const { return distances_between(rows_.points, places_); }

  // Goes to the places in steps, each an equal part of what is left, as long as these are sound.
  SoundReach go() {
    const double steps = std::max(1.0, std::ceil(distance().most / (kSpacingsOfStep * spacing_)));
    std::vector<double> times;
    for (double k = 0; k <= steps; ++k) times.push_back(k / steps);
    SteppedMotion motion;
    motion.solve = [this](double from, double to) { return solve((to - from) / (1 - from)); };
    motion.take = [this](const PotentialGrid& grid) { return take(grid); };
    // A finer grid would have too many unknowns.
    motion.set_spacing = [this, first = spacing_](double factor) { spacing_ = std::max(1.0, factor) * first; };
    return step_soundly(times, in_parts(std::move(motion)));
  }

  // Returns the grid that moves the body by a part of what is left.
  PotentialGrid solve(double part) {
    rows_.wanted.clear();
    for (std::size_t i = 0; i < places_.size(); ++i) rows_.wanted.push_back((places_[i] - rows_.points[i]) * part);
    if (!is_rigid_) want_strains(part);
    std::vector<Vec3d> before = before_;
    find_surroundings(body_, before, std::span(&rows_, 1), spacing_);
    const double shift = static_cast<double>(flow_.segments.size() % kOrigins) / kOrigins * spacing_;
    return NearRigidSystem({segment_.lattice.origin + Vec3d{shift, shift, shift}, spacing_}, body_,
                           std::span(&rows_, 1), run_.threads, run_.surface.progress)
        .solve(std::span(&rows_, 1));
  }

  // Moves the surface and the body by a grid, or says why the surface would not be sound.
  std::string take(const PotentialGrid& grid) {
    if (std::string problem = sound_.take(grid); !problem.empty()) return problem;
    before_ = body_.points;
    Segment& segment = flow_.segments.emplace_back();
    segment.grid = grid;
    AdvectOptions options = path_options();
    options.precision = Precision::float64;
    options.progress = nullptr;
    const std::vector<Mat3d> now = move_with_jacobians({{segment}}, body_.points, options, kJacobianTolerance);
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (left_[i]) left_[i] = now[i] * *left_[i];
    }
    set_rows();
    return {};
  }

  AdvectOptions path_options() const {
    AdvectOptions options;
    options.tolerance = kPathTolerance * norm(segment_.lattice.lengths);
    options.threads = run_.threads;
    options.progress = run_.surface.progress;
    return options;
  }

  // Wants a part of the strain that is left between where a sample is and its place.
  void want_strains(double part) {
    body_.strain.clear();
    for (const std::optional<Mat3d>& left : left_) {
      const Mat3d strain = left ? log_strain(*left) : Mat3d{} * 0.0;
      body_.strain.push_back(strain * (-part / std::max(1.0, row_sum_norm(strain) / kMaxSampleStrain)));
    }
  }

  static constexpr std::size_t kOrigins = 3;  // of grids in turn, so that no pattern of their nodes is seen

  bool is_rigid_;
  SurfaceRun& run_;
  std::array<std::array<bool, 2>, 3> closed_;
  Segment segment_;
  double greatest_ = 0;
  double spacing_ = 0;
  SoundSurface sound_;  // after the steps so far, as are:
  BodySamples body_;
  std::vector<Vec3d> before_;  // its points before the last step
  VelocityRows rows_;
  std::vector<Vec3d> places_;  // where the lattice would have the rows' points
  // For each sample the deformation from where the lattice would have it to where it is; none where the lattice folds.
  std::vector<std::optional<Mat3d>> left_;
  Flow flow_;
};

}  // namespace

void flow_on(const LatticeStroke& stroke, SurfaceRun& run) {
  LatticeFlow lattice(stroke, run);
  if (lattice.is_empty()) return;
  const std::vector<Vec3d> before(run.surface.positions.begin(), run.surface.positions.end());
  if (apply_grids(lattice.find(), run.surface)) lattice.tell(before, run.surface.positions);
}

}  // namespace knead::detail
