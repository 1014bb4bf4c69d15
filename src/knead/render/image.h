// A picture in memory, and its encoding as PNG or JPEG.
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

// Returns the bytes of a PNG file (8 bits, RGBA). Throws InvalidInput for an empty image.
std::string encode_png(const Image& image);

// Returns the bytes of a JPEG file: small, but lossy and without alpha. quality: from 1 to 100. Throws
// InvalidInput for an empty image or a quality outside its range.
std::string encode_jpeg(const Image& image, int quality = 88);

// Returns the picture in the bytes of a PNG or JPEG file. Throws InvalidInput for other bytes, and for more than 8192
// pixels along a side.
Image decode_image(const std::string& bytes);

// Returns the images in a row from left to right, centred vertically. The rest is transparent if any image has a
// transparent corner, else white. Throws InvalidInput if there are no images.
Image side_by_side(std::span<const Image> images);

}  // namespace knead::render
