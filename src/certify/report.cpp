// Descriptions and checks of shapes, the report of the command, and their JSON.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "certify/stroke_certificate.h"
#include "json/json.h"
#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/edges.h"

namespace knead {

namespace {

Json json_of(const Vec3d& v) { return std::vector<Json>{v.x, v.y, v.z}; }

Json json_of(const ShapeInfo& info) {
  const Measures& m = info.measures;
  const bool has_volume = m.closed() && m.oriented();
  Json json;
  json.set("format", info.format.empty() ? Json() : Json(info.format));
  json.set("vertices", m.vertices);
  json.set("faces", m.faces);
  json.set("triangles", m.triangles);
  json.set("closed", m.closed());
  json.set("manifold", m.manifold());
  json.set("oriented", m.oriented());
  json.set("components", m.components);
  json.set("boundary_loops", m.boundary_loops);
  json.set("euler", m.euler);
  json.set("volume", has_volume ? Json(m.volume) : Json());
  json.set("area", m.area);
  json.set("box_min", json_of(m.box.min));
  json.set("box_max", json_of(m.box.max));
  json.set("diagonal", m.box.diagonal());
  json.set("attributes", info.attributes);
  if (info.cells) {
    json.set("cells", *info.cells);
    Json patches = Json::array();
    for (const auto& [name, points] : info.patches) patches.push_back(Json{{"name", name}, {"points", points}});
    json.set("patches", std::move(patches));
  }
  json.set("notes", info.notes);
  return json;
}

std::size_t count_repeated(std::vector<Vec3d> positions) {
  const auto key = [](const Vec3d& p) { return std::array{p.x, p.y, p.z}; };
  std::sort(positions.begin(), positions.end(), [&](const Vec3d& a, const Vec3d& b) { return key(a) < key(b); });
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < positions.size(); ++i) repeated += positions[i] == positions[i - 1] ? 1 : 0;
  return repeated;
}

Json json_of(const CellCheck& check) {
  return Json{{"cells", check.cells},
              {"inverted", check.inverted},
              {"by_corners", check.by_corners},
              {"least_scaled_jacobian", check.least_scaled_jacobian},
              {"max_non_orthogonality_deg", check.max_non_orthogonality_deg},
              {"mean_non_orthogonality_deg", check.mean_non_orthogonality_deg},
              {"max_skewness", check.max_skewness},
              {"max_aspect_ratio", check.max_aspect_ratio}};
}

void add_displacements(const Mesh& mesh, const DeformedShape& result, Report& report) {
  const std::vector<Vec3d>& after = result.positions();
  for (std::size_t i = 0; i < after.size(); ++i) {
    const std::size_t source = result.is_remeshed() ? result.provenance()->vertex_source[i] : i;
    if (source != kNewVertex && same_bits(mesh.positions[source], after[i])) continue;
    ++report.moved_vertices;
    if (source == kNewVertex) continue;
    report.max_displacement = std::max(report.max_displacement, norm(after[i] - mesh.positions[source]));
  }
}

void add_steps(const DeformedShape& result, Report& report) {
  for (const std::uint32_t steps : result.steps()) {
    report.steps_max = std::max(report.steps_max, steps);
    report.vertex_steps += steps;
  }
  if (report.vertices == 0) return;
  report.steps_mean = static_cast<double>(report.vertex_steps) / static_cast<double>(report.vertices);
}

// Returns true if the triangle is thin and lower than this: corners that are less exact say nothing of its stretch.
bool is_sliver(const std::array<Vec3d, 3>& p, double min_height) {
  constexpr double thin = 0.05;  // of the longest edge: 3 degrees
  const double longest2 = std::max({norm2(p[1] - p[0]), norm2(p[2] - p[1]), norm2(p[0] - p[2])});
  const double double_area2 = norm2(cross(p[1] - p[0], p[2] - p[0]));
  const double height = std::min(min_height, thin * std::sqrt(longest2));
  return double_area2 < height * height * longest2;
}

std::optional<double> greatest_stretch_of(const Mesh& mesh, const DeformedShape& result) {
  const Provenance* const remeshed = result.provenance();
  const std::vector<Vec3d>& rest = remeshed != nullptr ? remeshed->rest : mesh.positions;
  const std::vector<Vec3d>& now = result.positions();
  constexpr double min_share = 3e-4;  // of the diagonal, as the default of max_chord
  const double min_height = remeshed != nullptr ? min_share * bounding_box(mesh.positions).diagonal() : 0;
  std::optional<double> greatest;
  for_each_triangle(result.mesh(), rest, [&](const Triangle& t) {
    const std::array<Vec3d, 3> before{rest[t[0]], rest[t[1]], rest[t[2]]};
    if (is_sliver(before, min_height)) return;
    const std::array<Vec3d, 3> after{now[t[0]], now[t[1]], now[t[2]]};
    const std::optional<double> stretch = triangle_stretch(before, after);
    if (stretch) greatest = std::max(*stretch, greatest.value_or(0));
  });
  return greatest;
}

// Adds the measures of the faces: five independent ones, on up to five threads.
void add_measures(const Mesh& mesh, const DeformedShape& result, int threads, Report& report) {
  VolumeAndArea before;
  VolumeAndArea deformed;
  bool has_volume = false;
  const WeldedMesh welded(mesh);
  const std::array<std::function<void()>, 5> works{
      [&] {
        const bool is_remeshed = result.is_remeshed();
        report.flipped_triangles = is_remeshed
                                       ? detail::opposing_more(welded.mesh(), WeldedMesh(result.to_mesh()).mesh())
                                       : count_flipped(welded.mesh(), mesh.positions, result.positions());
      },
      [&] { report.greatest_stretch = greatest_stretch_of(mesh, result); },
      [&] { has_volume = is_closed_and_oriented(welded.mesh(), threads); },
      [&] { before = measure_volume_and_area(mesh, mesh.positions); },
      [&] { deformed = measure_volume_and_area(result.mesh(), result.positions()); },
  };
  parallel_for(works.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) works[i]();
  });
  report.volume_before = before.volume;
  report.volume_after = deformed.volume;
  report.area_before = before.area;
  report.area_after = deformed.area;
  if (has_volume) report.volume_error = volume_change(before, deformed.volume);
}

void add_remesh(const DeformedShape& result, Report& report) {
  if (!result.is_remeshed()) return;
  const RemeshCounts& counts = result.provenance()->counts;
  RemeshReport& remesh = report.remesh.emplace();
  remesh.splits = counts.splits;
  remesh.collapses = counts.collapses;
  remesh.flips = counts.flips;
  remesh.complete = counts.complete;
  remesh.out_of_time = counts.out_of_time;
  remesh.crossings = counts.crossings;
  if (!report.volume_error) return;
  remesh.missing_volume = counts.missing_volume / report.volume_before;
  remesh.compensated_volume = counts.compensated_volume / report.volume_before;
  remesh.volume_error_uncompensated = *report.volume_error - *remesh.compensated_volume;
}

Json json_of(const RemeshReport& remesh) {
  return {{"splits", remesh.splits},
          {"collapses", remesh.collapses},
          {"flips", remesh.flips},
          {"missing_volume", remesh.missing_volume},
          {"compensated_volume", remesh.compensated_volume},
          {"volume_error_uncompensated", remesh.volume_error_uncompensated},
          {"complete", remesh.complete},
          {"out_of_time", remesh.out_of_time},
          {"crossings", remesh.crossings}};
}

Json json_of(const Certificate& certificate) {
  Json strokes = Json::array();
  for (const StrokeDistance& stroke : certificate.strokes) {
    strokes.push_back(Json{{"line", stroke.line},
                           {"points", stroke.points},
                           {"distance_rms", stroke.rms},
                           {"distance_max", stroke.max},
                           {"carried_back_rms", stroke.back_rms},
                           {"carried_back_max", stroke.back_max}});
  }
  return {{"crossings_before", certificate.crossings_before},
          {"crossings_after", certificate.crossings_after},
          {"flipped_triangles", certificate.flipped_triangles},
          {"degenerate_before", certificate.degenerate_before},
          {"degenerate_after", certificate.degenerate_after},
          {"closed_before", certificate.closed_before},
          {"closed_after", certificate.closed_after},
          {"euler_before", certificate.euler_before},
          {"euler_after", certificate.euler_after},
          {"volume_error", certificate.volume_error},
          {"volume_error_integration", certificate.volume_error_integration},
          {"volume_error_sampling", certificate.volume_error_sampling},
          {"det_least", certificate.det_least},
          {"det_greatest", certificate.det_greatest},
          {"motion_outside", certificate.motion_outside},
          {"inverted_cells_before", certificate.inverted_cells_before},
          {"inverted_cells_after", certificate.inverted_cells_after},
          {"smallest_angle_before", certificate.smallest_angle_before},
          {"smallest_angle_after", certificate.smallest_angle_after},
          {"touched_angle_before", certificate.touched_angle_before},
          {"touched_angle_after", certificate.touched_angle_after},
          {"distance_rms", certificate.distance_rms},
          {"distance_max", certificate.distance_max},
          {"carried_back_rms", certificate.carried_back_rms},
          {"carried_back_max", certificate.carried_back_max},
          {"strokes", strokes}};
}

}  // namespace

ShapeInfo describe(const Mesh& mesh) {
  ShapeInfo info;
  const WeldedMesh welded(mesh);
  info.measures = measure(welded.mesh());
  info.measures.unused_vertices -= welded.count();
  for (const Attribute& attribute : mesh.attributes) info.attributes.push_back(attribute.name);
  info.notes = describe_defects(info.measures);
  if (welded.count() > 0) {
    info.notes.push_back(
        fmt::format("vertices at the place of an earlier one, as along seams: {}; each place counts as one vertex",
                    welded.count()));
  }
  return info;
}

ShapeInfo describe(const ShapeFile& file) {
  ShapeInfo info = describe(file.mesh);
  info.format = file.format;
  info.notes.insert(info.notes.begin(), file.notes.begin(), file.notes.end());
  return info;
}

ShapeInfo describe(const ShapeFile& file, const std::filesystem::path& path) {
  ShapeInfo info = describe(file);
  try {
    const std::size_t cells = read_cells(path, file).size();
    const std::vector<Patch> patches = read_patches(path, file);
    if (cells + patches.size() > 0) info.cells = cells;
    for (const Patch& patch : patches) info.patches.emplace_back(patch.name, patch.points.size());
  } catch (const std::exception& error) {
    info.notes.push_back(fmt::format("its cells and patches are not read: {}", error.what()));
  }
  return info;
}

SurfaceCheck check_surface(const Mesh& mesh, ShapeInfo info, const Progress* progress) {
  const WeldedMesh welded(mesh);
  SurfaceCheck check;
  check.self_intersections = self_intersections(triangulate(welded.mesh()), mesh.positions, {.progress = progress});
  check.folded_edges = count_folded_edges(welded.mesh());
  const std::size_t count = check.self_intersections.count;
  if (!check.self_intersections.complete) {
    info.notes.push_back(fmt::format("more than {} pairs of triangles intersect; the count stops there", count));
  }
  const std::size_t repeated = count > 0 ? count_repeated(mesh.positions) - welded.count() : 0;
  if (repeated > 0) {
    info.notes.push_back(fmt::format(
        "{} vertices off the border share their position with another one; triangles that touch there count "
        "as intersecting",
        repeated));
  }
  check.info = std::move(info);
  return check;
}

SurfaceCheck check_surfaces(const JoinedMeshes& joined, ShapeInfo info, const Progress* progress) {
  SurfaceCheck check = check_surface(joined.mesh(), std::move(info), progress);
  if (check.self_intersections.complete) {
    check.crossings_between = count_between(check.self_intersections, joined, triangle_faces(joined.mesh()));
  }
  return check;
}

std::string to_json(const ShapeInfo& info) { return to_indented_text(json_of(info)); }

std::string to_json(const ShapeSummary& summary) {
  return to_indented_text(Json{{"format", summary.format},
                               {"vertices", summary.vertices},
                               {"faces", summary.faces},
                               {"triangles", summary.triangles},
                               {"box_min", json_of(summary.box.min)},
                               {"box_max", json_of(summary.box.max)},
                               {"diagonal", summary.box.diagonal()},
                               {"attributes", summary.attributes},
                               {"notes", summary.notes}});
}

std::string to_json(const SurfaceCheck& check) {
  const Measures& m = check.info.measures;
  Json json = json_of(check.info);
  json.set("boundary_edges", m.boundary_edges);
  json.set("nonmanifold_edges", m.nonmanifold_edges);
  json.set("nonmanifold_vertices", m.nonmanifold_vertices);
  json.set("misoriented_edges", m.misoriented_edges);
  json.set("self_intersections", check.self_intersections.count);
  json.set("degenerate_triangles", m.degenerate_triangles);
  json.set("smallest_angle_deg", m.smallest_angle_deg);
  json.set("folded_edges", check.folded_edges);
  json.set("flipped_triangles", check.flipped_triangles);
  if (check.crossings_between) json.set("crossings_between", *check.crossings_between);
  if (check.cells) json.set("volume_cells", json_of(*check.cells));
  return to_indented_text(json);
}

std::string to_json(const Certificate& certificate) { return to_indented_text(json_of(certificate)); }

Report make_report(const Mesh& mesh, const ReplayResult& result, const ReplayOptions& options,
                   const ReportSeconds& seconds) {
  Report report;
  report.vertices = result.shape.positions().size();
  report.faces = result.shape.mesh().face_count();
  report.strokes = result.strokes;
  report.segments = result.segments;
  report.penetration = result.penetration;
  report.evaluations = result.shape.work().evaluations;
  report.rejected_steps = result.shape.work().rejected_steps;
  report.seconds = seconds;
  report.threads = options.motion.threads == 0 ? hardware_threads() : options.motion.threads;
  report.simd = simd_name();
  report.precision = options.motion.precision;
  report.tolerance = options.motion.relative_tolerance;
  add_displacements(mesh, result.shape, report);
  add_steps(result.shape, report);
  add_measures(mesh, result.shape, options.motion.threads, report);
  add_remesh(result.shape, report);
  if (result.cells) report.cells = check_cells(*result.cells, result.shape.positions(), options.motion.threads);
  return report;
}

std::string to_json(const Report& report) {
  const ReportSeconds& seconds = report.seconds;
  Json json{
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
      {"seconds", Json{{"read", seconds.read},
                       {"deform", seconds.deform},
                       {"write", seconds.write},
                       {"measure", seconds.measure},
                       {"total", seconds.total}}},
      {"threads", report.threads},
      {"simd", report.simd},
      {"backend", report.backend},
      {"precision", report.precision == Precision::float32 ? "float" : "double"},
      {"tolerance", report.tolerance},
      {"volume_before", report.volume_before},
      {"volume_after", report.volume_after},
      {"volume_error", report.volume_error},
      {"area_before", report.area_before},
      {"area_after", report.area_after},
      {"max_displacement", report.max_displacement},
      {"greatest_stretch", report.greatest_stretch},
      {"flipped_triangles", report.flipped_triangles},
      {"self_intersections_before", report.self_intersections_before},
      {"self_intersections_after", report.self_intersections_after},
  };
  if (report.crossings_between) json.set("crossings_between", *report.crossings_between);
  if (report.penetration) json.set("penetration", *report.penetration);
  if (report.remesh) json.set("remesh", json_of(*report.remesh));
  if (report.cells) json.set("volume_cells", json_of(*report.cells));
  if (report.certificate) json.set("certificate", json_of(*report.certificate));
  return to_indented_text(json);
}

}  // namespace knead
