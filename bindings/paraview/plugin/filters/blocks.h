// The data sets that the filter's input consists of, and their copies in its output.
#pragma once

#include <vtkSmartPointer.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "knead/vec.h"

class vtkDataArray;
class vtkDataObject;
class vtkDataSet;
class vtkPointSet;

namespace knead::paraview {

// One data set with points.
struct Block {
  std::string name;  // for messages; empty: the only one
  vtkSmartPointer<vtkPointSet> set;
  std::vector<Vec3d> before;
  std::vector<Vec3d> after;  // as `set` stores them: rounded, if its points are floats
};

// Returns the kind of data object that the filter makes of such an input (vtkType.h): the same, but a structured grid
// of an image or a rectilinear grid. -1: it takes no such input.
int output_type(vtkDataObject& input);

// Makes `output`, which is empty, a copy of the input, but for its points: images and rectilinear grids become
// structured grids, and voxels and pixels of unstructured grids become hexahedra and quadrilaterals. Returns the data
// sets in it that have points.
std::vector<Block> copy_blocks(vtkDataObject& input, vtkDataObject& output);

// Returns whether the points are floats.
bool stores_floats(const Block& block);

// Rounds points as the block stores them.
void round_points(const Block& block, std::span<Vec3d> points);

// Gives the block's data set the points `after`.
void store_points(Block& block);

// Replaces the named vectors at the points (arrays with three components) by J v, with the J of each point. Names that
// the block does not have are left out; returns how many it has.
std::size_t carry_vectors(Block& block, std::span<const std::string> names, std::span<const Mat3d> jacobians);

// Turns normals at the points, and drops those of the cells, which no longer hold.
void carry_normals(Block& block, std::span<const Mat3d> jacobians);
bool has_point_normals(const Block& block);

// Adds an array of doubles to the points or cells of the block.
void add_point_array(Block& block, const char* name, std::span<const double> values);
void add_cell_array(Block& block, const char* name, std::span<const double> values);

}  // namespace knead::paraview
