// glTF 2.0 as text (.gltf), and GLB files whose buffers are not in their binary chunk: rows of the format table
// (formats.h). A file is read as the GLB file that holds the same (glb/glb.h) and written back as it came. Source:
// Khronos, "glTF 2.0 Specification" (2021).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "knead/io/gltf/buffers.h"
#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail::gltf {

struct Layout {
  ShapeFile glb;                // the same as a GLB file with one buffer, its binary chunk
  std::vector<Buffer> buffers;  // of the source
  std::string buffers_text;     // the JSON array of them
  std::filesystem::path path;   // of the source, beside which the files of buffers are
};

// Throw InvalidInput for buffers in other files: reading from memory opens none.
ShapeFile parse(std::string bytes, const std::string& name);
ShapeFile parse_glb(std::string bytes, const std::string& name);

// Read also buffers in files beside the path, by plain names.
ShapeFile parse_beside(std::string bytes, const std::filesystem::path& path);
ShapeFile parse_glb_beside(std::string bytes, const std::filesystem::path& path);

// For both formats. Buffers in files become data URIs; several buffers become one.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);
std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> source_losses(const ShapeFile& source);
std::vector<std::string> remesh_losses(const ShapeFile& source);
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// A new .gltf file with its buffer as a data URI.
std::string generate(const Mesh& mesh, const WriteOptions& options);

// Writes a file of the source, whose bytes rewrite or remeshed made or which did not change: what came in files goes to
// files beside the path again, under the same names unless others' files stand there.
void write_beside(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes);

}  // namespace knead::io_detail::gltf
