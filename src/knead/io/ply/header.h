// The header of a PLY file.
#pragma once

#include <bit>
#include <string>
#include <string_view>

#include "knead/io/ply/layout.h"

namespace knead::io_detail::ply {

// Reads the header: encoding, elements and properties, and where the body begins. Throws
// InvalidInput that names the line.
Layout parse_header(std::string_view bytes, const std::string& name);

// "float", "uchar", ...
std::string_view type_name(StoredType type);

// The type that a new file has for numbers of that type.
StoredType stored_type(NumberType type);

inline bool is_swapped(Encoding encoding) {
  return (encoding == Encoding::big_endian) == (std::endian::native == std::endian::little);
}

}  // namespace knead::io_detail::ply
