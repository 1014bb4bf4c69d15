#include "knead/flow/point_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "knead/field/point_sums.h"
#include "knead/math/box.h"

namespace knead::detail {

namespace {

constexpr std::uint32_t kLeaf = kPointPack;

}  // namespace

PointTree::PointTree(std::span<const Vec3d> points) : points_(points.begin(), points.end()) {
  nodes_.reserve(points_.size());
  if (!points_.empty()) build(0, static_cast<std::uint32_t>(points_.size()));
}

std::uint32_t PointTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  const std::span<Vec3d> own(points_.data() + begin, end - begin);
  Node node;
  node.begin = begin;
  node.end = end;
  for (const Vec3d& p : own) node.centroid += p;
  node.centroid = node.centroid / static_cast<double>(own.size());
  double greatest = 0;
  for (const Vec3d& p : own) {
    const double square = norm2(p - node.centroid);
    greatest = std::max(greatest, square);
    node.mean_square += square / static_cast<double>(own.size());
  }
  node.radius = std::sqrt(greatest);
  nodes_.push_back(node);
  if (own.size() <= kLeaf) return index;
  const Box box = bounding_box(own);
  const Vec3d size = box.max - box.min;
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  // Whole packs on the left.
  const std::uint32_t middle = begin + ((end - begin) / 2 + kLeaf - 1) / kLeaf * kLeaf;
  // A whole order, so that every standard library finds the same one.
  std::sort(own.begin(), own.end(), [axis](const Vec3d& p, const Vec3d& q) {
    return std::tie(p[axis], p.x, p.y, p.z) < std::tie(q[axis], q.x, q.y, q.z);
  });
  const std::uint32_t left = build(begin, middle);
  const std::uint32_t right = build(middle, end);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

// At least r(x) / |x - p| for every x of the ball and p of the node; infinity where there is no such number.
// With u the direction from the node's centroid to the ball's centre, at distance d, and x = centre + delta: |x -
// centroid| >= d exp(u.delta/d - 0.78 (delta/d)^2) while |delta| <= d/2; and since r^-m is a sum of powers, by
// Jensen's inequality r(x) <= r exp(grad r.delta/r + (delta/nearest)^2/2). Together they are far sharper than the two
// distances changed by the radius against each other, which is what is left otherwise.
double PointTree::ratio_bound(const ListDemand& demand, const Node& node) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Vec3d from = demand.center - node.centroid;
  const double distance = norm(from);
  const double least = distance - demand.radius;
  if (least <= node.radius) return infinity;
  const double spread = 1 - node.radius / least;
  const double coarse = demand.most / (least * spread);
  if (!demand.points_alone || 2 * demand.radius > demand.nearest) return coarse;
  const double at_nearest = demand.radius / demand.nearest;
  const double at_distance = demand.radius / distance;
  const Vec3d slope = demand.gradient / demand.r - from / (distance * distance);
  const double growth = norm(slope) * demand.radius + 0.5 * at_nearest * at_nearest + 0.78 * at_distance * at_distance;
  if (growth >= 1) return coarse;
  return std::min(coarse, demand.r / (distance * spread * (1 - growth)));  // exp(a) <= 1 / (1 - a)
}

// The list with no error above `most_of_one` for any one cluster; returns the bound of all errors together, or stops
// beyond demand.error.
double PointTree::list_by(const ListDemand& demand, double most_of_one, std::vector<WeightedPoint>& result) const {
  const double m = demand.exponent;
  double error = 0;
  std::array<std::uint32_t, 64> stack{};
  std::size_t height = 1;
  result.clear();
  while (height > 0 && error <= demand.error) {
    const Node& node = nodes_[stack[--height]];
    const double ratio = ratio_bound(demand, node);
    if (std::isfinite(ratio)) {
      double share = 0;
      positive_power(share, ratio * ratio, demand.exponent / 2);
      share *= node.end - node.begin;
      if (share <= most_of_one) {
        error += share;
        continue;
      }
      const double least = norm(demand.center - node.centroid) - node.radius - demand.radius;
      const double as_cluster = share * 0.5 * m * (m + 1) * node.mean_square / (least * least);
      if (as_cluster <= most_of_one && node.end - node.begin > 1) {
        error += as_cluster;
        result.push_back({node.centroid, static_cast<double>(node.end - node.begin)});
        continue;
      }
    }
    if (node.left == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) result.push_back({points_[i], 1.0});
      continue;
    }
    stack[height++] = node.right;
    stack[height++] = node.left;
  }
  return error;
}

void PointTree::list(const ListDemand& demand, std::vector<WeightedPoint>& result) const {
  result.clear();
  if (points_.empty()) return;
  double most_of_one = demand.error / 4;
  while (list_by(demand, most_of_one, result) > demand.error) most_of_one /= 4;
}

}  // namespace knead::detail
