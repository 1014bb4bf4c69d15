// The parts of the tool "lattice": its box, what a shape allows it to do, its flow, and files of other programs.
// Internal to the library.
#pragma once

#include "knead/editor/tools.h"
#include "knead/flow.h"
#include "knead/stroke.h"
#include "strokes/describe.h"

namespace knead::detail {

// Returns the lattice of a valid stroke without a file.
LatticeMotion motion_of(const LatticeStroke& stroke);

// Throws InvalidInput, naming the face, if a triangle passes through a face of the box whose two outer layers of
// control points do not rest.
void check_faces(const LatticeMotion& lattice, const LiveSurface& surface);

// Applies a valid stroke with the mode volume or rigid: passes grids to the surface. A remark says how near it came.
void flow_on(const LatticeStroke& stroke, SurfaceRun& run);

}  // namespace knead::detail
