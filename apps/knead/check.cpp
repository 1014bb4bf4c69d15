// knead check SHAPE: prints what info prints, and whether the surface is sound.
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "output.h"
#include "requirements.h"
#include "shape_info.h"
#include "streams.h"

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

std::string table_of_check(const SurfaceCheck& check) {
  const Measures& m = check.info.measures;
  std::string text = table_of(check.info);
  text += row("boundary edges", fmt::format("{}", m.boundary_edges));
  text += row("nonmanifold edges", fmt::format("{}", m.nonmanifold_edges));
  text += row("nonmanifold vertices", fmt::format("{}", m.nonmanifold_vertices));
  text += row("misoriented edges", fmt::format("{}", m.misoriented_edges));
  text += row("self-intersections", fmt::format("{}", check.self_intersections.count));
  text += row("degenerate triangles", fmt::format("{}", m.degenerate_triangles));
  text += row("smallest angle", m.smallest_angle_deg ? fmt::format("{:.6g} degrees", *m.smallest_angle_deg)
                                                     : "- (no triangle has an area)");
  text += row("folded edges", fmt::format("{}", check.folded_edges));
  if (check.flipped_triangles) text += row("flipped triangles", fmt::format("{}", *check.flipped_triangles));
  return text + table_of_notes(check.info.notes);
}

// Prints a line on standard error for each requirement that is not met; throws the last one.
void require_all(const CheckOptions& options, const std::vector<Requirement>& requirements, const SurfaceCheck& check) {
  std::string last;
  for (const Requirement& requirement : requirements) {
    const std::optional<std::string> complaint = unmet(requirement, check);
    if (!complaint) continue;
    if (!last.empty()) print_message(last);
    last = fmt::format("{}: {}", options.shape, *complaint);
  }
  if (!last.empty()) throw QualityError(last);
}

void run_check(const CheckOptions& options) {
  std::vector<Requirement> requirements;
  if (options.require) requirements = parse_requirements(*options.require, !options.before.empty());
  check_streams({options.shape}, options.format);
  const ShapeFile file = read_shape_or_stream(options.shape, options.format);
  std::optional<std::size_t> flipped;
  if (!options.before.empty()) flipped = count_flipped_since(options, file.mesh);
  SurfaceCheck check = check_surface(file.mesh, describe(file));
  check.flipped_triangles = flipped;
  if (options.common.json) {
    print(to_json(check));
  } else if (!options.common.quiet) {
    print(table_of_check(check));
  }
  require_all(options, requirements, check);
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
