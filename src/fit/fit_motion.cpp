#include "fit/fit_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/elementary.h"
#include "mesh/body_points.h"
#include "pose/pose_motion.h"

namespace knead::fit_detail {

namespace {

using namespace detail;

constexpr double kPatch = 0.025;         // size of a landmark's patch, of the diagonal
constexpr double kPatchOfGap = 0.35;     // of the distance to the next landmark: an upper bound
constexpr double kWeightOfMark = 600;    // by the number of a patch's points
constexpr double kSoft = 5e-4;           // of the diagonal: a tolerance at which a landmark's weight is half
constexpr double kNearlyOut = 0.8;       // of a tolerance: from here on a landmark gains weight, up to
constexpr double kUrgent = 0.1;          // of an exact landmark's
constexpr int kCorrections = 2;          // of the wanted velocities, by where the landmarks arrive
constexpr double kMaxCorrection = 0.25;  // of the spacing
constexpr std::size_t kInside = 3000;
constexpr double kCellsOfSample = 0.4;  // the samples' greatest spacing, in that of the grid
constexpr double kSurfaceStiffness = 20;
constexpr double kGrowthWeight = 0.1;    // of div v where volumes may change, beside the rest of the strain
constexpr double kGrowthSpacing = 0.08;  // of the diagonal, while the whole shape grows
constexpr double kGrowthStep = 0.04;     // of the diagonal: what a point moves in a step then
constexpr std::size_t kMaxGrowthSteps = 80;
constexpr std::size_t kGrowthRows = 300;
constexpr double kAllOfStrain = 1.0 / 3;  // the same where growth is asked for
constexpr double kStiff = 30;             // times as stiff, near vertices that crossed: nearer than
constexpr double kStiffReach = 0.5;       // spacings
constexpr double kExact = 1e-4;           // of the diagonal: smaller tolerances are met within each step

Flow flow_of(const PotentialGrid& grid) {
  Segment segment;
  segment.grid = grid;
  return {{std::move(segment)}};
}

}  // namespace

FitMotion::FitMotion(std::vector<Vec3d> positions, std::span<const Triangle> triangles, double diagonal, int threads,
                     Progress* progress)
    : positions_(std::move(positions)),
      triangles_(triangles),
      diagonal_(diagonal),
      threads_(threads),
      progress_(progress) {}

void FitMotion::set_marks(std::span<const Vec3d> points, std::vector<FitMark> marks) {
  marks_ = std::move(marks);
  patches_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    double gap = kPatch * diagonal_ / kPatchOfGap;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (k != i) gap = std::min(gap, norm(points[k] - points[i]));
    }
    patches_.push_back(patch_about(points[i], kPatchOfGap * gap));
  }
}

void FitMotion::set_spacing(double spacing) {
  const BodyPoints body = body_points(positions_, triangles_,
                                      {.inside = kInside,
                                       .most_spacing = kCellsOfSample * spacing,
                                       .shell_depth = 0.25 * spacing,
                                       .threads = threads_});
  body_ = {};
  body_.points = body.points;
  body_.stiffness.assign(body_.points.size(), kSurfaceStiffness);
  std::fill_n(body_.stiffness.begin(), body.inside, 1.0);
  if (grows_) {
    body_.growth.assign(body_.points.size(), growth_);
    body_.growth_weight = growth_ != 0 ? kAllOfStrain : kGrowthWeight;
  }
  before_.clear();
  lattice_ = {body_.points.front(), spacing};
  for (std::size_t i = 0; i < body_.points.size() && !stiff_.empty(); ++i) {
    if (is_stiff(body_.points[i])) body_.stiffness[i] *= kStiff;
  }
}

bool FitMotion::is_stiff(const Vec3d& at) const {
  const double reach = kStiffReach * lattice_.spacing;
  return std::any_of(stiff_.begin(), stiff_.end(),
                     [&](std::uint32_t v) { return norm2(positions_[v] - at) < reach * reach; });
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

// A landmark that is about to leave its tolerance is held more firmly.
double FitMotion::weight_of(std::size_t mark, const Vec3d& at) const {
  const double tolerance = marks_[mark].tolerance;
  if (!(tolerance > 0)) return 1;
  const double soft = tolerance / (kSoft * diagonal_);
  const double part = norm(at - marks_[mark].place) / tolerance;
  const double urgent = std::clamp((part - kNearlyOut) / (1 - kNearlyOut), 0.0, 1.0);
  return std::max(1 / (1 + soft * soft), kUrgent * urgent);
}

void FitMotion::move(const Flow& flow, std::vector<Vec3d>& points, Progress* progress) const {
  AdvectOptions options;
  options.tolerance = absolute_tolerance(kDefaultRelativeTolerance, diagonal_);
  options.threads = threads_;
  options.progress = progress;
  if (advect(flow, points, options).status == AdvectStatus::cancelled) throw Cancelled();
}

void FitMotion::step(std::span<const Vec3d> to, std::vector<VelocityRows> rows) {
  stop_if_cancelled(progress_);
  const std::size_t others = rows.size();
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const std::vector<Vec3d>& patch = patches_[i];
    const double weight = kWeightOfMark * weight_of(i, patch.front()) / static_cast<double>(patch.size());
    rows.push_back({patch, std::vector<Vec3d>(patch.size(), to[i] - patch.front()), weight, true});
  }
  find_surroundings(body_, before_, rows, lattice_.spacing);
  const NearRigidSystem system(lattice_, body_, rows, threads_, progress_);
  unknowns_ = std::max(unknowns_, system.unknowns());
  PotentialGrid grid = system.solve(rows);
  for (int round = 0; round < kCorrections && !patches_.empty(); ++round) {
    std::vector<Vec3d> arrived = marks_at();
    move(flow_of(grid), arrived, nullptr);
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      if (marks_[i].tolerance > kExact * diagonal_) continue;
      Vec3d miss = to[i] - arrived[i];
      const double most = kMaxCorrection * lattice_.spacing;
      if (norm(miss) > most) miss *= most / norm(miss);
      for (Vec3d& wanted : rows[others + i].wanted) wanted += miss;
    }
    grid = system.solve(rows);
  }
  carry(flow_of(grid));
  grids_.push_back(std::move(grid));
}

// v = rate (x - middle) + shift, where the middle moves evenly.
void FitMotion::grow(double factor, const Vec3d& from, const Vec3d& to) {
  double longest = 0;
  for (const Vec3d& p : positions_) longest = std::max(longest, norm(to + (p - from) * factor - p));
  const auto steps = std::clamp(static_cast<std::size_t>(std::ceil(longest / (kGrowthStep * diagonal_))),
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
    step(places, std::move(rows));
  }
  growth_ = 0;
}

void FitMotion::carry(const Flow& flow) {
  move(flow, positions_, progress_);
  move(flow, body_.points, nullptr);
  move(flow, followers_, nullptr);
  move(flow, guides_, nullptr);
  for (std::vector<Vec3d>& patch : patches_) move(flow, patch, nullptr);
}

}  // namespace knead::fit_detail
