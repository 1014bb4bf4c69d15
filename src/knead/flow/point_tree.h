// Points in a hierarchy of clusters, from which a short list is drawn that stands for all of them within a part of
// space. Internal to the flow room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/math/vec3.h"

namespace knead::detail {

struct WeightedPoint {
  Vec3d p;
  double weight = 1;
};

// Where a list is to hold, and how well. r is that of the whole region, of which the points may be a part.
struct ListDemand {
  Vec3d center;              // of a ball
  double radius = 0;         // and its radius
  double r = 0;              // at the centre
  Vec3d gradient;            // grad r there, only where all elements are points
  double nearest = 0;        // the true distance of the centre from the nearest element
  double most = 0;           // at least r everywhere in the ball
  bool points_alone = true;  // no other elements
  int exponent = 8;          // m
  double error = 0;          // relative, of the sum r^-m, everywhere in the ball
};

class PointTree {
 public:
  // In preorder: a left child follows its parent.
  struct Node {
    Vec3d centroid;
    double radius = 0;  // all points are within it
    double mean_square = 0;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t left = 0;  // 0: a leaf
    std::uint32_t right = 0;
  };

  // Time: n log n.
  explicit PointTree(std::span<const Vec3d> points);

  // Points and clusters, a cluster as its centroid with the number of its points as weight, such that the sum r^-m over
  // the list differs from that over all elements by at most error r^-m, and its gradient accordingly, everywhere in the
  // ball. A cluster at distance d, of n points whose mean squared distance from the centroid is rms^2, is taken where
  // n d^-m m(m+1)/2 rms^2/d^2 is small enough (method, section 3), and left out where n d^-m itself is; d is the least
  // distance from any x of the ball to any point of the cluster. So the bound is strict: by Taylor's theorem with the
  // greatest eigenvalue m(m+1) d^-(m+2) of the Hessian of d^-m. The list depends on the arguments alone.
  void list(const ListDemand& demand, std::vector<WeightedPoint>& result) const;

  // Calls visit(p) for a few points near x, all of them where they are few, by going down to the nearer centroids. Of
  // at least one point.
  template <class Visit>
  void visit_near(const Vec3d& x, Visit visit) const {
    const Node* node = nodes_.data();
    while (node->left != 0) {
      const Node& left = nodes_[node->left];
      const Node& right = nodes_[node->right];
      node = norm2(x - left.centroid) <= norm2(x - right.centroid) ? &left : &right;
    }
    for (std::uint32_t i = node->begin; i < node->end; ++i) visit(points_[i]);
  }

  std::size_t size() const { return points_.size(); }

  // As the nodes number them.
  std::span<const Vec3d> points() const { return points_; }
  std::span<const Node> nodes() const { return nodes_; }

 private:
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  double list_by(const ListDemand& demand, double most_of_one, std::vector<WeightedPoint>& result) const;
  static double ratio_bound(const ListDemand& demand, const Node& node);

  std::vector<Vec3d> points_;
  std::vector<Node> nodes_;
};

}  // namespace knead::detail
