// Numbers in text, independent of the locale.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

#include "knead/math/error.h"

namespace knead::io_detail {

enum class ParseResult { ok, malformed, overflow };

// The number that a whole token spells, e.g. "-1.5e3", "+2", "nan"; one too small to be held becomes 0. What
// Microsoft's libraries once printed for numbers that are not finite ("-1.#IND") is NaN.
ParseResult parse_real(std::string_view token, double& value);
ParseResult parse_real(std::string_view token, float& value);

// Appends the shortest decimal form that reads back as the same number.
void append_real(std::string& text, double value);
void append_real(std::string& text, float value);

// A number for a message, e.g. "8", "2.5", "1e+66".
std::string shown(double value);

// The line, counted from 1, of a byte of a text whose lines end with LF, CR LF or CR.
std::size_t line_of(std::string_view text, std::size_t position);

// Whether a finite number is within the range of float.
inline bool fits_float(double value) { return std::abs(value) <= double{std::numeric_limits<float>::max()}; }

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

// The byte after the token that begins at `begin`: the next blank, line end or end of the text.
std::size_t token_end(std::string_view text, std::size_t begin);

// The text without the zero bytes that end it, which some programs write.
std::string_view without_end_zeros(std::string_view text);

// A piece of the file for a message: in quotes, cut to a few characters, without control characters.
std::string in_quotes(std::string_view text);

}  // namespace knead::io_detail
