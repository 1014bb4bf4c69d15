// Animated GIFs, decoded again.
#include "knead/editor/render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "knead/error.h"

namespace knead::render::gif_test {
namespace {

// What a player shows: reads the file as the specification says.
class Player {
 public:
  explicit Player(std::string bytes) : bytes_(std::move(bytes)) {
    EXPECT_EQ(take(6), "GIF89a");
    width_ = number();
    height_ = number();
    take(3);
    canvas_.assign(static_cast<std::size_t>(width_ * height_), {1, 2, 3});
  }

  struct Shown {
    std::vector<std::array<std::uint8_t, 3>> pixels;
    int hundredths = 0;
  };

  std::vector<Shown> play() {
    std::vector<Shown> shown;
    int hundredths = 0;
    int transparent = -1;
    for (;;) {
      const int kind = byte();
      if (kind == ';') break;
      if (kind == '!') {
        if (byte() == 0xF9) {
          EXPECT_EQ(byte(), 4);
          transparent = (byte() & 1) != 0 ? 1 : -1;
          hundredths = number();
          const int index = byte();
          if (transparent == 1) transparent = index;
          EXPECT_EQ(byte(), 0);
        } else {
          blocks();
        }
        continue;
      }
      EXPECT_EQ(kind, ',');
      draw(transparent);
      shown.push_back({canvas_, hundredths});
    }
    EXPECT_EQ(at_, bytes_.size());
    return shown;
  }

 private:
  std::string take(std::size_t count) {
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  int byte() { return static_cast<unsigned char>(take(1).at(0)); }
  int number() {
    const int low = byte();
    return low + 256 * byte();
  }
  std::string blocks() {
    std::string all;
    for (int size = byte(); size > 0; size = byte()) all += take(static_cast<std::size_t>(size));
    return all;
  }

  void draw(int transparent) {
    const int left = number();
    const int top = number();
    const int width = number();
    const int height = number();
    EXPECT_EQ(byte(), 0x87);
    const std::string colors = take(768);
    EXPECT_EQ(byte(), 8);
    const std::vector<std::uint8_t> numbers = decompressed(blocks());
    ASSERT_EQ(numbers.size(), static_cast<std::size_t>(width * height));
    for (int i = 0; i < width * height; ++i) {
      const std::size_t n = numbers[static_cast<std::size_t>(i)];
      if (static_cast<int>(n) == transparent) continue;
      auto& pixel = canvas_.at(static_cast<std::size_t>((top + i / width) * width_ + left + i % width));
      for (std::size_t k = 0; k < 3; ++k) pixel[k] = static_cast<std::uint8_t>(colors[3 * n + k]);
    }
  }

  static std::vector<std::uint8_t> decompressed(const std::string& data) {
    std::vector<std::vector<std::uint8_t>> table;
    std::vector<std::uint8_t> result;
    std::vector<std::uint8_t> last;
    std::size_t bit = 0;
    std::size_t width = 9;
    for (;;) {
      std::size_t code = 0;
      for (std::size_t k = 0; k < width; ++k, ++bit) {
        code |= static_cast<std::size_t>(static_cast<unsigned char>(data.at(bit / 8)) >> bit % 8 & 1) << k;
      }
      if (code == 257) return result;
      if (code == 256) {
        table.assign(258, {});
        for (std::size_t i = 0; i < 256; ++i) table[i] = {static_cast<std::uint8_t>(i)};
        width = 9;
        last.clear();
        continue;
      }
      std::vector<std::uint8_t> entry;
      if (code < table.size()) {
        entry = table[code];
      } else {
        entry = last;
        entry.push_back(last.at(0));
      }
      result.insert(result.end(), entry.begin(), entry.end());
      if (!last.empty() && table.size() < 4096) {
        last.push_back(entry[0]);
        table.push_back(last);
      }
      if (table.size() == std::size_t{1} << width && width < 12) ++width;
      last = entry;
    }
  }

  std::string bytes_;
  std::size_t at_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::array<std::uint8_t, 3>> canvas_;
};

Image noise(int width, int height, int colors, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::array<std::uint8_t, 3>> palette(static_cast<std::size_t>(colors));
  for (auto& color : palette) {
    for (std::uint8_t& c : color) c = static_cast<std::uint8_t>(random());
  }
  Image image{width, height, {}};
  for (int i = 0; i < width * height; ++i) {
    const auto& color = palette[random() % palette.size()];
    image.pixels.insert(image.pixels.end(), {color[0], color[1], color[2], 255});
  }
  return image;
}

int farthest(const Image& image, const Player::Shown& shown) {
  int most = 0;
  for (std::size_t i = 0; i < shown.pixels.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(image.pixels[4 * i + k] - shown.pixels[i][k]));
  }
  return most;
}

// Noise fills the table of codes several times.
TEST(Gif, UpTo255ColorsAreExact) {
  for (const int colors : {1, 2, 100, 255}) {
    const Image first = noise(150, 120, colors, 1);
    Image second = first;
    const Image patch = noise(40, 30, colors, 2);
    for (int y = 0; y < 30; ++y) {
      std::copy_n(&patch.pixels[static_cast<std::size_t>(160 * y)], 160,
                  &second.pixels[static_cast<std::size_t>(4 * ((y + 50) * 150 + 70))]);
    }
    const std::string changed = gif_picture(second, &first, 5);
    const std::string bytes =
        gif_header(150, 120) + gif_picture(first, nullptr, 4) + changed + gif_picture(second, &second, 6) + gif_end();
    const auto shown = Player(bytes).play();
    ASSERT_EQ(shown.size(), 3U);
    EXPECT_EQ(farthest(first, shown[0]), 0) << colors;
    EXPECT_EQ(farthest(second, shown[1]), 0) << colors;
    EXPECT_EQ(farthest(second, shown[2]), 0) << colors;
    EXPECT_EQ(shown[0].hundredths, 4);
    EXPECT_EQ(shown[2].hundredths, 6);
    if (colors > 1) {
      EXPECT_LT(changed.size(), 800 + gif_picture(second, nullptr, 5).size() / 4);  // 768 bytes are colours
    }
  }
}

TEST(Gif, MoreColorsBecomeNearOnes) {
  Image image{256, 256, {}};
  for (int i = 0; i < 65536; ++i) {
    const auto gray = static_cast<std::uint8_t>(i / 256);
    image.pixels.insert(image.pixels.end(),
                        {gray, static_cast<std::uint8_t>(gray / 2 + i % 32), static_cast<std::uint8_t>(gray / 3), 255});
  }
  const auto shown = Player(gif_header(256, 256) + gif_picture(image, nullptr, 1) + gif_end()).play();
  EXPECT_LE(farthest(image, shown.at(0)), 12);
}

TEST(Gif, TransparentPixelsAreWhite) {
  const Image image{2, 1, {10, 20, 30, 0, 100, 100, 100, 128}};
  const auto shown = Player(gif_header(2, 1) + gif_picture(image, nullptr, 1) + gif_end()).play();
  EXPECT_EQ(shown.at(0).pixels[0], (std::array<std::uint8_t, 3>{255, 255, 255}));
  EXPECT_EQ(shown.at(0).pixels[1][0], 177);
}

TEST(Gif, PicturesHaveOneSize) {
  const Image image = noise(4, 4, 3, 1);
  const Image other = noise(4, 5, 3, 1);
  EXPECT_THROW(gif_picture(image, &other, 1), InvalidInput);
  EXPECT_THROW(gif_picture({}, nullptr, 1), InvalidInput);
}

}  // namespace
}  // namespace knead::render::gif_test
