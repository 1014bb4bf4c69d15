// knead deform SHAPE SESSION -o OUT: a mesh or point cloud deformed by a session.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "frames.h"
#include "knead/io/atomic_file.h"
#include "knead/io/authored_normals.h"
#include "knead/io/materials.h"
#include "knead/mesh/self_intersections.h"
#include "knead/mesh/triangulate.h"
#include "knead/session/report.h"
#include "output.h"
#include "work.h"

namespace knead::command {
namespace {

struct DeformOptions {
  std::string shape;
  std::string session;
  std::string output;
  double tolerance = 1e-5;
  std::string integrator = "tsit5";
  std::string precision = "float";
  std::string backend = "cpu";
  std::optional<int> threads;
  bool inverse = false;
  bool check = false;
  std::optional<double> until;
  std::optional<int> frames;
  std::string report;
  CommonOptions common;
};

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

void check_backend(const std::string& name) {
  if (name == "gpu") throw UsageError("this build has no GPU backend; leave --backend out");
  if (name != "cpu") throw UsageError(fmt::format("--backend {}: say cpu", name));
}

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
  replay.tolerance = options.tolerance;
  replay.integrator = integrator_named(options.integrator);
  replay.precision = precision_named(options.precision);
  replay.threads = options.threads.value_or(0);
  replay.inverse = options.inverse;
  replay.until = options.until;
  replay.frames = options.frames.value_or(0);
  return replay;
}

// The file of a moment of the deformation: of the result, where there are no frames.
class Target {
 public:
  explicit Target(const DeformOptions& options) : path_(options.output) {
    if (!options.frames) return;
    pattern_ = parse_frame_pattern(options.output);
    count_ = *options.frames;
  }

  int count() const { return count_; }
  std::string path(int index) const { return pattern_ ? frame_path(*pattern_, index) : path_; }
  std::string last_path() const { return path(count_ - 1); }

 private:
  std::string path_;
  std::optional<FramePattern> pattern_;
  int count_ = 1;
};

// All that can go wrong with the outputs is found before the work begins.
void check_outputs(const DeformOptions& options, const Target& target) {
  require_shape_extension(target.path(0));
  for (int i = 0; i < target.count(); ++i) require_writable(target.path(i));
  require_different(options.session, target.path(0));
  if (options.report.empty() || options.report == "-") return;
  for (const std::string& other : {options.shape, options.session, target.path(0)}) {
    require_different(other, options.report);
  }
  require_writable(options.report);
}

void check_until(const DeformOptions& options, const Session& session) {
  if (options.until && *options.until > static_cast<double>(session.strokes.size())) {
    throw UsageError(fmt::format("--until {}: {} has {}; give at most that", *options.until, session.name,
                                 counted(session.strokes.size(), "stroke")));
  }
}

std::string summary(const DeformOptions& options, const Target& target, const Report& report) {
  std::string text =
      fmt::format("{}: {} of {} vertices moved by {} ({})\n", target.last_path(), report.moved_vertices,
                  report.vertices, counted(report.strokes, "stroke"), counted(report.segments, "segment"));
  if (options.frames) text += fmt::format("frames   {}, from {}\n", target.count(), target.path(0));
  text += fmt::format("steps    {:.3g} a vertex on average, {} at most\n", report.steps_mean, report.steps_max);
  text += report.volume_error ? fmt::format("volume   changed by {:.2g} of itself\n", *report.volume_error)
                              : "volume   none: the shape is not closed and oriented\n";
  if (report.flipped_triangles > 0) text += fmt::format("flipped  {} triangles\n", report.flipped_triangles);
  if (report.penetration)
    text += fmt::format("inside   {:.2g} deep at most is left in a stamp's tool\n", *report.penetration);
  if (report.self_intersections_before && report.self_intersections_after) {
    text += fmt::format("crossing {} of triangles before, {} after\n",
                        counted(*report.self_intersections_before, "pair"), *report.self_intersections_after);
  }
  const ReportSeconds& seconds = report.seconds;
  return text + fmt::format("seconds  {:.2f}: read {:.2f}, deform {:.2f}, write {:.2f}\n", seconds.total, seconds.read,
                            seconds.deform, seconds.write);
}

void print_report(const DeformOptions& options, const Target& target, const Report& report) {
  const bool to_output = options.common.json || options.report == "-";
  if (!options.report.empty() && options.report != "-") write_file_atomically(options.report, to_json(report));
  if (to_output) {
    print(to_json(report));
  } else if (!options.common.quiet) {
    print(summary(options, target, report));
  }
}

// The same triangles before and after.
void add_self_intersections(const Mesh& mesh, const ReplayResult& result, int threads, Report& report) {
  const std::vector<Triangle> triangles = triangulate(mesh);
  const SelfIntersectionOptions options{.threads = threads};
  report.self_intersections_before = self_intersections(triangles, mesh.positions, options).count;
  report.self_intersections_after = self_intersections(triangles, result.positions, options).count;
}

// Measuring a large shape for a report that nobody reads would take longer than writing it.
bool is_reported(const DeformOptions& options) {
  return !options.common.quiet || options.common.json || !options.report.empty();
}

// Backwards, strokes that read the surface are resolved with the shape that they were made on.
void resolve_on_own_shape(Session& session, ReplayOptions options, bool quiet) {
  const bool reads = std::any_of(session.strokes.begin(), session.strokes.end(),
                                 [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); });
  if (!reads || !session.mesh) return;
  const std::filesystem::path path = std::filesystem::path(session.name).parent_path() / *session.mesh;
  const Inputs inputs{read_shape(path), session};
  options.inverse = false;
  options.until = std::nullopt;
  options.frames = 0;
  const std::vector<Vec3d> normals =
      inputs.shape.mesh.face_count() == 0 ? vertex_normals_of(inputs.shape) : std::vector<Vec3d>{};
  options.normals = normals;
  session.strokes = replay_watched(inputs, options, quiet).resolved;
  if (!quiet) print_message(fmt::format("note: {}: resolved with {}", session.name, path.string()));
}

void copy_materials(const DeformOptions& options, const ShapeFile& shape, const std::string& target) {
  for (const std::filesystem::path& path : copy_material_files(shape, options.shape, target)) {
    if (!options.common.quiet) print_message(fmt::format("note: {}: the materials are copied too", path.string()));
  }
}

void run_deform(const DeformOptions& options) {
  const Clock total;
  ReplayOptions replay = replay_options(options);
  const Target target(options);
  check_outputs(options, target);
  ReportSeconds seconds;
  Inputs inputs = read_inputs(options.shape, options.session, options.common.quiet);
  check_until(options, inputs.session);
  if (options.inverse) resolve_on_own_shape(inputs.session, replay, options.common.quiet);
  const std::vector<std::string> losses = conversion_losses(target.path(0), inputs.shape);
  if (!options.common.quiet) print_notes(losses);
  seconds.read = total.seconds();

  std::vector<Vec3d> normals;
  if (inputs.shape.mesh.face_count() == 0) normals = vertex_normals_of(inputs.shape);
  replay.normals = normals;
  const auto write = [&](const ReplayFrame& frame) {
    const Clock clock;
    write_shape(target.path(frame.index), inputs.shape, frame.positions,
                {replay.precision == Precision::float64, frame.normals});
    seconds.write += clock.seconds();
  };
  if (options.frames) replay.on_frame = write;
  const Clock deforming;
  const ReplayResult result = replay_watched(inputs, replay, options.common.quiet);
  seconds.deform = deforming.seconds() - seconds.write;
  if (!options.frames) write({0, result.positions, result.normals});
  if (format_of(target.path(0)) == "obj") copy_materials(options, inputs.shape, target.path(0));
  if (!is_reported(options)) return;
  Report report = make_report(inputs.shape.mesh, result, replay, seconds);
  if (options.check) add_self_intersections(inputs.shape.mesh, result, replay.threads, report);
  report.seconds.total = total.seconds();
  print_report(options, target, report);
}

void add_options(CLI::App& app, DeformOptions& options) {
  app.add_option("SHAPE", options.shape, "A mesh or point cloud: PLY, OBJ, STL, OFF, GLB or XYZ")
      ->required()
      ->type_name("");
  app.add_option("SESSION", options.session, "The strokes: a .knead file")->required()->type_name("");
  app.add_option("-o,--output", options.output,
                 "The file to write, in the format of its extension; may be SHAPE itself")
      ->required()
      ->type_name("FILE");
  app.add_option("--tolerance", options.tolerance,
                 "Position error of one path line over one segment, relative to the shape's box diagonal")
      ->capture_default_str()
      ->type_name("T");
  app.add_option("--integrator", options.integrator,
                 "rk4 (the paper's), bs32 (bogacki-shampine), dp54 (dormand-prince), tsit5 (tsitouras)")
      ->capture_default_str()
      ->type_name("NAME");
  app.add_option("--precision", options.precision, "float or double; double writes PLY coordinates as doubles")
      ->capture_default_str()
      ->type_name("NAME");
  app.add_option("--backend", options.backend, "cpu")->capture_default_str()->type_name("NAME");
  app.add_option("--threads", options.threads, "How many threads (all); the result is the same")->type_name("N");
  app.add_flag("--inverse", options.inverse, "The session backwards: takes a deformed shape back");
  app.add_flag("--check", options.check, "Count the self-intersections before and after, for the report");
  app.add_option("--until", options.until, "Stop after so many strokes; 2.5: half of the third")->type_name("S");
  app.add_option("--frames", options.frames,
                 "So many evenly spaced moments, the first and last among them; -o is then a pattern with one %04d")
      ->type_name("N");
  app.add_option("--report", options.report, "Write a JSON report to this file; -: standard output")->type_name("FILE");
  add_common_options(app, options.common);
}

}  // namespace

Subcommand add_deform(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("deform", "Deform a mesh or point cloud by a session");
  const auto options = std::make_shared<DeformOptions>();
  add_options(*app, *options);
  add_examples(*app,
               "  knead deform hand.ply bend.knead -o bent.ply\n"
               "  knead deform bent.ply bend.knead --inverse -o hand_again.ply\n"
               "  knead deform hand.ply bend.knead --frames 60 -o F_%04d.ply\n"
               "  knead deform scan.ply bend.knead --precision double --tolerance 1e-9 --report - -o exact.ply\n"
               "A file whose name begins with - is given after --, as in: knead deform -o out.ply -- -a.ply b.knead");
  return {app, [options] { run_deform(*options); }};
}

}  // namespace knead::command
