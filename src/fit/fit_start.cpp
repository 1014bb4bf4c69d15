// The start of a fit: what it needs, the size, alignment and growth of the source, and the map.
#include "fit/fitter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fit/coarse_body.h"
#include "fit/fit_align.h"
#include "fit/fit_tips.h"
#include "fit/functional_map.h"
#include "knead/editor/tools.h"
#include "math/elementary.h"
#include "mesh/body_points.h"

namespace knead::detail {

using namespace detail;

namespace {

constexpr double kMaxPairError = 0.05;  // of the diagonal: of landmarks from what vertices of the same number say
constexpr std::size_t kAlignSamples = 400;
constexpr std::size_t kTipNodes = 250;
constexpr std::size_t kTipSamples = 1500;
constexpr double kMaxAlignRatio = 0.6;    // automatic alignment needs a distance below this fraction of the one before
constexpr double kMinAlignOffset = 0.05;  // and a distance before above this fraction of the diagonal

}  // namespace

Fitter::Fitter(const Mesh& source, const Mesh& target, const BodyFitOptions& options)
    : source_(source),
      target_(target),
      options_(options),
      triangles_(triangulate(source)),
      target_triangles_(triangulate(target)),
      rest_(source.positions),
      landmarks_(options.landmarks),
      map_(options.map) {
  require(!source.positions.empty() && !target.positions.empty(), "a shape without vertices cannot be fitted");
  if (options.surface) {
    require(!triangles_.empty() && !target_triangles_.empty(),
            "a shape without faces has no surface to fit; fit landmarks alone");
    require(measure_volume_and_area(source, source.positions).area > 0 &&
                measure_volume_and_area(target, target.positions).area > 0,
            "a shape whose faces have no area has no surface to fit; fit landmarks alone");
  }
  if (turn_outward(target, target_triangles_, options.threads)) {
    report_.notes.emplace_back("the target's faces look inward and are turned");
  }
  if (turn_outward(source, triangles_, options.threads)) report_.notes.emplace_back("the source's faces look inward");
  if (options.volume == FitVolume::total) scale();
  report_.volume_difference =
      relative(volume_of(target, target.positions, options.threads), volume_of(source, rest_, options.threads));
  diagonal_ = shape_box(source, rest_).diagonal();
  require(diagonal_ > 1e-15 && diagonal_ < 1e18,
          fmt::format("the source is {:.3g} long; scale it to between 1e-15 and 1e18", diagonal_));
  if (options.align == FitAlign::never && landmarks_.empty()) require_near(shape_box(source, rest_), shape_box(target));
  require_apart(landmarks_, diagonal_);
  for (const auto& pairs : {landmarks_, map_}) require_no_mirror(pairs, diagonal_);
  crossings_before_ = crossings_of(rest_);
  judge_.emplace(rest_, triangles_, max_new_crossings(), options.threads, options.progress);
  motion_ = std::make_unique<FitMotion>(rest_, triangles_, diagonal_, *judge_, options.threads, options.progress);
  if (options.volume == FitVolume::free) motion_->let_grow();
  set_marks();
  pair_vertices();
  set_map();
  target_tree_ = std::make_unique<SurfaceTree>(tree_of({target.positions, target_triangles_}));
}

void Fitter::set_marks() {
  std::vector<Vec3d> points;
  std::vector<FitMark> marks;
  for (const FitPair& pair : landmarks_) {
    points.push_back(pair.source);
    marks.push_back({pair.target, pair.tolerance});
  }
  motion_->set_marks(points, std::move(marks));
}

void Fitter::set_map() {
  std::vector<Vec3d> points;
  for (const FitPair& pair : map_) points.push_back(pair.source);
  motion_->set_followers(std::move(points));
}

// Takes vertices of the same number as pairs where both shapes have the same faces, unless landmarks, a great stretch
// or a volume that has to stay say otherwise.
void Fitter::pair_vertices() {
  const std::vector<Vec3d>& to = target_.positions;
  if (!options_.surface || !map_.empty() || triangles_ != target_triangles_ || rest_.size() != to.size()) return;
  if (must_volume_differ()) return;
  const double stretch_99 = surface_stretch(triangles_, rest_, to).percentile_99;
  if (stretch_99 > options_.max_stretch) return;
  const SurfaceTree vertices = tree_of({rest_, {}});
  for (const FitPair& pair : landmarks_) {
    const std::size_t i = vertices.closest(pair.source)->triangle;
    if (norm(to[i] - rest_[i] - (pair.target - pair.source)) > kMaxPairError * diagonal_) return;
  }
  pairs_vertices_ = true;
  pairs_stretch_99_ = stretch_99;
  for (const std::uint32_t i : spread_points(rest_, kMaxMapAnchors)) map_.push_back({rest_[i], to[i]});
  report_.notes.emplace_back("both shapes have the same faces: vertices of the same number are pairs");
}

void Fitter::scale() {
  const std::optional<double> from = volume_of(source_, rest_, options_.threads);
  const std::optional<double> to = volume_of(target_, target_.positions, options_.threads);
  require(from && to && *from > 0 && *to > 0,
          "scaling needs the volume of both shapes, and one is not closed; leave it out");
  report_.scale = elementary::cbrt(*to / *from);
  const Vec3d middle = shape_box(source_).center();
  const auto scaled = [&](const Vec3d& p) { return middle + (p - middle) * report_.scale; };
  for (Vec3d& p : rest_) p = scaled(p);
  for (FitPair& pair : landmarks_) pair.source = scaled(pair.source);
  for (FitPair& pair : map_) pair.source = scaled(pair.source);
}

void Fitter::apply(const std::vector<Stroke>& strokes) {
  for (const Stroke& stroke : strokes) {
    motion_->carry(flow_of(stroke));
    strokes_.push_back(stroke);
  }
}

void Fitter::align() {
  if (options_.align == FitAlign::never) return;
  const bool always = options_.align == FitAlign::always;
  std::optional<RigidMap> map;
  const std::vector<FitPair>& pairs = landmarks_.size() >= 3 ? landmarks_ : map_;
  if (pairs.size() >= 3) {
    map = align_pairs(pairs);
    std::vector<Vec3d> from;
    std::vector<Vec3d> to;
    for (const FitPair& pair : pairs) {
      from.push_back(pair.source);
      to.push_back(pair.target);
    }
    const double before = rms_of({}, from, to);
    const bool is_nearer = before > kMinAlignOffset * diagonal_ && rms_of(*map, from, to) < kMaxAlignRatio * before;
    if (!always && !is_nearer) return;
  } else if (!triangles_.empty() && !target_triangles_.empty()) {
    const SurfaceSamples of_source(triangles_, rest_, kAlignSamples);
    const SurfaceSamples of_target(target_triangles_, target_.positions, kAlignSamples);
    const SurfaceAlignment found =
        align_surfaces(of_source.at(triangles_, rest_), of_target.at(target_triangles_, target_.positions), diagonal_);
    if (!always && !(found.distance < kMaxAlignRatio * found.distance_before)) return;
    map = found.map;
  }
  if (!map) return;
  const Box box = shape_box(source_, rest_);
  double radius = 0;
  for (const Vec3d& p : rest_) radius = std::max(radius, norm(p - box.center()));
  for (const Vec3d& p : motion_->marks_at()) radius = std::max(radius, norm(p - box.center()));
  apply(strokes_of(*map, box.center(), radius));
  report_.is_aligned = !strokes_.empty();
  if (report_.is_aligned) {
    const double sine = std::min(1.0, norm(map->turn.v));
    const double angle = 2 * elementary::atan2(sine, std::sqrt(1 - sine * sine)) * 180 / std::numbers::pi;
    report_.notes.push_back(fmt::format("the source is first turned by {:.0f} degrees and moved by {:.2g} of its size",
                                        angle, norm((*map)(box.center()) - box.center()) / diagonal_));
  }
}

// Lets the source grow as a whole if this brings it nearer: people differ in size before they differ in build.
bool Fitter::grow() {
  std::optional<Growth> growth;
  if (landmarks_.size() >= 3 || map_.size() >= 3) {
    std::vector<FitPair> pairs = landmarks_.size() >= 3 ? landmarks_ : map_;
    const std::vector<Vec3d>& now = landmarks_.size() >= 3 ? motion_->marks_at() : motion_->followers();
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].source = now[i];
    growth = growth_of(pairs);
  } else if (!triangles_.empty() && !target_triangles_.empty()) {
    const double more = 1 + report_.volume_difference.value_or(0);
    growth = growth_of(
        SurfaceSamples(triangles_, rest_, kAlignSamples).at(triangles_, motion_->positions()),
        SurfaceSamples(target_triangles_, target_.positions, kAlignSamples).at(target_triangles_, target_.positions),
        elementary::cbrt(std::max(more, 1e-3)), diagonal_);
  }
  if (!growth) return false;
  growth_ = growth->factor;
  return motion_->grow(growth->factor, growth->from, growth->to);
}

// Keeps the growth if it helps: pairs decide this; without them, the surfaces are matched a little from both starts.
void Fitter::grow_if_nearer() {
  const FitMotion plain = *motion_;
  if (!grow()) {
    *motion_ = plain;
    return;
  }
  if (landmarks_.size() < 3 && map_.size() < 3) {
    const FitMotion grown = *motion_;
    const Surfaces surfaces(*this);
    const auto distance_from = [&](const FitMotion& start) {
      *motion_ = start;
      match_level(kGrowthTrial, surfaces);
      return distance(kDistanceSamples).mean;
    };
    const bool is_nearer = distance_from(grown) < distance_from(plain);
    *motion_ = is_nearer ? grown : plain;
    if (!is_nearer) return;
  }
  report_.notes.push_back(fmt::format("the source first grows as a whole by a factor of {:.3g}", growth_));
}

// Finds a map by the surfaces' eigenfunctions, from the landmarks or from ends of limbs. Of these the set counts whose
// map is best: others are mirror images, or have a leg for an arm. Returns false if there is no good map.
bool Fitter::find_map() {
  std::vector<std::vector<FitPair>> sets{landmarks_};
  if (landmarks_.empty()) {
    sets = tip_sets({rest_, triangles_, kTipNodes}, {target_.positions, target_triangles_, kTipNodes}, diagonal_);
  }
  if (sets.empty() || sets.front().size() < 3) return false;
  const auto source = spectral_surface(rest_, triangles_, options_.progress);
  if (!source) return false;
  const auto target = spectral_surface(target_.positions, target_triangles_, options_.progress);
  if (!target) return false;
  const auto map_from = [&](const std::vector<FitPair>& seeds, bool sketches) {
    return functional_map(*source, *target, seeds, sketches, options_.threads, options_.progress);
  };
  std::size_t best = 0;
  double quality = kMinMapQuality;
  for (std::size_t i = 0; i < sets.size() && sets.size() > 1; ++i) {
    const double own = map_from(sets[i], true).quality;
    best = own > quality ? i : best;
    quality = std::max(quality, own);
  }
  map_ = map_from(sets[best], false).pairs;
  return !map_.empty();
}

// Uses ends of limbs as landmarks until the surfaces are matched, if no pairs are given.
void Fitter::find_tips() {
  const std::vector<SurfaceSample> of_source =
      SurfaceSamples(triangles_, rest_, kTipSamples).at(triangles_, motion_->positions());
  const std::vector<SurfaceSample> of_target =
      SurfaceSamples(target_triangles_, target_.positions, kTipSamples).at(target_triangles_, target_.positions);
  const CoarseBody source(motion_->positions(), triangles_, kTipNodes);
  const CoarseBody target(target_.positions, target_triangles_, kTipNodes);
  const auto pairs = match_tips({source, of_source}, {target, of_target}, diagonal_, options_.progress);
  if (!pairs) return;
  tips_ = pairs->size();
  landmarks_ = *pairs;
  set_marks();
  go_to_landmarks();
  landmarks_.clear();
  set_marks();
}

}  // namespace knead::detail
