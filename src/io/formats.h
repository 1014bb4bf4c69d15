// Where the numbers of a file are: what a format's reader leaves for its writer.
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

namespace knead::io_detail {

// Holds the Layout type of the format that read the file, e.g. ply::Layout.
struct AnyLayout {
  std::any value;
};

template <class FormatLayout>
void set_layout(ShapeFile& shape, FormatLayout layout) {
  shape.layout = std::make_shared<const AnyLayout>(AnyLayout{std::move(layout)});
}

// Returns null for a shape of another format.
template <class FormatLayout>
const FormatLayout* find_layout(const ShapeFile& shape) {
  return shape.layout == nullptr ? nullptr : std::any_cast<FormatLayout>(&shape.layout->value);
}

// The layout of a shape that this format's reader has made; any other shape is an error of the caller,
// std::bad_any_cast.
template <class FormatLayout>
const FormatLayout& layout_of(const ShapeFile& shape) {
  if (const FormatLayout* layout = find_layout<FormatLayout>(shape)) return *layout;
  throw std::bad_any_cast();
}

// The bytes of the file that a shape was read from: those in memory, or those of the file, read again.

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

// A mesh that takes the place of the one that a file was read into.

// The arguments of serialize_remeshed, checked.
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

// The first line end of a text; "\n" without one.
inline std::string_view line_end_of(std::string_view text) {
  const std::size_t end = text.find_first_of("\r\n");
  if (end == std::string_view::npos) return "\n";
  return text.substr(end, text.substr(end, 2) == "\r\n" ? 2 : 1);
}

// How fine the numbers of a file are against the shape.

// Returns a note if floats where the mesh stands lie further apart than a hundredth of its mean edge (of points: of
// their mean distance on a surface as large as their box); else an empty text.
std::string spacing_note(const Mesh& mesh);

// The table of the formats: what each can do.

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

  // A new file, and what it leaves out of the mesh; null for formats that are written from files of their own only.
  std::string (*generate)(const Mesh& mesh, const WriteOptions& options);
  std::vector<std::string> (*losses)(const Mesh& mesh);

  // What a file of another format leaves out that is in this source but not in its mesh.
  std::vector<std::string> (*source_losses)(const ShapeFile& source);

  // A file like the source's with another mesh, and what it leaves out of the source; null for points.
  std::string (*remeshed)(const NewMesh& shape, const WriteOptions& options);
  std::vector<std::string> (*remesh_losses)(const ShapeFile& source);

  // See face_labels in io.h; null if a file of this format does not group faces.
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

  // Reads a file piece by piece and sets ShapeFile::file, not its bytes; nothing if this file's writers need all bytes.
  // Null: they always do.
  std::optional<ShapeFile> (*parse_in_pieces)(const std::shared_ptr<const SourceFile>& file,
                                              const std::string& name) = nullptr;

  // Returns the summary of a source of which only the bytes or the file are set; nothing if that takes reading it as a
  // shape. Null: it always does.
  std::optional<ShapeSummary> (*summarize)(const ShapeFile& source, const std::string& name) = nullptr;
};

std::span<const Format> formats();

// Throws InvalidInput for a number of decimals that no double has.
void check_decimals(const WriteOptions& options);

// Files NAME.EXT.gz are compressed after RFC 1952.
inline constexpr std::string_view kGzip = ".gz";

// Returns what is in a file, without its compression by gzip. Throws IoError(read).
std::string bytes_of_file(const std::filesystem::path& path);
bool is_gzip_name(const std::filesystem::path& path);

// Returns what compressed bytes hold, of all members one after the other. Throws InvalidInput for damaged ones, and if
// Knead was built without zlib.
std::string unzipped(std::string_view bytes, const std::string& name);

// Returns the bytes, compressed without a name or time. Throws InvalidInput if Knead was built without zlib.
std::string zipped(std::string_view bytes, const std::string& name);

// Writes a file in the source's own format, with the files beside it that belong to it.
void write_own_format(const std::filesystem::path& path, const ShapeFile& source, const std::string& bytes);

// Writes a file in another format than the source's.
void write_new_file(const std::filesystem::path& path, const std::string& bytes);

// Returns what a file is that does not fit its format, and what to do: a format that is not read, or one that is read
// by another name. `head`: its first bytes, of so many. Empty: nothing is known.
std::optional<std::string> other_kind(std::string_view head, std::size_t size, std::string_view format);

// Returns whether all whole lines of a text are those of an OBJ file with vertices.
bool looks_like_obj(std::string_view head);

// The format whose files have that extension, without the point and in lower case. Throws InvalidInput that lists the
// known ones and names `file`.
const Format& format_with_extension(std::string_view extension, const std::string& file);

// The format of that name. Throws InvalidInput that lists the known ones and names `file`.
const Format& format_named(std::string_view name, const std::string& file);

}  // namespace knead::io_detail
