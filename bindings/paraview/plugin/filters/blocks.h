// The data sets of the filter's input, and their copies in its output.
#pragma once

#include <vtkSmartPointer.h>

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
  std::string name;  // for messages; empty for the only one
  vtkSmartPointer<vtkPointSet> set;
  std::vector<Vec3d> before;
  std::vector<Vec3d> after;  // rounded if the points of `set` are floats
};

// Returns the type of the filter's output for this input (vtkType.h): a structured grid for an image or a rectilinear
// grid, else that of the input; -1 for an input that the filter does not take.
int output_type(vtkDataObject& input);

// Copies the input to `output`, which is empty. Images and rectilinear grids become structured grids; voxels and pixels
// of unstructured grids become hexahedra and quadrilaterals. Returns the data sets of the copy that have points.
std::vector<Block> copy_blocks(vtkDataObject& input, vtkDataObject& output);

// Returns true if the points are floats.
bool stores_floats(const Block& block);

// Rounds points as the block stores them.
void round_points(const Block& block, std::span<Vec3d> points);

// Gives the block's data set the points `after`.
void store_points(Block& block);

// Replaces the named vectors v at the points (arrays with three components) by J v, with the J of each point. Ignores
// names that the block does not have; returns the number of those that it has.
std::size_t carry_vectors(Block& block, std::span<const std::string> names, std::span<const Mat3d> jacobians);

// Transforms normals at the points, and removes those of the cells, which are no longer correct.
void carry_normals(Block& block, std::span<const Mat3d> jacobians);
bool has_point_normals(const Block& block);

// Adds an array of doubles to the points or cells of the block.
void add_point_array(Block& block, const char* name, std::span<const double> values);
void add_cell_array(Block& block, const char* name, std::span<const double> values);

}  // namespace knead::paraview
