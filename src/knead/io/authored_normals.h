// The normals that a file came with, after its shape has moved.
#pragma once

#include <span>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

// One normal per vertex of the source ("normal" of vertices), or empty where it has none.
std::vector<Vec3d> vertex_normals_of(const ShapeFile& source);

// The authored normals of the source after its vertices moved: one per corner of an OBJ file, else one per vertex;
// empty where there are none that follow the shape. Those of shapes with faces are turned by transport_normals;
// vertices that share position and normal, as along a seam, turn together. Those of points are options.normals, if
// given.
std::vector<Vec3d> moved_normals(const ShapeFile& source, std::span<const Vec3d> positions,
                                 const WriteOptions& options);

// The source's mesh at the new positions, its normals and tangents with it.
Mesh moved_mesh(const ShapeFile& source, std::span<const Vec3d> positions, const WriteOptions& options);

}  // namespace knead
