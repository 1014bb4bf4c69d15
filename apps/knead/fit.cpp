// knead fit SOURCE TARGET --landmarks pairs.csv -o OUT.knead: writes a session that takes one shape to another.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.h"
#include "inputs.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/fit.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "output.h"

namespace knead::command {
namespace {

struct FitOptions {
  std::string source;
  std::string target;
  std::optional<std::string> landmarks;
  std::optional<std::string> target_landmarks;
  std::optional<std::string> map;
  bool surface = false;
  bool partial = false;
  std::string output;
  bool scale = false;
  FitVolume volume = FitVolume::keep;
  FitAlign align = FitAlign::automatic;
  double max_stretch = 5;
  int threads = 0;  // 0: all
  CommonOptions common;

  bool scales() const { return scale || volume == FitVolume::total; }
};

void require_volume(const std::string& path, const Mesh& mesh) {
  const Measures m = measure(WeldedMesh(mesh).mesh());
  if (m.closed() && m.oriented() && m.volume > 0) return;
  throw InvalidInput(Place{path}, "--scale needs the volume of both shapes, and this one is not closed; leave it out");
}

// Returns the file for the scaled source: OUT_source.EXT beside OUT.
std::string scaled_path(const FitOptions& options) {
  const std::filesystem::path out = options.output;
  const std::string name = out.stem().string() + "_source" + std::filesystem::path(options.source).extension().string();
  return (out.parent_path() / name).string();
}

// The path of a shape as the header of the session names it.
std::string relative_to(const std::string& shape, const std::string& session) {
  const std::filesystem::path folder = std::filesystem::absolute(session).parent_path();
  return std::filesystem::absolute(shape).lexically_relative(folder).string();
}

std::string line_of(const FitDistance& d) {
  return fmt::format("mean {:.3g}%, 95% within {:.3g}%, at most {:.3g}%", 100 * d.mean, 100 * d.percentile_95,
                     100 * d.max);
}

std::string summary(const FitOptions& options, const BodyFitReport& report) {
  std::string text =
      fmt::format("{}: {}, kept the stage \"{}\"\n", options.output, counted(report.strokes, "stroke"), report.stage);
  if (options.scales())
    text += fmt::format("scale    {:.6g}: {} is the scaled source\n", report.scale, scaled_path(options));
  text += fmt::format("before   {} of the source's diagonal from the target\n", line_of(report.before));
  text += fmt::format("after    {}; landmarks within {:.2g}%\n", line_of(report.after), 100 * report.landmark_distance);
  if (report.after_covered)
    text += fmt::format("         {:.3g}% where both shapes are\n", 100 * *report.after_covered);
  if (report.matched) text += fmt::format("matched  {:.0f}% of the source's surface\n", 100 * *report.matched);
  if (report.volume_error) text += fmt::format("volume   changed by a fraction of {:.2g}\n", *report.volume_error);
  if (report.det_least && report.det_greatest) {
    text += fmt::format("         on purpose: det J from {:.3g} to {:.3g}\n", *report.det_least, *report.det_greatest);
  }
  if (report.volume_difference) {
    text += fmt::format("         the target's volume differs by {:.2g}%\n", 100 * *report.volume_difference);
  }
  text += fmt::format("crossing {} of triangles before, {} after, {} of them new\n",
                      counted(report.crossings_before, "pair"), report.crossings_after, report.crossings_new);
  text += fmt::format("stretch  {:.3g} at most, {:.3g} for 99% of the triangles\n", report.greatest_stretch,
                      report.stretch_99);
  return text;
}

BodyFit watched(const FitOptions& options, const Mesh& source, const Mesh& target, BodyFitOptions fit) {
  Progress progress;
  const CancelOnInterruption cancel(progress);
  progress.total = fit_work(source, fit);
  fit.progress = &progress;
  const ProgressBar bar(progress, progress.total, !options.common.quiet);
  try {
    return fit_body(source, target, fit);
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
}

std::string note_of(const FitOptions& options, const BodyFitReport& report) {
  std::string note = options.surface ? "a fit of surfaces" : "a fit";
  if (report.landmarks > 0) note += fmt::format(" by {} of landmarks", counted(report.landmarks, "pair"));
  if (report.map_pairs > 0)
    note += fmt::format("{} a map of {}", report.landmarks > 0 ? " and" : " by", counted(report.map_pairs, "pair"));
  return note;
}

std::vector<FitPair> fit_pairs_of(const LandmarkPairs& pairs) {
  std::vector<FitPair> result;
  for (std::size_t i = 0; i < pairs.source.size(); ++i) {
    result.push_back({pairs.source[i], pairs.target[i], pairs.tolerance[i]});
  }
  return result;
}

LandmarkPairs pairs_of(const FitOptions& options, const Mesh& source, const Mesh& target) {
  if (!options.landmarks) return {};
  LandmarkPairs pairs = options.target_landmarks ? read_points(*options.landmarks, *options.target_landmarks)
                                                 : read_pairs(*options.landmarks, source, target);
  check_frames(pairs, *options.landmarks, reference_length(source));
  return pairs;
}

void check_options(const FitOptions& options) {
  if (options.target_landmarks && !options.landmarks) {
    throw UsageError("--target-landmarks needs --landmarks, the points of the source in the same order");
  }
  if (options.partial && !options.surface) throw UsageError("--partial needs --surface, which it matches in part");
  if (!options.landmarks && !options.map && !options.surface) {
    throw UsageError("give --landmarks, --map, --surface, or several of them");
  }
  constexpr std::string_view extensions[] = {"knead"};
  require_extension(options.output, extensions);
  require_writable(options.output);
  if (!options.scales()) return;
  require_different(options.source, scaled_path(options));
  require_different(options.target, scaled_path(options));
  require_writable(scaled_path(options));
}

// Adds the file of the pairs to messages about them.
BodyFit fitted(const FitOptions& options, const Mesh& source, const Mesh& target, const BodyFitOptions& fit) {
  try {
    return watched(options, source, target, fit);
  } catch (const InvalidInput& error) {
    if (!options.landmarks || std::string_view(error.what()).find("landmark") == std::string_view::npos) throw;
    throw InvalidInput(Place{*options.landmarks}, error.what());
  }
}

void write_scaled(const FitOptions& options, const ShapeFile& source, double scale) {
  const Vec3d middle = shape_box(source.mesh).center();
  std::vector<Vec3d> positions = source.mesh.positions;
  for (Vec3d& p : positions) p = middle + (p - middle) * scale;
  write_shape(scaled_path(options), source, positions);
}

void run_fit(const FitOptions& options) {
  check_options(options);
  const ShapeFile source = read_shape(options.source);
  const ShapeFile target = read_shape(options.target);
  LandmarkPairs pairs = pairs_of(options, source.mesh, target.mesh);
  if (options.scales()) {
    require_volume(options.target, target.mesh);
    require_volume(options.source, source.mesh);
  }
  BodyFitOptions wanted;
  wanted.landmarks = fit_pairs_of(pairs);
  if (options.map) wanted.map = fit_pairs_of(read_pairs(*options.map, source.mesh, target.mesh));
  wanted.surface = options.surface;
  wanted.partial = options.partial;
  wanted.align = options.align;
  wanted.volume = options.scales() ? FitVolume::total : options.volume;
  wanted.max_stretch = options.max_stretch;
  wanted.threads = options.threads;
  BodyFit fit = fitted(options, source.mesh, target.mesh, wanted);
  const BodyFitReport& report = fit.report;
  pairs.notes.insert(pairs.notes.end(), report.notes.begin(), report.notes.end());
  for (const std::string& note : pairs.notes) {
    if (!options.common.quiet) print_message("note: " + note);
  }
  Session session;
  session.mesh = relative_to(options.scales() ? scaled_path(options) : options.source, options.output);
  session.note = note_of(options, report);
  for (Stroke& stroke : fit.strokes) session.strokes.push_back({std::move(stroke)});
  if (options.scales()) write_scaled(options, source, report.scale);
  end_after_last_output(options.common.json);
  write_file_atomically(options.output, serialize_session(session));
  if (options.common.json) {
    print(to_json(report));
  } else if (!options.common.quiet) {
    print(summary(options, report));
  }
  const std::string complaint = complaint_about(report, wanted);
  if (!complaint.empty()) throw QualityError(options.output + ": " + complaint);
}

}  // namespace

Subcommand fit_command() {
  const auto options = std::make_shared<FitOptions>();
  std::vector<Option> described{
      {"SOURCE", &options->source, "The shape to deform", "", OptionKind::required},
      {"TARGET", &options->target, "The shape that it shall become", "", OptionKind::required},
      {"--landmarks", &options->landmarks,
       "Pairs of points that belong together, a CSV file: "
       "source_x,source_y,source_z,target_x,target_y,target_z, or source_vertex,target_vertex from 0 on; a further "
       "column, tolerance, says how far from its place a point may end",
       "FILE"},
      {"--target-landmarks", &options->target_landmarks,
       "The landmarks of the target, where --landmarks holds those of the source alone: .fcsv or .mrk.json of 3D "
       "Slicer, "
       "or a table x,y,z,label",
       "FILE"},
      {"--map", &options->map, "A start: pairs as for --landmarks, any number of them, which need not all be right",
       "FILE"},
      {"--surface", &options->surface,
       "Bring the whole surface of the source to the target's, by strokes from coarse to fine"},
      {"--partial", &options->partial,
       "Match only what both surfaces have: what faces a hole or a cut of the other one is left alone"},
      {"-o,--output", &options->output, "The .knead file to write", "FILE", OptionKind::required},
      {"--scale", &options->scale,
       "Scale the source to the target's volume first; the scaled source is written beside OUT as OUT_source.EXT"},
      {"--volume", word_target(options->volume, {"keep", "total", "free"}),
       "What becomes of the volume: it stays, the source is scaled as with --scale, or the body grows and shrinks on "
       "purpose where the target asks for it",
       "keep|total|free", OptionKind::with_default},
      {"--align", word_target(options->align, {"auto", "always", "never"}),
       "Turn and move the source as a whole first, by the landmarks, the map or its principal axes: where that brings "
       "it "
       "much nearer (auto), always or never",
       "auto|always|never", OptionKind::with_default},
      {"--max-stretch", &options->max_stretch, "End with exit code 4 if a triangle is stretched by more", "FACTOR",
       OptionKind::with_default},
  };
  add_threads_option(described, options->threads);
  add_common_options(described, options->common);
  return {"fit", "Write a session that takes one shape to another, by landmarks or the whole surface", described,
          "  knead fit scan.ply pose.ply --landmarks pairs.csv --surface -o fit.knead\n"
          "  knead deform scan.ply fit.knead -o fitted.ply\n"
          "  knead fit scan.ply other.ply --map matches.csv --surface -o fit.knead\n"
          "  knead fit small.obj large.obj --landmarks pairs.csv --scale --json -o fit.knead",
          [options] { run_fit(*options); }};
}

}  // namespace knead::command
