// glTF 2.0 as text (.gltf) and binary (.glb): what a file holds, and its JSON. Sources: Khronos, "glTF 2.0
// Specification" (2021), KHR_mesh_quantization and KHR_gaussian_splatting.
//
// Every file is read, and written back, as the GLB file that holds the same and whose one buffer is its binary chunk.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/codec.h"
#include "io/numbers.h"
#include "json/json.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail::gltf {

struct Chunk {
  std::uint32_t type = 0;
  std::size_t begin = 0;  // of its contents
  std::size_t size = 0;
};

// How a node places its mesh: world = linear * local + offset.
struct Placement {
  Mat3d linear;
  Vec3d offset;
  Mat3d inverse;  // of linear
};

// Vertices of the mesh that come from one POSITION accessor, placed by one node.
struct Block {
  std::size_t first = 0;  // vertex of the mesh
  std::size_t count = 0;
  std::size_t node = 0;
  std::size_t mesh = 0;                 // of the file
  std::vector<std::size_t> primitives;  // of that mesh
  std::size_t position = 0;             // accessors
  std::optional<std::size_t> normal;
  std::optional<std::size_t> tangent;
  std::optional<std::size_t> uv;
  std::optional<std::size_t> color;
  std::map<std::string, std::size_t> splats{};  // accessors of Gaussian splats by their keys; empty: there are none
  Placement placement;
};

// Faces of the mesh, one after the other, that come from one primitive.
struct Faces {
  std::size_t first = 0;
  std::size_t block = 0;
  std::size_t primitive = 0;  // of the block's mesh
};

// A buffer of the source.
struct Buffer {
  enum class Kind { chunk, data, file };

  Kind kind = Kind::chunk;
  std::string head;       // of a data URI: "data:...;base64,"
  std::string file;       // the plain name of a file
  std::size_t begin = 0;  // of its bytes among those of all buffers
  std::size_t size = 0;
};

// Of a source that is not the GLB file which is read.
struct Wrapping {
  std::string glb;              // that file
  std::vector<Buffer> buffers;  // of the source
  std::string buffers_text;     // the JSON array of them
  std::filesystem::path path;   // of the source, beside which the files of buffers are; empty: read from memory
};

// The contents of a GLB file that the mesh does not hold.
struct Layout {
  std::vector<Chunk> chunks;  // as in the file; the first is the JSON
  std::optional<std::size_t> bin;
  std::size_t end = 0;        // of the last chunk; what follows is kept
  std::vector<Block> blocks;  // the vertices in the mesh's order
  std::vector<Faces> faces;   // in the mesh's order; each goes on to where the next one begins
  std::optional<Wrapping> wrapping;
  std::string text;  // the JSON of a file that is not in memory
};

// Returns the layout of a file that is not read into memory, without the blocks; nothing if the file holds other than a
// JSON and a binary chunk.
std::optional<Layout> layout_of_file(const SourceFile& file);

// Returns the text as a JSON object. Throws InvalidInput for what parse_json refuses and for other values than objects;
// `begin`, the byte of the file where the text begins, is for messages.
Json parse_object(std::string_view text, std::size_t begin, const std::string& name);

// The file and position of the text that a value was read from, for messages.
struct Source {
  std::string file;
  std::string_view text;
  std::size_t begin = 0;  // byte of the file
};

// A value that knows its path, e.g. accessors[3].count, for messages. The value and the source must outlive it.
class Value {
 public:
  Value(const Json& json, const Source& source, std::string path = {})
      : json_(&json), source_(&source), path_(std::move(path)) {}

  // Returns the value at a key; nothing if this is no object or has no such key.
  std::optional<Value> find(const char* key) const;

  // Returns the value at a key; fails if it is missing.
  Value at(const char* key) const;

  // The size of an array; fails for anything else.
  std::size_t size() const;

  // The item of an array; fails where there is none.
  Value item(std::size_t i) const;

  // The item of the array at the key, e.g. item("accessors", 3).
  Value item(const char* key, std::size_t i) const;

  // The size of the array at the key; 0 where it is missing.
  std::size_t count(const char* key) const;

  double number() const;
  std::size_t whole() const;                                // from 0 to 2^53
  std::optional<std::size_t> whole(const char* key) const;  // nothing where the key is missing
  std::vector<double> numbers(std::size_t count) const;
  std::string text() const;
  bool flag(const char* key) const;  // false where the key is missing

  const Json& json() const { return *json_; }

  // Throws InvalidInput "FILE: byte N: PATH: what", the byte where the value begins.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  const Json* json_;
  const Source* source_;
  std::string path_;
};

// Bytes [begin, end) of a text.
struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// The span of the value at a path such as accessors[3].count, or of the last value on the way to it that the text has.
Span span_at(std::string_view text, std::string_view path);

struct Member {
  std::string key;  // empty for the items of an array
  Span value;
};

// The object that a text which parse_json has read consists of.
Span root_span(std::string_view text);

// The members of an object, or the items of an array; none for anything else. Takes time in proportion to the span.
std::vector<Member> members(std::string_view text, const Span& container);

// The span of the value at the key of an object, or nothing.
std::optional<Span> member(std::string_view text, const Span& object, std::string_view key);

// Replaces [begin, end), or inserts where both are the same.
struct Patch {
  Span span;
  std::string text;
};

// Appends an item to the array at `array`.
Patch appended_item(std::string_view text, const Span& array, const std::string& items);

// The text with its patches, which do not overlap.
std::string patched(std::string_view text, std::vector<Patch> patches);

inline constexpr std::size_t kJson = 0x4E4F534A;
inline constexpr std::size_t kBin = 0x004E4942;

inline constexpr std::size_t kPoints = 0;  // modes of primitives
inline constexpr std::size_t kTriangles = 4;
inline constexpr std::size_t kTriangleStrip = 5;
inline constexpr std::size_t kTriangleFan = 6;

// The contents of a binary chunk, in memory or in a file.
class Bin {
 public:
  Bin() = default;
  explicit Bin(std::string_view bytes) : bytes_(bytes), size_(bytes.size()) {}
  Bin(const SourceFile& file, const Chunk& chunk) : file_(&file), begin_(chunk.begin), size_(chunk.size) {}

  std::size_t size() const { return size_; }

  // Returns these bytes; `buffer` holds those of a file.
  std::string_view piece(std::size_t begin, std::size_t count, std::string& buffer) const;

 private:
  std::string_view bytes_;
  const SourceFile* file_ = nullptr;
  std::size_t begin_ = 0;  // in the file
  std::size_t size_ = 0;
};

// A GLB file opened.
struct Document {
  std::string_view bytes;  // of the file; empty if it is not in memory
  std::string_view text;   // its JSON
  Bin bin;                 // its binary chunk; empty without one
  std::size_t size = 0;    // of the file
  Json json;
  Source source;  // for messages

  Value root() const { return {json, source}; }
};

// The chunks of the file; the blocks stay empty. Throws InvalidInput that names the byte.
Layout parse_chunks(std::string_view bytes, const std::string& name);

// The document of a GLB file in memory, or of `file`; what is given must outlive it. Checks the version.
Document open_document(std::string_view bytes, const Layout& layout, const std::string& name,
                       const SourceFile* file = nullptr);

// The document that a source was read as, which must outlive it.
Document open_source(const ShapeFile& source);

// Where an accessor's elements are: element i at begin + i * stride of the binary chunk.
struct DenseData {
  std::size_t begin = 0;
  std::size_t stride = 0;
  std::size_t end = 0;  // of the last element
};

struct SparseData {
  std::size_t count = 0;
  NumberType index_type = NumberType::uint8;
  DenseData indices;
  DenseData values;
};

struct Accessor {
  std::size_t count = 0;
  NumberType type = NumberType::float32;
  bool normalized = false;
  std::size_t components = 1;
  std::optional<DenseData> dense;    // std::nullopt: zeros
  std::optional<SparseData> sparse;  // replaced elements

  std::size_t element_size() const;
};

// The type of an accessor's numbers, and their number for each element, from its componentType and type.
NumberType component_type(const Value& code);
std::size_t component_count(const Value& type);

// The accessor of that index with every range checked against the binary chunk. Throws InvalidInput for one that is
// malformed, that lies in another buffer, that is compressed, or that holds no data.
Accessor find_accessor(const Document& document, std::size_t index);

// Returns the accessor's numbers, `components` for each element. With `as_real`, normalised integers are divided by
// their maximum (rounded to float). Throws InvalidInput for sparse indices out of order.
std::vector<double> read_accessor(const Document& document, std::size_t index, const Accessor& accessor, bool as_real);

// Passes these numbers on in parts, each with the number of its first element.
using TakeNumbers = std::function<void(std::size_t first, std::span<const double> numbers)>;
void read_in_parts(const Document& document, std::size_t index, const Accessor& accessor, bool as_real,
                   const TakeNumbers& take);

// The vertices and corners that a file of that many bytes may have.
inline std::size_t most_elements(std::size_t bytes) { return (std::size_t{1} << 21) + 4 * bytes; }

// An attribute of a primitive that becomes one of the mesh.
struct Semantic {
  const char* key;   // in the file
  const char* name;  // of the mesh's attribute
  std::optional<std::size_t> Block::*accessor;
};

inline constexpr std::array<Semantic, 4> kSemantics = {{{"NORMAL", "normal", &Block::normal},
                                                        {"TANGENT", "tangent", &Block::tangent},
                                                        {"TEXCOORD_0", "uv", &Block::uv},
                                                        {"COLOR_0", "color", &Block::color}}};

// The attributes that some block has: directions in world coordinates and of length 1. Where a block has none, colors
// are white and others 0, which a note says. Throws InvalidInput for accessors that do not fit.
std::vector<Attribute> read_attributes(const Document& document, const std::vector<Block>& blocks,
                                       std::vector<std::string>& notes);

// Whether an attribute of that key in the file becomes one of the mesh.
bool is_read(const std::string& key);

// The extension of a primitive of Gaussian splats; its attributes are named "KHR_gaussian_splatting:NAME".
inline constexpr const char* kSplatting = "KHR_gaussian_splatting";

// Returns the accessors of the splats that a primitive holds, by their keys; none for a primitive of other points or of
// faces. Throws InvalidInput for splats that are compressed, incomplete, or of an unknown kernel.
std::map<std::string, std::size_t> splat_accessors(const Value& primitive);

// Appends the attributes of splats (splats.h) in world coordinates, if some block has splats; other vertices become
// splats that are not seen. The mesh has all positions and faces. Throws InvalidInput for accessors that do not fit.
void read_splats(const Document& document, const std::vector<Block>& blocks, Mesh& mesh,
                 std::vector<std::string>& notes);

// An attribute of splats as a file holds it.
struct SplatNumbers {
  std::string key;
  std::vector<std::string> names;  // of the mesh's attributes, one for each component
  std::vector<float> values;
};

// Returns the attributes of these splats of a mesh, ascending, in local coordinates. options: those that have other
// values than in the mesh.
std::vector<SplatNumbers> local_splats(const Placement& placement, const Mesh& mesh,
                                       std::span<const std::uint32_t> splats, const WriteOptions& options = {});

// Returns the direction of a vector; zero for the zero vector and for one that is not finite.
Vec3d direction(const Vec3d& v);

// A node that places a mesh.
struct Instance {
  std::size_t node = 0;
  std::size_t mesh = 0;
  Placement placement;
};

// The instances of the default scene (the first one, if none is named; all of the nodes, if there is none), in
// depth-first order. A skinned node is placed nowhere (glTF 2.0, 3.7.3.3): its vertices stay local. Nodes whose
// transform has no inverse are left out. Notes say both. Throws InvalidInput for nodes that form a cycle or have two
// parents, and for transforms that are none.
std::vector<Instance> find_instances(const Document& document, std::vector<std::string>& notes);

// Reads the triangles of the scene of a GLB file into the shape: those of the default scene in world coordinates, as
// stored. Vertices that a seam in the texture or a hard edge repeats are not welded, and a mesh that several nodes
// place has its vertices once for each. Attributes: "normal" (3, unit), "uv" (2; v upwards as in the other formats, 1
// minus what the file holds), "color" (3 or 4, in the type of the file) and "tangent" (4), each if some primitive has
// it, and those of splats. Throws InvalidInput also for what cannot be read without another file or a decoder. Vertices
// and corners may not exceed 2^21 plus four for each byte of the file (a small file can place one mesh very often).
// layout: that of the file, without blocks. glb: its bytes, unless the shape has a file.
Layout read_scene(ShapeFile& shape, Layout layout, std::string_view glb, const std::string& name);

// The functions of both containers' codecs for the GLB file. Of the options only the changed attributes count.
void rewrite_glb(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                 const WriteOptions& options, const ByteSink& out);
// Returns whether one primitive at one node holds all vertices of the file.
bool is_one_part(const ShapeFile& source);
std::string generate_glb(const Mesh& mesh, const WriteOptions& options);
std::string remeshed_glb(const NewMesh& shape);
std::vector<std::string> losses(const Mesh& mesh);
std::vector<std::string> source_losses(const ShapeFile& source);
std::vector<std::string> remesh_losses(const ShapeFile& source);
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// Returns a GLB file as text, with its buffer as a data URI.
std::string as_text(const std::string& glb);

// The extension of a primitive that compresses it.
inline constexpr const char* kDraco = "KHR_draco_mesh_compression";

// Return whether this build can decompress.
bool has_draco();
bool has_meshopt();

// The contents of a buffer view that EXT_meshopt_compression compresses; the names are those of the extension.
struct MeshoptView {
  std::size_t stride = 0;
  std::size_t count = 0;
  std::string mode;    // ATTRIBUTES, TRIANGLES or INDICES
  std::string filter;  // NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL
};

// Returns count * stride bytes; nothing for a damaged view, or one that the extension does not allow. A view that
// declares more than the codec can pack into so few bytes is damaged: memory stays below 512 bytes for each byte.
std::optional<std::string> decode_meshopt(std::string_view bytes, const MeshoptView& view);

// An attribute that a Draco mesh holds under a number, as an accessor wants it.
struct DracoAttribute {
  std::uint32_t id = 0;
  NumberType type = NumberType::float32;
  std::size_t components = 1;
};

struct DracoMesh {
  std::size_t vertices = 0;
  std::vector<std::uint32_t> corners;   // three for each triangle
  std::vector<std::string> attributes;  // as little-endian numbers side by side, in the order asked for
};

// Returns the mesh; nothing for damaged bytes, an attribute that is not there, more than `most` vertices or corners, or
// attributes of more than 64 bytes for each of `most`.
std::optional<DracoMesh> decode_draco(std::string_view bytes, const std::vector<DracoAttribute>& attributes,
                                      std::size_t most);

// Returns the extension of a buffer view that compresses it, or null.
const char* meshopt_extension(const Json& view);

// Returns whether a text names a compression that this build can undo.
bool names_codec(std::string_view text);

// Returns the file without compression, and adds a note; the same bytes where nothing is compressed that this build can
// decompress. `bytes` is a GLB file with one buffer, its binary chunk. Throws InvalidInput that names the view or the
// primitive.
std::string decompressed(std::string bytes, const std::string& name, std::vector<std::string>& notes);

}  // namespace knead::detail::gltf
