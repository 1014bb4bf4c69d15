#include "knead/render/occluder.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "knead/math/box.h"

namespace knead::render {
namespace {

void append(const DrawSurface& surface, Occluder& occluder) {
  if (surface.indices.empty()) {
    for (const DrawVertex& vertex : surface.vertices) occluder.points.push_back(vertex.position);
    return;
  }
  const auto first = static_cast<std::uint32_t>(occluder.positions.size());
  for (const DrawVertex& vertex : surface.vertices) occluder.positions.push_back(vertex.position);
  for (const std::uint32_t index : surface.indices) occluder.indices.push_back(first + index);
}

void measure(Occluder& occluder, const Vec3d& up) {
  Box box;
  double ground = Box::kInfinity;
  const auto visit = [&](const Vec3f& p) {
    box.extend(Vec3d(p));
    ground = std::min(ground, dot(up, Vec3d(p)));
  };
  std::for_each(occluder.positions.begin(), occluder.positions.end(), visit);
  std::for_each(occluder.points.begin(), occluder.points.end(), visit);
  if (box.empty()) return;
  occluder.ground = ground;
  occluder.center = box.center();
  double radius = 0;
  const auto reach = [&](const Vec3f& p) { radius = std::max(radius, norm(Vec3d(p) - occluder.center)); };
  std::for_each(occluder.positions.begin(), occluder.positions.end(), reach);
  std::for_each(occluder.points.begin(), occluder.points.end(), reach);
  occluder.radius = std::max(radius * 1.01, 1e-6);
}

void merge_cells(Occluder& occluder, double cell) {
  std::unordered_map<std::uint64_t, std::uint32_t> cells;
  std::vector<Vec3d> sums;
  std::vector<double> counts;
  std::vector<std::uint32_t> merged;
  merged.reserve(occluder.positions.size());
  const auto index = [&](float x) { return static_cast<std::uint64_t>(std::floor(x / cell) + 1048576) & 0x1fffff; };
  for (const Vec3f& p : occluder.positions) {
    const std::uint64_t key = index(p.x) | index(p.y) << 21 | index(p.z) << 42;
    const auto [at, is_new] = cells.try_emplace(key, static_cast<std::uint32_t>(sums.size()));
    if (is_new) {
      sums.emplace_back();
      counts.push_back(0);
    }
    sums[at->second] += Vec3d(p);
    counts[at->second] += 1;
    merged.push_back(at->second);
  }
  occluder.positions.clear();
  for (std::size_t i = 0; i < sums.size(); ++i) occluder.positions.emplace_back(sums[i] / counts[i]);
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    const std::uint32_t a = merged[occluder.indices[i]];
    const std::uint32_t b = merged[occluder.indices[i + 1]];
    const std::uint32_t c = merged[occluder.indices[i + 2]];
    if (a != b && b != c && c != a) kept.insert(kept.end(), {a, b, c});
  }
  occluder.indices = std::move(kept);
}

}  // namespace

Occluder make_occluder(const std::vector<DrawSurface>& surfaces, const Vec3d& up, double cell,
                       std::size_t max_triangles) {
  Occluder occluder;
  for (const DrawSurface& surface : surfaces) append(surface, occluder);
  measure(occluder, up);
  if (occluder.indices.size() > 3 * max_triangles) merge_cells(occluder, cell * occluder.radius);
  return occluder;
}

}  // namespace knead::render
