// Bends of a body (docs/mathematics.md, "Bends of a body"): by any angle, where the field of a plain bend would spoil
// it. Internal to the tool room.
#pragma once

#include "knead/tool/live_surface.h"
#include "knead/tool/pose.h"

namespace knead {

// A plain bend by more degrees than this turns its zone against itself.
inline constexpr double kMostOfPlainBend = 170;

// Returns whether the stroke bends the body: by more than kMostOfPlainBend, or with "auto" where no barrel separates the
// part from the rest, or where the part comes back over the zone or over what rests.
bool bends_body(const BendStroke& stroke, const LiveSurface& surface);

// Bends what lies in the zone of the stroke along an arc as long as the zone is wide, through the middle of the part;
// what is beyond `inner` moves rigidly, all else holds, and nothing flows along the axis. With "auto" the part is what
// hangs together with the zone's piece that is nearest to the centre, on the side of `inner`; with a radius it is what
// is within the barrel. Passes GridStrokes to surface.apply, as pose_on. Throws InvalidInput, beginning with the key in
// quotes, for a zone without vertices, for a part that the rest also hangs together with elsewhere, for a zone too
// short for its angle, and for a bend that would spoil the shape: the angle that does not is then named.
PoseResult bend_on(const BendStroke& stroke, const LiveSurface& surface, int threads);

}  // namespace knead
