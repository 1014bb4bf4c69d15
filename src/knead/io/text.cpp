#include "knead/io/text.h"

#include <cstdint>
#include <limits>
#include <system_error>

#include "knead/io/float_chars.h"

namespace knead::io_detail {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Whether a well-formed decimal number that no double can hold is too small rather than too large: whether its first
// digit other than 0 stands for a power of ten below one.
bool is_tiny(std::string_view token) {
  std::int64_t power = 0;  // of the first digit that is not 0; digits before the point count up
  bool found = false;
  bool after_point = false;
  std::size_t i = 0;
  for (; i < token.size() && token[i] != 'e' && token[i] != 'E'; ++i) {
    if (token[i] == '.') after_point = true;
    if (!is_digit(token[i])) continue;
    if (after_point && !found) --power;
    if (token[i] != '0') found = true;
    if (!after_point && found) ++power;
  }
  const bool negative = i + 1 < token.size() && token[i + 1] == '-';
  std::int64_t exponent = 0;
  for (; i < token.size(); ++i) {
    if (is_digit(token[i]) && exponent < 1'000'000'000'000) exponent = exponent * 10 + (token[i] - '0');
  }
  return power + (negative ? -exponent : exponent) < 0;
}

// What old Microsoft run-time libraries print for numbers that are not finite, e.g. "-1.#IND" and "1.#INF00".
bool is_microsoft_special(std::string_view token) {
  if (!token.empty() && (token[0] == '-' || token[0] == '+')) token.remove_prefix(1);
  if (token.substr(0, 3) != "1.#") return false;
  token.remove_prefix(3);
  while (!token.empty() && token.back() == '0') token.remove_suffix(1);
  return token == "IND" || token == "INF" || token == "QNAN" || token == "SNAN";
}

template <class T>
ParseResult parse(std::string_view token, T& value) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [stop, error] = float_from_chars(token.data(), end, value);
  if (error == std::errc::invalid_argument || stop != end) {
    if (!is_microsoft_special(token)) return ParseResult::malformed;
    value = std::numeric_limits<T>::quiet_NaN();
    return ParseResult::ok;
  }
  if (error == std::errc{}) return ParseResult::ok;
  if (!is_tiny(token)) return ParseResult::overflow;
  value = token[0] == '-' ? -T(0) : T(0);
  return ParseResult::ok;
}

template <class T>
void append(std::string& text, T value) {
  char buffer[32];  // the shortest form of a double has at most 24 characters
  const auto result = float_to_chars(buffer, buffer + sizeof buffer, value);
  text.append(buffer, result.ptr);
}

}  // namespace

ParseResult parse_real(std::string_view token, double& value) { return parse(token, value); }
ParseResult parse_real(std::string_view token, float& value) { return parse(token, value); }

void append_real(std::string& text, double value) { append(text, value); }
void append_real(std::string& text, float value) { append(text, value); }

std::string shown(double value) {
  char buffer[32];  // 15 digits, sign, point and exponent take at most 22
  const auto result = float_to_chars(buffer, buffer + sizeof buffer, value, kGeneral, 15);
  return {buffer, result.ptr};
}

std::size_t line_of(std::string_view text, std::size_t position) {
  std::size_t line = 1;
  for (std::size_t i = 0; i < position && i < text.size(); ++i) {
    const bool lone_return = text[i] == '\r' && (i + 1 >= text.size() || text[i + 1] != '\n');
    if (text[i] == '\n' || lone_return) ++line;
  }
  return line;
}

std::size_t token_end(std::string_view text, std::size_t begin) {
  while (begin < text.size() && !is_blank(text[begin]) && !is_line_end(text[begin])) ++begin;
  return begin;
}

std::string_view without_end_zeros(std::string_view text) { return text.substr(0, text.find_last_not_of('\0') + 1); }

std::string in_quotes(std::string_view text) {
  constexpr std::size_t most = 40;
  std::string result = "'";
  for (const char c : text.substr(0, most)) result += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return result + (text.size() > most ? "...'" : "'");
}

}  // namespace knead::io_detail
