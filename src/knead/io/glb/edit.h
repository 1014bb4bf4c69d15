// Changes of a GLB file: its bytes with some numbers replaced and others appended. Internal to the GLB writer.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "knead/io/glb/accessor.h"
#include "knead/io/glb/unused.h"

namespace knead::io_detail::glb {

inline constexpr std::size_t kVertexData = 34962;  // targets of buffer views
inline constexpr std::size_t kIndexData = 34963;

class Edit {
 public:
  // The document and the layout must outlive it.
  Edit(const Document& document, const Layout& layout);

  // The text of item i of the array at that key of the file, e.g. "meshes".
  Span item(const char* key, std::size_t i) const;

  // Patches that make the primitives of a mesh, the value of whose attribute is a number, use another accessor.
  std::vector<Patch> attribute_patches(std::size_t mesh, const std::vector<std::size_t>& primitives, const char* key,
                                       std::size_t accessor);

  void patch(const std::vector<Patch>& patches) { patches_.insert(patches_.end(), patches.begin(), patches.end()); }

  // Writes a float at that byte of the binary chunk.
  void overwrite(std::size_t position, float value);

  // Makes the min and max that the accessor states, if any, those of these values.
  void set_bounds(std::size_t accessor, const std::vector<float>& values, std::size_t components);

  // Appends the values as a new accessor (VEC3 or VEC4) and returns its index.
  std::size_t append_accessor(const std::vector<float>& values, std::size_t components);

  // From now on, what is appended takes the numbers of these, and their bytes go from the file.
  void reuse(Unused unused) { unused_ = std::move(unused); }

  // Appends elements as a new accessor over a view of its own and returns its index. stride: the bytes from one to the
  // next, or 0 where they stand side by side. `members` are
  // those of the accessor besides the view, e.g. R"("componentType":5125,"count":3,"type":"SCALAR")".
  std::size_t append_elements(std::string_view elements, std::size_t stride, std::size_t target,
                              const std::string& members);

  // Appends elements as a new view and returns its index. A target of 0: none is stated.
  std::size_t append_view(std::string_view elements, std::size_t stride, std::size_t target);

  // Appends an accessor, the text of a JSON object, and returns its index.
  std::size_t append_accessor(const std::string& text);

  // Appends an animation, the text of a JSON object.
  void append_animation(const std::string& text);

  // Gives a node a mesh of its own: a copy with these patches, which are within the text of the old one.
  void copy_mesh(std::size_t node, std::size_t mesh, std::vector<Patch> patches);

  // The file. Throws InvalidInput where it would exceed 4 GiB.
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

  void put_views();
  void cut_bytes();

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
  std::string bin_;
  Unused unused_;
  std::vector<View> views_;
};

// Appends a chunk, padded to a multiple of four bytes.
void append_chunk(std::string& bytes, std::uint32_t type, std::string_view contents);

// The header and the chunks of a file. Throws InvalidInput where it would exceed 4 GiB.
std::string with_header(const std::string& chunks);

// "[1,2.5]": the least, or greatest, of each component, in a form that reads back as the same number. What is not
// finite does not count.
std::string least_text(const std::vector<float>& values, std::size_t components);
std::string greatest_text(const std::vector<float>& values, std::size_t components);

// Appends a number as little-endian bytes.
void append_float(std::string& bytes, float value);
void append_uint32(std::string& bytes, std::uint32_t value);

}  // namespace knead::io_detail::glb
