// Applies a session to a shape.
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

#include "knead/animation.h"
#include "knead/editor/shape_state.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/session.h"

namespace knead {

// forwards: the strokes in their order.
// backwards: the inverse strokes, the latest first, which restores a deformed shape.
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

// The most frames, and the most that are held at each end.
inline constexpr int kMaxFrames = 1'000'000;

// How the time of an animation runs. Smooth: slowly at its beginning and end (3 t^2 - 2 t^3 of the linear one).
enum class Ease { linear, smooth };

// Moments of the deformation, evenly spaced in time, the start and the end among them; 1: the end only; 0: none. A
// stroke takes SessionStroke::duration.
struct FrameOptions {
  int count = 0;
  Ease ease = Ease::linear;
  int hold = 0;  // further frames of the start before the others, and of the end after them; 0 or more
  // For a session that remeshes. True: every frame has the vertices and faces of the result; the flow takes the
  // vertices back to their places at each moment. False: each frame has faces of its own.
  bool same_faces = false;
  std::function<void(const ReplayFrame&)> deliver{};  // called for one frame after the other
};

// Returns how many frames are delivered: count, and those that are held.
int frame_count(const FrameOptions& frames);

// What one stroke did, up to where it was applied.
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
  std::vector<Vec3d> normals{};                           // DeformedShape's
  std::vector<IndexRange> splats{};                       // of several meshes, see splats_among(); of one its own
  std::function<void(const AppliedStroke&)> on_stroke{};  // called when a stroke is complete
  Progress* progress = nullptr;                           // counts up to Replay::work(), its total
  // Keeps the result of a stroke after which triangles cross that did not before, although the mesh followed it. False:
  // such a stroke is refused (RemeshLimit), unless RemeshPolicy::seconds ended the work.
  bool may_cross = false;
  // Refuses (QualityLimit) a result whose faces are far from the exact image of the surface: a root mean square of more
  // than 1e-2 of the size, or a fraction of 1e-2 of the volume; where the mesh follows, 1e-3 of the size, or 1e-2 at
  // one place. Also refuses a flow that moves faces, but no vertex. False: a warning.
  bool must_follow = false;
  bool strokes_warn = true;  // false: the result lacks Replay::warnings(), for a caller who has shown them
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
  std::optional<double> penetration{};         // the deepest of all stamps, each at its end, into the stamp's tool
  std::shared_ptr<const VolumeCells> cells{};  // of the session's mesh, see on_walls(); null: none
  std::vector<SessionStroke> resolved;  // the applied strokes as strokes that read no surface, in the session's order
  std::vector<std::string> warnings;    // each with the session's file and line
  std::vector<std::string> shortfalls;  // the same: where a stroke fell short of what was asked; the result is sound
};

// Applies a session to a shape, which stays as it is. The result depends only on the mesh, the motion, the remesh
// policy, the part and the normals, bit for bit. The last frame is the result, and every frame is the result of a
// replay until that moment (with FrameOptions::same_faces, up to the tolerance and the faces).
//
// A stroke that reads the surface reads it as the standard MotionOptions give it, whatever the options: `resolved` does
// not depend on them. With other options a second shape is deformed by those, for such sessions.
//
// Remeshing: a stroke moves the vertices, then the mesh follows once (knead/remesh.h), also where the stroke resolves
// to several. Frames within a stroke are remeshed from the beginning of the stroke. Handles given by the numbers of
// vertices are refused once a remesh has changed the numbers. Point clouds are not remeshed, and no shape is remeshed
// backwards. Where remeshing leaves triangles that cross and did not before, RemeshLimit is thrown with the session's
// line; see ReplayOptions::may_cross.
//
// Relax strokes are not in `resolved`, for they are no flows. They are refused backwards, for point clouds, and where
// frames have the same faces as a remeshed result.
//
// Throws InvalidInput where validate(*mesh) does and for options out of range before anything is done, and with the
// session's line for a stroke that the shape cannot take, perhaps after frames were delivered.
ReplayResult replay(const std::shared_ptr<const Mesh>& mesh, const Session& session, const ReplayOptions& options = {});

// Does the same for a mesh that is not shared: moved or copied into the result.
ReplayResult replay(Mesh mesh, const Session& session, const ReplayOptions& options = {});

namespace session_detail {

struct Plan;  // what a replay does, in order

}  // namespace session_detail

// replay() in steps, for a caller who wants to know before the work begins what it will be. The first of work() and
// run() makes the plan: it checks the strokes, makes the flows of those that read no surface, and reads stamps.
class Replay {
 public:
  // The session and the options must outlive the object. Costs nothing.
  Replay(std::shared_ptr<const Mesh> mesh, const Session& session, const ReplayOptions& options);
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;
  ~Replay();

  // Returns whether the mesh is to follow a stroke. Costs nothing.
  bool remeshes() const;

  // Returns the warnings about the strokes as they are written, each with the session's file and line. Of a stroke of
  // many pins this takes about 0.15 s.
  std::vector<std::string> warnings() const;

  // Returns what run() adds to Progress::done if it is not cancelled. Throws as run().
  std::uint64_t work();

  // Returns what replay() does. May be called once.
  ReplayResult run();

 private:
  session_detail::Plan& plan();

  std::shared_ptr<const Mesh> mesh_;
  const Session& session_;
  const ReplayOptions& options_;
  std::unique_ptr<session_detail::Plan> plan_;
};

// Returns the flow of a session that reads no surface, for any points: advect() with it moves points as replay() does,
// bit for bit, where no limit cylinder is torn. Throws InvalidInput for a part out of range, and with the session's
// line for a stroke that reads the surface, or relaxes it, and for a mask by the numbers of vertices.
Flow flow_of(const Session& session, const SessionPart& part = {}, int threads = 0);

// Returns whether replay() looks at the faces: to read the surface, to relax it, to check a limit cylinder, or to
// remesh. If not, advect() by flow_of(session) gives the same positions, bit for bit.
bool needs_faces(const Session& session);

// Returns a function for FrameOptions::deliver that writes all frames to one file, which appears after the last frame.
// is_remeshed: Replay::remeshes(); FrameOptions::same_faces must then be set, and the file has the faces of the result
// and no other attributes. The source must outlive the function. Throws as AnimationFile.
std::function<void(const ReplayFrame&)> animation_writer(const std::filesystem::path& path, const ShapeFile& source,
                                                         bool is_remeshed, const AnimationOptions& options);

// Returns the vertices that are splats (splats.h), by their numbers in JoinedMeshes of these meshes. Throws
// InvalidInput for splats with another number of harmonics than there can be.
std::vector<IndexRange> splats_among(std::span<const Mesh* const> meshes);

// Splits long splats, and returns false if the session bends none. A splat is split where the second
// difference of the flow over a standard deviation is above 0.1 of the splat after it: into pieces along that axis, of
// the same covariance, which together are as opaque as it was. Again until it holds, the worst first, and only as long
// as there are at most `max_splats` (by default twice as many as before). The pieces are copies of the splat's row with
// other centres, sizes and opacities: the first in its place, the others after all. A splat of which a part would run
// away (AdvectStatus::step_limit) stays whole; backwards, one of which the flow forwards would not bend the result.
// Options: motion, part and what replay() needs for strokes that read the surface. `notes`: null, or what gets a
// sentence on how many run away, and one on how many need more pieces than the limit allows. Throws as replay() and
// flow_of().
bool split_splats(ShapeFile& shape, const Session& session, const ReplayOptions& options,
                  std::optional<std::size_t> max_splats = {}, std::vector<std::string>* notes = nullptr);

// Writes what the source has become with all else that it has, as write_shape or write_remeshed: also the normals of
// points, and splats. Throws as these.
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

// Writes what became of the part in a state of JoinedMeshes::mesh(), with all else that its source has, as write_shape
// or write_remeshed. Throws as these.
void write_part(const std::filesystem::path& path, const ShapePart& part, const ShapeState& state,
                const WriteOptions& options = {});

// Returns a function for FrameOptions::deliver that writes the frames of the part, as animation_writer does. The part's
// source and `joined` must outlive it.
std::function<void(const ReplayFrame&)> part_animation_writer(const std::filesystem::path& path, const ShapePart& part,
                                                              const AnimationOptions& options);

}  // namespace knead
