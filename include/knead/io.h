// Reads and writes shapes: PLY, OBJ, glTF, STL, 3MF, OFF and point files. In its own format, a shape is written by
// copying the bytes that were read and replacing the numbers that changed; everything that Knead does not understand
// survives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"

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
  std::string format;                                  // the name of a format: "ply", "obj", "glb" ...
  std::vector<std::string> notes;                      // one sentence for each oddity: what it is and how it was read
  std::string bytes;                                   // the file; empty if `file` is set
  std::shared_ptr<const io_detail::AnyLayout> layout;  // where the numbers are in `bytes`; copies share it
  std::shared_ptr<const io_detail::SourceFile> file;   // for reading the bytes again (ReadOptions); copies share it
};

// How a file is read.
struct ReadOptions {
  // Larger files are read in pieces and not kept, where the format allows it: binary PLY in a regular file. The
  // writers then read the file again, in pieces if the source's faces stay. Once the file has changed they throw
  // IoError(read); another file that takes its name is no change.
  std::size_t most_kept_bytes = std::numeric_limits<std::size_t>::max();
};

// Reads a file in the format that its extension names, in upper or lower case. Opens no other file but those in the
// same folder, by plain names and no links, that hold the buffers of a glTF file. Throws
// IoError(read) for a file that cannot be read; InvalidInput for an unknown extension, malformed or missing data,
// indices out of range and coordinates that are not finite. The message names the line, or in binary files the byte.
ShapeFile read_shape(const std::filesystem::path& path, const ReadOptions& options = {});

// Reads a file from memory. `format` is the name of a format; `name` stands in messages. Memory is bounded by a small
// multiple of bytes.size(), whatever the file declares.
ShapeFile parse_shape(std::string bytes, std::string_view format, const std::string& name);

// Returns a text file, without a byte order mark. Throws IoError(read) for a file that cannot be read; InvalidInput for
// UTF-16, and for what only stands in for the file: a pointer of Git LFS, or a web page.
std::string read_text(const std::filesystem::path& path);

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

// Returns the summary of a file. Refuses what read_shape() and parse_shape() refuse. A binary PLY file is read in
// pieces, and takes about a tenth of a second for 100 MB; other files take what reading them takes.
ShapeSummary read_summary(const std::filesystem::path& path);
ShapeSummary parse_summary(std::string bytes, std::string_view format, const std::string& name);

// How a shape is written.
struct WriteOptions {
  // Writes x y z of PLY files as doubles; those of a source with float coordinates only if a vertex moved. The other
  // formats have one type: doubles in text, floats in binary STL, binary OFF and GLB.
  bool double_coordinates = false;
  // The new normals of a shape without faces (DeformedShape::normals), one per vertex; empty: they stay as they are.
  std::span<const Vec3d> normals{};
  // Vertex attributes of one component with other values than the source's of the same names, for the vertices that
  // `changed` names in ascending order: one value for each of these (ChangedSplats).
  std::span<const Attribute> attributes{};
  std::span<const std::uint32_t> changed{};
  // The digits after the point of coordinates that differ, in text files: 0 to 17. A coordinate that rounds to the old
  // one keeps its spelling; components of normals have at least six digits. Empty: the shortest form that reads back as
  // the same number.
  std::optional<int> decimals{};
};

// Writes the source with its vertices at `positions`, one for each, in the format that the path's extension names.
// In the source's own format it replaces only the coordinates that differ, and the normals around them
// (transport_normals); if nothing moved, it writes the bytes of the source. PLY coordinates of integer type become
// doubles if a vertex moves. Another format is generated from the mesh and its attributes; conversion_losses says what
// it leaves out. The file is replaced as a whole (io.h). Throws IoError(write); InvalidInput for an unknown
// extension and for positions that are not finite or do not fit.
void write_shape(const std::filesystem::path& path, const ShapeFile& source, std::span<const Vec3d> positions,
                 const WriteOptions& options = {});

// Returns the bytes that write_shape writes; `format` is the name of a format.
std::string serialize_shape(std::string_view format, const ShapeFile& source, std::span<const Vec3d> positions,
                            const WriteOptions& options = {});

// Writes a mesh to a new file: PLY (binary, little-endian), OBJ, GLB, STL (binary), 3MF (in millimetres), OFF (text) or
// XYZ, with the attributes that the format can hold. Throws as write_shape does.
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
  // Returns the rows of a piece that serialize_shape() has written: what is left of `bytes`. Throws InvalidInput where
  // the type of coordinates would change, which the header states for all rows.
  std::string rows(const ShapeFile& piece, std::string bytes) const;

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
// Returns an empty list if both folders are the same or the shape is not from an OBJ file. `notes`: null, or what gets
// a sentence for each file that was copied, was not, or is another one in that folder, and for each texture of a glTF
// file that is not there. Throws IoError(write).
std::vector<std::filesystem::path> copy_material_files(const ShapeFile& shape, const std::filesystem::path& source,
                                                       const std::filesystem::path& target,
                                                       std::vector<std::string>* notes = nullptr);

// Returns the extensions of files that can be read and written, without the point: those of each format together, the
// one that is the format's name first.
std::vector<std::string_view> shape_extensions();

// Returns the formats of which a new file can hold a mesh with faces, or points without.
std::vector<std::string_view> written_extensions(bool has_faces);

// Returns the end of a file's name that names its format, as it is spelled: ".ply"; ".msh.gz" of a compressed file;
// ".points" for OpenFOAM's files, which are named `points`. Empty if it has none.
std::string shape_suffix(const std::filesystem::path& path);

// A named part of the boundary of a solver's mesh.
struct Patch {
  std::string name;
  std::vector<std::uint32_t> points;  // numbers of the shape's vertices, ascending
  std::vector<Triangle> faces{};      // cut into triangles; an edge of a mesh of two dimensions has its end twice

  friend bool operator==(const Patch&, const Patch&) = default;
};

// Returns the patches of the file that a shape was read from: physical groups of gmsh of every dimension (those without
// a name have their number), markers of SU2, and patches of OpenFOAM, whose files `boundary` and `faces` lie beside
// `points`. Empty for other formats. Throws as read_shape.
std::vector<Patch> read_patches(const std::filesystem::path& path, const ShapeFile& shape);

// Returns the cells of the file that a shape was read from: those of gmsh and SU2 of the first and second order, and of
// OpenFOAM, whose files `faces`, `owner` and `neighbour` lie beside `points`. Where all z are alike, the triangles and
// quadrilaterals are the cells. Empty for other formats. Throws as read_shape.
VolumeCells read_cells(const std::filesystem::path& path, const ShapeFile& shape);

// Returns the cells that a deformation of the shape must keep: as read_cells(), but none where they cannot be read,
// unless they are needed. Appends a sentence to `notes` where they are not judged, or by their corners only.
VolumeCells cells_to_judge(const std::filesystem::path& path, const ShapeFile& shape, bool are_needed,
                           std::vector<std::string>& notes);

// Returns the format that a path's extension names. Throws InvalidInput that lists the known ones.
std::string format_of(const std::filesystem::path& path);

// Writes a shape whose connectivity has changed to a file that keeps everything else of its source.

// Returns a file of that format with the source's contents and another mesh. `face_source` names, for each face of the
// mesh, the face of source.mesh that it lies in. The mesh has the source's attributes (names, domains, types) with its
// own values; "normal" is written as it is.
//
// The source's own format keeps:
//   PLY   encoding, line ends, comments, obj_info; names, types and order of elements and properties. Integer
//         coordinates become doubles if a position is not whole; indices get a wider type if they need it; strips of
//         triangles become faces. Elements other than vertices and faces stay if they cannot refer to vertices (only
//         reals and bytes, no lists). Other elements are left out, and all lists but vertex indices and texcoord.
//   OBJ   every line that does not name vertices, in place. A new face stands where the face stood that it lies in, so
//         it keeps material, groups, object and smoothing. v (with colors), vt and vn, each value once, stand before
//         the first line that could name them. A face has texture coordinates, or normals, if the face that it lies in
//         has them.
//   GLB   everything but the numbers of the primitives that changed: each keeps its material and the triangles that
//         lie in it. If several nodes place a mesh, those that changed get copies. Unchanged numbers keep their bits.
//         Points and lines whose vertices are in no face move with them if the mesh has as many such vertices as the
//         source, in its order; otherwise they stay. Points and lines among vertices of faces are left out if these
//         change.
//   STL   header, names, solids, the 16 bits, bytes after the last triangle; normals stay on their side, or zero. In
//         text a new triangle stands where the triangle stood that it lies in, with its spelling.
//   3MF   all parts but the models that changed, and in these all but the meshes that changed: build, materials,
//         metadata. A new triangle has the properties of the one that it lies in. The ranges of triangles by which
//         PrusaSlicer knows volumes follow.
//   OFF   text or binary with its byte order; keyword, everything before the counts and after the last face; normals,
//         texture coordinates, colors of vertices and faces. The count of edges becomes 0 (not counted).
// A mesh that equals the source's gives the bytes of the source. Another format is generated from the mesh as by
// serialize_mesh. remesh_losses says what is left out.
//
// Throws InvalidInput for a source without faces, a face_source or attributes that do not fit, positions that are not
// finite or do not fit the format, and GLB with a skeleton or morph targets, which would need numbers for new vertices;
// for 3MF where an object changes that is placed several times, or whose beams or sets number its triangles.
std::string serialize_remeshed(std::string_view format, const ShapeFile& source, const Mesh& mesh,
                               std::span<const std::uint32_t> face_source, const WriteOptions& options = {});

// Writes the bytes of serialize_remeshed to a file, in the format that its extension names. Throws also IoError(write).
void write_remeshed(const std::filesystem::path& path, const ShapeFile& source, const Mesh& mesh,
                    std::span<const std::uint32_t> face_source, const WriteOptions& options = {});

// Returns a number for each face; faces have the same number if the file groups them: under one material, group, object
// and smoothing (OBJ), in one primitive (GLB), or with the same properties (3MF). Empty for the other formats. A remesh
// with these face_labels keeps the lines between groups.
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// Returns what write_remeshed may leave out when it writes to this path, a sentence each; for a format other than the
// source's, what conversion_losses says. Throws InvalidInput if write_remeshed would throw for every mesh.
std::vector<std::string> remesh_losses(const std::filesystem::path& path, const ShapeFile& source);

// Writes files as a whole: after a failure the old file is still there.

// Replaces the contents of the file at `path`, or creates it. Writes a temporary file in the same folder, syncs it to
// disk and renames it, so the old file stays intact if this fails or the program dies. Follows a link, also one whose
// target does not exist yet, and keeps the permissions of an existing file. Writes directly to a path that is not a
// regular file (a pipe, a terminal, /dev/null). Throws IoError(write).
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

// A file that is written piece by piece, with the promises of write_file_atomically.
class AtomicFile {
 public:
  // Creates the temporary file. Throws IoError(write).
  explicit AtomicFile(const std::filesystem::path& path);

  // Creates the temporary file of a part that belongs to another file in the same folder, which is put in place last.
  // If the program is killed, both are known as abandoned together. Throws IoError(write).
  AtomicFile(const std::filesystem::path& path, const AtomicFile& whole);

  // Without finish() before, the old file stays.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) noexcept;

  // Appends the bytes. Throws IoError(write).
  void write(std::string_view bytes);

  // Syncs and closes the temporary file: nothing can be written after it. Throws IoError(write).
  void close();

  // Closes the file, if that is not done, and puts it in place; while this thread has a FilesTogether, leaves that to
  // it. Throws IoError(write).
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;

  friend class FilesTogether;
};

// While it lives, files that this thread finishes wait, and take their places all together: of several results either
// all are there or none. One at a time in a thread.
class FilesTogether {
 public:
  FilesTogether();
  FilesTogether(const FilesTogether&) = delete;
  FilesTogether& operator=(const FilesTogether&) = delete;

  // Without finish() before, the old files stay.
  ~FilesTogether();

  // Returns how many files wait.
  std::size_t count() const { return waiting_.size(); }

  // Puts all files in place, one right after the other; files that are finished afterwards do not wait. Throws
  // IoError(write).
  void finish();

 private:
  friend class AtomicFile;

  std::vector<AtomicFile> waiting_;
  std::filesystem::path first_;  // the temporary file that stays locked until the end
};

// Removes the temporary files of AtomicFile, and of calls of write_file_atomically that have not returned yet. A signal
// handler may call this before it ends the program.
void discard_unfinished_files() noexcept;

// Removes the temporary files in a folder that killed programs have left behind. Those of running programs stay.
void discard_abandoned_files(const std::filesystem::path& folder) noexcept;

// Returns how many files were put in place so far; one that is renamed at this moment may count
// twice. A signal handler may call this: a larger number than before means that a file is in place.
std::size_t count_files_in_place() noexcept;

// Returns the file that a path stands for, whether it exists or not: links at its end are followed.
std::filesystem::path followed_link(const std::filesystem::path& path);

}  // namespace knead
