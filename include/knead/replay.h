// Applies a session to a shape; derivatives of the result with respect to parameters, coefficients and points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/editor/shape_state.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead {

// forwards: the strokes in their order.
// backwards: the inverse strokes, the last one first, which restores a deformed shape.
enum class Direction { forwards, backwards };

// Which part of a session is applied, and in which direction. Strokes that are off are not counted.
struct SessionPart {
  Direction direction = Direction::forwards;
  // Only the first strokes. 2.5: two strokes and half of the third's segments. From 0 to their number; empty: all.
  std::optional<double> until{};
};

// The shape at a moment of the deformation.
struct ReplayFrame {
  int index = 0;
  const DeformedShape& shape;
};

// The greatest number of frames, and of repeated frames at each end.
inline constexpr int kMaxFrames = 1'000'000;

// How the time of an animation runs. smooth: slowly at the beginning and end, 3 t^2 - 2 t^3 of the linear time t.
enum class Ease { linear, smooth };

// The moments of the deformation that are delivered: evenly spaced in time, from the start to the end. A stroke lasts
// SessionStroke::duration.
struct FrameOptions {
  int count = 0;  // 1: the end only; 0: none
  Ease ease = Ease::linear;
  int hold = 0;  // how often the first and the last frame are repeated; 0 or more
  // For a session that remeshes. True: every frame has the vertices and faces of the result; the flow takes the
  // vertices back to their places at each moment. False: each frame has faces of its own.
  bool same_faces = false;
  std::function<void(const ReplayFrame&)> deliver{};  // called for each frame, in order
};

// Returns the number of frames that are delivered, with the repeated ones.
int frame_count(const FrameOptions& frames);

// What one stroke did, as far as it was applied.
struct AppliedStroke {
  std::size_t line = 0;  // of the session
  const Flow& flow;      // which moved the vertices
  const DeformedShape& before;
  const DeformedShape& after;
  const Remeshed* remeshed = nullptr;  // RemeshOutcome::remeshed; null: vertices and faces are those before
  const RelaxStroke* relax = nullptr;  // if the stroke relaxes; the flow is then empty
};

// How a session is applied.
struct ReplayOptions {
  MotionOptions motion{};
  RemeshPolicy remesh{};
  SessionPart part{};
  FrameOptions frames{};
  std::vector<Vec3d> normals{};                           // of a point cloud, see DeformedShape; or empty
  std::vector<IndexRange> splats{};                       // splats_among() joined meshes; empty: those of the mesh
  std::function<void(const AppliedStroke&)> on_stroke{};  // called when a stroke is complete
  Progress* progress = nullptr;                           // counts up to Replay::work(), its total
  // Keeps the result if triangles cross after a remeshed stroke that did not cross before. False: such a stroke is
  // refused (RemeshLimit), unless RemeshPolicy::seconds ended the work.
  bool may_cross = false;
  // Refuses (QualityLimit) a result whose faces are far from the exact image of the surface: a root mean square of more
  // than 1e-2 of the size, or a fraction of 1e-2 of the volume; where the mesh follows, 1e-3 of the size, or 1e-2 at
  // one place. Also refuses a flow that moves faces, but no vertex. False: a warning.
  bool must_follow = false;
  bool strokes_warn = true;  // false: the result lacks Replay::warnings(), for callers that have shown them
};

// Why a replay ends in step_limit, and what to do.
inline constexpr const char* kStepLimitAdvice =
    "a path line runs to infinity or needs over a million steps here; use a wider transition, a smaller angle, another "
    "gauge, or a larger tolerance";

// How a replay ended, and what it made.
struct ReplayResult {
  AdvectStatus status = AdvectStatus::done;
  std::size_t failed_line = 0;  // of the session, if the status is step_limit: the stroke that could not be applied
  DeformedShape shape;          // without vertices unless the status is done
  std::size_t strokes = 0;      // applied; a part of one counts as one
  std::size_t segments = 0;
  std::optional<double> penetration{};         // the greatest depth of the surface inside a stamp's tool, at its end
  std::shared_ptr<const VolumeCells> cells{};  // of the session's mesh, see on_walls(); null: none
  std::vector<SessionStroke> resolved;  // the applied strokes as strokes that read no surface, in the session's order
  std::vector<std::string> warnings;    // each with the session's file and line
  std::vector<std::string> shortfalls;  // as warnings: strokes that did not reach their targets; the result is sound
};

// Applies a session to a shape and returns the result; the mesh does not change. The bits of the result depend only on
// the mesh, the motion, the remesh policy, the part and the normals. The last frame is the result, and every frame is
// the result of a replay until that moment (with FrameOptions::same_faces, up to the tolerance and the faces).
//
// A stroke that reads the surface reads the shape that the default MotionOptions give, so `resolved` does not depend on
// the options. If such a session has other options, a second shape is deformed with these.
//
// Remeshing: a stroke moves the vertices, then the mesh follows once (knead/remesh.h), even if the stroke resolves to
// several strokes. Frames within a stroke are remeshed from the beginning of the stroke. Handles given by the numbers
// of vertices are refused once a remesh has changed the numbers. Point clouds are not remeshed, and no shape is
// remeshed backwards. If remeshing leaves triangles that cross and did not before, RemeshLimit is thrown with the
// session's line; see ReplayOptions::may_cross.
//
// Relax strokes are not in `resolved`, because they are no flows. They are refused backwards, for point clouds, and
// where frames have the same faces as a remeshed result.
//
// Throws InvalidInput where validate(*mesh) does and for options out of range, before anything is done. Throws it with
// the session's line for a stroke that cannot be applied to the shape; frames may have been delivered then.
ReplayResult replay(const std::shared_ptr<const Mesh>& mesh, const Session& session, const ReplayOptions& options = {});

// Does the same for a mesh that is not shared: moved or copied into the result.
ReplayResult replay(Mesh mesh, const Session& session, const ReplayOptions& options = {});

namespace detail {

struct Plan;  // what a replay does, in order

}  // namespace detail

// replay() in steps, for callers that need the amount of work in advance. The first call of work() or run() makes the
// plan: it checks the strokes, makes the flows of those that read no surface, and reads stamps.
class Replay {
 public:
  // The session and the options must outlive the object. Costs nothing.
  Replay(std::shared_ptr<const Mesh> mesh, const Session& session, const ReplayOptions& options);
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;
  ~Replay();

  // Returns whether the mesh will be remeshed after a stroke. Costs nothing.
  bool remeshes() const;

  // Returns the warnings that need no surface, each with the session's file and line. Takes about 0.15 s for a stroke
  // of many pins.
  std::vector<std::string> warnings() const;

  // Returns what run() adds to Progress::done if it is not cancelled. Throws as run().
  std::uint64_t work();

  // Returns what replay() does. May be called once.
  ReplayResult run();

 private:
  detail::Plan& plan();

  std::shared_ptr<const Mesh> mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  std::unique_ptr<detail::Plan> plan_;
};

// Returns the flow of a session that reads no surface, for any points. advect() with it moves points as replay() does,
// bit for bit; replay() also refuses a limit cylinder that would tear the surface. Throws InvalidInput for a part out
// of range, and with the session's line for a stroke that reads or relaxes the surface and for a mask given by the
// numbers of vertices.
Flow flow_of(const Session& session, const SessionPart& part = {}, int threads = 0);

// Returns whether replay() looks at the faces: to read the surface, to relax it, to check a limit cylinder, or to
// remesh. If not, advect() by flow_of(session) gives the same positions, bit for bit.
bool needs_faces(const Session& session);

// Returns a function for FrameOptions::deliver that writes all frames to one file, which appears after the last frame.
// is_remeshed: Replay::remeshes(); FrameOptions::same_faces must then be set, and the file has the faces of the result
// and no other attributes. The source must outlive the function. Throws as AnimationFile.
std::function<void(const ReplayFrame&)> animation_writer(const std::filesystem::path& path, const ShapeFile& source,
                                                         bool is_remeshed, const AnimationOptions& options);

// Returns the vertices that are splats, by their numbers in JoinedMeshes of these meshes. Throws
// InvalidInput as splat_degree() for splats with a wrong number of harmonics.
std::vector<IndexRange> splats_among(std::span<const Mesh* const> meshes);

// Splits splats that are too long for the flow to bend as one. Returns false if it splits none. A splat is too long if
// the second difference of the flow over one standard deviation is above 0.1 of the deformed splat. It is split along
// that axis into pieces, which together have its covariance and opacity. Splitting goes on, the worst splat first,
// until no splat is too long or there are `max_splats` (by default twice as many as before). A piece is a copy of the
// splat's row with its own centre, sizes and opacity; the first piece takes the splat's place, the others come after
// all splats. A splat stays whole if a part of it would run to infinity (AdvectStatus::step_limit); backwards, also if
// the flow forwards would not bend its result. Uses the options motion, part, and those that replay() needs for strokes
// that read the surface. `notes`: null, or receives a sentence on how many splats run to infinity, and one on how many
// need more pieces than `max_splats` allows. Throws as replay() and flow_of().
bool split_splats(ShapeFile& shape, const Session& session, const ReplayOptions& options,
                  std::optional<std::size_t> max_splats = {}, std::vector<std::string>* notes = nullptr);

// Writes the deformed shape with everything else that the source has, as write_shape() or write_remeshed(); also new
// normals of points, and new values of splats. Throws as these.
void write_deformed(const std::filesystem::path& path, const ShapeFile& source, const DeformedShape& shape,
                    const WriteOptions& options = {});

// Returns the bytes that write_deformed writes; `format` is the name of a format.
std::string serialize_deformed(std::string_view format, const ShapeFile& source, const DeformedShape& shape,
                               const WriteOptions& options = {});

// One of several shapes that are deformed as one, and its file.
struct ShapePart {
  const ShapeFile& source;
  const JoinedMeshes& joined;
  std::size_t number = 0;  // of the mesh in `joined`
};

// Writes one part of a deformed state of JoinedMeshes::mesh(), with everything else that its source has, as
// write_shape() or write_remeshed(). Throws as these.
void write_part(const std::filesystem::path& path, const ShapePart& part, const ShapeState& state,
                const WriteOptions& options = {});

// Returns a function for FrameOptions::deliver that writes the frames of the part, as animation_writer does. The part's
// source and `joined` must outlive it.
std::function<void(const ReplayFrame&)> part_animation_writer(const std::filesystem::path& path, const ShapePart& part,
                                                              const AnimationOptions& options);

// Derivatives.

// How derivatives are integrated along path lines, always in double.
struct DerivativeOptions {
  // Error of one path line over one segment: that of its position divided by the diagonal, and the relative error of
  // its derivative. From 1e-13 to 1. The tolerance of deform, 1e-5, takes a third of the time of 1e-8.
  double relative_tolerance = 1e-8;
  std::optional<double> diagonal{};  // a length; by default the diagonal of the points' box
  int threads = 0;                   // 0: as many as the machine has
  Progress* progress = nullptr;      // counts points times segments
};

// Deformed points, and their derivatives along a direction in the space of the parameters.
struct PointTangents {
  std::vector<Vec3d> points;
  std::vector<Vec3d> tangents;
};

// The gradient of a function of the deformed points with respect to the undeformed points and to each parameter.
struct SessionGradient {
  std::vector<Vec3d> points;
  std::vector<double> parameters;
};

// The derivatives of the map that a session applies to points with respect to its parameters, at their values. The map
// is that of the exact flow (docs/decisions/0037-derivatives.md).
class SessionDerivatives {
 public:
  // Throws InvalidInput where flow_of does, and for a parameter, which the message names, that has no derivative: it
  // sets a whole number or the number of segments, or is part of a mask or of a grid's nodes. Throws Cancelled. Cost:
  // for each parameter about 20 calls of flow_of() for the strokes that name it, each with the solution for its pins.
  explicit SessionDerivatives(const Session& session, const SessionPart& part = {}, int threads = 0,
                              const Progress* progress = nullptr);
  SessionDerivatives(const SessionDerivatives&) = delete;
  SessionDerivatives& operator=(const SessionDerivatives&) = delete;
  ~SessionDerivatives();

  // Returns the number of the flow's segments.
  std::size_t segments() const;

  // Forwards: returns the deformed position of each point, and its derivative along the direction, which has one number
  // for each parameter of the session. The bits of a result depend on its point and the diagonal alone. Cost: about 2
  // us for a point that a segment of one field reaches. Throws InvalidInput for numbers that are not finite, a
  // direction of another length, a tolerance out of range, and a path line that needs over a million steps; Cancelled.
  PointTangents jvp(std::span<const Vec3d> points, std::span<const double> direction,
                    const DerivativeOptions& options) const;

  // Backwards: takes the gradient of a function with respect to the deformed points, one vector for each point, and
  // returns its gradient with respect to the undeformed points and the parameters. The result has the same bits for
  // every number of threads. Cost: about one jvp(), for any number of parameters. Throws as jvp().
  SessionGradient vjp(std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                      const DerivativeOptions& options) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// The coefficients of a flow, for each segment: the displacements of its lattice, or the coefficients of its grid and
// then those at its end; none for another segment. What a grid's growth adds is not among them.
using FlowCoefficients = std::vector<std::vector<Vec3d>>;

// Returns the coefficients of a flow.
FlowCoefficients coefficients_of(const Flow& flow);

// Forwards: returns the deformed position of each point, and its derivative when the coefficients change in a
// direction. The direction has as many as coefficients_of() returns. Throws as SessionDerivatives::jvp().
PointTangents coefficient_jvp(const Flow& flow, std::span<const Vec3d> points, const FlowCoefficients& direction,
                              const DerivativeOptions& options);

// The gradient of a function of the deformed points with respect to the undeformed points and the coefficients.
struct CoefficientGradient {
  std::vector<Vec3d> points;
  FlowCoefficients coefficients;
};

// Backwards, as SessionDerivatives::vjp(), for any number of coefficients: those of grids may also be 0. Time
// (docs/decisions/0037-derivatives.md): a few times that of deform at its tolerance of 1e-5; for a grid some 30 times
// at 1e-8.
CoefficientGradient coefficient_vjp(const Flow& flow, std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                                    const DerivativeOptions& options);

// Values measured on a surface, with their derivatives with respect to its points: constraints for an optimiser. Where
// a value has no derivative, as a thickness measured onto an edge, the derivative on one side is given.
struct SurfaceMeasures {
  std::vector<double> values;
  // Value i depends on the points vertices[ends[i - 1]] to vertices[ends[i] - 1] (from 0 for the first value), and has
  // the derivatives at the same indices with respect to them.
  std::vector<std::size_t> ends;
  std::vector<std::uint32_t> vertices;
  std::vector<Vec3d> derivatives;
  std::size_t points = 0;  // of the surface

  // Returns the derivative of each value when the points move along the tangents. Throws InvalidInput unless there is
  // one tangent for each point.
  std::vector<double> jvp(std::span<const Vec3d> tangents) const;
  // Returns the gradient of the weighted sum of the values with respect to the points. Throws InvalidInput unless there
  // is one weight for each value.
  std::vector<Vec3d> vjp(std::span<const double> weights) const;
};

// The following functions throw InvalidInput for a number that is no vertex, and for coordinates that are not finite.
// Triangles are counter-clockwise seen from outside.

// Returns the volume within a closed surface. Throws InvalidInput if it is open.
SurfaceMeasures volume_of(std::span<const Vec3d> points, std::span<const Triangle> triangles);

// Returns the area of a surface.
SurfaceMeasures area_of(std::span<const Vec3d> points, std::span<const Triangle> triangles);

// Returns the wall thickness at each of the vertices: the distance along the inward normal to the other side. The
// normal is the mean of those of the faces around, weighted by area. Throws InvalidInput where there is no other side.
SurfaceMeasures thickness_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices);

// Returns the mean curvature at each of the vertices: 1 / r on a sphere, below 0 in hollows. Throws InvalidInput at a
// border. Method: the cotangent Laplacian (Meyer et al. 2003), divided by a third of the area of the faces around.
SurfaceMeasures curvature_at(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                             std::span<const std::uint32_t> vertices);

// Returns the distance of each of the vertices from a patch. The derivative of a distance of 0 is given as 0.
SurfaceMeasures patch_distance(std::span<const Vec3d> points, std::span<const std::uint32_t> vertices,
                               std::span<const Triangle> patch);

}  // namespace knead
