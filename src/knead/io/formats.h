// The table of the formats: what each can do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/decimals.h"
#include "knead/io/new_mesh.h"
#include "knead/io/shape_file.h"

namespace knead::io_detail {

// Takes the bytes of a file, one piece after the other.
using ByteSink = std::function<void(std::string_view)>;

// A list of losses has one sentence for each thing that is left out.
struct Format {
  std::string_view name;  // also an extension of its files

  // Reads a file and sets ShapeFile::layout; `name` is for messages.
  ShapeFile (*parse)(std::string bytes, const std::string& name);

  // Reads a file with what lies beside it; null for formats that are whole in themselves.
  ShapeFile (*parse_beside)(std::string bytes, const std::filesystem::path& path);

  // The bytes of the source with other positions, of which at least one differs, and with the normals of moved_normals.
  // Null if the format has rewrite_in_pieces.
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

  // Returns true if the coordinates of a file that was read are 32-bit floats.
  bool (*reads_floats)(const ShapeFile& source);

  // Calls visit for the word of each coordinate of a text file; null for formats that are never text. Not called for
  // binary files.
  void (*visit_coordinates)(const ShapeFile& source, const WordVisitor& visit) = nullptr;

  // Extensions of its files besides its name.
  std::span<const std::string_view> extensions{};

  // Does the same as rewrite, and passes the bytes on piece by piece. Throws InvalidInput before the first piece only.
  void (*rewrite_in_pieces)(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                            const WriteOptions& options, const ByteSink& out) = nullptr;

  // Returns true if all writers of this source can do without ShapeFile::bytes, if ShapeFile::file is set; null: no.
  bool (*reads_again)(const ShapeFile& source) = nullptr;

  // Returns the summary of a file; nothing if that takes reading it as a shape. Null: it always does.
  std::optional<ShapeSummary> (*summarize)(std::string_view bytes, const std::string& name) = nullptr;
};

std::span<const Format> formats();

// Throws InvalidInput for a number of decimals that no double has.
void check_decimals(const WriteOptions& options);

// Writes a file in the source's own format, with the files beside it that belong to it.
void write_own_format(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes);

// The format whose files have that extension, without the point and in lower case. Throws InvalidInput that lists the
// known ones and names `file`.
const Format& format_with_extension(std::string_view extension, const std::string& file);

// The format of that name. Throws InvalidInput that lists the known ones and names `file`.
const Format& format_named(std::string_view name, const std::string& file);

}  // namespace knead::io_detail
