// Fitting one shape to another by a flow that strains the body least (docs/decisions/0033-near-rigid-fits.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/stroke.h"

namespace knead {

// A point of the source and its position on the target. Coordinates are finite.
struct FitPair {
  Vec3d source;
  Vec3d target;
  double tolerance = 0;  // a length, 0 or more: the allowed distance of the moved point from the target
};

// Whether the source is moved as a whole before it is fitted.
enum class FitAlign {
  automatic,  // if that brings it much nearer to the target
  always,
  never,
};

// What becomes of the volume.
enum class FitVolume {
  keep,   // it stays that of the source
  total,  // the source is scaled to the target's volume first
  free,   // it follows the target, and changes smoothly over the body
};

// How one shape is fitted to another.
struct BodyFitOptions {
  std::vector<FitPair> landmarks{};  // at most 2000
  // Approximate pairs, of any number: the start for matching the surfaces. Empty: if both shapes have the same faces,
  // vertices of the same number are pairs, unless these contradict the landmarks, max_stretch or a volume that is kept.
  std::vector<FitPair> map{};
  bool surface = true;  // matches the whole surface; false: landmarks and map alone
  // Matches only the parts that both surfaces have; parts opposite a hole or a cut of the other surface are not
  // matched.
  bool partial = false;
  FitAlign align = FitAlign::automatic;
  FitVolume volume = FitVolume::keep;
  double max_stretch = 5;        // above 1: a triangle with a greater stretch makes the fit unsound (is_sound)
  int threads = 0;               // 0: all; does not change a bit of the result
  Progress* progress = nullptr;  // counts up to its total, and cancels within 0.5 s
};

// Distances between two surfaces, as fractions of the source's diagonal. They are those of the vertices of each surface
// from the other one, taken together.
struct FitDistance {
  double mean = 0;
  double percentile_95 = 0;  // 95% are at most this
  double max = 0;
  Vec3d farthest{};  // the vertex of either surface with this distance
};

// What a fit did. Lengths are fractions of the source's diagonal, after scaling.
struct BodyFitReport {
  std::size_t landmarks = 0;
  std::size_t map_pairs = 0;
  std::size_t tips = 0;  // ends of limbs that were used as landmarks because none were given
  std::size_t strokes = 0;
  std::size_t unknowns = 0;      // of the largest grid
  double scale = 1;              // of the source, about the middle of its box, before all strokes
  bool is_aligned = false;       // the first strokes move the source as a whole
  double landmark_distance = 0;  // the greatest distance of a landmark from its target
  double landmark_rms = 0;       // root mean square of these distances
  double landmark_excess = 0;    // the greatest part of such a distance beyond its tolerance
  double reached = 1;            // the fraction of their paths that landmarks and map moved while the shape was sound
  std::string obstacle;          // why they stopped there; empty if they reached their targets
  double map_distance = 0;       // the median distance of the map's pairs after the fit
  FitDistance before;            // of the source from the target before the fit
  FitDistance after;
  // For an open target: the mean distance of its vertices from the fitted source. With `partial`: this, or the mean
  // distance of the fitted source's vertices from the target if that is smaller.
  std::optional<double> after_covered;
  std::optional<double> matched;  // with `partial`: the fraction of the source's surface that was matched last
  double after_landmarks = 0;     // the mean distance before the surfaces were matched
  // The relative change of the source's volume; nothing unless closed and oriented. An error, except with
  // FitVolume::free.
  std::optional<double> volume_error;
  // With FitVolume::free: the least and greatest det J of the whole flow at evenly spread vertices. Above 0.
  std::optional<double> det_least;
  std::optional<double> det_greatest;
  std::optional<double> volume_difference;  // target / source - 1, before the fit; nothing unless both are closed
  std::size_t crossings_before = 0;         // pairs of triangles of the source
  std::size_t crossings_after = 0;
  std::size_t crossings_new = 0;   // pairs that did not cross before
  double greatest_stretch = 1;     // of a triangle, its greatest singular value or the inverse of its least
  double stretch_99 = 1;           // 99% of the triangles are stretched by at most this
  double rms_log_stretch = 0;      // root mean square of the logarithms of their singular values
  std::string stage;               // the stage that gave the result: "landmarks" or "surface"
  std::vector<std::string> notes;  // about the input, in sentences
  bool is_sound = true;            // no new crossing, stretch and landmarks within their bounds
};

// A fit: strokes, and their result.
struct BodyFit {
  std::vector<Stroke> strokes;   // for the source, scaled by BodyFitReport::scale if that is not 1
  std::vector<Vec3d> positions;  // of the source's vertices after them, as replaying the strokes gives them
  BodyFitReport report;
};

// Landmarks within this fraction of the diagonal count as met.
inline constexpr double kFitExact = 2e-5;

// Returns the strokes that move the source to the target:
// 1. strokes that align it as a whole;
// 2. `grid` strokes that move the landmarks (and the map) to their targets, on paths on which limbs turn about joints;
// 3. `grid` strokes that bring the surfaces together, from coarse to fine. They are kept only if they improve the fit.
// The volume stays, except with FitVolume::free, and nothing crosses along exact path lines; the report says what the
// flat triangles do. Time: about 5 to 15 s of processor time for 5,000 vertices. Memory: about 100 MB, and 200 bytes a
// vertex. Throws InvalidInput for invalid meshes, coordinates or tolerances; for a surface without triangles that must
// be matched; for FitVolume::total if a shape has no volume; for landmarks that are the target's mirror image; and if
// the equations cannot be solved. Throws Cancelled.
BodyFit fit_body(const Mesh& source, const Mesh& target, const BodyFitOptions& options);

// Returns the first value of progress->total, approximately. The total grows when a stage is repeated.
std::uint64_t fit_work(const Mesh& source, const BodyFitOptions& options);

// Returns the sentence that says which bound a fit misses and what to do; empty if it is sound.
std::string complaint_about(const BodyFitReport& report, const BodyFitOptions& options);

}  // namespace knead
