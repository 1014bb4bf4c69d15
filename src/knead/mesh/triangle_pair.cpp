#include "knead/mesh/triangle_pair.h"

#include <algorithm>
#include <cmath>

#include "knead/mesh/predicates.h"

namespace knead {
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

// The coordinate axis along which a triangle shows most of its area, or near to it.
View widest_view_of(const Corners& t) {
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  const Vec3d size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
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

}  // namespace knead
