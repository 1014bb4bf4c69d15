// Decimals of the coordinates in text files.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace knead::io_detail {

using WordVisitor = std::function<void(std::string_view word)>;

// Appends a number with so many digits after the point; without, the shortest form that reads back as the same number.
void append_decimals(std::string& text, double value, std::optional<int> decimals);

// Returns the digits after the point that a number has when it is written without exponent: 3 for "0.120" and "1.2e-2".
int decimals_in(std::string_view word);

// Returns the decimals for the components of unit vectors beside coordinates with so many: at least six.
std::optional<int> direction_decimals(std::optional<int> decimals);

}  // namespace knead::io_detail
