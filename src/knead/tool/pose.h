// Posing a surface (docs/mathematics.md, "Poses").
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "knead/tool/live_surface.h"

namespace knead {

// What a pose did. Distances are fractions of the shape's diagonal.
struct PoseResult {
  double part_distance = 0;     // the greatest of a point of a part, or of a pin, from its place
  double greatest_stretch = 1;  // singular values of the flow, at points spread over the surface
  double least_stretch = 1;
  double rms_log_stretch = 0;  // root mean square of their logarithms
  std::size_t unknowns = 0;    // of a grid, the most
  std::size_t segments = 0;
  bool stopped = false;  // apply returned false
  std::vector<std::string> warnings;
};

// Poses the surface: finds the grids of the whole motion, looks at what they do, and passes them to surface.apply as
// GridStrokes, one for each step of at most 8 degrees. With `exact` a PinsStroke follows. These strokes, applied in
// order, repeat the pose bit by bit, for every number of threads (0: all) and every order of vertices.
// Time: about 0.1 s a step for `detail` 0.075, besides apply. Throws InvalidInput, beginning with the key in quotes,
// for an invalid stroke, for vertices that the surface does not have, and for a pose that would spoil the shape: one
// that stretches it more than 10 times, or leaves a part by more than 0.02 from its place. Nothing has moved then.
PoseResult pose_on(const PoseStroke& stroke, const LiveSurface& surface, int threads = 0);

}  // namespace knead
