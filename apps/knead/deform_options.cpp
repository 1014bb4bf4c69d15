// The options of knead deform, and those of frames.
#include <fmt/format.h>

#include <charconv>
#include <optional>

#include "certified.h"
#include "command.h"
#include "deform.h"
#include "inputs.h"
#include "knead/mesh.h"
#include "math/elementary.h"
#include "output.h"

namespace knead::command {

Digits digits_of(const DeformOptions& options) {
  if (options.digits == "auto") return {};
  if (options.digits == "shortest") return {DigitsKind::shortest, 0};
  const char* const end = options.digits.data() + options.digits.size();
  Digits digits{DigitsKind::given, 0};
  const auto [stop, error] = std::from_chars(options.digits.data(), end, digits.count);
  constexpr int most = 17;  // that a double can tell apart
  if (error != std::errc{} || stop != end || digits.count < 0 || digits.count > most) {
    throw UsageError(fmt::format("--digits {}: say auto, shortest, or a number from 0 to {}", options.digits, most));
  }
  if (options.check || options.require) {
    throw UsageError(
        fmt::format("--digits {}: the certificate judges coordinates that are not rounded; leave out "
                    "--digits, --check or --require",
                    options.digits));
  }
  return digits;
}

std::optional<int> decimals_for(const Digits& digits, const ShapeFile& source, double tolerance) {
  if (digits.kind != DigitsKind::automatic) return decimals_for(digits, std::nullopt, 0, tolerance);
  return decimals_for(digits, decimals_of(source), shape_box(source.mesh).diagonal(), tolerance);
}

std::optional<int> decimals_for(const Digits& digits, std::optional<int> own, double diagonal, double tolerance) {
  if (digits.kind == DigitsKind::shortest) return std::nullopt;
  if (digits.kind == DigitsKind::given) return digits.count;
  constexpr int most = 17;
  const double rounding = 0.5 * elementary::power_of_ten(-own.value_or(0));
  if (!own || *own > most || rounding > tolerance * diagonal) return std::nullopt;
  return own;
}

void check_until(const DeformOptions& options, const Session& session) {
  if (options.until && *options.until > static_cast<double>(session.strokes.size())) {
    throw UsageError(fmt::format("--until {}: {} has {}; give at most that number", *options.until, session.name,
                                 counted(session.strokes.size(), "stroke")));
  }
}

ReplayOptions replay_options(const DeformOptions& options) {
  check_backend(options.backend);
  ReplayOptions replay;
  replay.motion.relative_tolerance = options.tolerance;
  replay.motion.integrator = options.integrator;
  replay.motion.precision = options.precision;
  replay.motion.threads = options.threads;
  if (options.inverse) replay.part.direction = Direction::backwards;
  replay.part.until = options.until;
  replay.must_follow = !options.keep_mesh;
  replay.frames = frame_options(options.frames);
  replay.remesh.settings = settings_of(options.remesh);
  if (options.remesh.seconds) replay.remesh.seconds = *options.remesh.seconds;
  return replay;
}

namespace {

std::vector<Option> describe_motion(DeformOptions& options) {
  return {
      {"SHAPE", &options.shape, "A mesh or point cloud, such as a PLY, OBJ, STL, OFF, glTF or XYZ file", "",
       OptionKind::required},
      {"SESSION", &options.session, "The strokes: a .knead file; or give them with --stroke"},
      {"--stroke", &options.strokes,
       "A stroke in the place of a SESSION, in words as 'rotate center=0,0,0 axis=0,0,1 angle_deg=30 inner=1 outer=2' "
       "or as a line of a session; may be repeated",
       "STROKE"},
      {"--session", &options.session_output, "Write the session to this .knead file, to go on with it", "FILE"},
      {"-o,--output", &options.output,
       "The file to write, in the format of its extension; may be SHAPE itself. With --also a folder", "FILE",
       OptionKind::required},
      {"--also", &options.also,
       "A further shape that moves along, such as clothes; may be repeated. All results go to the folder -o, each "
       "under "
       "the name of its file. Strokes that read a surface read that of SHAPE",
       "FILE"},
      {"--tolerance", &options.tolerance,
       "Position error of one path line over one segment, relative to the shape's box diagonal", "T",
       OptionKind::with_default, is_above_zero, "give a number above 0, such as 1e-5"},
      {"--digits", &options.digits,
       "Decimals of moved coordinates in text files: auto (the file's own, if the tolerance allows), shortest (of what "
       "reads back exactly), or a number",
       "auto|shortest|N", OptionKind::with_default},
      {"--stream", &options.stream,
       "Take a point cloud through in pieces, for clouds larger than memory: binary PLY or XYZ, a session that reads "
       "no surface. By itself where the file is larger than half of the memory"},
      {"--piece-mb", &options.piece_mb, "Size of a piece of --stream in megabytes; does not change the result", "MB",
       OptionKind::with_default, from_to(0.001, 1e5), "give megabytes, from 0.001 to 100000"},
      {"--max-splats", &options.max_splats,
       "The most splats that there are after long ones were split, so that they can bend (default: twice as many as "
       "before); 0 splits none",
       "N"},
      {"--integrator",
       WordTarget{{"rk4", "tsit5", "runge-kutta", "tsitouras"},
                  static_cast<std::size_t>(options.integrator),
                  [&options](std::size_t word) { options.integrator = static_cast<Integrator>(word % 2); }},
       "rk4 (the paper's) or tsit5 (tsitouras)", "NAME", OptionKind::with_default},
      {"--precision", word_target(options.precision, {"float", "double"}),
       "float or double; double writes PLY coordinates as doubles", "NAME", OptionKind::with_default},
      {"--backend", &options.backend, "cpu or gpu; without a GPU with OpenGL 4.3, gpu uses the CPU", "NAME",
       OptionKind::with_default},
      {"--inverse", &options.inverse, "Apply the session backwards, which restores a deformed shape"},
  };
}

[[noreturn]] void fail(const std::string& text) {
  throw UsageError(
      fmt::format("--output {}: with --frames, give a pattern with one %d or %04d for the number, as in F_%04d.ply; "
                  "write %% for a percent sign",
                  text));
}

// The length of the conversion after a percent sign, and its width; a length of 0: none.
struct Conversion {
  std::size_t length = 0;
  int width = 0;
};

Conversion conversion_at(std::string_view rest) {
  if (rest.starts_with('d')) return {1, 0};
  const bool padded = rest.size() >= 3 && rest[0] == '0' && rest[1] >= '1' && rest[1] <= '9' && rest[2] == 'd';
  if (padded) return {3, rest[1] - '0'};
  return {};
}

}  // namespace

std::vector<Option> describe(DeformOptions& options) {
  std::vector<Option> result = describe_motion(options);
  add_threads_option(result, options.threads);
  add_set_option(result, options.set);
  result.push_back({"--table", &options.table,
                    "A CSV file whose first line names parameters: one deformed shape for each further line, in the "
                    "folder -o or as the frames of an animation -o. Lines that were done before are skipped",
                    "FILE"});
  add_remesh_options(result, options.remesh);
  result.push_back({"--keep-mesh", &options.keep_mesh,
                    "Keep a result whose faces are too coarse for the motion: far from the exact image of the surface "
                    "(else exit code 4)"});
  result.insert(
      result.end(),
      {
          {"--check", &options.check,
           "Make a certificate of the result: crossings, flips, volume, angles, distance to the exact image"},
          {"--require", &options.require,
           "Certify the result, and refine a remeshed one, until all of these bounds hold; else write nothing and "
           "exit with code 4: " +
               known_bounds(),
           "LIST"},
          {"--until", &options.until, "Stop after S strokes; 2.5 stops halfway through the third", "S",
           OptionKind::optional, is_not_negative, "give a number of strokes, 0 or more"},
          {"--frames", &options.frames.frames,
           "Write N evenly spaced moments, including start and end; -o is then an animation (.pc2, .mdd, .glb, .usda, "
           ".pvd), or a pattern with one %04d for a file each",
           "N", OptionKind::optional, from_to(1, kMaxFrames), fmt::format("give 1 to {}", kMaxFrames)},
          {"--report", &options.report, "Write a JSON report to this file; - means standard output", "FILE"},
      });
  add_time_options(result, options.frames);
  add_format_option(result, options.format);
  add_common_options(result, options.common);
  return result;
}

void add_time_options(std::vector<Option>& options, FrameFlags& flags) {
  options.insert(options.end(),
                 {{"--fps", &flags.fps, "Frames a second of an animation or film (default: 24)", "F",
                   OptionKind::optional, is_above_zero, "give a number above 0, such as 24"},
                  {"--ease", word_target(flags.ease, {"linear", "smooth"}),
                   "How time runs over the frames: linear, or smooth (slowly at both ends)", "linear|smooth",
                   OptionKind::with_default},
                  {"--hold", &flags.hold, "Show the first and the last frame so many frames longer", "N",
                   OptionKind::optional, from_to(0, kMaxFrames), fmt::format("give 0 to {} frames", kMaxFrames)}});
}

FrameOptions frame_options(const FrameFlags& flags) {
  FrameOptions frames;
  frames.count = flags.frames.value_or(0);
  frames.ease = flags.ease;
  frames.hold = flags.hold.value_or(0);
  if (!flags.frames && (flags.fps || flags.hold || frames.ease != Ease::linear)) {
    throw UsageError("--fps, --ease and --hold are for --frames N; give it too, or leave them out");
  }
  return frames;
}

FramePattern parse_frame_pattern(const std::string& text) {
  FramePattern pattern;
  bool found = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& part = found ? pattern.after : pattern.before;
    if (text[i] != '%') {
      part += text[i];
      continue;
    }
    if (i + 1 < text.size() && text[i + 1] == '%') {
      part += '%';
      ++i;
      continue;
    }
    const Conversion conversion = conversion_at(std::string_view(text).substr(i + 1));
    if (conversion.length == 0 || found) fail(text);
    found = true;
    pattern.width = conversion.width;
    i += conversion.length;
  }
  if (!found) fail(text);
  return pattern;
}

std::string frame_path(const FramePattern& pattern, int index) {
  return fmt::format("{}{:0{}}{}", pattern.before, index, pattern.width, pattern.after);
}

}  // namespace knead::command
