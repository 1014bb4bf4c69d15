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

namespace detail {
struct AnyLayout;
class SourceFile;
}  // namespace detail

// A mesh and the file that it came from; made by read_shape and parse_shape.
//
// Attributes of the mesh, by name and number of components: "normal" (3), "uv" (2), "color" (3 or 4); "tangent" (4) of
// a GLB file, and those of its splats; "attribute" (1), the 16 bits after each triangle of an STL file;
// "color_index" (1) of the faces of an OFF file; "column4", "column5", ... (1), the numbers after x y z of an XYZ file;
// and every other number per vertex or face of a PLY file under its own name. Values that are not finite become 0, and
// a note says so.
struct ShapeFile {
  Mesh mesh;
  std::string format;                               // the name of a format: "ply", "obj", "glb" ...
  std::vector<std::string> notes;                   // one sentence for each oddity: what it is and how it was read
  std::string bytes;                                // the file; empty if `file` is set
  std::shared_ptr<const detail::AnyLayout> layout;  // where the numbers are in `bytes`; copies share it
  std::shared_ptr<const detail::SourceFile> file;   // for reading the bytes again (ReadOptions); copies share it
};

// How a file is read.
struct ReadOptions {
  // Larger regular files, in binary PLY and of splats in GLB, are read in pieces and not kept in memory. The writers
  // then read the file again, in pieces if the source's faces are the same. They throw IoError(read) if its contents
  // have changed; a new file under its name does no harm.
  std::size_t most_kept_bytes = std::numeric_limits<std::size_t>::max();
};

// Reads a file in the format that its extension names, in upper or lower case. Opens other files only for the buffers
// of a glTF file: in the same folder, with plain names, no links. Throws IoError(read) for a file that cannot be read;
// InvalidInput for an unknown extension, malformed or missing data, indices out of range and coordinates that are not
// finite. The message names the line, or in binary files the byte.
ShapeFile read_shape(const std::filesystem::path& path, const ReadOptions& options = {});

// Reads a file from memory. `format` is the name of a format; `name` stands in messages. Memory is bounded by a small
// multiple of bytes.size(), whatever the file declares.
ShapeFile parse_shape(std::string bytes, std::string_view format, const std::string& name);

// Returns the contents of a text file, without a byte order mark. Throws IoError(read) for a file that cannot be read;
// InvalidInput for UTF-16, and for a placeholder of the file: a pointer of Git LFS, or a web page.
std::string read_text(const std::filesystem::path& path);

// A description of a shape that needs no connectivity.
struct ShapeSummary {
  std::string format;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::size_t triangles = 0;            // of the faces
  Box box;                              // shape_box()
  std::vector<std::string> attributes;  // names
  std::vector<std::string> notes;       // as ShapeFile::notes, without the one on coarse coordinates
};

// Returns the summary of a file. Throws as read_shape() and parse_shape(). A binary PLY file is read in pieces, and
// takes about a tenth of a second for 100 MB; other files take as long as read_shape().
ShapeSummary read_summary(const std::filesystem::path& path);
ShapeSummary parse_summary(std::string bytes, std::string_view format, const std::string& name);

// How a shape is written.
struct WriteOptions {
  // Writes x y z of PLY files as doubles; those of a source with float coordinates only if a vertex moved. The other
  // formats have one type: doubles in text, floats in binary STL, binary OFF and GLB.
  bool double_coordinates = false;
  // The new normals of a shape without faces (DeformedShape::normals), one per vertex; empty: they stay as they are.
  std::span<const Vec3d> normals{};
  // New values of the source's vertex attributes with one component, by their names: one value for each of the vertices
  // in `changed`, which ascend (ChangedSplats).
  std::span<const Attribute> attributes{};
  std::span<const std::uint32_t> changed{};
  // Digits after the decimal point of changed coordinates in text files, 0 to 17. A coordinate that rounds to the old
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

// Returns one sentence for each property of the source that write_shape() leaves out when it writes to this path; none
// for the source's own format. Throws InvalidInput if the format cannot hold the shape at all (points in STL).
std::vector<std::string> conversion_losses(const std::filesystem::path& path, const ShapeFile& source);

// A point cloud that is read and written in pieces, for files larger than memory: XYZ, and binary PLY whose only rows
// are vertices without lists. The pieces do not contain the header, the count or the names of columns.
class CloudPieces {
 public:
  // Opens a cloud. A piece has about `piece_bytes` bytes, and at least one row. Throws IoError(read); InvalidInput with
  // the reason if the file cannot be read in pieces.
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
  // Returns the number of bytes up to the end of the last piece that was read, for progress.
  std::uintmax_t position() const;
  // Returns the number of bytes of the file.
  std::uintmax_t size() const;

  // Returns the bytes before the first row of the file.
  const std::string& head() const;
  // Returns the bytes after the last row of the file.
  const std::string& tail() const;
  // Returns the rows of a piece: `bytes`, as serialize_shape() has written them, without their header. Throws
  // InvalidInput if the type of coordinates would change, which the header states for all rows.
  std::string rows(const ShapeFile& piece, std::string bytes) const;

 private:
  struct Reader;
  std::unique_ptr<Reader> reader_;
};

// Returns true if write_shape and write_remeshed round the coordinates to 32-bit floats when they write the source to
// this path, whatever the options: as GLB, binary STL or binary OFF.
bool stores_floats(const std::filesystem::path& path, const ShapeFile& source);

// Returns true if they round the coordinates with these options.
bool stores_floats(const std::filesystem::path& path, const ShapeFile& source, const WriteOptions& options);

// Returns the greatest number of digits after the decimal point of a coordinate in a text file; nothing for binary
// files. Numbers with an exponent count as if written without it. For WriteOptions::decimals.
std::optional<int> decimals_of(const ShapeFile& source);

// Returns the normal of each vertex of the source (the attribute "normal" of vertices); empty if it has none.
std::vector<Vec3d> vertex_normals_of(const ShapeFile& source);

// Copies the material files that an OBJ file names from the folder of `source`, the file that the shape was read from,
// to the folder of `target`, and returns the paths written. Copies only regular files (no links) of at most 64 MB whose
// plain names end in .mtl; never replaces a file. Skips what it cannot read, because the shape does not need it.
// Returns an empty list if both folders are the same or the shape is not from an OBJ file. `notes`: null, or receives a
// sentence for each file that was copied, skipped, or differs from the one already there, and for each missing texture
// of a glTF file. Throws IoError(write).
std::vector<std::filesystem::path> copy_material_files(const ShapeFile& shape, const std::filesystem::path& source,
                                                       const std::filesystem::path& target,
                                                       std::vector<std::string>* notes = nullptr);

// Returns the extensions of files that can be read and written, without the point, grouped by format. The name of the
// format comes first in its group.
std::vector<std::string_view> shape_extensions();

// Returns the formats of new files that can hold a mesh with faces, or without: points.
std::vector<std::string_view> written_extensions(bool has_faces);

// Returns the suffix of a path that names its format, as it is spelled: ".ply"; ".msh.gz" for a compressed file;
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
// OpenFOAM, whose files `faces`, `owner` and `neighbour` lie beside `points`. If all z are equal, the triangles and
// quadrilaterals are the cells. Empty for other formats. Throws as read_shape.
VolumeCells read_cells(const std::filesystem::path& path, const ShapeFile& shape);

// Returns the cells that a deformation of the shape must not invert, as read_cells(). If they cannot be read, throws as
// read_cells() if they `are_needed`, and otherwise returns none. Appends a sentence to `notes` if cells cannot be
// judged, or only by their corners.
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
//   OBJ   every line that does not name vertices, in place. A new face takes the place of its source face, so
//         it keeps material, groups, object and smoothing. v (with colors), vt and vn, each value once, stand before
//         the first line that could name them. A face has texture coordinates, or normals, if its source face has them.
//   GLB   everything but the numbers of the primitives that changed: each keeps its material and the triangles that
//         lie in it. If several nodes place a mesh, those that changed get copies. Unchanged numbers keep their bits.
//         Points and lines whose vertices are in no face move with them if the mesh has as many such vertices as the
//         source, in its order; otherwise they stay. Points and lines among vertices of faces are left out if these
//         change.
//   STL   header, names, solids, the 16 bits, bytes after the last triangle; normals stay on their side, or zero. In
//         text a new triangle takes the place and the spelling of its source triangle.
//   3MF   all parts except changed models, and in these all except changed meshes: build, materials, metadata.
//         A new triangle has the properties of its source triangle. The ranges of triangles by which PrusaSlicer
//         identifies volumes are updated.
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

// Returns one sentence for each property that write_remeshed() may leave out when it writes to this path; for a format
// other than the source's, those of conversion_losses(). Throws InvalidInput if write_remeshed() would for every mesh.
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

  // Creates the temporary file of a part that belongs to the file `whole` in the same folder, which is put in place
  // last. If the program is killed, discard_abandoned_files() treats both as one. Throws IoError(write).
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

  // Closes the file, if it is open, and puts it in place. If this thread has a FilesTogether, the file waits for its
  // finish(). Throws IoError(write).
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;

  friend class FilesTogether;
};

// Puts several files in place together, so that of several results either all are there or none. Files that this thread
// finishes during its lifetime wait for finish(). At most one exists in a thread.
class FilesTogether {
 public:
  FilesTogether();
  FilesTogether(const FilesTogether&) = delete;
  FilesTogether& operator=(const FilesTogether&) = delete;

  // Without finish() before, the old files stay.
  ~FilesTogether();

  // Returns the number of waiting files.
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

// Returns how many files were put in place so far; a file that is being renamed may count twice. A signal handler may
// call this: a larger number than before means that a file is in place.
std::size_t count_files_in_place() noexcept;

// Returns the file that a path stands for, whether it exists or not: links at its end are followed.
std::filesystem::path followed_link(const std::filesystem::path& path);

// Animations: moving shapes in one file.

// The frames of an animation.
struct AnimationOptions {
  int frames = 1;   // the number of frames that will be added; 1 or more
  double fps = 24;  // frames per second; above 0
};

// Returns whether the path's extension, in upper or lower case, is one of .pc2, .mdd, .glb, .usda and .pvd.
bool is_animation(const std::filesystem::path& path);

// Returns one sentence for each property of the source that an animation in this format leaves out.
std::vector<std::string> animation_losses(const std::filesystem::path& path, const ShapeFile& source);

// An animation that is written frame by frame. The vertices and faces are those of the source in every frame.
//
// .pc2   PointCache2, version 1: positions as little-endian floats; starts at 0, one sample for each frame.
// .mdd   LightWave's motion designer file: times in seconds, positions as big-endian floats.
// .glb   glTF 2.0: the source, with one morph target (positions, normals) for each different frame after the first, and
//        an animation of their weights. A source in glTF keeps everything that it has.
// .usda  OpenUSD's text: a Mesh (or Points) with time samples of points, normals and extent.
// .pvd   ParaView's time series: OUT.pvd and a file OUT_0000.vtp for each frame, positions as doubles, with the
//        displacement since the first frame.
//
// The files appear complete when finish() returns, and not at all without it. Memory: two frames; for .glb also, in
// each frame, 32 bytes for each vertex that differs from the first frame, and some copies of the file; for .usda 16
// bytes for each normal that differs.
class AnimationFile {
 public:
  // Throws IoError(write) if no file can be made there, and InvalidInput for options out of range, another extension,
  // and a source that the format cannot hold.
  AnimationFile(const std::filesystem::path& path, const ShapeFile& source, const AnimationOptions& options);
  AnimationFile(const AnimationFile&) = delete;
  AnimationFile& operator=(const AnimationFile&) = delete;
  AnimationFile(AnimationFile&&) noexcept = default;
  AnimationFile& operator=(AnimationFile&&) noexcept = default;
  ~AnimationFile() = default;

  // Adds the next frame: a position for each vertex of the source. Throws IoError(write), and InvalidInput for
  // positions that the format cannot hold.
  // NOLINTNEXTLINE(readability-make-member-function-const): it changes the file
  void add(std::span<const Vec3d> positions) { writer_.add(positions); }

  // Completes the file, after all frames were added. Throws IoError(write), and InvalidInput for more than 4 GiB of
  // GLB. NOLINTNEXTLINE(readability-make-member-function-const)
  void finish() { writer_.finish(); }

  // The functions of a format.
  struct Writer {
    std::function<void(std::span<const Vec3d>)> add;
    std::function<void()> finish;
  };

 private:
  Writer writer_;
};

// The morph targets of a glTF file, and their weights over time.
struct MorphTargets {
  std::vector<std::vector<Vec3d>> shapes;  // each with a position for each vertex of the source; may be empty
  std::vector<std::string> names{};        // one for each shape, or empty
  std::vector<double> weights;             // one for each shape, for a viewer that plays no animation
  std::vector<double> times{};             // seconds, 0 or more, ascending; empty: no animation of the weights
  std::vector<double> keys{};              // the weights of all shapes at the first time, then at the second one ...
  std::size_t animation = 0;               // number of the file's animation that gets the keys; new if it has none
};

// Returns the bytes of a file in the format "glb" or "gltf" with the source and these morph targets (positions and
// normals). A source in glTF keeps everything, such as its skeleton and animations. Throws InvalidInput for lists of
// wrong lengths, for positions that the format cannot hold, and for a source that has morph targets of its own.
std::string serialize_morphed(const ShapeFile& source, const MorphTargets& targets, std::string_view format = "glb");

}  // namespace knead
