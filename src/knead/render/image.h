// A picture in memory, and its encoding as PNG, JPEG or GIF.
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

// Return the parts of an animated GIF: a header, the pictures, the end. It is played in a loop. Source: CompuServe,
// "Graphics Interchange Format, Version 89a" (1990), with the looping extension of Netscape.
std::string gif_header(int width, int height);

// Returns a picture that is shown for so many hundredths of a second. Only what differs from the picture before it is
// stored; null: there is none. Of more than 255 colours it keeps 255 by median cut. Transparent pixels become white.
// Throws InvalidInput for a picture of another size than `before`, or of more than 65535 pixels along a side.
std::string gif_picture(const Image& image, const Image* before, int hundredths);

// Returns the end of the file.
std::string gif_end();

}  // namespace knead::render
