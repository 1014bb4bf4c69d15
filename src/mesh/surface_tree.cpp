// The trees over triangles, BoxTree and SurfaceTree, and searches for the nearest points of a surface.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "math/geometry.h"
#include "mesh/box_tree.h"

namespace knead {
namespace {

constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();
constexpr FloatBox kEmpty{{kFloatInfinity, kFloatInfinity, kFloatInfinity},
                          {-kFloatInfinity, -kFloatInfinity, -kFloatInfinity}};

// Returns the place of the box's centre on the Morton curve.
std::uint64_t morton_code_of(const FloatBox& box) {
  std::array<float, 3> center{};
  for (std::size_t k = 0; k < 3; ++k) center[k] = (box.min[k] + box.max[k]) * 0.5F;
  return morton_code(center);
}

Box bounds_of(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
              std::span<const std::uint32_t> members) {
  Box all;
  for (const std::uint32_t t : members) {
    for (const std::uint32_t v : triangles[t]) all.extend(positions[v]);
  }
  return members.empty() ? Box{{}, {}} : all;
}

// Keeps the nearest of several points of a triangle.
struct NearestOfTriangle {
  NearTriangle best{{}, {}, kInfinity};
  const std::array<Vec3d, 3>& corners;
  const Vec3d& p;

  void offer(const std::array<double, 3>& barycentric, const Vec3d& point) {
    const double distance2 = norm2(point - p);
    if (distance2 < best.distance2) best = {barycentric, point, distance2};
  }

  void offer_side(std::size_t i, std::size_t j) {
    const Vec3d edge = corners[j] - corners[i];
    const double length2 = norm2(edge);
    const double along = length2 > 0 ? std::clamp(dot(edge, p - corners[i]) / length2, 0.0, 1.0) : 0.0;
    std::array<double, 3> barycentric{};
    barycentric[i] = 1 - along;
    barycentric[j] = along;
    offer(barycentric, along < 1 ? corners[i] + edge * along : corners[j]);
  }
};

Box join(const Box& a, const Box& b) {
  return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y), std::min(a.min.z, b.min.z)},
          {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y), std::max(a.max.z, b.max.z)}};
}

double squared_distance(const Box& box, const Vec3d& p) {
  const auto outside = [](double low, double high, double x) { return std::max(std::max(low - x, x - high), 0.0); };
  const double x = outside(box.min.x, box.max.x, p.x);
  const double y = outside(box.min.y, box.max.y, p.y);
  const double z = outside(box.min.z, box.max.z, p.z);
  return x * x + y * y + z * z;
}

bool is_nearer(const SurfacePoint& a, const SurfacePoint& b) {
  return std::pair(a.distance, a.triangle) < std::pair(b.distance, b.triangle);
}

bool is_earlier(const RayHit& a, const RayHit& b) { return std::pair(a.t, a.triangle) < std::pair(b.t, b.triangle); }

// Returns the box extended by the distance on each side, with a margin for rounding.
Box extended(Box box, double distance) {
  const double margin = distance + 1e-9 * (distance + box.diagonal() + norm(box.min));
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  return box;
}

// Returns the numbers of the triangles whose boxes overlap this one.
std::vector<std::uint32_t> triangles_in(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                        const Box& box, int threads) {
  constexpr std::size_t grain = 4096;
  std::vector<std::vector<std::uint32_t>> of_parts((triangles.size() + grain - 1) / grain);
  parallel_for(triangles.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (!overlap(bounding_box(corners_of(triangles[t], positions)), box)) continue;
      of_parts[begin / grain].push_back(static_cast<std::uint32_t>(t));
    }
  });
  std::vector<std::uint32_t> all;
  for (const std::vector<std::uint32_t>& part : of_parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// A search for the nearest point of the surface for each of many points. Of equally near triangles, the one with the
// lowest number counts.
struct NearestSearch {
  std::span<const Triangle> triangles;
  std::span<const Vec3d> positions;
  std::span<const Vec3d> points;
  std::vector<std::uint32_t> numbers;  // of the nearest triangle so far, for each point
  std::vector<double> distances;       // from it
  std::vector<Vec3d> nearest;          // its nearest point

  void look_at(std::uint32_t i, std::uint32_t t) {
    const NearTriangle found = nearest_on_triangle(corners_of(triangles[t], positions), points[i]);
    const double distance = std::sqrt(found.distance2);
    if (!(std::pair(distance, t) < std::pair(distances[i], numbers[i]))) return;
    numbers[i] = t;
    distances[i] = distance;
    nearest[i] = found.point;
  }
};

// Searches the members of a tree around a group of points that are neighbours in space.
void look_around(const BoxTree& tree, std::span<const CurvePlace> group, NearestSearch& search) {
  constexpr std::size_t kMaxLeaves = 64;
  const auto box_around = [&](std::uint32_t i) {
    const Box box = extended({search.points[i], search.points[i]}, search.distances[i]);
    return tree.box_of({box.min, box.max, box.max});
  };
  FloatBox all = kEmpty;
  for (const CurvePlace& place : group) all = join(all, box_around(place.index));
  std::vector<std::size_t> leaves;
  tree.for_each_leaf_with(all, [&](std::size_t leaf) {
    leaves.push_back(leaf);
    return group.size() == 1 || leaves.size() <= kMaxLeaves;
  });
  if (group.size() > 1 && leaves.size() > kMaxLeaves) {  // the points are too far apart
    look_around(tree, group.first(group.size() / 2), search);
    return look_around(tree, group.subspan(group.size() / 2), search);
  }
  for (const CurvePlace& place : group) {
    const FloatBox box = box_around(place.index);
    for (const std::size_t leaf : leaves) {
      tree.for_each_overlap_in(leaf, box, [&](std::uint32_t t) { search.look_at(place.index, t); });
    }
  }
}

}  // namespace

FloatBox BoxTree::box_of(const std::array<Vec3d, 3>& corners) const {
  FloatBox box = kEmpty;
  for (const Vec3d& corner : corners) {
    const auto [x, y, z] = to_unit_(corner);
    const FloatLanes p{x, y, z};
    box = join(box, {p, p});
  }
  return box;
}

void BoxTree::widen(std::uint32_t place, const FloatBox& box) {
  Leaf& leaf = leaves_[place / kLeafSize];
  const std::size_t i = place % kLeafSize;
  const FloatBox widened = join(box_in(leaf, i), box);
  for (std::size_t k = 0; k < 3; ++k) {
    leaf.min[k][i] = widened.min[k];
    leaf.max[k][i] = widened.max[k];
  }
  for (std::size_t node = nodes_.size() / 2 + place / kLeafSize; node > 0 && !nodes_[node].holds(box); node /= 2) {
    nodes_[node] = join(nodes_[node], box);
  }
}

BoxTree::BoxTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                 std::span<const std::uint32_t> members, int threads)
    : to_unit_(bounds_of(triangles, positions, members)), size_(members.size()) {
  std::vector<CurvePlace> order(members.size());
  parallel_for(order.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      order[i] = {morton_code_of(box_of(triangles[members[i]], positions)), members[i]};
    }
  });
  sort_along_curve(order);

  const std::size_t leaves = std::bit_ceil(std::max<std::size_t>(1, (order.size() + kLeafSize - 1) / kLeafSize));
  leaves_.resize(leaves);
  nodes_.assign(2 * leaves, kEmpty);
  parallel_for(leaves, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * kLeafSize; i < end * kLeafSize; ++i) {
      Leaf& leaf = leaves_[i / kLeafSize];
      const FloatBox box = i < order.size() ? box_of(triangles[order[i].index], positions) : kEmpty;
      for (std::size_t k = 0; k < 3; ++k) {
        leaf.min[k][i % kLeafSize] = box.min[k];
        leaf.max[k][i % kLeafSize] = box.max[k];
      }
      leaf.triangle[i % kLeafSize] = i < order.size() ? order[i].index : 0;
      nodes_[leaves + i / kLeafSize] = join(nodes_[leaves + i / kLeafSize], box);
    }
  });
  for (std::size_t node = leaves - 1; node > 0; --node) nodes_[node] = join(nodes_[2 * node], nodes_[2 * node + 1]);
}

NearTriangle nearest_on_triangle(const std::array<Vec3d, 3>& corners, const Vec3d& p) {
  const Vec3d ab = corners[1] - corners[0];
  const Vec3d ac = corners[2] - corners[0];
  const Vec3d normal = cross(ab, ac);
  const Vec3d ap = p - corners[0];
  const double area2 = norm2(normal);
  const double c = dot(normal, cross(ab, ap));
  const double b = dot(normal, cross(ap, ac));
  const double a = area2 - b - c;
  // In a very thin triangle the weights a, b and c are inaccurate, so its edges decide.
  const double size = norm2(ab) + norm2(ac);
  const bool needle = !(area2 > 1e-16 * size * size);
  NearestOfTriangle nearest{.corners = corners, .p = p};
  if (!needle && a > 0 && b > 0 && c > 0) {
    const double v = b / area2;
    const double w = c / area2;
    nearest.offer({std::max(0.0, 1 - v - w), v, w}, corners[0] + ab * v + ac * w);
    return nearest.best;
  }
  if (needle || c <= 0) nearest.offer_side(0, 1);
  if (needle || a <= 0) nearest.offer_side(1, 2);
  if (needle || b <= 0) nearest.offer_side(2, 0);
  return nearest.best;
}

SurfaceTree::SurfaceTree(std::span<const Triangle> triangles, std::span<const Vec3d> positions)
    : triangles_(triangles.begin(), triangles.end()) {
  check_triangles(triangles, positions);
  const auto box_of = [&](const Triangle& t) {
    return bounding_box(std::array{positions[t[0]], positions[t[1]], positions[t[2]]});
  };
  Box all;
  for (const Triangle& t : triangles) all = join(all, box_of(t));
  const ToUnit to_unit(all);
  std::vector<CurvePlace> order;
  order.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    order.push_back({morton_code(to_unit(box_of(triangles[t]).center())), t});
  }
  sort_along_curve(order);
  entries_.reserve(order.size());
  for (const CurvePlace& place : order) entries_.push_back({{}, place.index});
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

// Until the nodes below are refitted, a node's box holds the vertices at their old positions.
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
    if (found.distance <= max_distance && (!best || is_nearer(found, *best))) {
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
    if (found.distance > max_distance || (best.size() == count && !is_nearer(found, best.back()))) return limit2;
    if (best.size() == count) best.pop_back();
    best.insert(std::upper_bound(best.begin(), best.end(), found, is_nearer), found);
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
    if (!best || is_earlier(found, *best)) {
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
  std::sort(found.begin(), found.end(), is_earlier);
  return found;
}

std::vector<Vec3d> nearest_points(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                  std::span<const Vec3d> points, std::span<const std::uint32_t> guesses, int threads,
                                  const Progress* progress) {
  // Points that are farther from their guesses are searched for in the whole surface.
  const double near = 1e-3 * bounding_box(positions).diagonal();
  constexpr std::size_t group = 32;
  constexpr std::size_t grain = 32 * group;
  NearestSearch search{triangles, positions, points, {guesses.begin(), guesses.end()}, {}, {}};
  search.distances.resize(points.size());
  search.nearest.resize(points.size());
  const Box box = bounding_box(points);
  const ToUnit to_unit(box.empty() ? Box{{}, {}} : box);
  std::vector<CurvePlace> order(points.size());
  const auto in_parts = [&](std::size_t count, const auto& visit) {
    parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
      stop_if_cancelled(progress);
      visit(begin, end);
    });
  };
  in_parts(points.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const NearTriangle found = nearest_on_triangle(corners_of(triangles[guesses[i]], positions), points[i]);
      search.distances[i] = std::sqrt(found.distance2);
      search.nearest[i] = found.point;
      order[i] = {morton_code(to_unit(points[i])), static_cast<std::uint32_t>(i)};
    }
  });
  const auto is_near = [&](const CurvePlace& place) { return search.distances[place.index] <= near; };
  const auto end_of_near = std::stable_partition(order.begin(), order.end(), is_near);
  const std::vector<CurvePlace> far(end_of_near, order.end());
  order.erase(end_of_near, order.end());
  sort_along_curve(order);
  const BoxTree tree(triangles, positions, triangles_in(triangles, positions, extended(box, near), threads), threads);
  in_parts(order.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i += group) {
      look_around(tree, std::span(order).subspan(i, std::min(group, end - i)), search);
    }
  });
  if (far.empty()) return std::move(search.nearest);
  const SurfaceTree whole(triangles, positions);
  in_parts(far.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) search.nearest[far[k].index] = whole.closest(points[far[k].index])->point;
  });
  return std::move(search.nearest);
}

}  // namespace knead
