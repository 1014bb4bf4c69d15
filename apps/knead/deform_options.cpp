#include "deform_options.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

#include "backend.h"
#include "bounds.h"

namespace knead::command {
namespace {

Integrator integrator_named(const std::string& name) {
  struct Entry {
    std::string_view name;
    std::string_view long_name;
    Integrator integrator;
  };
  constexpr std::array<Entry, 4> entries{{{"rk4", "runge-kutta", Integrator::rk4},
                                          {"bs32", "bogacki-shampine", Integrator::bogacki_shampine},
                                          {"dp54", "dormand-prince", Integrator::dormand_prince},
                                          {"tsit5", "tsitouras", Integrator::tsitouras}}};
  for (const Entry& entry : entries) {
    if (name == entry.name || name == entry.long_name) return entry.integrator;
  }
  throw UsageError(fmt::format("--integrator {}: no such method; say rk4, bs32, dp54 or tsit5", name));
}

Precision precision_named(const std::string& name) {
  if (name == "float") return Precision::float32;
  if (name == "double") return Precision::float64;
  throw UsageError(fmt::format("--precision {}: say float or double", name));
}

}  // namespace

ReplayOptions replay_options(const DeformOptions& options) {
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance)) {
    throw UsageError(fmt::format("--tolerance {}: give a number above 0, such as 1e-5", options.tolerance));
  }
  if (options.threads.value_or(1) < 1) {
    throw UsageError(fmt::format("--threads {}: give 1 or more, or leave it out for all", *options.threads));
  }
  if (const double until = options.until.value_or(0); !(until >= 0) || !std::isfinite(until)) {
    throw UsageError(fmt::format("--until {}: give a number of strokes, 0 or more", until));
  }
  if (options.frames.value_or(1) < 1) throw UsageError(fmt::format("--frames {}: give 1 or more", *options.frames));
  check_backend(options.backend);
  ReplayOptions replay;
  replay.motion.relative_tolerance = options.tolerance;
  replay.motion.integrator = integrator_named(options.integrator);
  replay.motion.precision = precision_named(options.precision);
  replay.motion.threads = options.threads.value_or(0);
  if (options.inverse) replay.part.direction = Direction::backwards;
  replay.part.until = options.until;
  replay.frames.count = options.frames.value_or(0);
  replay.remesh.settings = settings_of(options.remesh);
  return replay;
}

std::vector<Option> describe(DeformOptions& options) {
  std::vector<Option> result{
      {"SHAPE", &options.shape, "A mesh or point cloud: PLY, OBJ, STL, OFF, GLB or XYZ", "", OptionKind::required},
      {"SESSION", &options.session, "The strokes: a .knead file", "", OptionKind::required},
      {"-o,--output", &options.output, "The file to write, in the format of its extension; may be SHAPE itself", "FILE",
       OptionKind::required},
      {"--tolerance", &options.tolerance,
       "Position error of one path line over one segment, relative to the shape's box diagonal", "T",
       OptionKind::with_default},
      {"--integrator", &options.integrator,
       "rk4 (the paper's), bs32 (bogacki-shampine), dp54 (dormand-prince), tsit5 (tsitouras)", "NAME",
       OptionKind::with_default},
      {"--precision", &options.precision, "float or double; double writes PLY coordinates as doubles", "NAME",
       OptionKind::with_default},
      {"--backend", &options.backend, "cpu, or gpu: a GPU with OpenGL 4.3, or the CPU where there is none", "NAME",
       OptionKind::with_default},
      {"--threads", &options.threads, "How many threads (all); the result is the same", "N"},
      {"--inverse", &options.inverse, "The session backwards: takes a deformed shape back"},
  };
  add_remesh_options(result, options.remesh);
  result.insert(
      result.end(),
      {
          {"--check", &options.check,
           "Certify the result: crossings, flips, volume, angles, the distance to the true image"},
          {"--require", &options.require,
           "Check, refine where the mesh is remeshed, and write nothing and exit with code 4 unless all of these "
           "hold: " +
               known_bounds(),
           "LIST"},
          {"--until", &options.until, "Stop after so many strokes; 2.5: half of the third", "S"},
          {"--frames", &options.frames,
           "So many evenly spaced moments, the first and last among them; -o is then a pattern with one %04d", "N"},
          {"--report", &options.report, "Write a JSON report to this file; -: standard output", "FILE"},
      });
  add_common_options(result, options.common);
  return result;
}

}  // namespace knead::command
