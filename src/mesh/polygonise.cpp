// Dual marching cubes: finds the cells that a surface crosses, makes quadrilaterals, and relaxes them onto the surface.
#include "mesh/polygonise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/error.h"

namespace knead {
namespace {

// A grid of cubic cells. Cell (x, y, z) has 0 <= x < cells[0] and so on; cell (0, 0, 0) begins at `origin`.
struct Grid {
  Vec3d origin;
  double cell = 0;
  std::array<std::uint32_t, 3> cells{};

  Vec3d at(double x, double y, double z) const { return origin + Vec3d{x, y, z} * cell; }
};

// Returns grid coordinates as one number that sorts by z, then y, then x; 20 bits each. grid_place() is the inverse.
std::uint64_t grid_key(std::uint64_t x, std::uint64_t y, std::uint64_t z) { return (z << 40) | (y << 20) | x; }
std::array<std::uint32_t, 3> grid_place(std::uint64_t key) {
  constexpr std::uint64_t kMask = (1U << 20) - 1;
  return {static_cast<std::uint32_t>(key & kMask), static_cast<std::uint32_t>((key >> 20) & kMask),
          static_cast<std::uint32_t>(key >> 40)};
}

// A cell with corners both inside and outside. Corner c has the offset (c & 1, (c >> 1) & 1, c >> 2).
struct SurfaceCell {
  std::uint64_t key = 0;
  std::array<double, 8> values{};

  bool inside(int corner) const { return values[corner] < 0; }
};

constexpr std::uint32_t kBlock = 2;  // cells along a side of the smallest blocks
constexpr double kMaxCells = 4096;   // along a side of the grid

// Cuts each block into eight blocks with `size` cells along a side, and returns those within the grid.
std::vector<std::uint64_t> split_blocks(const std::vector<std::uint64_t>& blocks, const Grid& grid,
                                        std::uint32_t size) {
  std::vector<std::uint64_t> halves;
  for (const std::uint64_t block : blocks) {
    const auto [x, y, z] = grid_place(block);
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t hx = 2 * x + (i & 1);
      const std::uint32_t hy = 2 * y + ((i >> 1) & 1);
      const std::uint32_t hz = 2 * z + (i >> 2);
      const bool in_grid = hx * size < grid.cells[0] && hy * size < grid.cells[1] && hz * size < grid.cells[2];
      if (in_grid) halves.push_back(grid_key(hx, hy, hz));
    }
  }
  return halves;
}

// Removes the blocks that cannot meet the surface: their centre is farther from it than from their corners.
void drop_empty_blocks(std::vector<std::uint64_t>& blocks, const ScalarFunction& f, const Grid& grid,
                       std::uint32_t size, double lipschitz) {
  const double to_corner = lipschitz * grid.cell * size * 0.5 * std::sqrt(3.0) * (1 + 1e-9);
  std::erase_if(blocks, [&](std::uint64_t block) {
    const auto [x, y, z] = grid_place(block);
    return std::abs(f(grid.at((x + 0.5) * size, (y + 0.5) * size, (z + 0.5) * size))) > to_corner;
  });
}

// Returns the smallest blocks that the surface may meet. Begins with the whole grid and halves blocks level by level.
std::vector<std::uint64_t> blocks_near_surface(const ScalarFunction& f, const Grid& grid, double lipschitz) {
  std::uint32_t size = kBlock;
  while (size < *std::max_element(grid.cells.begin(), grid.cells.end())) size *= 2;
  std::vector<std::uint64_t> blocks{grid_key(0, 0, 0)};
  drop_empty_blocks(blocks, f, grid, size, lipschitz);
  while (size > kBlock) {
    size /= 2;
    blocks = split_blocks(blocks, grid, size);
    drop_empty_blocks(blocks, f, grid, size, lipschitz);
  }
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

// The values of f at the corners of three consecutive grid layers. Each value is computed at its first use.
class CornerLayers {
 public:
  CornerLayers(const ScalarFunction& f, const Grid& grid) : f_(f), grid_(grid), row_(grid.cells[0] + 1) {
    const std::size_t layer = row_ * (grid.cells[1] + 1);
    for (Layer& l : layers_) {
      l.values.resize(layer);
      l.height.resize(layer, kNone);
    }
  }

  double operator()(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    Layer& layer = layers_[z % 3];
    const std::size_t i = row_ * y + x;
    if (layer.height[i] != z) {
      layer.height[i] = z;
      layer.values[i] = f_(grid_.at(x, y, z));
    }
    return layer.values[i];
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  struct Layer {
    std::vector<double> values;
    std::vector<std::uint32_t> height;  // the z that each value belongs to
  };

  const ScalarFunction& f_;
  const Grid& grid_;
  std::size_t row_;
  std::array<Layer, 3> layers_;
};

// Appends the cells of one block that have corners on both sides.
void append_surface_cells(std::uint64_t block, const Grid& grid, CornerLayers& corner,
                          std::vector<SurfaceCell>& cells) {
  const auto [bx, by, bz] = grid_place(block);
  for (std::uint32_t i = 0; i < kBlock * kBlock * kBlock; ++i) {
    const std::uint32_t x = kBlock * bx + i % kBlock;
    const std::uint32_t y = kBlock * by + i / kBlock % kBlock;
    const std::uint32_t z = kBlock * bz + i / (kBlock * kBlock);
    if (x >= grid.cells[0] || y >= grid.cells[1] || z >= grid.cells[2]) continue;
    SurfaceCell cell{grid_key(x, y, z), {}};
    int inside = 0;
    for (std::uint32_t c = 0; c < 8; ++c) {
      cell.values[c] = corner(x + (c & 1), y + ((c >> 1) & 1), z + (c >> 2));
      inside += cell.inside(static_cast<int>(c)) ? 1 : 0;
    }
    if (inside > 0 && inside < 8) cells.push_back(cell);
  }
}

std::uint32_t blocks_along(const Grid& grid, std::size_t axis) { return (grid.cells[axis] + kBlock - 1) / kBlock; }

void append_all_blocks(const Grid& grid, CornerLayers& corner, std::vector<SurfaceCell>& cells) {
  for (std::uint32_t z = 0; z < blocks_along(grid, 2); ++z) {
    for (std::uint32_t y = 0; y < blocks_along(grid, 1); ++y) {
      for (std::uint32_t x = 0; x < blocks_along(grid, 0); ++x) {
        append_surface_cells(grid_key(x, y, z), grid, corner, cells);
      }
    }
  }
}

// Returns the cells with corners on both sides, by increasing key. For lipschitz see PolygoniseOptions.
std::vector<SurfaceCell> surface_cells(const ScalarFunction& f, const Grid& grid, double lipschitz) {
  std::vector<SurfaceCell> cells;
  CornerLayers corner(f, grid);
  if (lipschitz > 0) {
    for (const std::uint64_t block : blocks_near_surface(f, grid, lipschitz)) {
      append_surface_cells(block, grid, corner, cells);
    }
  } else {
    append_all_blocks(grid, corner, cells);
  }
  std::sort(cells.begin(), cells.end(), [](const SurfaceCell& a, const SurfaceCell& b) { return a.key < b.key; });
  return cells;
}

// Edge 4 a + j of a cell runs along axis a. Bit 0 of j is its offset along the next axis, bit 1 along the one after
// that.
constexpr int edge_start(int edge) {
  const int a = edge / 4;
  return ((edge & 1) << ((a + 1) % 3)) | (((edge >> 1) & 1) << ((a + 2) % 3));
}
constexpr int edge_end(int edge) { return edge_start(edge) | (1 << (edge / 4)); }

struct Face {
  std::array<int, 4> corners{};  // counter-clockwise seen from outside the cell
  std::array<int, 4> edges{};    // edge i joins the corners i and i + 1
};

constexpr int edge_between(int c, int d) {
  for (int e = 0; e < 12; ++e) {
    if ((edge_start(e) == c && edge_end(e) == d) || (edge_start(e) == d && edge_end(e) == c)) return e;
  }
  return -1;
}

// The outward normal of face 2 a is along -a, that of face 2 a + 1 along +a.
constexpr Face make_face(int index) {
  const int a = index / 2;
  const int side = index % 2;
  const int b = 1 << ((a + 1) % 3);
  const int c = 1 << ((a + 2) % 3);
  const int base = side << a;
  Face face;
  face.corners = side == 1 ? std::array<int, 4>{base, base | b, base | b | c, base | c}
                           : std::array<int, 4>{base, base | c, base | b | c, base | b};
  for (std::size_t i = 0; i < 4; ++i) face.edges[i] = edge_between(face.corners[i], face.corners[(i + 1) % 4]);
  return face;
}

constexpr std::array<Face, 6> kFaces{make_face(0), make_face(1), make_face(2),
                                     make_face(3), make_face(4), make_face(5)};
constexpr std::uint8_t kNoEdge = 255;

// How the surface crosses a cell.
struct Passage {
  std::uint8_t flipped = 0;                // one bit for each face that is connected against the saddle
  std::array<std::uint8_t, 12> next{};     // the crossed edges in loops
  std::array<std::uint32_t, 12> vertex{};  // of each crossed edge: the vertex of its loop
};

bool crossed(const SurfaceCell& cell, int edge) { return cell.inside(edge_start(edge)) != cell.inside(edge_end(edge)); }

bool ambiguous(const SurfaceCell& cell, const Face& face) {
  const auto inside = [&](int i) { return cell.inside(face.corners[i]); };
  return inside(0) == inside(2) && inside(1) == inside(3) && inside(0) != inside(1);
}

// Returns true if the inside corners of an ambiguous face are connected across it: the sign of its bilinear saddle.
// Both cells at the face compute the same sign, because products commute bit for bit.
bool saddle_inside(const SurfaceCell& cell, const Face& face) {
  const auto value = [&](int i) { return cell.values[face.corners[i]]; };
  const double even = value(0) * value(2);
  const double odd = value(1) * value(3);
  return cell.inside(face.corners[0]) ? even > odd : odd > even;
}

// Links each face edge that leaves the inside (counter-clockwise) to the edge where the segment of the surface ends.
// The segment goes around the outside corner if the inside is connected across the face, else around the inside corner.
void link_edges(const SurfaceCell& cell, Passage& passage) {
  passage.next.fill(kNoEdge);
  for (std::size_t f = 0; f < 6; ++f) {
    const Face& face = kFaces[f];
    const bool flipped = ((passage.flipped >> f) & 1) != 0;
    const bool joined = ambiguous(cell, face) && saddle_inside(cell, face) != flipped;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!cell.inside(face.corners[i]) || cell.inside(face.corners[(i + 1) % 4])) continue;
      std::size_t to = joined ? i + 1 : i + 3;
      while (!crossed(cell, face.edges[to % 4])) to = joined ? to + 1 : to + 3;
      passage.next[face.edges[i]] = static_cast<std::uint8_t>(face.edges[to % 4]);
    }
  }
}

bool same_loop(const Passage& passage, int from, int to) {
  int edge = from;
  do {
    if (edge == to) return true;
    edge = passage.next[edge];
  } while (edge != from);
  return false;
}

// Returns true if one loop crosses an ambiguous face twice: then opposite edges are in the same loop.
bool doubled(const Passage& passage, const Face& face) { return same_loop(passage, face.edges[0], face.edges[2]); }

class CellFinder {
 public:
  explicit CellFinder(std::span<const SurfaceCell> cells) : cells_(cells) {}

  // Returns the index of the cell at these grid coordinates. Throws if there is none.
  std::size_t operator()(std::uint64_t key) const {
    const auto found = std::lower_bound(cells_.begin(), cells_.end(), key,
                                        [](const SurfaceCell& c, std::uint64_t k) { return c.key < k; });
    if (found == cells_.end() || found->key != key) {
      throw InvalidInput(
          "the function changes faster than its Lipschitz constant allows; give a larger constant, or 0 if it is "
          "unknown");
    }
    return static_cast<std::size_t>(found - cells_.begin());
  }

 private:
  std::span<const SurfaceCell> cells_;
};

constexpr std::array<std::uint64_t, 3> kStride{1, std::uint64_t{1} << 20, std::uint64_t{1} << 40};

// If two neighbours both cross their common face twice with one loop, four quadrilaterals would share an edge. The
// opposite connection of that face splits both loops. A split connects nothing elsewhere, so one pass is enough.
void separate_doubled_faces(std::span<const SurfaceCell> cells, std::vector<Passage>& passages) {
  const CellFinder find(cells);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      const Face& face = kFaces[2 * a + 1];
      if (!ambiguous(cells[i], face) || !doubled(passages[i], face)) continue;
      const std::size_t other = find(cells[i].key + kStride[a]);
      if (!doubled(passages[other], kFaces[2 * a])) continue;
      passages[i].flipped ^= static_cast<std::uint8_t>(1U << (2 * a + 1));
      passages[other].flipped ^= static_cast<std::uint8_t>(1U << (2 * a));
      link_edges(cells[i], passages[i]);
      link_edges(cells[other], passages[other]);
    }
  }
}

// Returns the point where the surface crosses an edge, as an offset from corner 0 of the cell, in cells.
Vec3d crossing(const SurfaceCell& cell, int edge) {
  const int start = edge_start(edge);
  const double from = cell.values[start];
  const double t = from / (from - cell.values[edge_end(edge)]);
  Vec3d p{static_cast<double>(start & 1), static_cast<double>((start >> 1) & 1), static_cast<double>(start >> 2)};
  p[static_cast<std::size_t>(edge / 4)] = t >= 0 && t <= 1 ? t : 0.5;  // 0.5 if a value is infinite or NaN
  return p;
}

void append_vertices(const SurfaceCell& cell, Passage& passage, const Grid& grid, std::vector<Vec3d>& positions) {
  constexpr std::uint32_t kUnset = ~std::uint32_t{0};
  const auto [x, y, z] = grid_place(cell.key);
  passage.vertex.fill(kUnset);
  for (int first = 0; first < 12; ++first) {
    if (passage.next[first] == kNoEdge || passage.vertex[first] != kUnset) continue;
    Vec3d sum;
    int count = 0;
    int edge = first;
    do {
      passage.vertex[edge] = static_cast<std::uint32_t>(positions.size());
      sum += crossing(cell, edge);
      ++count;
      edge = passage.next[edge];
    } while (edge != first);
    const Vec3d mean = sum / static_cast<double>(count);
    positions.push_back(grid.at(x + mean.x, y + mean.y, z + mean.z));
  }
}

using Quad = std::array<std::uint32_t, 4>;  // counter-clockwise seen from outside

// Appends the quadrilateral around the cell edge from corner 0 along axis a, if that edge is crossed.
void append_quad(std::size_t i, int a, std::span<const SurfaceCell> cells, std::span<const Passage> passages,
                 std::vector<Quad>& quads) {
  const SurfaceCell& cell = cells[i];
  const int edge = 4 * a;
  if (!crossed(cell, edge)) return;
  const std::uint64_t b = kStride[(a + 1) % 3];
  const std::uint64_t c = kStride[(a + 2) % 3];
  const CellFinder find(cells);
  Quad quad{passages[find(cell.key - b - c)].vertex[edge + 3], passages[find(cell.key - c)].vertex[edge + 2],
            passages[i].vertex[edge], passages[find(cell.key - b)].vertex[edge + 1]};
  if (!cell.inside(0)) std::swap(quad[1], quad[3]);
  quads.push_back(quad);
}

struct QuadSurface {
  std::vector<Vec3d> positions;
  std::vector<Quad> quads;
};

// Returns a surface with a vertex for each loop of crossed edges in a cell, at the mean of its crossings, and a
// quadrilateral for each crossed edge of the grid. No crossed edge may lie on the wall of the grid. Throws InvalidInput
// if a cell at a crossed edge is missing.
//
// The surface is manifold, and remains so when each quadrilateral is split along any diagonal: the four cells at a grid
// edge are distinct, opposite ones share no other edge, and no two loops of neighbouring cells meet in two segments of
// one face (see separate_doubled_faces).
QuadSurface dual_surface(std::span<const SurfaceCell> cells, const Grid& grid) {
  std::vector<Passage> passages(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) link_edges(cells[i], passages[i]);
  separate_doubled_faces(cells, passages);
  QuadSurface surface;
  for (std::size_t i = 0; i < cells.size(); ++i) append_vertices(cells[i], passages[i], grid, surface.positions);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (int a = 0; a < 3; ++a) append_quad(i, a, cells, passages, surface.quads);
  }
  return surface;
}

// The sums over the quadrilaterals at a vertex.
struct VertexRing {
  Vec3d normal;  // not of unit length
  Vec3d sum;     // of the neighbours
  double count = 0;
};

std::vector<VertexRing> vertex_rings(const QuadSurface& surface) {
  std::vector<VertexRing> rings(surface.positions.size());
  for (const Quad& quad : surface.quads) {
    const auto p = [&](std::size_t i) { return surface.positions[quad[i]]; };
    const Vec3d normal = cross(p(2) - p(0), p(3) - p(1));
    for (std::size_t i = 0; i < 4; ++i) {
      VertexRing& ring = rings[quad[i]];
      ring.normal += normal;
      ring.sum += p((i + 1) % 4);  // every edge is visited once in each direction
      ring.count += 1;
    }
  }
  return rings;
}

// Returns p moved by the largest of 1, 1/2, 1/4, 1/8 of the step that does not increase |f|, or p if all do.
Vec3d guarded_step(const ScalarFunction& f, const Vec3d& p, double value, const Vec3d& step) {
  double t = 1;
  for (int i = 0; i < 4; ++i, t *= 0.5) {
    const Vec3d q = p + step * t;
    if (std::abs(f(q)) <= std::abs(value)) return q;
  }
  return p;
}

Vec3d gradient(const ScalarFunction& f, const Vec3d& p, double value, double h) {
  return Vec3d{f({p.x + h, p.y, p.z}) - value, f({p.x, p.y + h, p.z}) - value, f({p.x, p.y, p.z + h}) - value} / h;
}

Vec3d limited(const Vec3d& v, double length) {
  const double size = norm(v);
  return size <= length ? v : v * (length / size);
}

// Moves p by one Newton step along the gradient, at most half a cell. Returns the gradient's length, 0 without a step.
double newton(const ScalarFunction& f, double cell, Vec3d& p) {
  const double value = f(p);
  const Vec3d g = gradient(f, p, value, 1e-5 * cell);
  const double steepness = norm2(g);
  if (!(steepness > 0) || !std::isfinite(steepness) || !std::isfinite(value)) return 0;
  p = guarded_step(f, p, value, limited(g * (-value / steepness), 0.5 * cell));
  return std::sqrt(steepness);
}

// Returns p moved by one secant step along the normal of the surface, given the slope of f there: two evaluations
// instead of five.
Vec3d return_along(const ScalarFunction& f, const Vec3d& p, const Vec3d& normal, double steepness, double cell) {
  const double value = f(p);
  const double size = norm(normal);
  if (!(steepness > 0) || !(size > 0) || !std::isfinite(value)) return p;
  return guarded_step(f, p, value, limited(normal * (-value / (steepness * size)), 0.5 * cell));
}

// Returns p moved towards its neighbours within the tangent plane.
Vec3d smoothed(const Vec3d& p, const VertexRing& around) {
  const double size = norm2(around.normal);
  const Vec3d move = around.sum / around.count - p;
  return size > 0 ? p + (move - around.normal * (dot(move, around.normal) / size)) * 0.6 : p;
}

double smallest_angle_cosine(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const auto cosine = [](const Vec3d& u, const Vec3d& v) {
    const double size = std::sqrt(norm2(u) * norm2(v));
    return size > 0 ? dot(u, v) / size : 1.0;
  };
  return std::max({cosine(b - a, c - a), cosine(a - b, c - b), cosine(a - c, b - c)});
}

// Moves every vertex onto {f = 0}, then `rounds` times towards the mean of its neighbours in the tangent plane and back
// onto {f = 0}. Does nothing for rounds = 0. A vertex moves at most one cell in all, and never where |f| would grow. So
// a function that is rough on the scale of a cell hardly changes the surface.
void relax(QuadSurface& surface, const ScalarFunction& f, double cell, int rounds) {
  if (rounds == 0) return;
  const std::vector<Vec3d> home = surface.positions;
  std::vector<double> steepness;
  for (Vec3d& p : surface.positions) steepness.push_back(newton(f, cell, p));
  for (int round = 0; round < rounds; ++round) {
    const std::vector<VertexRing> around = vertex_rings(surface);
    for (std::size_t i = 0; i < home.size(); ++i) {
      const Vec3d p = home[i] + limited(smoothed(surface.positions[i], around[i]) - home[i], cell);
      surface.positions[i] = return_along(f, p, around[i].normal, steepness[i], cell);
    }
  }
  for (Vec3d& p : surface.positions) newton(f, cell, p);
}

// Returns triangles: each quadrilateral is split along the diagonal that gives the larger smallest angle.
Mesh split_quads(const QuadSurface& surface) {
  Mesh mesh;
  mesh.positions = surface.positions;
  mesh.face_begin.reserve(2 * surface.quads.size() + 1);
  mesh.corner_vertex.reserve(6 * surface.quads.size());
  for (const Quad& q : surface.quads) {
    const auto p = [&](std::size_t i) { return surface.positions[q[i]]; };
    const double even = std::max(smallest_angle_cosine(p(0), p(1), p(2)), smallest_angle_cosine(p(0), p(2), p(3)));
    const double odd = std::max(smallest_angle_cosine(p(1), p(2), p(3)), smallest_angle_cosine(p(1), p(3), p(0)));
    const std::size_t s = even <= odd ? 0 : 1;
    mesh.add_face(std::array{q[s], q[s + 1], q[s + 2]});
    mesh.add_face(std::array{q[s], q[s + 2], q[(s + 3) % 4]});
  }
  return mesh;
}

void check_grid(const Box& box, const PolygoniseOptions& options) {
  if (!(options.cell > 0) || !std::isfinite(options.cell)) {
    throw InvalidInput("the grid cell of a polygonised surface is not a positive number; give a positive number");
  }
  if (!(options.lipschitz >= 0) || !std::isfinite(options.lipschitz)) {
    throw InvalidInput("the Lipschitz constant is negative or not finite; give 0 if it is unknown");
  }
  if (options.relaxations < 0 || options.relaxations > 100) {
    throw InvalidInput("the number of relaxations is out of range; give a number from 0 to 100");
  }
  const Vec3d size = box.max - box.min;
  if (!is_finite(box.min) || !is_finite(box.max) || !(size.x > 0 && size.y > 0 && size.z > 0)) {
    throw InvalidInput("the box of a polygonised surface is empty or not finite; give one with a volume");
  }
  if (std::max({size.x, size.y, size.z}) > kMaxCells * options.cell) {
    throw InvalidInput("the grid has more than 4096 cells along a side; give a larger cell");
  }
}

Grid grid_of(const Box& box, double cell) {
  const auto count = [&](double size) { return static_cast<std::uint32_t>(std::fmax(1, std::ceil(size / cell))); };
  const Vec3d size = box.max - box.min;
  return {box.min, cell, {count(size.x), count(size.y), count(size.z)}};
}

// Returns a bound of the signed distance from a box: positive outside, 0 on its walls.
double box_distance(const Box& box, const Vec3d& p) {
  const Vec3d below = box.min - p;
  const Vec3d above = p - box.max;
  return std::max({below.x, below.y, below.z, above.x, above.y, above.z});
}

}  // namespace

Mesh polygonise(const ScalarFunction& f, const Box& box, const PolygoniseOptions& options) {
  check_grid(box, options);
  const double slope = options.lipschitz > 0 ? options.lipschitz : 1;
  const ScalarFunction within_box = [&](const Vec3d& p) { return std::max(f(p), slope * box_distance(box, p)); };
  const Grid grid = grid_of(box, options.cell);
  const auto cells = surface_cells(within_box, grid, options.lipschitz);
  QuadSurface surface = dual_surface(cells, grid);
  relax(surface, within_box, options.cell, options.relaxations);
  return split_quads(surface);
}

}  // namespace knead
