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

namespace {

double beyond(const std::array<float, 4>& plane, const Vec3f& p) {
  return double{plane[0]} * p.x + double{plane[1]} * p.y + double{plane[2]} * p.z - double{plane[3]};
}

// The corners of what the plane leaves of a triangle, at most four.
std::vector<Vec3f> clipped(const std::array<Vec3f, 3>& triangle, const std::array<float, 4>& plane) {
  std::vector<Vec3f> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f& a = triangle[i];
    const Vec3f& b = triangle[(i + 1) % 3];
    const double at_a = beyond(plane, a);
    const double at_b = beyond(plane, b);
    if (at_a <= 0) kept.push_back(a);
    if ((at_a <= 0) != (at_b <= 0)) kept.push_back(Vec3f(Vec3d(a) + (Vec3d(b) - Vec3d(a)) * (at_a / (at_a - at_b))));
  }
  return kept;
}

}  // namespace

void clip_occluder(Occluder& occluder, const std::array<float, 4>& plane) {
  std::erase_if(occluder.points, [&](const Vec3f& p) { return beyond(plane, p) > 0; });
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    std::array<Vec3f, 3> triangle;
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = occluder.positions[occluder.indices[i + k]];
    const auto is_beyond = [&](const Vec3f& p) { return beyond(plane, p) > 0; };
    const auto count = std::count_if(triangle.begin(), triangle.end(), is_beyond);
    if (count == 0) {
      for (std::size_t k = 0; k < 3; ++k) indices.push_back(occluder.indices[i + k]);
    } else if (count < 3) {
      const auto first = static_cast<std::uint32_t>(occluder.positions.size());
      const std::vector<Vec3f> kept = clipped(triangle, plane);
      occluder.positions.insert(occluder.positions.end(), kept.begin(), kept.end());
      for (std::uint32_t k = 2; k < kept.size(); ++k) indices.insert(indices.end(), {first, first + k - 1, first + k});
    }
  }
  occluder.indices = std::move(indices);
}

}  // namespace knead::render
