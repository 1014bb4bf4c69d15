// OFF (Geomview, Object File Format), text and binary: its row of the format table (formats.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::off {

// [ST][C][N][n]OFF, the letters in any order, or no keyword: the counts, then a vertex on each line, then a face on
// each. Attributes: "normal" (N), "uv" (ST), "color" of vertices (C, or three or four more numbers than the keyword
// says) and of faces, "color_index" of faces with one number each; colors are uint8 where all are whole numbers.
// OFF BINARY is read in either byte order, and with the count of color numbers after each face or without (as PMP
// writes), whichever takes up the whole file.
ShapeFile parse(std::string bytes, const std::string& name);

// Rounds numbers in a binary file to floats; throws InvalidInput for a position that does not fit.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new text file. A color of a vertex with three numbers gets an alpha: COFF means four.
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);
bool stores_floats(const ShapeFile& source);

}  // namespace knead::io_detail::off
