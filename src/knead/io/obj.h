// Wavefront OBJ: reading, writing back, writing anew.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

ShapeFile parse_obj(std::string bytes, const std::string& name);

// The source with other positions and normals: one for each corner (moved_corner_normals), or none. Coordinates are
// always written as doubles, whatever the options say. Where corners that shared a line `vn` have turned apart, new
// lines are put in before the face that needs them first, and the faces' third numbers say which; not in a file whose
// faces stand before the normals that they use, where such corners keep one line.
std::string rewrite_obj(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                        const WriteOptions& options);

// A new file.
std::string generate_obj(const Mesh& mesh, const WriteOptions& options);

// What generate_obj leaves out, a sentence each.
std::vector<std::string> obj_losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> obj_source_losses(const ShapeFile& source);

// The byte at which the lines begin: after a byte order mark.
std::size_t first_obj_byte(std::string_view bytes);

// The first byte at or after `position` on the same line that is no blank; a backslash at the end of a line joins the
// next line to it.
std::size_t skip_obj_blanks(std::string_view bytes, std::size_t position);

// The line end at or after `position`, or the end of the text.
std::size_t obj_line_end(std::string_view bytes, std::size_t position);

// The byte after the token that begins at `position`.
std::size_t obj_token_end(std::string_view bytes, std::size_t position);

}  // namespace knead
