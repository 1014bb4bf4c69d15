// The shapes with rings: cylinder, torus, knot.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "knead/math/sincos.h"
#include "knead/mesh/shapes_grids.h"

namespace knead::shapes_detail {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::size_t rounded(double x, std::size_t least) {
  return std::max(least, static_cast<std::size_t>(std::fmax(0, std::floor(x + 0.5))));
}

double ratio(std::size_t a, std::size_t b) { return static_cast<double>(a) / static_cast<double>(b); }

// A closed curve with two unit vectors orthogonal to it at each point.
struct Spine {
  std::vector<Vec3d> points;
  std::vector<Vec3d> first;
  std::vector<Vec3d> second;
};

// Returns the tube of the given radius about a spine, with `around` vertices in each ring.
Mesh tube(const Spine& spine, std::size_t around, double radius) {
  Mesh mesh;
  const std::size_t along = spine.points.size();
  for (std::size_t i = 0; i < along; ++i) {
    for (std::size_t j = 0; j < around; ++j) {
      const auto [s, c] = sincos(kTurn * ratio(j, around));
      mesh.positions.push_back(spine.points[i] + (spine.first[i] * c + spine.second[i] * s) * radius);
    }
  }
  for (std::size_t i = 0; i < along; ++i) {
    const std::size_t here = i * around;
    const std::size_t there = (i + 1) % along * around;
    for (std::size_t j = 0; j < around; ++j) {
      const std::size_t k = (j + 1) % around;
      add_quad(mesh, here + j, here + k, there + k, there + j);
    }
  }
  return mesh;
}

// The numbers of vertices along and around a tube that make its quadrilaterals about square.
struct TubeGrid {
  std::size_t along;
  std::size_t around;
};
TubeGrid tube_grid(std::size_t vertices, double length, double radius) {
  const double wish = static_cast<double>(vertices);
  const std::size_t around = rounded(std::sqrt(wish * kTurn * radius / length), 4);
  return {rounded(wish / static_cast<double>(around), 3), around};
}

Vec3d knot_point(double t) {
  const auto [s2, c2] = sincos(2 * t);
  const auto [s3, c3] = sincos(3 * t);
  return {(2 + c3) * c2, (2 + c3) * s2, s3};
}

Vec3d knot_tangent(double t) {
  const auto [s2, c2] = sincos(2 * t);
  const auto [s3, c3] = sincos(3 * t);
  return normalized(Vec3d{-3 * s3 * c2 - 2 * (2 + c3) * s2, -3 * s3 * s2 + 2 * (2 + c3) * c2, 3 * c3});
}

// Returns the lengths of the knot from t = 0 to each of n + 1 parameters, by chords.
std::vector<double> knot_lengths(std::size_t n) {
  std::vector<double> lengths{0};
  for (std::size_t i = 0; i < n; ++i) {
    lengths.push_back(lengths.back() + norm(knot_point(kTurn * ratio(i + 1, n)) - knot_point(kTurn * ratio(i, n))));
  }
  return lengths;
}

// Returns the parameters of `count` points evenly spaced along the knot.
std::vector<double> even_parameters(const std::vector<double>& lengths, std::size_t count) {
  std::vector<double> parameters;
  const std::size_t n = lengths.size() - 1;
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double length = lengths.back() * ratio(i, count);
    while (lengths[k + 1] < length) ++k;
    const double within = (length - lengths[k]) / (lengths[k + 1] - lengths[k]);
    parameters.push_back(kTurn * (static_cast<double>(k) + within) / static_cast<double>(n));
  }
  return parameters;
}

// Returns v transported from one point of a curve to the next without rotation about the curve, by two reflections
// (Wang, Juettler, Zheng and Liu 2008).
Vec3d carried(const Vec3d& v, const Vec3d& step, const Vec3d& tangent, const Vec3d& next_tangent) {
  const auto reflected = [](const Vec3d& u, const Vec3d& n) { return u - n * (2 * dot(u, n) / norm2(n)); };
  return reflected(reflected(v, step), next_tangent - reflected(tangent, step));
}

// Returns the angle of the unit vector (c, s), from -pi to pi. Each round makes the error smaller than its cube. It
// calls only sincos, which gives the same bits everywhere.
double angle_of(double c, double s) {
  double angle = 0;
  for (int i = 0; i < 40; ++i) {
    const auto turned = sincos(angle);
    angle += s * turned.cos - c * turned.sin;
  }
  return angle;
}

// Transported frames do not close by themselves; the missing angle is spread evenly over the curve.
Spine knot_spine(const std::vector<double>& parameters) {
  const std::size_t n = parameters.size();
  Spine spine;
  std::vector<Vec3d> tangents;
  for (const double t : parameters) {
    spine.points.push_back(knot_point(t));
    tangents.push_back(knot_tangent(t));
  }
  std::vector<Vec3d> frames{any_orthogonal(tangents[0])};
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    frames.push_back(carried(frames[i], spine.points[j] - spine.points[i], tangents[i], tangents[j]));
  }
  const double missing = angle_of(dot(frames[n], frames[0]), dot(cross(frames[n], frames[0]), tangents[0]));
  for (std::size_t i = 0; i < n; ++i) {
    const auto [s, c] = sincos(missing * ratio(i, n));
    const Vec3d across = cross(tangents[i], frames[i]);
    spine.first.push_back(frames[i] * c + across * s);
    spine.second.push_back(across * c - frames[i] * s);
  }
  return spine;
}

struct CylinderGrid {
  std::size_t rings;  // around the centre of a cap; the cap has 6 * rings vertices at its rim
  std::size_t rows;   // along the side
};

// The rows follow from the rings. In all 6 m (rows + 1) + 2 (1 + 3 m (m - 1)) vertices.
CylinderGrid cylinder_grid(std::size_t vertices) {
  const double wish = static_cast<double>(vertices);
  const double side = 36 / std::numbers::pi;  // rows for each ring that make squares: 6 / (pi / 6 m)
  const std::size_t m = rounded(std::sqrt(wish / (6 * side + 6)), 1);
  const double rings = static_cast<double>(m);
  const double caps = 2 + 6 * rings * (rings - 1);
  return {m, rounded((wish - caps) / (6 * rings) - 1, 1)};
}

constexpr double kCylinderRadius = 0.5;

// Adds six sectors of a disk at z = height. Ring k has 6 k vertices; those of the outermost begin at `rim`.
void add_cap(Mesh& mesh, std::size_t rings, double height, std::size_t rim, bool up) {
  std::vector<std::size_t> start{mesh.vertex_count()};
  mesh.positions.emplace_back(0, 0, height);
  for (std::size_t k = 1; k < rings; ++k) {
    start.push_back(mesh.vertex_count());
    for (std::size_t i = 0; i < 6 * k; ++i) {
      const auto [s, c] = sincos(kTurn * ratio(i, 6 * k));
      mesh.positions.push_back(Vec3d{c, s, 0} * (kCylinderRadius * ratio(k, rings)) + Vec3d{0, 0, height});
    }
  }
  start.push_back(rim);
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) { add_triangle(mesh, a, up ? b : c, up ? c : b); };
  for (std::size_t k = 1; k <= rings; ++k) {
    const auto inner = [&](std::size_t i) { return k == 1 ? start[0] : start[k - 1] + i % (6 * (k - 1)); };
    const auto outer = [&](std::size_t i) { return start[k] + i % (6 * k); };
    for (std::size_t sector = 0; sector < 6; ++sector) {
      const std::size_t o = sector * k;
      const std::size_t n = sector * (k - 1);
      for (std::size_t i = 0; i < k; ++i) {
        add(inner(n + i), outer(o + i), outer(o + i + 1));
        if (i + 1 < k) add(inner(n + i), outer(o + i + 1), inner(n + i + 1));
      }
    }
  }
}

}  // namespace

void add_triangle(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c) {
  mesh.add_face(
      std::array{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
}

void add_quad(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
  const auto& p = mesh.positions;
  if (norm2(p[c] - p[a]) <= norm2(p[d] - p[b])) {
    add_triangle(mesh, a, b, c);
    add_triangle(mesh, a, c, d);
  } else {
    add_triangle(mesh, b, c, d);
    add_triangle(mesh, b, d, a);
  }
}

Mesh make_cylinder(std::size_t vertices) {
  const CylinderGrid grid = cylinder_grid(vertices);
  const std::size_t around = 6 * grid.rings;
  Mesh mesh;
  for (std::size_t row = 0; row <= grid.rows; ++row) {
    for (std::size_t i = 0; i < around; ++i) {
      const auto [s, c] = sincos(kTurn * ratio(i, around));
      mesh.positions.emplace_back(kCylinderRadius * c, kCylinderRadius * s, 6 * ratio(row, grid.rows) - 3);
    }
  }
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t i = 0; i < around; ++i) {
      const std::size_t k = (i + 1) % around;
      const std::size_t here = row * around;
      add_quad(mesh, here + i, here + k, here + around + k, here + around + i);
    }
  }
  add_cap(mesh, grid.rings, -3, 0, false);
  add_cap(mesh, grid.rings, 3, grid.rows * around, true);
  return mesh;
}

Mesh make_torus(std::size_t vertices) {
  const TubeGrid grid = tube_grid(vertices, kTurn, 0.3);
  Spine spine;
  for (std::size_t i = 0; i < grid.along; ++i) {
    const auto [s, c] = sincos(kTurn * ratio(i, grid.along));
    spine.points.emplace_back(c, s, 0);
    spine.first.emplace_back(c, s, 0);
    spine.second.emplace_back(0, 0, -1);
  }
  return tube(spine, grid.around, 0.3);
}

Mesh make_knot(std::size_t vertices) {
  const std::vector<double> lengths = knot_lengths(4096);
  const TubeGrid grid = tube_grid(vertices, lengths.back(), 0.45);
  return tube(knot_spine(even_parameters(lengths, grid.along)), grid.around, 0.45);
}

}  // namespace knead::shapes_detail
