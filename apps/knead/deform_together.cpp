// knead deform --also: several shapes in one flow.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "certified.h"
#include "deform.h"
#include "inputs.h"
#include "knead/error.h"
#include "knead/io.h"
#include "output.h"

namespace knead::command {

namespace {

std::vector<const Mesh*> meshes_of(const Inputs& inputs) {
  std::vector<const Mesh*> meshes{&inputs.shape.mesh};
  for (const ShapeFile& shape : inputs.also) meshes.push_back(&shape.mesh);
  return meshes;
}

namespace fs = std::filesystem;

// Returns the shapes' files, SHAPE first.
std::vector<std::string> sources_of(const DeformOptions& options) {
  std::vector<std::string> sources{options.shape};
  sources.insert(sources.end(), options.also.begin(), options.also.end());
  return sources;
}

// The output of one shape.
struct PartTarget {
  std::string path;                     // of the result, or of an animation
  std::optional<FramePattern> pattern;  // one file for each frame

  std::string path_of(int frame) const { return pattern ? frame_path(*pattern, frame) : path; }
};

// With frames, a file that can hold an animation holds all of them; of any other there is one for each frame.
PartTarget target_of(const DeformOptions& options, const std::string& shape) {
  PartTarget target{(fs::path(options.output) / fs::path(shape).filename()).string(), std::nullopt};
  if (!options.frames.frames || knead::is_animation(target.path)) return target;
  const fs::path path = target.path;
  target.pattern = FramePattern{(path.parent_path() / path.stem()).string() + "_", 4, path.extension().string()};
  return target;
}

// Finds all problems with the outputs before the work begins.
std::vector<PartTarget> targets_together(const DeformOptions& options) {
  const fs::path folder = options.output;
  std::error_code error;
  if (!fs::is_directory(folder, error) && (fs::exists(folder, error) || is_shape_file(folder))) {
    throw UsageError(fmt::format("--output {}: with --also, give a folder; it takes all results", options.output));
  }
  std::vector<PartTarget> targets;
  for (const std::string& shape : sources_of(options)) {
    if (is_stream(shape) || is_stream(options.output)) {
      throw UsageError("--also: standard input and output hold one shape; give files, and a folder");
    }
    PartTarget target = target_of(options, shape);
    const auto is_same = [&](const PartTarget& other) { return lower_case(other.path) == lower_case(target.path); };
    if (std::ranges::any_of(targets, is_same)) {
      throw UsageError(fmt::format("--also {}: another shape has this name, and both results go to {}; rename one",
                                   shape, options.output));
    }
    require_shape_extension(target.path);
    if (fs::is_directory(folder, error)) require_writable(target.path_of(0));
    require_different(options.session, target.path);
    check_report(options, target.path);
    if (!options.report.empty() && options.report != "-") require_different(shape, options.report);
    targets.push_back(std::move(target));
  }
  if (!fs::is_directory(folder, error)) require_writable(folder);
  return targets;
}

// Makes strokes that read a surface read that of the first shape. Those of a session that was made on several shapes
// read all. Counts replay.part.until in the strokes that there are then.
void resolve_on_first(Inputs& inputs, ReplayOptions& replay, bool quiet) {
  const auto reads = [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); };
  const bool reads_one = inputs.session.also.empty() && std::ranges::any_of(inputs.session.strokes, reads);
  if (!reads_one) return;
  require_flows(inputs.session, "other shapes cannot follow it; remove this line, or deform the shape alone");
  ReplayOptions options = replay;
  options.part = {};
  options.frames = {};
  options.may_cross = true;
  options.must_follow = false;
  options.normals = inputs.shape.mesh.face_count() == 0 ? vertex_normals_of(inputs.shape) : std::vector<Vec3d>{};
  options.remesh.face_labels = face_labels(inputs.shape);
  ReplayResult first = replay_watched(inputs.shape.mesh, without_cells(inputs.session), options, quiet);
  if (!quiet) print_notes(first.shortfalls);
  std::optional<double>& until = replay.part.until;
  if (until) until = moment_among_resolved(inputs.session.strokes, first.resolved, *until);
  inputs.session.strokes = std::move(first.resolved);
}

// Returns the lists of all shapes as one, with `count` items of each shape; empty if all lists are.
template <class T>
std::vector<T> joined_lists(const Inputs& inputs, const std::function<std::vector<T>(const ShapeFile&)>& list_of,
                            std::size_t (Mesh::*count)() const) {
  std::vector<T> all;
  bool is_empty = true;
  const auto append = [&](const ShapeFile& shape) {
    std::vector<T> list = list_of(shape);
    is_empty = is_empty && list.empty();
    list.resize((shape.mesh.*count)());
    all.insert(all.end(), list.begin(), list.end());
  };
  append(inputs.shape);
  for (const ShapeFile& shape : inputs.also) append(shape);
  return is_empty ? std::vector<T>{} : all;
}

Inputs read_together(const DeformOptions& options, ReplayOptions& replay) {
  const bool quiet = options.common.quiet;
  Inputs inputs = read_inputs(options.shape, {}, source_of(options), quiet);
  if (!inputs.session.walls.empty()) {
    throw InvalidInput(Place{options.session, 1}, "walls are those of one mesh; deform it alone");
  }
  check_until(options, inputs.session);
  for (const std::string& path : options.also) {
    inputs.also.push_back(read_shape(path));
    if (quiet) continue;
    for (const std::string& note : inputs.also.back().notes) print_message(fmt::format("note: {}: {}", path, note));
  }
  if (options.inverse) {
    resolve_on_own_shape(inputs.session, replay, quiet);
  } else {
    resolve_on_first(inputs, replay, quiet);
  }
  for (std::size_t i = 0; i < inputs.also.size(); ++i) {
    split_long_splats(options, replay, options.also[i], inputs.session, inputs.also[i]);
  }
  split_long_splats(options, replay, options.shape, inputs.session, inputs.shape);
  join(inputs);
  inputs.remeshes = Replay(borrow(inputs.mesh()), inputs.session, replay).remeshes();
  return inputs;
}

// Writes the deformed shapes. The files take their places at the end, all or none.
class TogetherOutput {
 public:
  TogetherOutput(const DeformOptions& options, const Inputs& inputs, std::vector<PartTarget> targets,
                 const ReplayOptions& replay)
      : options_(options), inputs_(inputs), targets_(std::move(targets)), frames_(frame_count(replay.frames)) {
    const Digits digits = digits_of(options);
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      writing_.push_back(write_options_for(options, digits, source(i), targets_[i].path));
      animations_.emplace_back();
    }
    if (!options.common.quiet) print_losses();
  }
  TogetherOutput(const TogetherOutput&) = delete;
  TogetherOutput& operator=(const TogetherOutput&) = delete;
  ~TogetherOutput() {
    animations_.clear();
    files_.reset();
    std::error_code ignored;
    if (is_folder_new_) fs::remove(options_.output, ignored);  // only an empty one
  }

  bool stores_floats_somewhere() const {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (stores_floats(targets_[i].path, source(i), writing_[i])) return true;
    }
    return false;
  }
  // Whether all frames must have the same faces.
  bool has_animation() const {
    return std::ranges::any_of(targets_, [&](const PartTarget& target) { return is_animation(target); });
  }

  // Writes a frame of every shape, or the result.
  void add(const ReplayFrame& frame) {
    if (!files_) begin();
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (!is_animation(targets_[i])) {
        write(i, frame);
      } else {
        if (!animations_[i]) {
          animations_[i] =
              part_animation_writer(targets_[i].path, part(i), {frames_, options_.frames.frames_per_second()});
        }
        animations_[i](frame);
      }
    }
  }

  // Puts the files in place. An interruption meanwhile waits.
  void finish() {
    end_after_last_output(says_more(options_), files_->count());
    Progress waits;
    const CancelOnInterruption shield(waits);
    files_->finish();
    is_folder_new_ = false;
  }

  std::string frames_line() const {
    return options_.frames.frames ? fmt::format("frames   {} of each shape, from {}\n", frames_, targets_[0].path_of(0))
                                  : std::string();
  }

 private:
  ShapePart part(std::size_t number) const { return {source(number), *inputs_.joined, number}; }
  const ShapeFile& source(std::size_t part) const { return part == 0 ? inputs_.shape : inputs_.also[part - 1]; }
  bool is_animation(const PartTarget& target) const { return options_.frames.frames && !target.pattern; }

  void print_losses() const {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (is_animation(targets_[i])) {
        print_notes(animation_losses(targets_[i].path, source(i)));
      } else if (inputs_.remeshes && source(i).mesh.face_count() > 0) {
        print_notes(remesh_losses(targets_[i].path, source(i)));
      }
    }
  }

  void begin() {
    is_folder_new_ = fs::create_directories(options_.output);
    files_.emplace();
  }

  void write(std::size_t number, const ReplayFrame& frame) {
    const std::string path = targets_[number].path_of(frame.index);
    write_part(path, part(number), frame.shape.state(), writing_[number]);
    const bool is_last = frame.index + 1 == std::max(frames_, 1);
    if (!is_last || !is_shape_file(path)) return;
    copy_materials(source(number), number == 0 ? options_.shape : options_.also[number - 1], path,
                   options_.common.quiet);
  }

  const DeformOptions& options_;
  const Inputs& inputs_;
  std::vector<PartTarget> targets_;
  int frames_ = 0;
  std::vector<WriteOptions> writing_;
  std::vector<std::function<void(const ReplayFrame&)>> animations_;
  std::optional<FilesTogether> files_;
  bool is_folder_new_ = false;
};

// Nothing if there are too many to be counted. Can be interrupted.
std::optional<std::uint64_t> crossings_between(const JoinedMeshes& joined, const DeformedShape& shape, int threads) {
  const Mesh mesh = shape.to_mesh();
  const std::vector<Triangle> triangles = triangulate(WeldedMesh(mesh).mesh());
  std::vector<std::uint32_t> sources = triangle_faces(mesh);
  if (const Provenance* const from = shape.provenance()) {
    for (std::uint32_t& face : sources) face = from->face_source[face];
  }
  Progress progress;
  const CancelOnInterruption cancel(progress);
  try {
    const SelfIntersections found =
        self_intersections(triangles, mesh.positions, {.threads = threads, .progress = &progress});
    if (!found.complete) return std::nullopt;
    return count_between(found, joined, sources);
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
}

}  // namespace

void join(Inputs& inputs) { inputs.joined.emplace(meshes_of(inputs)); }

std::vector<Vec3d> normals_of_clouds(const Inputs& inputs) {
  const auto normals_of = [](const ShapeFile& shape) {
    return shape.mesh.face_count() == 0 ? vertex_normals_of(shape) : std::vector<Vec3d>{};
  };
  return joined_lists<Vec3d>(inputs, normals_of, &Mesh::vertex_count);
}

void run_together(const DeformOptions& options) {
  const Clock total;
  ReplayOptions replay = replay_options(options);
  const std::vector<Bound> bounds = options.require ? parse_bounds(*options.require) : std::vector<Bound>{};
  replay.may_cross = bounds_crossings(bounds);
  std::vector<PartTarget> targets = targets_together(options);
  const bool quiet = options.common.quiet;
  const ChosenBackend backend = choose_backend(options.backend, quiet);
  replay.motion.backend = backend.move;
  ReportSeconds seconds;
  const Inputs inputs = read_together(options, replay);
  seconds.read = total.seconds();
  replay.normals = normals_of_clouds(inputs);
  replay.splats = splats_among(meshes_of(inputs));
  replay.remesh.face_labels = joined_lists<std::uint32_t>(inputs, face_labels, &Mesh::face_count);
  // A session that was made on several shapes is not changed.
  if (inputs.session.also.empty()) replay.motion.diagonal = reference_length(inputs.shape.mesh);

  TogetherOutput output(options, inputs, std::move(targets), replay);
  replay.remesh.single_precision = output.stores_floats_somewhere();
  replay.frames.same_faces = output.has_animation();
  const auto add = [&](const ReplayFrame& frame) {
    const Clock clock;
    output.add(frame);
    seconds.write += clock.seconds();
  };
  if (options.frames.frames) replay.frames.deliver = add;
  const Clock deforming;
  const Certified certified = replay_certified(inputs, replay, options.check, bounds, quiet);
  seconds.deform = deforming.seconds() - seconds.write;
  if (!options.frames.frames) add({0, certified.result.shape});

  // The files wait meanwhile, so that an interruption leaves none.
  const Clock measuring;
  Report report;
  if (is_reported(options)) {
    report = report_of(inputs.mesh(), certified, seconds);
    report.crossings_between = crossings_between(*inputs.joined, certified.result.shape, replay.motion.threads);
  }
  seconds.measure = measuring.seconds();
  const Clock placing;
  output.finish();
  seconds.write += placing.seconds();
  if (!is_reported(options)) return require_reached(certified.result);
  report.seconds = seconds;
  report.seconds.total = total.seconds();
  report.backend = backend.name();
  print_report(options, options.output, output.frames_line(), report);
  require_reached(certified.result);
}

}  // namespace knead::command
