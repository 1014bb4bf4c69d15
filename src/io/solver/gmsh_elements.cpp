// gmsh's elements as faces and cells.
#include <algorithm>
#include <array>

#include "io/solver/solver.h"
#include "knead/cells.h"

namespace knead::detail::solver {
namespace {

using Form = GmshElement::Form;

constexpr std::array kGmshElements{GmshElement{1, Form::edge, 1, 2},
                                   GmshElement{2, Form::triangle, 1, 3},
                                   GmshElement{3, Form::quadrilateral, 1, 4},
                                   GmshElement{4, Form::tetrahedron, 1, 4},
                                   GmshElement{5, Form::hexahedron, 1, 8},
                                   GmshElement{6, Form::wedge, 1, 6},
                                   GmshElement{7, Form::pyramid, 1, 5},
                                   GmshElement{8, Form::edge, 2, 3},
                                   GmshElement{9, Form::triangle, 2, 6},
                                   GmshElement{10, Form::quadrilateral, 2, 9},
                                   GmshElement{11, Form::tetrahedron, 2, 10},
                                   GmshElement{12, Form::hexahedron, 2, 27},
                                   GmshElement{13, Form::wedge, 2, 18},
                                   GmshElement{14, Form::pyramid, 2, 14},
                                   GmshElement{15, Form::point, 1, 1},
                                   GmshElement{16, Form::quadrilateral, 2, 8},
                                   GmshElement{17, Form::hexahedron, 2, 20},
                                   GmshElement{18, Form::wedge, 2, 15},
                                   GmshElement{19, Form::pyramid, 2, 13},
                                   GmshElement{20, Form::triangle, 3, 9},
                                   GmshElement{21, Form::triangle, 3, 10},
                                   GmshElement{23, Form::triangle, 4, 15},
                                   GmshElement{25, Form::triangle, 5, 21},
                                   GmshElement{26, Form::edge, 3, 4},
                                   GmshElement{27, Form::edge, 4, 5},
                                   GmshElement{28, Form::edge, 5, 6},
                                   GmshElement{29, Form::tetrahedron, 3, 20},
                                   GmshElement{30, Form::tetrahedron, 4, 35},
                                   GmshElement{31, Form::tetrahedron, 5, 56},
                                   GmshElement{36, Form::quadrilateral, 3, 16},
                                   GmshElement{37, Form::quadrilateral, 4, 25},
                                   GmshElement{38, Form::quadrilateral, 5, 36},
                                   GmshElement{39, Form::quadrilateral, 3, 12},
                                   GmshElement{90, Form::wedge, 3, 40},
                                   GmshElement{91, Form::wedge, 4, 75},
                                   GmshElement{92, Form::hexahedron, 3, 64},
                                   GmshElement{93, Form::hexahedron, 4, 125},
                                   GmshElement{94, Form::hexahedron, 5, 216},
                                   GmshElement{99, Form::hexahedron, 3, 32},
                                   GmshElement{106, Form::wedge, 5, 126},
                                   GmshElement{111, Form::wedge, 3, 24},
                                   GmshElement{118, Form::pyramid, 3, 30},
                                   GmshElement{119, Form::pyramid, 4, 55},
                                   GmshElement{120, Form::pyramid, 5, 91},
                                   GmshElement{125, Form::pyramid, 3, 21}};

// The nodes of a face of gmsh at the places of a lattice; a triangle fills half of it. gmsh numbers the corners, then
// the nodes of the edges, then those inside as a face of a lower order.
class FaceLattice {
 public:
  FaceLattice(const GmshElement& face, std::span<const std::uint32_t> points)
      : is_triangle_(face.form == Form::triangle), order_(face.order), points_(points) {
    for (std::size_t ring = 0; next_ < points.size(); ++ring) number_ring(ring);
  }

  void add_to(std::vector<Triangle>& faces) const {
    for (std::size_t i = 0; i < order_; ++i) {
      for (std::size_t j = 0; j < (is_triangle_ ? order_ - i : order_); ++j) {
        faces.push_back({nodes_[i][j], nodes_[i + 1][j], nodes_[i][j + 1]});
        const bool is_half = is_triangle_ && i + j + 1 == order_;
        if (!is_half) faces.push_back({nodes_[i + 1][j], nodes_[i + 1][j + 1], nodes_[i][j + 1]});
      }
    }
  }

 private:
  void number_ring(std::size_t ring) {
    const std::size_t n = order_ - ring * (is_triangle_ ? 3 : 2);
    std::vector<std::array<std::size_t, 2>> corners{{0, 0}, {n, 0}, {n, n}, {0, n}};
    if (is_triangle_) corners = {{0, 0}, {n, 0}, {0, n}};
    const std::size_t count = n == 0 ? 1 : corners.size();
    const auto put = [&](std::size_t i, std::size_t j) { nodes_[ring + i][ring + j] = points_[next_++]; };
    for (std::size_t k = 0; k < count; ++k) put(corners[k][0], corners[k][1]);
    for (std::size_t k = 0; k < count; ++k) {
      const auto& [i, j] = corners[k];
      const auto& [to_i, to_j] = corners[(k + 1) % count];
      for (std::size_t step = 1; step < n; ++step) {
        put((i * (n - step) + to_i * step) / n, (j * (n - step) + to_j * step) / n);
      }
    }
  }

  bool is_triangle_;
  std::size_t order_;
  std::span<const std::uint32_t> points_;
  std::size_t next_ = 0;
  std::array<std::array<std::uint32_t, 6>, 6> nodes_{};
};

// Of the third order and above. Without nodes inside there are none.
void add_curved_faces(const GmshElement& face, std::span<const std::uint32_t> p, std::vector<Triangle>& faces) {
  const std::size_t n = face.order;
  if (face.form == Form::edge) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t end = p[k + 1 == n ? 1 : k + 2];
      faces.push_back({p[k == 0 ? 0 : k + 1], end, end});
    }
  } else if (p.size() == (face.form == Form::triangle ? (n + 1) * (n + 2) / 2 : (n + 1) * (n + 1))) {
    FaceLattice(face, p).add_to(faces);
  }
}

using Edge = std::array<std::uint8_t, 2>;

// What a cell of gmsh is. Its corners are those of VTK, but wedges look to the other side.
struct GmshCell {
  std::int64_t type;
  CellKind kind;
  std::span<const Edge> middles;  // the edges of the middle nodes, in gmsh's order; empty: of the first order
};

constexpr std::array<Edge, 6> kTetrahedron{{{0, 1}, {1, 2}, {2, 0}, {3, 0}, {2, 3}, {1, 3}}};
constexpr std::array<Edge, 12> kHexahedron{
    {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}}};
constexpr std::array<Edge, 9> kWedge{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}}};
constexpr std::array<Edge, 8> kPyramid{{{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}};

constexpr std::array kGmshCells{GmshCell{4, CellKind::tetrahedron, {}},
                                GmshCell{5, CellKind::hexahedron, {}},
                                GmshCell{6, CellKind::wedge, {}},
                                GmshCell{7, CellKind::pyramid, {}},
                                GmshCell{11, CellKind::tetrahedron, kTetrahedron},
                                GmshCell{12, CellKind::hexahedron, kHexahedron},
                                GmshCell{13, CellKind::wedge, kWedge},
                                GmshCell{14, CellKind::pyramid, kPyramid},
                                GmshCell{17, CellKind::hexahedron, kHexahedron},
                                GmshCell{18, CellKind::wedge, kWedge},
                                GmshCell{19, CellKind::pyramid, kPyramid}};

// gmsh's number of a corner.
std::uint8_t gmsh_corner(CellKind kind, std::uint8_t corner) {
  constexpr std::array<std::uint8_t, 6> wedge{0, 2, 1, 3, 5, 4};
  return kind == CellKind::wedge ? wedge[corner] : corner;
}

}  // namespace

const GmshElement* gmsh_element(std::int64_t type) {
  const auto* const found =
      std::find_if(kGmshElements.begin(), kGmshElements.end(), [&](const GmshElement& e) { return e.type == type; });
  return found == kGmshElements.end() ? nullptr : found;
}

void add_faces(std::int64_t type, std::span<const std::uint32_t> p, std::vector<Triangle>& faces) {
  const auto add = [&](std::initializer_list<std::array<std::size_t, 3>> triangles) {
    for (const auto& t : triangles) faces.push_back({p[t[0]], p[t[1]], p[t[2]]});
  };
  switch (type) {
    case 1:
      return add({{0, 1, 1}});
    case 2:
      return add({{0, 1, 2}});
    case 3:
      return add({{0, 1, 2}, {0, 2, 3}});
    case 8:
      return add({{0, 2, 2}, {2, 1, 1}});
    case 9:
      return add({{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}});
    case 10:
      return add({{0, 4, 8}, {4, 1, 8}, {1, 5, 8}, {5, 2, 8}, {2, 6, 8}, {6, 3, 8}, {3, 7, 8}, {7, 0, 8}});
    case 16:
      return add({{0, 4, 7}, {4, 1, 5}, {5, 2, 6}, {6, 3, 7}, {4, 5, 7}, {5, 6, 7}});
    default: {
      const GmshElement* const element = gmsh_element(type);
      if (element != nullptr && element->order > 2 && element->dimension() < 3) add_curved_faces(*element, p, faces);
    }
  }
}

void add_cell(std::int64_t type, std::span<const std::uint32_t> points, VolumeCells& cells) {
  const auto* const found =
      std::find_if(kGmshCells.begin(), kGmshCells.end(), [&](const GmshCell& cell) { return cell.type == type; });
  if (found == kGmshCells.end()) {
    const GmshElement* const element = gmsh_element(type);
    if (element == nullptr || element->dimension() < 3) return;
    constexpr std::array kLinear{4, 5, 6, 7};
    ++cells.by_corners;
    return add_cell(kLinear[static_cast<std::size_t>(element->form) - static_cast<std::size_t>(Form::tetrahedron)],
                    points, cells);
  }
  std::array<std::uint32_t, 8> corners{};
  const std::size_t count = corner_count(found->kind);
  for (std::uint8_t k = 0; k < count; ++k) corners[k] = points[gmsh_corner(found->kind, k)];
  cells.cells.add(found->kind, std::span(corners).first(count));
  if (found->middles.empty()) return;
  MiddleNodes& middles = cells.middles;
  middles.cells.push_back(cells.cells.size() - 1);
  for (const Edge& edge : edges_of(found->kind)) {
    const std::uint8_t a = gmsh_corner(found->kind, edge[0]);
    const std::uint8_t b = gmsh_corner(found->kind, edge[1]);
    const auto at = std::find_if(found->middles.begin(), found->middles.end(), [&](const Edge& other) {
      return std::minmax(a, b) == std::minmax(other[0], other[1]);
    });
    middles.points.push_back(points[count + static_cast<std::size_t>(at - found->middles.begin())]);
  }
  middles.first.push_back(middles.points.size());
}

void add_flat_cell(std::int64_t type, std::span<const std::uint32_t> numbers, std::span<const Vec3d> points,
                   VolumeCells& cells) {
  const GmshElement* const element = gmsh_element(type);
  if (element == nullptr || element->dimension() != 2) return;
  const std::size_t corners = element->form == Form::triangle ? 3 : 4;
  const bool is_curved = element->order == 2;
  if (element->order > 2) ++cells.by_corners;
  knead::add_flat_cell(numbers.first(corners), numbers.subspan(corners, is_curved ? corners : 0), points, cells);
}

bool is_flat(std::span<const Vec3d> points) {
  return std::all_of(points.begin(), points.end(), [&](const Vec3d& p) { return p.z == points.front().z; });
}

}  // namespace knead::detail::solver
