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

// A point of the source and its place on the target. Coordinates are finite.
struct FitPair {
  Vec3d source;
  Vec3d target;
  double tolerance = 0;  // a length, 0 or more: how far from its place the point may end; 0: it ends there
};

// Whether the source is moved as a whole before it is fitted.
enum class FitAlign {
  automatic,  // where that brings it much nearer to the target
  always,
  never,
};

// What becomes of the volume.
enum class FitVolume {
  keep,   // it stays that of the source
  total,  // the source is scaled to the target's volume first
  free,   // it grows and shrinks on purpose where the target asks for it, smoothly over the body
};

// How one shape is fitted to another.
struct BodyFitOptions {
  std::vector<FitPair> landmarks{};  // at most 2000
  // Pairs that need not be right, of any number: a start, from which the surfaces find each other.
  std::vector<FitPair> map{};
  bool surface = true;  // brings the whole surface of the source to the target's; false: landmarks and map alone
  FitAlign align = FitAlign::automatic;
  FitVolume volume = FitVolume::keep;
  double max_stretch = 5;        // above 1: what the fit may stretch a triangle; BodyFitReport::is_sound tells
  int threads = 0;               // 0: all; does not change a bit of the result
  Progress* progress = nullptr;  // counts up to its total, and cancels within 0.5 s
};

// Distances of two surfaces: of the vertices of each from the other one, both together, as fractions of the source's
// diagonal.
struct FitDistance {
  double mean = 0;
  double percentile_95 = 0;  // 95% are at most this
  double max = 0;
};

// What a fit did. Lengths are fractions of the source's diagonal, after scaling.
struct BodyFitReport {
  std::size_t landmarks = 0;
  std::size_t map_pairs = 0;
  std::size_t tips = 0;  // ends of limbs that took the place of landmarks: none were given
  std::size_t strokes = 0;
  std::size_t unknowns = 0;      // of a grid, the most
  double scale = 1;              // of the source, about the middle of its box, before all strokes
  bool is_aligned = false;       // the first strokes move the source as a whole
  double landmark_distance = 0;  // the greatest of a landmark from its place
  double landmark_rms = 0;       // root mean square of all of them
  double landmark_excess = 0;    // the greatest beyond its tolerance
  double map_distance = 0;       // the median of the map's pairs after the fit
  FitDistance before;            // of the source from the target, as they were
  FitDistance after;
  double after_landmarks = 0;  // the mean distance before the surfaces were matched
  // What the fit changed of the source's volume, a fraction; nothing unless closed and oriented. An error but for
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
  std::string stage;               // whose result it is: "landmarks" or "surface"
  std::vector<std::string> notes;  // what was odd about the input, in sentences
  bool is_sound = true;            // no new crossing, stretch and landmarks within their bounds
};

// A fit: strokes, and what they do.
struct BodyFit {
  std::vector<Stroke> strokes;   // for the source, scaled by BodyFitReport::scale if that is not 1
  std::vector<Vec3d> positions;  // of the source's vertices after them, as replaying the strokes gives them
  BodyFitReport report;
};

// Landmarks and distances up to this fraction of the diagonal count as met.
inline constexpr double kFitExact = 2e-5;

// Returns the strokes that take the source to the target: first those that align it, then `grid` strokes with which the
// landmarks (and the map) go to their places along paths on which limbs turn about their joints, then others that bring
// the surfaces together, from coarse to fine. Of the stages the best one is kept: the surfaces never make a shape worse
// than its landmarks gave. The volume stays, but for FitVolume::free, and nothing crosses where path lines are exact;
// what the flat triangles do is in the report. Time: about 5 to 15 s of processor time for 5,000 vertices. Memory:
// about 100 MB, and 200 bytes a vertex. Throws InvalidInput for invalid meshes, coordinates or tolerances; for a
// surface without triangles that has to be matched; for FitVolume::total without two volumes; for landmarks that are
// the target's mirror image (named); where the equations cannot be solved; and Cancelled.
BodyFit fit_body(const Mesh& source, const Mesh& target, const BodyFitOptions& options);

// Returns about what progress->total is at first. It grows where a stage begins again.
std::uint64_t fit_work(const Mesh& source, const BodyFitOptions& options);

// Returns the sentence that says which bound a fit misses and what to do; empty if it is sound.
std::string complaint_about(const BodyFitReport& report, const BodyFitOptions& options);

}  // namespace knead
