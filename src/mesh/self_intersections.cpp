#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/box_tree.h"
#include "mesh/predicates.h"

namespace knead {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon() / 2;  // the largest relative error of one rounding
constexpr double kBound2d = (3 + 16 * kEpsilon) * kEpsilon;              // Shewchuk's ccwerrboundA
constexpr double kBound3d = (7 + 56 * kEpsilon) * kEpsilon;              // and o3derrboundA

// A rounded result and its rounding error: their sum is exact.
struct Two {
  double head;
  double tail;
};

Two two_sum(double a, double b) {
  const double sum = a + b;
  const double b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

// Requires |a| >= |b|.
Two fast_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

Two two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// A number as the sum of doubles that do not overlap, from smallest to largest; none is zero.
template <std::size_t Capacity>
struct Expansion {
  std::array<double, Capacity> terms{};
  std::size_t size = 0;

  void append(double term) {
    if (term != 0) terms[size++] = term;
  }
  int sign() const { return size == 0 ? 0 : (terms[size - 1] > 0 ? 1 : -1); }
};

Expansion<2> difference(double a, double b) {
  const Two exact = two_sum(a, -b);
  Expansion<2> result;
  result.append(exact.tail);
  result.append(exact.head);
  return result;
}

// Shewchuk's Fast-Expansion-Sum: merges the terms of both by magnitude and adds them up.
template <std::size_t M, std::size_t N>
Expansion<M + N> operator+(const Expansion<M>& e, const Expansion<N>& f) {
  Expansion<M + N> result;
  Two sum{0, 0};
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < e.size || j < f.size) {
    const bool from_e = j == f.size || (i < e.size && std::abs(e.terms[i]) < std::abs(f.terms[j]));
    sum = two_sum(sum.head, from_e ? e.terms[i++] : f.terms[j++]);
    result.append(sum.tail);
  }
  result.append(sum.head);
  return result;
}

template <std::size_t N>
Expansion<N> operator-(Expansion<N> e) {
  for (std::size_t i = 0; i < e.size; ++i) e.terms[i] = -e.terms[i];
  return e;
}

// Shewchuk's Scale-Expansion.
template <std::size_t N>
Expansion<2 * N> operator*(const Expansion<N>& e, double factor) {
  Expansion<2 * N> result;
  double carry = 0;
  for (std::size_t i = 0; i < e.size; ++i) {
    const Two product = two_product(e.terms[i], factor);
    const Two low = two_sum(carry, product.tail);
    const Two high = fast_two_sum(product.head, low.head);
    result.append(low.tail);
    result.append(high.tail);
    carry = high.head;
  }
  result.append(carry);
  return result;
}

template <std::size_t N>
Expansion<4 * N> operator*(const Expansion<N>& e, const Expansion<2>& f) {
  if (f.size < 2) {  // most differences of coordinates are exact
    Expansion<4 * N> result;
    if (f.size == 0) return result;
    const Expansion<2 * N> product = e * f.terms[0];
    for (std::size_t i = 0; i < product.size; ++i) result.append(product.terms[i]);
    return result;
  }
  return e * f.terms[0] + e * f.terms[1];
}

struct ExactVector {
  Expansion<2> x, y, z;
};

ExactVector difference(const Vec3d& a, const Vec3d& b) {
  return {difference(a.x, b.x), difference(a.y, b.y), difference(a.z, b.z)};
}

Expansion<16> minor(const Expansion<2>& a, const Expansion<2>& b, const Expansion<2>& c, const Expansion<2>& d) {
  return a * d + -(b * c);
}

int exact_orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const ExactVector p = difference(b, a);
  const ExactVector q = difference(c, a);
  const ExactVector r = difference(d, a);
  return (minor(q.x, q.y, r.x, r.y) * p.z + minor(r.x, r.y, p.x, p.y) * q.z + minor(p.x, p.y, q.x, q.y) * r.z).sign();
}

// Returns whether a determinant, whose error is at most `bound`, has the right sign. The bound is 0 only if all
// products are 0. It is not finite if a coordinate is not, or if products are too large for exact numbers.
bool decides(double determinant, double bound) {
  return std::abs(determinant) > bound || bound == 0 || !std::isfinite(bound);
}

int sign(double x) { return static_cast<int>(x > 0) - static_cast<int>(x < 0); }

}  // namespace

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  const Vec3d p = b - a;
  const Vec3d q = c - a;
  const Vec3d r = d - a;
  const double qx_ry = q.x * r.y;
  const double qy_rx = q.y * r.x;
  const double rx_py = r.x * p.y;
  const double ry_px = r.y * p.x;
  const double px_qy = p.x * q.y;
  const double py_qx = p.y * q.x;
  const double determinant = p.z * (qx_ry - qy_rx) + q.z * (rx_py - ry_px) + r.z * (px_qy - py_qx);
  const double permanent = std::abs(p.z) * (std::abs(qx_ry) + std::abs(qy_rx)) +
                           std::abs(q.z) * (std::abs(rx_py) + std::abs(ry_px)) +
                           std::abs(r.z) * (std::abs(px_qy) + std::abs(py_qx));
  return decides(determinant, kBound3d * permanent) ? sign(determinant) : exact_orient3d(a, b, c, d);
}

int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis) {
  const std::size_t u = axis == 2 ? 0 : static_cast<std::size_t>(axis) + 1;
  const std::size_t v = axis == 0 ? 2 : static_cast<std::size_t>(axis) - 1;
  const double left = (b[u] - a[u]) * (c[v] - a[v]);
  const double right = (b[v] - a[v]) * (c[u] - a[u]);
  const double determinant = left - right;
  if (decides(determinant, kBound2d * (std::abs(left) + std::abs(right)))) return sign(determinant);
  return minor(difference(b[u], a[u]), difference(b[v], a[v]), difference(c[u], a[u]), difference(c[v], a[v])).sign();
}

namespace {

bool all_negative(const std::array<int, 3>& signs) { return std::max({signs[0], signs[1], signs[2]}) < 0; }
bool all_positive(const std::array<int, 3>& signs) { return std::min({signs[0], signs[1], signs[2]}) > 0; }
bool none_negative(const std::array<int, 3>& signs) { return std::min({signs[0], signs[1], signs[2]}) >= 0; }
bool none_positive(const std::array<int, 3>& signs) { return std::max({signs[0], signs[1], signs[2]}) <= 0; }

int side_of(const Corners& t, const Vec3d& p) { return orient3d(t[0], t[1], t[2], p); }

std::array<int, 3> sides_of(const Corners& t, const Corners& points) {
  return {side_of(t, points[0]), side_of(t, points[1]), side_of(t, points[2])};
}

// A coordinate axis along which the projected triangle has an area, and the orientation of its corners.
struct View {
  int axis = 0;
  int turn = 0;  // 0: there is no such axis
};

View view_of(const Corners& t) {
  for (int axis = 0; axis < 3; ++axis) {
    const int turn = orient2d(t[0], t[1], t[2], axis);
    if (turn != 0) return {axis, turn};
  }
  return {};
}

// Two convex polygons in a plane are disjoint only if the line through an edge of one separates them.
bool meets_in_plane(const Corners& t, const Vec3d& p, const Vec3d& q) {
  const View view = view_of(t);
  const auto turn = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) { return orient2d(a, b, c, view.axis); };
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d& a = t[i];
    const Vec3d& b = t[(i + 1) % 3];
    if (turn(a, b, p) == -view.turn && turn(a, b, q) == -view.turn) return false;
  }
  const std::array<int, 3> turns{turn(p, q, t[0]), turn(p, q, t[1]), turn(p, q, t[2])};
  return !all_positive(turns) && !all_negative(turns);
}

// Returns true if the segment p q meets the triangle. The signs give the sides of its plane where p and q lie.
bool meets(const Corners& t, const Vec3d& p, const Vec3d& q, int p_side, int q_side) {
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) return meets_in_plane(t, p, q);
  const std::array<int, 3> turns{orient3d(p, q, t[0], t[1]), orient3d(p, q, t[1], t[2]), orient3d(p, q, t[2], t[0])};
  return none_negative(turns) || none_positive(turns);
}

// Returns true if an edge of u meets t.
bool an_edge_meets(const Corners& t, const Corners& u, const std::array<int, 3>& u_sides) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (meets(t, u[i], u[j], u_sides[i], u_sides[j])) return true;
  }
  return false;
}

// The coordinate axis in which a normal is longest.
int widest_axis(const Vec3d& normal) {
  const Vec3d size{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  return size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
}

// The coordinate axis along which a triangle shows most of its area, or near to it.
View widest_view_of(const Corners& t) {
  const int axis = widest_axis(cross(t[1] - t[0], t[2] - t[0]));
  return {axis, orient2d(t[0], t[1], t[2], axis)};
}

// Returns true if the line through an edge of t, seen along one axis, has t on one side and all the points beyond it.
// The edges begin at the given corners. Where surfaces are flat this costs far less than exact signs in space.
template <std::size_t Edges, std::size_t Points>
bool separates(const Corners& t, const std::array<std::size_t, Edges>& edges, const std::array<Vec3d, Points>& points) {
  const View view = widest_view_of(t);
  return view.turn != 0 && std::any_of(edges.begin(), edges.end(), [&](std::size_t i) {
           const Vec3d& a = t[i];
           const Vec3d& b = t[(i + 1) % 3];
           return std::all_of(points.begin(), points.end(),
                              [&](const Vec3d& p) { return orient2d(a, b, p, view.axis) == -view.turn; });
         });
}

constexpr std::array<std::size_t, 3> kAllEdges{0, 1, 2};
constexpr std::array<std::size_t, 2> kEdgesAtCorner0{0, 2};

// Returns true if the points surely lie on one side of the plane of t: where surfaces lie above each other, this
// decides without exact signs. The error of a height, n.(p - t[0]) for n = e x f of two edges, is below 16 units
// of rounding of |e| |f| |p - t[0]|; four times that is asked for.
template <std::size_t Points>
bool lie_beside(const Corners& t, const std::array<Vec3d, Points>& points) {
  const Vec3d e = t[1] - t[0];
  const Vec3d f = t[2] - t[0];
  const Vec3d n = cross(e, f);
  const double size2 = norm2(e) * norm2(f);
  int above = 0;
  int below = 0;
  for (const Vec3d& p : points) {
    const Vec3d d = p - t[0];
    const double height = dot(n, d);
    if (!(height * height > 0x1p-94 * size2 * norm2(d))) return false;
    ++(height > 0 ? above : below);
  }
  return above == 0 || below == 0;
}

// Two triangles meet if and only if an edge of one meets the other.
bool meet(const Corners& t, const Corners& u) {
  if (lie_beside(t, u) || lie_beside(u, t)) return false;
  if (separates(t, kAllEdges, u) || separates(u, kAllEdges, t)) return false;
  const std::array<int, 3> u_sides = sides_of(t, u);
  if (all_positive(u_sides) || all_negative(u_sides)) return false;
  const std::array<int, 3> t_sides = sides_of(u, t);
  if (all_positive(t_sides) || all_negative(t_sides)) return false;
  return an_edge_meets(t, u, u_sides) || an_edge_meets(u, t, t_sides);
}

// For triangles that share corner 0: returns true if the opposite edge of one meets the other.
bool meet_beyond_corner(const Corners& t, const Corners& u) {
  if (lie_beside(t, std::array{u[1], u[2]}) || lie_beside(u, std::array{t[1], t[2]})) return false;
  if (separates(t, kEdgesAtCorner0, std::array{u[1], u[2]}) || separates(u, kEdgesAtCorner0, std::array{t[1], t[2]})) {
    return false;  // on the line there is nothing of both but the corner
  }
  const int u1 = side_of(t, u[1]);
  const int u2 = side_of(t, u[2]);
  if (u1 * u2 > 0) return false;  // u is in the plane of t with its corner 0 only
  if (meets(t, u[1], u[2], u1, u2)) return true;
  return meets(u, t[1], t[2], side_of(u, t[1]), side_of(u, t[2]));
}

// For triangles that share corners 0 and 1: returns true if one covers a part of the other.
bool meet_beyond_edge(const Corners& t, const Corners& u) {
  const View view = view_of(t);
  return orient2d(t[0], t[1], u[2], view.axis) == view.turn && side_of(t, u[2]) == 0;
}

// The common corners of t and u: their indices in both.
struct Shared {
  std::size_t count = 0;
  std::array<std::array<std::size_t, 2>, 3> places{};
};

Shared shared_corners(const Triangle& t, const Triangle& u) {
  Shared shared;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (t[i] == u[j]) shared.places[shared.count++] = {i, j};
    }
  }
  return shared;
}

// Returns the corners with the two given ones first. The orientation may change.
Corners beginning_with(std::size_t first, std::size_t second, const Corners& c) {
  return {c[first], c[second], c[3 - first - second]};
}

}  // namespace

bool are_collinear(const Corners& corners) { return view_of(corners).turn == 0; }

bool meet_beyond_shared(const Triangle& t, const Corners& t_corners, const Triangle& u, const Corners& u_corners) {
  const Shared shared = shared_corners(t, u);
  if (shared.count == 0) return meet(t_corners, u_corners);
  if (shared.count == 3) return true;
  const auto [i, j] = shared.places[0];
  if (shared.count == 1) {
    return meet_beyond_corner(beginning_with(i, (i + 1) % 3, t_corners), beginning_with(j, (j + 1) % 3, u_corners));
  }
  const auto [i2, j2] = shared.places[1];
  return meet_beyond_edge(beginning_with(i, i2, t_corners), beginning_with(j, j2, u_corners));
}

namespace {

using Pair = std::array<std::uint32_t, 2>;

// Returns the positions times a power of two: the largest coordinate in use is then from 1 to 2, as predicates.h
// requires.
std::vector<Vec3d> scale_to_range(std::span<const Triangle> triangles, std::span<const Vec3d> positions) {
  double largest = 0;
  for (const Triangle& t : triangles) {
    for (const std::uint32_t v : t) {
      const Vec3d& p = positions[v];
      largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
  }
  const int exponent = largest > 0 ? std::ilogb(largest) : 0;
  const double part = std::scalbn(1.0, -exponent / 2);  // in two parts neither overflows
  const double rest = std::scalbn(1.0, -exponent - -exponent / 2);
  const auto scaled = [&](double x) {
    const double y = x * part * rest;
    return std::abs(y) < 0x1p-250 ? 0.0 : y;
  };
  std::vector<Vec3d> result(positions.size());
  std::transform(positions.begin(), positions.end(), result.begin(), [&](const Vec3d& p) {
    return Vec3d{scaled(p.x), scaled(p.y), scaled(p.z)};
  });
  return result;
}

Corners corners_of(const Triangle& t, std::span<const Vec3d> positions) {
  return {positions[t[0]], positions[t[1]], positions[t[2]]};
}

// The pairs that each chunk of work finds, up to a common limit.
class Findings {
 public:
  Findings(std::size_t chunks, std::size_t limit) : pairs_of_(chunks), limit_(limit) {}

  bool full() const { return count_.load(std::memory_order_relaxed) > limit_; }

  void add(std::size_t chunk, const Pair& pair) {
    pairs_of_[chunk].push_back(pair);
    count_.fetch_add(1, std::memory_order_relaxed);
  }

  SelfIntersections sorted(std::size_t triangles) const {
    if (full()) return {{}, limit_, false};
    SelfIntersections result;
    result.count = count_;
    if (result.count < triangles) {
      for (const std::vector<Pair>& pairs : pairs_of_) {
        result.pairs.insert(result.pairs.end(), pairs.begin(), pairs.end());
      }
      std::sort(result.pairs.begin(), result.pairs.end());
    } else {
      sort_many(triangles, result.pairs);
    }
    return result;
  }

 private:
  // Lays the pairs down by their first triangle, then sorts each triangle's own.
  void sort_many(std::size_t triangles, std::vector<Pair>& sorted) const {
    std::vector<std::size_t> end(triangles + 1, 0);  // of the pairs of each triangle, once they lie there
    for (const std::vector<Pair>& pairs : pairs_of_) {
      for (const Pair& pair : pairs) ++end[pair[0] + 1];
    }
    std::partial_sum(end.begin(), end.end(), end.begin());
    sorted.resize(count_);
    for (const std::vector<Pair>& pairs : pairs_of_) {
      for (const Pair& pair : pairs) sorted[end[pair[0]]++] = pair;
    }
    std::size_t begin = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
      const auto first = sorted.begin();
      std::sort(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end[t]));
      begin = end[t];
    }
  }

  std::vector<std::vector<Pair>> pairs_of_;
  std::size_t limit_;
  std::atomic<std::size_t> count_ = 0;
};

bool is_chosen(std::uint32_t t, const SelfIntersectionOptions& options) {
  return options.chosen == nullptr || (*options.chosen)[t];
}

// Finds the vertices that are flat: seen along a coordinate axis, their triangles lie around them once, side by side.
// Two triangles at a flat vertex are no pair: they meet in what they share. Most vertices of most shapes are flat.
class FlatVertices {
 public:
  // Looks at the vertices of the chosen triangles.
  FlatVertices(std::span<const Triangle> triangles, std::span<const Vec3d> points,
               const SelfIntersectionOptions& options)
      : triangles_(triangles), points_(points), begin_(points.size() + 1), flat_(points.size()) {
    std::vector<std::uint8_t> wanted(points.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      if (!is_chosen(t, options)) continue;
      for (const std::uint32_t v : triangles[t]) wanted[v] = 1;
    }
    std::vector<std::uint32_t> found;  // the triangles at them
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      const Triangle& corners = triangles[t];
      if ((wanted[corners[0]] | wanted[corners[1]] | wanted[corners[2]]) != 0) found.push_back(t);
    }
    const auto for_each_corner = [&](const auto& visit) {
      for (const std::uint32_t t : found) {
        for (std::uint32_t i = 0; i < 3; ++i) {
          if (wanted[triangles[t][i]] != 0) visit(3 * t + i, triangles[t][i]);
        }
      }
    };
    for_each_corner([&](std::uint32_t, std::uint32_t v) { ++begin_[v + std::size_t{1}]; });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    corners_.resize(begin_.back());
    std::vector<std::uint32_t> end(begin_.begin(), begin_.end() - 1);
    for_each_corner([&](std::uint32_t c, std::uint32_t v) { corners_[end[v]++] = c; });
    parallel_for(points.size(), 4096, options.threads, [&](std::size_t first, std::size_t last) {
      stop_if_cancelled(options.progress);
      for (std::size_t v = first; v < last; ++v) flat_[v] = is_flat(static_cast<std::uint32_t>(v)) ? 1 : 0;
    });
  }

  bool is_any(const Triangle& t) const { return flat_[t[0]] + flat_[t[1]] + flat_[t[2]] > 0; }

  // The corners that are flat; for the others kNoName.
  std::array<std::uint32_t, 3> of(const Triangle& t) const {
    const auto name = [&](std::uint32_t v) { return flat_[v] != 0 ? v : BoxTree::kNoName; };
    return {name(t[0]), name(t[1]), name(t[2])};
  }

  bool is_shared(const Triangle& t, const Triangle& u) const {
    return std::any_of(t.begin(), t.end(),
                       [&](std::uint32_t v) { return flat_[v] != 0 && (v == u[0] || v == u[1] || v == u[2]); });
  }

 private:
  static constexpr std::size_t kMaxTriangles = 32;  // triangles at a vertex that are looked at

  // Goes round the vertex from triangle to triangle, which all must turn the same way. Each full turn passes once from
  // one side of a line through the vertex to the other, and once back.
  bool is_flat(std::uint32_t v) const {
    const std::size_t count = begin_[v + std::size_t{1}] - begin_[v];
    if (count < 3 || count > kMaxTriangles) return false;
    std::array<std::array<std::uint32_t, 2>, kMaxTriangles> sides{};  // the other corners of each triangle
    Vec3d normal{};
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t c = corners_[begin_[v] + i];
      const Triangle& t = triangles_[c / 3];
      sides[i] = {t[(c + 1) % 3], t[(c + 2) % 3]};
      normal += cross(points_[sides[i][0]] - points_[v], points_[sides[i][1]] - points_[v]);
    }
    const int axis = widest_axis(normal);
    const int turn = normal[static_cast<std::size_t>(axis)] > 0 ? 1 : -1;
    const std::size_t height = axis == 2 ? 0 : static_cast<std::size_t>(axis) + 1;
    const auto is_below = [&](std::uint32_t w) { return points_[w][height] < points_[v][height]; };
    std::size_t at = 0;
    int rises = 0;
    for (std::size_t step = 1; step <= count; ++step) {
      const auto [from, to] = sides[at];
      if (orient2d(points_[v], points_[from], points_[to], axis) != turn) return false;
      rises += is_below(from) && !is_below(to) ? 1 : 0;
      for (at = 0; at < count && sides[at][0] != to;) ++at;
      const bool is_round = at == 0;  // each triangle has been met once if that is so after as many steps as there are
      if (at == count || is_round != (step == count)) return false;
    }
    return rises == 1;
  }

  std::span<const Triangle> triangles_;
  std::span<const Vec3d> points_;
  std::vector<std::uint32_t> begin_;    // of each vertex, in corners_
  std::vector<std::uint32_t> corners_;  // 3 t + i: corner i of triangle t
  std::vector<std::uint8_t> flat_;
};

struct Sorted {
  std::vector<std::uint32_t> degenerate;  // of the chosen ones
  std::vector<std::uint32_t> chosen;
  std::vector<std::uint32_t> others;
};

Sorted sort_triangles(std::span<const Triangle> triangles, std::span<const Vec3d> points, const FlatVertices& flat,
                      const SelfIntersectionOptions& options) {
  Sorted sorted;
  sorted.chosen.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    stop_if_cancelled(options.progress);
    if (!is_chosen(t, options)) {
      sorted.others.push_back(t);
    } else {
      const bool has_area = flat.is_any(triangles[t]) || !are_collinear(corners_of(triangles[t], points));
      (has_area ? sorted.chosen : sorted.degenerate).push_back(t);
    }
  }
  return sorted;
}

}  // namespace

SelfIntersections self_intersections(std::span<const Triangle> triangles, std::span<const Vec3d> positions,
                                     const SelfIntersectionOptions& options) {
  check_triangles(triangles, positions);
  const std::vector<Vec3d> points = scale_to_range(triangles, positions);
  const FlatVertices flat(triangles, points, options);
  const Sorted sorted = sort_triangles(triangles, points, flat, options);
  stop_if_cancelled(options.progress);
  BoxTree tree(triangles, points, sorted.chosen, options.threads);
  tree.set_names([&](std::uint32_t t) { return flat.of(triangles[t]); }, options.threads);
  constexpr std::size_t grain = 4096;  // triangles
  const std::size_t first_part = 2 + sorted.others.size() / grain;
  Findings findings(first_part + tree.part_count(), options.limit);
  for (const std::uint32_t t : sorted.degenerate) findings.add(0, {t, t});
  // Returns whether to go on.
  const auto look_at = [&](std::size_t chunk, std::uint32_t t, std::uint32_t u) {
    const Triangle& a = triangles[t];
    const Triangle& b = triangles[u];
    if (meet_beyond_shared(a, corners_of(a, points), b, corners_of(b, points))) {
      findings.add(chunk, {std::min(t, u), std::max(t, u)});
    }
    return !findings.full();
  };
  parallel_for(sorted.others.size(), grain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !findings.full(); ++i) {
      stop_if_cancelled(options.progress);
      const std::uint32_t t = sorted.others[i];
      const Corners corners = corners_of(triangles[t], points);
      tree.for_each_overlap_with(tree.box_of(corners), [&](std::uint32_t u) {
        if (flat.is_shared(triangles[t], triangles[u])) return true;
        return !are_collinear(corners) && look_at(1 + begin / grain, t, u);  // without area it is in no pair
      });
    }
  });
  parallel_for(tree.part_count(), 1, options.threads, [&](std::size_t part, std::size_t) {
    stop_if_cancelled(options.progress);
    if (findings.full()) return;
    tree.for_each_overlap(part, [&](std::uint32_t t, std::uint32_t u) { return look_at(first_part + part, t, u); });
  });
  return findings.sorted(triangles.size());
}

std::size_t count_new(const SelfIntersections& now, const SelfIntersections& before) {
  if (!now.complete || !before.complete) return now.count;
  return static_cast<std::size_t>(std::count_if(now.pairs.begin(), now.pairs.end(), [&](const auto& pair) {
    return !std::binary_search(before.pairs.begin(), before.pairs.end(), pair);
  }));
}

}  // namespace knead
