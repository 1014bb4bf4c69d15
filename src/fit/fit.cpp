// fit_body(): aligns, moves landmarks along paths of limbs, matches the surfaces, and keeps the best stage.
#include "knead/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "fit/coarse_body.h"
#include "fit/fit_align.h"
#include "fit/fit_motion.h"
#include "fit/fit_report.h"
#include "fit/fit_tips.h"
#include "fit/functional_map.h"
#include "fit/surface_matches.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "math/elementary.h"
#include "mesh/body_points.h"
#include "pose/sound_steps.h"

namespace knead {
namespace {

using namespace fit_detail;
using namespace detail;

// Landmarks:
constexpr double kMaxStep = 0.03;      // of the diagonal: the greatest motion in a step
constexpr double kPathSpacing = 0.08;  // of the grids, of the diagonal
constexpr std::size_t kMinSteps = 4;
constexpr std::size_t kMaxSteps = 80;
constexpr std::size_t kPathPieces = 24;
constexpr std::size_t kBodyNodes = 600;  // of the coarse body
constexpr double kGuideWeight = 0.3;     // of a node of the coarse body, in the units of surface matches
constexpr double kSoftTolerance = 0.01;  // of the diagonal: the tolerance at which an anchor's weight is half
// The map:
constexpr double kMapAnchorWeight = 0.02;  // of a pair, relative to a landmark
constexpr std::size_t kMaxMapAnchors = 1500;
constexpr std::size_t kMaxMapRows = 600;
constexpr double kMaxPairError = 0.05;  // of the diagonal: of landmarks from what vertices of the same number say
constexpr double kMapWeight = 0.4;      // in the units of surface matches
constexpr std::size_t kMaxSeeds = 100;  // landmarks from which a map is found; with more none is needed
constexpr double kMaxFittedDistance = 2.5e-3;  // of the diagonal: surfaces that are farther apart need a map
// The surface:
constexpr double kNormalShare = 0.8;  // of a match's displacement, along the target's normal, that a step covers
constexpr double kTangentShare = 0.4;
constexpr double kMaxStretch99 = 2.5;     // the stretch of 99% of the triangles after matching
constexpr double kMinSpacingEdges = 1.5;  // the finest spacing, in mean edges
constexpr double kMinDistance = 5e-5;     // of the diagonal: matching ends at this median distance along normals
constexpr std::size_t kCandidates = 8000;
constexpr std::size_t kDistanceSamples = 3000;  // vertices of each shape between levels
constexpr std::size_t kAlignSamples = 400;
constexpr std::size_t kGrowthSamples = 400;  // vertices at which det J is measured
constexpr double kMaxPathStretch = 2;        // of a triangle on the way to the landmarks, relative to max_stretch
constexpr double kMaxKeptDifference = 0.03;  // of volumes: with more, a note advises to let them change
constexpr int kMaxFailedRounds = 2;          // of a level
constexpr std::size_t kTipNodes = 250;
constexpr std::size_t kTipSamples = 1500;
constexpr double kMaxAlignRatio = 0.6;    // automatic alignment needs a distance below this fraction of the one before
constexpr double kMinAlignOffset = 0.05;  // and a distance before above this fraction of the diagonal

// A level of the surface stage.
struct Level {
  double spacing;  // of the diagonal
  int rounds;
  double first_weight;  // of a match in the first round
  double last_weight;   // and in the last one
  std::size_t samples;  // of each surface
};
constexpr Level kLevels[] = {{0.1, 8, 0.2, 0.8, 900},
                             {0.085, 6, 0.8, 2, 900},
                             {0.07, 6, 2, 4, 900},
                             {0.05, 6, 4, 6, 1500},
                             {0.035, 4, 6, 6, 3000}};

// The level that decides whether a source that has grown as a whole is the better start.
constexpr Level kGrowthTrial{0.1, 4, 0.2, 0.8, 900};

void require(bool holds, const std::string& what) {
  if (!holds) throw InvalidInput(what);
}

Vec3d clipped(const Vec3d& v, double max_length) {
  const double length = norm(v);
  return length > max_length ? v * (max_length / length) : v;
}

class Fitter {
 public:
  Fitter(const Mesh& source, const Mesh& target, const BodyFitOptions& options);

  BodyFit run();

 private:
  // The result of a stage and its quality.
  struct Result {
    FitMotion motion;
    double distance = 0;
    double stretch = 1;
    double stretch_99 = 1;
    std::size_t crossings = 0;
    std::size_t crossings_new = 0;
    bool is_sound = false;
    std::string stage;
  };

  void set_marks();
  void set_map();
  void pair_vertices();
  void scale();
  void align();
  bool grow();
  void grow_if_nearer();
  void apply(const std::vector<Stroke>& strokes);
  bool find_map();
  void attempt();
  void attempt_with_map(const FitMotion& start);
  void find_tips();
  struct Paths;
  SoundReach go_to_landmarks();
  SoundReach go_along(const Paths& paths, std::size_t steps);
  PotentialGrid step_to(const Paths& paths, double time);
  void exactly_to_landmarks();
  struct Surfaces;
  bool match_level(const Level& level, const Surfaces& surfaces);
  void match_surfaces();
  std::optional<PotentialGrid> match_round(const Level& level, double weight, const SurfaceSamples& asking,
                                           const Surfaces& surfaces, const std::vector<SurfaceSample>& of_target);
  Matches matches_of(const Level& level, const SurfaceSamples& asking, const Surfaces& surfaces,
                     const std::vector<SurfaceSample>& of_target) const;
  Result look(std::string stage) const;
  void keep_better(Result result);
  SelfIntersections crossings_of(std::span<const Vec3d> positions) const;
  std::size_t max_new_crossings() const { return knead::fit_detail::max_new_crossings(crossings_before_.count); }
  // Whether the volume stays although that of the target is another.
  bool must_volume_differ() const {
    return options_.volume == FitVolume::keep && std::abs(report_.volume_difference.value_or(0)) > kMaxKeptDifference;
  }
  void measure_covered();
  void finish(BodyFit& fit);
  // Returns the distance from the target by at most `max_vertices` vertices of each shape; 0: all.
  FitDistance distance(std::size_t max_vertices) const {
    return distance_of({motion_->positions(), triangles_}, {target_.positions, target_triangles_}, *target_tree_,
                       {diagonal_, max_vertices, options_.threads, options_.progress});
  }

  const Mesh& source_;
  const Mesh& target_;
  const BodyFitOptions& options_;
  std::vector<Triangle> triangles_;
  std::vector<Triangle> target_triangles_;
  std::vector<Vec3d> rest_;  // the source, scaled
  std::vector<FitPair> landmarks_;
  std::vector<FitPair> map_;
  bool pairs_vertices_ = false;  // a vertex belongs to that of the same number
  double pairs_stretch_99_ = 0;  // which 99% of the triangles then have at most
  double diagonal_ = 0;
  std::unique_ptr<SurfaceTree> target_tree_;
  SelfIntersections crossings_before_;
  std::optional<SoundJudge> judge_;  // of all steps
  std::unique_ptr<FitMotion> motion_;
  std::vector<Stroke> strokes_;  // before those of the grids
  std::vector<Stroke> last_;     // after them
  std::size_t tips_ = 0;         // used as landmarks
  double max_path_stretch_ = kMaxPathStretch;
  double growth_ = 1;  // the factor by which the source first grows as a whole
  std::optional<Result> best_;
  BodyFitReport report_;
};

// The points of the two surfaces that samples are matched with.
struct Fitter::Surfaces {
  explicit Surfaces(const Fitter& fitter)
      : Surfaces(fitter, {fitter.target_triangles_, fitter.target_.positions, kCandidates}) {}

  SurfaceSamples candidates;
  SampleTree target;
  std::vector<bool> source_border;  // with `partial`: candidates on borders
  std::vector<bool> target_border;

 private:
  Surfaces(const Fitter& fitter, const SurfaceSamples& of_target)
      : candidates(fitter.triangles_, fitter.rest_, kCandidates),
        target(of_target.at(fitter.target_triangles_, fitter.target_.positions), kNormalLength * fitter.diagonal_) {
    if (!fitter.options_.partial) return;
    source_border = candidates.on_border(fitter.triangles_, fitter.rest_);
    target_border = of_target.on_border(fitter.target_triangles_, fitter.target_.positions);
  }
};

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
    const double soft = landmarks_[i].tolerance / (kSoftTolerance * diagonal_);
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
      paths, std::clamp(static_cast<std::size_t>(std::ceil(longest / (kMaxStep * diagonal_))), kMinSteps, kMaxSteps));
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
    const Vec3d by = clipped(place_on(paths.all[landmarks_.size() + k], time) - p, 2 * kMaxStep * diagonal_);
    rows.push_back({{p}, {by}, is_node ? kGuideWeight : kMapWeight});
  }
  return motion_->solve(to, std::move(rows));
}

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
    const Vec3d by = clipped(along * kNormalShare + (m.by - along) * kTangentShare, kMaxStep * diagonal_);
    rows.push_back({{m.at}, {by}, weight * m.weight});
  }
  std::vector<Vec3d> to;
  const std::vector<Vec3d> at = motion_->marks_at();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    to.push_back(at[i] + clipped(landmarks_[i].target - at[i], kMaxStep * diagonal_));
  }
  return motion_->solve(to, std::move(rows));
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

}  // namespace

std::uint64_t fit_work(const Mesh& source, const BodyFitOptions& options) {
  std::size_t steps = options.landmarks.empty() && options.map.empty() ? 2 : 30;
  for (const Level& level : kLevels) steps += options.surface ? static_cast<std::size_t>(level.rounds) : 0;
  constexpr std::size_t kGrowthSteps = 6;
  if (options.volume == FitVolume::free) steps += kGrowthSteps + 2 * static_cast<std::size_t>(kGrowthTrial.rounds);
  return source.vertex_count() * steps;
}

BodyFit fit_body(const Mesh& source, const Mesh& target, const BodyFitOptions& options) {
  validate(source);
  validate(target);
  require_usable(options);
  return Fitter(WeldedMesh(source).mesh(), WeldedMesh(target).mesh(), options).run();
}

}  // namespace knead
