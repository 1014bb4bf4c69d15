#include "knead/session/replay_shared.h"

#include <fmt/format.h>

#include <cmath>

#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/session/surface_stroke.h"

namespace knead::session_detail {

namespace {

// Below it, relative to the diagonal, the rounding of float evaluation is what remains of the error.
constexpr double kFloatNoise = 1e-6;

// Of the diagonal: the error of the path lines of a normal's companions.
constexpr double kCompanionTolerance = 1e-9;

std::string describe_refusal(const Barrel& barrel, const BarrelCheck& check) {
  std::string text = fmt::format("{} cross the cylinder of \"radius\" {} and would be torn; ",
                                 check.crossing == 1 ? "1 triangle would" : fmt::format("{} triangles", check.crossing),
                                 barrel.radius);
  const std::optional<double> nearest = nearest_radius(check, barrel.radius);
  if (!nearest) return text + "no other radius works: leave \"radius\" out";
  text += fmt::format("use \"radius\": {}, the nearest that works", *nearest);
  if (!check.smaller) return text + " (no smaller one does)";
  if (!check.larger) return text + " (no larger one does)";
  return text + fmt::format(" (on the other side {})", nearest == check.smaller ? *check.larger : *check.smaller);
}

// Appends a part of a stroke; dabs of one brush become one stroke.
void append(const Stroke& part, const SessionStroke& source, std::vector<SessionStroke>& parts) {
  const auto* dab = std::get_if<PaintStroke>(&part);
  auto* last = parts.empty() ? nullptr : std::get_if<PaintStroke>(&parts.back().stroke);
  const bool joins = dab != nullptr && last != nullptr && last->outer == dab->outer && last->depth == dab->depth;
  if (joins) {
    last->samples.insert(last->samples.end(), dab->samples.begin(), dab->samples.end());
  } else {
    parts.push_back({part, source.line, source.remesh});
  }
}

}  // namespace

double checked_diagonal(const Mesh& mesh, const ReplayOptions& options) {
  double diagonal = bounding_box(mesh.positions).diagonal();
  if (!(diagonal > 0)) diagonal = 1;
  const double tolerance = options.tolerance * diagonal;
  if (!(tolerance > 0) || !std::isfinite(tolerance)) {
    throw InvalidInput("the tolerance and the shape's size leave no positive length");
  }
  return diagonal;
}

MoveOptions move_options(const ReplayOptions& options, double diagonal) {
  MoveOptions result;
  result.vertices.tolerance = options.tolerance * diagonal;
  result.vertices.integrator = options.integrator;
  result.vertices.precision = options.precision;
  result.vertices.threads = options.threads;
  result.vertices.progress = options.progress;
  result.backend = options.backend;
  result.companions.tolerance = kCompanionTolerance * diagonal;
  result.companions.precision = Precision::float64;
  result.companions.threads = options.threads;
  result.companions.progress = options.progress;
  return result;
}

bool is_usual(const ReplayOptions& options) {
  const ReplayOptions defaults;
  return options.tolerance == defaults.tolerance && options.integrator == defaults.integrator &&
         options.precision == defaults.precision && options.single_precision == defaults.single_precision &&
         !options.backend;
}

ReplayOptions usual(const ReplayOptions& options) {
  const ReplayOptions defaults;
  ReplayOptions result = options;
  result.tolerance = defaults.tolerance;
  result.integrator = defaults.integrator;
  result.precision = defaults.precision;
  result.backend = nullptr;
  result.single_precision = defaults.single_precision;
  result.frames = 0;
  result.on_stroke = nullptr;
  return result;
}

std::vector<std::string> plan_warnings(const Session& session, const ReplayOptions& options, const Plan& plan) {
  std::vector<std::string> result;
  if (options.precision == Precision::float32 && options.tolerance < kFloatNoise) {
    result.push_back(fmt::format("a tolerance of {} is below what single precision resolves ({}); use double precision",
                                 options.tolerance, kFloatNoise));
  }
  for (const PlannedStroke& stroke : plan.strokes) {
    for (const std::string& warning : warnings(stroke.source->stroke)) {
      result.push_back(to_string(place_of(session, *stroke.source)) + ": " + warning);
    }
  }
  return result;
}

SurfaceReading read_surface(const Session& session, const PlannedStroke& stroke, std::span<const Triangle> triangles,
                            const std::function<std::vector<Vec3d>()>& normals, const MoveOptions& options,
                            MovedShape& shape) {
  SurfaceReading reading;
  LiveSurface surface;
  surface.positions = shape.positions;
  surface.triangles = triangles;
  surface.normals = normals;
  surface.apply = [&](const Stroke& part) {
    Flow flow = flow_of(part);
    reading.barrel = barrel_of(part);
    append(part, *stroke.source, reading.parts);
    if (!reading.barrel) move(flow, options, shape);  // else after its check
    std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(reading.flow.segments));
    return shape.counts.status == AdvectStatus::done;
  };
  try {
    reading.penetration =
        apply_on(stroke.source->stroke, stroke.tool.get(), options.vertices.threads, surface, reading.remarks);
  } catch (const InvalidInput& error) {
    throw InvalidInput(place_of(session, *stroke.source), error.what());
  }
  return reading;
}

std::optional<std::string> barrel_warning(const Session& session, const PlannedStroke& stroke,
                                          std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  if (!stroke.barrel) return std::nullopt;
  const BarrelCheck found = check_barrel(*stroke.barrel, positions, triangles);
  if (found.crossing > 0) {
    throw InvalidInput(place_of(session, *stroke.source), describe_refusal(*stroke.barrel, found));
  }
  if (found.later == 0) return std::nullopt;
  return fmt::format(
      "{} triangles cross the cylinder of \"radius\" {} where the bend arrives later, and may "
      "be torn; look there, or choose another radius",
      found.later, stroke.barrel->radius);
}

}  // namespace knead::session_detail
