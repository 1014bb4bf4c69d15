// A session applied to a shape.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/flow/backend.h"
#include "knead/mesh/mesh.h"
#include "knead/remesh/remesh.h"
#include "knead/session/session.h"

namespace knead {

// A moment of the deformation.
struct ReplayFrame {
  int index = 0;
  std::span<const Vec3d> positions;
  std::span<const Vec3d> normals;  // as many as in the options
  // The shape where strokes so far were remeshed, and for each of its faces the face of the input that it lies in. Null
  // and none: the faces are the input's.
  const Mesh* mesh = nullptr;
  std::span<const std::uint32_t> face_source{};
};

// A shape's faces with vertices at these positions, which need not be those of the mesh.
struct PosedMesh {
  const Mesh& mesh;
  std::span<const Vec3d> positions;
};

// What one stroke did, as far as it was to be done.
struct AppliedStroke {
  std::size_t line = 0;  // of the session
  const Flow& flow;      // which moved the vertices
  PosedMesh before;
  PosedMesh after;
  // How the vertices and faces came from those before, its mesh moved out into `after`; null: they are the same.
  const Remeshed* remeshed = nullptr;
};

struct ReplayOptions {
  double tolerance = 1e-5;  // position error of one path line over one segment, relative to the shape's box diagonal
  Integrator integrator = Integrator::tsitouras;
  Precision precision = Precision::float32;
  int threads = 0;  // 0: all
  // What moves the vertices; empty: advect. Normals' companions, strokes' readings of the surface and shapes that are
  // remeshed stay with that.
  Backend backend{};
  bool inverse = false;          // the strokes backwards, latest first: takes a deformed shape back
  std::optional<double> until;   // only the session's first strokes; 2.5: two, and half of the third's segments
  Progress* progress = nullptr;  // counts up to total_work
  // Of a shape without faces: a normal for each vertex, to be carried along by the flow's Jacobian. Empty: none.
  // Normals of shapes with faces follow from the faces (mesh/normals.h).
  std::span<const Vec3d> normals{};
  // `frames` moments, evenly spaced in strokes, the start and the end among them (1: the end only), given one after the
  // other to on_frame. 0: none.
  int frames = 0;
  std::function<void(const ReplayFrame&)> on_frame{};
  // Remeshing after every stroke; a stroke's own settings win. Nothing: only where strokes have settings of their own.
  std::optional<RemeshSettings> remesh{};
  // Where remeshed: one for each face of the mesh, or none; edges between faces of different labels (materials, groups)
  // are kept like seams.
  std::span<const std::uint32_t> face_labels{};
  bool single_precision = true;  // where remeshed: triangles must not cross with positions rounded to float
  std::function<void(const AppliedStroke&)> on_stroke{};  // called as each stroke is completed
};

struct ReplayResult {
  AdvectStatus status = AdvectStatus::done;
  std::size_t failed_line = 0;   // of the session, where status is step_limit: the stroke that could not be done
  std::vector<Vec3d> positions;  // of the deformed shape where status is done, else empty
  // The deformed shape where a stroke was to be remeshed, with these positions; nothing: its faces are the input's.
  std::optional<Mesh> mesh;
  std::vector<std::uint32_t> face_source;    // for each face of mesh the face of the input that it lies in
  std::vector<std::uint32_t> vertex_source;  // for each vertex of mesh the vertex of the input, or kNewVertex
  std::vector<bool> touched;                 // for each vertex of mesh: whether it, or the surface there, was moved
  RemeshCounts remesh;                       // of all strokes, added up; crossings: as the last left them
  std::vector<Vec3d> normals;                // as many as in the options
  std::vector<std::uint32_t> steps;  // accepted steps of each vertex, over the session; of a new one since it came
  std::uint64_t accepted_steps = 0;  // of all vertices, and of the points that remeshing carried
  std::uint64_t rejected_steps = 0;
  std::uint64_t evaluations = 0;
  std::size_t strokes = 0;  // applied, a part of one counting as one
  std::size_t segments = 0;
  std::optional<double> penetration;    // of the surface into a stamp's tool at its end, the deepest of all stamps
  std::vector<SessionStroke> resolved;  // the strokes applied, in the session's order, as ones that read no mesh
  std::vector<std::string> warnings;    // each with its session's file and line
};

// Applies the session to the mesh's vertices; the mesh itself stays as it is. The result depends on nothing but the
// vertices and the options other than threads, progress and frames, to the bit; the last frame is the result, and every
// frame is what `until` that moment gives. With `inverse`, `until` says which part of the session is taken back.
// Strokes that read the surface read it as it is at the default tolerance, integrator and precision, whatever the
// options: `resolved` does not depend on these, and repeats the result to the bit.
//
// Remeshing: a stroke takes the vertices from its beginning to where it is to end, then the mesh is made to follow
// (remesh/remesh.h), with targets from the input mesh, so that they are the same for all strokes. Every frame within a
// stroke is remeshed from the stroke's beginning. A stroke that reads the surface reads the remeshed one, and is
// remeshed once: not after each of the strokes that it resolves to. Marked regions given by vertices' numbers are
// refused once a remesh has changed these. Point clouds are not remeshed, nor is a shape taken back by `inverse`.
//
// Normals are accurate to about 1e-5, which costs four further path lines in double precision for each.
// Throws InvalidInput for options out of range (before anything is done), and, naming the session's line, for a stroke
// whose barrel cuts triangles of the shape as it is when the stroke begins, perhaps after frames were delivered.
ReplayResult replay(const Mesh& mesh, const Session& session, const ReplayOptions& options = {});

// What progress->done grows by in a replay that is not cancelled. Throws InvalidInput for options out of range.
std::uint64_t total_work(const Mesh& mesh, const Session& session, const ReplayOptions& options);

}  // namespace knead
