#include "knead/io/decimals.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "knead/io/float_chars.h"
#include "knead/io/text.h"

namespace knead::io_detail {

void append_decimals(std::string& text, double value, std::optional<int> decimals) {
  if (!decimals) return append_real(text, value);
  char buffer[std::numeric_limits<double>::max_exponent10 + 32];  // all digits before the point, and at most 17 after
  const auto result = float_to_chars(buffer, buffer + sizeof buffer, value, kFixed, *decimals);
  text.append(buffer, result.ptr);
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

}  // namespace knead::io_detail
