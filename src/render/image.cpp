// PNG, JPEG and rows of images, by stb's code.
#include "knead/editor/render.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "io/picture.h"
#include "knead/error.h"

#if defined(KNEAD_HAS_ZLIB)
#include <zlib.h>

#include <cstdlib>

// Called by stb, which frees the bytes. The lowest level is faster than stb's own code, and its files are smaller.
// Returns null if there is no memory.
static unsigned char* deflate_with_zlib(unsigned char* data, int size, int* written, int) {
  uLongf room = compressBound(static_cast<uLong>(size));
  auto* const bytes = static_cast<unsigned char*>(std::malloc(room));  // NOLINT(cppcoreguidelines-no-malloc)
  if (bytes == nullptr || compress2(bytes, &room, data, static_cast<uLong>(size), Z_BEST_SPEED) != Z_OK) {
    std::free(bytes);  // NOLINT(cppcoreguidelines-no-malloc)
    return nullptr;
  }
  *written = static_cast<int>(room);
  return bytes;
}
#define STBIW_ZLIB_COMPRESS deflate_with_zlib
#endif

// The only translation unit with stb's code for writing, which does not pass our warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>
#pragma GCC diagnostic pop

namespace knead::render {
namespace {

// One filter of PNG instead of the best of five for each line: faster, and smaller for pictures of shapes.
[[maybe_unused]] const int kPngFilter = stbi_write_force_png_filter = 1;

bool has_transparent_corner(const Image& image) {
  const std::size_t row = 4 * static_cast<std::size_t>(image.width);
  const std::size_t last_row = row * static_cast<std::size_t>(image.height - 1);
  return image.pixels[3] < 255 || image.pixels[row - 1] < 255 || image.pixels[last_row + 3] < 255 ||
         image.pixels[last_row + row - 1] < 255;
}

void check(const Image& image) {
  const auto expected =
      4 * static_cast<std::size_t>(std::max(image.width, 0)) * static_cast<std::size_t>(std::max(image.height, 0));
  if (expected == 0 || image.pixels.size() != expected) {
    throw InvalidInput("image: empty or of the wrong size; give width * height * 4 bytes");
  }
}

void append_bytes(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

bool is_opaque(const Image& image) {
  for (std::size_t i = 3; i < image.pixels.size(); i += 4) {
    if (image.pixels[i] < 255) return false;
  }
  return true;
}

std::vector<std::uint8_t> without_alpha(const Image& image) {
  std::vector<std::uint8_t> pixels(image.pixels.size() / 4 * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = image.pixels[i / 3 * 4 + i % 3];
  return pixels;
}

}  // namespace

std::string encode_png(const Image& image) {
  check(image);
  const bool opaque = is_opaque(image);
  const std::vector<std::uint8_t> pixels = opaque ? without_alpha(image) : image.pixels;
  const int channels = opaque ? 3 : 4;
  std::string bytes;
  if (stbi_write_png_to_func(append_bytes, &bytes, image.width, image.height, channels, pixels.data(),
                             channels * image.width) == 0) {
    throw std::runtime_error("image: could not be encoded as PNG; make it smaller");
  }
  return bytes;
}

std::string encode_jpeg(const Image& image, int quality) {
  check(image);
  if (quality < 1 || quality > 100) throw InvalidInput("image: the quality of a JPEG is from 1 to 100");
  std::string bytes;
  if (stbi_write_jpg_to_func(append_bytes, &bytes, image.width, image.height, 4, image.pixels.data(), quality) == 0) {
    throw std::runtime_error("image: could not be encoded as JPEG; make it smaller");
  }
  return bytes;
}

Image decode_image(const std::string& bytes) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw InvalidInput("image: too many bytes; give a PNG or JPEG file of at most 8192 pixels along a side");
  }
  std::optional<detail::Pixels<std::uint8_t>> pixels = detail::read_colors(bytes);
  if (!pixels) {
    throw InvalidInput("image: not a PNG or JPEG file of at most 8192 pixels along a side, or it is damaged");
  }
  return {pixels->width, pixels->height, std::move(pixels->numbers)};
}

Image side_by_side(std::span<const Image> images) {
  if (images.empty()) throw InvalidInput("side_by_side: no images; give at least one");
  Image row;
  for (const Image& image : images) {
    check(image);
    row.width += image.width;
    row.height = std::max(row.height, image.height);
  }
  const bool transparent = std::any_of(images.begin(), images.end(), has_transparent_corner);
  row.pixels.assign(4 * static_cast<std::size_t>(row.width) * static_cast<std::size_t>(row.height),
                    transparent ? std::uint8_t{0} : std::uint8_t{255});
  int left = 0;
  for (const Image& image : images) {
    const int top = (row.height - image.height) / 2;
    for (int y = 0; y < image.height; ++y) {
      const auto from = image.pixels.begin() + std::ptrdiff_t{4} * image.width * y;
      std::copy_n(from, 4 * image.width, row.pixels.begin() + 4 * (std::ptrdiff_t{row.width} * (top + y) + left));
    }
    left += image.width;
  }
  return row;
}

}  // namespace knead::render
