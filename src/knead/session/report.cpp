#include "knead/session/report.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>

#include "knead/flow/simd.h"
#include "knead/math/parallel.h"
#include "knead/mesh/edges.h"
#include "knead/mesh/flipped.h"
#include "knead/mesh/measures.h"

namespace knead {

namespace {

bool same_bits(const Vec3d& a, const Vec3d& b) {
  using Bits = std::array<std::uint64_t, 3>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

void add_displacements(const Mesh& mesh, const std::vector<Vec3d>& after, Report& report) {
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (same_bits(mesh.positions[i], after[i])) continue;
    ++report.moved_vertices;
    report.max_displacement = std::max(report.max_displacement, norm(after[i] - mesh.positions[i]));
  }
}

void add_steps(const ReplayResult& result, Report& report) {
  for (const std::uint32_t steps : result.steps) {
    report.steps_max = std::max(report.steps_max, steps);
    report.vertex_steps += steps;
  }
  if (report.vertices == 0) return;
  report.steps_mean = static_cast<double>(report.vertex_steps) / static_cast<double>(report.vertices);
}

// What is measured of the faces: four things that do not depend on each other, on as many threads as there are.
void add_measures(const Mesh& mesh, const std::vector<Vec3d>& after, int threads, Report& report) {
  VolumeAndArea before;
  VolumeAndArea deformed;
  bool has_volume = false;
  const std::array<std::function<void()>, 4> works{
      [&] { report.flipped_triangles = count_flipped(mesh, mesh.positions, after); },
      [&] { has_volume = is_closed_and_oriented(mesh); },
      [&] { before = measure_volume_and_area(mesh, mesh.positions); },
      [&] { deformed = measure_volume_and_area(mesh, after); },
  };
  parallel_for(works.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) works[i]();
  });
  report.volume_before = before.volume;
  report.volume_after = deformed.volume;
  report.area_before = before.area;
  report.area_after = deformed.area;
  const double error = deformed.volume / before.volume - 1;
  if (has_volume && std::isfinite(error)) report.volume_error = error;
}

template <class T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

Report make_report(const Mesh& mesh, const ReplayResult& result, const ReplayOptions& options,
                   const ReportSeconds& seconds) {
  Report report;
  report.vertices = mesh.vertex_count();
  report.faces = mesh.face_count();
  report.strokes = result.strokes;
  report.segments = result.segments;
  report.penetration = result.penetration;
  report.evaluations = result.evaluations;
  report.rejected_steps = result.rejected_steps;
  report.seconds = seconds;
  report.threads = options.threads == 0 ? hardware_threads() : options.threads;
  report.simd = simd_name();
  report.precision = options.precision;
  report.tolerance = options.tolerance;
  add_displacements(mesh, result.positions, report);
  add_steps(result, report);
  add_measures(mesh, result.positions, options.threads, report);
  return report;
}

std::string to_json(const Report& report) {
  const ReportSeconds& seconds = report.seconds;
  nlohmann::ordered_json json{
      {"vertices", report.vertices},
      {"faces", report.faces},
      {"moved_vertices", report.moved_vertices},
      {"strokes", report.strokes},
      {"segments", report.segments},
      {"steps_mean", report.steps_mean},
      {"steps_max", report.steps_max},
      {"vertex_steps", report.vertex_steps},
      {"evaluations", report.evaluations},
      {"rejected_steps", report.rejected_steps},
      {"seconds",
       {{"read", seconds.read}, {"deform", seconds.deform}, {"write", seconds.write}, {"total", seconds.total}}},
      {"threads", report.threads},
      {"simd", report.simd},
      {"backend", report.backend},
      {"precision", report.precision == Precision::float32 ? "float" : "double"},
      {"tolerance", report.tolerance},
      {"volume_before", report.volume_before},
      {"volume_after", report.volume_after},
      {"volume_error", or_null(report.volume_error)},
      {"area_before", report.area_before},
      {"area_after", report.area_after},
      {"max_displacement", report.max_displacement},
      {"flipped_triangles", report.flipped_triangles},
      {"self_intersections_before", or_null(report.self_intersections_before)},
      {"self_intersections_after", or_null(report.self_intersections_after)},
  };
  if (report.penetration) json["penetration"] = *report.penetration;
  return json.dump(2) + "\n";
}

}  // namespace knead
