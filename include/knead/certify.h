// Descriptions and checks of shapes, the certificate of a result, the report of the command, and safe parts of
// sessions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
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

// A description of a shape. The members, and those of `measures`, are the keys of `knead info --json`.
struct ShapeInfo {
  std::string format;  // of its file; empty without a file
  Measures measures;
  std::vector<std::string> attributes;  // their names
  std::vector<std::string> notes;       // the reader's notes, and the defects of the mesh

  // Of a volume mesh: the number of its cells, and the name and number of points of each patch.
  std::optional<std::size_t> cells{};
  std::vector<std::pair<std::string, std::size_t>> patches{};
};

// Returns the description of a shape, with the reader's notes if it is from a file. Time: linear.
ShapeInfo describe(const Mesh& mesh);
ShapeInfo describe(const ShapeFile& file);
// Returns the description of a file that was read from the path, with its cells and patches. If these cannot be read, a
// note says why.
ShapeInfo describe(const ShapeFile& file, const std::filesystem::path& path);

// The defects of a surface. The members are keys of `knead check --json`.
struct SurfaceCheck {
  ShapeInfo info;
  SelfIntersections self_intersections;
  std::size_t folded_edges = 0;                  // knead/mesh.h
  std::optional<std::size_t> flipped_triangles;  // compared with an earlier shape, if one was given
  std::optional<std::size_t> crossings_between;  // self-intersections of two different shapes, if there are several
  std::optional<CellCheck> cells{};              // of a volume mesh
};

// Returns the defects of a surface. `info`: its description, to which a note about the intersections may be added.
// progress: cancels the search for intersections, which then throws Cancelled.
SurfaceCheck check_surface(const Mesh& mesh, ShapeInfo info, const Progress* progress = nullptr);
// Returns the defects of several shapes as one surface.
SurfaceCheck check_surfaces(const JoinedMeshes& joined, ShapeInfo info, const Progress* progress = nullptr);

// Return one JSON object, indented, with a line end.
std::string to_json(const ShapeInfo& info);
std::string to_json(const ShapeSummary& summary);
std::string to_json(const SurfaceCheck& check);

// The distance between the result of one stroke and the true image of the surface before it, at the vertices and the
// centres of the faces that the stroke moved; relative to the diagonal of the input's box. The inverse flow carries the
// points back. Their distance g from the surface there, divided by |grad g|, is the distance to first order; the
// gradient is with respect to the position after the stroke. Where the stroke flattens a surface, g is many times the
// distance.
struct StrokeDistance {
  std::size_t line = 0;  // of the session
  std::size_t points = 0;
  double rms = 0;
  double max = 0;
  double back_rms = 0;  // of the distance g
  double back_max = 0;
};

// Statements about the result, with its positions as they are written to the file. The members are the keys of the
// report.
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
  // triangles that represent a curved surface. Strokes that change volumes on purpose count for neither part; with such
  // strokes `sampling` is nothing.
  std::optional<double> volume_error;
  double volume_error_integration = 0;
  std::optional<double> volume_error_sampling;
  // The least and greatest det J of a stroke that changes volumes on purpose, at its moved vertices; nothing without
  // such strokes. Above 0: nothing is turned inside out.
  std::optional<double> det_least;
  std::optional<double> det_greatest;
  // The greatest motion of a vertex where the flow of the stroke must not move anything; a length, 0 for a correct
  // flow.
  double motion_outside = 0;
  // Of a volume mesh: inverted at one corner or middle node at least; nothing without cells.
  std::optional<std::size_t> inverted_cells_before;
  std::optional<std::size_t> inverted_cells_after;
  // In degrees, of triangles with area; nothing if there is none. touched_angle_after: of the faces at moved vertices;
  // touched_angle_before: of the faces before that these lie in.
  std::optional<double> smallest_angle_before;
  std::optional<double> smallest_angle_after;
  std::optional<double> touched_angle_before;
  std::optional<double> touched_angle_after;
  double distance_rms = 0;  // over all strokes, as in StrokeDistance
  double distance_max = 0;
  double carried_back_rms = 0;
  double carried_back_max = 0;
  std::vector<StrokeDistance> strokes;
};

// Follows a replay to certify its result: pass every ReplayOptions::on_stroke to add(), in order.
class CertificateBuilder {
 public:
  // The mesh and the options are those of the replay, and must outlive the builder. `max_points`: of more points that
  // moved, the distances are those of about so many, evenly chosen. Throws as replay().
  CertificateBuilder(const Mesh& mesh, const ReplayOptions& options,
                     std::size_t max_points = std::numeric_limits<std::size_t>::max());

  // Adds a stroke. Takes about six times as long as the stroke in double precision, plus a search for the nearest point
  // of the surface for each vertex and face that moved.
  void add(const AppliedStroke& stroke);

  // Returns the certificate. `as_float`: the result is written with float coordinates.
  Certificate finish(const ReplayResult& result, bool as_float) const;

 private:
  const Mesh& mesh_;
  const ReplayOptions& options_;
  std::size_t max_points_;
  double length_;  // tolerance and distances are relative to it
  double drift_ = 0;
  std::optional<double> det_least_;
  std::optional<double> det_greatest_;
  double motion_outside_ = 0;
  std::vector<StrokeDistance> strokes_;
};

// Replays the session and certifies the positions `after`, one for each vertex of `before`, which another program or an
// earlier run has computed for it. Throws InvalidInput as replay(), for positions that are not finite or of another
// number, and for a session that remeshes; Cancelled.
Certificate certify(const Mesh& before, std::span<const Vec3d> after, const Session& session,
                    const ReplayOptions& options = {});

// Returns one JSON object, indented, with a line end.
std::string to_json(const Certificate& certificate);

// The distances between two surfaces: of the vertices of each surface from the other one, taken together.
struct SurfaceDistance {
  double mean = 0;
  double percentile_95 = 0;  // 95% are at most this
  double max = 0;
};

// Returns the distance of each vertex of a shape from the surface of another, or from its nearest point if the other
// has no faces. Adds the number of vertices to progress->done. Throws as distance_between().
std::vector<double> vertex_distances(const Mesh& from, const Mesh& to, int threads = 0, Progress* progress = nullptr);

// Returns the distance of two shapes; a shape without faces counts as points. Throws InvalidInput where validate()
// does, and for a shape without vertices; Cancelled. Time: two searches for a nearest point per vertex, about 10 us
// each.
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
  // Fractions of the volume before: missed by the chords of the refined meshes, and restored by the compensation.
  std::optional<double> missing_volume;
  std::optional<double> compensated_volume;
  std::optional<double> volume_error_uncompensated;  // the volume error without the compensation
  bool complete = true;                              // false: edges above the targets remain
  bool out_of_time = false;                          // a stroke's remesh ended after RemeshPolicy::seconds
  std::size_t crossings = 0;                         // pairs where the last stroke changed the mesh
};

// The members are the report's keys.
struct Report {
  std::size_t vertices = 0;  // of the result
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
  double max_displacement = 0;  // of the input's vertices
  // The greatest stretch of a triangle from the input to the result (knead/editor/tools.h); nothing without a triangle
  // that has an area. For a remeshed shape, the positions of new vertices in the input are interpolated, and triangles
  // do not count that were lower there than 3e-4 of its diagonal and had an angle below about 3 degrees.
  std::optional<double> greatest_stretch;
  // Triangles that oppose the normals of their vertices now, but did not before. For a remeshed shape: how many more
  // such triangles than in the input.
  std::size_t flipped_triangles = 0;
  std::optional<double> penetration;                       // ReplayResult::penetration
  std::optional<std::uint64_t> self_intersections_before;  // pairs; nothing unless the caller counted them
  std::optional<std::uint64_t> self_intersections_after;
  std::optional<std::uint64_t> crossings_between{};  // pairs of triangles of two different shapes, if there are several
  std::optional<RemeshReport> remesh;                // if the result was remeshed
  std::optional<CellCheck> cells{};                  // of the deformed volume mesh; the key is "volume_cells"
  std::optional<Certificate> certificate;            // if the caller made one
};

// Returns the report on a replay with these options that ended in `done`. `mesh`: the shape before it. Linear time.
Report make_report(const Mesh& mesh, const ReplayResult& result, const ReplayOptions& options,
                   const ReportSeconds& seconds);

// Returns one JSON object, indented, with a line end; an absent number is null.
std::string to_json(const Report& report);

// Safe parts of sessions.

// The range, in strokes, in which a condition first fails.
struct SafeUntil {
  double until = 0;
  double beyond = 0;  // equal to `until` if the condition holds to the end
};

// Returns the range in which a condition first fails between 0 and `strokes` strokes. Samples every 16th of a stroke
// (from 16 strokes on, every 256th of the whole) in order, and bisects the range before the first failing sample ten
// times.
//
// Guaranteed: holds(until) was true, or `until` is 0, where the condition is assumed to hold; holds(beyond) was false;
// the condition held at every sample below. Undetected: a failure that begins and ends between two samples.
SafeUntil safe_until(double strokes, const std::function<bool(double until)>& holds);

// Returns the number of strokes before the one that fails at `beyond`.
std::size_t strokes_before(const SafeUntil& range);

// How the search for spoiled cells works.
struct SafeCellsOptions {
  // From 0, below 1. 0: a cell is spoiled if it is inverted, decided exactly. Above 0: also if its scaled Jacobian
  // falls below this. Cells that were below it before, or flat, do not count.
  double least_scaled_jacobian = 0;
  SessionPart part{};
  MotionOptions motion{};
  Progress* progress = nullptr;  // cancels the search, which then throws Cancelled
};

// The part of a session that spoils no cell of a volume mesh, and the cell that is spoiled first.
struct SafeCells {
  AdvectStatus status = AdvectStatus::done;  // step_limit: the other members are unknown; see kStepLimitAdvice
  SafeUntil range;                           // up to range.until, no cell is spoiled
  std::optional<std::size_t> cell;           // the worst spoiled cell at range.beyond; empty: the whole session is safe
  double scaled_jacobian = 1;                // of that cell at range.beyond, as in CellChanges
  std::optional<double> outer;               // widest_outer() of the stroke that spoils it
};

// Returns the part of a session that spoils no cell; safe_until() says what is guaranteed. The cells are measured with
// the points that advect() moves by flow_of(session, part) with part.until = range.until. Time: up to 26 times that of
// the flow for one stroke and of measuring the cells that it moves. Throws InvalidInput for a bound out of range, and
// as flow_of(session, part), compare_cells() and advect(); Cancelled.
SafeCells safe_until(const Session& session, const Cells& cells, std::span<const Vec3d> points,
                     const SafeCellsOptions& options = {});

}  // namespace knead
