// The cells of a data set, and their quality after a deformation.
#pragma once

#include <vtkType.h>

#include <cstdint>
#include <span>
#include <vector>

#include "knead/cells.h"
#include "knead/mesh.h"

class vtkPointSet;

namespace knead::paraview {

// The cells of a data set that have a volume. Quadratic cells are represented by their corners.
struct VolumeCells {
  Cells linear;
  std::vector<vtkIdType> linear_numbers;  // in the data set
  std::vector<std::uint32_t> faces;       // of all polyhedra, each as for polyhedron_volume()
  std::vector<std::size_t> first{0};      // of each polyhedron: the index of its first number in `faces`; and the end
  std::vector<vtkIdType> polyhedron_numbers;
  std::vector<std::uint8_t> is_counted;  // for each cell of the data set: 0 for ghosts and blanked cells

  bool empty() const { return linear_numbers.empty() && polyhedron_numbers.empty(); }
};

// Returns the cells of a data set. Throws InvalidInput if a point's number does not fit into 32 bits.
VolumeCells volume_cells(vtkPointSet& set);

// What a deformation did to the cells of a data set. The vectors are empty for CellValues::inversions.
struct Damage {
  std::vector<double> volume_ratio;     // NaN for cells without volume
  std::vector<double> scaled_jacobian;  // NaN also for polyhedra
  std::vector<double> non_orthogonality_deg;
  std::vector<double> skewness;
  std::int64_t inverted = 0;  // counted cells
  vtkIdType first = -1;       // the first inverted cell
};
Damage damage_of(const VolumeCells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                 CellValues values);

// Returns count_cells_unresolved_in_float() of the cells, ghosts included.
std::size_t unresolved_cells(const VolumeCells& cells, std::span<const Vec3d> points);

// Appends the corners of the faces that belong to one cell only: 12 coordinates for each, in ascending order; those of
// a missing fourth corner are infinite. Ignores ghosts and polyhedra.
void add_boundary_faces(const VolumeCells& cells, std::span<const Vec3d> points, std::vector<double>& faces);

// Returns the corners of the faces that occur once. A face between two ranks or blocks occurs twice.
std::vector<Vec3d> corners_of_single_faces(std::span<const double> faces);

}  // namespace knead::paraview
