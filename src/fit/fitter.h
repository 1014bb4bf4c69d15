// The fit of a body: aligns, moves landmarks along paths of limbs, matches the surfaces, and keeps the best stage.
// Internal to the fit module.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fit/fit_align.h"
#include "fit/fit_motion.h"
#include "fit/fit_report.h"
#include "fit/surface_matches.h"
#include "knead/fit.h"
#include "knead/mesh.h"
#include "knead/stroke.h"
#include "pose/sound_steps.h"

namespace knead::detail {

inline constexpr double kMaxFitStep = 0.03;  // of the diagonal: the greatest motion in a step
inline constexpr std::size_t kMaxMapAnchors = 1500;
inline constexpr double kMaxPathStretch = 2;        // of a triangle while the landmarks move, relative to max_stretch
inline constexpr double kMaxKeptDifference = 0.03;  // of volumes: with more, a note advises to let them change
inline constexpr std::size_t kDistanceSamples = 3000;  // vertices of each shape between levels
inline constexpr std::size_t kCandidates = 8000;

// A level of the surface stage.
struct Level {
  double spacing;  // of the diagonal
  int rounds;
  double first_weight;  // of a match in the first round
  double last_weight;   // and in the last one
  std::size_t samples;  // of each surface
};
inline constexpr Level kLevels[] = {{0.1, 8, 0.2, 0.8, 900},
                                    {0.085, 6, 0.8, 2, 900},
                                    {0.07, 6, 2, 4, 900},
                                    {0.05, 6, 4, 6, 1500},
                                    {0.035, 4, 6, 6, 3000}};

// The level that decides whether a source that has grown as a whole is the better start.
inline constexpr Level kGrowthTrial{0.1, 4, 0.2, 0.8, 900};

inline Vec3d clipped(const Vec3d& v, double max_length) {
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
  std::size_t max_new_crossings() const { return detail::max_new_crossings(crossings_before_.count); }
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

}  // namespace knead::detail
