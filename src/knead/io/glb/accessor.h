// The accessors of a GLB file: where their numbers are. Internal to the GLB reader and writer.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/glb/json.h"
#include "knead/io/glb/layout.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail::glb {

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
  std::optional<DenseData> dense;    // nothing: zeros
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

}  // namespace knead::io_detail::glb
