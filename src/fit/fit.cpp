#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/fit_parts.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/tools.h"

namespace knead {

namespace {

constexpr std::size_t kGrain = 64;
// Fewer pins are all within each other's reach and can still be solved (strokes/pins.cpp).
constexpr std::size_t kMaxTogether = 600;

SurfaceTree tree_of(const Mesh& mesh) {
  validate(mesh);
  if (mesh.vertex_count() == 0) throw InvalidInput("a shape without vertices has no distance; give another one");
  std::vector<Triangle> triangles = triangulate(mesh);
  if (triangles.empty()) {
    for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) triangles.push_back({i, i, i});
  }
  return {triangles, mesh.positions};
}

void add_distances(const Mesh& from, const SurfaceTree& to, int threads, Progress* progress,
                   std::vector<double>& distances) {
  const std::size_t first = distances.size();
  distances.resize(first + from.vertex_count());
  parallel_for(from.vertex_count(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && (progress == nullptr || !progress->cancel); ++i) {
      distances[first + i] = to.closest(from.positions[i])->distance;
    }
  });
  stop_if_cancelled(progress);
}

Json json_of(const SurfaceDistance& distance) {
  return {{"mean", distance.mean}, {"most_95", distance.percentile_95}, {"max", distance.max}};
}

std::optional<double> volume_of(const Mesh& mesh) {
  const Measures m = measure(mesh);
  return m.closed() && m.oriented() ? std::optional(m.volume) : std::nullopt;
}

std::optional<double> relative(const std::optional<double>& now, const std::optional<double>& before) {
  return now && before && *before != 0 ? std::optional(*now / *before - 1) : std::nullopt;
}

SurfaceDistance scaled(SurfaceDistance distance, double by) {
  return {distance.mean * by, distance.percentile_95 * by, distance.max * by};
}

double greatest_of(const std::vector<float>& stretches) {
  return stretches.empty() ? 0 : *std::max_element(stretches.begin(), stretches.end());
}

}  // namespace

std::vector<double> vertex_distances(const Mesh& from, const Mesh& to, int threads, Progress* progress) {
  validate(from);
  std::vector<double> distances;
  add_distances(from, tree_of(to), threads, progress, distances);
  if (progress != nullptr) progress->done += from.vertex_count();
  return distances;
}

SurfaceDistance distance_between(const Mesh& a, const Mesh& b, int threads, Progress* progress) {
  const SurfaceTree tree_a = tree_of(a);
  const SurfaceTree tree_b = tree_of(b);
  std::vector<double> distances;
  add_distances(a, tree_b, threads, progress, distances);
  add_distances(b, tree_a, threads, progress, distances);
  SurfaceDistance result;
  for (const double distance : distances) result.mean += distance;
  result.mean /= static_cast<double>(distances.size());
  std::sort(distances.begin(), distances.end());
  result.percentile_95 = distances[(distances.size() * 95 + 99) / 100 - 1];
  result.max = distances.back();
  return result;
}

PinsStroke landmark_pins(std::vector<Vec3d> from, std::vector<Vec3d> to, double diagonal) {
  PinsStroke pins;
  pins.points = std::move(from);
  pins.to = std::move(to);
  pins.radius_auto = true;
  validate(pins);
  const Flow flow = flow_of(pins);
  const double automatic = flow.segments.front().fields.front().thresholds.outer;
  const double wide = pins.points.size() <= kMaxTogether ? 0.5 * diagonal : 0;
  pins.radius = std::max(automatic, wide);
  pins.radius_auto = false;
  validate(pins);
  return pins;
}

std::uint64_t fit_work(const Mesh& source, const ShapeFitOptions& options) {
  return source.vertex_count() * session_detail::most_strokes(options);
}

ShapeFit fit_shape(const Mesh& source, const Mesh& target, const ShapeFitOptions& options) {
  validate(source);
  const double unit = reference_length(source);
  ShapeFit fit;
  FitReport& report = fit.report;
  report.before = scaled(distance_between(source, target, options.threads, options.progress), 1 / unit);
  session_detail::ShapeFitter fitter(source, target, options);
  fitter.run();
  fit.strokes = fitter.take_strokes();
  report.strokes = fit.strokes.size();
  report.landmark_distance = fitter.landmark_distance() / unit;
  report.crossings_before = fitter.crossings_before();
  report.crossings_after = fitter.crossings();
  if (options.landmarks) report.pairs = options.landmarks->points.size();
  for (const SessionStroke& stroke : fit.strokes) {
    const auto& pins = std::get<PinsStroke>(stroke.stroke);
    report.radius = *pins.radius;
    report.pins = std::max(report.pins, pins.points.size());
    report.remeshed_strokes += stroke.remesh ? 1 : 0;
  }
  const DeformedShape& shape = fitter.shape();
  const Mesh fitted = shape.to_mesh();
  report.after = scaled(distance_between(fitted, target, options.threads, options.progress), 1 / unit);
  const std::optional<double> volume = volume_of(source);
  report.volume_error = relative(volume_of(fitted), volume);
  report.volume_difference = relative(volume_of(target), volume);
  if (!shape.triangles().empty()) {
    const Provenance* const provenance = shape.provenance();
    const std::vector<Vec3d>& rest = provenance != nullptr ? provenance->rest : source.positions;
    report.greatest_stretch = greatest_of(vertex_stretches(shape.triangles(), rest, shape.positions()));
  }
  return fit;
}

std::string to_json(const FitReport& report) {
  return to_indented_text({{"pairs", report.pairs},
                           {"strokes", report.strokes},
                           {"remeshed_strokes", report.remeshed_strokes},
                           {"pins", report.pins},
                           {"radius", report.radius},
                           {"scale", report.scale},
                           {"landmark_distance", report.landmark_distance},
                           {"distance_before", json_of(report.before)},
                           {"distance_after", json_of(report.after)},
                           {"volume_error", report.volume_error},
                           {"volume_difference", report.volume_difference},
                           {"crossings_before", report.crossings_before},
                           {"crossings_after", report.crossings_after},
                           {"greatest_stretch", report.greatest_stretch}});
}

}  // namespace knead
