// What replays with and without remeshing have in common. Internal to the session room.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/mesh/triangulate.h"
#include "knead/session/moved_shape.h"
#include "knead/session/replay.h"
#include "knead/session/replay_plan.h"

namespace knead::session_detail {

// The length that tolerances are relative to: the diagonal of the shape's box, 1 for a point. Throws InvalidInput where
// that and the tolerance leave no positive length.
double checked_diagonal(const Mesh& mesh, const ReplayOptions& options);

MoveOptions move_options(const ReplayOptions& options, double diagonal);

// Whether strokes that read the surface find it as they always do: at the default tolerance, integrator and precision
// on the CPU, and remeshed for single precision.
bool is_usual(const ReplayOptions& options);

// The options with these at their defaults; without frames, so that nothing is delivered.
ReplayOptions usual(const ReplayOptions& options);

// What there is to say before anything is done.
std::vector<std::string> plan_warnings(const Session& session, const ReplayOptions& options, const Plan& plan);

// A stroke that reads the surface, as what it became on one surface.
struct SurfaceReading {
  Flow flow;
  std::optional<Barrel> barrel;
  std::vector<SessionStroke> parts;  // the strokes that it became
  std::optional<double> penetration;
  std::vector<std::string> remarks;
};

// Reads the surface for the whole stroke, and moves `shape` through it, except where there is a barrel, which is to be
// checked first. A stroke that could not be completed leaves its status in `shape`. `normals`: of a point cloud as it
// is; null: none. Throws InvalidInput that names the session's line.
SurfaceReading read_surface(const Session& session, const PlannedStroke& stroke, std::span<const Triangle> triangles,
                            const std::function<std::vector<Vec3d>()>& normals, const MoveOptions& options,
                            MovedShape& shape);

// Checks a stroke's barrel against the surface as the stroke begins. Returns what there is to say. Throws InvalidInput
// that names the session's line where triangles would be torn.
std::optional<std::string> barrel_warning(const Session& session, const PlannedStroke& stroke,
                                          std::span<const Vec3d> positions, std::span<const Triangle> triangles);

}  // namespace knead::session_detail
