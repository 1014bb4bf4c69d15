// Improves the triangles of a surface after a deformation, and restores the volume that they miss.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/remesh.h"
#include "knead/vec.h"
#include "remesh/refine.h"
#include "remesh/surface.h"

namespace knead::detail {

// Moves vertices along the area vectors of their stars to add the volume `missing`. Returns the volume added.
//
// An edge misses about (area vectors of its two faces) . (deviation) / 3 (docs/remeshing.md); each end compensates half
// of that. A vertex moves by at most 1.5 times the largest deviation around it. All motions are then scaled to reach
// `missing`; the factor stays between 0.75 and 1.25. Only vertices that the deformation moves are changed; those at
// features, at the border of the patch, and locked ones stay. `deviations` are those of Refinement.
double compensate(Surface& surface, const std::vector<Vec3d>& deviations, const std::vector<bool>& locked,
                  double missing);

// The missing volume as the same sum over edges.
struct MissingVolume {
  double sum = 0;
  double sum_of_sizes = 0;  // of the terms
};
MissingVolume estimate_missing_volume(const Surface& surface, const std::vector<Vec3d>& deviations);

// Returns the signed volume between the surface with these positions and the mean of surface.before. If the border
// rests, differences of this volume equal those of the whole closed mesh.
double enclosed_volume(const Surface& surface, const std::vector<Vec3d>& positions);

class CrossingGuard;
class SurfaceMemory;

// The targets of an improvement, and what it must not do.
struct Improvement {
  RemeshTargets targets;
  const Progress* progress = nullptr;  // cancels; the surface then has some of the changes
  CrossingGuard* guard = nullptr;      // refuses changes that would make triangles cross; null: none are refused
  Deadline* deadline = nullptr;        // ends the work after a change; null: never
  SurfaceMemory* memory = nullptr;     // of this surface, shared by several calls; null: each call uses its own
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

// The functions below change the positions `after`, in the surface's region only. They keep the enclosed volume up to
// rounding: vertices move orthogonally to the area vector of their star, a collapsed edge ends on the plane that keeps
// the volume, and neighbouring vertices compensate what flips and other collapses change (after Kuprat et al., J.
// Comput. Phys. 172, 2001). Each returns the number of changes.

// Runs rounds of flips, collapses and diffusion. No vertex moves farther than half of max_chord from the planes of the
// faces around it.
ImprovementCounts improve(Surface& surface, const Improvement& improvement);

// Improves the worst triangles by any change. Each level from 0 to kRepairLevels - 1 allows larger changes than the one
// before. Levels kRepairLevels to kGuardedLevels - 1 are for surfaces where that made triangles cross: each allows
// smaller changes than the one before.
inline constexpr int kRepairLevels = 4;
inline constexpr int kGuardedLevels = 8;
ImprovementCounts repair_triangles(Surface& surface, const Improvement& improvement, int level);

// Improves thin triangles in the flat faces of parts, as repair_triangles() does, but within their planes. Removes
// none.
ImprovementCounts improve_flat_faces(Surface& surface, const Improvement& improvement);

// Divides the flat faces of parts before a deformation so that their triangles are good and no edge is longer than
// `max_edge`; the surface and its vertices stay. Splits the longest edges around a bad triangle in their middles, and
// flips edges to those of a Delaunay triangulation after each split. Splits edges between faces only where they are
// longer than `max_edge`, or the longest beside a bad triangle of a large face. `surface.after` must equal `before`.
//
// After M. Rivara and N. Hitschfeld, "LEPP-Delaunay algorithm: a robust tool for producing size-optimal quality
// triangulations", 8th International Meshing Roundtable, 1999.
ImprovementCounts divide_flat_faces(Surface& surface, const Improvement& improvement, double max_edge);

// Moves all free vertices but the locked ones by one distance, so that the volume grows by about `volume`; by less if
// the distance would be more than `max_distance`.
void spread_volume(Surface& surface, double volume, double max_distance, const std::vector<bool>& locked);

// Changes these faces of any shape by collapses, flips and moves within the widest bounds. This often ends crossings;
// the guard accepts only changes that leave fewer crossing pairs.
ImprovementCounts repair_crossings(Surface& surface, const Improvement& improvement,
                                   std::span<const std::uint32_t> faces);

}  // namespace knead::detail
