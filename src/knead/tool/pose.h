// Posing a surface (docs/mathematics.md, "Poses").
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
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
// that stretches it more than 6 times, or leaves a part by more than 0.02 from its place. Nothing has moved then.
PoseResult pose_on(const PoseStroke& stroke, const LiveSurface& surface, int threads = 0);

// A pose that follows a pointer: each advance goes on from where the last one came to, so it takes only the time of its
// own steps. The result is about that of the whole stroke: it depends on the ways between.
class PoseDrag {
 public:
  // At the beginning of a pose: nothing has moved. Throws as pose_on.
  PoseDrag(const PoseStroke& stroke, const LiveSurface& surface, int threads = 0);
  PoseDrag(PoseDrag&&) noexcept;
  PoseDrag& operator=(PoseDrag&&) noexcept;
  PoseDrag(const PoseDrag&) = delete;
  PoseDrag& operator=(const PoseDrag&) = delete;
  ~PoseDrag();

  // Returns whether the stroke is the same pose but for where its parts and pins go.
  bool takes(const PoseStroke& stroke) const;

  // Goes straight towards the ends of the stroke's ways, by about so many steps at most (of 8 degrees, or half of the
  // grid's spacing), and passes their grids to apply. Returns false if that did. Throws InvalidInput where the equations
  // cannot be solved.
  bool advance(const PoseStroke& stroke, double most_steps, const std::function<bool(const Stroke&)>& apply);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace knead
