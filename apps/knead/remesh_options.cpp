#include "remesh_options.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "command.h"
#include "knead/error.h"

namespace knead::command {
namespace {

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

std::optional<RemeshSettings> settings_of(const RemeshFlags& flags) {
  RemeshSettings settings;
  settings.max_edge = flags.max_edge;
  settings.max_angle_deg = flags.max_angle;
  settings.max_chord = flags.max_chord;
  settings.min_edge = flags.min_edge;
  settings.iterations = flags.iterations;
  settings.max_vertices = flags.max_vertices;
  if (!flags.remesh && settings == RemeshSettings{}) return std::nullopt;
  if (flags.iterations && (*flags.iterations < 0 || *flags.iterations > 100)) {
    throw UsageError(fmt::format("--remesh-iterations {}: give 0 to 100", *flags.iterations));
  }
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
                     {"--remesh-iterations", &flags.iterations,
                      fmt::format("Rounds that improve triangles (default: {})", kDefaultRemeshIterations), "N"},
                     {"--remesh-seconds", &flags.seconds,
                      "After so many seconds a stroke keep the best mesh so far, and say what still crosses; the "
                      "result then depends on the machine (default: no limit)",
                      "S"},
                 });
}

}  // namespace knead::command
