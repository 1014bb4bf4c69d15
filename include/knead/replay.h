// A shape that strokes deform, one after the other, and its states for undo.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/animation.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/session.h"

namespace knead {

// How strokes move vertices.
struct MotionOptions {
  // Position error of one path line over one segment, as a fraction of the diagonal of the shape's box; above 0.
  double relative_tolerance = kDefaultRelativeTolerance;
  std::optional<double> diagonal{};  // a length that takes the place of the diagonal; above 0
  Integrator integrator = Integrator::tsitouras;
  Precision precision = Precision::float32;
  Backend backend{};  // moves the vertices, and the points that remeshing adds; empty: advect
  int threads = 0;    // 0: all

  // Returns whether the accuracy is the default one, on the CPU. Strokes that read the surface always read it with this
  // accuracy.
  bool is_standard() const;
};

// Returns the length that relative tolerances and distances refer to, if MotionOptions::diagonal does not give another:
// the diagonal of shape_box(), or 1 for a single point; of positions alone that of a cloud. Throws InvalidInput if a
// coordinate is above 1e18, or the shape is shorter than 1e-15.
double reference_length(const Mesh& mesh);
double reference_length(std::span<const Vec3d> positions);

// Returns the options of advect() for a shape with this reference length. Throws InvalidInput if the tolerance is not
// above 0 and finite, relative or as a length, or if the number of threads is below 0.
AdvectOptions advect_options(const MotionOptions& options, double reference_length);

// How the mesh follows the strokes.
struct RemeshPolicy {
  // Remeshes after every stroke; a stroke's own settings win. Nothing: only after strokes with settings of their own.
  std::optional<RemeshSettings> settings{};
  // One for each face, or empty. Edges between faces of different labels (materials, groups) are kept like seams.
  std::vector<std::uint32_t> face_labels{};
  bool single_precision = true;  // triangles must not cross with positions rounded to float
  // The time for the mesh to follow one stroke: above 0. Then the best mesh so far is kept, which depends on the
  // machine.
  double seconds = kInfinity;
};

// Where the vertices and faces of a remeshed shape come from in the shape at the start.
struct Provenance {
  std::vector<std::uint32_t> face_source;    // for each face: the face at the start that it lies in
  std::vector<std::uint32_t> vertex_source;  // for each vertex: the vertex at the start, or kNewVertex
  std::vector<bool> touched;                 // for each vertex: whether it, or the surface there, has moved
  // For each vertex: where this point of the surface was at the start, and before the last stroke that was remeshed. A
  // new vertex has a place between those of the old ones.
  std::vector<Vec3d> rest;
  std::vector<Vec3d> before_stroke;
  std::optional<std::vector<MeshEdge>> creases;  // of the shape before the first remesh, as they are now
  RemeshCounts counts;                           // sums over all strokes; crossings: after the last one
  bool is_renumbered = false;                    // vertices have other numbers than at the start
};

// The indices from begin to end, without end.
struct IndexRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

// Positions that share memory with an earlier snapshot where they are the same. Immutable; copies are cheap, and any
// thread may read them.
class Snapshot {
 public:
  static constexpr std::size_t kChunk = 1024;  // vertices that are shared together

  Snapshot() = default;

  // Shares every chunk whose positions have the same bits as in `before`, if that has as many vertices. Costs a
  // comparison, and a copy of what differs. threads as for parallel_for.
  Snapshot(std::span<const Vec3d> positions, const Snapshot& before, int threads = 0);

  // Returns the number of vertices.
  std::size_t size() const { return size_; }
  const Vec3d& operator[](std::size_t i) const { return (*chunks_[i / kChunk])[i % kChunk]; }

  // Copies the positions.
  void copy_to(std::span<Vec3d> positions) const;  // size() places
  std::vector<Vec3d> copy() const;

  // Returns the vertices, by whole chunks, that may differ from a snapshot of the same size; neighbouring chunks are
  // joined. Returns all vertices if the sizes differ.
  std::vector<IndexRange> changes_since(const Snapshot& before) const;

  // Returns the bytes of the chunks that `before` does not share.
  std::size_t bytes_beyond(const Snapshot& before) const;

  // Calls visit(address, bytes) for each chunk; snapshots share those with the same address.
  template <class Visit>
  void for_each_chunk(const Visit& visit) const {
    for (const auto& chunk : chunks_) visit(static_cast<const void*>(chunk.get()), sizeof(Chunk));
  }

  // Returns the bytes that a snapshot takes without its chunks.
  std::size_t table_bytes() const { return chunks_.capacity() * sizeof(chunks_.front()); }

 private:
  using Chunk = std::array<Vec3d, kChunk>;  // zero beyond the last vertex

  std::size_t size_ = 0;
  std::vector<std::shared_ptr<const Chunk>> chunks_;
};

// A deformed shape at one moment. Immutable; copies are cheap, and any thread may read them.
struct ShapeState {
  std::shared_ptr<const Mesh> mesh;  // faces and attributes, with the positions from when the faces were made
  Snapshot positions;
  std::vector<Vec3d> normals{};                  // as many as the shape carries
  std::shared_ptr<const Provenance> provenance;  // null: the faces are those at the start
  Mask mask{};                                   // of the strokes that follow

  // Returns the mesh with the positions.
  Mesh to_mesh() const;

  // Returns whether both have the same faces and mask, and positions with the same bits. Compares pointers only.
  bool is_same(const ShapeState& other) const;
};

// What one stroke did.
struct StrokeOutcome {
  AdvectStatus status = AdvectStatus::done;
  std::vector<SessionStroke> parts;     // the stroke as strokes that read no surface
  std::optional<double> penetration{};  // of a stamp: how deep the surface is left in its tool
  std::vector<std::string> warnings;    // a sentence each
};

// The result of a remesh.
struct RemeshOutcome {
  AdvectStatus status = AdvectStatus::done;
  // How the vertices and faces come from those before; its mesh has been moved into the shape. Nothing if the status is
  // not done or the flow is empty.
  std::optional<Remeshed> remeshed;
};

// Returns a pointer that does not own the mesh, for a caller who keeps the mesh alive and wants no copy of it.
std::shared_ptr<const Mesh> borrow(const Mesh& mesh);

namespace remesh_detail {

struct MorePlaces;

}  // namespace remesh_detail

namespace session_detail {

struct RelaxMesh;  // what relaxing needs to know of the faces

// Normals of points, carried by the Jacobian of the flow. Four points around each point that has a normal, in the plane
// across it, show how the flow turns that plane: a map with the Jacobian J takes the normal t1 x t2 to J t1 x J t2.
struct TransportedNormals {
  std::vector<Vec3d> normals;         // at the beginning
  std::vector<std::uint32_t> vertex;  // whose points begin[4 k] to begin[4 k + 3] are
  std::vector<Vec3d> begin;           // p + a, p - a, p + b, p - b
  std::vector<Vec3d> now;             // the same points after the flow
  std::optional<PointBlocks> blocks{};
  double reach = 0;  // length of a and b
};

}  // namespace session_detail

// A shape that strokes deform. It is a value: copies are independent, and share the faces.
//
// Every bit of the result follows from the shape at the start, the strokes and the accuracy; not from threads, undo, or
// the pieces in which strokes were applied.
class DeformedShape {
 public:
  DeformedShape() = default;  // without vertices

  // `normals`: one for each vertex, or none; meant for points without faces. They turn with the deformation, right to
  // about 1e-5, for the price of four more path lines in double precision for each. Throws InvalidInput where
  // validate(*mesh) does, for options out of range, and for labels or normals of another number.
  explicit DeformedShape(std::shared_ptr<const Mesh> mesh, MotionOptions motion = {}, RemeshPolicy remesh = {},
                         std::vector<Vec3d> normals = {});

  // Returns the positions of the vertices.
  const std::vector<Vec3d>& positions() const& { return positions_; }
  std::vector<Vec3d> positions() && { return std::move(positions_); }
  const Mesh& mesh() const { return *mesh_; }  // faces and attributes, with positions from when the faces were made
  Mesh to_mesh() const;                        // the mesh with the positions
  std::vector<Vec3d> normals() const;          // as many as were given; for a remeshed shape one for each vertex
  // Returns one of them, without computing the others. The shape must carry normals.
  Vec3d normal(std::uint32_t vertex) const;
  // Returns whether the shape carries normals.
  bool has_normals() const { return normals_.has_value(); }
  // Those of the faces, of which a polygon is always cut in the same way. They name the first vertex at each place, as
  // WeldedMesh does.
  std::span<const Triangle> triangles() const;

  // Returns whether a remesh has changed vertices or faces since the start.
  bool is_remeshed() const { return provenance_ != nullptr; }
  const Provenance* provenance() const { return provenance_.get(); }  // null: vertices and faces are those at the start
  std::vector<bool> touched() const;  // for each vertex: whether it, or the surface there, has moved

  // Returns the accepted steps of each vertex since it was made or the state restored.
  std::vector<std::uint32_t> steps() const;
  // Returns the work since the start, of all path lines, including those of points that remeshing added.
  const AdvectResult& work() const { return work_; }

  // Returns the mask of the strokes that follow: that of the latest mask stroke.
  const Mask& mask() const { return mask_; }
  void set_mask(Mask mask) { mask_ = std::move(mask); }

  // Keeps points on walls (Session::mesh_walls) in all moves that follow; null: none. The shape has no faces.
  void set_walls(std::shared_ptr<const MeshWalls> walls) { walls_ = std::move(walls); }
  // Returns the greatest distance by which a point was put back onto a wall.
  double put_back() const { return put_back_; }

  // Returns how strokes move vertices.
  const MotionOptions& motion() const { return motion_; }
  // Returns the length that relative tolerances refer to, of the shape at the start.
  double reference_length() const { return reference_length_; }
  // Returns the settings that hold for a stroke; none for a point cloud.
  std::optional<RemeshSettings> settings_of(const SessionStroke& stroke) const;

  // Applies a stroke with its remesh settings. A stroke that reads the surface reads this shape. `folder`: the paths of
  // stamps are relative to it. Throws InvalidInput for a stroke that this shape cannot take, for instance if its limit
  // cylinder cuts triangles. After an exception, or a status other than done, the shape is part-way: restore a state.
  StrokeOutcome apply(const SessionStroke& stroke, const std::filesystem::path& folder = {},
                      Progress* progress = nullptr);

  // Moves the vertices through a flow as it is: its segments bring their own masks. The faces stay. On a status other
  // than done the shape is part-way.
  AdvectStatus move(const Flow& flow, Progress* progress = nullptr);

  // Relaxes the surface at the points of the stroke from one number to another; a fraction at the end is that part of
  // the amount at that point. The faces stay. Returns done or cancelled; then the shape is part-way. Throws
  // InvalidInput for a point cloud.
  AdvectStatus relax(const RelaxStroke& stroke, double from, double to, Progress* progress = nullptr);

  // Returns how often relax() has changed the shape since the start, for telling whether it has.
  std::uint64_t dabs() const { return dabs_; }

  // Makes the mesh follow a flow that has moved the vertices from `before` to where they are. Where triangles cross
  // that did not before, the flow is halved, and the mesh follows one half after the other; three times at most, and
  // only where that can pay. On a status other than done the faces stay.
  RemeshOutcome remesh(std::span<const Vec3d> before, const Flow& flow, const RemeshSettings& settings,
                       Progress* progress = nullptr);

  // Returns the targets that follow from the settings and the shape at the start, the same for all strokes. Throws
  // InvalidInput as knead::resolve.
  const RemeshTargets& targets_of(const RemeshSettings& settings) const;

  // Takes the positions of the chosen vertices, and their counts of steps, from a shape that has the same faces.
  void take(const std::vector<bool>& vertices, const DeformedShape& from);

  // Takes these positions, one for each vertex.
  void set_positions(std::vector<Vec3d> positions);

  // Returns the shape as it is. Shares memory with `before`, which may be an empty state.
  ShapeState state(const ShapeState& before = {}) const;
  // Goes back, or forward, to a state of this shape.
  void restore(const ShapeState& state);

  // Sorts the vertices for the first move (about 60 ns a vertex), so that it takes no longer than later ones.
  void prepare();

  // Frees the memory that only moving needs, 28 bytes a vertex. The next move sets it up again.
  void free_layout();

 private:
  void start_normals(std::vector<Vec3d> normals);
  void lay_out(bool sorted);
  AdvectResult move_vertices(const Flow& flow, const AdvectOptions& options);
  AdvectResult move_on_walls(const Flow& flow, const AdvectOptions& options);
  std::uint64_t carry(const Flow& flow, Progress* progress, std::span<Vec3d> points, std::uint64_t most);
  RemeshOptions remesh_options(const RemeshSettings& settings, const std::vector<std::uint32_t>& labels) const;
  // A part of a stroke that the mesh follows.
  struct Part {
    std::span<const Vec3d> before;         // where the vertices were before the part
    std::span<const Vec3d> before_stroke;  // and before the stroke
    const Flow& flow;
  };
  struct Halving {
    int left = 0;                // how often the flow may still be halved
    bool is_narrow = false;      // a mask's border is: halves are tried, too, where the whole is much work
    double spent = 0;            // evaluations on the points of all remeshes of the stroke
    std::size_t faces = 0;       // of the whole and of the halves that have been begun
    std::size_t most_faces = 0;  // that all of them may have together; 0 before the whole
    std::chrono::steady_clock::time_point end = std::chrono::steady_clock::time_point::max();  // of the time for them
  };
  double evaluations_each(const Part& part, Progress* progress);
  RemeshOutcome remesh(const Part& part, const RemeshSettings& settings, Halving& halving, Progress* progress);
  RemeshOutcome remesh(const Mesh& mesh, const Part& part, const RemeshSettings& settings, Halving& halving,
                       Progress* progress);
  RemeshOutcome remesh_narrow(const Mesh& mesh, const Part& part, const RemeshSettings& settings, Halving& halving,
                              Progress* progress);
  RemeshOutcome remesh_in_halves(const Part& part, const RemeshSettings& settings, Halving& halving,
                                 Progress* progress);
  RemeshOutcome remesh_halves(const Part& part, const RemeshSettings& settings, Halving& halving, Progress* progress);
  static bool can_halve(const RemeshCounts& counts, const Halving& halving);
  void finish_stopped(const Mesh& mesh, const Deformation& deformation, const RemeshOptions& options, Remeshed& stopped,
                      remesh_detail::MorePlaces& places) const;
  AdvectStatus move_uncounted(const Flow& flow, Progress* progress);
  void adopt(Remeshed& remeshed, remesh_detail::MorePlaces& places, std::span<const Vec3d> before);
  const session_detail::RelaxMesh& relax_mesh() const;

  std::shared_ptr<const Mesh> start_ = std::make_shared<const Mesh>();
  std::shared_ptr<const Mesh> mesh_ = start_;
  std::shared_ptr<const Provenance> provenance_;
  mutable std::shared_ptr<const std::vector<Triangle>> triangles_;       // of mesh_, from when they are first needed
  mutable std::shared_ptr<const session_detail::RelaxMesh> relax_mesh_;  // the same
  MotionOptions motion_;
  std::shared_ptr<const RemeshPolicy> policy_ = std::make_shared<const RemeshPolicy>();
  mutable std::optional<std::pair<RemeshSettings, RemeshTargets>> targets_;  // the latest that were asked for
  double reference_length_ = 1;
  std::vector<Vec3d> positions_;
  std::optional<PointBlocks> blocks_;         // the same positions laid out for moving, from the first move on
  bool is_sorted_ = false;                    // the blocks
  std::size_t segments_ = 0;                  // that have moved the vertices since the start or a restore
  std::vector<std::uint32_t> earlier_steps_;  // before the blocks were made; empty: none
  std::optional<session_detail::TransportedNormals> normals_;
  Mask mask_;
  std::shared_ptr<const MeshWalls> walls_;
  double put_back_ = 0;
  AdvectResult work_;
  std::uint64_t dabs_ = 0;
};

// A session applied to a shape.

// forwards: the strokes in their order.
// backwards: the inverse strokes, the latest first, which restores a deformed shape.
enum class Direction { forwards, backwards };

// Which part of a session is applied, and in which direction. Strokes that are off are not counted.
struct SessionPart {
  Direction direction = Direction::forwards;
  // Only the first strokes. 2.5: two strokes and half of the third's segments. From 0 to their number; empty: all.
  std::optional<double> until{};
};

// A moment of the deformation.
struct ReplayFrame {
  int index = 0;
  const DeformedShape& shape;
};

// The most frames, and the most that are held at each end.
inline constexpr int kMaxFrames = 1'000'000;

// How the time of an animation runs. Smooth: slowly at its beginning and end (3 t^2 - 2 t^3 of the linear one).
enum class Ease { linear, smooth };

// Moments of the deformation, evenly spaced in time, the start and the end among them; 1: the end only; 0: none. Every
// stroke takes its duration, by default as long as any other.
struct FrameOptions {
  int count = 0;
  Ease ease = Ease::linear;
  int hold = 0;  // so many more frames of the start before the others, and of the end after them; 0 or more
  // Of a session that remeshes: every frame has the vertices and faces of the result. The vertices are taken back
  // through the flow, to their places at each moment. Else each frame has faces of its own.
  bool same_faces = false;
  std::function<void(const ReplayFrame&)> deliver{};  // called for one frame after the other
};

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
  std::function<void(const AppliedStroke&)> on_stroke{};  // called when a stroke is complete
  Progress* progress = nullptr;                           // counts up to total_work
  // Keeps the result of a stroke after which triangles cross that did not before, although the mesh followed it. False:
  // such a stroke is refused (RemeshLimit), unless RemeshPolicy::seconds ended the work.
  bool may_cross = false;
  // Refuses (QualityLimit) a result whose faces are far from the exact image of the surface: a root mean square of more
  // than 1e-2 of the size, or a fraction of 1e-2 of the volume; where the mesh follows, 1e-3 of the size. Also what
  // moves faces, but no vertex. False: a warning.
  bool must_follow = false;
  bool strokes_warn = true;  // false: the result lacks stroke_warnings(), for a caller who has shown them
};

// Why a replay ends in step_limit, and what to do.
inline constexpr const char* kStepLimitAdvice =
    "a path line runs to infinity or needs over a million steps here; use a wider transition, a smaller angle, another "
    "gauge, or a larger tolerance";

// How replay() ended, and what it made.
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
};

// Returns how many frames are delivered: count, and those that are held.
int frame_count(const FrameOptions& frames);

// Returns a function for FrameOptions::deliver that writes all frames to one file, which appears after the last frame.
// is_remeshed: will_remesh(...); FrameOptions::same_faces must then be set, and the file has the faces of the result
// and no other attributes. The source must outlive the function. Throws as AnimationFile.
std::function<void(const ReplayFrame&)> animation_writer(const std::filesystem::path& path, const ShapeFile& source,
                                                         bool is_remeshed, const AnimationOptions& options);

// One of several shapes that are deformed as one: what became of it in a state of JoinedMeshes::mesh(), and its file.
struct ShapePart {
  const ShapeFile& source;
  const JoinedMeshes& joined;
  std::size_t number = 0;  // of the mesh in `joined`
};

// Writes what became of the part, with all else that its source has, as write_shape or write_remeshed. Throws as these.
void write_part(const std::filesystem::path& path, const ShapePart& part, const ShapeState& state,
                const WriteOptions& options = {});

// Returns a function for FrameOptions::deliver that writes the frames of the part, as animation_writer does. The part's
// source and `joined` must outlive it.
std::function<void(const ReplayFrame&)> part_animation_writer(const std::filesystem::path& path, const ShapePart& part,
                                                              const AnimationOptions& options);

// Applies a session to a shape, which stays as it is. The result depends only on the mesh, the motion, the remesh
// policy, the part and the normals, bit for bit. The last frame is the result, and every frame is the result of a
// replay until that moment (with FrameOptions::same_faces, up to the tolerance and the faces).
//
// A stroke that reads the surface reads it as the standard MotionOptions give it, whatever the options: `resolved` does
// not depend on them. With other options a second shape is deformed by those, for such sessions.
//
// Remeshing: a stroke moves the vertices, then the mesh follows once (knead/remesh.h), also where the stroke resolves
// to several. Frames within a stroke are remeshed from the beginning of the stroke. Handles given by the numbers of
// vertices are refused once a remesh has changed the numbers. Point clouds are not remeshed, and no
// shape is remeshed backwards. Where remeshing leaves triangles that cross and did not before, RemeshLimit is thrown
// with the session's line; see ReplayOptions::may_cross.
//
// Relax strokes are not in `resolved`, for they are no flows. They are refused backwards, for point clouds, and where
// frames have the same faces as a remeshed result.
//
// Throws InvalidInput where validate(*mesh) does and for options out of range before anything is done, and with the
// session's line for a stroke that the shape cannot take, perhaps after frames were delivered.
ReplayResult replay(const std::shared_ptr<const Mesh>& mesh, const Session& session, const ReplayOptions& options = {});

// The same for a mesh that is not shared: moved or copied into the result.
ReplayResult replay(Mesh mesh, const Session& session, const ReplayOptions& options = {});

// Returns the flow of a session that reads no surface, for any points: advect() with it moves points as replay() does,
// bit for bit, where no limit cylinder is torn. Throws InvalidInput for a part out of range, and with the session's
// line for a stroke that reads the surface, or relaxes it, and for a mask by the numbers of vertices.
Flow flow_of(const Session& session, const SessionPart& part = {}, int threads = 0);

// How path lines are followed for their derivatives, always in double.
struct DerivativeOptions {
  // Error of one path line and of its derivative over one segment: of the place as a fraction of the diagonal, of the
  // derivative as a fraction of itself. From 1e-13 to 1.
  double relative_tolerance = 1e-8;
  std::optional<double> diagonal{};  // by default that of the points' box
  int threads = 0;                   // 0: as many as the machine has
  Progress* progress = nullptr;      // counts points times segments
};

// Points where a flow takes them, and how they move there per unit of a direction in the space of the parameters.
struct PointTangents {
  std::vector<Vec3d> points;
  std::vector<Vec3d> tangents;
};

// The derivatives of the map that a session applies to points with respect to its parameters, at their values. The map
// is that of the exact flow (docs/decisions/0037-derivatives.md).
class SessionDerivatives {
 public:
  // Throws InvalidInput where flow_of does; naming it, for a parameter of which the flow has no derivative: it chooses
  // a whole number or how many segments there are, or it is in a mask, or in the nodes of a grid.
  // Costs some 20 flow_of() for each parameter, each with the solution of its pins. Throws Cancelled.
  explicit SessionDerivatives(const Session& session, const SessionPart& part = {}, int threads = 0,
                              const Progress* progress = nullptr);
  SessionDerivatives(const SessionDerivatives&) = delete;
  SessionDerivatives& operator=(const SessionDerivatives&) = delete;
  ~SessionDerivatives();

  // Returns the number of the flow's segments.
  std::size_t segments() const;

  // Forwards: returns where the flow takes each of the points, and the derivative of that place along the direction,
  // one number for each parameter of the session. The bits of a result depend on its point and the diagonal alone.
  // Cost: about 0.1 ms for a point and segment of one field. Throws InvalidInput for numbers that are not finite or not
  // so many, a tolerance out of range, and a path line that needs over a million steps; Cancelled.
  PointTangents jvp(std::span<const Vec3d> points, std::span<const double> direction,
                    const DerivativeOptions& options) const;

  // Backwards: returns the gradient with respect to each parameter of a function of the deformed points, from its
  // gradient with respect to these, one vector for each point. Sums are taken in a fixed order: the result does not
  // depend on the number of threads. Cost: that of jvp() for each three parameters. Throws as jvp.
  std::vector<double> vjp(std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                          const DerivativeOptions& options) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// Returns whether replay() looks at the faces: to read the surface, to relax it, to check a limit cylinder, or to
// remesh. If not, advect() by flow_of(session) gives the same positions, bit for bit.
bool needs_faces(const Session& session);

// Returns what is to be said of the strokes before they are applied, each with the session's file and line. It is in
// ReplayResult::warnings, too. Of a stroke of many pins this takes about 0.15 s.
std::vector<std::string> stroke_warnings(const Session& session, const SessionPart& part = {});

// Returns whether replay() would return a remeshed shape.
bool will_remesh(const Mesh& mesh, const Session& session, const ReplayOptions& options);

// Returns what progress->done grows by in a replay that is not cancelled. Throws InvalidInput for options out of range.
std::uint64_t total_work(const Mesh& mesh, const Session& session, const ReplayOptions& options);

}  // namespace knead
