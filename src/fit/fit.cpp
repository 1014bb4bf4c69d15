// fit_body(): runs the stages of a fit, and keeps the best result.
#include "knead/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "fit/fit_align.h"
#include "fit/fit_report.h"
#include "fit/fitter.h"
#include "knead/editor/tools.h"
#include "knead/mesh.h"

namespace knead {

namespace detail {

using namespace detail;

namespace {

constexpr std::size_t kMaxSeeds = 100;         // landmarks from which a map is found; with more none is needed
constexpr double kMaxFittedDistance = 2.5e-3;  // of the diagonal: surfaces that are farther apart need a map
constexpr std::size_t kGrowthSamples = 400;    // vertices at which det J is measured

}  // namespace

BodyFit Fitter::run() {
  Progress* const progress = options_.progress;
  if (progress != nullptr) {
    progress->total = fit_work(source_, options_);
    progress->done = 0;
  }
  report_.crossings_before = crossings_before_.count;
  report_.before = distance(0);
  const FitMotion start = *motion_;
  attempt();
  if (!best_->is_sound || best_->distance > kMaxFittedDistance) attempt_with_map(start);
  BodyFit fit;
  finish(fit);
  if (progress != nullptr) progress->done = progress->total.load();
  return fit;
}

// Fits from the start, and sets the best result.
void Fitter::attempt() {
  align();
  if (options_.volume == FitVolume::free) grow_if_nearer();
  if (!landmarks_.empty() || !map_.empty()) {
    SoundReach reach = go_to_landmarks();
    report_.reached = reach.time;
    report_.obstacle = std::move(reach.problem);
  } else if (options_.surface && !options_.partial) {
    find_tips();
  }
  Result landmarks = look("landmarks");
  report_.after_landmarks = landmarks.distance;
  keep_better(std::move(landmarks));
  if (options_.surface) match_surfaces();
}

// Fits again from a map that is found, and keeps the better result of both.
void Fitter::attempt_with_map(const FitMotion& start) {
  const bool is_wanted = options_.surface && map_.empty() && landmarks_.size() <= kMaxSeeds;
  if (!is_wanted || !report_.volume_difference || !find_map()) return;
  if (options_.progress != nullptr) options_.progress->total += options_.progress->done.load();
  Result before = std::move(*best_);
  BodyFitReport report = report_;
  std::vector<Stroke> strokes = std::exchange(strokes_, {});
  const std::size_t tips = std::exchange(tips_, 0);
  best_.reset();
  report_.notes.push_back(fmt::format("a map of {} pairs was found", map_.size()));
  *motion_ = start;
  set_map();
  max_path_stretch_ = 1;
  attempt();
  const Result with_map = *best_;
  keep_better(std::move(before));
  if (best_->distance == with_map.distance) return;
  report_ = std::move(report);
  strokes_ = std::move(strokes);
  tips_ = tips;
  map_.clear();
}

SelfIntersections Fitter::crossings_of(std::span<const Vec3d> positions) const {
  if (triangles_.empty()) return {};
  return self_intersections(triangles_, positions, {.threads = options_.threads, .progress = options_.progress});
}

Fitter::Result Fitter::look(std::string stage) const {
  Result result{*motion_, 0, 1, 1, 0, 0, false, std::move(stage)};
  const std::vector<Vec3d>& positions = motion_->positions();
  result.distance = distance(kDistanceSamples).mean;
  const SurfaceStretch stretch = surface_stretch(triangles_, rest_, positions);
  result.stretch = stretch.worst();
  result.stretch_99 = stretch.percentile_99;
  const SelfIntersections crossings = crossings_of(positions);
  result.crossings = crossings.count;
  result.crossings_new = count_new(crossings, crossings_before_);
  const bool is_clean = max_new_crossings() == 0
                            ? result.crossings_new == 0
                            : judge_->crossing_of(positions, std::vector<bool>(triangles_.size(), true)).text.empty();
  result.is_sound = is_clean && result.stretch <= options_.max_stretch;
  return result;
}

// Keeps the better result: a sound one before others, then the nearer one.
void Fitter::keep_better(Result result) {
  const bool is_better = !best_ || (result.is_sound && !best_->is_sound) ||
                         (result.is_sound == best_->is_sound && result.distance < best_->distance);
  if (is_better) best_ = std::move(result);
}

// Measures an open target, and what both shapes have, without what the other one lacks.
void Fitter::measure_covered() {
  if (!options_.surface || (!options_.partial && volume_of(target_, target_.positions, options_.threads))) return;
  const Measuring measuring{diagonal_, 0, options_.threads, options_.progress};
  report_.after_covered = mean_distance(target_.positions, tree_of({motion_->positions(), triangles_}), measuring);
  if (!options_.partial) return;
  report_.after_covered =
      std::min(*report_.after_covered, mean_distance(motion_->positions(), *target_tree_, measuring));
}

void Fitter::finish(BodyFit& fit) {
  *motion_ = best_->motion;
  exactly_to_landmarks();
  const Result last = look(best_->stage);
  fit.positions = motion_->positions();
  fit.strokes = std::move(strokes_);
  for (const PotentialGrid& grid : motion_->grids()) fit.strokes.emplace_back(GridStroke{grid});
  std::move(last_.begin(), last_.end(), std::back_inserter(fit.strokes));
  report_.stage = last.stage;
  report_.landmarks = landmarks_.size();
  report_.map_pairs = map_.size();  // given or found
  report_.tips = tips_;
  report_.strokes = fit.strokes.size();
  report_.unknowns = motion_->unknowns();
  report_.crossings_after = last.crossings;
  report_.crossings_new = last.crossings_new;
  report_.after = distance(0);
  measure_covered();
  const SurfaceStretch stretch = surface_stretch(triangles_, rest_, fit.positions);
  report_.greatest_stretch = stretch.worst();
  report_.stretch_99 = stretch.percentile_99;
  report_.rms_log_stretch = stretch.rms_log;
  const int threads = options_.threads;
  report_.volume_error = relative(volume_of(source_, fit.positions, threads), volume_of(source_, rest_, threads));
  if (options_.volume == FitVolume::free) {
    const auto [low, high] = growth_range(fit.strokes, rest_, {diagonal_, kGrowthSamples, threads, options_.progress});
    report_.det_least = low;
    report_.det_greatest = high;
  }
  report_.landmark_excess = std::max(0.0, motion_->miss()) / diagonal_;
  add_landmarks(motion_->marks_at(), landmarks_, diagonal_, report_);
  report_.map_distance = median_distance(motion_->followers(), map_) / diagonal_;
  if (must_volume_differ()) {
    report_.notes.push_back(
        fmt::format("the target's volume is {:+.0f}%, and that of the source stays, so flesh gathers or is missing "
                    "somewhere; let the "
                    "volume change (free)",
                    100 * *report_.volume_difference));
  }
  report_.is_sound = complaint_about(report_, options_).empty();
  fit.report = std::move(report_);
}

}  // namespace detail

std::uint64_t fit_work(const Mesh& source, const BodyFitOptions& options) {
  std::size_t steps = options.landmarks.empty() && options.map.empty() ? 2 : 30;
  for (const detail::Level& level : detail::kLevels)
    steps += options.surface ? static_cast<std::size_t>(level.rounds) : 0;
  constexpr std::size_t kGrowthSteps = 6;
  if (options.volume == FitVolume::free)
    steps += kGrowthSteps + 2 * static_cast<std::size_t>(detail::kGrowthTrial.rounds);
  return source.vertex_count() * steps;
}

BodyFit fit_body(const Mesh& source, const Mesh& target, const BodyFitOptions& options) {
  validate(source);
  validate(target);
  detail::require_usable(options);
  return detail::Fitter(WeldedMesh(source).mesh(), WeldedMesh(target).mesh(), options).run();
}

}  // namespace knead
