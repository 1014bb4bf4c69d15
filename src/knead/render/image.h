// A picture in memory, and how it leaves the program.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace knead::render {

// Rows from the top down, pixels from the left, four bytes per pixel: red, green, blue (sRGB, not multiplied by alpha)
// and alpha. pixels.size() == 4 * width * height.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  friend bool operator==(const Image&, const Image&) = default;
};

// The bytes of a PNG file (8 bits, RGBA). Throws InvalidInput for an empty image.
std::string encode_png(const Image& image);

// The bytes of a JPEG file: small, but not every byte of the image; alpha is lost. quality: from 1 to 100. Throws
// InvalidInput for an empty image or a quality outside its range.
std::string encode_jpeg(const Image& image, int quality = 88);

// The images in a row from left to right, aligned at their middles; what they do not cover is transparent where any
// image has a transparent corner, else white. Throws InvalidInput for no images.
Image side_by_side(std::span<const Image> images);

}  // namespace knead::render
