#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
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

// The place of a box's centre on the Morton curve.
std::uint64_t morton_code_of(const FloatBox& box) {
  std::array<float, 3> center{};
  for (std::size_t k = 0; k < 3; ++k) center[k] = (box.min[k] + box.max[k]) * 0.5F;
  return morton_code(center);
}

using CodedMember = std::pair<std::uint64_t, std::uint32_t>;

// Sorts by the code, then by the member. Many are sorted by digits, from the last one on: members of one code then stay
// in their order, which must ascend.
void sort_by_code(std::vector<CodedMember>& order) {
  constexpr std::size_t few = 4096;
  constexpr int bits = 11;
  constexpr int code_bits = 63;
  const auto by_member = [](const CodedMember& a, const CodedMember& b) { return a.second < b.second; };
  if (order.size() < few || !std::is_sorted(order.begin(), order.end(), by_member)) {
    return std::sort(order.begin(), order.end());
  }
  std::vector<CodedMember> sorted(order.size());
  for (int shift = 0; shift < code_bits; shift += bits) {
    const auto digit = [&](const CodedMember& each) { return each.first >> shift & ((1 << bits) - 1); };
    std::array<std::size_t, (1 << bits) + 1> begin{};
    for (const CodedMember& each : order) ++begin[digit(each) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (const CodedMember& each : order) sorted[begin[digit(each)]++] = each;
    order.swap(sorted);
  }
}

Box bounds_of(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
              std::span<const std::uint32_t> members) {
  Box all;
  for (const std::uint32_t t : members) {
    for (const std::uint32_t v : triangles[t]) all.extend(positions[v]);
  }
  return members.empty() ? Box{{}, {}} : all;
}

}  // namespace

FloatBox BoxTree::box_of(const std::array<Vec3d, 3>& corners) const {
  FloatBox box = kEmpty;
  for (const Vec3d& corner : corners) {
    const std::array<float, 3> p = to_unit_(corner);
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
    : to_unit_(bounds_of(triangles, positions, members)) {
  constexpr std::size_t grain = 4096;  // triangles, or leaves
  std::vector<CodedMember> order(members.size());
  parallel_for(order.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      order[i] = {morton_code_of(box_of(triangles[members[i]], positions)), members[i]};
    }
  });
  sort_by_code(order);

  const std::size_t leaves = std::bit_ceil(std::max<std::size_t>(1, (order.size() + kLeafSize - 1) / kLeafSize));
  leaves_.resize(leaves);
  nodes_.assign(2 * leaves, kEmpty);
  parallel_for(leaves, grain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * kLeafSize; i < end * kLeafSize; ++i) {
      Leaf& leaf = leaves_[i / kLeafSize];
      const FloatBox box = i < order.size() ? box_of(triangles[order[i].second], positions) : kEmpty;
      for (std::size_t k = 0; k < 3; ++k) {
        leaf.min[k][i % kLeafSize] = box.min[k];
        leaf.max[k][i % kLeafSize] = box.max[k];
      }
      leaf.triangle[i % kLeafSize] = i < order.size() ? order[i].second : 0;
      nodes_[leaves + i / kLeafSize] = join(nodes_[leaves + i / kLeafSize], box);
    }
  });
  for (std::size_t node = leaves - 1; node > 0; --node) nodes_[node] = join(nodes_[2 * node], nodes_[2 * node + 1]);
}

namespace {

// Keeps the nearest of several points of a triangle.
struct Nearest {
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

}  // namespace

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
  Nearest nearest{.corners = corners, .p = p};
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

namespace {

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
