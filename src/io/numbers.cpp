// Numbers as text, also where the standard library converts integers only, and base64.
#include "io/numbers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <limits>

#include "io/text.h"

namespace knead::detail {

void append_decimals(std::string& text, double value, std::optional<int> decimals) {
  if (!decimals) return append_real(text, value);
  char buffer[std::numeric_limits<double>::max_exponent10 + 32];  // all digits before the point, and at most 17 after
  const auto result = float_to_chars(buffer, buffer + sizeof buffer, value, kFixed, *decimals);
  text.append(buffer, result.ptr);
}

void append_point(std::string& text, const Vec3d& p, std::optional<int> decimals) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis > 0) text += ' ';
    append_decimals(text, p[axis], decimals);
  }
}

int decimals_in(std::string_view word) {
  const std::size_t end = std::min(word.find_first_of("eE"), word.size());
  const std::size_t point = word.find('.');
  const std::ptrdiff_t after = point < end ? static_cast<std::ptrdiff_t>(end - point - 1) : 0;
  std::ptrdiff_t exponent = 0;
  std::size_t digits = end + 1;
  if (digits < word.size() && word[digits] == '+') ++digits;
  if (digits < word.size()) std::from_chars(word.data() + digits, word.data() + word.size(), exponent);
  constexpr std::ptrdiff_t most = 1000;  // more than any double has
  return static_cast<int>(std::clamp<std::ptrdiff_t>(after - std::clamp(exponent, -most, most), 0, most));
}

std::optional<int> direction_decimals(std::optional<int> decimals) {
  constexpr int least = 6;
  return decimals ? std::optional(std::max(*decimals, least)) : std::nullopt;
}

}  // namespace knead::detail

#if !defined(KNEAD_STD_FLOAT_CHARS)

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace knead::detail {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

const char* skip_digits(const char* at, const char* last) {
  while (at != last && is_digit(*at)) ++at;
  return at;
}

bool begins_with(const char* at, const char* last, std::string_view lower) {
  if (static_cast<std::size_t>(last - at) < lower.size()) return false;
  return std::equal(lower.begin(), lower.end(), at, [](char a, char b) { return a == (b | 0x20); });
}

// The end of the number that begins at first, as std::from_chars reads it; first if there is none.
const char* number_end(const char* first, const char* last) {
  const char* at = first;
  if (at != last && *at == '-') ++at;
  for (const std::string_view word : {"infinity", "inf", "nan"}) {
    if (!begins_with(at, last, word)) continue;
    at += word.size();
    if (word != "nan" || at == last || *at != '(') return at;
    const char* const closed = std::find(at, last, ')');  // as in nan(ind)
    return closed == last ? at : closed + 1;
  }
  const char* const whole = skip_digits(at, last);
  const bool has_point = whole != last && *whole == '.';
  const char* const end = has_point ? skip_digits(whole + 1, last) : whole;
  if (end - at == (has_point ? 1 : 0)) return first;
  if (end == last || (*end | 0x20) != 'e') return end;
  const char* digits = end + 1;
  if (digits != last && (*digits == '-' || *digits == '+')) ++digits;
  const char* const exponent_end = skip_digits(digits, last);
  return exponent_end == digits ? end : exponent_end;
}

double read(const char* text, double) { return std::strtod(text, nullptr); }
float read(const char* text, float) { return std::strtof(text, nullptr); }

bool is_spelled_zero(std::string_view text) {
  return text.substr(0, text.find_first_of("eE")).find_first_of("123456789") == std::string_view::npos;
}

template <class T>
std::from_chars_result from_chars(const char* first, const char* last, T& value) {
  const char* const end = number_end(first, last);
  if (end == first) return {first, std::errc::invalid_argument};
  const std::string_view text(first, static_cast<std::size_t>(end - first));
  char copy[64];  // ended by a zero, as strtod needs it
  T number = 0;
  if (text.size() < sizeof copy) {
    std::memcpy(copy, text.data(), text.size());
    copy[text.size()] = 0;
    number = read(copy, T());
  } else {
    number = read(std::string(text).c_str(), T());
  }
  const bool is_spelled_finite = is_digit(text.back()) || text.back() == '.';
  if (is_spelled_finite && (std::isinf(number) || (number == 0 && !is_spelled_zero(text)))) {
    return {end, std::errc::result_out_of_range};
  }
  value = number;
  return {end, std::errc{}};
}

std::to_chars_result put(char* first, char* last, std::string_view text) {
  if (static_cast<std::size_t>(last - first) < text.size()) return {last, std::errc::value_too_large};
  return {std::copy(text.begin(), text.end(), first), std::errc{}};
}

// The shortest digits that read back as a number, and the power of ten of the last of them.
struct Shortest {
  std::string digits;
  int exponent = 0;
};

template <class T>
Shortest shortest(T value) {
  const std::string text = fmt::format("{}", value);
  Shortest result;
  bool after_point = false;
  std::size_t i = 0;
  for (; i < text.size() && text[i] != 'e'; ++i) {
    if (text[i] == '.') after_point = true;
    if (!is_digit(text[i])) continue;
    result.digits += text[i];
    if (after_point) --result.exponent;
  }
  if (i < text.size()) result.exponent += std::atoi(text.c_str() + i + 1);
  result.digits.erase(0, std::min(result.digits.find_first_not_of('0'), result.digits.size() - 1));
  while (result.digits.size() > 1 && result.digits.back() == '0') {
    result.digits.pop_back();
    ++result.exponent;
  }
  return result;
}

std::string scientific(const Shortest& number) {
  std::string text = number.digits.substr(0, 1);
  if (number.digits.size() > 1) text += "." + number.digits.substr(1);
  return text + fmt::format("e{:+03d}", number.exponent + static_cast<int>(number.digits.size()) - 1);
}

std::string fixed(const Shortest& number, double value) {
  if (number.exponent >= 0) return fmt::format("{:.0f}", value);  // all digits of a whole number
  const std::size_t after = static_cast<std::size_t>(-number.exponent);
  std::string digits = number.digits;
  if (digits.size() <= after) digits.insert(0, after + 1 - digits.size(), '0');
  return digits.insert(digits.size() - after, ".");
}

// The shorter of the two forms, as the standard asks; the fixed one if both have the same length.
template <class T>
std::to_chars_result to_chars(char* first, char* last, T value) {
  const std::string sign = std::signbit(value) ? "-" : "";
  const T size = std::abs(value);
  if (std::isnan(value)) return put(first, last, sign + "nan");
  if (std::isinf(value)) return put(first, last, sign + "inf");
  if (size == 0) return put(first, last, sign + "0");
  const Shortest number = shortest(size);
  const int count = static_cast<int>(number.digits.size());
  const int one = count == 1 ? 1 : 0;  // a single digit has no point
  const bool is_fixed = number.exponent >= -(count + 3) + one && number.exponent <= 5 - one;
  return put(first, last, sign + (is_fixed ? fixed(number, static_cast<double>(size)) : scientific(number)));
}

}  // namespace

std::from_chars_result float_from_chars(const char* first, const char* last, double& value) {
  return from_chars(first, last, value);
}
std::from_chars_result float_from_chars(const char* first, const char* last, float& value) {
  return from_chars(first, last, value);
}
std::to_chars_result float_to_chars(char* first, char* last, double value) { return to_chars(first, last, value); }
std::to_chars_result float_to_chars(char* first, char* last, float value) { return to_chars(first, last, value); }

std::to_chars_result float_to_chars(char* first, char* last, double value, FloatFormat format, int digits) {
  if (!std::isfinite(value)) return to_chars(first, last, value);
  char text[400];  // a double has at most 309 digits before the point, and callers ask for at most 17 after it
  const int size = std::snprintf(text, sizeof text, format == FloatFormat::fixed ? "%.*f" : "%.*g", digits, value);
  return put(first, last, {text, static_cast<std::size_t>(size)});
}

}  // namespace knead::detail

#endif

namespace knead::detail {

constexpr std::string_view kBase64Digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::optional<std::string> from_base64(std::string_view text) {
  for (int i = 0; i < 2 && !text.empty() && text.back() == '='; ++i) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  static const std::array<std::uint8_t, 256> value = [] {
    std::array<std::uint8_t, 256> table{};
    table.fill(64);
    for (std::size_t i = 0; i < kBase64Digits.size(); ++i) {
      table[static_cast<unsigned char>(kBase64Digits[i])] = static_cast<std::uint8_t>(i);
    }
    return table;
  }();
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::uint8_t digit = value[static_cast<unsigned char>(c)];
    if (digit > 63) return std::nullopt;
    bits = bits << 6 | digit;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xffu);
  }
  return bytes;
}

std::string to_base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kBase64Digits[bits >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

}  // namespace knead::detail
