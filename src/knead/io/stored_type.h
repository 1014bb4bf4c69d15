// The number types of files: those of meshes, and 64-bit integers, which meshes hold as reals.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "knead/io/number_types.h"

namespace knead::io_detail {

enum class StoredType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

// Returns the type that an attribute of a mesh has for such numbers.
constexpr NumberType number_type(StoredType type) {
  switch (type) {
    case StoredType::int8:
      return NumberType::int8;
    case StoredType::uint8:
      return NumberType::uint8;
    case StoredType::int16:
      return NumberType::int16;
    case StoredType::uint16:
      return NumberType::uint16;
    case StoredType::int32:
      return NumberType::int32;
    case StoredType::uint32:
      return NumberType::uint32;
    case StoredType::float32:
      return NumberType::float32;
    case StoredType::int64:
    case StoredType::uint64:
    case StoredType::float64:
      break;
  }
  return NumberType::float64;
}

// Calls visit(T{}) for the C++ type.
template <class Visit>
decltype(auto) visit_type(StoredType type, Visit visit) {
  if (type == StoredType::int64) return visit(std::int64_t{});
  if (type == StoredType::uint64) return visit(std::uint64_t{});
  return io_detail::visit_type(number_type(type), visit);
}

inline bool is_integer(StoredType type) { return type != StoredType::float32 && type != StoredType::float64; }

// Returns the nearest value that the type can hold, of 64-bit integers one that a double holds too.
inline double nearest_of(StoredType type, double value) {
  constexpr double below_2_63 = 0x1p63 - 0x1p10;
  constexpr double below_2_64 = 0x1p64 - 0x1p11;
  if (type == StoredType::int64) return std::clamp(std::round(value), -0x1p63, below_2_63);
  if (type == StoredType::uint64) return std::clamp(std::round(value), 0.0, below_2_64);
  return io_detail::nearest_of(number_type(type), value);
}

}  // namespace knead::io_detail
