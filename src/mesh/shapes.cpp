// The procedural shapes: those made of regular grids, and the polygonised ones (figures.cpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/polygonise.h"

namespace knead {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;

std::size_t rounded(double x, std::size_t min = 1) {
  return std::max(min, static_cast<std::size_t>(std::fmax(0, std::floor(x + 0.5))));
}

double ratio(std::size_t a, std::size_t b) { return static_cast<double>(a) / static_cast<double>(b); }

void add_triangle(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c) {
  mesh.add_face(
      std::array{static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
}

// Adds the quadrilateral a, b, c, d as two triangles, split along the shorter diagonal.
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

constexpr double kGolden = 1.6180339887498948482;
constexpr std::array<Vec3d, 12> kIcosahedronCorners{{{-1, kGolden, 0},
                                                     {1, kGolden, 0},
                                                     {-1, -kGolden, 0},
                                                     {1, -kGolden, 0},
                                                     {0, -1, kGolden},
                                                     {0, 1, kGolden},
                                                     {0, -1, -kGolden},
                                                     {0, 1, -kGolden},
                                                     {kGolden, 0, -1},
                                                     {kGolden, 0, 1},
                                                     {-kGolden, 0, -1},
                                                     {-kGolden, 0, 1}}};
constexpr std::array<std::array<std::size_t, 3>, 20> kIcosahedronFaces{
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

// The icosahedron with every edge cut into n parts; vertices are made at their first use.
class Geodesic {
 public:
  explicit Geodesic(std::size_t n) : n_(n) {
    for (const Vec3d& p : kIcosahedronCorners) mesh_.positions.push_back(normalized(p));
    edge_start_.fill(0);
  }

  Mesh make() {
    for (const auto& face : kIcosahedronFaces) add_face(face);
    return std::move(mesh_);
  }

 private:
  // Returns the k-th of the n + 1 vertices from corner a to corner b.
  std::size_t on_edge(std::size_t a, std::size_t b, std::size_t k) {
    if (k == 0) return a;
    if (k == n_) return b;
    if (a > b) return on_edge(b, a, n_ - k);
    std::size_t& start = edge_start_[12 * a + b];
    if (start == 0) {
      start = mesh_.vertex_count();
      for (std::size_t i = 1; i < n_; ++i)
        add_vertex(kIcosahedronCorners[a], kIcosahedronCorners[b], kIcosahedronCorners[b], i, 0);
    }
    return start + k - 1;
  }

  void add_vertex(const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t i, std::size_t j) {
    const double n = static_cast<double>(n_);
    const double u = static_cast<double>(i) / n;
    const double v = static_cast<double>(j) / n;
    mesh_.positions.push_back(normalized(a * (1 - u - v) + b * u + c * v));
  }

  void add_face(const std::array<std::size_t, 3>& face) {
    const auto [a, b, c] = face;
    std::vector<std::size_t> below;
    for (std::size_t i = 0; i <= n_; ++i) below.push_back(on_edge(a, b, i));
    for (std::size_t j = 1; j <= n_; ++j) {
      std::vector<std::size_t> row{on_edge(a, c, j)};
      for (std::size_t i = 1; i + j < n_; ++i) {
        row.push_back(mesh_.vertex_count());
        add_vertex(kIcosahedronCorners[a], kIcosahedronCorners[b], kIcosahedronCorners[c], i, j);
      }
      if (j < n_) row.push_back(on_edge(b, c, j));
      for (std::size_t i = 0; i < row.size(); ++i) {
        add_triangle(mesh_, below[i], below[i + 1], row[i]);
        if (i + 1 < row.size()) add_triangle(mesh_, below[i + 1], row[i + 1], row[i]);
      }
      below = std::move(row);
    }
  }

  std::size_t n_;
  Mesh mesh_;
  std::array<std::size_t, 144> edge_start_{};  // 0: not made yet
};

Mesh make_sphere(std::size_t vertices) {
  const double frequency = std::sqrt((static_cast<double>(vertices) - 2) / 10);
  std::size_t n = static_cast<std::size_t>(frequency);
  const auto excess = [&](std::size_t k) {
    return std::abs(10.0 * static_cast<double>(k * k) + 2 - static_cast<double>(vertices));
  };
  if (excess(n + 1) < excess(n)) ++n;
  return Geodesic(n).make();
}

// The bar and the crater: both deform the surface of a block of cubes.

using GridPoint = std::array<std::size_t, 3>;

// The surface of a block of unit cubes. Each square is split into two triangles along alternating diagonals; vertices
// have integer coordinates and are numbered at their first use.
class BoxSurface {
 public:
  explicit BoxSurface(const GridPoint& size) : size_(size) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (const std::size_t side : {std::size_t{0}, size[a]}) {
        numbers_[a][side == 0 ? 0 : 1].resize((size[next(a)] + 1) * (size[next(next(a))] + 1), kNone);
      }
    }
  }

  Mesh make() {
    for (std::size_t a = 0; a < 3; ++a) {
      for (const std::size_t side : {std::size_t{0}, size_[a]}) add_side(a, side);
    }
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::size_t next(std::size_t a) { return (a + 1) % 3; }

  // The first side that contains the vertex stores its number.
  std::size_t vertex(const GridPoint& p) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (p[a] != 0 && p[a] != size_[a]) continue;
      const std::size_t b = next(a);
      std::uint32_t& number = numbers_[a][p[a] == 0 ? 0 : 1][p[next(b)] * (size_[b] + 1) + p[b]];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(mesh_.vertex_count());
        mesh_.positions.emplace_back(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
      }
      return number;
    }
    return kNone;
  }

  void add_side(std::size_t a, std::size_t side) {
    const std::size_t b = side == 0 ? next(next(a)) : next(a);  // a, b, c are ordered so that the side faces outward
    const std::size_t c = 3 - a - b;
    for (std::size_t j = 0; j < size_[c]; ++j) {
      for (std::size_t i = 0; i < size_[b]; ++i) {
        const auto corner = [&](std::size_t di, std::size_t dj) {
          GridPoint p{};
          p[a] = side;
          p[b] = i + di;
          p[c] = j + dj;
          return vertex(p);
        };
        const std::array q{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
        const std::size_t s = (i + j) % 2;
        add_triangle(mesh_, q[s], q[s + 1], q[s + 2]);
        add_triangle(mesh_, q[s], q[s + 2], q[(s + 3) % 4]);
      }
    }
  }

  GridPoint size_;
  Mesh mesh_;
  std::array<std::array<std::vector<std::uint32_t>, 2>, 3> numbers_;
};

// Returns a pseudo-random value from 0 to 1 for a point of the integer grid.
double lattice_value(std::int64_t x, std::int64_t y, std::uint32_t octave) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343U ^ static_cast<std::uint32_t>(y) * 0xd8163841U;
  h = (h ^ (octave * 0xcb1ab31fU)) * 0x9e3779b1U;
  h = (h ^ (h >> 15)) * 0x85ebca6bU;
  h = (h ^ (h >> 13)) * 0xc2b2ae35U;
  return static_cast<double>(h ^ (h >> 16)) / 4294967295.0;
}

double smooth(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

// Returns value noise, from -1 to 1: smoothly interpolated values of the grid.
double noise(double x, double y, std::uint32_t octave) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx);
  const auto iy = static_cast<std::int64_t>(fy);
  const double u = smooth(x - fx);
  const double v = smooth(y - fy);
  const double low = lattice_value(ix, iy, octave) * (1 - u) + lattice_value(ix + 1, iy, octave) * u;
  const double high = lattice_value(ix, iy + 1, octave) * (1 - u) + lattice_value(ix + 1, iy + 1, octave) * u;
  return 2 * (low * (1 - v) + high * v) - 1;
}

double bump(double t) { return 1 / ((1 + t * t) * (1 + t * t)); }

// Returns the height of the ground: a bowl of radius 2, its rim, a central peak, and hills.
double crater_height(double x, double y) {
  const double r = std::sqrt(x * x + y * y) + 0.12 * noise(0.9 * x, 0.9 * y, 7);
  const double t = r / 2.0;
  const double bowl = t < 1 ? -0.75 * (1 - t * t) * (1 - t * t) * (1 + 2 * t * t) : 0;
  const double rim = 0.38 * bump((r - 2.05) / 0.55);
  const double peak = 0.42 * bump(r / 0.45);
  double ground = 0;
  double size = 0.09;
  double frequency = 0.6;
  for (std::uint32_t octave = 0; octave < 4; ++octave, size *= 0.5, frequency *= 2) {
    ground += size * noise(frequency * x, frequency * y, octave);
  }
  return bowl + rim + peak + ground;
}

// 4 l m + 2 m^2 + 2 vertices for l x m x m squares; the squares are closest to square for l = 6 m.
Mesh make_box(std::size_t vertices) {
  const double wish = static_cast<double>(vertices) - 2;
  const std::size_t m = rounded(std::sqrt(wish / 26));
  const double across = static_cast<double>(m);
  const std::size_t l = rounded((wish - 2 * across * across) / (4 * across));
  Mesh mesh = BoxSurface({l, m, m}).make();
  for (Vec3d& p : mesh.positions) {
    p = {p.x / static_cast<double>(l) * 6 - 3, p.y / across - 0.5, p.z / across - 0.5};
  }
  return mesh;
}

// n x n squares above and below, h squares high: 2 n^2 + 4 n h + 2 vertices, with h about 0.15 n.
Mesh make_crater(std::size_t vertices) {
  constexpr double kDepth = 1.5;
  const double wish = static_cast<double>(vertices) - 2;
  const std::size_t n = rounded(std::sqrt(wish / 2.6));
  const double across = static_cast<double>(n);
  const std::size_t h = rounded((wish - 2 * across * across) / (4 * across));
  Mesh mesh = BoxSurface({n, n, h}).make();
  for (Vec3d& p : mesh.positions) {
    const double x = p.x / across * 10 - 5;
    const double y = p.y / across * 10 - 5;
    const double up = p.z / static_cast<double>(h);
    p = {x, y, -kDepth + up * (kDepth + crater_height(x, y))};
  }
  return mesh;
}

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
      const auto [s, c] = sincos(kFullTurn * ratio(j, around));
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
  const std::size_t around = rounded(std::sqrt(wish * kFullTurn * radius / length), 4);
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
    lengths.push_back(lengths.back() +
                      norm(knot_point(kFullTurn * ratio(i + 1, n)) - knot_point(kFullTurn * ratio(i, n))));
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
    parameters.push_back(kFullTurn * (static_cast<double>(k) + within) / static_cast<double>(n));
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
      const auto [s, c] = sincos(kFullTurn * ratio(i, 6 * k));
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

Mesh make_cylinder(std::size_t vertices) {
  const CylinderGrid grid = cylinder_grid(vertices);
  const std::size_t around = 6 * grid.rings;
  Mesh mesh;
  for (std::size_t row = 0; row <= grid.rows; ++row) {
    for (std::size_t i = 0; i < around; ++i) {
      const auto [s, c] = sincos(kFullTurn * ratio(i, around));
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
  const TubeGrid grid = tube_grid(vertices, kFullTurn, 0.3);
  Spine spine;
  for (std::size_t i = 0; i < grid.along; ++i) {
    const auto [s, c] = sincos(kFullTurn * ratio(i, grid.along));
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

constexpr std::array<std::string_view, 9> kShapeNames{"sphere", "box",  "cylinder", "torus", "hand",
                                                      "crater", "knot", "letter-y", "figure"};
constexpr std::size_t kMaxShapeVertices = 20'000'000;
constexpr std::array<ShapeCounts, 9> kShapeCounts{{{12, 10'242, kMaxShapeVertices},
                                                   {28, 10'000, kMaxShapeVertices},
                                                   {100, 10'000, kMaxShapeVertices},
                                                   {60, 10'000, kMaxShapeVertices},
                                                   {4'000, 36'000, kMaxShapeVertices},
                                                   {100, 40'000, kMaxShapeVertices},
                                                   {600, 20'000, kMaxShapeVertices},
                                                   {1'000, 20'000, kMaxShapeVertices},
                                                   {4'000, 30'000, kMaxShapeVertices}}};

// Searches for the cell size that gives this number of vertices, by counting the vertices of unrelaxed surfaces; then
// makes the surface.
Mesh make_solid(const Solid& solid, std::size_t vertices) {
  const double wish = static_cast<double>(vertices);
  PolygoniseOptions options{std::sqrt(1.39 * solid.area / wish), 1, 0};
  for (int i = 0; i < 8; ++i) {
    const double count = static_cast<double>(polygonise(solid.distance, solid.box, options).vertex_count());
    if (std::abs(count / wish - 1) < 0.04) break;
    options.cell *= std::sqrt(count / wish);
  }
  options.relaxations = 8;
  return polygonise(solid.distance, solid.box, options);
}

Mesh make_kind(ShapeKind kind, std::size_t vertices) {
  switch (kind) {
    case ShapeKind::sphere:
      return make_sphere(vertices);
    case ShapeKind::box:
      return make_box(vertices);
    case ShapeKind::cylinder:
      return make_cylinder(vertices);
    case ShapeKind::torus:
      return make_torus(vertices);
    case ShapeKind::hand:
      return make_solid(hand_solid(), vertices);
    case ShapeKind::crater:
      return make_crater(vertices);
    case ShapeKind::knot:
      return make_knot(vertices);
    case ShapeKind::figure:
      return make_solid(figure_solid(), vertices);
    case ShapeKind::letter_y:
      break;
  }
  return make_solid(letter_y_solid(), vertices);
}

}  // namespace

std::span<const std::string_view> shape_names() { return kShapeNames; }

ShapeKind shape_kind(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kShapeNames.size(); ++i) {
    if (kShapeNames[i] == name) return static_cast<ShapeKind>(i);
    known += (i == 0 ? "" : ", ") + std::string(kShapeNames[i]);
  }
  throw InvalidInput("there is no shape '" + std::string(name) + "'; choose one of " + known);
}

ShapeCounts shape_counts(ShapeKind kind) { return kShapeCounts[static_cast<std::size_t>(kind)]; }

Mesh make_shape(ShapeKind kind, std::size_t vertices) {
  const ShapeCounts counts = shape_counts(kind);
  if (vertices == 0) vertices = counts.standard;
  if (vertices < counts.minimum || vertices > counts.maximum) {
    throw InvalidInput("a " + std::string(kShapeNames[static_cast<std::size_t>(kind)]) + " of " +
                       std::to_string(vertices) + " vertices cannot be made; ask for " +
                       std::to_string(counts.minimum) + " to " + std::to_string(counts.maximum));
  }
  return make_kind(kind, vertices);
}

}  // namespace knead
