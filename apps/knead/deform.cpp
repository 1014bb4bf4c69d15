// knead deform SHAPE SESSION -o OUT: deforms a mesh or point cloud by a session.
#include "deform.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "certified.h"
#include "command.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/certify.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "output.h"

namespace knead::command {

constexpr double kToldDistance = 1e-9;  // of the diagonal: more than rounding

WriteOptions write_options_for(const DeformOptions& options, const Digits& digits, const ShapeFile& shape,
                               const std::string& output) {
  WriteOptions result;
  result.double_coordinates = options.precision == Precision::float64;
  const bool is_own = format_of(format_path(output, options.format)) == shape.format;
  const bool is_certified = options.check || options.require;  // of coordinates that are not rounded
  if (digits.kind == DigitsKind::given || (is_own && !is_certified)) {
    result.decimals = decimals_for(digits, shape, options.tolerance);
  }
  return result;
}

void split_long_splats(const DeformOptions& options, const ReplayOptions& replay, const std::string& path,
                       const Session& session, ShapeFile& shape) {
  std::vector<std::string> notes;
  const std::size_t before = shape.mesh.vertex_count();
  if (split_splats(shape, session, replay, options.max_splats, &notes)) {
    notes.insert(notes.begin(), fmt::format("long splats are split, so that they can bend: {} are now {}", before,
                                            shape.mesh.vertex_count()));
  }
  if (options.common.quiet) return;
  for (const std::string& note : notes) print_message(fmt::format("note: {}: {}", path, note));
}

void write_frame(const std::string& path, const StreamFormat& format, const Inputs& inputs, const DeformedShape& shape,
                 const WriteOptions& options) {
  const ShapeFile& source = inputs.shape;
  if (!inputs.quiet && shape.put_back() > kToldDistance * shape_box(source.mesh).diagonal()) {
    print_message(fmt::format("note: {}: points were put back onto walls by up to {:.2g}", path, shape.put_back()));
  }
  if (!is_stream(path)) return write_deformed(path, source, shape, options);
  print(serialize_deformed(format_of(format_path(path, format)), source, shape, options));
}

namespace {

// The files to write: one for each frame, one for all of them, or one for the result if there are no frames.
class Target {
 public:
  Target(const DeformOptions& options, const FrameOptions& frames) : path_(options.output) {
    const bool is_one_file = knead::is_animation(path_) && !is_pattern(path_);
    if (!options.frames.frames) {
      if (is_one_file && !is_shape_file(path_)) {
        throw UsageError(fmt::format("--output {}: an animation; say how many frames it has, with --frames N", path_));
      }
      return;
    }
    count_ = frame_count(frames);
    is_animation_ = is_one_file;
    if (!is_animation_) pattern_ = parse_frame_pattern(options.output);
  }

  int count() const { return count_; }
  bool is_animation() const { return is_animation_; }
  std::string path(int index) const { return pattern_ ? frame_path(*pattern_, index) : path_; }
  std::string last_path() const { return path(count_ - 1); }

  // Returns the files of an animation: a series of ParaView has one for each frame, and one that names them.
  std::size_t files() const {
    return lower_case(std::filesystem::path(path_).extension().string()) == ".pvd"
               ? static_cast<std::size_t>(count_) + 1
               : 1;
  }

 private:
  std::string path_;
  std::optional<FramePattern> pattern_;
  bool is_animation_ = false;
  int count_ = 1;
};

// Finds all problems with the outputs before the work begins.
void check_outputs(const DeformOptions& options, const Target& target) {
  check_streams({options.shape, target.path(0)}, options.format);
  require_free_output(target.path(0), options.common.json, "--json");
  if (target.is_animation()) {
    require_writable(target.path(0));
  } else {
    for (int i = 0; i < target.count(); ++i) require_shape_output(target.path(i));
  }
  for (const std::string& file : {options.session, options.session_output}) {
    if (!file.empty()) require_different(file, target.path(0));
  }
  if (!options.session_output.empty()) require_writable(options.session_output);
  check_report(options, target.path(0));
}

std::string remesh_text(const RemeshReport& remesh) {
  std::string text = fmt::format("remesh   {}, {}, {}", counted(remesh.splits, "split"),
                                 counted(remesh.collapses, "collapse"), counted(remesh.flips, "flip"));
  if (remesh.volume_error_uncompensated) {
    text += fmt::format("; volume changed by {:.2g} without compensation", *remesh.volume_error_uncompensated);
  }
  return text + (remesh.complete
                     ? "\n"
                     : "; stopped at a limit: edges are above the targets, or triangles too thin to improve\n");
}

// `frames`: the line about them, if there are some.
std::string summary(const std::string& output, const std::string& frames, const Report& report) {
  std::string text =
      fmt::format("{}: {} of {} vertices moved by {} ({})\n", output, report.moved_vertices, report.vertices,
                  counted(report.strokes, "stroke"), counted(report.segments, "segment"));
  text += frames;
  text += fmt::format("steps    {:.3g} per vertex on average, {} at most\n", report.steps_mean, report.steps_max);
  text += report.volume_error ? fmt::format("volume   changed by a fraction of {:.2g}\n", *report.volume_error)
                              : "volume   none: the shape is not closed and oriented, or holds none\n";
  if (report.flipped_triangles > 0) text += fmt::format("flipped  {} triangles\n", report.flipped_triangles);
  if (report.cells) {
    text += fmt::format("cells    {} of {} inverted\n", report.cells->inverted, report.cells->cells);
  }
  if (report.penetration)
    text += fmt::format("inside   the surface is at most {:.2g} deep inside a stamp's tool\n", *report.penetration);
  if (report.self_intersections_before && report.self_intersections_after) {
    text += fmt::format("crossing {} of triangles before, {} after\n",
                        counted(*report.self_intersections_before, "pair"), *report.self_intersections_after);
  }
  if (report.crossings_between) {
    text += fmt::format("between  {} of triangles of two shapes cross\n", counted(*report.crossings_between, "pair"));
  }
  if (report.remesh) text += remesh_text(*report.remesh);
  if (report.certificate) text += "certificate " + line_of(*report.certificate) + "\n";
  const ReportSeconds& seconds = report.seconds;
  return text + fmt::format("seconds  {:.2f}: read {:.2f}, deform {:.2f}, write {:.2f}, measure {:.2f}\n",
                            seconds.total, seconds.read, seconds.deform, seconds.write, seconds.measure);
}

// Returns one line that says what was done.
std::string brief(const std::string& output, const Session& session, const Report& report) {
  std::string text = output + ": ";
  for (const SessionStroke& stroke : session.strokes) text += words_of(stroke.stroke, "") + ", ";
  text += fmt::format("{} vertices", report.vertices);
  if (report.volume_error) text += fmt::format(", volume changed by a fraction of {:.1g}", *report.volume_error);
  if (report.certificate) {
    text += fmt::format(", {} crossing, {}", counted(report.certificate->crossings_after, "pair"),
                        report.certificate->closed_after ? "closed" : "open");
    if (const auto& c = *report.certificate; c.det_least) {
      text += fmt::format(", det J from {:.3g} to {:.3g}", *c.det_least, *c.det_greatest);
    }
  }
  if (report.greatest_stretch) text += fmt::format(", stretched up to {:.3g} times", *report.greatest_stretch);
  return text + fmt::format(", {:.2f} s\n", report.seconds.total);
}

std::string frames_line(const DeformOptions& options, const Target& target) {
  if (!options.frames.frames) return {};
  return target.is_animation() ? fmt::format("frames   {}\n", target.count())
                               : fmt::format("frames   {}, from {}\n", target.count(), target.path(0));
}

bool says_one_line(const DeformOptions& options) {
  return options.is_brief && !options.common.json && options.report.empty();
}

// One line names no distance, so that a part of the points is enough to refine what is far from the exact image.
std::size_t points_measured(const DeformOptions& options) {
  constexpr std::size_t kMaxPointsOfLine = 5'000;
  return says_one_line(options) && !options.require ? kMaxPointsOfLine : std::numeric_limits<std::size_t>::max();
}

void say(const DeformOptions& options, const Target& target, const Session& session, const Report& report) {
  if (says_one_line(options) && !options.common.quiet) return print(brief(target.last_path(), session, report));
  print_report(options, target.last_path(), frames_line(options, target), report);
}

void write_session(const DeformOptions& options, const Session& session) {
  if (!options.session_output.empty()) {
    write_file_atomically(options.session_output, serialize_session(session));
  }
}

Inputs read_deform_inputs(const DeformOptions& options, ReplayOptions& replay, const Target& target) {
  const bool quiet = options.common.quiet;
  Inputs inputs = read_inputs(options.shape, options.format, source_of(options), quiet, replay.motion.threads);
  check_until(options, inputs.session);
  inputs.remeshes = Replay(borrow(inputs.shape.mesh), inputs.session, replay).remeshes();
  if (!quiet && options.remesh.seconds && !inputs.remeshes) {
    print_message("note: --remesh-seconds: nothing is remeshed; add --remesh");
  }
  if (options.inverse) resolve_on_own_shape(inputs.session, replay, quiet);
  const std::filesystem::path path = format_path(target.path(0), options.format);
  std::vector<std::string> losses;  // found even if they are not printed, because formats refuse shapes there
  if (!target.is_animation()) {
    losses = inputs.remeshes ? remesh_losses(path, inputs.shape) : conversion_losses(path, inputs.shape);
  } else if (inputs.remeshes) {
    losses = {"every frame has the vertices and faces of the remeshed result, without other attributes"};
  } else if (!quiet) {
    losses = animation_losses(path, inputs.shape);
  }
  if (!quiet) print_notes(losses);
  split_long_splats(options, replay, options.shape, inputs.session, inputs.shape);
  return inputs;
}

// --- knead resolve SHAPE SESSION -o OUT.knead: the session as strokes that need no mesh ------------------------------

struct ResolveOptions {
  std::string shape;
  std::string session;
  std::string output;
  std::vector<std::string> set;
  StreamFormat format;
  CommonOptions common;
};

void run_resolve(const ResolveOptions& options) {
  const bool to_output = is_stream(options.output);
  require_free_output(options.output, options.common.json, "--json");
  if (!to_output) {
    constexpr std::string_view extensions[] = {"knead"};
    require_extension(options.output, extensions);
    require_writable(options.output);
  }
  check_streams({options.shape}, options.format);
  const Inputs inputs =
      read_inputs(options.shape, options.format, {options.session, options.set}, options.common.quiet);
  require_flows(inputs.session, "it cannot be resolved; remove this line, or use the session as it is");
  ReplayOptions replay;
  replay.may_cross = true;  // the shape is not kept
  if (inputs.shape.mesh.face_count() == 0) replay.normals = vertex_normals_of(inputs.shape);
  replay.remesh.face_labels = face_labels(inputs.shape);
  const ReplayResult result =
      replay_watched(inputs.shape.mesh, without_cells(inputs.session), replay, options.common.quiet);
  Session resolved;
  resolved.note = inputs.session.note;
  resolved.strokes = result.resolved;
  if (to_output) {
    print(serialize_session(resolved));
    return require_reached(result);
  }
  end_after_last_output(options.common.json);
  write_file_atomically(options.output, serialize_session(resolved));
  if (options.common.json) {
    const Json json{{"strokes", resolved.strokes.size()}, {"segments", result.segments}};
    print(to_indented_text(json));
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} ({})\n", options.output, counted(resolved.strokes.size(), "stroke"),
                      counted(result.segments, "segment")));
  }
  require_reached(result);
}

}  // namespace

void run_deform(const DeformOptions& options) {
  if (!options.table.empty()) return run_batch(options);
  if (is_streamed(options)) return run_stream(options);
  if (!options.also.empty()) return run_together(options);
  const Clock total;
  ReplayOptions replay = replay_options(options);
  const std::vector<Bound> bounds = options.require ? parse_bounds(*options.require) : std::vector<Bound>{};
  replay.may_cross = bounds_crossings(bounds);
  const Target target(options, replay.frames);
  check_outputs(options, target);
  const Digits digits = digits_of(options);
  const bool quiet = options.common.quiet;
  const ChosenBackend backend = choose_backend(options.backend, quiet);
  replay.motion.backend = backend.move;
  ReportSeconds seconds;
  const Inputs inputs = read_deform_inputs(options, replay, target);
  seconds.read = total.seconds();

  if (inputs.shape.mesh.face_count() == 0) replay.normals = vertex_normals_of(inputs.shape);
  replay.remesh.face_labels = face_labels(inputs.shape);
  WriteOptions write_options;
  std::function<void(const ReplayFrame&)> add_to_animation;
  if (target.is_animation()) {
    replay.frames.same_faces = true;
    add_to_animation = animation_writer(target.path(0), inputs.shape, inputs.remeshes,
                                        {target.count(), options.frames.frames_per_second()});
  } else {
    write_options = write_options_for(options, digits, inputs.shape, target.path(0));
    replay.remesh.single_precision =
        stores_floats(format_path(target.path(0), options.format), inputs.shape, write_options);
  }
  const auto write = [&](const ReplayFrame& frame) {
    const Clock clock;
    const bool is_last = frame.index + 1 == target.count();
    if (add_to_animation) {
      if (is_last) end_after_last_output(says_more(options), target.files());
      add_to_animation(frame);
    } else {
      if (is_last) end_after_last_shape(target.last_path(), says_more(options));
      write_frame(target.path(frame.index), options.format, inputs, frame.shape, write_options);
    }
    seconds.write += clock.seconds();
  };
  if (options.frames.frames) replay.frames.deliver = write;
  const Clock deforming;
  const Certified certified = replay_certified(inputs, replay, options.check, bounds, quiet, points_measured(options));
  seconds.deform = deforming.seconds() - seconds.write;
  if (!options.frames.frames) write({0, certified.result.shape});
  if (!target.is_animation() && !is_stream(target.path(0))) {
    copy_materials(inputs.shape, options.shape, target.path(0), options.common.quiet);
  }
  write_session(options, inputs.session);
  if (!is_reported(options)) return require_reached(certified.result);
  const Clock measuring;
  Report report = report_of(inputs.shape.mesh, certified, seconds);
  report.seconds.measure = measuring.seconds();
  report.seconds.total = total.seconds();
  report.backend = backend.name();
  say(options, target, inputs.session, report);
  require_reached(certified.result);
}

void check_report(const DeformOptions& options, const std::string& output) {
  require_free_output(output, options.report == "-", "--report -");
  if (options.report.empty() || options.report == "-") return;
  for (const std::string& other : {options.shape, options.session, output}) {
    if (!other.empty()) require_different(other, options.report);
  }
  require_writable(options.report);
}

void print_report(const DeformOptions& options, const std::string& output, const std::string& frames,
                  const Report& report) {
  const bool to_output = options.common.json || options.report == "-";
  if (!options.report.empty() && options.report != "-") write_file_atomically(options.report, to_json(report));
  if (to_output) {
    print(to_json(report));
  } else if (!options.common.quiet && !is_stream(options.output)) {
    print(summary(output, frames, report));
  }
}

bool is_reported(const DeformOptions& options) {
  const bool is_printed = !options.common.quiet && !is_stream(options.output);
  return is_printed || options.common.json || !options.report.empty();
}

SessionSource source_of(const DeformOptions& options) { return {options.session, options.set, options.strokes}; }

bool says_more(const DeformOptions& options) { return options.common.json || !options.report.empty(); }

void require_flows(const Session& session, std::string_view consequence) {
  if (puts_points_back(session)) {
    throw InvalidInput(
        Place{session.name, 1},
        "points are put back onto these walls, which is no flow, so the session cannot be resolved; use it "
        "as it is");
  }
  for (const SessionStroke& stroke : session.strokes) {
    if (is_flow(stroke.stroke)) continue;
    throw InvalidInput(Place{session.name, stroke.line}, fmt::format("a relax is no flow, so {}", consequence));
  }
}

void resolve_on_own_shape(Session& session, ReplayOptions& options, bool quiet) {
  const bool reads = std::any_of(session.strokes.begin(), session.strokes.end(),
                                 [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); });
  const bool has_inverse = std::all_of(session.strokes.begin(), session.strokes.end(),
                                       [](const SessionStroke& stroke) { return is_flow(stroke.stroke); });
  if (!reads || !has_inverse || !session.mesh) return;
  const std::filesystem::path folder = std::filesystem::path(session.name).parent_path();
  const std::filesystem::path path = folder / *session.mesh;
  Inputs own;
  own.shape = read_shape(path);
  for (const std::string& other : session.also) own.also.push_back(read_shape(folder / other));
  if (!own.also.empty()) join(own);
  ReplayOptions forwards = options;
  forwards.part = {};
  forwards.must_follow = false;
  forwards.frames = {};
  forwards.normals = normals_of_clouds(own);
  std::vector<SessionStroke> resolved = replay_watched(own.mesh(), without_cells(session), forwards, quiet).resolved;
  std::optional<double>& until = options.part.until;
  if (until) until = moment_among_resolved(session.strokes, resolved, *until);
  session.strokes = std::move(resolved);
  if (!quiet) print_message(fmt::format("note: {}: its strokes were resolved on {}", session.name, path.string()));
}

Report report_of(const Mesh& mesh, const Certified& certified, const ReportSeconds& seconds) {
  Report report = make_report(mesh, certified.result, certified.options, seconds);
  report.certificate = certified.certificate;
  if (!report.certificate) return report;
  report.self_intersections_before = report.certificate->crossings_before;
  report.self_intersections_after = report.certificate->crossings_after;
  return report;
}

bool bounds_crossings(const std::vector<Bound>& bounds) {
  return std::any_of(bounds.begin(), bounds.end(), [](const Bound& bound) { return bound.name == kCrossingsBound; });
}

Subcommand deform_command() {
  const auto options = std::make_shared<DeformOptions>();
  return {"deform", "Deform a mesh or point cloud by a session", describe(*options),
          "  knead deform hand.ply bend.knead -o bent.ply\n"
          "  knead deform bent.ply bend.knead --inverse -o hand_again.ply\n"
          "  knead deform hand.ply bend.knead --frames 60 -o F_%04d.ply\n"
          "  knead deform hand.ply bend.knead --frames 48 --ease smooth -o hand.glb\n"
          "  knead deform hand.ply bend.knead --remesh --require volume=1e-5,crossings=0 -o bent.ply\n"
          "  knead deform body.ply bend.knead --also clothes.obj --also eyes.ply -o posed\n"
          "  knead deform wing.stl wing.knead --set sweep=12 -o wing_12.stl\n"
          "  knead deform wing.stl wing.knead --table values.csv -o variants\n"
          "  knead deform ball.stl --stroke 'stretch center=0,0,0 axis=0,0,1 factor=1.5 inner=2 outer=9' -o egg.stl\n"
          "  knead deform scan.ply bend.knead --precision double --tolerance 1e-9 --report - -o exact.ply\n"
          "  knead deform - bend.knead --format ply -o - < hand.ply > bent.ply\n"
          "If the name of a file begins with -, put it after --: knead deform -o out.ply -- -a.ply b.knead",
          [options] { run_deform(*options); }};
}

Subcommand resolve_command() {
  const auto options = std::make_shared<ResolveOptions>();
  std::vector<Option> described{
      {"SHAPE", &options->shape, "The shape that the session was made for", "", OptionKind::required},
      {"SESSION", &options->session, "The strokes: a .knead file", "", OptionKind::required},
      {"-o,--output", &options->output, "The .knead file to write, or - for standard output", "FILE",
       OptionKind::required},
  };
  add_set_option(described, options->set);
  add_format_option(described, options->format);
  add_common_options(described, options->common);
  return {"resolve", "Write a session as strokes that do not read the surface", described,
          "  knead resolve hand.ply paint.knead -o flow.knead\n"
          "  knead deform fine_hand.ply flow.knead -o painted.ply",
          [options] { run_resolve(*options); }};
}

}  // namespace knead::command
