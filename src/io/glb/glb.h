// Where the numbers of a GLB file are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/codec.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::io_detail::glb {

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
  Placement placement;
};

// Faces of the mesh, one after the other, that come from one primitive.
struct Faces {
  std::size_t first = 0;
  std::size_t block = 0;
  std::size_t primitive = 0;  // of the block's mesh
};

// The part of a GLB file that a mesh does not hold.
struct Layout {
  std::vector<Chunk> chunks;  // as in the file; the first is the JSON
  std::optional<std::size_t> bin;
  std::size_t end = 0;        // of the last chunk; what follows is kept
  std::vector<Block> blocks;  // the vertices in the mesh's order
  std::vector<Faces> faces;   // in the mesh's order; each goes on to where the next one begins
};

// Binary glTF 2.0 (GLB): reading, writing back, writing anew. Source: Khronos, "glTF 2.0 Specification" (2021), and
// KHR_mesh_quantization.
//
// The mesh is that of the default scene in world coordinates, as stored: vertices that a seam in the texture or a hard
// edge repeats are not welded, and a mesh that several nodes place has its vertices once for each. Attributes: "normal"
// (3, unit), "uv" (2; v upwards as in the other formats, 1 minus what the file holds), "color" (3 or 4, in the type of
// the file) and "tangent" (4), each if some primitive has it.

// Throws InvalidInput also for what cannot be read without another file or a decoder: buffers outside of the file,
// Draco and meshopt compression. Vertices and corners may not exceed 2^21 plus four for each byte of the file (a small
// file can place one mesh very often).
void read(ShapeFile& shape, const std::string& name);

// The source with other positions and, if there are any, other normals (both per vertex, in world coordinates); the
// tangents follow (transport_tangents). Numbers in the file are local floats: a vertex that did not move keeps its
// bits. Only its numbers, the bounds of its accessors and what those need are replaced. Data that the file stores as
// integers, sparsely, or in bytes that something else reads too, is appended as new floats; a mesh that several nodes
// place gets copies where they moved differently. Throws InvalidInput where a float cannot hold a coordinate. The
// options change nothing.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);

// A new file: one node, one mesh, one primitive of triangles (of points, if there are no faces) with float coordinates,
// whatever the options say. A vertex whose corners differ in an attribute becomes several at the end of the list.
// Other attributes per vertex become "_NAME". Throws InvalidInput where a float cannot hold a coordinate.
std::string generate(const Mesh& mesh, const WriteOptions& options);

// What generate leaves out, a sentence each.
std::vector<std::string> losses(const Mesh& mesh);

// What a file made of the source's mesh alone leaves out.
std::vector<std::string> source_losses(const ShapeFile& source);

std::string remeshed(const NewMesh& shape, const WriteOptions& options);
std::vector<std::string> remesh_losses(const ShapeFile& source);
std::vector<std::uint32_t> face_labels(const ShapeFile& source);

// The JSON of a GLB file: read strictly, and found again in the text. Internal to the GLB reader and writer.

// Returns the text as a JSON object. Throws InvalidInput for what parse_json refuses and for other values than objects;
// `begin`, the byte of the file where the text begins, is for messages.
Json parse_object(std::string_view text, std::size_t begin, const std::string& name);

// Where the text that a value was read from stands: for messages.
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

  // The value at a key; nothing where this is no object or has no such key.
  std::optional<Value> find(const char* key) const;

  // The same; fails where it is missing.
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

// The accessors of a GLB file: where their numbers are. Internal to the GLB reader and writer.

inline constexpr std::size_t kJson = 0x4E4F534A;
inline constexpr std::size_t kBin = 0x004E4942;

inline constexpr std::size_t kPoints = 0;  // modes of primitives
inline constexpr std::size_t kTriangles = 4;
inline constexpr std::size_t kTriangleStrip = 5;
inline constexpr std::size_t kTriangleFan = 6;

// A GLB file opened.
struct Document {
  std::string_view bytes;  // of the file
  std::string_view text;   // its JSON
  std::string_view bin;    // its binary chunk; empty without one
  Json json;
  Source source;  // for messages

  Value root() const { return {json, source}; }
};

// The chunks of the file; the blocks stay empty. Throws InvalidInput that names the byte.
Layout parse_chunks(std::string_view bytes, const std::string& name);

// The document; `bytes` must outlive it. Checks the version.
Document open_document(std::string_view bytes, const Layout& layout, const std::string& name);

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

// What a componentType and a type of an accessor say: the type of number, its bytes, and how many make an element.
NumberType component_type(const Value& code);
std::size_t component_size(NumberType type);
std::size_t component_count(const Value& type);

// The accessor of that index with every range checked against the binary chunk. Throws InvalidInput for one that is
// malformed, that lies in another buffer, that is compressed, or that holds no data.
Accessor find_accessor(const Document& document, std::size_t index);

// Its numbers, components per element. Integers as they are, or with `as_real` as what they stand for: divided by
// their maximum where the accessor says so (rounded to float). Throws InvalidInput for sparse indices out of order.
std::vector<double> read_accessor(const Document& document, std::size_t index, const Accessor& accessor, bool as_real);

// The vertices and corners that a file of that many bytes may have.
inline std::size_t most_elements(std::size_t bytes) { return (std::size_t{1} << 21) + 4 * bytes; }

// The attributes of the vertices that a GLB file's primitives have. Internal to the GLB reader.

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

// The direction of a vector; zero for zero and for what is not finite.
Vec3d direction(const Vec3d& v);

// The nodes of a GLB file's scene and where they are. Internal to the GLB reader.

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

}  // namespace knead::io_detail::glb
