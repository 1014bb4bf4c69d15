// Changes of a GLB file: the accessors of its parts, its bytes with some numbers replaced and others appended, and the
// vertices of a mesh as its primitives hold them.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/gltf/gltf.h"

namespace knead::detail::gltf {

struct Unused {
  std::vector<std::size_t> accessors;
  std::vector<std::size_t> views;  // buffer views that only these accessors name
};

// Returns the accessors and views that only the attributes and indices of these primitives (mesh, number) use. Returns
// nothing if the file has an unknown extension, which may name accessors or views in an unknown way.
Unused unused_after(const Document& document, const std::set<std::pair<std::size_t, std::size_t>>& primitives);

// The bytes of the binary chunk that are removed.
class Cuts {
 public:
  Cuts() = default;

  // Removes the bytes that only views with is_replaced[view] cover, in multiples of four; none if a view is malformed.
  Cuts(const Document& document, const std::vector<bool>& is_replaced);

  bool empty() const { return spans_.empty(); }

  // Returns the new position of a byte that stays.
  std::size_t moved(std::size_t position) const;

  // Returns how many bytes are removed.
  std::size_t size() const { return through_.empty() ? 0 : through_.back(); }

  // Returns the bytes of the first `size` that stay.
  std::vector<Span> rest(std::size_t size) const;

 private:
  void subtract(Span range, const std::vector<Span>& kept);
  void add(Span span);

  std::vector<Span> spans_;           // in order
  std::vector<std::size_t> through_;  // how many bytes are removed up to the end of each
};

inline constexpr std::size_t kVertexData = 34962;  // targets of buffer views
inline constexpr std::size_t kIndexData = 34963;

// New numbers of some elements of an accessor.
struct NewElements {
  std::size_t components = 3;
  std::vector<std::uint32_t> elements;  // ascending
  std::vector<float> values;            // `components` for each
};

// Bytes that are made when they are written.
struct LazyBytes {
  std::size_t size = 0;
  std::function<void(const ByteSink&)> write;
};

class Edit {
 public:
  // The document and the layout must outlive it.
  Edit(const Document& document, const Layout& layout);

  // Returns the text of item i of the array at that key of the file, e.g. "meshes".
  Span item(const char* key, std::size_t i) const;

  // Patches that make the primitives of a mesh, the value of whose attribute is a number, use another accessor.
  std::vector<Patch> attribute_patches(std::size_t mesh, const std::vector<std::size_t>& primitives,
                                       const std::string& key, std::size_t accessor);

  void patch(const std::vector<Patch>& patches) { patches_.insert(patches_.end(), patches.begin(), patches.end()); }

  // Writes these elements, which must outlive this, over those that `data` describes.
  void overwrite(const DenseData& data, const NewElements& elements);

  // Returns whether the accessor has a min or max.
  bool has_bounds(std::size_t accessor) const;

  // Sets the min and max of the accessor, if it has them, to those of these values.
  void set_bounds(std::size_t accessor, const std::vector<float>& values, std::size_t components);

  // Appends the values as a new accessor (SCALAR, VEC3 or VEC4) and returns its index.
  std::size_t append_accessor(const std::vector<float>& values, std::size_t components);

  // Lets appended items take the numbers of these, whose bytes are removed from the file.
  void reuse(Unused unused) { unused_ = std::move(unused); }

  // Appends elements as a new accessor over a view of its own and returns its index. stride: the bytes from one to the
  // next, or 0 where they stand side by side. `members` are
  // those of the accessor besides the view, e.g. R"("componentType":5125,"count":3,"type":"SCALAR")".
  std::size_t append_elements(std::string_view elements, std::size_t stride, std::size_t target,
                              const std::string& members);

  // Appends elements as a new view and returns its index. A target of 0: none is stated.
  std::size_t append_view(std::string_view elements, std::size_t stride, std::size_t target);
  std::size_t append_view(LazyBytes elements, std::size_t stride, std::size_t target);

  // Appends an accessor, the text of a JSON object, and returns its index.
  std::size_t append_accessor(const std::string& text);

  // Appends an animation, the text of a JSON object.
  void append_animation(const std::string& text);

  // Gives a node a mesh of its own: a copy with these patches, which are within the text of the old one.
  void copy_mesh(std::size_t node, std::size_t mesh, std::vector<Patch> patches);

  // Passes on the file, piece by piece. Throws InvalidInput where it would exceed 4 GiB, before the first piece.
  void finish(const ByteSink& out);
  std::string finish();

 private:
  std::size_t append_mesh(const std::string& text);  // returns its index

  struct Array {
    const char* key;
    Span span;
    std::vector<Member> items;
    std::string appended;
    std::size_t count;  // with what is appended
  };

  // Of elements that were appended.
  struct View {
    std::size_t index = 0;
    Span bytes;
    std::size_t stride = 0;
    std::size_t target = 0;
  };

  struct Overwrite {
    DenseData data;
    const NewElements* elements = nullptr;
  };

  void put_views();
  Cuts cut_bytes();
  void write_bin(const Cuts& cuts, const ByteSink& out) const;
  static void put_over(const Overwrite& overwrite, std::size_t begin, std::string& piece);

  Array& array(const char* key);
  const Array& array(const char* key) const;

  // The number of a new item: a unused one, or the next.
  std::size_t next_number(const char* key, std::vector<std::size_t>& unused);

  // Replaces the item of that number, or appends it: those beyond the old ones in order.
  void put(const char* key, std::size_t number, const std::string& item);

  const Document& document_;
  const Layout& layout_;
  std::vector<Array> arrays_;
  std::map<std::size_t, std::vector<Member>> primitives_;  // of the meshes that were asked for
  std::vector<Patch> patches_;
  std::vector<Overwrite> overwrites_;
  std::vector<LazyBytes> appended_;  // to the binary chunk, each at a multiple of four bytes
  std::size_t bin_size_;
  Unused unused_;
  std::vector<View> views_;
};

// Appends a chunk, padded to a multiple of four bytes.
void append_chunk(std::string& bytes, std::uint32_t type, std::string_view contents);

// The header of a file, and with its chunks. Throw InvalidInput where the file would exceed 4 GiB.
std::string file_header(std::size_t chunks_size);
std::string with_header(std::string chunks);

// "[1,2.5]": the least, or greatest, of each component, in a form that reads back as the same number. What is not
// finite does not count.
std::string least_text(const std::vector<float>& values, std::size_t components);
std::string greatest_text(const std::vector<float>& values, std::size_t components);

// Returns the type of accessors with that many components.
std::string vector_type(std::size_t components);

// Appends a number as little-endian bytes.
void append_number(std::string& bytes, NumberType type, double value);

// One place that names an accessor.
struct AccessorUse {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  std::size_t mesh = kNone;  // kNone: skins, animations, instancing
  std::size_t primitive = kNone;
  std::string key;  // of the attribute; empty for indices and morph targets
};

// Returns true for an extension that does not change the geometry, or that the reader understands.
bool is_understood(const std::string& extension);

// Returns the uses of each accessor, by accessor.
std::map<std::size_t, std::vector<AccessorUse>> find_uses(const Document& document);

// Returns for each mesh of the file that has vertices the blocks of each node that places it.
std::map<std::size_t, std::vector<std::vector<std::size_t>>> blocks_by_node(const Layout& layout);

// Returns how many nodes place each mesh, in all scenes.
std::map<std::size_t, std::size_t> count_placements(const Document& document);

// Returns whether the bytes of an accessor's elements are also read through another accessor, a sparse accessor's
// indices or values, or an image; also true if finding out would take long.
class ByteReaders {
 public:
  explicit ByteReaders(const Document& document);

  bool others_read(std::size_t accessor) const;

 private:
  struct Range {
    std::size_t accessor;  // kNone: not one's elements
    std::size_t begin;
    std::size_t end;
    std::size_t stride;
    std::size_t size;
  };

  static bool overlap(const Range& a, const Range& b);
  void add_accessors(const Document& document);
  void add_images(const Document& document);

  std::vector<Range> ranges_;              // by where they begin
  std::vector<std::size_t> furthest_end_;  // of the ranges up to each
  std::map<std::size_t, std::size_t> of_accessor_;
};

// An attribute and its key in the file.
struct WritableAttribute {
  std::string key;
  Attribute attribute;  // of vertices or corners
};

struct WritableAttributes {
  std::vector<WritableAttribute> attributes;
  std::vector<std::string> losses;
};

// Returns the attributes that GLB can hold, and a sentence for each that it cannot.
WritableAttributes writable_attributes(const Mesh& mesh);

// The vertices of the file: those of the mesh in their order, then the copies that seams need.
struct SplitVertices {
  std::vector<std::uint32_t> original;      // the vertex of the mesh
  std::vector<std::size_t> corner;          // some corner of the mesh that uses it; kNone for a vertex in no face
  std::vector<std::uint32_t> corner_index;  // the vertex of the file for each corner of the mesh

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
};

// Returns the vertices of the file; corners that differ in an attribute get separate vertices.
SplitVertices split_vertices(const Mesh& mesh, const std::vector<WritableAttribute>& held);

}  // namespace knead::detail::gltf
