// The normals of a file after its shape has moved.
#pragma once

#include <span>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead::io_detail {

// Returns the authored normals after the source's vertices moved: one per corner of an OBJ file, else one per vertex;
// empty if the file has none that follow the shape. transport_normals turns those of shapes with faces; vertices with
// the same position and normal, as along a seam, turn together. Normals of points are options.normals, if given.
std::vector<Vec3d> moved_normals(const ShapeFile& source, std::span<const Vec3d> positions,
                                 const WriteOptions& options);

// Returns the source's mesh at the new positions, with its normals and tangents turned.
Mesh moved_mesh(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options);

}  // namespace knead::io_detail
