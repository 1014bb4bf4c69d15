// Copies data sets of every kind, and stores the points, vectors and normals of their deformed copies.
#include "blocks.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTypes.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <utility>

namespace knead::paraview {
namespace {

bool is_grid_without_points(vtkDataObject& data) {
  return data.IsA("vtkImageData") != 0 || data.IsA("vtkRectilinearGrid") != 0;
}

// The structured grid with the points that an image or rectilinear grid stands for.
vtkSmartPointer<vtkStructuredGrid> curvilinear(vtkDataSet& source, const int* extent) {
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  std::array<int, 6> copied{};
  std::copy(extent, extent + 6, copied.begin());
  grid->SetExtent(copied.data());
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(source.GetNumberOfPoints());
  auto* at = static_cast<double*>(points->GetVoidPointer(0));
  for (vtkIdType i = 0; i < source.GetNumberOfPoints(); ++i) source.GetPoint(i, at + 3 * i);
  grid->SetPoints(points);
  grid->GetPointData()->ShallowCopy(source.GetPointData());
  grid->GetCellData()->ShallowCopy(source.GetCellData());
  grid->GetFieldData()->ShallowCopy(source.GetFieldData());
  return grid;
}

// Takes other types and corners of the cells; the faces of polyhedra stay. VTK 9.4 stores these in another way, and its
// function of the old name takes no grid without them.
template <class Grid>
void set_cells(Grid& grid, vtkUnsignedCharArray* types, vtkCellArray* cells) {
  if constexpr (requires { grid.GetPolyhedronFaces(); }) {
    grid.SetPolyhedralCells(types, cells, grid.GetPolyhedronFaceLocations(), grid.GetPolyhedronFaces());
  } else {
    grid.SetCells(types, cells, grid.GetFaceLocations(), grid.GetFaces());
  }
}

// A voxel has axes along those of space, which it loses when it is deformed.
void use_general_cells(vtkUnstructuredGrid& grid) {
  vtkUnsignedCharArray* const types = grid.GetCellTypesArray();
  if (types == nullptr) return;
  const auto is_special = [](unsigned char type) { return type == VTK_VOXEL || type == VTK_PIXEL; };
  const unsigned char* const begin = types->GetPointer(0);
  if (std::none_of(begin, begin + types->GetNumberOfValues(), is_special)) return;
  vtkNew<vtkUnsignedCharArray> own_types;
  own_types->DeepCopy(types);
  vtkNew<vtkCellArray> own_cells;
  own_cells->DeepCopy(grid.GetCells());
  vtkNew<vtkIdList> corners;
  for (vtkIdType i = 0; i < own_types->GetNumberOfValues(); ++i) {
    if (!is_special(own_types->GetValue(i))) continue;
    own_cells->GetCellAtId(i, corners);
    std::swap(*corners->GetPointer(2), *corners->GetPointer(3));
    if (own_types->GetValue(i) == VTK_VOXEL) std::swap(*corners->GetPointer(6), *corners->GetPointer(7));
    own_cells->ReplaceCellAtId(i, corners);
    own_types->SetValue(i, own_types->GetValue(i) == VTK_VOXEL ? VTK_HEXAHEDRON : VTK_QUAD);
  }
  set_cells(grid, own_types, own_cells);
}

vtkSmartPointer<vtkPointSet> copied(vtkDataSet& source) {
  if (auto* const image = vtkImageData::SafeDownCast(&source)) return curvilinear(source, image->GetExtent());
  if (auto* const grid = vtkRectilinearGrid::SafeDownCast(&source)) return curvilinear(source, grid->GetExtent());
  if (vtkPointSet::SafeDownCast(&source) == nullptr) return nullptr;
  auto copy = vtkSmartPointer<vtkPointSet>::Take(vtkPointSet::SafeDownCast(source.NewInstance()));
  copy->ShallowCopy(&source);
  if (auto* const grid = vtkUnstructuredGrid::SafeDownCast(copy)) use_general_cells(*grid);
  return copy;
}

template <class T>
void read_as(const T* numbers, std::vector<Vec3d>& points) {
  for (Vec3d& p : points) {
    p = {static_cast<double>(numbers[0]), static_cast<double>(numbers[1]), static_cast<double>(numbers[2])};
    numbers += 3;
  }
}

void read_points(Block& block) {
  vtkPoints* const stored = block.set->GetPoints();
  if (stored == nullptr) return;
  block.before.resize(static_cast<std::size_t>(stored->GetNumberOfPoints()));
  vtkDataArray* const data = stored->GetData();
  if (auto* const floats = vtkAOSDataArrayTemplate<float>::FastDownCast(data)) {
    read_as(floats->GetPointer(0), block.before);
  } else if (auto* const doubles = vtkAOSDataArrayTemplate<double>::FastDownCast(data)) {
    read_as(doubles->GetPointer(0), block.before);
  } else {
    for (std::size_t i = 0; i < block.before.size(); ++i) {
      std::array<double, 3> p{};
      stored->GetPoint(static_cast<vtkIdType>(i), p.data());
      block.before[i] = {p[0], p[1], p[2]};
    }
  }
}

template <class T>
void write_as(std::span<const Vec3d> points, T* numbers) {
  for (const Vec3d& p : points) {
    for (const double x : {p.x, p.y, p.z}) *numbers++ = static_cast<T>(x);
  }
}

vtkSmartPointer<vtkDoubleArray> array_of(const char* name, std::span<const double> values) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  return array;
}

// Applies change(J, vector) to each vector of an array, in an array of the same type.
template <class Change>
vtkSmartPointer<vtkDataArray> changed(vtkDataArray& source, std::span<const Mat3d> jacobians, const Change& change) {
  auto result = vtkSmartPointer<vtkDataArray>::Take(source.NewInstance());
  result->DeepCopy(&source);
  for (std::size_t i = 0; i < jacobians.size(); ++i) {
    std::array<double, 3> v{};
    result->GetTuple(static_cast<vtkIdType>(i), v.data());
    const Vec3d now = change(jacobians[i], Vec3d{v[0], v[1], v[2]});
    v = {now.x, now.y, now.z};
    result->SetTuple(static_cast<vtkIdType>(i), v.data());
  }
  return result;
}

}  // namespace

int output_type(vtkDataObject& input) {
  if (is_grid_without_points(input)) return VTK_STRUCTURED_GRID;
  const bool is_taken = input.IsA("vtkPointSet") != 0 || input.IsA("vtkDataObjectTree") != 0;
  return is_taken ? input.GetDataObjectType() : -1;
}

std::vector<Block> copy_blocks(vtkDataObject& input, vtkDataObject& output) {
  std::vector<Block> blocks;
  if (auto* const set = vtkDataSet::SafeDownCast(&input)) {
    blocks.push_back({{}, copied(*set), {}, {}});
    output.ShallowCopy(blocks.back().set);
    blocks.back().set = vtkPointSet::SafeDownCast(&output);
  } else {
    auto& from = *vtkDataObjectTree::SafeDownCast(&input);
    auto& to = *vtkDataObjectTree::SafeDownCast(&output);
    to.CopyStructure(&from);
    to.GetFieldData()->ShallowCopy(from.GetFieldData());
    const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(from.NewIterator());
    for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem()) {
      auto* const leaf = vtkDataSet::SafeDownCast(iterator->GetCurrentDataObject());
      vtkSmartPointer<vtkPointSet> copy = leaf == nullptr ? nullptr : copied(*leaf);
      to.SetDataSet(iterator, copy != nullptr ? copy.Get() : iterator->GetCurrentDataObject());
      if (copy == nullptr) continue;
      const bool has_name =
          iterator->HasCurrentMetaData() != 0 && iterator->GetCurrentMetaData()->Has(vtkCompositeDataSet::NAME()) != 0;
      std::string name = has_name ? iterator->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME()) : "";
      if (name.empty()) name = std::to_string(iterator->GetCurrentFlatIndex());
      blocks.push_back({std::move(name), copy, {}, {}});
    }
  }
  for (Block& block : blocks) read_points(block);
  return blocks;
}

bool stores_floats(const Block& block) {
  return block.set->GetPoints() != nullptr && block.set->GetPoints()->GetDataType() == VTK_FLOAT;
}

void round_points(const Block& block, std::span<Vec3d> points) {
  if (!stores_floats(block)) return;
  const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
  for (Vec3d& p : points) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
}

void store_points(Block& block) {
  if (block.before.empty()) return;
  vtkNew<vtkPoints> points;
  points->SetDataType(stores_floats(block) ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(static_cast<vtkIdType>(block.after.size()));
  if (stores_floats(block)) {
    write_as(block.after, static_cast<float*>(points->GetVoidPointer(0)));
  } else {
    write_as(block.after, static_cast<double*>(points->GetVoidPointer(0)));
  }
  points->GetData()->SetName(block.set->GetPoints()->GetData()->GetName());
  block.set->SetPoints(points);
}

std::size_t carry_vectors(Block& block, std::span<const std::string> names, std::span<const Mat3d> jacobians) {
  std::size_t found = 0;
  for (const std::string& name : names) {
    vtkDataArray* const array = block.set->GetPointData()->GetArray(name.c_str());
    if (array == nullptr || array->GetNumberOfComponents() != 3) continue;
    ++found;
    block.set->GetPointData()->AddArray(
        changed(*array, jacobians, [](const Mat3d& j, const Vec3d& v) { return j * v; }));
  }
  return found;
}

bool has_point_normals(const Block& block) { return block.set->GetPointData()->GetNormals() != nullptr; }

void carry_normals(Block& block, std::span<const Mat3d> jacobians) {
  vtkPointData* const data = block.set->GetPointData();
  if (vtkDataArray* const normals = data->GetNormals()) {
    // The rows of the cofactors of J; what the determinant would divide by is lost in the length.
    data->SetNormals(changed(*normals, jacobians, [](const Mat3d& j, const Vec3d& n) {
      const Vec3d turned{dot(cross(j.row1, j.row2), n), dot(cross(j.row2, j.row0), n), dot(cross(j.row0, j.row1), n)};
      const double length = norm(turned);
      return length > 0 ? turned * (1 / length) : n;
    }));
  }
  vtkCellData* const cells = block.set->GetCellData();
  const vtkDataArray* const normals = cells->GetNormals();
  for (int i = cells->GetNumberOfArrays() - 1; i >= 0 && normals != nullptr; --i) {
    if (cells->GetAbstractArray(i) == normals) cells->RemoveArray(i);  // by its number: it may have no name
  }
}

void add_point_array(Block& block, const char* name, std::span<const double> values) {
  block.set->GetPointData()->AddArray(array_of(name, values));
}

void add_cell_array(Block& block, const char* name, std::span<const double> values) {
  block.set->GetCellData()->AddArray(array_of(name, values));
}

}  // namespace knead::paraview
