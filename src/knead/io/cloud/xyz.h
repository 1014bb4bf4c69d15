// XYZ, points in text: its row of the format table (formats.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::xyz {

// A point on each line: x y z and any further numbers, between blanks, or between commas or semicolons. Lines that are
// empty or begin with #, % or // are passed over; the number of points and the names of the columns may stand before
// them. Words that are no numbers (labels) may stand before x or after z; points whose coordinates are not finite are
// left out of the mesh. Three further numbers that are of unit length in at least 95% of the lines are "normal", three
// whole numbers from 0 to 255 "color", others "column4" and so on; none if lines differ in how many they have, or have
// more than 64.
ShapeFile parse(std::string bytes, const std::string& name);
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new file: x y z and the normal, or if there is none the color as three numbers from 0 to 255.
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

}  // namespace knead::io_detail::xyz
