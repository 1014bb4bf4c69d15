// The table of the formats: what each can do.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail {

// A list of losses has one sentence for each thing that is left out.
struct Format {
  std::string_view name;  // also the extension of its files

  // Reads a file and sets ShapeFile::layout; `name` is for messages.
  ShapeFile (*parse)(std::string bytes, const std::string& name);

  // The bytes of the source with other positions, of which at least one differs, and with the normals of moved_normals.
  std::string (*rewrite)(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                         const WriteOptions& options);

  // A new file, and what it leaves out of the mesh.
  std::string (*generate)(const Mesh& mesh, const WriteOptions& options);
  std::vector<std::string> (*losses)(const Mesh& mesh);

  // What a file of another format leaves out that is in this source but not in its mesh.
  std::vector<std::string> (*source_losses)(const ShapeFile& source);

  // A file like the source's with another mesh, and what it leaves out of the source; null for points.
  std::string (*remeshed)(const NewMesh& shape, const WriteOptions& options);
  std::vector<std::string> (*remesh_losses)(const ShapeFile& source);

  // See face_labels in remeshed.h; null if a file of this format does not group faces.
  std::vector<std::uint32_t> (*face_labels)(const ShapeFile& source);

  // Returns true if a file of this format that is rewritten, or generated, rounds coordinates to 32-bit floats.
  bool (*rewrites_floats)(const ShapeFile& source);
  bool generates_floats;
};

std::span<const Format> formats();

// The format of that name. Throws InvalidInput that lists the known ones and names `file`.
const Format& format_named(std::string_view name, const std::string& file);

}  // namespace knead::io_detail
