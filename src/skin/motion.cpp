#include "skin/motion.h"

#include <algorithm>
#include <cmath>

#include "knead/mesh.h"

namespace knead::skin_detail {

namespace {

using detail::Lattice;
using detail::NearRigidSystem;
using detail::VelocityRows;

// Of a limb's rows together, in units of the mean diagonal of the strain times spacing^2, and of what holds.
constexpr double kWeightOfLimb = 20000;
constexpr double kWeightOfHold = 5000;
constexpr double kMargin = 0.25;         // of the spacing, about all points
constexpr double kMaxCorrection = 0.25;  // of the spacing, in one step
constexpr double kConflict = 0.35;       // what velocities of two limbs may differ by, over their distance
constexpr double kSearched = 2;          // spacings: how far away another limb may be in conflict
constexpr double kTolerance = 1e-6;      // of the diagonal, for the body's own points

class Motion {
 public:
  explicit Motion(StageProblem problem) : problem_(std::move(problem)) {
    lattice_.spacing = problem_.spacing;
    for (const LimbPoints& limb : problem_.limbs) now_.push_back(limb.points);
    const std::vector<Rigid> first = problem_.motions(0);
    for (const Rigid& motion : first) back_.push_back(inverse(motion));
  }

  Flow run(std::size_t& unknowns) {
    const auto count = static_cast<double>(problem_.steps);
    for (std::size_t k = 0; k < problem_.steps; ++k) {
      step(static_cast<double>(k) / count, static_cast<double>(k + 1) / count, unknowns);
    }
    step(1, 1, unknowns);
    return std::move(flow_);
  }

 private:
  void step(double from, double to, std::size_t& unknowns) {
    stop_if_cancelled(problem_.progress);
    const std::vector<VelocityRows> rows = rows_of(from, to);
    find_surroundings(rows);
    const NearRigidSystem system(lattice_, problem_.body, rows, problem_.threads, problem_.progress);
    unknowns = std::max(unknowns, system.unknowns());
    Segment segment;
    segment.grid = system.solve(rows);
    Flow one;
    one.segments.push_back(segment);
    flow_.segments.push_back(std::move(segment));
    move(one, problem_.body.points);
    for (std::vector<Vec3d>& points : now_) move(one, points);
  }

  // What each limb's points want: the rate of the limb, and what is missing from their place.
  std::vector<VelocityRows> rows_of(double from, double to) const {
    const std::vector<Rigid> begin = problem_.motions(from);
    const std::vector<Rigid> end = problem_.motions(to);
    std::vector<std::vector<Vec3d>> wanted;
    for (std::size_t i = 0; i < now_.size(); ++i) wanted.push_back(wanted_of(i, begin, end));
    const std::vector<std::vector<bool>> in_conflict = conflicts(wanted);
    std::vector<VelocityRows> rows;
    for (std::size_t i = 0; i < now_.size(); ++i) {
      VelocityRows list;
      list.rests = !problem_.limbs[i].moves;
      for (std::size_t k = 0; k < now_[i].size(); ++k) {
        if (in_conflict[i][k]) continue;
        list.points.push_back(now_[i][k]);
        list.wanted.push_back(wanted[i][k]);
      }
      if (list.points.empty()) continue;
      if (!list.rests) look_ahead(i, begin, end, list);
      list.weight = (list.rests ? kWeightOfHold : kWeightOfLimb) / static_cast<double>(now_[i].size());
      rows.push_back(std::move(list));
    }
    return rows;
  }

  // The same rate is wanted where the points come to: else what is thin is bent a little more by each step.
  void look_ahead(std::size_t i, const std::vector<Rigid>& begin, const std::vector<Rigid>& end,
                  VelocityRows& list) const {
    const Screw screw = step_of(i, begin, end);
    const std::size_t count = list.points.size();
    Vec3d missing{0, 0, 0};
    for (std::size_t k = 0; k < count; ++k) {
      missing += (list.wanted[k] - rate_of(screw, list.points[k])) / static_cast<double>(count);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3d ahead = list.points[k] + list.wanted[k];
      list.points.push_back(ahead);
      list.wanted.push_back(rate_of(screw, ahead) + missing);
    }
  }

  // The screw that takes a limb from one moment to the other, and the rate at which it does.
  Screw step_of(std::size_t i, const std::vector<Rigid>& begin, const std::vector<Rigid>& end) const {
    const std::size_t limb = problem_.limbs[i].limb;
    return screw_of(end[limb] * inverse(begin[limb]), now_[i].front());
  }
  static Vec3d rate_of(const Screw& screw, const Vec3d& p) {
    return cross(screw.axis * screw.angle, p - screw.center) + screw.slide;
  }

  std::vector<Vec3d> wanted_of(std::size_t i, const std::vector<Rigid>& begin, const std::vector<Rigid>& end) const {
    const LimbPoints& limb = problem_.limbs[i];
    const double most = kMaxCorrection * problem_.spacing;
    const Rigid to_begin = begin[limb.limb] * back_[limb.limb];
    const Screw screw = step_of(i, begin, end);
    std::vector<Vec3d> wanted;
    for (std::size_t k = 0; k < now_[i].size(); ++k) {
      const Vec3d& p = now_[i][k];
      Vec3d miss = (limb.moves ? to_begin(limb.points[k]) : limb.points[k]) - p;
      if (norm(miss) > most) miss *= most / norm(miss);
      Vec3d rate{0, 0, 0};
      if (limb.moves) rate = rate_of(screw, p);
      wanted.push_back(rate + miss);
    }
    return wanted;
  }

  // Points that another limb is so near that no smooth field meets both.
  std::vector<std::vector<bool>> conflicts(const std::vector<std::vector<Vec3d>>& wanted) const {
    std::vector<Vec3d> points;
    std::vector<Vec3d> velocities;
    std::vector<std::size_t> of;
    std::vector<std::vector<bool>> result;
    for (std::size_t i = 0; i < now_.size(); ++i) {
      points.insert(points.end(), now_[i].begin(), now_[i].end());
      velocities.insert(velocities.end(), wanted[i].begin(), wanted[i].end());
      of.insert(of.end(), now_[i].size(), i);
      result.emplace_back(now_[i].size(), false);
    }
    for (std::size_t i = 0; i < now_.size(); ++i) {
      std::vector<Triangle> others;
      for (std::uint32_t p = 0; p < points.size(); ++p) {
        if (of[p] != i) others.push_back({p, p, p});
      }
      if (others.empty()) continue;
      const SurfaceTree tree(others, points);
      for (std::size_t k = 0; k < now_[i].size(); ++k) {
        const std::optional<SurfacePoint> near = tree.closest(now_[i][k], kSearched * problem_.spacing);
        if (!near) continue;
        const std::uint32_t other = others[near->triangle][0];
        result[i][k] = norm(velocities[other] - wanted[i][k]) > kConflict * near->distance;
      }
    }
    return result;
  }

  // Where points are within the step: where they are, where they would come to as they moved before, and near there.
  void find_surroundings(const std::vector<VelocityRows>& rows) {
    std::vector<Vec3d>& around = problem_.body.around;
    around.clear();
    const auto add = [&](const Vec3d& p) {
      const double off = kMargin * problem_.spacing;
      for (const double x : {-off, off}) {
        for (const double y : {-off, off}) {
          for (const double z : {-off, off}) around.push_back(p + Vec3d{x, y, z});
        }
      }
    };
    for (std::size_t i = 0; i < problem_.body.points.size(); ++i) {
      if (!problem_.body.held.empty() && problem_.body.held[i]) continue;
      add(problem_.body.points[i]);
      if (!before_.empty()) add(problem_.body.points[i] * 2.0 - before_[i]);
    }
    for (const VelocityRows& list : rows) {
      for (std::size_t k = 0; k < list.points.size() && !list.rests; ++k) add(list.points[k] + list.wanted[k]);
    }
    before_ = problem_.body.points;
  }

  void move(const Flow& flow, std::vector<Vec3d>& points) const {
    AdvectOptions options;
    options.tolerance = kTolerance * problem_.diagonal;
    options.precision = Precision::float64;
    options.threads = problem_.threads;
    advect(flow, points, options);
  }

  StageProblem problem_;
  Lattice lattice_;
  std::vector<std::vector<Vec3d>> now_;  // where the points of the limbs are
  std::vector<Rigid> back_;              // from the beginning of the stage to rest
  std::vector<Vec3d> before_;            // where the body's points were a step ago
  Flow flow_;
};

}  // namespace

Flow stage_flow(StageProblem problem, std::size_t& unknowns) { return Motion(std::move(problem)).run(unknowns); }

}  // namespace knead::skin_detail
