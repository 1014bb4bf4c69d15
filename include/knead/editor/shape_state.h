// A shape that strokes deform, one after the other, and its states for undo.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/remesh.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead {

struct SplatJacobians;  // mesh.h

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
  // Ends the remeshing after a stroke when this time is over; above 0. The result is then the best mesh so far, which
  // depends on the machine.
  double seconds = kInfinity;
};

// Where the vertices and faces of a remeshed shape come from in the shape at the start.
struct Provenance {
  std::vector<std::uint32_t> face_source;    // for each face: the face at the start that it lies in
  std::vector<std::uint32_t> vertex_source;  // for each vertex: the vertex at the start, or kNewVertex
  std::vector<bool> touched;                 // for each vertex: whether it, or the surface there, has moved
  // For each vertex: the place of its point of the surface at the start, and before the last stroke that was remeshed.
  // That of a new vertex lies between those of the old ones.
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
  std::vector<Vec3d> normals{};                    // as many as the shape carries
  std::shared_ptr<const Provenance> provenance;    // null: the faces are those at the start
  Mask mask{};                                     // of the strokes that follow
  std::shared_ptr<const SplatJacobians> splats{};  // DeformedShape::splats()

  // Returns the mesh with the positions.
  Mesh to_mesh() const;

  // Returns the memory of `splats`.
  std::size_t splat_bytes() const;

  // Returns whether both have the same faces, mask and splats, and positions with the same bits. Compares pointers
  // only.
  bool is_same(const ShapeState& other) const;
};

// What one stroke did.
struct StrokeOutcome {
  AdvectStatus status = AdvectStatus::done;
  std::vector<SessionStroke> parts;     // the stroke as strokes that read no surface
  std::optional<double> penetration{};  // of a stamp: how deep the surface is left in its tool
  std::vector<std::string> warnings;    // a sentence each
  std::string shortfall{};              // where the stroke fell short of what was asked; empty if it did not
  double reached = 1;                   // the part of the stroke that was made, from 0 to 1
};

// The result of DeformedShape::remesh().
struct RemeshOutcome {
  AdvectStatus status = AdvectStatus::done;
  // Says from which the vertices and faces come; its mesh has been moved into the shape. Nothing if the status is not
  // done or the flow is empty.
  std::optional<Remeshed> remeshed;
};

// Returns a pointer that does not own the mesh. The mesh must outlive it.
std::shared_ptr<const Mesh> borrow(const Mesh& mesh);

namespace detail {

class MeshFollower;  // which remeshes a shape
struct RelaxMesh;    // what relaxing needs to know of the faces
struct MovedSplats;  // what a move makes of splats

// Normals of points, carried by the Jacobian of the flow. Four points around each point that has a normal, in the plane
// across it, show how the flow turns that plane: a map with the Jacobian J takes the normal t1 x t2 to J t1 x J t2.
struct TransportedNormals {
  std::vector<Vec3d> normals;         // at the beginning
  std::vector<std::uint32_t> vertex;  // whose points begin[4 k] to begin[4 k + 3] are
  std::vector<Vec3d> begin;           // p + a, p - a, p + b, p - b
  std::vector<Vec3d> now;             // the same points after the flow
  std::optional<PointBlocks> blocks{};
  double offset = 0;  // length of a and b
};

}  // namespace detail

// A shape that strokes deform. It is a value: copies are independent, and share the faces.
//
// Every bit of the result follows from the shape at the start, the strokes and the accuracy; not from threads, undo, or
// the pieces in which strokes were applied.
class DeformedShape {
 public:
  DeformedShape() = default;  // without vertices

  // `normals`: one for each vertex, or none; meant for points without faces. They turn with the deformation, with an
  // error of about 1e-5. Each costs four more path lines in double precision. Throws InvalidInput where
  // validate(*mesh) does, for options out of range, and for labels or normals of another number.
  explicit DeformedShape(std::shared_ptr<const Mesh> mesh, MotionOptions motion = {}, RemeshPolicy remesh = {},
                         std::vector<Vec3d> normals = {});

  // Returns the positions of the vertices.
  const std::vector<Vec3d>& positions() const& { return positions_; }
  std::vector<Vec3d> positions() && { return std::move(positions_); }
  const Mesh& mesh() const { return *mesh_; }  // faces and attributes, with positions from when the faces were made
  Mesh to_mesh() const;                        // the mesh with the positions, and splats as they are now
  std::vector<Vec3d> normals() const;          // as many as were given; for a remeshed shape one for each vertex
  // Returns one of them, without computing the others. The shape must carry normals.
  Vec3d normal(std::uint32_t vertex) const;
  // Returns whether the shape carries normals.
  bool has_normals() const { return normals_.has_value(); }
  // From now on, moves change the splats among the vertices, too: those in these ranges, which ascend, by
  // their numbers at the start. Their centres then follow path lines as exact as the Jacobians: 1e-7 of the size.
  void carry_splats(std::vector<IndexRange> splats);
  // While splats are held, moves change their centres only, like those of other points: for a preview.
  void hold_splats(bool are_held) { are_splats_held_ = are_held; }
  // Returns the Jacobians of all moves since carry_splats(), by the splats' numbers at the start; null without that.
  const std::shared_ptr<const SplatJacobians>& splats() const { return splats_; }
  // Returns the triangles of the faces; a polygon is always cut in the same way. They name the first vertex at each
  // place, as WeldedMesh does.
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

  // Keeps points where Session::constraint wants them in all moves that follow; null: none. For a shape without faces.
  void constrain(std::shared_ptr<const PointConstraint> constraint) { constraint_ = std::move(constraint); }
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

  // Relaxes the surface at the points `from` to `to` of the stroke, counted from 0. A fraction at the end applies this
  // part of the amount at that point. The faces stay. Returns done or cancelled; then the shape is part-way. Throws
  // InvalidInput for a point cloud.
  AdvectStatus relax(const RelaxStroke& stroke, double from, double to, Progress* progress = nullptr);

  // Returns how often relax() has changed the shape since the start.
  std::uint64_t dabs() const { return dabs_; }

  // Makes the mesh follow a flow that has moved the vertices from `before` to where they are. Where triangles cross
  // that did not before, halves the flow, up to three times and where that may help, and makes the mesh follow one half
  // after the other. On a status other than done the faces stay.
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
  // Replaces the shape by a state of it.
  void restore(const ShapeState& state);

  // Sorts the vertices for the first move (about 60 ns a vertex), so that it takes no longer than later ones.
  void prepare();

  // Frees the memory that only moving needs, 28 bytes a vertex. The next move sets it up again.
  void free_layout();

 private:
  friend class detail::MeshFollower;

  void start_normals(std::vector<Vec3d> normals);
  void lay_out(bool sorted);
  std::vector<std::uint32_t> splats_in_support(const Flow& flow) const;
  detail::MovedSplats moved_splats(const Flow& flow, AdvectOptions options) const;
  void put(const detail::MovedSplats& moved);
  void take_splats(const std::vector<bool>& vertices, const DeformedShape& from);
  AdvectResult move_vertices(const Flow& flow, const AdvectOptions& options);
  AdvectResult move_constrained(const Flow& flow, const AdvectOptions& options);
  const detail::RelaxMesh& relax_mesh() const;

  std::shared_ptr<const Mesh> start_ = std::make_shared<const Mesh>();
  std::shared_ptr<const Mesh> mesh_ = start_;
  std::shared_ptr<const Provenance> provenance_;
  mutable std::shared_ptr<const std::vector<Triangle>> triangles_;  // of mesh_, from when they are first needed
  mutable std::shared_ptr<const detail::RelaxMesh> relax_mesh_;     // the same
  MotionOptions motion_;
  std::shared_ptr<const RemeshPolicy> policy_ = std::make_shared<const RemeshPolicy>();
  mutable std::optional<std::pair<RemeshSettings, RemeshTargets>> targets_;  // the latest that were asked for
  double reference_length_ = 1;
  std::vector<Vec3d> positions_;
  std::optional<PointBlocks> blocks_;         // the same positions laid out for moving, from the first move on
  bool is_sorted_ = false;                    // the blocks
  std::size_t segments_ = 0;                  // that have moved the vertices since the start or a restore
  std::vector<std::uint32_t> earlier_steps_;  // before the blocks were made; empty: none
  std::optional<detail::TransportedNormals> normals_;
  std::vector<IndexRange> splat_ranges_;
  std::shared_ptr<const SplatJacobians> splats_;  // null: not carried
  bool are_splats_held_ = false;
  Mask mask_;
  std::shared_ptr<const PointConstraint> constraint_;
  double put_back_ = 0;
  AdvectResult work_;
  std::uint64_t dabs_ = 0;
};

}  // namespace knead
