// The bar and the crater: both deform the surface of a block of cubes.
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "knead/mesh/shapes_grids.h"

namespace knead::shapes_detail {
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

}  // namespace knead::shapes_detail
