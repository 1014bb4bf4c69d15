// Exact orientation tests by adaptive precision, and exact tests of triangles by their signs.
#include "mesh/predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace knead {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon() / 2;  // the largest relative error of one rounding
constexpr double kBound2d = (3 + 16 * kEpsilon) * kEpsilon;              // Shewchuk's ccwerrboundA
constexpr double kBound3d = (7 + 56 * kEpsilon) * kEpsilon;              // Shewchuk's o3derrboundA

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

// Returns true if a determinant with an error of at most `bound` has the right sign. The bound is 0 only if all
// products are 0. It is not finite if a coordinate is not, or if products are too large for exact numbers.
bool decides(double determinant, double bound) {
  return std::abs(determinant) > bound || bound == 0 || !std::isfinite(bound);
}

int sign(double x) { return static_cast<int>(x > 0) - static_cast<int>(x < 0); }

bool all_negative(const std::array<int, 3>& signs) { return std::max({signs[0], signs[1], signs[2]}) < 0; }
bool all_positive(const std::array<int, 3>& signs) { return std::min({signs[0], signs[1], signs[2]}) > 0; }
bool none_negative(const std::array<int, 3>& signs) { return std::min({signs[0], signs[1], signs[2]}) >= 0; }
bool none_positive(const std::array<int, 3>& signs) { return std::max({signs[0], signs[1], signs[2]}) <= 0; }

int side_of(const Corners& t, const Vec3d& p) { return orient3d(t[0], t[1], t[2], p); }

std::array<int, 3> sides_of(const Corners& t, const Corners& points) {
  return {side_of(t, points[0]), side_of(t, points[1]), side_of(t, points[2])};
}

// A coordinate axis along which the projected triangle has an area, and the orientation of its corners.
struct Projection {
  int axis = 0;
  int turn = 0;  // 0: there is no such axis
};

Projection projection_of(const Corners& t) {
  for (int axis = 0; axis < 3; ++axis) {
    const int turn = orient2d(t[0], t[1], t[2], axis);
    if (turn != 0) return {axis, turn};
  }
  return {};
}

// Two convex polygons in a plane are disjoint only if the line through an edge of one separates them.
bool meets_in_plane(const Corners& t, const Vec3d& p, const Vec3d& q) {
  const Projection view = projection_of(t);
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

// Returns the projection in which the triangle has the largest area, to rounding.
Projection widest_projection_of(const Corners& t) {
  const int axis = widest_axis(cross(t[1] - t[0], t[2] - t[0]));
  return {axis, orient2d(t[0], t[1], t[2], axis)};
}

// Returns true if the line through one of the edges, seen along one axis, separates t from all the points. The edges
// begin at the given corners. Where surfaces are flat, this costs far less than exact signs in space.
template <std::size_t Edges, std::size_t Points>
bool separates(const Corners& t, const std::array<std::size_t, Edges>& edges, const std::array<Vec3d, Points>& points) {
  const Projection view = widest_projection_of(t);
  return view.turn != 0 && std::any_of(edges.begin(), edges.end(), [&](std::size_t i) {
           const Vec3d& a = t[i];
           const Vec3d& b = t[(i + 1) % 3];
           return std::all_of(points.begin(), points.end(),
                              [&](const Vec3d& p) { return orient2d(a, b, p, view.axis) == -view.turn; });
         });
}

constexpr std::array<std::size_t, 3> kAllEdges{0, 1, 2};
constexpr std::array<std::size_t, 2> kEdgesAtCorner0{0, 2};

// Returns true if the points certainly lie on one side of the plane of t. Where surfaces lie above each other, this
// decides without exact signs. The error of a height, n.(p - t[0]) for n = e x f of two edges, is below 16 units of
// rounding of |e| |f| |p - t[0]|; the test requires four times that.
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
    return false;  // on the line they have only the corner in common
  }
  const int u1 = side_of(t, u[1]);
  const int u2 = side_of(t, u[2]);
  if (u1 * u2 > 0) return false;  // u is in the plane of t with its corner 0 only
  if (meets(t, u[1], u[2], u1, u2)) return true;
  return meets(u, t[1], t[2], side_of(u, t[1]), side_of(u, t[2]));
}

// For triangles that share corners 0 and 1: returns true if one covers a part of the other.
bool meet_beyond_edge(const Corners& t, const Corners& u) {
  const Projection view = projection_of(t);
  return orient2d(t[0], t[1], u[2], view.axis) == view.turn && side_of(t, u[2]) == 0;
}

// The common corners of t and u: their indices in both.
struct SharedCorners {
  std::size_t count = 0;
  std::array<std::array<std::size_t, 2>, 3> indices{};
};

SharedCorners shared_corners(const Triangle& t, const Triangle& u) {
  SharedCorners shared;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (t[i] == u[j]) shared.indices[shared.count++] = {i, j};
    }
  }
  return shared;
}

// Returns the corners with the two given ones first. The orientation may change.
Corners beginning_with(std::size_t first, std::size_t second, const Corners& c) {
  return {c[first], c[second], c[3 - first - second]};
}

}  // namespace

int widest_axis(const Vec3d& normal) {
  const Vec3d size{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
  return size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
}

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

bool are_collinear(const Corners& corners) { return projection_of(corners).turn == 0; }

bool meet_beyond_shared(const Triangle& t, const Corners& t_corners, const Triangle& u, const Corners& u_corners) {
  const SharedCorners shared = shared_corners(t, u);
  if (shared.count == 0) return meet(t_corners, u_corners);
  if (shared.count == 3) return true;
  const auto [i, j] = shared.indices[0];
  if (shared.count == 1) {
    return meet_beyond_corner(beginning_with(i, (i + 1) % 3, t_corners), beginning_with(j, (j + 1) % 3, u_corners));
  }
  const auto [i2, j2] = shared.indices[1];
  return meet_beyond_edge(beginning_with(i, i2, t_corners), beginning_with(j, j2, u_corners));
}

}  // namespace knead
