#include "knead/remesh/compensate.h"

#include <algorithm>
#include <cmath>

namespace knead::remesh_detail {

namespace {

constexpr double kMostOffset = 1.5;  // largest motion of a vertex, relative to the largest deviation around it
constexpr double kMostScale = 0.25;  // largest difference of the common factor from 1
constexpr int kRounds = 4;

// Returns a flag for each vertex: true if it may move.
std::vector<bool> find_open(const Surface& s, const std::vector<bool>& locked) {
  std::vector<bool> open(s.vertex_count());
  for (std::uint32_t v = 0; v < open.size(); ++v) {
    open[v] = s.has(v, kMoved) && !s.has(v, kFixed) && !(v < locked.size() && locked[v]);
  }
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    if (!s.edge_has(h, kFeature)) continue;
    open[s.origin(h)] = false;
    open[s.target(h)] = false;
  }
  return open;
}

// Returns the displacement of each vertex.
std::vector<Vec3d> offsets(const Surface& s, const std::vector<Vec3d>& deviations, const std::vector<bool>& open) {
  std::vector<Vec3d> star(s.vertex_count());
  std::vector<double> share(s.vertex_count(), 0.0);  // six times the volume
  std::vector<double> most(s.vertex_count(), 0.0);
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    const Vec3d n = area_vector(s, f, s.after);
    for (const std::uint32_t v : s.triangle(f)) star[v] += n;
    for (std::uint32_t h = static_cast<std::uint32_t>(3 * f); h < 3 * f + 3; ++h) {
      const Vec3d& d = deviations[s.edge[h]];
      const std::uint32_t a = s.origin(h);
      const std::uint32_t b = s.target(h);
      const double both = (open[a] ? 1 : 0) + (open[b] ? 1 : 0);
      for (const std::uint32_t v : {a, b}) {
        if (!open[v]) continue;
        share[v] += dot(n, d) / both;
        most[v] = std::max(most[v], norm(d));
      }
    }
  }
  std::vector<Vec3d> result(s.vertex_count());
  for (std::uint32_t v = 0; v < s.vertex_count(); ++v) {
    const double size = norm(star[v]);
    if (!open[v] || !(size > 0)) continue;
    const double limit = kMostOffset * most[v];
    result[v] = star[v] * (std::clamp(share[v] / size, -limit, limit) / size);
  }
  return result;
}

}  // namespace

double estimate_missing_volume(const Surface& s, const std::vector<Vec3d>& deviations) {
  double sum = 0;
  for (std::uint32_t h = 0; h < s.corner.size(); ++h) {
    sum += dot(area_vector(s, h / 3, s.after), deviations[s.edge[h]]);
  }
  return sum / 6;
}

double enclosed_volume(const Surface& s, const std::vector<Vec3d>& positions) {
  Vec3d center{};
  for (const Vec3d& p : s.before) center += p;
  if (!s.before.empty()) center = center / static_cast<double>(s.before.size());
  double sum = 0;
  for (std::size_t f = 0; f < s.face_count(); ++f) {
    if (!s.is_alive(f)) continue;
    const auto [a, b, c] = s.triangle(f);
    sum += dot(positions[a] - center, cross(positions[b] - center, positions[c] - center));
  }
  return sum / 6;
}

double compensate(Surface& s, const std::vector<Vec3d>& deviations, const std::vector<bool>& locked, double missing) {
  const std::vector<Vec3d> d = offsets(s, deviations, find_open(s, locked));
  const std::vector<Vec3d> from = s.after;
  const double was = enclosed_volume(s, from);
  double scale = 1;
  double grown = 0;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t v = 0; v < from.size(); ++v) s.after[v] = from[v] + d[v] * scale;
    grown = enclosed_volume(s, s.after) - was;
    const double next = grown != 0 ? std::clamp(scale * missing / grown, 1 - kMostScale, 1 + kMostScale) : 1;
    if (std::abs(next - scale) < 1e-9) break;
    if (round + 1 < kRounds) scale = next;
  }
  return grown;
}

}  // namespace knead::remesh_detail
