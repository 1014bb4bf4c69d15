// Stamping (paper, section 4.4; method, section 4): a closed tool presses its shape into the surface.
#pragma once

#include <string>
#include <vector>

#include "knead/mesh/mesh.h"
#include "knead/tool/live_surface.h"

namespace knead {

struct StampResult {
  double outer = 0;        // as given, or what it stood for
  double step = 0;         // likewise
  std::size_t steps = 0;   // collision tests along the whole path
  double penetration = 0;  // how deep the surface still lies inside the tool at the end, at its deepest
  bool stopped = false;    // apply asked for it; penetration was then not measured
  std::vector<std::string> warnings;
};

// Moves the surface out of the tool's way along the path. Each piece of the path falls into steps of equal length, at
// most stroke.step; a piece of length zero is skipped. Within a step the contacts are found once, on the surface as it
// then is and the tool as it stands at the step's end, and are moved by the step in four quarters, each place of the
// surface from that quarter on in which the tool hits it. What has no contact with the tool does not move; nor does
// anything in a step without contacts.
//
// Every motion is handed to surface.apply as a PointsStroke (the contacts, the stroke's exponent, one displacement for
// each quarter): these strokes alone, applied in their order, repeat the stamp to the bit. The same for every number of
// threads (0: all).
//
// Where the tool already stands in the surface at the path's beginning, what is inside is carried along but not pushed
// out, and a warning says so.
//
// Throws InvalidInput, beginning with the key in quotes, for a stroke that is not valid and for a tool that is not
// closed and oriented outward, before anything is moved.
//
// Cost, besides apply: about 10 us for each vertex in the tool's box at each step, on one core.
StampResult stamp(const StampStroke& stroke, const Mesh& tool, const LiveSurface& surface, int threads = 0);

// How many segments a stamp becomes, at most. Throws as stamp does.
std::size_t stamp_segments(const StampStroke& stroke, const Mesh& tool);

}  // namespace knead
