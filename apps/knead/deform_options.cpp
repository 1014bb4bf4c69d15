#include "deform_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "backend.h"
#include "bounds.h"
#include "knead/math/elementary.h"
#include "knead/mesh/measures.h"
#include "output.h"

namespace knead::command {
namespace {

Integrator read_integrator(const std::string& name) {
  if (const std::optional<Integrator> integrator = integrator_named(name)) return *integrator;
  throw UsageError(fmt::format("--integrator {}: no such method; say rk4, bs32, dp54 or tsit5", name));
}

Precision precision_named(const std::string& name) {
  if (name == "float") return Precision::float32;
  if (name == "double") return Precision::float64;
  throw UsageError(fmt::format("--precision {}: say float or double", name));
}

}  // namespace

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
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance)) {
    throw UsageError(fmt::format("--tolerance {}: give a number above 0, such as 1e-5", options.tolerance));
  }
  if (const double until = options.until.value_or(0); !(until >= 0) || !std::isfinite(until)) {
    throw UsageError(fmt::format("--until {}: give a number of strokes, 0 or more", until));
  }
  check_backend(options.backend);
  ReplayOptions replay;
  replay.motion.relative_tolerance = options.tolerance;
  replay.motion.integrator = read_integrator(options.integrator);
  replay.motion.precision = precision_named(options.precision);
  replay.motion.threads = threads_of(options.threads);
  if (options.inverse) replay.part.direction = Direction::backwards;
  replay.part.until = options.until;
  replay.frames = frame_options(options.frames);
  replay.remesh.settings = settings_of(options.remesh);
  if (const std::optional<double> seconds = options.remesh.seconds) {
    if (!(*seconds > 0)) throw UsageError(fmt::format("--remesh-seconds {}: give a number above 0", *seconds));
    replay.remesh.seconds = *seconds;
  }
  return replay;
}

std::vector<Option> describe(DeformOptions& options) {
  std::vector<Option> result{
      {"SHAPE", &options.shape, "A mesh or point cloud, such as a PLY, OBJ, STL, OFF, glTF or XYZ file", "",
       OptionKind::required},
      {"SESSION", &options.session, "The strokes: a .knead file", "", OptionKind::required},
      {"-o,--output", &options.output, "The file to write, in the format of its extension; may be SHAPE itself", "FILE",
       OptionKind::required},
      {"--tolerance", &options.tolerance,
       "Position error of one path line over one segment, relative to the shape's box diagonal", "T",
       OptionKind::with_default},
      {"--digits", &options.digits,
       "Decimals of moved coordinates in text files: auto (the file's own, if the tolerance allows), shortest (of what "
       "reads back exactly), or a number",
       "auto|shortest|N", OptionKind::with_default},
      {"--stream", &options.stream,
       "Take a point cloud through in pieces, for clouds larger than memory: binary PLY or XYZ, a session that reads "
       "no surface. By itself where the file is larger than half of the memory"},
      {"--piece-mb", &options.piece_mb, "Size of a piece of --stream in megabytes; does not change the result", "MB",
       OptionKind::with_default},
      {"--integrator", &options.integrator,
       "rk4 (the paper's), bs32 (bogacki-shampine), dp54 (dormand-prince), tsit5 (tsitouras)", "NAME",
       OptionKind::with_default},
      {"--precision", &options.precision, "float or double; double writes PLY coordinates as doubles", "NAME",
       OptionKind::with_default},
      {"--backend", &options.backend, "cpu or gpu; without a GPU with OpenGL 4.3, gpu uses the CPU", "NAME",
       OptionKind::with_default},
      {"--threads", &options.threads, "Number of threads (default: all); does not change the result", "N"},
      {"--inverse", &options.inverse, "Apply the session backwards, which restores a deformed shape"},
  };
  add_remesh_options(result, options.remesh);
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
          {"--until", &options.until, "Stop after S strokes; 2.5 stops halfway through the third", "S"},
          {"--frames", &options.frames.frames,
           "Write N evenly spaced moments, including start and end; -o is then an animation (.pc2, .mdd, .glb, .usda, "
           ".pvd), or a pattern with one %04d for a file each",
           "N"},
          {"--report", &options.report, "Write a JSON report to this file; - means standard output", "FILE"},
      });
  add_time_options(result, options.frames);
  add_format_option(result, options.format);
  add_common_options(result, options.common);
  return result;
}

}  // namespace knead::command
