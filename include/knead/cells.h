// The cells of volume meshes: their quality, and what a deformation does to it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead {

// Linear cells of volume meshes, their corners in the order of VTK.
enum class CellKind { tetrahedron, pyramid, wedge, hexahedron };

// Returns 4, 5, 6 or 8.
std::size_t corner_count(CellKind kind);

// The quality of a cell.
struct CellQuality {
  double volume = 0;  // between its bilinear faces; below 0 for a cell that is inside out
  // The least over its corners (of a pyramid without its apex) of the determinant of the three edges there divided by
  // the product of their lengths, scaled so that a cell with equal edges has 1. 0 if an edge has no length.
  double scaled_jacobian = 0;
  // 1: the three edges at all these corners are right-handed, as in a valid cell; -1: at none; 0: at some, or flat.
  // Exact.
  int orientation = 0;
};

// Returns the quality of a cell. Throws InvalidInput for another number of corners, and for coordinates that are not
// finite or beyond 1e75. The scaled Jacobian is that of the Verdict library (Stimpson et al., 2007) at the corners;
// that library also measures the centre of a hexahedron, and measures pyramids differently.
CellQuality cell_quality(CellKind kind, std::span<const Vec3d> corners);

// The linear cells of a volume mesh.
struct Cells {
  std::vector<CellKind> kinds;
  std::vector<std::size_t> first{0};   // of each cell: the index of its first corner; then the number of corners
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

// Returns the edges of a cell of this kind: pairs of corners, in VTK's order of the middle nodes of second-order cells.
std::span<const std::array<std::uint8_t, 2>> edges_of(CellKind kind);

// The middle nodes of second-order cells.
struct MiddleNodes {
  std::vector<std::size_t> cells;     // the numbers of these cells, ascending
  std::vector<std::size_t> first{0};  // of each of them: the index of its first node; then the number of nodes
  std::vector<std::uint32_t> points;  // one for each of edges_of() the cell
};

// Returns for each of these cells the least scaled Jacobian of its second-order map at its corners and middle nodes,
// without a pyramid's apex: at most 1; 0 or less for a folded cell. A cell whose middle nodes are the midpoints of
// straight edges has nearly the value of cell_quality(). Ignores nodes inside faces and cells. Throws InvalidInput for
// a number that is no point.
std::vector<double> middle_jacobians(const Cells& cells, const MiddleNodes& middles, std::span<const Vec3d> points,
                                     int threads = 0);

// The values that compare_cells() computes.
enum class CellValues { all, inversions };

// What a deformation did to cells: a value for each. volume_ratio and scaled_jacobian are empty for
// CellValues::inversions.
struct CellChanges {
  std::vector<double> volume_ratio;         // the volume after divided by the volume before; not finite if that was 0
  std::vector<double> scaled_jacobian;      // after; negated for a cell that was inside out before
  std::vector<std::uint8_t> is_inverted{};  // 1: a corner has turned; 0 for a cell that was flat or mixed before
  std::size_t inverted = 0;                 // the number of inverted cells
};

// Compares cells before and after a deformation. The result is the same for every number of threads. A cell whose
// points all rest is measured once for all values, and not at all for inversions. Throws InvalidInput with the cell's
// number for a corner that is no point, and where cell_quality() does for a cell that is measured.
CellChanges compare_cells(const Cells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                          int threads = 0, CellValues values = CellValues::all);

// The quality of cells for a finite volume method: for each cell the worst value of its faces, by the definitions of
// OpenFOAM's checkMesh.
struct CellFaceQuality {
  // The angle between the normal of a face and the line from its cell's centre to the neighbour's, in degrees from 0 to
  // 180; 0 for a cell without a neighbour. checkMesh complains above 70.
  std::vector<double> non_orthogonality_deg;
  // The distance of that line from the face's centre, divided by the size of the face in that direction; at the
  // boundary the line is along the normal. 0 or more; checkMesh complains above 4 inside, and above 20 at the boundary.
  std::vector<double> skewness;
  // The ratio of the areas of the cell's projections along x, y and z; or a sixth of their sum divided by the volume to
  // the power 2/3, if that is greater. 1 for a cube; checkMesh complains above 1000.
  std::vector<double> aspect_ratio;
  // The angle whose cosine is the mean of the cosines at all faces between two cells.
  double mean_non_orthogonality_deg = 0;
};

// Returns these values for the cells, then for the polyhedra (each a list of faces as for polyhedron_volume()). Cells
// are neighbours if they have a face with the same points. If all cells are inside out, the values are those of the
// mirror image; faces of polyhedra must look outward. The result is the same for every number of threads. Throws
// InvalidInput for a corner that is no point, and for an incomplete list of faces.
CellFaceQuality cell_face_quality(const Cells& cells, std::span<const Vec3d> points,
                                  std::span<const std::span<const std::uint32_t>> polyhedra = {}, int threads = 0);

// Returns the number of cells and polyhedra with an edge shorter than 1e4 epsilons of float32 (1.2e-3) times the
// greatest coordinate of its ends: rounding coordinates to float changes such an edge by up to 1e-4 of its length.
// Throws as cell_face_quality().
std::size_t count_cells_unresolved_in_float(const Cells& cells, std::span<const Vec3d> points,
                                            std::span<const std::span<const std::uint32_t>> polyhedra = {},
                                            int threads = 0);

// Returns the points on the boundary of a volume mesh, ascending: corners of a face that belongs to one cell only, or
// to more than two. Below 2^32 cells. Throws InvalidInput for a corner that is not below `points`.
std::vector<std::uint32_t> boundary_points(const Cells& cells, std::size_t points, int threads = 0);

// The corners of a face of a volume mesh, ascending. The fourth of a triangle is kNoCorner.
using CellBoundaryFace = std::array<std::uint32_t, 4>;
constexpr std::uint32_t kNoCorner = 0xffffffff;

// Returns the faces on the boundary of a volume mesh, ascending: those that belong to one cell only, or to more than
// two. Below 2^32 cells. Throws InvalidInput for a corner that is not below `points`.
std::vector<CellBoundaryFace> boundary_faces(const Cells& cells, std::size_t points, int threads = 0);

// Returns the volume between the faces of a polyhedron. `faces`: [n, v1 ... vn, n, ...]; each looks outward and is cut
// into triangles around the mean of its corners. Throws InvalidInput for an incomplete list, and for a corner that is
// no point.
double polyhedron_volume(std::span<const std::uint32_t> faces, std::span<const Vec3d> points);

// Returns 1 if the pyramids from the mean of a polyhedron's corners to all its faces have a volume above 0; -1 if none
// has; 0 if some have: the cell is partly inverted, or far from convex. `faces` and errors as above. Not exact: decides
// by the signs of sums of doubles.
int polyhedron_orientation(std::span<const std::uint32_t> faces, std::span<const Vec3d> points);

// The cells of a volume mesh, or of a mesh of two dimensions.
struct VolumeCells {
  Cells cells;                               // linear cells, and the corners of second-order cells
  MiddleNodes middles;                       // of the second-order cells
  std::vector<std::uint32_t> on_surfaces{};  // points of faces that the file names, also of faces inside the mesh
  // All cells of OpenFOAM, each a list of faces as for polyhedron_volume().
  std::vector<std::vector<std::uint32_t>> polyhedra{};
  // The number of linear cells that represent cells of third and higher order by their corners.
  std::size_t by_corners = 0;
  // Cells of two dimensions are represented by one layer of prisms, as in OpenFOAM: of n points, number n + i is point
  // i moved along z, and 2 n + i the middle between the two.
  bool is_flat = false;

  // Returns the number of all cells.
  std::size_t size() const { return cells.size() + polyhedra.size(); }
};

// Appends a triangle or quadrilateral of a mesh of two dimensions, with one z for all points, to cells that are all of
// this kind. The orientation of the prism follows from the points. `corners`: in order around the cell; `middles`: the
// middle node of each edge, or empty. Throws InvalidInput for a number that is no point, other numbers of nodes, and
// more than 2^30 points.
void add_flat_cell(std::span<const std::uint32_t> corners, std::span<const std::uint32_t> middles,
                   std::span<const Vec3d> points, VolumeCells& cells);

// The quality of a volume mesh. The members are keys of `knead check --json`.
struct CellCheck {
  std::size_t cells = 0;
  std::size_t inverted = 0;    // at one corner or middle node at least
  std::size_t by_corners = 0;  // cells of third and higher order: measured by their corners
  // Includes the middle nodes of second-order cells; nothing for OpenFOAM's cells.
  std::optional<double> least_scaled_jacobian{};
  double max_non_orthogonality_deg = 0;  // these four as defined by OpenFOAM's checkMesh
  double mean_non_orthogonality_deg = 0;
  double max_skewness = 0;
  double max_aspect_ratio = 0;
};

// Measures the cells. Throws InvalidInput for a cell with a corner that is no point.
CellCheck check_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads = 0);

// Returns the number of cells that a deformation has inverted: a corner has turned, or a middle node or a polyhedron is
// inverted now and was not before. Linear cells that were inside out before, as in some SU2 meshes, count if they turn.
std::size_t count_inverted_since(const VolumeCells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                                 int threads = 0);

// Returns true if the wedges look inward, as gmsh numbers them: at least nine of ten do, and not all other cells.
bool wedges_look_inward(const Cells& cells, std::span<const Vec3d> points);

// Returns 1 for each cell that is inverted at a corner or a middle node: first linear cells, then polyhedra.
std::vector<std::uint8_t> inverted_cells(const VolumeCells& cells, std::span<const Vec3d> points, int threads = 0);

}  // namespace knead
