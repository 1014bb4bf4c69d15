// XYZ, points in text: reading, writing back, writing anew.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

// A point on each line: x y z and any further numbers, between blanks, or between commas or semicolons. Lines that are
// empty or begin with # or // are passed over; the first line may be the number of points. Three further numbers that
// are of unit length in at least 95% of the lines are "normal", three whole numbers from 0 to 255 "color", others
// "column4" and so on; none where lines have differently many or more than 64.
ShapeFile parse_xyz(std::string bytes, const std::string& name);

// The source with other positions and normals (one per point; empty: none, or left as they are).
std::string rewrite_xyz(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions& options);

// A new file: x y z, and after them the normal, or where there is none the color as three numbers from 0 to 255.
std::string generate_xyz(const Mesh& mesh, const WriteOptions& options);

// What generate_xyz leaves out, a sentence each.
std::vector<std::string> xyz_losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> xyz_source_losses(const ShapeFile& source);

}  // namespace knead
