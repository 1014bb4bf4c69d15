#include "knead/mesh/surface_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "knead/math/morton.h"
#include "knead/math/triangle_ray.h"
#include "knead/mesh/triangle_queries.h"

namespace knead {
namespace {

Box join(const Box& a, const Box& b) {
  return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y), std::min(a.min.z, b.min.z)},
          {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y), std::max(a.max.z, b.max.z)}};
}

bool overlap(const Box& a, const Box& b) {
  return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y && a.min.z <= b.max.z &&
         b.min.z <= a.max.z;
}

double squared_distance(const Box& box, const Vec3d& p) {
  const auto outside = [](double low, double high, double x) { return std::max({low - x, x - high, 0.0}); };
  const double x = outside(box.min.x, box.max.x, p.x);
  const double y = outside(box.min.y, box.max.y, p.y);
  const double z = outside(box.min.z, box.max.z, p.z);
  return x * x + y * y + z * z;
}

bool nearer(const SurfacePoint& a, const SurfacePoint& b) {
  return std::pair(a.distance, a.triangle) < std::pair(b.distance, b.triangle);
}

bool before(const RayHit& a, const RayHit& b) { return std::pair(a.t, a.triangle) < std::pair(b.t, b.triangle); }

}  // namespace

SurfaceTree::SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions)
    : triangles_(triangles.begin(), triangles.end()) {
  check_triangles(triangles, positions);
  const auto box_of = [&](const Triangle& t) {
    return bounding_box(std::array{positions[t[0]], positions[t[1]], positions[t[2]]});
  };
  Box all;
  for (const Triangle& t : triangles) all = join(all, box_of(t));
  const ToUnit to_unit(all);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    order.emplace_back(morton_code(to_unit(box_of(triangles[t]).center())), t);
  }
  std::sort(order.begin(), order.end());
  entries_.reserve(order.size());
  for (const auto& [code, t] : order) entries_.push_back({{}, t});
  const std::size_t leaves = (entries_.size() + kLeafSize - 1) / kLeafSize;
  first_leaf_ = std::bit_ceil(std::max<std::size_t>(1, leaves));
  refit(positions);
}

void SurfaceTree::fit_leaf(std::size_t leaf, std::span<const Vec3d> positions) {
  Box box;
  const std::size_t end = std::min((leaf + 1) * kLeafSize, entries_.size());
  for (std::size_t i = leaf * kLeafSize; i < end; ++i) {
    const Triangle& t = triangles_[entries_[i].triangle];
    entries_[i].corners = {positions[t[0]], positions[t[1]], positions[t[2]]};
    for (const Vec3d& corner : entries_[i].corners) box.extend(corner);
  }
  nodes_[first_leaf_ + leaf] = box;
}

void SurfaceTree::refit(std::span<const Vec3d> positions) {
  nodes_.resize(2 * first_leaf_);
  for (std::size_t leaf = 0; leaf < first_leaf_; ++leaf) fit_leaf(leaf, positions);
  for (std::size_t node = first_leaf_ - 1; node > 0; --node) {
    nodes_[node] = join(nodes_[2 * node], nodes_[2 * node + 1]);
  }
  slack_ = 1e-14 * nodes_[1].diagonal();
}

void SurfaceTree::refit(std::span<const Vec3d> positions, const Box& moved) {
  refit_below(1, positions, moved);
  slack_ = 1e-14 * nodes_[1].diagonal();
}

// A node's box holds its vertices as they were, until all below it is refitted.
void SurfaceTree::refit_below(std::size_t node, std::span<const Vec3d> positions, const Box& moved) {
  if (!overlap(nodes_[node], moved)) return;
  if (node >= first_leaf_) return fit_leaf(node - first_leaf_, positions);
  refit_below(2 * node, positions, moved);
  refit_below(2 * node + 1, positions, moved);
  nodes_[node] = join(nodes_[2 * node], nodes_[2 * node + 1]);
}

std::span<const SurfaceTree::Entry> SurfaceTree::entries_of(std::size_t leaf) const {
  const std::size_t begin = std::min(leaf * kLeafSize, entries_.size());
  return std::span(entries_).subspan(begin, std::min(kLeafSize, entries_.size() - begin));
}

double SurfaceTree::limit2_of(double distance) const {
  const double limit = distance * (1 + 1e-14) + slack_;
  return limit * limit;
}

template <class Visit>
void SurfaceTree::visit_near(const Vec3d& p, double limit2, Visit visit) const {
  struct Waiting {
    std::size_t node;
    double distance2;
  };
  std::array<Waiting, 64> stack{Waiting{1, squared_distance(nodes_[1], p)}};
  for (std::size_t height = 1; height > 0;) {
    const auto [node, distance2] = stack[--height];
    if (distance2 > limit2) continue;
    if (node >= first_leaf_) {
      for (const Entry& entry : entries_of(node - first_leaf_)) {
        if (squared_distance(bounding_box(entry.corners), p) <= limit2) limit2 = visit(entry);
      }
      continue;
    }
    Waiting near{2 * node, squared_distance(nodes_[2 * node], p)};
    Waiting far{2 * node + 1, squared_distance(nodes_[2 * node + 1], p)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[height++] = far;
    stack[height++] = near;
  }
}

std::optional<SurfacePoint> SurfaceTree::closest(const Vec3d& p, double max_distance) const {
  std::optional<SurfacePoint> best;
  double limit2 = limit2_of(max_distance);
  visit_near(p, limit2, [&](const Entry& entry) {
    const NearTriangle near = nearest_on_triangle(entry.corners, p);
    const SurfacePoint found{entry.triangle, near.barycentric, near.point, std::sqrt(near.distance2)};
    if (found.distance <= max_distance && (!best || nearer(found, *best))) {
      best = found;
      limit2 = limit2_of(found.distance);
    }
    return limit2;
  });
  return best;
}

std::vector<SurfacePoint> SurfaceTree::nearest(const Vec3d& p, std::size_t count, double max_distance) const {
  std::vector<SurfacePoint> best;
  if (count == 0) return best;
  double limit2 = limit2_of(max_distance);
  visit_near(p, limit2, [&](const Entry& entry) {
    const NearTriangle near = nearest_on_triangle(entry.corners, p);
    const SurfacePoint found{entry.triangle, near.barycentric, near.point, std::sqrt(near.distance2)};
    if (found.distance > max_distance || (best.size() == count && !nearer(found, best.back()))) return limit2;
    if (best.size() == count) best.pop_back();
    best.insert(std::upper_bound(best.begin(), best.end(), found, nearer), found);
    if (best.size() == count) limit2 = limit2_of(best.back().distance);
    return limit2;
  });
  return best;
}

template <class Ray, class Visit>
void SurfaceTree::visit_along(const Ray& ray, double limit, Visit visit) const {
  struct Waiting {
    std::size_t node;
    double t;
  };
  std::array<Waiting, 64> stack{Waiting{1, ray.entry(nodes_[1], slack_)}};
  for (std::size_t height = 1; height > 0;) {
    const auto [node, t] = stack[--height];
    if (!(t <= limit) || t == kInfinity) continue;
    if (node >= first_leaf_) {
      for (const Entry& entry : entries_of(node - first_leaf_)) limit = visit(entry);
      continue;
    }
    Waiting near{2 * node, ray.entry(nodes_[2 * node], slack_)};
    Waiting far{2 * node + 1, ray.entry(nodes_[2 * node + 1], slack_)};
    if (far.t < near.t) std::swap(near, far);
    stack[height++] = far;
    stack[height++] = near;
  }
}

std::optional<RayHit> SurfaceTree::first_hit(const Vec3d& origin, const Vec3d& direction, double max_t) const {
  const TriangleRay ray(origin, direction);
  std::optional<RayHit> best;
  double limit = max_t;
  visit_along(ray, limit, [&](const Entry& entry) {
    const std::optional<TriangleRay::Meeting> meeting = ray.meet(entry.corners);
    if (!meeting || !(meeting->t >= 0 && meeting->t <= max_t)) return limit;
    const RayHit found{entry.triangle, meeting->t, meeting->leaves};
    if (!best || before(found, *best)) {
      best = found;
      limit = found.t;
    }
    return limit;
  });
  return best;
}

std::vector<RayHit> SurfaceTree::hits(const Vec3d& origin, const Vec3d& direction) const {
  const TriangleRay ray(origin, direction);
  std::vector<RayHit> found;
  visit_along(ray, kInfinity, [&](const Entry& entry) {
    const std::optional<TriangleRay::Meeting> meeting = ray.meet(entry.corners);
    if (meeting && meeting->t >= 0) found.push_back({entry.triangle, meeting->t, meeting->leaves});
    return kInfinity;
  });
  std::sort(found.begin(), found.end(), before);
  return found;
}

}  // namespace knead
