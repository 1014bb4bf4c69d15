// What a deformation did, as the JSON report of the command.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "knead/mesh/mesh.h"
#include "knead/session/certificate.h"
#include "knead/session/replay.h"

namespace knead {

// Wall-clock times.
struct ReportSeconds {
  double read = 0;
  double deform = 0;
  double write = 0;
  double total = 0;
};

// What remeshing did. The members are the keys of the report's "remesh".
struct RemeshReport {
  std::size_t splits = 0;
  std::size_t collapses = 0;
  std::size_t flips = 0;
  // Of the volume before: what the chords of the refined meshes missed, and what the compensation gave back.
  std::optional<double> missing_volume;
  std::optional<double> compensated_volume;
  std::optional<double> volume_error_uncompensated;  // the volume error as it would be without that
  bool complete = true;                              // false: edges above the targets remain
};

// The members are the report's keys.
struct Report {
  std::size_t vertices = 0;  // of the result, and so its faces
  std::size_t faces = 0;
  std::size_t moved_vertices = 0;  // whose position differs in any bit from the input's, and those that are new
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
  std::optional<double> volume_error;  // after / before - 1; nothing where not closed and oriented
  double area_before = 0;
  double area_after = 0;
  double max_displacement = 0;  // of the vertices that the input had
  // That oppose the normals of their vertices, and did not before. Of a remeshed shape: how many more oppose these than
  // in the input.
  std::size_t flipped_triangles = 0;
  std::optional<double> penetration;                       // ReplayResult::penetration
  std::optional<std::uint64_t> self_intersections_before;  // pairs; nothing where the caller did not count them
  std::optional<std::uint64_t> self_intersections_after;
  std::optional<RemeshReport> remesh;      // where the result was remeshed
  std::optional<Certificate> certificate;  // where the caller had one made
};

// The report on a replay with these options that ended in `done`. `mesh` is the shape before it. Linear.
Report make_report(const Mesh& mesh, const ReplayResult& result, const ReplayOptions& options,
                   const ReportSeconds& seconds);

// One JSON object, indented, ending in a line end; an absent number is null.
std::string to_json(const Report& report);

}  // namespace knead
