// Connected parts of points and polylines, by a hierarchy of boxes.
#include "strokes/connected_parts.h"

#include <algorithm>
#include <utility>

#include "mesh/edges.h"

namespace knead::detail {

namespace {

// A point (both ends the same) or a segment of a curve.
struct ElementPiece {
  Vec3d a;
  Vec3d b;
  std::uint32_t element = 0;
};

// A node of the hierarchy over pieces[begin, end). whole: all of its pieces are known to be of one component, which
// stays true once it is.
struct Node {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::uint32_t left = 0;  // 0: a leaf
  std::uint32_t right = 0;
  bool whole = false;
  Box box;
};

double squared_box_distance(const Box& a, const Box& b) {
  const auto gap = [](double a_min, double a_max, double b_min, double b_max) {
    return std::max({0.0, a_min - b_max, b_min - a_max});
  };
  return norm2(Vec3d{gap(a.min.x, a.max.x, b.min.x, b.max.x), gap(a.min.y, a.max.y, b.min.y, b.max.y),
                     gap(a.min.z, a.max.z, b.min.z, b.max.z)});
}

// Joins all pieces nearer than the reach, from the leaves of a box hierarchy upwards, so that connected pieces are not
// compared again.
class Joiner {
 public:
  Joiner(std::vector<ElementPiece> pieces, std::size_t elements, double reach)
      : pieces_(std::move(pieces)), sets_(elements), reach2_(reach * reach) {
    nodes_.reserve(2 * pieces_.size());
    build(0, static_cast<std::uint32_t>(pieces_.size()));
    join_within(0);
  }

  DisjointSets& sets() { return sets_; }

 private:
  static constexpr std::uint32_t kLeaf = 4;

  std::uint32_t build(std::uint32_t begin, std::uint32_t end) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    Node node{begin, end, 0, 0, false, {}};
    for (std::uint32_t i = begin; i < end; ++i) {
      node.box.extend(pieces_[i].a);
      node.box.extend(pieces_[i].b);
    }
    nodes_.push_back(node);
    if (end - begin <= kLeaf) return index;
    const Vec3d size = node.box.max - node.box.min;
    const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(
        pieces_.begin() + begin, pieces_.begin() + middle, pieces_.begin() + end,
        [&](const ElementPiece& p, const ElementPiece& q) { return p.a[axis] + p.b[axis] < q.a[axis] + q.b[axis]; });
    const std::uint32_t left = build(begin, middle);
    const std::uint32_t right = build(middle, end);
    nodes_[index].left = left;
    nodes_[index].right = right;
    return index;
  }

  std::uint32_t set_of(const Node& node) { return sets_.find(pieces_[node.begin].element); }

  void join_within(std::uint32_t index) {
    Node& node = nodes_[index];
    if (node.left == 0) {
      join_leaves(node, node);
    } else {
      join_within(node.left);
      join_within(node.right);
      join_between(node.left, node.right);
    }
    refresh(node);
  }

  void refresh(Node& node) {
    if (node.whole) return;
    if (node.left != 0) {
      const Node& left = nodes_[node.left];
      const Node& right = nodes_[node.right];
      node.whole = left.whole && right.whole && set_of(left) == set_of(right);
      return;
    }
    node.whole = true;
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      node.whole = node.whole && sets_.find(pieces_[i].element) == set_of(node);
    }
  }

  void join_between(std::uint32_t first, std::uint32_t second) {
    Node& a = nodes_[first];
    Node& b = nodes_[second];
    if (squared_box_distance(a.box, b.box) >= reach2_) return;
    if (a.whole && b.whole && set_of(a) == set_of(b)) return;
    if (a.left == 0 && b.left == 0) {
      join_leaves(a, b);
    } else if (b.left == 0 || (a.left != 0 && a.end - a.begin >= b.end - b.begin)) {
      join_between(a.left, second);
      join_between(a.right, second);
    } else {
      join_between(first, b.left);
      join_between(first, b.right);
    }
    refresh(a);
    refresh(b);
  }

  void join_leaves(const Node& a, const Node& b) {
    for (std::uint32_t i = a.begin; i < a.end; ++i) {
      for (std::uint32_t j = b.begin; j < b.end; ++j) {
        const ElementPiece& p = pieces_[i];
        const ElementPiece& q = pieces_[j];
        if (sets_.find(p.element) == sets_.find(q.element)) continue;
        if (squared_segment_distance(p.a, p.b, q.a, q.b) < reach2_) sets_.join(p.element, q.element);
      }
    }
  }

  std::vector<ElementPiece> pieces_;
  std::vector<Node> nodes_;
  DisjointSets sets_;
  double reach2_;
};

double squared_point_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d e = b - a;
  const double length2 = norm2(e);
  const double along = length2 > 0 ? std::clamp(dot(e, p - a) / length2, 0.0, 1.0) : 0.0;
  return norm2(p - a - e * along);
}

}  // namespace

// The squared distance is a convex function over the square of the two parameters: its least value is at the lines'
// nearest points where both lie inside, else at an end of one of the segments.
double squared_segment_distance(const Vec3d& a0, const Vec3d& a1, const Vec3d& b0, const Vec3d& b1) {
  const double ends = std::min({squared_point_distance(a0, b0, b1), squared_point_distance(a1, b0, b1),
                                squared_point_distance(b0, a0, a1), squared_point_distance(b1, a0, a1)});
  const Vec3d u = a1 - a0;
  const Vec3d v = b1 - b0;
  const Vec3d normal = cross(u, v);
  const double normal2 = norm2(normal);
  if (!(normal2 > 0)) return ends;
  const Vec3d w = b0 - a0;
  const double s = dot(cross(w, v), normal) / normal2;
  const double t = dot(cross(w, u), normal) / normal2;
  if (s <= 0 || s >= 1 || t <= 0 || t >= 1) return ends;
  return std::min(ends, norm2(w + v * t - u * s));
}

std::vector<Part> connected_parts(std::span<const Vec3d> points, std::span<const std::vector<Vec3d>> curves,
                                  double reach) {
  std::vector<ElementPiece> pieces;
  for (const Vec3d& p : points) pieces.push_back({p, p, static_cast<std::uint32_t>(pieces.size())});
  for (std::size_t k = 0; k < curves.size(); ++k) {
    const auto element = static_cast<std::uint32_t>(points.size() + k);
    for (std::size_t i = 0; i + 1 < curves[k].size(); ++i) pieces.push_back({curves[k][i], curves[k][i + 1], element});
  }
  std::vector<Part> parts;
  if (pieces.empty()) return parts;
  const std::size_t elements = points.size() + curves.size();
  Joiner joiner(std::move(pieces), elements, reach);
  std::vector<std::uint32_t> part_of(elements);
  for (std::uint32_t i = 0; i < elements; ++i) {  // a set's smallest element names it
    const std::uint32_t first = joiner.sets().find(i);
    if (first == i) {
      part_of[i] = static_cast<std::uint32_t>(parts.size());
      parts.emplace_back();
    }
    Part& part = parts[part_of[first]];
    if (i < points.size()) {
      part.points.push_back(i);
    } else {
      part.curves.push_back(i - static_cast<std::uint32_t>(points.size()));
    }
  }
  return parts;
}

}  // namespace knead::detail
