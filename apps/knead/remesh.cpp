// knead remesh SHAPE -o OUT: refines a mesh and improves its triangles; the surface stays where it is. knead refine
// only splits edges.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.h"
#include "deform.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/remesh.h"
#include "output.h"

namespace knead::command {

namespace {

struct RemeshCommand {
  std::string shape;
  std::string output;
  RemeshFlags flags;
  int threads = 0;  // 0: all
  StreamFormat format;
  CommonOptions common;
};

Remeshed remeshed(const ShapeFile& shape, const RemeshSettings& settings, int threads) {
  const std::vector<std::uint32_t> labels = face_labels(shape);
  RemeshOptions options;
  options.face_labels = labels;
  options.threads = threads;
  return remesh(shape.mesh, settings, options);
}

std::string json_of(const Remeshed& result) {
  const RemeshCounts& counts = result.counts;
  const Json json{{"vertices", result.mesh.vertex_count()},
                  {"faces", result.mesh.face_count()},
                  {"splits", counts.splits},
                  {"collapses", counts.collapses},
                  {"flips", counts.flips},
                  {"complete", counts.complete},
                  {"distance", counts.distance}};
  return to_indented_text(json);
}

void run_remesh(RemeshCommand command) {
  command.flags.remesh = true;
  const RemeshSettings settings = *settings_of(command.flags);
  check_streams({command.shape, command.output}, command.format);
  require_free_output(command.output, command.common.json, "--json");
  require_shape_output(command.output);
  const ShapeFile shape = read_shape_or_stream(command.shape, command.format);
  if (shape.mesh.face_count() == 0) {
    throw InvalidInput(Place{command.shape}, "it has no faces to remesh; give a mesh");
  }
  const bool quiet = command.common.quiet;
  if (!quiet) {
    for (const std::string& note : shape.notes) print_message(fmt::format("note: {}: {}", command.shape, note));
    print_notes(remesh_losses(format_path(command.output, command.format), shape));
  }
  const Remeshed result = remeshed(shape, settings, command.threads);
  end_after_last_shape(command.output, command.common.json);
  write_remeshed_or_stream(command.output, command.format, shape, result.mesh, result.face_source);
  if (is_stream(command.output)) return;
  copy_materials(shape, command.shape, command.output, quiet);
  if (command.common.json) {
    print(json_of(result));
  } else if (!quiet) {
    const RemeshCounts& counts = result.counts;
    print(fmt::format("{}: {} vertices, {} faces; {}, {}, {}; {:.1g} from the surface before\n", command.output,
                      result.mesh.vertex_count(), result.mesh.face_count(), counted(counts.splits, "split"),
                      counted(counts.collapses, "collapse"), counted(counts.flips, "flip"), counts.distance));
    if (!counts.complete)
      print_notes(std::array{std::string("stopped at a limit; some edges are still above the targets")});
  }
}

Option iterations_option(const char* name, RemeshFlags& flags) {
  return {name,
          &flags.iterations,
          fmt::format("Rounds that improve triangles (default: {})", kDefaultRemeshIterations),
          "N",
          OptionKind::optional,
          from_to(0, 100),
          "give 0 to 100"};
}

std::vector<Option> shape_and_output(RemeshCommand& command) {
  return {{"SHAPE", &command.shape, "A mesh: PLY, OBJ, STL, OFF, GLB or 3MF", "", OptionKind::required},
          {"-o,--output", &command.output, "The file to write, in the format of its extension; may be SHAPE itself",
           "FILE", OptionKind::required}};
}

void add_other_options(std::vector<Option>& options, RemeshCommand& command) {
  add_threads_option(options, command.threads);
  add_format_option(options, command.format);
  add_common_options(options, command.common);
}

// The keys of the settings, and the options that set them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kNames{{
    {"\"max_edge\"", "--max-edge"},
    {"\"max_angle_deg\"", "--max-angle"},
    {"\"max_chord\"", "--max-chord"},
    {"\"min_edge\"", "--min-edge"},
    {"\"max_vertices\"", "--max-vertices"},
}};

std::string in_options(std::string text) {
  for (const auto& [key, option] : kNames) {
    for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key)) {
      text.replace(at, key.size(), option);
    }
  }
  return text;
}

}  // namespace

Subcommand remesh_command() {
  const auto command = std::make_shared<RemeshCommand>();
  std::vector<Option> options = shape_and_output(*command);
  add_edge_options(options, command->flags);
  options.insert(
      options.end(),
      {
          {"--max-chord", &command->flags.max_chord,
           fmt::format("Let curved parts move by about so much to improve their triangles; as a fraction of the box "
                       "diagonal (default: 0, with --min-edge {})",
                       kDefaultMaxChord),
           "FRACTION"},
          iterations_option("--iterations", command->flags),
      });
  add_other_options(options, *command);
  return {"remesh", "Refine a mesh and improve its triangles", options,
          "  knead remesh scan.ply --max-chord 3e-4 -o even.ply\n"
          "  knead remesh box.obj --max-edge 0.05 -o fine.obj\n"
          "  knead remesh fine.obj --min-edge 0.1 --max-edge 0.5 --json -o coarse.obj",
          [command] { run_remesh(*command); }};
}

Subcommand refine_command() {
  const auto command = std::make_shared<RemeshCommand>();
  std::vector<Option> options = shape_and_output(*command);
  add_edge_options(options, command->flags);
  const auto is_other = [](const Option& option) { return option.name == "--min-edge"; };
  options.erase(std::remove_if(options.begin(), options.end(), is_other), options.end());
  for (Option& option : options) {
    if (option.name != "--max-edge") continue;
    option.help = "Split edges longer than this, the longest first";
    option.kind = OptionKind::required;
  }
  add_other_options(options, *command);
  return {"refine", "Split long edges; no vertex moves, so the surface stays as it is", options,
          "  knead refine plate.stl --max-edge 2 -o fine.stl\n"
          "  knead refine part.3mf --max-edge 0.5 -o part.3mf",
          [command] {
            command->flags.iterations = 0;
            run_remesh(*command);
          }};
}

std::optional<RemeshSettings> settings_of(const RemeshFlags& flags) {
  RemeshSettings settings;
  settings.max_edge = flags.max_edge;
  settings.max_angle_deg = flags.max_angle;
  settings.max_chord = flags.max_chord;
  settings.min_edge = flags.min_edge;
  settings.iterations = flags.iterations;
  settings.max_vertices = flags.max_vertices;
  if (!flags.remesh && settings == RemeshSettings{}) return std::nullopt;
  try {
    validate(settings);
  } catch (const InvalidInput& error) {
    throw UsageError(in_options(error.what()));
  }
  return settings;
}

void add_edge_options(std::vector<Option>& options, RemeshFlags& flags) {
  options.insert(
      options.end(),
      {
          {"--max-edge", &flags.max_edge,
           "Split longer edges (default: twice the length that 95% of the shape's edges stay below)", "LENGTH"},
          {"--min-edge", &flags.min_edge,
           "Collapse shorter edges where the surface is flat (default: a quarter of the shape's mean edge)", "LENGTH"},
          {"--max-vertices", &flags.max_vertices,
           fmt::format("Refuse to grow the mesh beyond this, with exit code 4 (default: {} times the shape's, at least "
                       "{})",
                       kDefaultGrowth, kDefaultMaxVertices),
           "N"},
      });
}

void add_remesh_options(std::vector<Option>& options, RemeshFlags& flags) {
  options.push_back(
      {"--remesh", &flags.remesh,
       "Let the mesh follow each stroke: split stretched edges, keep triangles well shaped; the next six options "
       "imply this"});
  add_edge_options(options, flags);
  options.insert(options.end(),
                 {
                     {"--max-angle", &flags.max_angle,
                      fmt::format("Split edges if a stroke turns the normals at their ends apart by more (default: {})",
                                  kDefaultMaxAngleDeg),
                      "DEGREES"},
                     {"--max-chord", &flags.max_chord,
                      fmt::format("Split edges whose middle is farther from its exact image; as a fraction of the box "
                                  "diagonal (default: {})",
                                  kDefaultMaxChord),
                      "FRACTION"},
                     iterations_option("--remesh-iterations", flags),
                     {"--remesh-seconds", &flags.seconds,
                      "After so many seconds a stroke keep the best mesh so far, and say what still crosses; the "
                      "result then depends on the machine (default: no limit)",
                      "S", OptionKind::optional, [](double seconds) { return seconds > 0; }, "give a number above 0"},
                 });
}

}  // namespace knead::command
