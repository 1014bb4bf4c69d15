// Reads the cells of data sets, measures them after a deformation, and finds faces on the boundary.
#include "cells.h"

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointSet.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "knead/error.h"

namespace knead::paraview {
namespace {

std::optional<CellKind> kind_of(int type) {
  switch (type) {
    case VTK_TETRA:
    case VTK_QUADRATIC_TETRA:
    case VTK_LAGRANGE_TETRAHEDRON:
    case VTK_BEZIER_TETRAHEDRON:
      return CellKind::tetrahedron;
    case VTK_PYRAMID:
    case VTK_QUADRATIC_PYRAMID:
    case VTK_TRIQUADRATIC_PYRAMID:
    case VTK_LAGRANGE_PYRAMID:
    case VTK_BEZIER_PYRAMID:
      return CellKind::pyramid;
    case VTK_WEDGE:
    case VTK_QUADRATIC_WEDGE:
    case VTK_QUADRATIC_LINEAR_WEDGE:
    case VTK_BIQUADRATIC_QUADRATIC_WEDGE:
    case VTK_LAGRANGE_WEDGE:
    case VTK_BEZIER_WEDGE:
      return CellKind::wedge;
    case VTK_HEXAHEDRON:
    case VTK_QUADRATIC_HEXAHEDRON:
    case VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON:
    case VTK_TRIQUADRATIC_HEXAHEDRON:
    case VTK_LAGRANGE_HEXAHEDRON:
    case VTK_BEZIER_HEXAHEDRON:
      return CellKind::hexahedron;
    default:
      return std::nullopt;
  }
}

void add_polyhedron(vtkUnstructuredGrid& grid, vtkIdType cell, vtkIdList* stream, VolumeCells& cells) {
  grid.GetFaceStream(cell, stream);  // the number of faces, then for each its number of corners and these
  const vtkIdType* const numbers = stream->GetPointer(0);
  if (stream->GetNumberOfIds() > 0)
    cells.faces.insert(cells.faces.end(), numbers + 1, numbers + stream->GetNumberOfIds());
  cells.first.push_back(cells.faces.size());
  cells.polyhedron_numbers.push_back(cell);
}

// The cells of a data set; those of an unstructured grid without a call for each.
class CellReader {
 public:
  explicit CellReader(vtkPointSet& set) : set_(set) {
    auto* const grid = vtkUnstructuredGrid::SafeDownCast(&set);
    if (grid == nullptr || grid->GetCellTypesArray() == nullptr) return;
    types_ = grid->GetCellTypesArray()->GetPointer(0);
    array_ = grid->GetCells();
  }

  int type_of(vtkIdType cell) const { return types_ != nullptr ? types_[cell] : set_.GetCellType(cell); }

  // Valid until the next call.
  std::span<const vtkIdType> points_of(vtkIdType cell) {
    vtkIdType size = 0;
    const vtkIdType* numbers = nullptr;
    if (array_ != nullptr) {
      array_->GetCellAtId(cell, size, numbers, list_);
    } else {
      set_.GetCellPoints(cell, size, numbers, list_);
    }
    return {numbers, static_cast<std::size_t>(size)};
  }

 private:
  vtkPointSet& set_;
  const unsigned char* types_ = nullptr;
  vtkCellArray* array_ = nullptr;
  vtkNew<vtkIdList> list_;
};

// Makes room for cells of the given kinds, so that large vectors need not grow.
void reserve(Cells& cells, const CellReader& reader, vtkIdType count) {
  std::size_t linear = 0;
  std::size_t corners = 0;
  for (vtkIdType i = 0; i < count; ++i) {
    const std::optional<CellKind> kind = kind_of(reader.type_of(i));
    if (!kind) continue;
    ++linear;
    corners += corner_count(*kind);
  }
  cells.kinds.reserve(linear);
  cells.first.reserve(linear + 1);
  cells.corners.reserve(corners);
}

std::vector<std::span<const std::uint32_t>> polyhedra_of(const VolumeCells& cells) {
  std::vector<std::span<const std::uint32_t>> polyhedra;
  for (std::size_t i = 0; i < cells.polyhedron_numbers.size(); ++i) {
    polyhedra.push_back(std::span(cells.faces).subspan(cells.first[i], cells.first[i + 1] - cells.first[i]));
  }
  return polyhedra;
}

// Neighbours that are ghosts count.
void judge_faces(const VolumeCells& cells, std::span<const Vec3d> points, Damage& damage) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  damage.non_orthogonality_deg.assign(cells.is_counted.size(), none);
  damage.skewness.assign(cells.is_counted.size(), none);
  const CellFaceQuality quality = cell_face_quality(cells.linear, points, polyhedra_of(cells));
  const std::size_t linear = cells.linear.size();
  for (std::size_t i = 0; i < quality.skewness.size(); ++i) {
    const vtkIdType number = i < linear ? cells.linear_numbers[i] : cells.polyhedron_numbers[i - linear];
    damage.non_orthogonality_deg[static_cast<std::size_t>(number)] = quality.non_orthogonality_deg[i];
    damage.skewness[static_cast<std::size_t>(number)] = quality.skewness[i];
  }
}

}  // namespace

VolumeCells volume_cells(vtkPointSet& set) {
  if (set.GetNumberOfPoints() > std::numeric_limits<std::uint32_t>::max()) {
    throw InvalidInput("a part has over 4 thousand million points; use more ranks");
  }
  VolumeCells cells;
  const vtkIdType count = set.GetNumberOfCells();
  cells.is_counted.assign(static_cast<std::size_t>(count), 1);
  vtkUnsignedCharArray* const ghosts = set.GetCellGhostArray();
  auto* const grid = vtkUnstructuredGrid::SafeDownCast(&set);
  constexpr int hidden = vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::HIDDENCELL;
  CellReader reader(set);
  reserve(cells.linear, reader, count);
  cells.linear_numbers.reserve(cells.linear.kinds.capacity());
  std::array<std::uint32_t, 8> corners{};
  vtkNew<vtkIdList> stream;
  for (vtkIdType i = 0; i < count; ++i) {
    if (ghosts != nullptr && (ghosts->GetValue(i) & hidden) != 0) cells.is_counted[static_cast<std::size_t>(i)] = 0;
    const int type = reader.type_of(i);
    if (type == VTK_POLYHEDRON && grid != nullptr) add_polyhedron(*grid, i, stream, cells);
    const std::optional<CellKind> kind = kind_of(type);
    if (!kind) continue;
    const std::span<const vtkIdType> numbers = reader.points_of(i);
    const std::size_t used = corner_count(*kind);
    if (numbers.size() < used) continue;
    std::transform(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(used), corners.begin(),
                   [](vtkIdType n) { return static_cast<std::uint32_t>(n); });
    cells.linear.add(*kind, std::span(corners).first(used));
    cells.linear_numbers.push_back(i);
  }
  return cells;
}

Damage damage_of(const VolumeCells& cells, std::span<const Vec3d> before, std::span<const Vec3d> after,
                 CellValues values) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const bool has_values = values == CellValues::all;
  const std::size_t valued = has_values ? cells.is_counted.size() : 0;
  Damage damage{std::vector<double>(valued, none), std::vector<double>(valued, none), {}, {}};
  if (has_values) judge_faces(cells, after, damage);
  const auto invert = [&](vtkIdType number) {
    if (cells.is_counted[static_cast<std::size_t>(number)] == 0) return;
    if (damage.inverted++ == 0 || number < damage.first) damage.first = number;
  };
  const CellChanges changes = compare_cells(cells.linear, before, after, 0, values);
  for (std::size_t i = 0; i < cells.linear.size(); ++i) {
    const auto number = static_cast<std::size_t>(cells.linear_numbers[i]);
    if (has_values) {
      damage.volume_ratio[number] = changes.volume_ratio[i];
      damage.scaled_jacobian[number] = changes.scaled_jacobian[i];
    }
    if (changes.is_inverted[i] != 0) invert(cells.linear_numbers[i]);
  }
  const std::vector<std::span<const std::uint32_t>> polyhedra = polyhedra_of(cells);
  for (std::size_t i = 0; i < polyhedra.size(); ++i) {
    const std::span<const std::uint32_t> faces = polyhedra[i];
    const double was = polyhedron_volume(faces, before);
    const double ratio = polyhedron_volume(faces, after) / was;
    const int side = polyhedron_orientation(faces, before);
    if (has_values) damage.volume_ratio[static_cast<std::size_t>(cells.polyhedron_numbers[i])] = ratio;
    const bool is_tangled = side != 0 && polyhedron_orientation(faces, after) != side;
    if (is_tangled || (was != 0 && !(ratio > 0))) invert(cells.polyhedron_numbers[i]);
  }
  return damage;
}

std::size_t unresolved_cells(const VolumeCells& cells, std::span<const Vec3d> points) {
  return count_cells_unresolved_in_float(cells.linear, points, polyhedra_of(cells));
}

void add_boundary_faces(const VolumeCells& cells, std::span<const Vec3d> points, std::vector<double>& faces) {
  constexpr double none = std::numeric_limits<double>::infinity();
  Cells counted;
  for (std::size_t i = 0; i < cells.linear.size(); ++i) {
    if (cells.is_counted[static_cast<std::size_t>(cells.linear_numbers[i])] == 0) continue;
    counted.add(cells.linear.kinds[i], cells.linear.corners_of(i));
  }
  for (const CellBoundaryFace& face : boundary_faces(counted, points.size())) {
    std::array<std::array<double, 3>, 4> corners{};
    std::transform(face.begin(), face.end(), corners.begin(), [&](std::uint32_t v) {
      return v == kNoCorner ? std::array{none, none, none} : std::array{points[v].x, points[v].y, points[v].z};
    });
    std::sort(corners.begin(), corners.end());
    for (const std::array<double, 3>& corner : corners) faces.insert(faces.end(), corner.begin(), corner.end());
  }
}

std::vector<Vec3d> corners_of_single_faces(std::span<const double> faces) {
  using Face = std::array<double, 12>;
  std::vector<Face> sorted(faces.size() / 12);
  for (std::size_t i = 0; i < sorted.size(); ++i) std::copy_n(faces.begin() + 12 * i, 12, sorted[i].begin());
  std::sort(sorted.begin(), sorted.end());
  std::vector<Vec3d> corners;
  for (std::size_t i = 0; i < sorted.size();) {
    std::size_t end = i;
    while (end < sorted.size() && sorted[end] == sorted[i]) ++end;
    for (std::size_t k = 0; k < 12 && end - i == 1 && sorted[i][k] < std::numeric_limits<double>::infinity(); k += 3) {
      corners.push_back({sorted[i][k], sorted[i][k + 1], sorted[i][k + 2]});
    }
    i = end;
  }
  return corners;
}

}  // namespace knead::paraview
