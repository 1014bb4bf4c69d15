// Better triangles at the same volume. Internal to the remesh room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/remesh/remesh.h"
#include "knead/remesh/surface.h"

namespace knead::remesh_detail {

// What improving is to do and where.
struct Improvement {
  RemeshTargets targets;
  std::vector<bool> locked;  // of the first vertices: nothing at them is changed
};

struct ImprovementCounts {
  std::size_t splits = 0;
  std::size_t flips = 0;
  std::size_t collapses = 0;
};

// All of these work in the region of the surface after the deformation. The enclosed volume stays as it is, to the
// rounding: vertices move across their star's area vector, edges collapse on the plane that keeps the volume, and what
// flips and other collapses change is given back by the vertices around (after Kuprat et al., J. Comput. Phys. 172,
// 2001).

// Rounds of flips, collapses and diffusion. Nothing moves farther from the planes of the faces there than half of
// max_chord.
ImprovementCounts improve(Surface& surface, const Improvement& improvement);

// Whatever helps the worst triangles: with wider bounds from level to level, 0 to kMendLevels - 1, on the last of which
// also creases give way to triangles of less than 6 degrees; and then, where that
// made triangles cross, with distances that fall from level to level, to kCarefulLevels - 1.
inline constexpr int kMendLevels = 5;
inline constexpr int kCarefulLevels = 9;
ImprovementCounts mend(Surface& surface, const Improvement& improvement, int level);

// Changes these faces, whatever their shape, by collapses, flips and moves within the widest bounds: what crosses may
// cross no more then. The volume stays as it is.
ImprovementCounts untangle(Surface& surface, const Improvement& improvement, std::span<const std::uint32_t> faces);

// The paper's way (section 5.2): diffusion with projection back onto the surface as it was given, collapses at
// midpoints. Loses volume.
ImprovementCounts improve_as_in_the_paper(Surface& surface, const Improvement& improvement);

}  // namespace knead::remesh_detail
