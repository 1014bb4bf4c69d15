// Stamping (paper, section 4.4; method, section 4): a closed tool presses its shape into the surface.
#pragma once

#include <string>
#include <vector>

#include "knead/mesh/mesh.h"
#include "knead/tool/live_surface.h"

namespace knead {

// What a stamp did.
struct StampResult {
  double outer = 0;        // as given, or the default for this tool
  double step = 0;         // likewise
  std::size_t steps = 0;   // collision tests along the whole path
  double penetration = 0;  // greatest depth of the surface inside the tool at the end
  bool stopped = false;    // apply returned false; penetration is then not measured
  std::vector<std::string> warnings;
};

// Moves the tool along the path and pushes the surface before it.
//
// - Each piece of the path is cut into steps of equal length, at most stroke.step. Pieces of length zero are skipped.
// - Each step finds the contacts once, between the current surface and the tool at the end of the step, and moves them
//   in four quarters. A place joins in the quarter in which the tool hits it. Without contacts a step moves nothing.
// - Every motion goes to surface.apply as a PointsStroke.
//   It holds the contacts, the stroke's exponent and one displacement for each quarter.
// - A stamp that slips does neither. In each step, twice at most, it takes what is inside the tool the shortest way
//   out, as a PinsStroke with the radius `outer`. What it has pressed so far is held by further pins. If stroke.outer
//   is not given, so is what touches the tool where the path begins: a path may be pressed in pieces.
// - These strokes, applied in order, repeat the stamp to the bit, for every number of threads (0: all).
// - If the tool already intersects the surface at the start of the path, the part inside moves along but is not pushed
//   out, and a warning says so. If the stamp slips, it is pushed out step by step.
//
// Throws InvalidInput, beginning with the key in quotes, for an invalid stroke and for a tool that is not closed and
// oriented outwards; nothing has moved then. Cost, besides apply: about 10 us for each vertex in the tool's box at each
// step, on one core.
StampResult stamp(const StampStroke& stroke, const Mesh& tool, const LiveSurface& surface, int threads = 0);

// Returns the greatest number of segments that a stamp becomes. Throws as stamp does.
std::size_t stamp_segments(const StampStroke& stroke, const Mesh& tool);

}  // namespace knead
