// The only translation unit with stb's code for reading, which does not pass our warnings.
#include "io/picture.h"

#include <limits>
#include <memory>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wunused-function"
#if !defined(__clang_analyzer__)  // which finds leaks in stb
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#endif
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNM
#define STBI_MAX_DIMENSIONS 8192
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace knead::detail {
namespace {

// `load`: of stb's functions the one for these numbers.
template <class Number, class Load>
std::optional<Pixels<Number>> read_pixels(const std::string& bytes, int channels, const Load& load) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return std::nullopt;
  Pixels<Number> result;
  int channels_in_file = 0;
  const auto* const data = reinterpret_cast<const stbi_uc*>(bytes.data());  // NOLINT: bytes
  const std::unique_ptr<Number, void (*)(void*)> pixels(
      load(data, static_cast<int>(bytes.size()), &result.width, &result.height, &channels_in_file, channels),
      stbi_image_free);
  if (!pixels) return std::nullopt;
  const auto count = static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height);
  result.numbers.assign(pixels.get(), pixels.get() + count * static_cast<std::size_t>(channels));
  return result;
}

}  // namespace

std::optional<Pixels<std::uint8_t>> read_colors(const std::string& bytes) {
  if (bytes.starts_with('P')) return std::nullopt;  // PNM
  return read_pixels<std::uint8_t>(bytes, 4, stbi_load_from_memory);
}

std::optional<Pixels<std::uint16_t>> read_greys(const std::string& bytes) {
  return read_pixels<std::uint16_t>(bytes, 2, stbi_load_16_from_memory);
}

std::string picture_trouble() {
  const char* const reason = stbi_failure_reason();
  return reason == nullptr ? "too large" : reason;
}

}  // namespace knead::detail
