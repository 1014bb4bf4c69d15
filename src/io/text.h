// Numbers and words in text, independent of the locale; and cursors that go through a file without passing its end.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "knead/error.h"

namespace knead::detail {

enum class ParseResult { ok, malformed, overflow };

// Returns the number that a whole token spells, e.g. "-1.5e3", "+2", "nan"; 0 for one too small for a double. The texts
// of old Microsoft libraries for numbers that are not finite ("-1.#IND") give NaN.
ParseResult parse_real(std::string_view token, double& value);
ParseResult parse_real(std::string_view token, float& value);

// Appends the shortest decimal form that reads back as the same number.
void append_real(std::string& text, double value);
void append_real(std::string& text, float value);

// Returns a number for a message, e.g. "8", "2.5", "1e+66".
std::string shown(double value);

// Returns the line, counted from 1, of a byte of a text whose lines end with LF, CR LF or CR.
std::size_t line_of(std::string_view text, std::size_t position);

// Returns whether a finite number is within the range of float.
inline bool fits_float(double value) { return std::abs(value) <= double{std::numeric_limits<float>::max()}; }

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// Returns the position after the token that begins at `begin`: that of the next blank, line end or end of the text.
std::size_t token_end(std::string_view text, std::size_t begin);

// Returns the text without zero bytes at its end, which some programs write.
std::string_view without_end_zeros(std::string_view text);

// Returns the text with the letters a to z, or A to Z, in the other case.
std::string upper(std::string_view text);
std::string lower(std::string_view text);

// Returns the text without the blanks around it.
std::string_view trimmed(std::string_view text);

// Returns whether there is a character, and all are digits.
bool is_digits(std::string_view word);

// Returns the first line end of a text; "\n" without one.
std::string_view line_end_of(std::string_view text);

// Returns a piece of the file for a message: in quotes, cut to a few characters, without control characters.
std::string in_quotes(std::string_view text);

// Returns the message that a file is too short for its declared contents, e.g. "8 points", with `left` bytes left.
std::string too_many(const std::string& what, std::size_t left);

template <class T>
T swap_bytes(T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

// Throws InvalidInput "NAME: byte N: what".
[[noreturn]] void fail_at_byte(const std::string& name, std::size_t position, const std::string& what);

// Throws InvalidInput "NAME:LINE: what" for the line of the byte at `position`.
[[noreturn]] void fail_at_line(const std::string& name, std::string_view bytes, std::size_t position,
                               const std::string& what);

// Returns a sentence, with advice, on bytes in the place of a file: a pointer of Git LFS, or a web page. Returns
// nothing for others.
std::optional<std::string> stand_in(std::string_view bytes);

// Returns the position of the first byte of a text after a UTF-8 byte-order mark. Throws InvalidInput for UTF-16, and
// for a placeholder of a file.
std::size_t text_begin(std::string_view bytes, const std::string& name);

// Goes through a binary file front to back. Every failure is an InvalidInput that names the byte.
class ByteCursor {
 public:
  // The bytes and the name must outlive the cursor. Numbers are in the byte order named.
  ByteCursor(std::string_view bytes, const std::string& name, std::endian order = std::endian::little)
      : bytes_(bytes), name_(name), swapped_(order != std::endian::native) {}

  std::size_t position() const { return position_; }
  std::size_t left() const { return bytes_.size() - position_; }

  // Returns the next number; `expected` names it for messages, e.g. "the count of triangles".
  template <class T>
  T take(const char* expected) {
    const std::string_view from = take_bytes(sizeof(T), expected);
    T value;
    std::memcpy(&value, from.data(), sizeof(T));
    return swapped_ ? swap_bytes(value) : value;
  }

  std::string_view take_bytes(std::size_t count, const char* expected) {
    if (left() < count) fail_missing(count, expected);
    position_ += count;
    return bytes_.substr(position_ - count, count);
  }

  [[noreturn]] void fail(const std::string& what) const { fail_at_byte(name_, position_, what); }

 private:
  [[noreturn]] void fail_missing(std::size_t count, const char* expected) const;

  std::string_view bytes_;
  const std::string& name_;
  bool swapped_;
  std::size_t position_ = 0;
};

// Goes through a text: words between blanks, lines that end with LF, CR LF or CR, comments from # to the end of the
// line. Every failure is an InvalidInput that names the line.
class TextCursor {
 public:
  // The bytes and the name must outlive the cursor.
  TextCursor(std::string_view bytes, const std::string& name, std::size_t position = 0)
      : bytes_(bytes), name_(name), position_(position) {}

  // Returns the position after the last word.
  std::size_t position() const { return position_; }
  std::size_t word_begin() const { return word_begin_; }

  // Returns the next word of this line; empty at the end of the line or file.
  std::string_view next_on_line() {
    while (position_ < bytes_.size() && is_blank(bytes_[position_])) ++position_;
    word_begin_ = position_;
    if (position_ < bytes_.size() && bytes_[position_] == '#') return {};
    position_ = token_end(bytes_, position_);
    return bytes_.substr(word_begin_, position_ - word_begin_);
  }

  // Moves to the beginning of the next line; returns false at the end of the file.
  bool next_line();

  // Returns the next word on this line or a later one; empty at the end of the file.
  std::string_view next() {
    std::string_view word = next_on_line();
    while (word.empty() && next_line()) word = next_on_line();
    return word;
  }

  // Takes a word whose bounds the caller has found, for formats whose words have other ends.
  std::string_view take(std::size_t begin, std::size_t end) {
    word_begin_ = begin;
    position_ = end;
    return bytes_.substr(begin, end - begin);
  }

  // Returns the number that a word of the file spells; failures name its line. An empty word is a missing number after
  // the last word; `expected` names it, e.g. "a coordinate".
  double real(std::string_view word, const char* expected) const;

  // The same for a coordinate: a number that is finite.
  double coordinate(std::string_view word) const;

  // The same for a whole number from 0 to `most`.
  std::size_t whole(std::string_view word, std::size_t most, const char* expected) const;

  // Throws InvalidInput with the line of the last word.
  [[noreturn]] void fail(const std::string& what) const { fail_at_line(name_, bytes_, word_begin_, what); }

 private:
  [[noreturn]] void fail_about(std::string_view word, const std::string& what) const;

  std::string_view bytes_;
  const std::string& name_;
  std::size_t position_ = 0;
  std::size_t word_begin_ = 0;
};

}  // namespace knead::detail
