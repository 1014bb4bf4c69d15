// OFF (Geomview, Object File Format), text and binary: reading, writing back, writing anew.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

// [ST][C][N][n]OFF, the letters in any order, or no keyword: the counts, then a vertex on each line, then a face on
// each. Attributes: "normal" (N), "uv" (ST), "color" of vertices (C, or three or four more numbers than the keyword
// says) and of faces, "color_index" of faces with one number each; colors are uint8 where all are whole numbers.
// OFF BINARY is read in either byte order, and with the count of color numbers after each face or without (as PMP
// writes), whichever takes up the whole file.
ShapeFile parse_off(std::string bytes, const std::string& name);

// The source with other positions and normals (one per vertex; empty: none, or left as they are). Numbers in a binary
// file are rounded to floats; throws InvalidInput where a position does not fit.
std::string rewrite_off(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions& options);

// A new text file. A color of a vertex with three numbers gets an alpha: COFF means four.
std::string generate_off(const Mesh& mesh, const WriteOptions& options);

// What generate_off leaves out, a sentence each.
std::vector<std::string> off_losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> off_source_losses(const ShapeFile& source);

}  // namespace knead
