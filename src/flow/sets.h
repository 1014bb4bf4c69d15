// Large point sets: a tree whose clusters replace distant points, and fields in cells of space that each use a short
// list of points and clusters. Internal to the library.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "field/point_sums.h"
#include "flow/closed_form.h"
#include "flow/masked.h"
#include "knead/vec.h"

namespace knead::detail {

struct WeightedPoint {
  Vec3d p;
  double weight = 1;
};

// The ball in which a list is valid, and the error of the list. r is that of the whole region, of which the points may
// be a part.
struct ListDemand {
  Vec3d center;              // of the ball
  double radius = 0;         // of the ball
  double r = 0;              // at the centre
  Vec3d gradient;            // grad r at the centre, if all elements are points
  double nearest = 0;        // the true distance of the centre from the nearest element
  double most = 0;           // an upper bound of r in the ball
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

  // Finds points and clusters such that the sum r^-m over the list differs from that over all elements by at most error
  // r^-m, and its gradient accordingly, everywhere in the ball. A cluster is its centroid with the number of its points
  // as weight. A cluster at distance d, of n points whose mean squared distance from the centroid is rms^2, is listed
  // where n d^-m m(m+1)/2 rms^2/d^2 is small enough (method, section 3), and omitted where n d^-m itself is; d is the
  // least distance from any x of the ball to any point of the cluster. The bound is strict, by Taylor's theorem with
  // the greatest eigenvalue m(m+1) d^-(m+2) of the Hessian of d^-m. The list depends on the arguments alone.
  void list(const ListDemand& demand, std::vector<WeightedPoint>& result) const;

  // Calls visit(p) for a few points near x: those of the leaf to which the nearer centroids lead. The tree must not be
  // empty.
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

  // In the order of the nodes.
  std::span<const Vec3d> points() const { return points_; }
  std::span<const Node> nodes() const { return nodes_; }

 private:
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  double list_by(const ListDemand& demand, double most_of_one, std::vector<WeightedPoint>& result) const;
  static double ratio_bound(const ListDemand& demand, const Node& node);

  std::vector<Vec3d> points_;
  std::vector<Node> nodes_;
};

// A point set with a tree that estimates the distance to its points.
template <class S>
struct GuidedSet {
  PackedSet<S> set;
  std::shared_ptr<const PointTree> tree;
};

template <class S>
GuidedSet<S> guided(const PointSet<double>& set) {
  return {packed<S>(set), std::make_shared<const PointTree>(set.points)};
}

// Returns r and grad r at d. The unit of the sums is the distance to a near point, not the least distance, which takes
// half of the time for a large set. If the sums overflow, because another point is far nearer, evaluates as PackedSet.
template <class S>
RegionValue<S> evaluate(const GuidedSet<S>& region, const Vec3<S>& d, const S& t) {
  if (!region.set.curves->empty() || region.tree->size() == 0) return evaluate(region.set, d, t);
  S near2 = std::numeric_limits<S>::max();
  region.tree->visit_near(Vec3d(d), [&](const Vec3d& p) { near2 = std::min(near2, norm2(d - Vec3<S>(p))); });
  if (near2 > S(0)) {
    const RegionValue<S> r = evaluate_by(region.set, d, near2, std::sqrt(near2));
    if (is_sound(r)) return r;
  }
  return evaluate(region.set, d, t);
}

// From this number of points on, a set uses lists in cells, not pack kernels.
inline constexpr std::size_t kMinListedPoints = 48;

template <class S>
using SetField = SingleField<S, Translation<S>, PackedSet<S>>;

// Returns whether the segment consists of swept translations of point sets, as SetCells requires.
bool is_of_sets(const Segment& segment);

// A cube of space in the tool's frame, and the fields whose supports meet it, each with its list of elements and a
// scale for their sums.
template <class S>
struct SetCell {
  int index = 0;  // among all cells
  Vec3d center;
  std::vector<SetField<S>> fields;  // empty: v = 0 everywhere in the cell
  bool inside = false;              // r < outer of some field everywhere in the cell
};

// The fields of moving point sets, in cells of the tool's space. Cells are made when a path line first needs them, each
// from the segment alone, so that a point's result depends neither on other points nor on threads. Within a cell the
// field is one smooth function with its exact gradient, hence divergence-free. It approximates the field of all
// elements so that positions err by at most about a tenth of the tolerance. A path line keeps the cell in which it
// begins while it stays near it: in a short segment to its end.
template <class S>
class SetCells {
 public:
  SetCells(const Segment& segment, double tolerance, const SegmentMask& mask = {});
  SetCells(const SetCells&) = delete;
  SetCells& operator=(const SetCells&) = delete;
  ~SetCells();

  // The cell of a path line; null outside all cells.
  using Place = const SetCell<S>*;

  // Returns the earliest time from t on at which the resting point x can be inside the support; moves `place` along.
  std::optional<double> next_contact(Place& place, const Segment& segment, const Vec3d& x, double t) const;

  // The cell in which x is at the time t.
  Place cell_at(const Vec3d& x, double t) const { return cell_at(in_tool(x, t)); }

  // Moves `place` along with a path line that has come to x. Returns whether the cell is still the same.
  bool keeps(Place& place, const Vec3d& x, double t) const;

  Vec3<S> velocity(Place place, const Vec3d& x0, const Vec3<S>& moved, double t) const {
    Vec3<S> sum{};
    if (place == nullptr) return sum;
    for (const SetField<S>& field : place->fields) sum += field.velocity(x0, moved, t);
    return sum;
  }

 private:
  struct Part {
    SetField<S> field;  // with all elements
    Vec3d offset;       // of its centre from the anchor
    Box box;            // of its elements, about its centre
    double radius = 0;  // support_radius
    double error = 0;   // that v may have, by the tool's speed
    double outer = 0;
    PointTree tree;
  };

  Part make_part(const Field& field, double error) const;
  void lay_grid();
  int cell_count() const { return counts_[0] * counts_[1] * counts_[2]; }
  Vec3d in_tool(const Vec3d& x, double t) const { return x - anchor_ - displacement_ * t; }
  bool holds(Place place, const Vec3d& d) const;
  Place cell_at(const Vec3d& d) const;
  std::unique_ptr<SetCell<S>> make_cell(const Vec3d& center) const;
  void add_part(const Part& part, SetCell<S>& cell) const;
  double safe_advance(Place place, const Vec3d& d, const Vec3d& velocity) const;

  Vec3d anchor_;
  Vec3d displacement_;
  double duration_;  // an upper bound of that of path lines
  std::vector<Part> parts_;
  Box box_;               // of the supports, in the tool's frame
  double size_ = 0;       // of a cell
  double excursion_ = 0;  // the distance by which a step's stages may leave the cube of a cell
  double home_ = 0;       // half the edge of the cube in which a path line keeps its cell
  double radius_ = 0;     // of the ball around a cell's centre in which its lists are valid
  double inverse_size_ = 0;
  std::array<int, 3> counts_{};
  std::unique_ptr<std::atomic<const SetCell<S>*>[]> cells_;
};

extern template class SetCells<float>;
extern template class SetCells<double>;

}  // namespace knead::detail
