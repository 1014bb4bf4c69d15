// Reads and writes shapes: PLY, OBJ, glTF, STL, OFF and point files. In its own format, a shape is written by copying
// the bytes that were read and replacing the numbers that changed; everything that Knead does not understand survives.
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/math/box.h"
#include "knead/mesh/mesh.h"

namespace knead {

namespace io_detail {
struct AnyLayout;
class SourceFile;
}  // namespace io_detail

// A mesh and the file that it came from; made by read_shape and parse_shape.
//
// Attributes of the mesh, by name and number of components: "normal" (3), "uv" (2), "color" (3 or 4); "tangent" (4) of
// a GLB file; "attribute" (1), the 16 bits after each triangle of an STL file; "color_index" (1) of the faces of an OFF
// file; "column4", "column5", ... (1), the numbers after x y z of an XYZ file; and every other number per vertex or
// face of a PLY file under its own name. Values that are not finite become 0, and a note says so.
struct ShapeFile {
  Mesh mesh;
  std::string format;                                  // one of format_names(): "ply", "obj", "glb" ...
  std::vector<std::string> notes;                      // one sentence for each oddity: what it is and how it was read
  std::string bytes;                                   // the file; empty if `file` is set
  std::shared_ptr<const io_detail::AnyLayout> layout;  // where the numbers are in `bytes`; copies share it
  std::shared_ptr<const io_detail::SourceFile> file;   // for reading the bytes again (ReadOptions); copies share it
};

// How a file is read.
struct ReadOptions {
  // The bytes of larger files are freed after reading, where the format allows it: binary PLY in a regular file. The
  // writers then read the file again, in pieces if the source's faces stay. Once the file has changed they throw
  // IoError(read); another file that takes its name is no change.
  std::size_t most_kept_bytes = std::numeric_limits<std::size_t>::max();
};

// Reads a file in the format that its extension names, in upper or lower case. Opens no other file but those in the
// same folder, by plain names and no links, that hold the buffers of a glTF file. Throws
// IoError(read) for a file that cannot be read; InvalidInput for an unknown extension, malformed or missing data,
// indices out of range and coordinates that are not finite. The message names the line, or in binary files the byte.
ShapeFile read_shape(const std::filesystem::path& path, const ReadOptions& options = {});

// Reads a file from memory. `format` is one of format_names(); `name` stands in messages. Memory is bounded by a small
// multiple of bytes.size(), whatever the file declares.
ShapeFile parse_shape(std::string bytes, std::string_view format, const std::string& name);

// What can be said of a shape without looking at which faces are neighbours.
struct ShapeSummary {
  std::string format;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::size_t triangles = 0;            // of the faces
  Box box;                              // shape_box()
  std::vector<std::string> attributes;  // names
  std::vector<std::string> notes;       // as ShapeFile::notes, without that on coarse coordinates
};

// Returns the summary of a file. Refuses what read_shape() and parse_shape() refuse. A binary PLY file takes the memory
// of its bytes and about a tenth of a second for 100 MB; other files take what reading them takes.
ShapeSummary read_summary(const std::filesystem::path& path);
ShapeSummary parse_summary(std::string bytes, std::string_view format, const std::string& name);

// How a shape is written.
struct WriteOptions {
  // Writes x y z of PLY files as doubles; those of a source with float coordinates only if a vertex moved. The other
  // formats have one type: doubles in text, floats in binary STL, binary OFF and GLB.
  bool double_coordinates = false;
  // The new normals of a shape without faces (DeformedShape::normals), one per vertex; empty: they stay as they are.
  std::span<const Vec3d> normals{};
  // The digits after the point of coordinates that differ, in text files: 0 to 17. A coordinate that rounds to the old
  // one keeps its spelling; components of normals have at least six digits. Empty: the shortest form that reads back as
  // the same number.
  std::optional<int> decimals{};
};

// Writes the source with its vertices at `positions`, one for each, in the format that the path's extension names.
// In the source's own format it replaces only the coordinates that differ, and the normals around them
// (transport_normals); if nothing moved, it writes the bytes of the source. PLY coordinates of integer type become
// doubles if a vertex moves. Another format is generated from the mesh and its attributes; conversion_losses says what
// it leaves out. The file is replaced as a whole (atomic_file.h). Throws IoError(write); InvalidInput for an unknown
// extension and for positions that are not finite or do not fit.
void write_shape(const std::filesystem::path& path, const ShapeFile& source, std::span<const Vec3d> positions,
                 const WriteOptions& options = {});

// Returns the bytes that write_shape writes; `format` is one of format_names().
std::string serialize_shape(std::string_view format, const ShapeFile& source, std::span<const Vec3d> positions,
                            const WriteOptions& options = {});

// Writes a mesh to a new file: PLY (binary, little-endian), OBJ, GLB, STL (binary), OFF (text) or XYZ, with the
// attributes that the format can hold. Throws as write_shape does.
void write_mesh(const std::filesystem::path& path, const Mesh& mesh, const WriteOptions& options = {});
std::string serialize_mesh(std::string_view format, const Mesh& mesh, const WriteOptions& options = {});

// Returns what write_shape leaves out when it writes the source to this path, a sentence each; empty for the source's
// own format. Throws InvalidInput if the format cannot hold the shape at all (points in STL).
std::vector<std::string> conversion_losses(const std::filesystem::path& path, const ShapeFile& source);

// A point cloud that is read and written in pieces, because it is larger than memory: binary PLY whose only rows are
// vertices without lists, and XYZ. Its header, count and names of columns are in no piece.
class CloudPieces {
 public:
  // Opens a cloud; a piece has about so many bytes, at least one row. Throws IoError(read); InvalidInput with the
  // reason where a file cannot be read in pieces.
  explicit CloudPieces(const std::filesystem::path& path, std::size_t piece_bytes = std::size_t{1} << 25);
  ~CloudPieces();
  CloudPieces(const CloudPieces&) = delete;
  CloudPieces& operator=(const CloudPieces&) = delete;
  CloudPieces(CloudPieces&&) noexcept;
  CloudPieces& operator=(CloudPieces&&) noexcept;

  // Returns the next piece as a shape of its own, as parse_shape() reads it; nothing after the last one. Messages name
  // the line or vertex where the piece begins.
  std::optional<ShapeFile> next();
  // Goes back to the first piece.
  void rewind();
  // Bytes of the file up to the end of the last piece, for progress; of the whole file.
  std::uintmax_t position() const;
  std::uintmax_t size() const;

  // What stands before the first row of the file, and after the last one.
  const std::string& head() const;
  const std::string& tail() const;
  // Returns the rows of a piece as serialize_shape() writes them. Throws as it does, and InvalidInput where the type of
  // coordinates would change, which the header states for all rows.
  std::string rows(const ShapeFile& piece, std::span<const Vec3d> positions, const WriteOptions& options) const;

 private:
  struct Reader;
  std::unique_ptr<Reader> reader_;
};

// Returns true if write_shape and write_remeshed round the coordinates to 32-bit floats when they write the source to
// this path, whatever the options: as GLB, binary STL or binary OFF.
bool stores_floats(const std::filesystem::path& path, const ShapeFile& source);

// Returns true if they do so with these options.
bool stores_floats(const std::filesystem::path& path, const ShapeFile& source, const WriteOptions& options);

// Returns the most digits after the point that a coordinate of a text file has, those of a number with an exponent as
// if it were written without; nothing for binary files. For WriteOptions::decimals.
std::optional<int> decimals_of(const ShapeFile& source);

// Returns the normal of each vertex of the source (the attribute "normal" of vertices); empty if it has none.
std::vector<Vec3d> vertex_normals_of(const ShapeFile& source);

// Copies the material files that an OBJ file names from the folder of `source`, the file that the shape was read from,
// to the folder of `target`, and returns the paths written. Copies only regular files (no links) of at most 64 MB whose
// plain names end in .mtl; never replaces a file. Skips what it cannot read, because the shape does not need it.
// Returns an empty list if both folders are the same or the shape is not from an OBJ file. Throws IoError(write).
std::vector<std::filesystem::path> copy_material_files(const ShapeFile& shape, const std::filesystem::path& source,
                                                       const std::filesystem::path& target);

// Returns the formats that can be read and written.
std::vector<std::string_view> format_names();

// Returns the extensions of files that can be read and written, without the point: those of each format together, the
// one that is the format's name first.
std::vector<std::string_view> shape_extensions();

// Returns the format that a path's extension names. Throws InvalidInput that lists the known ones.
std::string format_of(const std::filesystem::path& path);

}  // namespace knead
