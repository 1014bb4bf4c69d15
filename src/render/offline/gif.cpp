// Animated GIFs: palettes by median cut, LZW, and the parts of a picture that change.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "knead/editor/render.h"
#include "knead/error.h"

namespace knead::render {
namespace {

constexpr std::size_t kMaxColors = 255;  // and one for pixels that stay
constexpr std::uint8_t kStays = 255;

using Rgb = std::array<std::uint8_t, 3>;

struct CountedColor {
  Rgb color{};
  std::size_t count = 0;
};

std::uint32_t key_of(const Rgb& c) {
  return static_cast<std::uint32_t>(c[0]) << 16 | static_cast<std::uint32_t>(c[1]) << 8 | c[2];
}

// Returns the colour of a pixel on white.
Rgb color_at(const Image& image, std::size_t pixel) {
  const std::uint8_t* const p = &image.pixels[4 * pixel];
  Rgb color{};
  for (std::size_t k = 0; k < 3; ++k) {
    color[k] = static_cast<std::uint8_t>((p[k] * p[3] + 255 * (255 - p[3]) + 127) / 255);
  }
  return color;
}

// A range of the colours, and its extent.
struct ColorBox {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t axis = 0;
  double weight = 0;  // of pixels times the length along the axis; 0: one colour
};

ColorBox measured(const std::vector<CountedColor>& colors, std::size_t begin, std::size_t end) {
  Rgb least{255, 255, 255};
  Rgb greatest{};
  double pixels = 0;
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      least[k] = std::min(least[k], colors[i].color[k]);
      greatest[k] = std::max(greatest[k], colors[i].color[k]);
    }
    pixels += static_cast<double>(colors[i].count);
  }
  ColorBox box{begin, end};
  int length = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (greatest[k] - least[k] <= length) continue;
    length = greatest[k] - least[k];
    box.axis = k;
  }
  box.weight = length * std::sqrt(pixels);
  return box;
}

// Returns where to cut a box, with half of its pixels on either side.
std::size_t cut(std::vector<CountedColor>& colors, const ColorBox& box) {
  const auto begin = colors.begin() + static_cast<std::ptrdiff_t>(box.begin);
  const auto end = colors.begin() + static_cast<std::ptrdiff_t>(box.end);
  std::sort(begin, end, [&](const CountedColor& a, const CountedColor& b) {
    return a.color[box.axis] != b.color[box.axis] ? a.color[box.axis] < b.color[box.axis] : a.color < b.color;
  });
  const std::size_t all =
      std::accumulate(begin, end, std::size_t{0}, [](std::size_t n, const CountedColor& c) { return n + c.count; });
  std::size_t sum = 0;
  std::size_t at = box.begin;
  while (at + 1 < box.end && 2 * (sum + colors[at].count) <= all) sum += colors[at++].count;
  return std::clamp(at, box.begin + 1, box.end - 1);
}

Rgb mean_of(const std::vector<CountedColor>& colors, const ColorBox& box) {
  std::array<std::size_t, 3> sum{};
  std::size_t count = 0;
  for (std::size_t i = box.begin; i < box.end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += colors[i].color[k] * colors[i].count;
    count += colors[i].count;
  }
  Rgb mean{};
  for (std::size_t k = 0; k < 3; ++k) mean[k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
  return mean;
}

// A rectangle of pixels.
struct Rectangle {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
};

// The colours of a picture, 255 at most, and the number of each colour in it.
struct Palette {
  std::vector<Rgb> colors;
  std::unordered_map<std::uint32_t, std::uint8_t> number;
};

// Median cut (Heckbert 1982).
Palette palette_of(const std::vector<Rgb>& pixels) {
  std::unordered_map<std::uint32_t, CountedColor> counts;
  for (const Rgb& pixel : pixels) {
    CountedColor& counted = counts[key_of(pixel)];
    counted.color = pixel;
    ++counted.count;
  }
  std::vector<CountedColor> colors;
  colors.reserve(counts.size());
  for (const auto& [key, counted] : counts) colors.push_back(counted);
  std::sort(colors.begin(), colors.end(), [](const auto& a, const auto& b) { return a.color < b.color; });
  std::vector<ColorBox> boxes;
  if (!colors.empty()) boxes.push_back(measured(colors, 0, colors.size()));
  while (boxes.size() < kMaxColors) {
    const auto widest = std::max_element(boxes.begin(), boxes.end(),
                                         [](const ColorBox& a, const ColorBox& b) { return a.weight < b.weight; });
    if (widest == boxes.end() || widest->weight == 0) break;
    const ColorBox whole = *widest;
    const std::size_t at = cut(colors, whole);
    *widest = measured(colors, whole.begin, at);
    boxes.push_back(measured(colors, at, whole.end));
  }
  Palette palette;
  for (const ColorBox& box : boxes) {
    for (std::size_t i = box.begin; i < box.end; ++i) {
      palette.number[key_of(colors[i].color)] = static_cast<std::uint8_t>(palette.colors.size());
    }
    palette.colors.push_back(mean_of(colors, box));
  }
  return palette;
}

void append_16(std::string& bytes, int value) {
  bytes += static_cast<char>(value & 255);
  bytes += static_cast<char>(value >> 8);
}

// Codes of growing width, the least significant bit first, in blocks of up to 255 bytes.
class CodeWriter {
 public:
  explicit CodeWriter(std::string& bytes) : bytes_(bytes) {}

  void add(int code, int width) {
    bits_ |= static_cast<std::uint32_t>(code) << count_;
    for (count_ += width; count_ >= 8; count_ -= 8, bits_ >>= 8) add_byte(static_cast<char>(bits_ & 255));
  }

  void finish() {
    if (count_ > 0) add_byte(static_cast<char>(bits_ & 255));
    flush();
    bytes_ += '\0';
  }

 private:
  void add_byte(char byte) {
    block_ += byte;
    if (block_.size() == 255) flush();
  }
  void flush() {
    if (block_.empty()) return;
    bytes_ += static_cast<char>(block_.size());
    bytes_ += block_;
    block_.clear();
  }

  std::string& bytes_;
  std::string block_;
  std::uint32_t bits_ = 0;
  int count_ = 0;
};

// LZW with codes of 9 to 12 bits.
void append_compressed(std::string& bytes, const std::vector<std::uint8_t>& numbers) {
  constexpr int clear = 256;
  constexpr int most_codes = 4096;
  bytes += '\x08';
  CodeWriter writer(bytes);
  std::vector<std::array<std::int16_t, 256>> next(most_codes);  // the code of a code and a number; 0: none
  int codes = clear + 2;
  int width = 9;
  const auto restart = [&] {
    writer.add(clear, width);
    std::fill(next.begin(), next.end(), std::array<std::int16_t, 256>{});
    codes = clear + 2;
    width = 9;
  };
  restart();
  int prefix = numbers.front();
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    std::int16_t& known = next[static_cast<std::size_t>(prefix)][numbers[i]];
    if (known != 0) {
      prefix = known;
      continue;
    }
    writer.add(prefix, width);
    if (codes == most_codes) {
      restart();
    } else {
      if (codes == 1 << width) ++width;
      known = static_cast<std::int16_t>(codes++);
    }
    prefix = numbers[i];
  }
  writer.add(prefix, width);
  if (codes == 1 << width && width < 12) ++width;
  writer.add(clear + 1, width);
  writer.finish();
}

// Returns the rectangle that differs from the picture before; one pixel if nothing does.
Rectangle changed(const Image& image, const Image* before) {
  if (before == nullptr) return {0, 0, image.width, image.height};
  int left = image.width;
  int right = 0;
  int top = image.height;
  int bottom = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      if (color_at(image, pixel) == color_at(*before, pixel)) continue;
      left = std::min(left, x);
      right = std::max(right, x + 1);
      top = std::min(top, y);
      bottom = std::max(bottom, y + 1);
    }
  }
  if (right == 0) return {0, 0, 1, 1};
  return {left, top, right - left, bottom - top};
}

void check(const Image& image, const Image* before) {
  constexpr int most = 65535;
  const bool is_whole =
      image.width > 0 && image.height > 0 && image.width <= most && image.height <= most &&
      image.pixels.size() == 4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (!is_whole) throw InvalidInput("a GIF holds pictures from 1 x 1 to 65535 x 65535 pixels");
  if (before != nullptr && (before->width != image.width || before->height != image.height)) {
    throw InvalidInput("all pictures of a GIF have the same size");
  }
}

}  // namespace

std::string gif_header(int width, int height) {
  std::string bytes = "GIF89a";
  append_16(bytes, width);
  append_16(bytes, height);
  bytes += std::string("\x70\x00\x00", 3);                                  // no colours for all pictures
  bytes += std::string("\x21\xFF\x0BNETSCAPE2.0\x03\x01\x00\x00\x00", 19);  // played for ever
  return bytes;
}

std::string gif_picture(const Image& image, const Image* before, int hundredths) {
  check(image, before);
  const Rectangle part = changed(image, before);
  std::vector<Rgb> pixels;  // that change
  std::vector<bool> stays;
  for (int y = part.top; y < part.top + part.height; ++y) {
    for (int x = part.left; x < part.left + part.width; ++x) {
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      const Rgb color = color_at(image, pixel);
      stays.push_back(before != nullptr && color == color_at(*before, pixel));
      if (!stays.back()) pixels.push_back(color);
    }
  }
  const Palette palette = palette_of(pixels);
  std::string bytes("\x21\xF9\x04\x05", 4);  // leave the picture in place; one number is transparent
  append_16(bytes, std::clamp(hundredths, 0, 65535));
  bytes += static_cast<char>(kStays);
  bytes += std::string("\x00\x2C", 2);
  for (const int n : {part.left, part.top, part.width, part.height}) append_16(bytes, n);
  bytes += '\x87';  // 256 colours of its own
  for (std::size_t i = 0; i < 256; ++i) {
    const Rgb color = i < palette.colors.size() ? palette.colors[i] : Rgb{};
    for (const std::uint8_t c : color) bytes += static_cast<char>(c);
  }
  std::vector<std::uint8_t> numbers;
  numbers.reserve(stays.size());
  std::size_t next = 0;
  for (const bool stay : stays) numbers.push_back(stay ? kStays : palette.number.at(key_of(pixels[next++])));
  append_compressed(bytes, numbers);
  return bytes;
}

std::string gif_end() { return ";"; }

}  // namespace knead::render
