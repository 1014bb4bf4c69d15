// What a deformation did: the certificate of its result, and the JSON report of the command.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/fit.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/vec.h"

namespace knead {

// What is in a shape. The members, and those of `measures`, are the keys of `knead info --json`.
struct ShapeInfo {
  std::string format;  // of its file; empty: of none
  Measures measures;
  std::vector<std::string> attributes;  // names
  std::vector<std::string> notes;       // what the reader found odd, and defects of the mesh

  // Of a volume mesh: the number of its cells, and the name and number of points of each patch.
  std::optional<std::size_t> cells{};
  std::vector<std::pair<std::string, std::size_t>> patches{};
};

// Returns what is in a shape, with the reader's notes if it is from a file. Time: linear.
ShapeInfo describe(const Mesh& mesh);
ShapeInfo describe(const ShapeFile& file);
// Does this for a file that was read from the path, with its cells and patches; a note says why these cannot be read.
ShapeInfo describe(const ShapeFile& file, const std::filesystem::path& path);

// Whether a surface is sound. The members are keys of `knead check --json`.
struct SurfaceCheck {
  ShapeInfo info;
  SelfIntersections self_intersections;
  std::size_t folded_edges = 0;                  // knead/mesh.h
  std::optional<std::size_t> flipped_triangles;  // since an earlier shape, if one was given
  std::optional<std::size_t> crossings_between;  // of self_intersections: of two shapes, if there are several
  std::optional<CellCheck> cells{};              // of a volume mesh
};

// Looks for what is wrong with a surface. `info` describes it; a note is added where the count of intersections needs
// one. progress: cancels the search for intersections, which then throws Cancelled.
SurfaceCheck check_surface(const Mesh& mesh, ShapeInfo info, const Progress* progress = nullptr);
// Does this for several shapes as one surface.
SurfaceCheck check_surfaces(const JoinedMeshes& joined, ShapeInfo info, const Progress* progress = nullptr);

// Return one JSON object, indented, with a line end.
std::string to_json(const ShapeInfo& info);
std::string to_json(const ShapeSummary& summary);
std::string to_json(const SurfaceCheck& check);

// The distance between the result of one stroke and the true image of the surface before it, at the vertices and the
// centres of the faces that the stroke moved; relative to the diagonal of the input's box. The points are carried back
// by the inverse flow. Their distance g from the surface there, divided by |grad g|, is the distance here to the first
// order; grad is taken with respect to the place after the stroke. Where the stroke presses a surface flat, g is many
// times the distance here.
struct StrokeDistance {
  std::size_t line = 0;  // of the session
  std::size_t points = 0;
  double rms = 0;
  double max = 0;
  double back_rms = 0;  // of g
  double back_max = 0;
};

// Statements about the result, with its positions as they are written. The members are the keys of the report.
struct Certificate {
  std::uint64_t crossings_before = 0;  // pairs of triangles, by exact predicates (knead/mesh.h)
  std::uint64_t crossings_after = 0;
  std::size_t flipped_triangles = 0;  // Report::flipped_triangles
  std::size_t degenerate_before = 0;
  std::size_t degenerate_after = 0;
  bool closed_before = false;
  bool closed_after = false;
  std::int64_t euler_before = 0;
  std::int64_t euler_after = 0;
  // after / before - 1; nothing for a shape without a volume. It has two parts. integration: the mean of det J - 1 over
  // path lines of moved vertices (flow/path_jacobian.h), summed over the strokes. sampling: the rest, the error of
  // triangles that stand for a curved surface. Strokes that change volumes on purpose count for neither of the two:
  // then `sampling` is nothing.
  std::optional<double> volume_error;
  double volume_error_integration = 0;
  std::optional<double> volume_error_sampling;
  // Of strokes that change volumes on purpose: the least and greatest det J of one of them, at its moved vertices;
  // nothing if there are none. Above 0: nothing is turned inside out.
  std::optional<double> det_least;
  std::optional<double> det_greatest;
  // The greatest motion of a vertex around which the flow of the stroke can move nothing; a length, 0 if all is well.
  double motion_outside = 0;
  // Of a volume mesh, in a corner or a middle node at least; nothing without cells.
  std::optional<std::size_t> inverted_cells_before;
  std::optional<std::size_t> inverted_cells_after;
  // In degrees, of triangles with area; nothing if there is none. touched_angle_after: of the faces at vertices that
  // moved; touched_angle_before: of the faces that those came from.
  std::optional<double> smallest_angle_before;
  std::optional<double> smallest_angle_after;
  std::optional<double> touched_angle_before;
  std::optional<double> touched_angle_after;
  double distance_rms = 0;  // over all strokes; StrokeDistance
  double distance_max = 0;
  double carried_back_rms = 0;
  double carried_back_max = 0;
  std::vector<StrokeDistance> strokes;
};

// Follows a replay to certify its result: pass every ReplayOptions::on_stroke to add(), in order.
class CertificateBuilder {
 public:
  // The mesh and the options are those of the replay, and must outlive the builder. Throws as replay().
  CertificateBuilder(const Mesh& mesh, const ReplayOptions& options);

  // Adds a stroke. Takes about six times as long as the stroke in double precision, plus a search for the nearest point
  // of the surface for each vertex and face that moved.
  void add(const AppliedStroke& stroke);

  // Returns the certificate. `as_float`: the result is written with float coordinates.
  Certificate finish(const ReplayResult& result, bool as_float) const;

 private:
  const Mesh& mesh_;
  const ReplayOptions& options_;
  double length_;  // that tolerance and distances are relative to
  double drift_ = 0;
  std::optional<double> det_least_;
  std::optional<double> det_greatest_;
  double motion_outside_ = 0;
  std::vector<StrokeDistance> strokes_;
};

// Certifies positions that some other program, or an earlier run, has computed for a session: as if the last stroke had
// moved the vertices of `before` there. `after`: one for each vertex. Replays the session for it. Throws InvalidInput
// as replay(), for positions that are not finite or of another number, and for a session that remeshes; Cancelled.
Certificate certify(const Mesh& before, std::span<const Vec3d> after, const Session& session,
                    const ReplayOptions& options = {});

// Returns one JSON object, indented, with a line end.
std::string to_json(const Certificate& certificate);

// How far two surfaces are apart: the distances of the vertices of each from the other, both together.
struct SurfaceDistance {
  double mean = 0;
  double percentile_95 = 0;  // 95% are at most this
  double max = 0;
};

// Returns the distance of each vertex of a shape from the surface of another, or from its nearest point if that has no
// faces. Adds the number of vertices to progress->done. Throws as distance_between().
std::vector<double> vertex_distances(const Mesh& from, const Mesh& to, int threads = 0, Progress* progress = nullptr);

// Returns the distance of two shapes; of points where a shape has no faces. Throws InvalidInput where validate() does,
// and for a shape without vertices; Cancelled. Time: two searches for the nearest point a vertex, about 10 us each.
SurfaceDistance distance_between(const Mesh& a, const Mesh& b, int threads = 0, Progress* progress = nullptr);

// Returns one JSON object, indented, with a line end.
std::string to_json(const BodyFitReport& report);

// Wall-clock times.
struct ReportSeconds {
  double read = 0;
  double deform = 0;
  double write = 0;
  double measure = 0;  // the shape before and after, for the report
  double total = 0;
};

// What remeshing did. The members are the keys of the report's "remesh".
struct RemeshReport {
  std::size_t splits = 0;
  std::size_t collapses = 0;
  std::size_t flips = 0;
  // Fractions of the volume before: missed by the chords of the refined meshes, and given back by the compensation.
  std::optional<double> missing_volume;
  std::optional<double> compensated_volume;
  std::optional<double> volume_error_uncompensated;  // the volume error without the compensation
  bool complete = true;                              // false: edges above the targets remain
  bool out_of_time = false;                          // RemeshPolicy::seconds ended the work after a stroke
  std::size_t crossings = 0;                         // pairs where the last stroke touched the mesh
};

// The members are the report's keys.
struct Report {
  std::size_t vertices = 0;  // of the result, and so its faces
  std::size_t faces = 0;
  std::size_t moved_vertices = 0;  // new ones, and those whose position differs from the input's in any bit
  std::size_t strokes = 0;
  std::size_t segments = 0;
  double steps_mean = 0;  // accepted steps of one path line over the session; over all vertices
  std::uint32_t steps_max = 0;
  std::uint64_t vertex_steps = 0;  // accepted steps in all
  std::uint64_t evaluations = 0;
  std::uint64_t rejected_steps = 0;
  ReportSeconds seconds;
  int threads = 0;
  std::string simd;  // simd_name()
  std::string backend = "cpu";
  Precision precision = Precision::float32;
  double tolerance = 0;  // relative to the box diagonal
  double volume_before = 0;
  double volume_after = 0;
  std::optional<double> volume_error;  // after / before - 1; nothing unless closed and oriented
  double area_before = 0;
  double area_after = 0;
  double max_displacement = 0;  // of the vertices that the input had
  // The greatest stretch of a triangle from the input to the result (knead/tools.h); nothing without a triangle that
  // has an area. For a remeshed shape the places of new vertices in the input are interpolated.
  std::optional<double> greatest_stretch;
  // Triangles that oppose the normals of their vertices now, but did not before. For a remeshed shape: how many more
  // such triangles than in the input.
  std::size_t flipped_triangles = 0;
  std::optional<double> penetration;                       // ReplayResult::penetration
  std::optional<std::uint64_t> self_intersections_before;  // pairs; nothing unless the caller counted them
  std::optional<std::uint64_t> self_intersections_after;
  std::optional<std::uint64_t> crossings_between{};  // pairs of triangles of two shapes; if there are several
  std::optional<RemeshReport> remesh;                // if the result was remeshed
  std::optional<CellCheck> cells{};                  // of a volume mesh, after: the key "volume_cells"
  std::optional<Certificate> certificate;            // if the caller made one
};

// Returns the report on a replay with these options that ended in `done`. `mesh`: the shape before it. Linear time.
Report make_report(const Mesh& mesh, const ReplayResult& result, const ReplayOptions& options,
                   const ReportSeconds& seconds);

// Returns one JSON object, indented, with a line end; an absent number is null.
std::string to_json(const Report& report);

// How far a session can be applied to a volume mesh before it spoils a cell, and what would let it go farther.

// How far something holds, in strokes.
struct SafeUntil {
  double until = 0;
  double beyond = 0;  // equal to `until` if it holds to the end
};

// Returns the range in which something first fails between 0 and `most` strokes. It samples every 16th of a stroke
// (from 16 strokes on, every 256th of the whole) in order, and bisects the range before the first sample that fails ten
// times.
//
// Guaranteed: holds(until) was true, or `until` is 0, which is taken to hold; holds(beyond) was false; it was true at
// every sample below. Not seen: a failure that begins and ends between two samples, or between two of the bisection.
SafeUntil safe_until(double most, const std::function<bool(double until)>& holds);

// Returns how many strokes come before the one that fails at `beyond`.
std::size_t strokes_before(const SafeUntil& range);

// What a search for spoiled cells needs to know.
struct SafeCellsOptions {
  // 0: a cell is spoiled if it is inverted, exactly. Below 1: also if its scaled Jacobian falls below this. Cells that
  // were below it before, or flat, do not count.
  double least_scaled_jacobian = 0;
  SessionPart part{};
  MotionOptions motion{};
  Progress* progress = nullptr;  // cancels the search, which then throws Cancelled
};

// How far a session can be applied to a volume mesh, and what ends it.
struct SafeCells {
  AdvectStatus status = AdvectStatus::done;  // step_limit: nothing else is known; see kStepLimitAdvice
  SafeUntil range;                           // within it no cell is spoiled
  std::optional<std::size_t> cell;           // the worst spoiled cell at range.beyond; empty: the whole session is safe
  double scaled_jacobian = 1;                // of that cell, there; as in CellChanges
  std::optional<double> outer;               // of the stroke that spoils it: widest_outer()
};

// Returns how far a session can be applied before it spoils a cell; safe_until() says what is guaranteed. Points that
// advect() moves by flow_of(session, part) with part.until = range.until are those that were judged. Time: up to 26
// times that of the flow for one stroke, and of judging the cells that it moves. Throws InvalidInput for a bound out of
// range, and as flow_of(session, part), compare_cells() and advect(); Cancelled.
SafeCells safe_until(const Session& session, const Cells& cells, std::span<const Vec3d> points,
                     const SafeCellsOptions& options = {});

}  // namespace knead
