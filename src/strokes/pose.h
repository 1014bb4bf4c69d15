// Posing a surface, bending its body by a pose, and inflating it (docs/mathematics.md, "Poses", "Bends of a body",
// "Volume on purpose"). Internal to the library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/flow.h"
#include "pose/pose_motion.h"

namespace knead {

// What a pose did. Distances are fractions of the shape's diagonal.
struct PoseResult {
  double part_distance = 0;     // the greatest distance of a point of a part, or of a pin, from its place
  double greatest_stretch = 1;  // singular values of the flow along the surface, at points spread over it; for clouds
  double least_stretch = 1;     // in all directions
  double rms_log_stretch = 0;   // root mean square of their logarithms
  std::size_t unknowns = 0;     // of the largest grid
  std::size_t segments = 0;
  bool stopped = false;     // apply returned false
  double reached = 1;       // the fraction of the pose that was sound
  std::string shortfall{};  // says how the pose missed its targets; empty if it reached them
  std::vector<std::string> warnings;
};

// Poses the surface: finds the grids of the motion and passes them to surface.apply as GridStrokes, one for each step
// of at most 8 degrees. It ends before a step after which triangles cross that did not at the start, or are stretched
// or compressed more than 6 times (step_soundly()). With `exact` a PinsStroke follows. These strokes, applied in order,
// repeat the pose bit for bit, for every number of threads (0: all) and every order of vertices. Time: about 0.1 s a
// step for `detail` 0.075, without apply. Throws InvalidInput, beginning with the key in quotes, for an invalid stroke
// and for vertices that the surface does not have. Nothing has moved then.
PoseResult pose_on(const PoseStroke& stroke, const LiveSurface& surface, int threads = 0);

// A pose that follows a pointer: each advance() starts from the end of the last one, so it takes only the time of its
// own steps. The result is near that of the whole stroke; it depends on the intermediate targets.
class PoseDrag {
 public:
  // Begins a pose; nothing has moved. Throws as pose_on.
  PoseDrag(const PoseStroke& stroke, const LiveSurface& surface, int threads = 0);
  PoseDrag(PoseDrag&&) noexcept;
  PoseDrag& operator=(PoseDrag&&) noexcept;
  PoseDrag(const PoseDrag&) = delete;
  PoseDrag& operator=(const PoseDrag&) = delete;
  ~PoseDrag();

  // Returns whether the stroke is the same pose, except for the targets of its parts and pins.
  bool takes(const PoseStroke& stroke) const;

  // Moves parts and pins straight towards the stroke's targets, by about `most_steps` steps at most (of 8 degrees, or
  // half of the grid's spacing), and passes their grids to apply. Returns false if apply did. Throws InvalidInput if
  // the equations cannot be solved.
  bool advance(const PoseStroke& stroke, double most_steps, const std::function<bool(const Stroke&)>& apply);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// A plain bend by more degrees than this turns its zone against itself.
inline constexpr double kMaxOfPlainBend = 170;

// Returns whether the stroke bends the body: if its angle is above kMaxOfPlainBend, and with "auto" also if no limit
// cylinder separates the part from the rest, or if the part ends over the zone or over resting parts.
bool bends_body(const BendStroke& stroke, const LiveSurface& surface);

// Bends the stroke's zone along an arc as long as the zone is wide, through the middle of the part. The part beyond
// `inner` moves rigidly, everything else holds, and nothing flows along the axis. With "auto" the part is connected to
// the zone's piece nearest to the centre, on the side of `inner`; with a radius it is inside the limit cylinder. Passes
// GridStrokes to surface.apply, as pose_on. Throws InvalidInput, beginning with the key in quotes, for a zone without
// vertices, for a part that is also connected to the rest elsewhere, for a zone too short for its angle, and for a bend
// that would spoil the shape; the message then names an angle that does not.
PoseResult bend_on(const BendStroke& stroke, const LiveSurface& live, int threads);

// Inflates the surface: finds the grids of the whole motion, and passes them to surface.apply as GridStrokes. The
// volume inside the triangles changes by the stroke's volume, with a relative error of 1e-6 and that of apply. Returns
// false if apply did. Time: about 0.2 s a step for a path as long as the radius. Throws InvalidInput, beginning with
// the key in quotes, for an invalid stroke, for a place where nothing can grow, and for a volume too large for the
// radius. Nothing has moved then.
bool inflate_on(const InflateStroke& stroke, const LiveSurface& surface, int threads);

namespace detail {

// Returns the diagonal of the box of the vertices that triangles use, or of a cloud.
double diagonal_of(const LiveSurface& surface);

// Returns a part that holds, with evenly spread points of `all`, enough for a grid of that spacing.
detail::PosedPart part_of(const std::vector<Vec3d>& all, double spacing);

inline constexpr std::size_t kSamplesInside = 4000;  // of a body

// Returns samples of the body for a grid of that spacing, about that number of them inside it. Adds a warning if the
// surface is open.
detail::BodySamples body_of(const LiveSurface& surface, double spacing, std::size_t inside, int threads,
                            std::vector<std::string>& warnings);

// Returns the detail of a pose that names none: a quarter of the thickness of the thinnest part that moves, from 0.02
// to 0.075.
double usual_detail(const PoseStroke& stroke, const LiveSurface& surface);

// Returns a pose on the surface in numbers. If a part moves near one that holds, the spacing is smaller than the
// stroke's `detail`, down to `least_detail`. Throws as pose_on. Adds a warning if the surface is open.
detail::PoseProblem problem_of(const PoseStroke& stroke, const LiveSurface& surface, std::size_t inside,
                               double least_detail, int threads, std::vector<std::string>& warnings);

// Returns for each point the number of the nearest position.
std::vector<std::uint32_t> nearest_of(std::span<const Vec3d> positions, const std::vector<Vec3d>& points);

// Solves the problem; the flow gets one segment for each grid.
detail::PoseOutcome find_flow(detail::PoseProblem problem, Flow& flow);

// Sets the stretches of the result, at evenly spread points.
void measure_stretch(const Flow& flow, const LiveSurface& surface, double diagonal, int threads, PoseResult& result);

// Passes each grid of the flow to surface.apply; returns false if apply did.
bool apply_grids(const Flow& flow, const LiveSurface& surface);

}  // namespace detail

}  // namespace knead
