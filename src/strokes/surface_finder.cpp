// The closest point and normal of triangles or a cloud that moves.
#include "strokes/surface_finder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/elementary.h"

namespace knead::detail {

namespace {

constexpr std::size_t kNeighbours = 8;

struct Neighbour {
  double square = 0;  // of the distance
  std::uint32_t point = 0;

  bool operator<(const Neighbour& other) const {
    return std::pair(square, point) < std::pair(other.square, other.point);
  }
};

// For the tree: each point by itself.
std::vector<Triangle> as_triangles(std::size_t points) {
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < points; ++i) triangles.push_back({i, i, i});
  return triangles;
}

// The nearest points to p, nearest first; equally near ones by number.
std::vector<Neighbour> nearest_points(const SurfaceTree& tree, std::span<const Vec3d> points, const Vec3d& p) {
  std::vector<Neighbour> nearest;
  for (const SurfacePoint& found : tree.nearest(p, kNeighbours)) {
    nearest.push_back({norm2(points[found.triangle] - p), found.triangle});
  }
  std::sort(nearest.begin(), nearest.end());
  return nearest;
}

std::optional<Vec3d> unit_or_nothing(const Vec3d& v) {
  const double length = norm(v);
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  return v / length;
}

}  // namespace

SurfaceFinder::SurfaceFinder(const LiveSurface& surface)
    : surface_(surface),
      tree_(surface.triangles.empty() ? SurfaceTree(as_triangles(surface.positions.size()), surface.positions)
                                      : SurfaceTree(surface.triangles, surface.positions)) {
  if (surface.triangles.empty()) return;
  first_.assign(surface.positions.size() + 1, 0);
  for (const Triangle& triangle : surface.triangles) {
    for (const std::uint32_t v : triangle) ++first_[v + 1];
  }
  for (std::size_t v = 0; v < surface.positions.size(); ++v) first_[v + 1] += first_[v];
  around_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const std::uint32_t v : surface.triangles[t]) around_[next[v]++] = static_cast<std::uint32_t>(t);
  }
}

std::optional<PaintSample> SurfaceFinder::closest(const Vec3d& p) const {
  return surface_.triangles.empty() ? closest_in_cloud(p) : closest_on_triangles(p);
}

void SurfaceFinder::follow(const Vec3d& p, double radius) {
  const Vec3d corner{radius, radius, radius};
  tree_.refit(surface_.positions, {p - corner, p + corner});
}

std::optional<PaintSample> SurfaceFinder::closest_on_triangles(const Vec3d& p) const {
  const auto found = tree_.closest(p);
  if (!found) return std::nullopt;
  const Triangle& triangle = surface_.triangles[found->triangle];
  Vec3d sum{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) sum += vertex_normal(triangle[i]) * found->barycentric[i];
  std::optional<Vec3d> normal = unit_or_nothing(sum);
  if (!normal) {  // the two sides of a sheet share their vertices: the triangle's own side counts
    const Vec3d& a = surface_.positions[triangle[0]];
    normal = unit_or_nothing(cross(surface_.positions[triangle[1]] - a, surface_.positions[triangle[2]] - a));
  }
  if (!normal) return std::nullopt;
  return PaintSample{found->point, *normal};
}

std::optional<PaintSample> SurfaceFinder::closest_in_cloud(const Vec3d& p) const {
  if (!surface_.normal || surface_.positions.empty()) return std::nullopt;
  const Vec3d q = surface_.positions[nearest_points(tree_, surface_.positions, p).front().point];
  const std::vector<Neighbour> near = nearest_points(tree_, surface_.positions, q);
  const double reach2 = near.back().square > 0 ? near.back().square : 1;
  Vec3d normal_sum{0, 0, 0};
  Vec3d offset_sum{0, 0, 0};
  double weight_sum = 0;
  for (const Neighbour& neighbour : near) {
    const double weight = std::max(1 - neighbour.square / reach2, 0.0);
    const std::optional<Vec3d> own = unit_or_nothing(surface_.normal(neighbour.point));
    if (!own) continue;
    normal_sum += *own * (weight * weight);
    offset_sum += (surface_.positions[neighbour.point] - q) * (weight * weight);
    weight_sum += weight * weight;
  }
  const std::optional<Vec3d> normal = unit_or_nothing(normal_sum);
  if (!normal) return std::nullopt;
  const Vec3d mean = q + offset_sum / weight_sum;
  const Vec3d foot = p - *normal * dot(*normal, p - mean);
  return PaintSample{norm2(foot - q) <= reach2 ? foot : q, *normal};
}

Vec3d SurfaceFinder::vertex_normal(std::uint32_t vertex) const {
  Vec3d sum{0, 0, 0};
  const Vec3d& p = surface_.positions[vertex];
  for (std::uint32_t k = first_[vertex]; k < first_[vertex + 1]; ++k) {
    const Triangle& triangle = surface_.triangles[around_[k]];
    const auto corner =
        static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), vertex) - triangle.begin());
    const Vec3d a = surface_.positions[triangle[(corner + 1) % 3]] - p;
    const Vec3d b = surface_.positions[triangle[(corner + 2) % 3]] - p;
    const std::optional<Vec3d> normal = unit_or_nothing(cross(a, b));
    if (normal) sum += *normal * elementary::atan2(norm(cross(a, b)), dot(a, b));
  }
  return unit_or_nothing(sum).value_or(Vec3d{0, 0, 0});
}

}  // namespace knead::detail
