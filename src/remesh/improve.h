// The step that raises the least of several values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/remesh.h"
#include "knead/vec.h"
#include "remesh/refine.h"
#include "remesh/surface.h"

namespace knead::remesh_detail {

// Returns the step d for which the least of value + gradient . d, less |d|^2 / (2 reach), is greatest. There is at
// least one value, and as many gradients. A step where no value can rise is 0.
//
// Method: the dual problem looks for the weights of the gradients whose sum is the step. At most four are above 0,
// which are found by an active set: P. Wolfe, "Finding the nearest point in a polytope", Mathematical Programming 11,
// 1976.
Vec3d best_step(std::span<const double> values, std::span<const Vec3d> gradients, double reach);

// Restores the volume that the flat triangles of a refined mesh miss.

// Moves vertices along the area vectors of their stars to add the volume `missing`. Returns the volume added.
//
// An edge misses about (area vectors of its two faces) . (deviation) / 3 (docs/remeshing.md); each end compensates half
// of that. A vertex moves by at most 1.5 times the largest deviation around it. All motions are then scaled to reach
// `missing`; the factor stays between 0.75 and 1.25. Only vertices that the deformation moves are changed; those at
// features, at the border of the patch, and locked ones stay. `deviations` are those of Refinement.
double compensate(Surface& surface, const std::vector<Vec3d>& deviations, const std::vector<bool>& locked,
                  double missing);

// Returns the missing volume as the same sum over edges.
double estimate_missing_volume(const Surface& surface, const std::vector<Vec3d>& deviations);

// Returns the signed volume between the surface with these positions and a fixed point, the mean of surface.before.
// While the border rests, differences of this volume equal those of the whole closed mesh.
double enclosed_volume(const Surface& surface, const std::vector<Vec3d>& positions);

// Improves triangles and keeps the volume.

class CrossingGuard;
class SurfaceMemory;

// The targets of an improvement, and what it must not do.
struct Improvement {
  RemeshTargets targets;
  const Progress* progress = nullptr;  // cancels; the surface is then part-way
  CrossingGuard* guard = nullptr;      // refuses changes that would make triangles cross; null: none are refused
  Deadline* deadline = nullptr;        // ends after a change, with less improved; null: never
  SurfaceMemory* memory = nullptr;     // of this surface, for several functions in a row; null: they use their own
  int threads = 1;                     // as for parallel_for; changes no bit
  bool exact = false;                  // vertices stay in the planes and on the lines of the surface
  bool may_collapse = true;
};

struct ImprovementCounts {
  std::size_t splits = 0;
  std::size_t flips = 0;
  std::size_t collapses = 0;
  double volume = 0;  // lost by changes that no vertices nearby could compensate; see spread_volume()

  ImprovementCounts& operator+=(const ImprovementCounts& more);
};

// The functions below change the surface after the deformation, in its region only. They keep the enclosed volume up to
// rounding: vertices move orthogonally to the area vector of their star, collapsed edges are placed on the plane that
// keeps the volume, and neighbouring vertices compensate what flips and other collapses change (after Kuprat et al.,
// J. Comput. Phys. 172, 2001). Each returns the number of changes.

// Runs rounds of flips, collapses and diffusion. No vertex moves farther than half of max_chord from the planes of the
// faces around it.
ImprovementCounts improve(Surface& surface, const Improvement& improvement);

// Changes the worst triangles in any way that improves them. Each level from 0 to kMendLevels - 1 allows larger
// changes. Levels kMendLevels to kGuardedLevels - 1 are for surfaces where that made triangles cross: they allow
// smaller and smaller changes.
inline constexpr int kMendLevels = 4;
inline constexpr int kGuardedLevels = 8;
ImprovementCounts mend(Surface& surface, const Improvement& improvement, int level);

// Improves thin triangles of the flat faces of parts before a deformation, as mend() does, but in their planes: then
// the deformation is followed from good triangles that lie where the thin ones did. Removes none. `surface.after` must
// be `before`.
ImprovementCounts improve_flat_faces(Surface& surface, const Improvement& improvement);

// Moves all free vertices but the locked ones a little, so that the volume grows by about `volume`.
void spread_volume(Surface& surface, double volume, const std::vector<bool>& locked);

// Changes these faces, whatever their shape, by collapses, flips and moves within the widest bounds. Faces that cross
// often do not cross afterwards; the guard accepts no change that leaves as many pairs.
ImprovementCounts repair_crossings(Surface& surface, const Improvement& improvement,
                                   std::span<const std::uint32_t> faces);

}  // namespace knead::remesh_detail
