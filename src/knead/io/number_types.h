// Numbers of the types that files declare, and their bytes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "knead/io/cursor.h"
#include "knead/mesh/mesh.h"

namespace knead::io_detail {

// Calls visit(T{}) for the C++ type that a number type stands for. What follows holds for every Type with a visit_type.
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

template <class Type>
std::size_t size_of(Type type) {
  return visit_type(type, [](auto number) { return sizeof number; });
}

inline bool is_integer(NumberType type) { return type != NumberType::float32 && type != NumberType::float64; }

// The number of that type at `from`, which has enough bytes.
template <class Type>
double read_binary(const char* from, Type type, bool swapped) {
  return visit_type(type, [&](auto value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(swapped ? swap_bytes(value) : value);
  });
}

// Appends a number that fits the type.
template <class Type>
void append_binary(std::string& bytes, Type type, double number, bool swapped) {
  visit_type(type, [&](auto value) {
    value = static_cast<decltype(value)>(number);
    if (swapped) value = swap_bytes(value);
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  });
}

// The nearest value that the type can hold; integers are rounded.
inline double nearest_of(NumberType type, double value) {
  return visit_type(type, [&](auto number) {
    using Limits = std::numeric_limits<decltype(number)>;
    const double whole = Limits::is_integer ? std::round(value) : value;
    return std::clamp(whole, double{Limits::lowest()}, double{Limits::max()});
  });
}

}  // namespace knead::io_detail
