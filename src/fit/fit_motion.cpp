// Moves the shape of a fit by near-rigid steps, with patches around its landmarks.
#include "fit/fit_motion.h"

#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "mesh/body_points.h"
#include "pose/pose_motion.h"

namespace knead::detail {

namespace {

using namespace detail;

constexpr double kPatchSize = 0.025;     // of a landmark, of the diagonal
constexpr double kMaxPatchShare = 0.35;  // of the distance to the next landmark
constexpr double kMarkWeight = 600;      // of all points of a patch together
constexpr double kSoftTolerance = 5e-4;  // of the diagonal: the tolerance at which a landmark's weight is half
constexpr double kUrgentShare = 0.8;     // of its tolerance: beyond it a landmark gains weight,
constexpr double kUrgentWeight = 0.1;    // up to this fraction of an exact landmark's
constexpr int kCorrections = 2;          // of the wanted velocities, by where the landmarks arrive
constexpr double kMaxCorrection = 0.25;  // in spacings
constexpr std::size_t kInsideSamples = 3000;
constexpr double kMaxSampleSpacing = 0.4;  // in spacings of the grid
constexpr double kSurfaceStiffness = 20;
constexpr double kFreeGrowthWeight = 0.1;        // of div v where volumes may change
constexpr double kWantedGrowthWeight = 1.0 / 3;  // of div v where growth is wanted: the whole strain counts
constexpr double kGrowthSpacing = 0.08;          // of the diagonal, while the whole shape grows
constexpr double kMaxGrowthStep = 0.04;          // of the diagonal: the motion of a point in a step then
constexpr std::size_t kMaxGrowthSteps = 80;
constexpr std::size_t kGrowthRows = 300;
constexpr double kStiffFactor = 30;          // near vertices that crossed
constexpr double kStiffRadius = 0.5;         // around these, in spacings
constexpr double kMaxExactTolerance = 1e-4;  // of the diagonal: landmarks with less are corrected within each step

Flow flow_of(const PotentialGrid& grid) {
  Segment segment;
  segment.grid = grid;
  return {{std::move(segment)}};
}

}  // namespace

FitMotion::FitMotion(std::vector<Vec3d> positions, std::span<const Triangle> triangles, double diagonal,
                     const SoundJudge& judge, int threads, Progress* progress)
    : positions_(std::move(positions)),
      triangles_(triangles),
      diagonal_(diagonal),
      threads_(threads),
      progress_(progress),
      judge_(&judge) {}

void FitMotion::soften() {
  stiff_.clear();
  unsound_.clear();
}

void FitMotion::set_marks(std::span<const Vec3d> points, std::vector<FitMark> marks) {
  marks_ = std::move(marks);
  patches_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    double gap = kPatchSize * diagonal_ / kMaxPatchShare;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (k != i) gap = std::min(gap, norm(points[k] - points[i]));
    }
    patches_.push_back(patch_about(points[i], kMaxPatchShare * gap));
  }
}

void FitMotion::set_spacing(double spacing) {
  const BodyPoints body = body_points(positions_, triangles_,
                                      {.inside = kInsideSamples,
                                       .most_spacing = kMaxSampleSpacing * spacing,
                                       .shell_depth = 0.25 * spacing,
                                       .threads = threads_});
  body_ = {};
  body_.points = body.points;
  body_.stiffness.assign(body_.points.size(), kSurfaceStiffness);
  std::fill_n(body_.stiffness.begin(), body.inside, 1.0);
  if (grows_) {
    body_.growth.assign(body_.points.size(), growth_);
    body_.growth_weight = growth_ != 0 ? kWantedGrowthWeight : kFreeGrowthWeight;
  }
  before_.clear();
  lattice_ = {body_.points.front(), spacing};
  for (std::size_t i = 0; i < body_.points.size() && !stiff_.empty(); ++i) {
    if (is_stiff(body_.points[i])) body_.stiffness[i] *= kStiffFactor;
  }
}

bool FitMotion::is_stiff(const Vec3d& at) const {
  const double radius = kStiffRadius * lattice_.spacing;
  return std::any_of(stiff_.begin(), stiff_.end(),
                     [&](std::uint32_t v) { return norm2(positions_[v] - at) < radius * radius; });
}

std::vector<Vec3d> FitMotion::marks_at() const {
  std::vector<Vec3d> at;
  at.reserve(patches_.size());
  for (const std::vector<Vec3d>& patch : patches_) at.push_back(patch.front());
  return at;
}

double FitMotion::miss() const {
  double greatest = 0;
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    greatest = std::max(greatest, norm(patches_[i].front() - marks_[i].place) - marks_[i].tolerance);
  }
  return greatest;
}

// Gives more weight to a landmark that is about to leave its tolerance.
double FitMotion::weight_of(std::size_t mark, const Vec3d& at) const {
  const double tolerance = marks_[mark].tolerance;
  if (!(tolerance > 0)) return 1;
  const double soft = tolerance / (kSoftTolerance * diagonal_);
  const double part = norm(at - marks_[mark].place) / tolerance;
  const double urgent = std::clamp((part - kUrgentShare) / (1 - kUrgentShare), 0.0, 1.0);
  return std::max(1 / (1 + soft * soft), kUrgentWeight * urgent);
}

void FitMotion::move(const Flow& flow, std::vector<Vec3d>& points, Progress* progress) const {
  AdvectOptions options;
  options.tolerance = absolute_tolerance(kDefaultRelativeTolerance, diagonal_);
  options.threads = threads_;
  options.progress = progress;
  if (advect(flow, points, options).status == AdvectStatus::cancelled) throw Cancelled();
}

PotentialGrid FitMotion::solve(std::span<const Vec3d> to, std::vector<VelocityRows> rows) {
  stop_if_cancelled(progress_);
  const std::size_t others = rows.size();
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const std::vector<Vec3d>& patch = patches_[i];
    const double weight = kMarkWeight * weight_of(i, patch.front()) / static_cast<double>(patch.size());
    rows.push_back({patch, std::vector<Vec3d>(patch.size(), to[i] - patch.front()), weight, true});
  }
  std::vector<Vec3d> before = before_;
  find_surroundings(body_, before, rows, lattice_.spacing);
  const NearRigidSystem system(lattice_, body_, rows, threads_, progress_);
  unknowns_ = std::max(unknowns_, system.unknowns());
  PotentialGrid grid = system.solve(rows);
  for (int round = 0; round < kCorrections && !patches_.empty(); ++round) {
    std::vector<Vec3d> arrived = marks_at();
    move(flow_of(grid), arrived, nullptr);
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      if (marks_[i].tolerance > kMaxExactTolerance * diagonal_) continue;
      Vec3d miss = to[i] - arrived[i];
      const double max_miss = kMaxCorrection * lattice_.spacing;
      if (norm(miss) > max_miss) miss *= max_miss / norm(miss);
      for (Vec3d& wanted : rows[others + i].wanted) wanted += miss;
    }
    grid = system.solve(rows);
  }
  return grid;
}

std::string FitMotion::take(PotentialGrid grid) {
  const Flow flow = flow_of(grid);
  std::vector<Vec3d> next = positions_;
  move(flow, next, progress_);
  StepProblem problem = judge_->problem_of(positions_, next, max_stretch_);
  unsound_.insert(unsound_.end(), problem.where.begin(), problem.where.end());
  if (!problem.text.empty()) {
    if (progress_ != nullptr) progress_->total += positions_.size();
    return std::move(problem.text);
  }
  positions_ = std::move(next);
  before_ = body_.points;
  move_others(flow);
  grids_.push_back(std::move(grid));
  return {};
}

// Grows by v = rate (x - middle) + shift, where the middle moves evenly.
bool FitMotion::grow(double factor, const Vec3d& from, const Vec3d& to) {
  double longest = 0;
  for (const Vec3d& p : positions_) longest = std::max(longest, norm(to + (p - from) * factor - p));
  const auto steps = std::clamp(static_cast<std::size_t>(std::ceil(longest / (kMaxGrowthStep * diagonal_))),
                                std::size_t{1}, kMaxGrowthSteps);
  const double rate = elementary::log(factor) / static_cast<double>(steps);
  const Vec3d shift = (to - from) / static_cast<double>(steps);
  growth_ = 3 * rate;
  for (std::size_t i = 0; i < steps; ++i) {
    const Vec3d middle = from + shift * (static_cast<double>(i) + 0.5);
    const auto velocity = [&](const Vec3d& p) { return (p - middle) * rate + shift; };
    set_spacing(kGrowthSpacing * diagonal_);
    std::vector<VelocityRows> rows;
    for (const std::uint32_t k : spread_points(positions_, kGrowthRows)) {
      rows.push_back({{positions_[k]}, {velocity(positions_[k])}, 1});
    }
    std::vector<Vec3d> places = marks_at();
    for (Vec3d& p : places) p += velocity(p);
    if (!take(solve(places, std::move(rows))).empty()) return false;
  }
  growth_ = 0;
  return true;
}

void FitMotion::carry(const Flow& flow) {
  move(flow, positions_, progress_);
  move_others(flow);
}

void FitMotion::move_others(const Flow& flow) {
  move(flow, body_.points, nullptr);
  move(flow, followers_, nullptr);
  move(flow, guides_, nullptr);
  for (std::vector<Vec3d>& patch : patches_) move(flow, patch, nullptr);
}

}  // namespace knead::detail
