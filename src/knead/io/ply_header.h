// The header of a PLY file and the encoding of its numbers.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "knead/io/cursor.h"
#include "knead/io/ply_layout.h"

namespace knead {

// Reads the header: encoding, elements and properties, and where the body begins. Throws
// InvalidInput that names the line.
PlyLayout parse_ply_header(std::string_view bytes, const std::string& name);

// Bytes of a number in a binary file.
std::size_t size_of(NumberType type);

bool is_integer(NumberType type);

// "float", "uchar", ...
std::string_view ply_type_name(NumberType type);

inline bool is_swapped(PlyEncoding encoding) {
  return (encoding == PlyEncoding::big_endian) == (std::endian::native == std::endian::little);
}

// Calls visit(T{}) for the C++ type that a number type stands for.
template <class Visit>
decltype(auto) visit_type(NumberType type, Visit visit) {
  switch (type) {
    case NumberType::int8:
      return visit(std::int8_t{});
    case NumberType::uint8:
      return visit(std::uint8_t{});
    case NumberType::int16:
      return visit(std::int16_t{});
    case NumberType::uint16:
      return visit(std::uint16_t{});
    case NumberType::int32:
      return visit(std::int32_t{});
    case NumberType::uint32:
      return visit(std::uint32_t{});
    case NumberType::float32:
      return visit(float{});
    case NumberType::float64:
      break;
  }
  return visit(double{});
}

// The number of that type at `from`, which has enough bytes.
inline double read_binary(const char* from, NumberType type, bool swapped) {
  return visit_type(type, [&](auto value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(swapped ? swap_bytes(value) : value);
  });
}

// Appends a number that fits the type.
inline void append_binary(std::string& bytes, NumberType type, double number, bool swapped) {
  visit_type(type, [&](auto value) {
    value = static_cast<decltype(value)>(number);
    if (swapped) value = swap_bytes(value);
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  });
}

}  // namespace knead
