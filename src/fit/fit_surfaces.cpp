// Matches the surfaces, level by level.
#include "fit/fitter.h"

#include <algorithm>
#include <utility>

#include "knead/fit.h"

namespace knead::detail {

using namespace detail;

namespace {

constexpr double kNormalShare = 0.8;  // of a match's displacement, along the target's normal, that a step covers
constexpr double kTangentShare = 0.4;
constexpr double kMaxStretch99 = 2.5;     // the stretch of 99% of the triangles after matching
constexpr double kMinSpacingEdges = 1.5;  // the finest spacing, in mean edges
constexpr double kMinDistance = 5e-5;     // of the diagonal: matching ends at this median distance along normals
constexpr int kMaxFailedRounds = 2;       // of a level

}  // namespace

// Runs the rounds of a level as far as they are sound. Where a step is not, the body gets stiff and asks for no
// matches. Returns true if the surfaces are still apart. Throws InvalidInput if the level is too fine for the shape.
bool Fitter::match_level(const Level& level, const Surfaces& surfaces) {
  const SurfaceSamples asking(triangles_, rest_, level.samples);
  const SurfaceSamples of_target(target_triangles_, target_.positions, level.samples);
  const std::vector<SurfaceSample> target_samples = of_target.at(target_triangles_, target_.positions);
  const auto take = [this](const PotentialGrid& grid) { return motion_->take(grid); };
  motion_->set_spacing(level.spacing * diagonal_);
  bool is_apart = true;
  int failures = 0;
  for (int round = 0; round < level.rounds && is_apart && failures < kMaxFailedRounds; ++round) {
    const double part = static_cast<double>(round) / std::max(1, level.rounds - 1);
    const std::optional<PotentialGrid> grid = match_round(
        level, level.first_weight * (1 - part) + level.last_weight * part, asking, surfaces, target_samples);
    is_apart = grid.has_value();
    const double taken = grid ? take_soundly(*grid, take) : 1;
    if (taken == 1) continue;
    failures += taken == 0 ? 1 : 0;
    motion_->stiffen();
    motion_->set_spacing(level.spacing * diagonal_);
  }
  motion_->soften();
  return is_apart;
}

void Fitter::match_surfaces() {
  const Surfaces surfaces(*this);
  motion_->set_max_stretch(std::max(options_.max_stretch, best_->stretch));
  const double edge = mean_edge(triangles_, rest_);
  const double stretch_99 = std::max(best_->stretch_99, pairs_stretch_99_);
  for (const Level& level : kLevels) {
    if (&level != &kLevels[0] && level.spacing * diagonal_ < kMinSpacingEdges * edge) return;
    bool goes_on = true;
    try {
      goes_on = match_level(level, surfaces);
    } catch (const InvalidInput&) {
      return;  // too fine for the shape: the level before is the last
    }
    Result now = look("surface");
    if (now.stretch_99 > std::max(kMaxStretch99, stretch_99)) return;
    keep_better(std::move(now));
    if (!goes_on) return;
  }
}

Matches Fitter::matches_of(const Level& level, const SurfaceSamples& asking, const Surfaces& surfaces,
                           const std::vector<SurfaceSample>& of_target) const {
  const std::vector<Vec3d>& positions = motion_->positions();
  const std::vector<SurfaceSample> from = asking.at(triangles_, positions);
  if (pairs_vertices_) return match_in_order(from, asking.at(triangles_, target_.positions));
  const SampleTree source(surfaces.candidates.at(triangles_, positions), kNormalLength * diagonal_);
  const MatchOptions options{kNormalLength * diagonal_, level.spacing * diagonal_, surfaces.source_border,
                             surfaces.target_border, options_.threads};
  return match(source, from, surfaces.target, of_target, options);
}

// Returns the grid that covers the distance between the surfaces; nothing if they are as near as matching can bring
// them.
std::optional<PotentialGrid> Fitter::match_round(const Level& level, double weight, const SurfaceSamples& asking,
                                                 const Surfaces& surfaces,
                                                 const std::vector<SurfaceSample>& of_target) {
  const Matches matches = matches_of(level, asking, surfaces, of_target);
  if (options_.partial) report_.matched = matches.matched;
  if (matches.median_along < kMinDistance * diagonal_) return std::nullopt;
  std::vector<VelocityRows> rows;
  for (const Match& m : matches.all) {
    if (motion_->is_stiff(m.at)) continue;
    const Vec3d along = m.normal * dot(m.normal, m.by);
    const Vec3d by = clipped(along * kNormalShare + (m.by - along) * kTangentShare, kMaxFitStep * diagonal_);
    rows.push_back({{m.at}, {by}, weight * m.weight});
  }
  std::vector<Vec3d> to;
  const std::vector<Vec3d> at = motion_->marks_at();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    to.push_back(at[i] + clipped(landmarks_[i].target - at[i], kMaxFitStep * diagonal_));
  }
  return motion_->solve(to, std::move(rows));
}

}  // namespace knead::detail
