// Wavefront OBJ: its row of the format table (formats.h), and the words of its lines.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::obj {

ShapeFile parse(std::string bytes, const std::string& name);

// `normals`: one for each corner (moved_corner_normals), or none. Writes coordinates as doubles, whatever the options
// say. Where corners that shared a line `vn` have turned differently, adds lines before the first face that needs them
// and changes the third numbers of the faces. In a file whose faces stand before the normals that they use, such
// corners keep one line.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);
std::string generate(const Mesh& mesh, const WriteOptions& options);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// The byte at which the lines begin: after a byte order mark.
std::size_t first_byte(std::string_view bytes);

// The first byte at or after `position` on the same line that is no blank; a backslash at the end of a line joins the
// next line to it.
std::size_t skip_blanks(std::string_view bytes, std::size_t position);

// The line end at or after `position`, or the end of the text.
std::size_t end_of_line(std::string_view bytes, std::size_t position);

// The byte after the token that begins at `position`.
std::size_t word_end(std::string_view bytes, std::size_t position);

}  // namespace knead::io_detail::obj
