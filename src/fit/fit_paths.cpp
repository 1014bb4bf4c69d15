// Moves landmarks, and pairs of the map, on paths of limbs.
#include "fit/fitter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/coarse_body.h"
#include "fit/fit_align.h"
#include "knead/editor/tools.h"
#include "mesh/body_points.h"

namespace knead::detail {

using namespace detail;

namespace {

constexpr double kPathSpacing = 0.08;  // of the grids, of the diagonal
constexpr std::size_t kMinSteps = 4;
constexpr std::size_t kMaxSteps = 80;
constexpr std::size_t kPathPieces = 24;
constexpr std::size_t kBodyNodes = 600;    // of the coarse body
constexpr double kGuideWeight = 0.3;       // of a node of the coarse body, in the units of surface matches
constexpr double kSoftAnchor = 0.01;       // of the diagonal: the tolerance at which an anchor's weight is half
constexpr double kMapAnchorWeight = 0.02;  // of a pair, relative to a landmark
constexpr std::size_t kMaxMapRows = 600;
constexpr double kMapWeight = 0.4;  // in the units of surface matches

}  // namespace

// The paths of landmarks, of evenly spread pairs of the map, and of the nodes of the coarse body.
struct Fitter::Paths {
  std::vector<std::vector<Vec3d>> all;  // in this order
  std::size_t pairs = 0;                // of the map
};

// Moves landmarks, and evenly spread pairs of the map, on paths on which limbs turn about their joints, as far as this
// is sound. The nodes of the coarse body guide the rest: otherwise a limb whose ends approach each other for a moment
// buckles and stays buckled.
SoundReach Fitter::go_to_landmarks() {
  std::vector<Anchor> anchors;
  const std::vector<Vec3d> at = motion_->marks_at();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const double soft = landmarks_[i].tolerance / (kSoftAnchor * diagonal_);
    anchors.push_back({at[i], landmarks_[i].target, 1 / (1 + soft * soft)});
  }
  const std::vector<Vec3d>& followers = motion_->followers();
  const std::vector<std::uint32_t> chosen = spread_points(followers, kMaxMapAnchors);
  for (const std::uint32_t i : chosen) anchors.push_back({followers[i], map_[i].target, kMapAnchorWeight, true});
  CoarseBody body(motion_->positions(), triangles_, kBodyNodes);
  body.pose(anchors, options_.progress);
  const std::size_t pairs = anchors.size();
  const std::vector<Anchor> nodes = body.node_anchors();
  anchors.insert(anchors.end(), nodes.begin(), nodes.end());
  const Paths paths{body.paths(anchors, kPathPieces), chosen.size()};
  double longest = 0;
  for (std::size_t i = 0; i < pairs; ++i) longest = std::max(longest, length_of_path(paths.all[i]));
  std::vector<Vec3d> guides;
  for (std::size_t i = landmarks_.size(); i < anchors.size(); ++i) guides.push_back(anchors[i].from);
  motion_->set_guides(std::move(guides));
  SoundReach reach = go_along(
      paths,
      std::clamp(static_cast<std::size_t>(std::ceil(longest / (kMaxFitStep * diagonal_))), kMinSteps, kMaxSteps));
  motion_->set_guides({});
  return reach;
}

SoundReach Fitter::go_along(const Paths& paths, std::size_t steps) {
  std::vector<double> times;
  for (std::size_t i = 0; i <= steps; ++i) times.push_back(static_cast<double>(i) / static_cast<double>(steps));
  times.insert(times.end(), 2, 1.0);  // the last steps bring what lags behind to its place
  const double spacing = kPathSpacing * diagonal_;
  motion_->set_spacing(spacing);
  motion_->set_max_stretch(max_path_stretch_ * options_.max_stretch);
  SteppedMotion stepped;
  stepped.solve = [&](double, double to) { return step_to(paths, to); };
  stepped.take = [this](const PotentialGrid& grid) { return motion_->take(grid); };
  stepped.set_spacing = [&](double factor) {
    motion_->stiffen();
    motion_->set_spacing(factor * spacing);
  };
  SoundReach reach = step_soundly(times, stepped);
  motion_->soften();
  return reach;
}

// Returns the grid that moves what follows a path to its place at a time.
PotentialGrid Fitter::step_to(const Paths& paths, double time) {
  std::vector<Vec3d> to;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) to.push_back(place_on(paths.all[i], time));
  std::vector<VelocityRows> rows;
  const std::size_t stride = paths.pairs / kMaxMapRows + 1;
  for (std::size_t k = 0; k < motion_->guides().size(); ++k) {
    const bool is_node = k >= paths.pairs;
    if (!is_node && k % stride != 0) continue;
    const Vec3d& p = motion_->guides()[k];
    const Vec3d by = clipped(place_on(paths.all[landmarks_.size() + k], time) - p, 2 * kMaxFitStep * diagonal_);
    rows.push_back({{p}, {by}, is_node ? kGuideWeight : kMapWeight});
  }
  return motion_->solve(to, std::move(rows));
}

// Moves landmarks exactly to their targets: by a few steps of no duration, then by pins if they are too dense for
// grids.
void Fitter::exactly_to_landmarks() {
  for (int again = 0; again < 3 && motion_->miss() > 0.3 * kFitExact * diagonal_; ++again) {
    std::vector<Vec3d> to;
    for (const FitMark& mark : motion_->marks()) to.push_back(mark.place);
    if (!motion_->take(motion_->solve(to, {})).empty()) return;
  }
  if (motion_->miss() <= kFitExact * diagonal_) return;
  const FitMotion before = *motion_;
  PinsStroke pins;
  pins.points = motion_->marks_at();
  for (const FitMark& mark : motion_->marks()) pins.to.push_back(mark.place);
  pins.radius_auto = true;
  std::string problem;
  try {
    motion_->carry(flow_of(pins));
    problem = judge_->problem_of(before.positions(), motion_->positions(), kMaxPathStretch * options_.max_stretch).text;
  } catch (const InvalidInput& error) {
    problem = error.what();
  }
  if (!problem.empty()) {
    *motion_ = before;
    return;
  }
  last_.emplace_back(std::move(pins));
}

}  // namespace knead::detail
