// knead check SHAPE: prints what info prints, and whether the surface is sound.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command.h"
#include "knead/math/error.h"
#include "knead/mesh/flipped.h"
#include "knead/mesh/triangulate.h"
#include "output.h"
#include "requirements.h"
#include "shape_info.h"

namespace knead::command {
namespace {

struct CheckOptions {
  std::string shape;
  std::string before;
  std::optional<std::string> require;
  StreamFormat format;
  CommonOptions common;
};

std::size_t count_flipped_since(const CheckOptions& options, const Mesh& mesh) {
  const Mesh before = read_shape(options.before).mesh;
  if (before.vertex_count() != mesh.vertex_count() || before.face_begin != mesh.face_begin ||
      before.corner_vertex != mesh.corner_vertex) {
    throw InvalidInput(Place{options.before}, fmt::format("its faces differ from those of {}; give that shape as it "
                                                          "was before the deformation",
                                                          options.shape));
  }
  return count_flipped(mesh, before.positions, mesh.positions);
}

Findings find(const CheckOptions& options, const ShapeInfo& info) {
  const Mesh& mesh = info.file.mesh;
  Findings findings;
  findings.measures = info.measures;
  if (!options.before.empty()) findings.flipped_triangles = count_flipped_since(options, mesh);
  findings.self_intersections = self_intersections(triangulate(mesh), mesh.positions);
  findings.folded_edges = count_folded_edges(mesh);
  return findings;
}

std::string json_of(const ShapeInfo& info, const Findings& findings) {
  const Measures& m = findings.measures;
  Json json = to_json(info);
  json.set("boundary_edges", m.boundary_edges);
  json.set("nonmanifold_edges", m.nonmanifold_edges);
  json.set("nonmanifold_vertices", m.nonmanifold_vertices);
  json.set("misoriented_edges", m.misoriented_edges);
  json.set("self_intersections", findings.self_intersections.count);
  json.set("degenerate_triangles", m.degenerate_triangles);
  json.set("smallest_angle_deg", m.smallest_angle_deg);
  json.set("folded_edges", findings.folded_edges);
  json.set("flipped_triangles", findings.flipped_triangles);
  return to_indented_text(json);
}

std::string table_of(const ShapeInfo& info, const Findings& findings) {
  const Measures& m = findings.measures;
  std::string text = table_of(info);
  text += row("boundary edges", fmt::format("{}", m.boundary_edges));
  text += row("nonmanifold edges", fmt::format("{}", m.nonmanifold_edges));
  text += row("nonmanifold vertices", fmt::format("{}", m.nonmanifold_vertices));
  text += row("misoriented edges", fmt::format("{}", m.misoriented_edges));
  text += row("self-intersections", fmt::format("{}", findings.self_intersections.count));
  text += row("degenerate triangles", fmt::format("{}", m.degenerate_triangles));
  text += row("smallest angle", m.smallest_angle_deg ? fmt::format("{:.6g} degrees", *m.smallest_angle_deg)
                                                     : "- (no triangle has an area)");
  text += row("folded edges", fmt::format("{}", findings.folded_edges));
  if (findings.flipped_triangles) text += row("flipped triangles", fmt::format("{}", *findings.flipped_triangles));
  return text + table_of_notes(info);
}

// Prints a line on standard error for each requirement that is not met; throws the last one.
void require_all(const CheckOptions& options, const std::vector<Requirement>& requirements, const Findings& findings) {
  std::string last;
  for (const Requirement& requirement : requirements) {
    const std::optional<std::string> complaint = unmet(requirement, findings);
    if (!complaint) continue;
    if (!last.empty()) print_message(last);
    last = fmt::format("{}: {}", options.shape, *complaint);
  }
  if (!last.empty()) throw QualityError(last);
}

std::size_t count_repeated(std::vector<Vec3d> positions) {
  const auto key = [](const Vec3d& p) { return std::array{p.x, p.y, p.z}; };
  std::sort(positions.begin(), positions.end(), [&](const Vec3d& a, const Vec3d& b) { return key(a) < key(b); });
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < positions.size(); ++i) repeated += positions[i] == positions[i - 1] ? 1 : 0;
  return repeated;
}

void run_check(const CheckOptions& options) {
  std::vector<Requirement> requirements;
  if (options.require) requirements = parse_requirements(*options.require, !options.before.empty());
  check_streams({options.shape}, options.format);
  ShapeInfo info = read_info(options.shape, options.format);
  const Findings findings = find(options, info);
  if (!findings.self_intersections.complete) {
    info.notes.push_back(fmt::format("more than {} pairs of triangles intersect; the count stops there",
                                     findings.self_intersections.count));
  }
  const std::size_t repeated = count_repeated(info.file.mesh.positions);
  if (repeated > 0 && findings.self_intersections.count > 0) {
    info.notes.push_back(fmt::format(
        "{} vertices share their position with another one, as along seams; triangles that touch there count as "
        "intersecting",
        repeated));
  }
  if (options.common.json) {
    print(json_of(info, findings));
  } else if (!options.common.quiet) {
    print(table_of(info, findings));
  }
  require_all(options, requirements, findings);
}

}  // namespace

Subcommand check_command() {
  const auto options = std::make_shared<CheckOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "A mesh", "", OptionKind::required},
      {"--before", &options->before, "The same mesh before it was deformed, to count flipped triangles", "FILE"},
      {"--require", &options->require, "Exit with code 4 unless all of these hold: " + known_requirements(), "LIST"},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"check", "Check whether a surface is sound: self-intersections, triangles without area, folds", described,
          "  knead check scan.ply\n"
          "  knead check bent.ply --before hand.ply --json\n"
          "  knead check bent.ply --require closed,manifold,no-self-intersections,min-angle=1",
          [options] { run_check(*options); }};
}

}  // namespace knead::command
