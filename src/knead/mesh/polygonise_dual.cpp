#include "knead/mesh/polygonise_dual.h"

#include <algorithm>
#include <cstddef>

#include "knead/math/error.h"

namespace knead::polygonise_detail {
namespace {

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
// Both cells at the face compute the same sign, because products commute to the bit.
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

}  // namespace

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

}  // namespace knead::polygonise_detail
