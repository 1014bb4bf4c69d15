// Pixels of pictures, read by stb. Internal; only where Knead is built with stb.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace knead::detail {

// A picture: rows from the top, and the channels of each pixel one after the other.
template <class Number>
struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<Number> numbers{};
};

// Reads a PNG or JPEG file of at most 8192 pixels along a side: red, green, blue and alpha. Returns nothing if it
// cannot be read.
std::optional<Pixels<std::uint8_t>> read_colors(const std::string& bytes);

// Reads such a file or a PNM file: grey and alpha. Returns nothing if it cannot be read; picture_trouble() then says
// why.
std::optional<Pixels<std::uint16_t>> read_greys(const std::string& bytes);
std::string picture_trouble();

}  // namespace knead::detail
