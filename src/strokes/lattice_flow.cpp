// The flow of a lattice: grids of potentials, one for each step, that take the surface in the box as near to the places
// where the lattice's displacements would have it as a divergence-free flow can. The inside gives way.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "flow/lattice_map.h"
#include "knead/error.h"
#include "knead/vec.h"
#include "mesh/body_points.h"
#include "pose/near_rigid.h"
#include "pose/pose_motion.h"
#include "strokes/lattice.h"
#include "strokes/pose.h"

namespace knead::tool_detail {

namespace {

using namespace detail;

constexpr double kSpacingsOfCell = 2.5;  // of the grid, in the least distance of control points; fewer where there
constexpr double kUnknowns = 5000;       // would be more unknowns than so many
constexpr double kSamplesApart = 0.7;    // of the grid's spacing
constexpr double kStepLength = 1;        // of the grid's spacing, at most
constexpr double kMaxSteps = 100;
// The weights of the displacements at each sample, beside strain. Straight ways to the places would squeeze what turns:
// first the body goes about there as rigidly as it likes, then nearer and nearer; mode rigid ends after the first.
constexpr std::array<double, 5> kFollows{0.03, 0.1, 0.3, 1, 3};
constexpr double kFollowsWeakly = 0.005;
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

class LatticeFlow {
 public:
  LatticeFlow(const LatticeStroke& stroke, SurfaceRun& run)
      : is_rigid_(stroke.mode == LatticeMode::rigid), run_(run), closed_(closed_faces(motion_of(stroke))) {
    segment_.lattice = motion_of(stroke);
    for (const Vec3d& d : stroke.displacements) greatest_ = std::max(greatest_, norm(d));
    find_spacing();
    find_body();
  }

  bool is_empty() const { return rows_.points.empty() || greatest_ == 0; }

  // Returns a segment for each step.
  Flow find() {
    Flow flow;
    const double length = distances_between(rows_.points, places_).most;
    const double wanted = std::max(1.0, std::ceil(length / (kStepLength * spacing_)));
    if (wanted > kMaxSteps) {
      throw InvalidInput(fmt::format(
          "\"displacements\" go {:.0f} times as far as control points are apart; make the distances of control points "
          "larger, or divide the stroke into several",
          length / (spacing_ * kSpacingsOfCell)));
    }
    rows_.weight = is_rigid_ ? kFollowsWeakly : kFollows.front();
    go(wanted, flow);
    if (is_rigid_) return flow;
    for (const double weight : std::span(kFollows).subspan(1)) {
      rows_.weight = weight;
      const Distances before = distances_between(rows_.points, places_);
      const std::vector<Vec3d> points = rows_.points;
      const std::vector<Vec3d> inside = inside_;
      const std::size_t segments = flow.segments.size();
      go(std::max(1.0, std::ceil(before.most / (kStepLength * spacing_))), flow);
      const double after = distances_between(rows_.points, places_).mean;
      if (after < kMinGain * before.mean) continue;
      flow.segments.resize(segments);
      rows_.points = points;
      inside_ = inside;
    }
    return flow;
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
    if (!(off.most > kNear * greatest_)) return;
    run_.remarks.push_back(
        fmt::format("{}: the shape comes within {:.2g} of where they would have it, in the mean {:.2g}; the greatest "
                    "of them is {:.2g}",
                    is_rigid_ ? "a body that strains little cannot follow the displacements"
                              : "the displacements change the volume",
                    off.most, off.mean, greatest_));
  }

 private:
  // The finest grid whose unknowns are not too many for the whole box.
  void find_spacing() {
    const LatticeMotion& lattice = segment_.lattice;
    double least = kInfinity;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least = std::min(least, lattice.lengths[axis] / (lattice.counts[axis] - 1));
    }
    spacing_ = least / kSpacingsOfCell;
    const auto unknowns = [&] {
      double product = 2;
      for (std::size_t axis = 0; axis < 3; ++axis) product *= lattice.lengths[axis] / spacing_ + 3;
      return product;
    };
    while (unknowns() > kUnknowns) spacing_ *= 1.05;
  }

  void find_body() {
    const LatticeMap map(segment_);
    Box box = bounding_box(segment_.lattice);
    const BodyPoints body =
        body_points(run_.surface.positions, run_.surface.triangles,
                    {.most_spacing = kSamplesApart * spacing_, .threads = run_.threads, .within = box});
    for (std::size_t i = 0; i < body.points.size(); ++i) {
      Vec3d place = body.points[i];
      if (!map.move(place)) continue;
      (i < body.inside ? inside_ : rows_.points).push_back(body.points[i]);
      if (i >= body.inside) places_.push_back(place);
    }
    reach_ = [this](const Box& support) {
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
    };
  }

  // Goes to the places in so many steps, each an equal part of what is left.
  void go(double steps, Flow& flow) {
    for (double n = steps; n >= 1; --n) step(n, flow);
  }

  // Moves the body by the n-th part of what is left, and adds the grid that does.
  void step(double n, Flow& flow) {
    rows_.wanted.clear();
    for (std::size_t i = 0; i < places_.size(); ++i) rows_.wanted.push_back((places_[i] - rows_.points[i]) / n);
    BodySamples body{inside_};
    body.points.insert(body.points.end(), rows_.points.begin(), rows_.points.end());
    body.reach = reach_;
    find_surroundings(body, before_, std::span(&rows_, 1), spacing_);
    const double part = static_cast<double>(flow.segments.size() % kOrigins) / kOrigins;
    const Lattice lattice{segment_.lattice.origin + Vec3d{1, 1, 1} * (part * spacing_), spacing_};
    Segment segment;
    segment.grid = NearRigidSystem(lattice, body, std::span(&rows_, 1), run_.threads, run_.surface.progress)
                       .solve(std::span(&rows_, 1));
    flow.segments.push_back(std::move(segment));
    AdvectOptions options;
    options.tolerance = kPathTolerance * norm(segment_.lattice.lengths);
    options.precision = Precision::float64;
    options.threads = run_.threads;
    for (std::vector<Vec3d>* points : {&rows_.points, &inside_}) advect({{flow.segments.back()}}, *points, options);
  }

  static constexpr std::size_t kOrigins = 3;  // of grids in turn, so that no pattern of their nodes is seen

  bool is_rigid_;
  SurfaceRun& run_;
  std::array<std::array<bool, 2>, 3> closed_;
  Segment segment_;
  double greatest_ = 0;
  double spacing_ = 0;
  VelocityRows rows_;          // with points of the surface, as they are after the steps so far
  std::vector<Vec3d> inside_;  // points inside the body, where only strain counts
  std::vector<Vec3d> places_;  // where the lattice would have them
  std::vector<Vec3d> before_;  // the points before the last step
  std::function<bool(const Box&)> reach_;
};

}  // namespace

void flow_on(const LatticeStroke& stroke, SurfaceRun& run) {
  LatticeFlow lattice(stroke, run);
  if (lattice.is_empty()) return;
  const std::vector<Vec3d> before(run.surface.positions.begin(), run.surface.positions.end());
  if (apply_grids(lattice.find(), run.surface)) lattice.tell(before, run.surface.positions);
}

}  // namespace knead::tool_detail
