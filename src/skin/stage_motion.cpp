// Moves the limbs of a stage step by step, and the flesh between them by the flow that strains it least.
#include "skin/stage_motion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pose/pose_motion.h"

namespace knead::detail {

namespace {

// Weights of all rows of a limb together, in units of the mean diagonal of the strain times spacing^2.
constexpr double kLimbWeight = 20000;
constexpr double kHoldWeight = 5000;           // of limbs that rest
constexpr double kGrowthSpacing = 1.5;         // of the grid in which flesh grows, in spacings of the stage
constexpr double kGrowthWeight = 3;            // of wanted growth, relative to strain
constexpr double kMaxCorrection = 0.25;        // in one step, in spacings
constexpr double kMaxVelocityGradient = 0.25;  // between two limbs: their velocities' difference over their distance
constexpr double kConflictRadius = 2;          // the distance within which limbs may conflict, in spacings
constexpr double kTolerance = 1e-6;            // of the diagonal, for the body's own points
constexpr double kMaxRestoredStrain = 0.25;    // that a step wants to undo, as a norm: with more, fields break
constexpr double kStiffening = 0.3;            // of flesh by the square of its strain

// Moves the limbs and the body of a stage step by step.
class StageMotion {
 public:
  explicit StageMotion(StageProblem& problem)
      : problem_(problem), stiffness_(problem.body.stiffness), deformations_(problem.body.points.size()) {
    lattice_.spacing = problem_.spacing;
    for (const LimbPoints& limb : problem_.limbs) now_.push_back(limb.points);
    const std::vector<Rigid> first = problem_.motions(0);
    for (const Rigid& motion : first) back_.push_back(inverse(motion));
  }

  Flow run(std::size_t& unknowns, SoundReach& reach) {
    std::vector<double> times;
    const auto count = static_cast<double>(problem_.steps);
    for (std::size_t k = 0; k <= problem_.steps; ++k) times.push_back(static_cast<double>(k) / count);
    times.push_back(1);
    SteppedMotion motion;
    motion.solve = [&](double from, double to) { return solve(from, to, unknowns); };
    motion.take = [this](const PotentialGrid& grid) { return take(grid); };
    motion.set_spacing = [this, first = problem_.spacing](double factor) {
      problem_.spacing = lattice_.spacing = factor * first;
    };
    reach = step_soundly(times, in_parts(std::move(motion)));
    problem_.body.strain.clear();
    problem_.body.stiffness = std::move(stiffness_);
    for (std::size_t i = 0; i < now_.size(); ++i) problem_.limbs[i].points = std::move(now_[i]);
    return std::move(flow_);
  }

 private:
  // Returns the grid of a step from the present state, which stays.
  PotentialGrid solve(double from, double to, std::size_t& unknowns) {
    stop_if_cancelled(problem_.progress);
    const std::vector<VelocityRows> rows = rows_of(from, to);
    std::vector<Vec3d> before = before_;
    find_surroundings(problem_.body, before, rows, problem_.spacing);
    want_strain_undone();
    const NearRigidSystem system(lattice_, problem_.body, rows, problem_.threads, problem_.progress);
    unknowns = std::max(unknowns, system.unknowns());
    return system.solve(rows);
  }

  std::string take(const PotentialGrid& grid) {
    if (std::string problem = problem_.judge(grid); !problem.empty()) return problem;
    Flow one;
    one.segments.emplace_back().grid = grid;
    flow_.segments.push_back(one.segments.front());
    before_ = problem_.body.points;
    deform(one);
    move(one, problem_.body.points);
    for (std::vector<Vec3d>& points : now_) move(one, points);
    if (problem_.progress != nullptr) problem_.progress->done += kWorkOfStage / (problem_.steps + 1);
    return {};
  }

  // Makes the body elastic: each step wants to undo the strain of earlier steps, and strained flesh is stiffer. Without
  // this, each step would add strain where the first one did.
  void want_strain_undone() {
    problem_.body.strain.clear();
    for (std::size_t i = 0; i < deformations_.size(); ++i) {
      const Mat3d strain = log_strain(deformations_[i]);
      const double square =
          dot(strain.row0, strain.row0) + dot(strain.row1, strain.row1) + dot(strain.row2, strain.row2);
      problem_.body.stiffness[i] = stiffness_[i] * (1 + kStiffening * square);
      problem_.body.strain.push_back(strain * -std::min(1.0, kMaxRestoredStrain / std::sqrt(square)));
    }
  }

  // Adds a step to the deformation of each sample of the body.
  void deform(const Flow& step) {
    const std::vector<Mat3d> now = jacobians(step, problem_.body.points, tolerance());
    for (std::size_t i = 0; i < now.size(); ++i) deformations_[i] = now[i] * deformations_[i];
  }

  // Returns the rows of each limb: its rate, and the distance of each point from its target.
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
      list.weight = (list.rests ? kHoldWeight : kLimbWeight) / static_cast<double>(now_[i].size());
      rows.push_back(std::move(list));
    }
    return rows;
  }

  // Wants the same rate at the positions to which the points move: otherwise each step bends thin limbs a little more.
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

  // Returns the screw of a limb's motion during a step, and its rate at a point.
  Screw step_of(std::size_t i, const std::vector<Rigid>& begin, const std::vector<Rigid>& end) const {
    const std::size_t limb = problem_.limbs[i].limb;
    return screw_of(end[limb] * inverse(begin[limb]), now_[i].front());
  }
  static Vec3d rate_of(const Screw& screw, const Vec3d& p) {
    return cross(screw.axis * screw.angle, p - screw.center) + screw.slide;
  }

  std::vector<Vec3d> wanted_of(std::size_t i, const std::vector<Rigid>& begin, const std::vector<Rigid>& end) const {
    const LimbPoints& limb = problem_.limbs[i];
    const double max_miss = kMaxCorrection * problem_.spacing;
    const Rigid to_begin = begin[limb.limb] * back_[limb.limb];
    const Screw screw = step_of(i, begin, end);
    std::vector<Vec3d> wanted;
    for (std::size_t k = 0; k < now_[i].size(); ++k) {
      const Vec3d& p = now_[i][k];
      Vec3d miss = (limb.moves ? to_begin(limb.points[k]) : limb.points[k]) - p;
      if (norm(miss) > max_miss) miss *= max_miss / norm(miss);
      Vec3d rate{0, 0, 0};
      if (limb.moves) rate = rate_of(screw, p);
      wanted.push_back(rate + miss);
    }
    return wanted;
  }

  // Finds the points that are so near to another limb that no smooth field meets both. Resting limbs have none, unless
  // they may deform.
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
      if (!problem_.limbs[i].moves && !problem_.rest_gives) continue;
      std::vector<Triangle> others;
      for (std::uint32_t p = 0; p < points.size(); ++p) {
        if (of[p] != i) others.push_back({p, p, p});
      }
      if (others.empty()) continue;
      const SurfaceTree tree(others, points);
      for (std::size_t k = 0; k < now_[i].size(); ++k) {
        const std::optional<SurfacePoint> near = tree.closest(now_[i][k], kConflictRadius * problem_.spacing);
        if (!near) continue;
        const std::uint32_t other = others[near->triangle][0];
        result[i][k] = norm(velocities[other] - wanted[i][k]) > kMaxVelocityGradient * near->distance;
      }
    }
    return result;
  }

  void move(const Flow& flow, std::vector<Vec3d>& points) const { advect(flow, points, tolerance()); }

  AdvectOptions tolerance() const {
    AdvectOptions options;
    options.tolerance = kTolerance * problem_.diagonal;
    options.precision = Precision::float64;
    options.threads = problem_.threads;
    return options;
  }

  StageProblem& problem_;
  Lattice lattice_;
  std::vector<std::vector<Vec3d>> now_;  // the points of the limbs
  std::vector<Rigid> back_;              // from the beginning of the stage to rest
  std::vector<Vec3d> before_;            // the body's points one step earlier
  std::vector<double> stiffness_;        // of the body's samples without strain
  std::vector<Mat3d> deformations_;      // of the body's samples since the stage began
  Flow flow_;
};

}  // namespace

Flow stage_flow(StageProblem& problem, std::size_t& unknowns, SoundReach& reach) {
  return StageMotion(problem).run(unknowns, reach);
}

PotentialGrid growing_grid(const StageProblem& problem, std::vector<double> growth) {
  std::vector<VelocityRows> rows;
  for (const LimbPoints& limb : problem.limbs) {
    VelocityRows& list = rows.emplace_back();
    list.points = limb.points;
    list.wanted.assign(limb.points.size(), Vec3d{0, 0, 0});
    list.weight = kHoldWeight / static_cast<double>(limb.points.size());
    list.rests = true;
  }
  BodySamples body = problem.body;
  body.growth = std::move(growth);
  body.growth_weight = kGrowthWeight;
  Lattice lattice;
  lattice.spacing = kGrowthSpacing * problem.spacing;
  return NearRigidSystem(lattice, body, rows, problem.threads, problem.progress).solve(rows);
}

}  // namespace knead::detail
