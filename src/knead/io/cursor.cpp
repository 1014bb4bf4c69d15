#include "knead/io/cursor.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>

namespace knead::io_detail {

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

}  // namespace knead::io_detail
