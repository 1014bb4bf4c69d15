#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "mesh/polygonise.h"
#include "mesh/solids.h"

namespace knead::shapes_detail {
namespace {

constexpr double kGolden = 1.6180339887498948482;
constexpr std::array<Vec3d, 12> kCorners{{{-1, kGolden, 0},
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
constexpr std::array<std::array<std::size_t, 3>, 20> kFaces{
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

// The icosahedron with every edge cut into n parts; vertices are made at their first use.
class Geodesic {
 public:
  explicit Geodesic(std::size_t n) : n_(n) {
    for (const Vec3d& p : kCorners) mesh_.positions.push_back(normalized(p));
    edge_start_.fill(0);
  }

  Mesh make() {
    for (const auto& face : kFaces) add_face(face);
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
      for (std::size_t i = 1; i < n_; ++i) add_vertex(kCorners[a], kCorners[b], kCorners[b], i, 0);
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
        add_vertex(kCorners[a], kCorners[b], kCorners[c], i, j);
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

}  // namespace

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

namespace {

using Place = std::array<std::size_t, 3>;

// The vertices on the surface of a grid, numbered at their first use.
class BoxSurface {
 public:
  explicit BoxSurface(const Place& size) : size_(size) {
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
  std::size_t vertex(const Place& p) {
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
          Place p{};
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

  Place size_;
  Mesh mesh_;
  std::array<std::array<std::vector<std::uint32_t>, 2>, 3> numbers_;
};

std::size_t rounded(double x) { return static_cast<std::size_t>(std::fmax(1, std::floor(x + 0.5))); }

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

}  // namespace

Mesh box_surface(std::size_t nx, std::size_t ny, std::size_t nz) { return BoxSurface({nx, ny, nz}).make(); }

// 4 l m + 2 m^2 + 2 vertices for l x m x m squares; the squares are closest to square for l = 6 m.
Mesh make_box(std::size_t vertices) {
  const double wish = static_cast<double>(vertices) - 2;
  const std::size_t m = rounded(std::sqrt(wish / 26));
  const double across = static_cast<double>(m);
  const std::size_t l = rounded((wish - 2 * across * across) / (4 * across));
  Mesh mesh = box_surface(l, m, m);
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
  Mesh mesh = box_surface(n, n, h);
  for (Vec3d& p : mesh.positions) {
    const double x = p.x / across * 10 - 5;
    const double y = p.y / across * 10 - 5;
    const double up = p.z / static_cast<double>(h);
    p = {x, y, -kDepth + up * (kDepth + crater_height(x, y))};
  }
  return mesh;
}

// The letter Y: a stem and two arms as strips of the plane, extruded with rounded edges.

namespace {

constexpr double kHalfWidth = 0.085;  // of a stroke
constexpr double kHalfHeight = 0.4;
constexpr double kHalfThickness = 0.1;
constexpr double kRounding = 0.02;
constexpr double kArmEnd = 0.2944;  // x of the middle of an arm at its end: puts the outer corners at x = 0.4

// Every part is thinner by the radius of the rounding.
double stem(double x, double y) {
  return blend_max(std::abs(x) - (kHalfWidth - kRounding), std::max(-y - (kHalfHeight - kRounding), y), kRounding);
}

// The strip from the origin to (side * kArmEnd, kHalfHeight), cut level at the end.
double arm(double x, double y, double side) {
  const double length = std::sqrt(kArmEnd * kArmEnd + kHalfHeight * kHalfHeight);
  const double dx = side * kArmEnd / length;
  const double dy = kHalfHeight / length;
  const double across = std::abs(dy * x - dx * y) - (kHalfWidth - kRounding);
  return blend_max(across, std::max(y - (kHalfHeight - kRounding), -(dx * x + dy * y)), kRounding);
}

double letter_y(const Vec3d& p) {
  const double arms = blend_min(arm(p.x, p.y, -1), arm(p.x, p.y, 1), 0.03);
  const double outline = blend_min(stem(p.x, p.y), arms, 0.03);
  const double height = std::abs(p.z) - (kHalfThickness - kRounding);
  const double out = std::fmax(outline, 0);
  const double up = std::fmax(height, 0);
  return std::min(std::max(outline, height), 0.0) + std::sqrt(out * out + up * up) - kRounding;
}

}  // namespace

Solid letter_y_solid() { return {letter_y, {{-0.5, -0.5, -0.2}, {0.5, 0.5, 0.2}}, 0.985}; }

}  // namespace knead::shapes_detail

namespace knead {
namespace {

constexpr std::array<std::string_view, 9> kNames{"sphere", "box",  "cylinder", "torus", "hand",
                                                 "crater", "knot", "letter-y", "figure"};
constexpr std::size_t kMax = 20'000'000;
constexpr std::array<ShapeCounts, 9> kCounts{{{12, 10'242, kMax},
                                              {28, 10'000, kMax},
                                              {100, 10'000, kMax},
                                              {60, 10'000, kMax},
                                              {4'000, 36'000, kMax},
                                              {100, 40'000, kMax},
                                              {600, 20'000, kMax},
                                              {1'000, 20'000, kMax},
                                              {4'000, 30'000, kMax}}};

// Searches for the cell size that gives this number of vertices, by counting the vertices of unrelaxed surfaces; then
// makes the surface.
Mesh make_solid(const shapes_detail::Solid& solid, std::size_t vertices) {
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

Mesh make(ShapeKind kind, std::size_t vertices) {
  switch (kind) {
    case ShapeKind::sphere:
      return shapes_detail::make_sphere(vertices);
    case ShapeKind::box:
      return shapes_detail::make_box(vertices);
    case ShapeKind::cylinder:
      return shapes_detail::make_cylinder(vertices);
    case ShapeKind::torus:
      return shapes_detail::make_torus(vertices);
    case ShapeKind::hand:
      return make_solid(shapes_detail::hand_solid(), vertices);
    case ShapeKind::crater:
      return shapes_detail::make_crater(vertices);
    case ShapeKind::knot:
      return shapes_detail::make_knot(vertices);
    case ShapeKind::figure:
      return make_solid(shapes_detail::figure_solid(), vertices);
    case ShapeKind::letter_y:
      break;
  }
  return make_solid(shapes_detail::letter_y_solid(), vertices);
}

}  // namespace

std::span<const std::string_view> shape_names() { return kNames; }

ShapeKind shape_kind(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return static_cast<ShapeKind>(i);
    known += (i == 0 ? "" : ", ") + std::string(kNames[i]);
  }
  throw InvalidInput("there is no shape '" + std::string(name) + "'; choose one of " + known);
}

ShapeCounts shape_counts(ShapeKind kind) { return kCounts[static_cast<std::size_t>(kind)]; }

Mesh make_shape(ShapeKind kind, std::size_t vertices) {
  const ShapeCounts counts = shape_counts(kind);
  if (vertices == 0) vertices = counts.standard;
  if (vertices < counts.minimum || vertices > counts.maximum) {
    throw InvalidInput("a " + std::string(kNames[static_cast<std::size_t>(kind)]) + " of " + std::to_string(vertices) +
                       " vertices cannot be made; ask for " + std::to_string(counts.minimum) + " to " +
                       std::to_string(counts.maximum));
  }
  return make(kind, vertices);
}

}  // namespace knead
