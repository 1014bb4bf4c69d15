// std::from_chars and std::to_chars for float and double, also where the standard library has them for integers only
// (libc++). Both give the same results, to the character and to the bit. Internal to the io room.
#pragma once

#include <charconv>

// libc++ has them from version 20 on, without saying so.
#if defined(__cpp_lib_to_chars) || (defined(_LIBCPP_VERSION) && _LIBCPP_VERSION >= 200000)
#define KNEAD_STD_FLOAT_CHARS
#endif

namespace knead::io_detail {

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

}  // namespace knead::io_detail
