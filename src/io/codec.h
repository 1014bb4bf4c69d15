// The Codec of a file format: its functions; the layout that its reader keeps for its writers; and the bytes of its
// files.
#pragma once

#include <any>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/numbers.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::detail {

// Vertices and attribute values of a mesh that its file does not contain.
struct VertexEdits {
  std::vector<std::uint32_t> copied;    // the file's vertices of which those after its last one are copies, in order
  std::vector<std::uint32_t> vertices;  // ascending: those with places and attributes that the file lacks
  std::vector<std::string> attributes;  // the names of these, each with one component
};

// Holds the Layout type of the format that read the file, e.g. ply::Layout.
struct AnyLayout {
  std::any value;
  VertexEdits edits{};
};

template <class FormatLayout>
void set_layout(ShapeFile& shape, FormatLayout layout) {
  shape.layout = std::make_shared<const AnyLayout>(AnyLayout{std::move(layout), {}});
}

// Returns null for a shape of another format.
template <class FormatLayout>
const FormatLayout* find_layout(const ShapeFile& shape) {
  return shape.layout == nullptr ? nullptr : std::any_cast<FormatLayout>(&shape.layout->value);
}

// Returns the layout of a shape that this format's reader has made. Any other shape is an error of the caller,
// std::bad_any_cast.
template <class FormatLayout>
const FormatLayout& layout_of(const ShapeFile& shape) {
  if (const FormatLayout* layout = find_layout<FormatLayout>(shape)) return *layout;
  throw std::bad_any_cast();
}

// A regular file that stays open, so that its bytes can be read again, even if another file takes its name.
class SourceFile {
 public:
  // Throws IoError(read).
  explicit SourceFile(const std::filesystem::path& path);
  SourceFile(const SourceFile&) = delete;
  SourceFile& operator=(const SourceFile&) = delete;
  ~SourceFile();

  std::size_t size() const { return state_.size; }

  // Fills `to` with the bytes from `begin` on. Throws IoError(read), also if the file has changed since the
  // constructor.
  void read(std::size_t begin, std::span<char> to) const;

 private:
  struct State {
    std::size_t size = 0;
    std::int64_t changed_ns = 0;

    friend bool operator==(const State&, const State&) = default;
  };
  State state() const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  int file_ = -1;
  State state_;
};

// The bytes that a shape was read from: those in memory, or those of its file, read again.
class SourceBytes {
 public:
  // The source must outlive this.
  explicit SourceBytes(const ShapeFile& source) : source_(source) {}

  std::size_t size() const { return source_.file ? source_.file->size() : source_.bytes.size(); }

  // Returns these bytes, which are valid until the next call. Throws IoError(read).
  std::string_view piece(std::size_t begin, std::size_t count);
  std::string_view all() { return piece(0, size()); }

  // Passes these bytes on, in pieces of 1 MB.
  void copy(std::size_t begin, std::size_t end, const std::function<void(std::string_view)>& out);

 private:
  const ShapeFile& source_;
  std::string buffer_;
};

// A mesh that takes the place of the one that a file was read into: the arguments of serialize_remeshed, checked.
struct NewMesh {
  const ShapeFile& source;
  const Mesh& mesh;
  std::span<const std::uint32_t> face_source;
};

// The new elements (faces, triangles) that lie in each face of the source, in their order.
class BySource {
 public:
  BySource(std::span<const std::uint32_t> source_of, std::size_t sources) : begin_(sources + 1, 0) {
    for (const std::uint32_t source : source_of) ++begin_[source + 1];
    for (std::size_t i = 0; i < sources; ++i) begin_[i + 1] += begin_[i];
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    elements_.resize(source_of.size());
    for (std::size_t i = 0; i < source_of.size(); ++i) elements_[next[source_of[i]]++] = static_cast<std::uint32_t>(i);
  }

  std::span<const std::uint32_t> of(std::size_t source) const {
    return std::span(elements_).subspan(begin_[source], begin_[source + 1] - begin_[source]);
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> elements_;
};

// Takes the bytes of a file, one piece after the other.
using ByteSink = std::function<void(std::string_view)>;

// The functions of a format. Null: the format does not support it, or does not need it. A list of losses has one
// sentence for each property that is left out.
struct Codec {
  std::string_view name;                           // also an extension of its files
  std::span<const std::string_view> extensions{};  // the others

  // Reads shape.bytes: sets the mesh, the notes and the layout. `name` is for messages.
  void (*read)(ShapeFile& shape, const std::string& name) = nullptr;

  // Reads shape.bytes with further files beside it. Null: the format has one file.
  void (*read_beside)(ShapeFile& shape, const std::filesystem::path& path) = nullptr;

  // Reads shape.file piece by piece. Returns false if this file's writers need all bytes. Null: they always do.
  bool (*read_in_pieces)(ShapeFile& shape, const std::string& name) = nullptr;

  // Returns the summary of a source of which only the bytes or the file are set; nothing if the summary needs read().
  // Null: it always does.
  std::optional<ShapeSummary> (*summarize)(const ShapeFile& source, const std::string& name) = nullptr;

  // Returns the bytes of the source with other positions, of which at least one differs, and with the normals of
  // moved_normals. Null if the format has rewrite_in_pieces.
  std::string (*rewrite)(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                         const WriteOptions& options) = nullptr;

  // Does the same, and passes the bytes on piece by piece. Throws InvalidInput before the first piece only.
  void (*rewrite_in_pieces)(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                            const WriteOptions& options, const ByteSink& out) = nullptr;

  // Returns the file of the source with copies of these vertices after its last one; empty if this source cannot have
  // them. Null: it cannot.
  std::string (*with_copies)(const ShapeFile& source, std::span<const std::uint32_t> vertices) = nullptr;

  // Returns whether the writers write AnyLayout::edits of a source, so that with_copies is not needed. Null: they do
  // not.
  bool (*writes_edits)(const ShapeFile& source) = nullptr;

  // Returns a new file, and its losses. Null: files are only written from files of the same format.
  std::string (*generate)(const Mesh& mesh, const WriteOptions& options) = nullptr;
  std::vector<std::string> (*losses)(const Mesh& mesh) = nullptr;

  // Returns the losses of a file of another format: the contents of this source that its mesh does not hold.
  std::vector<std::string> (*source_losses)(const ShapeFile& source) = nullptr;

  // Returns a file like the source's with another mesh, and its losses. Null: a format of points.
  std::string (*remeshed)(const NewMesh& shape, const WriteOptions& options) = nullptr;
  std::vector<std::string> (*remesh_losses)(const ShapeFile& source) = nullptr;

  // See face_labels in io.h. Null: a file does not group faces.
  std::vector<std::uint32_t> (*face_labels)(const ShapeFile& source) = nullptr;

  // Returns the source's normals after its vertices moved, one for each corner; empty if it has none. Null: normals are
  // those of vertices.
  std::vector<Vec3d> (*moved_corner_normals)(const ShapeFile& source, std::span<const Vec3d> positions) = nullptr;

  // Returns whether the coordinates of a source are 32-bit floats. Null: never.
  bool (*stores_floats)(const ShapeFile& source) = nullptr;
  bool can_widen = false;         // a source with floats is rewritten with doubles if the options say so
  bool generates_floats = false;  // new files have floats, whatever the options say
  bool needs_faces = false;       // new files hold no points without faces
  bool is_for_splats = false;     // new files hold splats (splats.h) and nothing else

  // Calls visit for the word of each coordinate of a text file; not called for binary files. Null: there is no text.
  void (*visit_coordinates)(const ShapeFile& source, const WordVisitor& visit) = nullptr;

  // Writes the bytes of a file of the source with the files beside it that belong to it. Null: there are none.
  void (*write)(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes) = nullptr;

  // Does copy_material_files(), from one folder to another. Null: a file names no others.
  std::vector<std::filesystem::path> (*copy_beside)(const ShapeFile& source, const std::filesystem::path& from,
                                                    const std::filesystem::path& to, const ByteSink& note) = nullptr;
};

std::span<const Codec* const> codecs();

// Returns the codec of that name, or null.
const Codec* find_codec(std::string_view name);

// Returns the codec of that name. Throws InvalidInput that lists the known ones and names `file`.
const Codec& codec_named(std::string_view name, const std::string& file);

// Returns the codec whose files have that extension, without the point and in lower case. Throws InvalidInput that
// lists the known ones and names `file`.
const Codec& codec_with_extension(std::string_view extension, const std::string& file);

// Returns a sentence on the kind of a file that does not fit its format, with advice: a format that Knead does not
// read, or one that it reads by another extension. `head`: its first bytes. Empty if the kind is unknown.
std::optional<std::string> other_kind(std::string_view head, std::size_t size, std::string_view format);

// Returns the notes on splats (splats.h).
std::string splat_note(const Mesh& splats);

// Returns whether all whole lines of a text are those of an OBJ file with vertices.
bool looks_like_obj(std::string_view head);

// Returns the contents of a file, decompressed if it is in gzip. Throws IoError(read).
std::string bytes_of_file(const std::filesystem::path& path);

// Replaces a file, or creates it; compresses the bytes if its name says so.
void write_new_file(const std::filesystem::path& path, const std::string& bytes);

// Returns the folder that a file lies in: "." for a plain name.
std::filesystem::path folder_of(const std::filesystem::path& path);

// Files NAME.EXT.gz are compressed after RFC 1952.
inline constexpr std::string_view kGzip = ".gz";
bool is_gzip_name(const std::filesystem::path& path);

// Returns the decompressed bytes of all members, one after the other. Throws InvalidInput for damaged bytes, and if
// Knead was built without zlib.
std::string unzipped(std::string_view bytes, const std::string& name);

// Returns the bytes, compressed without a name or time. Throws InvalidInput if Knead was built without zlib.
std::string zipped(std::string_view bytes, const std::string& name);

// Returns the decompressed bytes of a stream of deflate (RFC 1951). Throws as unzipped().
std::string inflate_bytes(std::string_view bytes, const std::string& name);

// Returns the bytes as such a stream; nothing if Knead was built without zlib.
std::optional<std::string> deflate_bytes(std::string_view bytes);

// The codecs, each defined in its format's folder.
extern const Codec ply_codec, obj_codec, glb_codec, gltf_codec, stl_codec, off_codec, threemf_codec;
extern const Codec xyz_codec, pcd_codec, ptx_codec, splat_codec, spz_codec;
extern const Codec su2_codec, gmsh_codec, foam_codec, nastran_codec, abaqus_codec, unv_codec;

}  // namespace knead::detail
