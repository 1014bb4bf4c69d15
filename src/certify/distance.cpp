// The distance of two surfaces, and the JSON of fits.
#include <algorithm>

#include "json/json.h"
#include "knead/certify.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead {

namespace {

constexpr std::size_t kDistanceGrain = 64;

SurfaceTree triangle_tree_of(const Mesh& mesh) {
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
  parallel_for(from.vertex_count(), kDistanceGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && (progress == nullptr || !progress->cancel); ++i) {
      distances[first + i] = to.closest(from.positions[i])->distance;
    }
  });
  stop_if_cancelled(progress);
}

Json json_of(const FitDistance& distance) {
  return {{"mean", distance.mean}, {"percentile_95", distance.percentile_95}, {"max", distance.max}};
}

}  // namespace

std::vector<double> vertex_distances(const Mesh& from, const Mesh& to, int threads, Progress* progress) {
  validate(from);
  std::vector<double> distances;
  add_distances(from, triangle_tree_of(to), threads, progress, distances);
  if (progress != nullptr) progress->done += from.vertex_count();
  return distances;
}

SurfaceDistance distance_between(const Mesh& a, const Mesh& b, int threads, Progress* progress) {
  const SurfaceTree tree_a = triangle_tree_of(a);
  const SurfaceTree tree_b = triangle_tree_of(b);
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

std::string to_json(const BodyFitReport& report) {
  return to_indented_text({{"pairs", report.landmarks},
                           {"map_pairs", report.map_pairs},
                           {"tips", report.tips},
                           {"strokes", report.strokes},
                           {"unknowns", report.unknowns},
                           {"scale", report.scale},
                           {"aligned", report.is_aligned},
                           {"stage", report.stage},
                           {"reached", report.reached},
                           {"obstacle", report.obstacle},
                           {"landmark_distance", report.landmark_distance},
                           {"landmark_rms", report.landmark_rms},
                           {"landmark_excess", report.landmark_excess},
                           {"map_distance", report.map_distance},
                           {"distance_before", json_of(report.before)},
                           {"distance_landmarks", report.after_landmarks},
                           {"distance_after", json_of(report.after)},
                           {"distance_covered", report.after_covered},
                           {"matched", report.matched},
                           {"volume_error", report.volume_error},
                           {"det_least", report.det_least},
                           {"det_greatest", report.det_greatest},
                           {"volume_difference", report.volume_difference},
                           {"crossings_before", report.crossings_before},
                           {"crossings_after", report.crossings_after},
                           {"crossings_new", report.crossings_new},
                           {"greatest_stretch", report.greatest_stretch},
                           {"stretch_99", report.stretch_99},
                           {"rms_log_stretch", report.rms_log_stretch},
                           {"sound", report.is_sound},
                           {"notes", report.notes}});
}

}  // namespace knead
