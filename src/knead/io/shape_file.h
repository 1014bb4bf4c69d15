// Shapes in files: PLY, OBJ, GLB, STL, OFF and XYZ. A shape is written back into its own format by copying the bytes it
// was read from and replacing only the numbers that changed, so everything that Knead does not understand survives.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "knead/io/glb_layout.h"
#include "knead/io/obj_layout.h"
#include "knead/io/off_layout.h"
#include "knead/io/ply_layout.h"
#include "knead/io/stl_layout.h"
#include "knead/io/xyz_layout.h"
#include "knead/mesh/mesh.h"

namespace knead {

// A mesh together with the file that it came from. `bytes` and `layout` belong to the readers and writers.
// Attributes of the mesh: "normal" (3), "uv" (2), "color" (3 or 4), and any other number per vertex or face of a PLY
// file under its own name; "attribute" for the 16 bits after each triangle of an STL file; "color_index" for
// the single number after each face of an OFF file; "column4" and so on
// for the numbers after x y z of an XYZ file. Values that are not finite are read as 0, which a note says.
struct ShapeFile {
  Mesh mesh;
  std::string format;              // "ply", "obj", "glb", "stl", "off" or "xyz"
  std::vector<std::string> notes;  // what was odd and how it was read, a sentence each
  std::string bytes;               // the file as read
  std::variant<PlyLayout, ObjLayout, GlbLayout, StlLayout, OffLayout, XyzLayout> layout;
};

// Reads a file, the format chosen by its extension in upper or lower case. Opens no other file, whatever this one
// names. Throws IoError(read) for a file that cannot be read, and InvalidInput for an unknown extension, malformed or
// missing data, indices out of range and coordinates that are not finite; the message names the line, or in binary the
// byte.
ShapeFile read_shape(const std::filesystem::path& path);

// The same for bytes at hand; `format` as in ShapeFile::format, `name` for messages. Memory is bounded by a small
// multiple of bytes.size(), whatever the contents declare.
ShapeFile parse_shape(std::string bytes, std::string_view format, const std::string& name);

struct WriteOptions {
  // PLY: write x y z as doubles (of a file with float coordinates: only if some vertex moved). Text always holds
  // doubles, binary STL and OFF floats.
  bool double_coordinates = false;
  // Of a shape without faces: its normals as they turned (ReplayResult::normals); empty: they stay as they are.
  std::span<const Vec3d> normals{};
};

// The source with its vertices at `positions` (as many as it has), as a file of the format that the path's extension
// names. In the source's own format only the coordinates that differ are replaced, and the authored normals around them
// (transport_normals); with nothing moved the file is the source, byte for byte. PLY coordinates of integer type become
// doubles when a vertex moves. Another format is generated from the mesh and its attributes; see conversion_losses.
// Written beside the target and renamed (atomic_file.h). Throws IoError(write); InvalidInput for an unknown extension
// or a position that is not finite or does not fit.
void write_shape(const std::filesystem::path& path, const ShapeFile& source, std::span<const Vec3d> positions,
                 const WriteOptions& options = {});

// The bytes that write_shape writes; `format` as in ShapeFile::format.
std::string serialize_shape(std::string_view format, const ShapeFile& source, std::span<const Vec3d> positions,
                            const WriteOptions& options = {});

// A new file from a mesh: PLY (binary little endian), OBJ, STL (binary), OFF (text) or XYZ. Attributes are written
// where the format can hold them.
void write_mesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options = {});
std::string serialize_mesh(std::string_view format, const Mesh& mesh, const WriteOptions& options = {});

// What write_shape will lose when it writes the source to this path, a sentence each; empty for the same format.
// Throws InvalidInput where the format cannot hold the shape at all (points in STL).
std::vector<std::string> conversion_losses(const std::filesystem::path& path, const ShapeFile& source);

// The formats that can be read and written; each is also the extension of its files.
std::vector<std::string_view> format_names();

// The format that a path's extension names ("ply", "obj", "glb", "stl", "off", "xyz"). Throws InvalidInput that lists
// the supported ones.
std::string format_of(const std::filesystem::path& path);

}  // namespace knead
