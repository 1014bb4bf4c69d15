// knead resolve SHAPE SESSION -o OUT.knead: writes the session as strokes that need no mesh.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "command.h"
#include "interrupt.h"
#include "knead/error.h"
#include "knead/io.h"
#include "output.h"
#include "work.h"

namespace knead::command {
namespace {

struct ResolveOptions {
  std::string shape;
  std::string session;
  std::string output;
  StreamFormat format;
  CommonOptions common;
};

void require_flows(const Session& session) {
  for (const SessionStroke& stroke : session.strokes) {
    if (is_flow(stroke.stroke)) continue;
    throw InvalidInput(Place{session.name, stroke.line},
                       "a relax is no flow, so it cannot be resolved; remove this line, or use the session as it is");
  }
}

void run_resolve(const ResolveOptions& options) {
  const bool to_output = is_stream(options.output);
  require_free_output(options.output, options.common.json, "--json");
  if (!to_output) {
    constexpr std::string_view extensions[] = {"knead"};
    require_extension(options.output, extensions);
    require_writable(options.output);
  }
  check_streams({options.shape}, options.format);
  const Inputs inputs = read_inputs(options.shape, options.format, options.session, options.common.quiet);
  require_flows(inputs.session);
  ReplayOptions replay;
  replay.may_cross = true;  // the shape is not kept
  const ReplayResult result = replay_watched(inputs.shape.mesh, inputs.session, replay, options.common.quiet);
  Session resolved;
  resolved.note = inputs.session.note;
  resolved.strokes = result.resolved;
  if (to_output) return print(serialize_session(resolved));
  end_after_last_output(options.common.json);
  write_file_atomically(options.output, serialize_session(resolved));
  if (options.common.json) {
    const Json json{{"strokes", resolved.strokes.size()}, {"segments", result.segments}};
    print(to_indented_text(json));
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} ({})\n", options.output, counted(resolved.strokes.size(), "stroke"),
                      counted(result.segments, "segment")));
  }
}

}  // namespace

Subcommand resolve_command() {
  const auto options = std::make_shared<ResolveOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "The shape that the session was made for", "", OptionKind::required},
      {"SESSION", &options->session, "The strokes: a .knead file", "", OptionKind::required},
      {"-o,--output", &options->output, "The .knead file to write, or - for standard output", "FILE",
       OptionKind::required},
  };
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"resolve", "Write a session as strokes that do not read the surface", described,
          "  knead resolve hand.ply paint.knead -o flow.knead\n"
          "  knead deform fine_hand.ply flow.knead -o painted.ply",
          [options] { run_resolve(*options); }};
}

}  // namespace knead::command
