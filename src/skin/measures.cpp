#include "skin/measures.h"

#include <algorithm>
#include <cmath>

#include "knead/io.h"
#include "math/elementary.h"

namespace knead::skin_detail {

RestShape::RestShape(const Mesh& mesh, int threads, const Progress* progress)
    : mesh_(mesh), triangles_(triangulate(mesh)), threads_(threads), progress_(progress) {
  const Measures m = knead::measure(mesh);
  has_volume_ = m.closed() && m.oriented() && m.volume != 0;
  volume_ = m.volume;
  crossings_ = crossings_at(mesh.positions);
}

SelfIntersections RestShape::crossings_at(std::span<const Vec3d> positions) const {
  SelfIntersectionOptions options;
  options.threads = threads_;
  options.progress = progress_;
  return self_intersections(triangles_, positions, options);
}

SkinMeasures RestShape::measure(std::span<const Vec3d> posed) const {
  constexpr double kNoArea = 1e-24;  // squared area over the longest edge's fourth power
  SkinMeasures result;
  if (has_volume_) result.volume_error = measure_volume_and_area(mesh_, posed).volume / volume_ - 1;
  const SelfIntersections now = crossings_at(posed);
  result.crossings = now.count;
  result.crossings_new = static_cast<std::size_t>(
      std::count_if(now.pairs.begin(), now.pairs.end(), [&](const std::array<std::uint32_t, 2>& pair) {
        return !std::binary_search(crossings_.pairs.begin(), crossings_.pairs.end(), pair);
      }));
  double sum = 0;
  std::size_t count = 0;
  for (const Triangle& t : triangles_) {
    const std::span<const Vec3d> rest = mesh_.positions;
    const Vec3d a = rest[t[1]] - rest[t[0]];
    const Vec3d b = rest[t[2]] - rest[t[0]];
    const double area2 = norm2(cross(a, b));
    const double edge = std::max({norm2(a), norm2(b), norm2(b - a)});
    if (!(area2 > kNoArea * edge * edge)) continue;
    const Vec3d c = posed[t[1]] - posed[t[0]];
    const Vec3d d = posed[t[2]] - posed[t[0]];
    // The singular values' squares are the eigenvalues of the matrix that takes one metric to the other.
    const double trace = (norm2(b) * norm2(c) - 2 * dot(a, b) * dot(c, d) + norm2(a) * norm2(d)) / area2;
    const double product = norm2(cross(c, d)) / area2;
    const double greater = 0.5 * (trace + std::sqrt(std::max(0.0, trace * trace - 4 * product)));
    const double less = greater > 0 ? product / greater : 0;
    result.greatest_stretch = std::max(result.greatest_stretch, std::sqrt(greater));
    result.least_stretch = std::min(result.least_stretch, std::sqrt(less));
    const double x = 0.5 * elementary::log(std::max(greater, 1e-30));
    const double y = 0.5 * elementary::log(std::max(less, 1e-30));
    sum += x * x + y * y;
    ++count;
  }
  if (count > 0) result.rms_log_stretch = std::sqrt(sum / (2 * static_cast<double>(count)));
  return result;
}

}  // namespace knead::skin_detail

namespace knead {

namespace {

Json json_of(const SkinMeasures& measures) {
  return {{"volume_error", measures.volume_error},         {"crossings", measures.crossings},
          {"crossings_new", measures.crossings_new},       {"least_stretch", measures.least_stretch},
          {"greatest_stretch", measures.greatest_stretch}, {"rms_log_stretch", measures.rms_log_stretch}};
}

}  // namespace

std::string to_json(const SkinReport& report) {
  return to_indented_text({{"linear", json_of(report.linear)},
                           {"dual", json_of(report.dual)},
                           {"flow", json_of(report.flow)},
                           {"bones", report.bones},
                           {"stages", report.stages},
                           {"segments", report.segments},
                           {"unknowns", report.unknowns},
                           {"part_distance", report.part_distance},
                           {"part_distance_95", report.part_distance_95},
                           {"seconds", report.seconds},
                           {"notes", report.notes}});
}

}  // namespace knead
