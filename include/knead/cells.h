// The cells of volume meshes: their quality, and what a deformation does to it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

// Linear cells of volume meshes, their corners in the order of VTK.
enum class CellKind { tetrahedron, pyramid, wedge, hexahedron };

// Returns 4, 5, 6 or 8.
std::size_t corner_count(CellKind kind);

// What a deformation may spoil in a cell.
struct CellQuality {
  double volume = 0;  // between its faces, which are bilinear; below 0 for a cell that is inside out
  // The least of its corners: the determinant of the three edges there over the product of their lengths, times a
  // constant with which a cell with equal edges has 1. Of a pyramid without its apex. 0 where an edge has no length.
  double scaled_jacobian = 0;
  // 1: at all these corners the three edges are right-handed, as they should be; -1: at none; 0: at some, or flat.
  // Exact.
  int orientation = 0;
};

// Returns the quality of a cell. Throws InvalidInput for another number of corners, and for coordinates that are not
// finite or beyond 1e75. The scaled Jacobian is that of the Verdict library (Stimpson et al., 2007) at the corners;
// that library also looks at the middle of a hexahedron, and measures pyramids in another way.
CellQuality cell_quality(CellKind kind, std::span<const Vec3d> corners);

// The linear cells of a volume mesh.
struct Cells {
  std::vector<CellKind> kinds;
  std::vector<std::size_t> first{0};   // where the corners of each cell begin, and after the last their number
  std::vector<std::uint32_t> corners;  // numbers of points in VTK's order

  // Returns the number of cells.
  std::size_t size() const { return kinds.size(); }
  // Returns the points of a cell, in VTK's order.
  std::span<const std::uint32_t> corners_of(std::size_t cell) const {
    return std::span(corners).subspan(first[cell], first[cell + 1] - first[cell]);
  }
  // Appends a cell, which has corner_count(kind) corners.
  void add(CellKind kind, std::span<const std::uint32_t> numbers);
};

// Returns the edges of a cell of this kind: pairs of corners, in the order in which VTK has the middle nodes of cells
// of the second order.
std::span<const std::array<std::uint8_t, 2>> edges_of(CellKind kind);

// The middle nodes of some cells, which are of the second order.
struct MiddleNodes {
  std::vector<std::size_t> cells;     // their numbers, ascending
  std::vector<std::size_t> first{0};  // where the nodes of each begin, and after the last their number
  std::vector<std::uint32_t> points;  // one for each of edges_of() the cell
};

// Returns for each of these cells the least scaled Jacobian of the map of the second order at its corners and middle
// nodes, without a pyramid's apex: 1 at most, 0 or less where the cell is folded. A cell whose middle nodes are in the
// middle of straight edges has nearly the value of cell_quality(). Nodes in the middle of faces and cells are not
// looked at. Throws InvalidInput for a number that is no point.
std::vector<double> middle_jacobians(const Cells& cells, const MiddleNodes& middles, std::span<const Vec3d> points,
                                     int threads = 0);

// What compare_cells() finds.
enum class CellValues { all, inversions };

// What a deformation did to cells: a value for each. Without volume_ratio and scaled_jacobian if only the inversions
// were asked for.
struct CellChanges {
  std::vector<double> volume_ratio;         // the volume after over that before; not finite where that was 0
  std::vector<double> scaled_jacobian;      // after; its negative for a cell that was inside out before
  std::vector<std::uint8_t> is_inverted{};  // 1: a corner has turned; 0 for a cell that was flat or mixed before
  std::size_t inverted = 0;                 // how many
};

// Compares cells before and after a deformation. The result is the same for every number of threads. A cell whose
// points all rest is judged once for all values, and not at all for inversions. Throws InvalidInput with the cell's
// number for a corner that is no point, and for each cell that is judged where cell_quality does.
CellChanges compare_cells(const Cells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                          int threads = 0, CellValues values = CellValues::all);

// What a finite volume method asks of cells: for each cell the worst of its faces, by the definitions of OpenFOAM's
// checkMesh.
struct CellFaceQuality {
  // In degrees, from 0 to 180: between the normal of a face and the line from its cell's centre to the neighbour's.
  // checkMesh complains above 70. 0 for a cell without a neighbour.
  std::vector<double> non_orthogonality_deg;
  // How far that line passes by the face's centre, beside the size of the face in that direction; at the boundary the
  // line is along the normal. From 0; checkMesh complains above 4 inside, and above 20 at the boundary.
  std::vector<double> skewness;
  // Of each cell: how unequal the areas are that it shows along x, y and z; or a sixth of their sum over the volume's
  // 2/3 power, if that is more. A cube has 1; checkMesh complains above 1000.
  std::vector<double> aspect_ratio;
  // The angle whose cosine is the mean of the cosines at all faces between two cells.
  double mean_non_orthogonality_deg = 0;
};

// Returns these values for the cells, then for the polyhedra (each as polyhedron_volume() takes it). Cells are
// neighbours if they name the same points. A mesh whose cells are inside out as a whole has the values of its mirror
// image; a face of a polyhedron is taken to look outward. The result is the same for every number of threads. Throws
// InvalidInput for a corner that is no point, and for a list of faces that is cut off.
CellFaceQuality cell_face_quality(const Cells& cells, std::span<const Vec3d> points,
                                  std::span<const std::span<const std::uint32_t>> polyhedra = {}, int threads = 0);

// Returns the number of cells and polyhedra with an edge shorter than 1e4 epsilons of float32 (1.2e-3) times the
// greatest coordinate of its ends: coordinates that were float once have moved such an edge by up to 1e-4 of its
// length. Throws as cell_face_quality.
std::size_t count_cells_unresolved_in_float(const Cells& cells, std::span<const Vec3d> points,
                                            std::span<const std::span<const std::uint32_t>> polyhedra = {},
                                            int threads = 0);

// Returns the points on the boundary of a volume mesh, ascending: corners of a face that belongs to one cell only, or
// to more than two. Below 2^32 cells. Throws InvalidInput for a corner that is not below `points`.
std::vector<std::uint32_t> boundary_points(const Cells& cells, std::size_t points, int threads = 0);

// The corners of a face of a volume mesh, ascending. A triangle has no fourth one: kNoCorner.
using CellBoundaryFace = std::array<std::uint32_t, 4>;
constexpr std::uint32_t kNoCorner = 0xffffffff;

// Returns the faces on the boundary of a volume mesh, ascending: those that belong to one cell only, or to more than
// two. Below 2^32 cells. Throws InvalidInput for a corner that is not below `points`.
std::vector<CellBoundaryFace> boundary_faces(const Cells& cells, std::size_t points, int threads = 0);

// Returns the volume between the faces of a polyhedron: [n, v1 ... vn, n, ...], which look outward. A face is cut into
// triangles around the mean of its corners. Throws InvalidInput for a list that is cut off, and a corner that is no
// point.
double polyhedron_volume(std::span<const std::uint32_t> faces, std::span<const Vec3d> points);

// Returns 1 if the mean of a polyhedron's corners sees each of its faces from inside: the pyramids from there over all
// faces have a volume above 0. -1: none has. 0: some have, so the cell is tangled in a part, or far from convex.
// `faces` and errors as above. Not exact: by the signs of sums of doubles.
int polyhedron_orientation(std::span<const std::uint32_t> faces, std::span<const Vec3d> points);

// The cells of a volume mesh, or of a mesh of two dimensions.
struct VolumeCells {
  Cells cells;                               // linear, or the corners of cells of the second order
  MiddleNodes middles;                       // of those
  std::vector<std::uint32_t> on_surfaces{};  // points of faces that the file names, also those within the mesh
  // Of OpenFOAM all cells, each as polyhedron_volume() takes it.
  std::vector<std::vector<std::uint32_t>> polyhedra{};
  // How many of the linear cells are those of the third order and above, without their nodes.
  std::size_t by_corners = 0;
  // Cells of two dimensions stand as prisms of one layer, as OpenFOAM has them: of n points the number n + i is the
  // i-th one, lifted along z, and 2 n + i the middle between the two.
  bool is_flat = false;

  // Returns the number of all cells.
  std::size_t size() const { return cells.size() + polyhedra.size(); }
};

// Appends a triangle or quadrilateral of a mesh of two dimensions, whose z are all alike, to cells that have no others.
// Its side is that which it shows at these points. `corners`: around; `middles`: for each edge the middle node, or
// none. Throws InvalidInput for a number that is no point, other numbers of nodes, and more than 2^30 points.
void add_flat_cell(std::span<const std::uint32_t> corners, std::span<const std::uint32_t> middles,
                   std::span<const Vec3d> points, VolumeCells& cells);

// Whether the cells of a volume mesh are good. The members are keys of `knead check --json`.
struct CellCheck {
  std::size_t cells = 0;
  std::size_t inverted = 0;    // in a corner or a middle node at least
  std::size_t by_corners = 0;  // how many are of the third order and above: judged by their corners
  // With the middle nodes of cells of the second order; nothing for OpenFOAM's cells.
  std::optional<double> least_scaled_jacobian{};
  double max_non_orthogonality_deg = 0;  // these four as checkMesh of OpenFOAM has them
  double mean_non_orthogonality_deg = 0;
  double max_skewness = 0;
  double max_aspect_ratio = 0;
};

// Judges the cells. Throws InvalidInput for a cell that names no point.
CellCheck check_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads = 0);

// Returns how many cells a deformation has inverted: a corner has turned, or a middle node or a polyhedron is inverted
// now and was not before. A linear cell that looked to the other side as a whole counts as well: SU2 has such meshes.
std::size_t count_inverted_since(const VolumeCells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                                 int threads = 0);

// Returns whether the wedges look inward, as gmsh numbers them: at least nine of ten do, and not all other cells.
bool wedges_look_inward(const Cells& cells, std::span<const Vec3d> points);

// Returns 1 for each cell that is inverted in a corner or a middle node: linear cells, then polyhedra.
std::vector<std::uint8_t> inverted_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads = 0);

}  // namespace knead
