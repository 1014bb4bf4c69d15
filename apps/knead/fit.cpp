// knead fit SOURCE TARGET --landmarks pairs.csv -o OUT.knead: writes a session that takes one shape to another.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "command.h"
#include "inputs.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "math/elementary.h"
#include "output.h"

namespace knead::command {
namespace {

// Landmarks must be met to this multiple of the tolerance of path lines.
constexpr double kMetTo = 2;
// With --surface, the greatest mean distance of the surfaces that is no failure, in diagonals.
constexpr double kMeanDistance = 3e-3;
// Volumes that differ by more than this fraction hinder a fit.
constexpr double kVolumeDifference = 1e-3;

struct FitOptions {
  std::string source;
  std::string target;
  std::optional<std::string> landmarks;
  std::optional<std::string> target_landmarks;
  bool surface = false;
  std::string output;
  bool scale = false;
  double max_stretch = 5;
  std::optional<int> threads;
  CommonOptions common;
};

double volume_of(const std::string& path, const Mesh& mesh) {
  const Measures m = measure(mesh);
  if (m.closed() && m.oriented() && m.volume > 0) return m.volume;
  throw InvalidInput(Place{path}, "--scale needs the volume of both shapes, and this one is not closed; leave it out");
}

// Scales the shape and the landmarks about the middle of the shape's box, and returns by how much.
double scale_to(const FitOptions& options, const Mesh& target, Mesh& source, std::vector<Vec3d>& landmarks) {
  const double scale = elementary::cbrt(volume_of(options.target, target) / volume_of(options.source, source));
  const Vec3d middle = shape_box(source).center();
  for (Vec3d& p : source.positions) p = middle + (p - middle) * scale;
  for (Vec3d& p : landmarks) p = middle + (p - middle) * scale;
  return scale;
}

// Where the scaled source is written: OUT_source.EXT beside OUT.
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

std::string line_of(const SurfaceDistance& d) {
  return fmt::format("mean {:.3g}%, 95% within {:.3g}%, at most {:.3g}%", 100 * d.mean, 100 * d.percentile_95,
                     100 * d.max);
}

std::string summary(const FitOptions& options, const FitReport& report) {
  std::string text = fmt::format("{}: {}, {} at most, radius {:.4g}\n", options.output,
                                 counted(report.strokes, "stroke"), counted(report.pins, "pin"), report.radius);
  if (report.remeshed_strokes > 0)
    text += fmt::format("remesh   after {}\n", counted(report.remeshed_strokes, "stroke"));
  if (options.scale)
    text += fmt::format("scale    {:.6g}: {} is the scaled source\n", report.scale, scaled_path(options));
  text += fmt::format("before   {} of the source's diagonal from the target\n", line_of(report.before));
  text += fmt::format("after    {}; landmarks within {:.2g}%\n", line_of(report.after), 100 * report.landmark_distance);
  if (report.volume_error) text += fmt::format("volume   changed by a fraction of {:.2g}\n", *report.volume_error);
  if (report.volume_difference) {
    text += fmt::format("         the target's volume differs by {:.2g}%\n", 100 * *report.volume_difference);
  }
  text += fmt::format("crossing {} of triangles before, {} after\n", counted(report.crossings_before, "pair"),
                      report.crossings_after);
  if (report.greatest_stretch) text += fmt::format("stretch  {:.3g} at most\n", *report.greatest_stretch);
  return text;
}

ShapeFit watched(const FitOptions& options, const Mesh& source, const Mesh& target, ShapeFitOptions fit) {
  Progress progress;
  const CancelOnInterruption cancel(progress);
  progress.total = fit_work(source, fit);
  fit.progress = &progress;
  fit.threads = threads_of(options.threads);
  const ProgressBar bar(progress, progress.total, !options.common.quiet);
  try {
    return fit_shape(source, target, fit);
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
}

void require_fit(const FitOptions& options, const FitReport& report) {
  if (report.greatest_stretch.value_or(0) > options.max_stretch) {
    throw QualityError(
        fmt::format("{}: a triangle is stretched by {:.3g}, more than --max-stretch ({:g}) allows; look at the result "
                    "there, correct pairs of landmarks, or give more",
                    options.output, *report.greatest_stretch, options.max_stretch));
  }
  if (report.landmark_distance > kMetTo * kDefaultRelativeTolerance) {
    throw QualityError(
        fmt::format("{}: a landmark is {:.2g} of the diagonal from its place; give fewer pairs, or pairs "
                    "that are farther apart",
                    options.output, report.landmark_distance));
  }
  if (report.crossings_after > report.crossings_before) {
    throw QualityError(fmt::format("{}: {} of triangles cross after the fit; {}give more pairs", options.output,
                                   counted(report.crossings_after, "pair"),
                                   options.surface ? "" : "apply it with knead deform --remesh, or "));
  }
  if (options.surface && report.after.mean > kMeanDistance) {
    const bool differs = std::abs(report.volume_difference.value_or(0)) > kVolumeDifference;
    throw QualityError(
        fmt::format("{}: the surfaces are still {:.2g}% of the diagonal apart; give more pairs of "
                    "landmarks{}",
                    options.output, 100 * report.after.mean, differs ? ", or --scale, for the volumes differ" : ""));
  }
}

std::string note_of(const FitOptions& options, const FitReport& report) {
  const std::string pairs = fmt::format("{} of landmarks", counted(report.pairs, "pair"));
  if (!options.surface) return "a fit by " + pairs;
  std::string note = report.pairs > 0 ? fmt::format("a fit of surfaces and {}", pairs) : "a fit of surfaces";
  if (report.remeshed_strokes > 0) note += fmt::format("; {} remeshed", counted(report.remeshed_strokes, "stroke"));
  return note;
}

PinsStroke pins_of(const FitOptions& options, LandmarkPairs pairs, const Mesh& source) {
  try {
    return landmark_pins(std::move(pairs.source), std::move(pairs.target), reference_length(source));
  } catch (const InvalidInput& error) {
    throw InvalidInput(Place{*options.landmarks},
                       fmt::format("the pairs, counted from 0, cannot be pins: {}", error.what()));
  }
}

LandmarkPairs pairs_of(const FitOptions& options, const Mesh& source, const Mesh& target) {
  if (!options.landmarks) return {};
  LandmarkPairs pairs = options.target_landmarks ? read_points(*options.landmarks, *options.target_landmarks)
                                                 : read_pairs(*options.landmarks, source, target);
  check_frames(pairs, *options.landmarks, reference_length(source));
  return pairs;
}

// A target that is inside out has the normals of no source.
void turn_outward(const FitOptions& options, Mesh& target, std::vector<std::string>& notes) {
  const Measures m = measure(target);
  if (!m.closed() || !m.oriented() || m.volume >= 0) return;
  for (std::size_t f = 0; f < target.face_count(); ++f) {
    const auto begin = target.corner_vertex.begin() + target.face_begin[f];
    std::reverse(begin, target.corner_vertex.begin() + target.face_begin[f + 1]);
  }
  target.attributes.clear();  // those of corners are in another order now
  notes.push_back(options.target + ": the faces look inward and are turned");
}

// Without landmarks, surfaces find each other only where they lie near each other.
void check_apart(const FitOptions& options, const Mesh& source, const Mesh& target) {
  if (options.landmarks) return;
  const Box a = shape_box(source);
  const Box b = shape_box(target);
  const double gap = a.empty() || b.empty() ? 0 : norm(b.center() - a.center());
  if (gap <= a.diagonal() + b.diagonal()) return;
  const Vec3d shift = b.center() - a.center();
  throw InvalidInput(Place{options.target},
                     fmt::format("lies {:.3g} away from the source; move the source by ({:.6g}, {:.6g}, {:.6g}) first, "
                                 "or give landmarks",
                                 gap, shift.x, shift.y, shift.z));
}

void run_fit(const FitOptions& options) {
  if (options.target_landmarks && !options.landmarks) {
    throw UsageError("--target-landmarks needs --landmarks, the points of the source in the same order");
  }
  if (!options.landmarks && !options.surface) {
    throw UsageError("give --landmarks, --surface, or both");
  }
  constexpr std::string_view extensions[] = {"knead"};
  require_extension(options.output, extensions);
  require_writable(options.output);
  if (options.scale) {
    require_different(options.source, scaled_path(options));
    require_different(options.target, scaled_path(options));
    require_writable(scaled_path(options));
  }
  const ShapeFile source = read_shape(options.source);
  ShapeFile target = read_shape(options.target);
  LandmarkPairs pairs = pairs_of(options, source.mesh, target.mesh);
  turn_outward(options, target.mesh, pairs.notes);
  for (const std::string& note : pairs.notes) {
    if (!options.common.quiet) print_message("note: " + note);
  }
  check_apart(options, source.mesh, target.mesh);
  Mesh mesh = source.mesh;
  const double scale = options.scale ? scale_to(options, target.mesh, mesh, pairs.source) : 1;
  ShapeFitOptions wanted{.surface = options.surface};
  if (options.landmarks) wanted.landmarks = pins_of(options, std::move(pairs), mesh);
  ShapeFit fit = watched(options, mesh, target.mesh, wanted);
  FitReport& report = fit.report;
  report.scale = scale;
  Session session;
  session.mesh = relative_to(options.scale ? scaled_path(options) : options.source, options.output);
  session.note = note_of(options, report);
  session.strokes = std::move(fit.strokes);
  if (options.scale) write_shape(scaled_path(options), source, mesh.positions);
  end_after_last_output(options.common.json);
  write_file_atomically(options.output, serialize_session(session));
  if (options.common.json) {
    print(to_json(report));
  } else if (!options.common.quiet) {
    print(summary(options, report));
  }
  require_fit(options, report);
}

}  // namespace

Subcommand fit_command() {
  const auto options = std::make_shared<FitOptions>();
  std::vector<Option> described{
      {"SOURCE", &options->source, "The shape to deform", "", OptionKind::required},
      {"TARGET", &options->target, "The shape that it shall become", "", OptionKind::required},
      {"--landmarks", &options->landmarks,
       "Pairs of points that belong together, a CSV file: "
       "source_x,source_y,source_z,target_x,target_y,target_z, or source_vertex,target_vertex from 0 on",
       "FILE"},
      {"--target-landmarks", &options->target_landmarks,
       "The landmarks of the target, where --landmarks holds those of the source alone: .fcsv or .mrk.json of 3D "
       "Slicer, "
       "or a table x,y,z,label",
       "FILE"},
      {"--surface", &options->surface,
       "Bring the whole surface of the source to the target's, by strokes from coarse to fine"},
      {"-o,--output", &options->output, "The .knead file to write", "FILE", OptionKind::required},
      {"--scale", &options->scale,
       "Scale the source to the target's volume first; the scaled source is written beside OUT as OUT_source.EXT"},
      {"--max-stretch", &options->max_stretch, "End with exit code 4 if a triangle is stretched by more", "FACTOR",
       OptionKind::with_default},
      {"--threads", &options->threads, "Number of threads (default: all); does not change the result", "N"},
  };
  add_common_options(described, options->common);
  return {"fit", "Write a session that takes one shape to another, by landmarks or the whole surface", described,
          "  knead fit scan.ply pose.ply --landmarks pairs.csv --surface -o fit.knead\n"
          "  knead deform scan.ply fit.knead -o fitted.ply\n"
          "  knead fit small.obj large.obj --landmarks pairs.csv --scale --json -o fit.knead",
          [options] { run_fit(*options); }};
}

}  // namespace knead::command
