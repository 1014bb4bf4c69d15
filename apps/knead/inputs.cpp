// Reads the inputs of the subcommands, and replays sessions with a progress bar.
#include "inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <numeric>
#include <optional>
#include <system_error>
#include <vector>

#include "command.h"
#include "knead/error.h"
#include "knead/io.h"
#include "output.h"

#ifdef KNEAD_HAS_GPU
#include "knead/editor/gpu.h"
#endif

namespace knead::command {

namespace {

constexpr std::string_view kInput = "standard input";
constexpr std::size_t kMaxKeptBytes = std::size_t{64} << 20;  // of a file that can be read again

std::string read_standard_input() {
  std::string bytes;
  std::array<char, 1 << 16> block{};
  for (std::size_t count = 0; (count = std::fread(block.data(), 1, block.size(), stdin)) > 0;) {
    bytes.append(block.data(), count);
  }
  if (std::ferror(stdin) == 0) return bytes;
  throw IoError(IoError::Operation::read, std::string(kInput),
                fmt::format("cannot be read ({}); check where it comes from", std::generic_category().message(errno)));
}

void put_on_walls_watched(Inputs& inputs, const std::string& path, int threads) {
  Progress progress;
  const CancelOnInterruption cancel(progress);
  const std::span<const Vec3d> points = inputs.shape.mesh.positions;
  progress.total = points.size();  // until it is known better
  const ProgressBar bar(progress, 0, !inputs.quiet);
  const bool has_walls = !inputs.session.walls.empty();
  try {
    std::vector<std::string> notes;
    const auto cells = std::make_shared<const VolumeCells>(cells_to_judge(path, inputs.shape, has_walls, notes));
    if (!inputs.quiet) print_notes(notes);
    if (!has_walls && cells->size() == 0) return;
    const std::vector<Patch> patches = has_walls ? read_patches(path, inputs.shape) : std::vector<Patch>{};
    inputs.session = on_walls(std::move(inputs.session), patches, points, {threads, &progress, cells});
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
}

}  // namespace

void add_format_option(std::vector<Option>& options, StreamFormat& format) {
  options.push_back({"--format", &format,
                     "The format of a shape that is -, standard input or output, by the extension of its files",
                     "EXT"});
}

void check_streams(const std::vector<std::string>& paths, const StreamFormat& format) {
  const bool streams = std::any_of(paths.begin(), paths.end(), is_stream);
  if (streams && !format) throw UsageError("-: standard input and output have no extension; add --format, as ply");
  if (!streams && format) throw UsageError("--format: no file is -; the extension of a file says its format");
  if (!format) return;
  const std::vector<std::string_view> known = shape_extensions();
  if (std::find(known.begin(), known.end(), *format) != known.end()) return;
  throw UsageError(fmt::format("--format {}: no such format; say one of {}", *format, fmt::join(known, ", ")));
}

void require_free_output(const std::string& output, bool asked, std::string_view option) {
  if (!asked || !is_stream(output)) return;
  throw UsageError(
      fmt::format("{}: standard output takes the result (--output -); write one of them to a file", option));
}

ShapeFile read_shape_or_stream(const std::string& path, const StreamFormat& format, const ReadOptions& options) {
  if (!is_stream(path)) return read_shape(path, options);
  return parse_shape(read_standard_input(), format_of(format_path(path, format)), std::string(kInput));
}

ShapeSummary read_summary_or_stream(const std::string& path, const StreamFormat& format) {
  if (!is_stream(path)) return read_summary(path);
  return parse_summary(read_standard_input(), format_of(format_path(path, format)), std::string(kInput));
}

std::filesystem::path format_path(const std::string& path, const StreamFormat& format) {
  return is_stream(path) ? "standard output." + *format : path;
}

void require_shape_output(const std::string& path) {
  if (is_stream(path)) return;
  require_shape_extension(path);
  require_writable(path);
}

void end_after_last_shape(const std::string& path, bool more_to_say) {
  if (is_stream(path)) return;
  const std::string format = format_of(path);
  if (format != "gltf" && format != "glb" && format != "obj") end_after_last_output(more_to_say);
}

void write_remeshed_or_stream(const std::string& path, const StreamFormat& format, const ShapeFile& source,
                              const Mesh& mesh, std::span<const std::uint32_t> face_source,
                              const WriteOptions& options) {
  if (!is_stream(path)) return write_remeshed(path, source, mesh, face_source, options);
  print(serialize_remeshed(format_of(format_path(path, format)), source, mesh, face_source, options));
}

void copy_materials(const ShapeFile& shape, const std::string& source, const std::string& target, bool quiet) {
  if (format_of(target) != shape.format) return;
  std::vector<std::string> notes;
  copy_material_files(shape, source, target, &notes);
  if (!quiet) print_notes(notes);
}

void add_set_option(std::vector<Option>& options, std::vector<std::string>& set) {
  options.push_back(
      {"--set", &set, "Give a parameter of the session this value, as in length=0.3; may be repeated", "NAME=NUMBER"});
}

Session read_session_with(const SessionSource& source) {
  ParameterValues values;
  for (const std::string& text : source.set) {
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string name = text.substr(0, equals);
    const char* const end = text.data() + text.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data() + std::min(equals + 1, text.size()), end, value);
    if (name.empty() || error != std::errc{} || stop != end) {
      throw UsageError(fmt::format("--set {}: give a name and a number, as in --set length=0.3", text));
    }
    if (!values.emplace(name, value).second) throw UsageError(fmt::format("--set {}: {} is given twice", text, name));
  }
  Session session;
  if (source.path.empty() == source.strokes.empty()) {
    throw UsageError("name a SESSION, or give the strokes with --stroke");
  }
  if (source.strokes.empty()) session = read_session(source.path);
  for (const std::string& text : source.strokes) {
    session.name = "--stroke";
    session.strokes.push_back(parse_stroke(text, session.name));
  }
  return values.empty() ? session : with_values(std::move(session), values);
}

Inputs read_inputs(const std::string& shape, const StreamFormat& format, const SessionSource& source, bool quiet,
                   int threads) {
  const std::string& session = source.path;
  Inputs inputs;
  inputs.quiet = quiet;
  if (is_shape_file(session) && !is_shape_file(shape) && !is_stream(shape)) {
    throw UsageError(fmt::format("{}: a session stands where the shape belongs; write {} {}", shape, session, shape));
  }
  const std::string extension = lower_case(shape_suffix(session));
  for (const std::string_view mesh : written_extensions(true)) {
    if (extension != fmt::format(".{}", mesh)) continue;
    throw UsageError(fmt::format("{}: a shape stands where the session belongs; name a .knead file", session));
  }
  inputs.session = without_off(read_session_with(source));  // first, because it is shorter and more often has errors
  inputs.shape = read_shape_or_stream(shape, format, {.most_kept_bytes = kMaxKeptBytes});
  if (!inputs.session.walls.empty() || !is_stream(shape)) put_on_walls_watched(inputs, shape, threads);
  if (!quiet) {
    print_notes(inputs.session.warnings);
    for (const std::string& note : inputs.shape.notes) print_message(fmt::format("note: {}: {}", shape, note));
  }
  return inputs;
}

Session without_cells(Session session) {
  if (session.walls.empty()) session.constraint.reset();
  return session;
}

ReplayResult replay_watched(const Mesh& mesh, const Session& session, ReplayOptions options, bool quiet) {
  Progress progress;
  options.progress = &progress;
  options.strokes_warn = false;
  Replay replay(borrow(mesh), session, options);
  if (!quiet) print_notes(replay.warnings());
  ReplayResult result;
  {
    std::optional<CancelOnInterruption> cancel(std::in_place, progress);
    const int frames = frame_count(options.frames);
    ProgressBar bar(progress, replay.work(), !quiet, frames);
    if (const auto deliver = options.frames.deliver) {
      // From the last frame on, an interruption that comes when all files are in place is none.
      options.frames.deliver = [&, deliver](const ReplayFrame& frame) {
        if (frame.index + 1 == frames) cancel.reset();
        if (progress.cancel) throw Interrupted{};
        deliver(frame);
        bar.count_frame();
      };
    }
    result = replay.run();
  }
  if (progress.cancel) throw Interrupted{};
  if (result.status == AdvectStatus::step_limit) {
    throw QualityError(to_string(Place{session.name, result.failed_line}) + ": " + kStepLimitAdvice);
  }
  if (!quiet) print_notes(result.warnings);
  return result;
}

double moment_among_resolved(const std::vector<SessionStroke>& strokes, const std::vector<SessionStroke>& resolved,
                             double moment) {
  double result = 0;
  double share = moment;  // of the current stroke
  for (auto stroke = strokes.begin(); stroke != strokes.end() && share > 0; ++stroke, --share) {
    std::vector<double> lengths;  // of its parts, in segments
    for (const SessionStroke& part : resolved) {
      if (part.line != stroke->line) continue;
      const std::vector<Segment> segments = share < 1 ? flow_of(part).segments : std::vector<Segment>{};
      lengths.push_back(std::accumulate(segments.begin(), segments.end(), 0.0,
                                        [](double sum, const Segment& segment) { return sum + segment.end; }));
    }
    double left = share * std::accumulate(lengths.begin(), lengths.end(), 0.0);
    for (const double length : lengths) {
      if (left > 0 || share >= 1) result += share >= 1 ? 1 : std::min(1.0, left / length);
      left -= length;
    }
  }
  return result;
}

void require_reached(const ReplayResult& result) {
  if (!result.shortfalls.empty()) throw QualityError(result.shortfalls.front());
}

#ifdef KNEAD_HAS_GPU

ChosenBackend choose_backend(const std::string& name, bool quiet) {
  if (name != "gpu") return {};
  const auto use = std::make_shared<BackendUse>();
  Backend gpu = gpu::backend_or_cpu([use, quiet](const std::string& why) {
    use->has_failed = true;
    if (!quiet) print_message(fmt::format("note: {}; the CPU moves the points instead", why));
  });
  Backend move = [use, gpu = std::move(gpu)](const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options) {
    use->was_called = true;
    return gpu(flow, points, options);
  };
  return {std::move(move), use};
}

#else

ChosenBackend choose_backend(const std::string& /*name*/, bool /*quiet*/) { return {}; }

#endif

}  // namespace knead::command
