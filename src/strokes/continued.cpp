#include "strokes/continued.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "knead/vec.h"
#include "mesh/edges.h"

namespace knead::tool_detail {

namespace {

struct PlanePoint {
  double x = 0;
  double y = 0;
};

// An edge that the plane cuts, as one of the two of a cut triangle.
struct Cut {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t piece = 0;  // the cut triangle, numbered among the cut ones
  PlanePoint at;
};

struct Cutter {
  Vec3d point;
  Vec3d normal;
  Vec3d u;
  Vec3d v;
  std::span<const Vec3d> positions;

  double height(std::uint32_t vertex) const { return dot(normal, positions[vertex] - point); }
  bool is_above(std::uint32_t vertex) const { return height(vertex) > 0; }
  bool cuts(std::uint32_t a, std::uint32_t b) const { return is_above(a) != is_above(b); }

  // Of the edge's two ends in one order, so that both of its triangles have the same point.
  Cut cut(std::uint32_t a, std::uint32_t b, std::uint32_t piece) const {
    const auto [low, high] = std::minmax(a, b);
    const double from = height(low);
    const Vec3d d = positions[low] + (positions[high] - positions[low]) * (from / (from - height(high))) - point;
    return {low, high, piece, {dot(u, d), dot(v, d)}};
  }
};

// Whether a ray from the origin along +x crosses from p to q.
bool crosses_ray(const PlanePoint& p, const PlanePoint& q) {
  if ((p.y > 0) == (q.y > 0)) return false;
  return p.x + (q.x - p.x) * (p.y / (p.y - q.y)) > 0;
}

// Joins the triangles on both sides of every edge that is cut.
DisjointSets joined_across_edges(std::vector<Cut> cuts, std::size_t pieces) {
  std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) {
    return std::tie(a.low, a.high, a.piece) < std::tie(b.low, b.high, b.piece);
  });
  DisjointSets sets(pieces);
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    if (cuts[i].low == cuts[i - 1].low && cuts[i].high == cuts[i - 1].high) sets.join(cuts[i].piece, cuts[i - 1].piece);
  }
  return sets;
}

}  // namespace

std::vector<SliceLoop> slice(const Vec3d& point, const Vec3d& normal, std::span<const Vec3d> positions,
                             std::span<const Triangle> triangles) {
  const Vec3d u = any_orthogonal(normal);
  const Cutter cutter{point, normal, u, cross(normal, u), positions};
  std::vector<Cut> cuts;  // two for every triangle that is cut
  std::vector<std::uint32_t> cut_triangles;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const auto piece = static_cast<std::uint32_t>(cut_triangles.size());
    for (std::size_t k = 0; k < 3; ++k) {
      if (cutter.cuts(t[k], t[(k + 1) % 3])) cuts.push_back(cutter.cut(t[k], t[(k + 1) % 3], piece));
    }
    if (cuts.size() > 2 * cut_triangles.size()) cut_triangles.push_back(i);
  }
  DisjointSets sets = joined_across_edges(cuts, cut_triangles.size());
  std::map<std::uint32_t, SliceLoop> loops;
  for (std::uint32_t i = 0; i < cut_triangles.size(); ++i) {
    SliceLoop& loop = loops.try_emplace(sets.find(i), SliceLoop{0, false, cut_triangles[i]}).first->second;
    const PlanePoint& p = cuts[std::size_t{2} * i].at;
    const PlanePoint& q = cuts[std::size_t{2} * i + 1].at;
    loop.reach = std::max({loop.reach, std::sqrt(p.x * p.x + p.y * p.y), std::sqrt(q.x * q.x + q.y * q.y)});
    if (crosses_ray(p, q)) loop.around_point = !loop.around_point;
  }
  std::vector<SliceLoop> result;
  result.reserve(loops.size());
  for (const auto& [set, loop] : loops) result.push_back(loop);
  return result;
}

std::optional<SliceLoop> innermost(const std::vector<SliceLoop>& loops) {
  std::optional<SliceLoop> found;
  for (const SliceLoop& loop : loops) {
    if (loop.around_point && (!found || loop.reach < found->reach)) found = loop;
  }
  return found;
}

}  // namespace knead::tool_detail

namespace knead {

namespace {

template <class T>
bool begins_with(const std::vector<T>& whole, const std::vector<T>& beginning) {
  return whole.size() > beginning.size() && std::equal(beginning.begin(), beginning.end(), whole.begin());
}

// The stroke without what grows while it is made.
template <class S, class List>
S without(S stroke, List S::*list) {
  (stroke.*list).clear();
  return stroke;
}

template <class S, class List>
bool has_grown(const S& before, const S& now, List S::*list) {
  return begins_with(now.*list, before.*list) && without(before, list) == without(now, list);
}

template <class S, class List>
bool goes_on(const S& last, const S& next, List S::*list) {
  const bool touches = !(last.*list).empty() && !(next.*list).empty() && (last.*list).back() == (next.*list).front();
  return touches && without(last, list) == without(next, list);
}

// Of the list, what comes from an index on.
template <class S, class List>
S from(S stroke, List S::*list, std::size_t first) {
  (stroke.*list).erase((stroke.*list).begin(), (stroke.*list).begin() + static_cast<std::ptrdiff_t>(first));
  return stroke;
}

template <class S, class List>
S with(S stroke, List S::*list, const List& more, std::size_t skipped) {
  (stroke.*list).insert((stroke.*list).end(), more.begin() + static_cast<std::ptrdiff_t>(skipped), more.end());
  return stroke;
}

// Returns true if a relaxed path goes on near one of its last points; with mirror images these are several.
bool goes_on_near(const RelaxStroke& last, const RelaxStroke& next) {
  constexpr std::size_t kMaxImages = 256;
  if (next.points.empty() || without(last, &RelaxStroke::points) != without(next, &RelaxStroke::points)) return false;
  const std::size_t first = last.points.size() - std::min(last.points.size(), kMaxImages);
  return std::any_of(last.points.begin() + static_cast<std::ptrdiff_t>(first), last.points.end(),
                     [&](const Vec3d& p) { return norm(p - next.points.front()) <= last.radius; });
}

// Calls body with both as strokes of that tool; nothing where one is of another.
template <class S, class Body>
auto of_both(const Stroke& a, const Stroke& b, const Body& body) {
  const auto* first = std::get_if<S>(&a);
  const auto* second = std::get_if<S>(&b);
  return first != nullptr && second != nullptr ? body(*first, *second) : decltype(body(*first, *second)){};
}

}  // namespace

std::optional<Stroke> suffix_since(const Stroke& before, const Stroke& now) {
  using Rest = std::optional<Stroke>;
  Rest path = of_both<ImplicitStroke>(before, now, [](const auto& a, const auto& b) -> Rest {
    if (a.path.empty() || !has_grown(a, b, &ImplicitStroke::path)) return std::nullopt;
    return from(b, &ImplicitStroke::path, a.path.size() - 1);
  });
  if (path) return path;
  Rest dabs = of_both<RelaxStroke>(before, now, [](const auto& a, const auto& b) -> Rest {
    if (a.points.empty() || !has_grown(a, b, &RelaxStroke::points)) return std::nullopt;
    return from(b, &RelaxStroke::points, a.points.size());
  });
  if (dabs) return dabs;
  return of_both<PaintStroke>(before, now, [](const auto& a, const auto& b) -> Rest {
    if (a.samples.empty() || !has_grown(a, b, &PaintStroke::samples)) return std::nullopt;
    return from(b, &PaintStroke::samples, a.samples.size());
  });
}

std::optional<Flow> flow_suffix_since(const Stroke& before, const Stroke& now, const Mirror& mirror) {
  if (!is_flow(now)) return std::nullopt;
  if (const std::optional<Stroke> rest = suffix_since(before, now)) return flow_of(*rest, mirror);
  return of_both<PointsStroke>(before, now, [&](const auto& a, const auto& b) -> std::optional<Flow> {
    if (!has_grown(a, b, &PointsStroke::displacements)) return std::nullopt;
    Flow flow = flow_of(b, mirror);
    const std::size_t done = flow_of(a).segments.size();
    flow.segments.erase(flow.segments.begin(), flow.segments.begin() + static_cast<std::ptrdiff_t>(done));
    return flow;
  });
}

bool continues(const Stroke& last, const Stroke& next) {
  const auto goes_on_along_path = [](const auto& a, const auto& b) {
    using S = std::decay_t<decltype(a)>;
    return goes_on(a, b, &S::path);
  };
  if (of_both<ImplicitStroke>(last, next, goes_on_along_path)) return true;
  if (of_both<StampStroke>(last, next, goes_on_along_path)) return true;
  if (of_both<RelaxStroke>(last, next, goes_on_near)) return true;
  return of_both<PaintStroke>(last, next, [](const auto& a, const auto& b) {
    return a.path.empty() && b.path.empty() && a.outer == b.outer && a.depth == b.depth && a.falloff == b.falloff;
  });
}

std::optional<Stroke> joined(const Stroke& last, const Stroke& next) {
  using Joined = std::optional<Stroke>;
  if (!continues(last, next)) return std::nullopt;
  Joined path = of_both<ImplicitStroke>(
      last, next, [](const auto& a, const auto& b) -> Joined { return with(a, &ImplicitStroke::path, b.path, 1); });
  if (path) return path;
  Joined dabs = of_both<RelaxStroke>(
      last, next, [](const auto& a, const auto& b) -> Joined { return with(a, &RelaxStroke::points, b.points, 0); });
  if (dabs) return dabs;
  return of_both<PaintStroke>(
      last, next, [](const auto& a, const auto& b) -> Joined { return with(a, &PaintStroke::samples, b.samples, 0); });
}

}  // namespace knead

namespace knead::tool_detail {

namespace {

// A point (both ends the same) or a segment of a curve.
struct Piece {
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

// Joins everything nearer than the reach, from the leaves of a box hierarchy upwards, so that whatever already hangs
// together is not compared again.
class Joiner {
 public:
  Joiner(std::vector<Piece> pieces, std::size_t elements, double reach)
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
    std::nth_element(pieces_.begin() + begin, pieces_.begin() + middle, pieces_.begin() + end,
                     [&](const Piece& p, const Piece& q) { return p.a[axis] + p.b[axis] < q.a[axis] + q.b[axis]; });
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
        const Piece& p = pieces_[i];
        const Piece& q = pieces_[j];
        if (sets_.find(p.element) == sets_.find(q.element)) continue;
        if (squared_segment_distance(p.a, p.b, q.a, q.b) < reach2_) sets_.join(p.element, q.element);
      }
    }
  }

  std::vector<Piece> pieces_;
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
  std::vector<Piece> pieces;
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

}  // namespace knead::tool_detail
