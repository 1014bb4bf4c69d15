// Numbers and words in text, what a message says of them, and the cursors that readers go through files with.
#include "io/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>

#include "io/numbers.h"

namespace knead::detail {
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

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return result;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

bool is_digits(std::string_view word) { return !word.empty() && std::all_of(word.begin(), word.end(), is_digit); }

std::string_view line_end_of(std::string_view text) {
  const std::size_t end = text.find_first_of("\r\n");
  if (end == std::string_view::npos) return "\n";
  return text.substr(end, text.substr(end, 2) == "\r\n" ? 2 : 1);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t most = 40;
  std::string result = "'";
  for (const char c : text.substr(0, most)) result += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return result + (text.size() > most ? "...'" : "'");
}

std::string too_many(const std::string& what, std::size_t left) {
  return what + " are declared, but only " + std::to_string(left) + " bytes follow; the file is cut short or damaged";
}

void fail_at_byte(const std::string& name, std::size_t position, const std::string& what) {
  throw InvalidInput(Place{name}, "byte " + std::to_string(position) + ": " + what);
}

void fail_at_line(const std::string& name, std::string_view bytes, std::size_t position, const std::string& what) {
  throw InvalidInput(Place{name, line_of(bytes, position)}, what);
}

std::size_t text_begin(std::string_view bytes, const std::string& name) {
  const std::string_view mark = bytes.substr(0, 2);
  if (mark == "\xfe\xff" || mark == "\xff\xfe")
    throw InvalidInput(Place{name, 1}, "is UTF-16 text; convert it to UTF-8");
  if (const std::optional<std::string> other = stand_in(bytes)) throw InvalidInput(Place{name}, *other);
  return bytes.substr(0, 3) == "\xef\xbb\xbf" ? 3 : 0;
}

void ByteCursor::fail_missing(std::size_t count, const char* expected) const {
  fail("expected " + std::string(expected) + " (" + std::to_string(count) + " bytes), but only " +
       std::to_string(left()) + " are left; the file is cut short or damaged");
}

bool TextCursor::next_line() {
  while (position_ < bytes_.size() && !is_line_end(bytes_[position_])) ++position_;
  if (position_ < bytes_.size() && bytes_[position_] == '\r') {
    ++position_;
    if (position_ < bytes_.size() && bytes_[position_] == '\n') ++position_;
  } else if (position_ < bytes_.size()) {
    ++position_;
  }
  word_begin_ = position_;
  return position_ < bytes_.size();
}

void TextCursor::fail_about(std::string_view word, const std::string& what) const {
  fail_at_line(name_, bytes_, word.empty() ? word_begin_ : static_cast<std::size_t>(word.data() - bytes_.data()), what);
}

double TextCursor::real(std::string_view word, const char* expected) const {
  if (word.empty()) fail_about(word, "expected " + std::string(expected) + ", found the end of the line or file");
  double value = 0;
  const ParseResult result = parse_real(word, value);
  if (result == ParseResult::malformed)
    fail_about(word, "expected " + std::string(expected) + ", found " + in_quotes(word));
  if (result == ParseResult::overflow) fail_about(word, in_quotes(word) + " does not fit in a double; repair the file");
  return value;
}

double TextCursor::coordinate(std::string_view word) const {
  const double value = real(word, "a coordinate");
  if (!std::isfinite(value))
    fail_about(word, "a coordinate is " + in_quotes(word) + ", which is not finite; repair the file");
  return value;
}

std::size_t TextCursor::whole(std::string_view word, std::size_t most, const char* expected) const {
  if (word.empty()) fail_about(word, "expected " + std::string(expected) + ", found the end of the line or file");
  std::uint64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error == std::errc::invalid_argument || stop != end) {
    fail_about(word, "expected " + std::string(expected) + ", found " + in_quotes(word));
  }
  if (error != std::errc{} || value > most) {
    fail_about(word, std::string(expected) + " is " + in_quotes(word) + ", more than " + std::to_string(most));
  }
  return static_cast<std::size_t>(value);
}

}  // namespace knead::detail
