// PLY, ascii and binary: reading, writing back, writing anew.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

ShapeFile parse_ply(std::string bytes, const std::string& name);

// The source with other positions and normals (one per vertex; empty: none, or left as they are).
std::string rewrite_ply(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions& options);

// A new binary little-endian file.
std::string generate_ply(const Mesh& mesh, const WriteOptions& options);

// What generate_ply leaves out, a sentence each.
std::vector<std::string> ply_losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> ply_source_losses(const ShapeFile& source);

// The numbers of one element: for each property those of all rows, one after the other; ends[p][row] is the end of the
// row's list in values[p]. row_begin: the first byte of each row, then the byte after the last.
struct PlyColumns {
  std::vector<std::vector<double>> values;
  std::vector<std::vector<std::size_t>> ends;
  std::vector<std::size_t> row_begin;
};

// Makes the mesh and its notes of what the body held. The columns, one per element, are used up.
void build_ply_mesh(ShapeFile& shape, std::vector<PlyColumns>& columns, const std::string& name);

// Whether a list holds the vertices of faces, or of strips of triangles.
bool is_index_list(const PlyElement& element, const PlyProperty& property);

// Throws InvalidInput for the byte at `position`.
[[noreturn]] void fail_in_ply(std::string_view bytes, const PlyLayout& layout, std::size_t position,
                              const std::string& name, const std::string& what);

}  // namespace knead
