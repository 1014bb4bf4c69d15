// Numbers as files hold them: their types and bytes, their decimals in text, base64, and the copy of a text in which
// some numbers are replaced (Splice).
#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/system.h"

namespace knead::detail {

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

// Returns the number of that type at `from`, which must have enough bytes.
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

// Returns the nearest value that the type can hold; integers are rounded.
inline double nearest_of(NumberType type, double value) {
  return visit_type(type, [&](auto number) {
    using Limits = std::numeric_limits<decltype(number)>;
    const double whole = Limits::is_integer ? std::round(value) : value;
    return std::clamp(whole, double{Limits::lowest()}, double{Limits::max()});
  });
}

// The number types of files: those of meshes, and 64-bit integers, which meshes hold as reals.
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
  return visit_type(number_type(type), visit);
}

inline bool is_integer(StoredType type) { return type != StoredType::float32 && type != StoredType::float64; }

// Returns the nearest value that the type can hold, of 64-bit integers one that a double holds too.
inline double nearest_of(StoredType type, double value) {
  constexpr double below_2_63 = 0x1p63 - 0x1p10;
  constexpr double below_2_64 = 0x1p64 - 0x1p11;
  if (type == StoredType::int64) return std::clamp(std::round(value), -0x1p63, below_2_63);
  if (type == StoredType::uint64) return std::clamp(std::round(value), 0.0, below_2_64);
  return nearest_of(number_type(type), value);
}

inline bool fits_floats(const Vec3d& p) { return fits_float(p.x) && fits_float(p.y) && fits_float(p.z); }

// Returns whether all coordinates are floats.
inline bool are_floats(std::span<const Vec3d> positions) {
  return std::all_of(positions.begin(), positions.end(),
                     [](const Vec3d& p) { return fits_floats(p) && p == Vec3d(Vec3f(p)); });
}

// Throws InvalidInput for the first position that is beyond the range of float.
inline void check_fits_floats(std::span<const Vec3d> positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (fits_floats(positions[i])) continue;
    throw InvalidInput(
        "vertex " + std::to_string(i) +
        " has coordinates beyond the range of float, the type of this binary format; write another format");
  }
}

// Replaces four bytes. The value is within the range of float.
inline void put_float(std::string& bytes, std::size_t at, double value, std::endian order) {
  const float rounded = static_cast<float>(value);
  const float stored = order == std::endian::native ? rounded : swap_bytes(rounded);
  std::memcpy(bytes.data() + at, &stored, sizeof stored);
}

// Replaces those of three floats that differ from their old values.
inline void replace_floats(std::string& bytes, std::size_t at, const Vec3d& from, const Vec3d& to, std::endian order) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (from[axis] != to[axis]) put_float(bytes, at + axis * sizeof(float), to[axis], order);
  }
}

using WordVisitor = std::function<void(std::string_view word)>;

// Appends a number with `decimals` digits after the point, or in the shortest form that reads back as the same number.
void append_decimals(std::string& text, double value, std::optional<int> decimals);

// Appends "x y z".
void append_point(std::string& text, const Vec3d& p, std::optional<int> decimals);

// Returns the digits after the point that a number has when it is written without exponent: 3 for "0.120" and "1.2e-2".
int decimals_in(std::string_view word);

// Returns the decimals of unit vectors' components, given those of coordinates: the same, but at least six.
std::optional<int> direction_decimals(std::optional<int> decimals);

}  // namespace knead::detail

// std::from_chars and std::to_chars for float and double, also where the standard library has them for integers only
// (libc++). Both give the same results, to the character and bit for bit.
// libc++ has them from version 20 on, without saying so.
#if defined(__cpp_lib_to_chars) || (defined(_LIBCPP_VERSION) && _LIBCPP_VERSION >= 200000)
#define KNEAD_STD_FLOAT_CHARS
#endif

namespace knead::detail {

#if defined(KNEAD_STD_FLOAT_CHARS)

inline constexpr std::chars_format kGeneral = std::chars_format::general;
inline constexpr std::chars_format kFixed = std::chars_format::fixed;

template <class T>
std::from_chars_result float_from_chars(const char* first, const char* last, T& value) {
  return std::from_chars(first, last, value);
}
template <class T>
std::to_chars_result float_to_chars(char* first, char* last, T value) {
  return std::to_chars(first, last, value);
}
template <class T>
std::to_chars_result float_to_chars(char* first, char* last, T value, std::chars_format format, int digits) {
  return std::to_chars(first, last, value, format, digits);
}

#else

enum class FloatFormat { general, fixed };
inline constexpr FloatFormat kGeneral = FloatFormat::general;
inline constexpr FloatFormat kFixed = FloatFormat::fixed;

std::from_chars_result float_from_chars(const char* first, const char* last, double& value);
std::from_chars_result float_from_chars(const char* first, const char* last, float& value);
std::to_chars_result float_to_chars(char* first, char* last, double value);
std::to_chars_result float_to_chars(char* first, char* last, float value);
std::to_chars_result float_to_chars(char* first, char* last, double value, FloatFormat format, int digits);

#endif

// Returns the bytes of base64 text (RFC 4648); nothing if it is malformed.
std::optional<std::string> from_base64(std::string_view text);
std::string to_base64(std::string_view bytes);

// A copy of a text with some of its words replaced.
class Splice {
 public:
  // The source must outlive this. Numbers have `decimals` digits after the point, or the shortest form that reads back
  // as the same number.
  explicit Splice(std::string_view source, std::optional<int> decimals = std::nullopt)
      : source_(source), decimals_(decimals) {
    reserve_large(result_, source.size() + source.size() / 4 + 64);
  }

  // Replaces the components of a point that differ; next_word() gives the word of each, front to back.
  template <class NextWord>
  void replace_changed(const Vec3d& from, const Vec3d& to, NextWord next_word) {
    replace_components(from, to, decimals_, next_word);
  }

  // Does the same for a unit vector.
  template <class NextWord>
  void replace_direction(const Vec3d& from, const Vec3d& to, NextWord next_word) {
    replace_components(from, to, direction_decimals(decimals_), next_word);
  }

  std::string finish() {
    result_.append(source_, copied_);
    return std::move(result_);
  }

  // Replaces one component of a point or of a unit vector.
  void replace_coordinate(std::string_view word, double from, double to) { replace(word, from, to, decimals_); }
  void replace_component(std::string_view word, double from, double to) {
    replace(word, from, to, direction_decimals(decimals_));
  }

  // Replaces a word, or bytes, by other ones.
  void replace_text(std::string_view word, std::string_view text) {
    const std::size_t begin = static_cast<std::size_t>(word.data() - source_.data());
    result_.append(source_, copied_, begin - copied_);
    result_ += text;
    copied_ = begin + word.size();
  }

 private:
  template <class NextWord>
  void replace_components(const Vec3d& from, const Vec3d& to, std::optional<int> decimals, NextWord next_word) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view word = next_word();
      replace(word, from[axis], to[axis], decimals);
    }
  }

  // If the rounded number equals the old one, its spelling stays.
  void replace(std::string_view word, double from, double to, std::optional<int> decimals) {
    if (from == to) return;
    number_.clear();
    append_decimals(number_, to, decimals);
    double rounded = to;
    if (decimals) parse_real(number_, rounded);
    if (rounded == from) return;
    replace_text(word, number_);
  }

  std::string_view source_;
  std::optional<int> decimals_;
  std::string number_;
  std::string result_;
  std::size_t copied_ = 0;
};

}  // namespace knead::detail
