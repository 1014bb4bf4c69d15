// Measures a mesh: counts, topology, volume, area, and what a deformation turned over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead {

// Finds the box of a point cloud from its points in any order, with little memory. A few points may lie astray: up to
// 5% of them, at most 64 on each side of each axis, are left out if they lie more than 10 times the extent of all
// others from these. Clouds of fewer than 20 points have no such points.
class CloudBox {
 public:
  // Adds points, whose coordinates are finite.
  void add(std::span<const Vec3d> points);

  // Returns the box of all points that do not lie astray; empty without points.
  Box box() const;

  // Returns the box of all points.
  const Box& whole() const { return whole_; }

 private:
  static constexpr std::size_t kMost = 64;

  std::size_t points_ = 0;
  Box whole_;
  std::array<std::vector<double>, 6> ends_;  // heaps of the lowest and of the highest coordinates on each axis
};

// Returns the box of the vertices that faces use; of a mesh without faces that of its points as CloudBox finds it.
// Time: linear. Lengths that are relative to a shape refer to the diagonal of this box. `positions` takes the place of
// the mesh's own and has one for each vertex.
Box shape_box(const Mesh& mesh);
Box shape_box(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns a sentence about vertices further outside of shape_box() than its diagonal; empty if there are none.
std::string stray_note(const Mesh& mesh);

// What measure() finds. An edge is an unordered pair of different vertices that are consecutive in a face. A face that
// uses an edge twice counts as two faces there.
struct Measures {
  std::size_t vertices = 0;
  std::size_t unused_vertices = 0;  // in no face
  std::size_t faces = 0;
  std::size_t triangles = 0;             // of triangulate(mesh)
  std::size_t degenerate_triangles = 0;  // with a repeated vertex or without area (see is_degenerate)
  std::size_t edges = 0;
  std::size_t boundary_edges = 0;        // with one face
  std::size_t nonmanifold_edges = 0;     // with more than two faces
  std::size_t misoriented_edges = 0;     // used in one direction two or more times more than in the other
  std::size_t nonmanifold_vertices = 0;  // whose faces form several fans
  std::size_t components = 0;            // connected by shared vertices; unused vertices do not count
  std::size_t boundary_loops = 0;
  std::int64_t euler = 0;  // used vertices - edges + faces
  double volume = 0;       // signed; positive if the faces point outward. Meaningful for a closed mesh only
  double area = 0;
  std::optional<double> smallest_angle_deg;  // of the triangles that are not degenerate
  Box box;                                   // of the vertices that faces use (see shape_box)

  // Returns whether there are faces, and no edge has only one.
  bool closed() const { return faces > 0 && boundary_edges == 0; }
  // Returns whether no edge has more than two faces and no vertex lies in several fans.
  bool manifold() const { return nonmanifold_edges == 0 && nonmanifold_vertices == 0; }
  // Returns whether the faces at each edge agree about which side is outside: the numbers of uses in the two directions
  // differ by at most 1. The volume of a closed mesh then does not depend on the origin, even if it is not manifold.
  bool oriented() const { return misoriented_edges == 0; }
};

// Returns the measures of a mesh. Time: linear in the corners, plus a small sort at each vertex. Sums run in the order
// of faces, so every run returns the same bits. Throws InvalidInput where validate(mesh) does.
Measures measure(const Mesh& mesh);

// Returns the same, in a fifth of the time, from the measures of a mesh that has the same faces.
Measures measure(const Mesh& mesh, const Measures& same_faces);

// The volume and the area of a mesh.
struct VolumeAndArea {
  double volume = 0;
  double area = 0;
};
// Returns the volume and area of `mesh` with other positions, one for each vertex, by the same sums as measure().
VolumeAndArea measure_volume_and_area(const Mesh& mesh, std::span<const Vec3d> positions);

// Returns true if the triangle has no area: its height over the longest edge is below 1e-12 times that edge, or two
// corners are equal.
bool is_degenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c);

// Returns the defects of a mesh, one sentence each, e.g. "1 edge has more than two faces"; empty for a closed, manifold
// and oriented mesh without degenerate triangles.
std::vector<std::string> describe_oddities(const Measures& measures);

// Returns the number of flipped triangles. A triangle is flipped if its normal opposes the mean of the vertex normals
// of its corners (negative dot product) with the positions `after`, but not with `before`. A triangle without area is
// never flipped. Polygons are cut into triangles with the positions `before`. Both spans hold one position per vertex.
std::size_t count_flipped(const Mesh& mesh, std::span<const Vec3d> before, std::span<const Vec3d> after);

// Returns the number of folded edges. An edge is folded if it has exactly two triangles, these have the same
// orientation, and the angle between their normals is above 170 degrees. The triangles are those of triangulate(mesh),
// so an edge may lie inside a polygon. Triangles without area (see is_degenerate) are ignored.
std::size_t count_folded_edges(const Mesh& mesh);

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

}  // namespace knead
