// The cells of a data set, as the library judges them.
#pragma once

#include <vtkType.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "knead/cells.h"
#include "knead/mesh.h"

class vtkPointSet;

namespace knead::paraview {

// The cells of a data set that have a volume. Of quadratic cells the corners.
struct VolumeCells {
  Cells linear;
  std::vector<vtkIdType> linear_numbers;  // in the data set
  std::vector<std::uint32_t> faces;       // of all polyhedra, as polyhedron_volume() takes them
  std::vector<std::size_t> first{0};      // where each polyhedron begins in `faces`, and the end of the last
  std::vector<vtkIdType> polyhedron_numbers;
  std::vector<std::uint8_t> is_counted;  // for each cell of the data set: 0 for ghosts and blanked cells

  bool empty() const { return linear_numbers.empty() && polyhedron_numbers.empty(); }
};

// Returns the cells of a data set. Throws InvalidInput if a point's number does not fit into 32 bits.
VolumeCells volume_cells(vtkPointSet& set);

// What a deformation did to the cells of a data set. The vectors are empty if only the inversions were asked for.
struct Damage {
  std::vector<double> volume_ratio;     // NaN for cells without volume
  std::vector<double> scaled_jacobian;  // NaN also for polyhedra
  std::vector<double> non_orthogonality_deg;
  std::vector<double> skewness;
  std::int64_t inverted = 0;  // of the cells that are counted
  vtkIdType first = -1;       // of the inverted ones
};
Damage damage_of(const VolumeCells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                 CellValues values);

// Returns count_cells_unresolved_in_float() of the cells, ghosts included.
std::size_t unresolved_cells(const VolumeCells& cells, std::span<const Vec3d> points);

// Appends the corners of the faces that only one of the cells has: 12 coordinates for each, in ascending order, those
// of a missing fourth corner infinite. Ghosts and polyhedra do not count.
void add_boundary_faces(const VolumeCells& cells, std::span<const Vec3d> points, std::vector<double>& faces);

// Returns the corners of those faces that are there once. A face between two ranks or blocks is there twice.
std::vector<Vec3d> corners_of_single_faces(std::span<const double> faces);

}  // namespace knead::paraview
