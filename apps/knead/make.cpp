// knead make KIND: makes a procedural closed shape.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "command.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "output.h"
#include "streams.h"

namespace knead::command {
namespace {

struct MakeOptions {
  std::string kind;
  std::optional<std::size_t> vertices;  // nothing: the default of the kind
  std::string output;
  StreamFormat format;
  CommonOptions common;
};

ShapeKind checked_kind(const std::string& name) {
  const auto names = shape_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw UsageError(fmt::format("no kind of shape '{}'; say one of {}", name, fmt::join(names, ", ")));
  }
  return shape_kind(name);
}

void check_count(ShapeKind kind, const MakeOptions& options) {
  const ShapeCounts counts = shape_counts(kind);
  if (!options.vertices || (*options.vertices >= counts.minimum && *options.vertices <= counts.maximum)) return;
  throw UsageError(fmt::format("--vertices {}: a {} can have {} to {}", *options.vertices, options.kind, counts.minimum,
                               counts.maximum));
}

void run_make(const MakeOptions& options) {
  const ShapeKind kind = checked_kind(options.kind);
  check_count(kind, options);
  check_streams({options.output}, options.format);
  require_free_output(options.output, options.common.json, "--json");
  require_shape_output(options.output);
  const Mesh mesh = make_shape(kind, options.vertices.value_or(0));
  if (is_stream(options.output)) {
    return print(serialize_mesh(format_of(format_path(options.output, options.format)), mesh));
  }
  end_after_last_shape(options.output, options.common.json);
  write_mesh(options.output, mesh);
  if (options.common.json) {
    const Json json{{"kind", options.kind}, {"vertices", mesh.vertex_count()}, {"faces", mesh.face_count()}};
    print(to_indented_text(json));
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} vertices, {} faces\n", options.output, mesh.vertex_count(), mesh.face_count()));
  }
}

}  // namespace

Subcommand make_command() {
  const auto options = std::make_shared<MakeOptions>();
  std::vector<std::string_view> written = shape_extensions();
  std::erase(written, "ptx");  // is read only
  std::vector<Option> described{
      {"KIND", &options->kind, fmt::format("{}", fmt::join(shape_names(), ", ")), "", OptionKind::required},
      {"-n,--vertices", &options->vertices, "About this many vertices (each kind has its own default)", "N"},
      {"-o,--output", &options->output,
       fmt::format("The file, in the format of its extension: {}", fmt::join(written, ", ")), "FILE",
       OptionKind::required},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"make", "Make a procedural shape: closed, in one piece, of triangles", described,
          "  knead make hand -o hand.ply\n"
          "  knead make sphere -n 100000 -o sphere.obj",
          [options] { run_make(*options); }};
}

}  // namespace knead::command
