// XYZ, points in text: its row of the format table (formats.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "knead/io/cloud/layout.h"
#include "knead/io/decimals.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::xyz {

// A point on each line: x y z and any further numbers, between blanks, or between commas or semicolons. Lines that are
// empty or begin with #, % or // are passed over; the number of points and the names of the columns may stand before
// them. Where columns are named x, y and z (table.h says how), these are the coordinates; otherwise they are the first
// three numbers, and a note says which columns these are where more follow. Words that are no numbers (labels) may
// stand in other columns; points whose coordinates are not finite are left out of the mesh. Other columns have their
// names; nx, ny, nz are "normal" and r, g, b from 0 to 255 "color". Without names three further numbers that are of
// unit length in at least 95% of the lines are "normal", three whole numbers from 0 to 255 "color", others "column4"
// and so on; none if lines differ in how many they have, or have more than 64.
ShapeFile parse(std::string bytes, const std::string& name);

// Reads a table into the mesh of `shape`, which has the bytes.
Layout read_table(ShapeFile& shape, const TableStart& start, const std::string& name);
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new file: x y z and the normal, or if there is none the color as three numbers from 0 to 255.
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

}  // namespace knead::io_detail::xyz
