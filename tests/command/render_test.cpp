// knead render, where there is a renderer.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "process.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STB_IMAGE_STATIC
#include "stb_image.h"
#pragma GCC diagnostic pop

namespace knead::command_test::render_test {
namespace {

using Words = std::vector<std::string>;

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  // red, green, blue

  // How many pixels of columns [left, right) are as the predicate says.
  template <class Predicate>
  int count(int left, int right, Predicate predicate) const {
    int found = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = left; x < right; ++x) {
        const std::uint8_t* p = &pixels[3 * static_cast<std::size_t>(y * width + x)];
        if (predicate(p[0], p[1], p[2])) ++found;
      }
    }
    return found;
  }
};

// The cut's colour is the only one that is red without being dark; clay is grey-brown.
bool is_cut(int red, int green, int blue) { return red > green + 50 && green > blue; }
bool is_covered(int red, int green, int blue) { return std::min({red, green, blue}) < 250; }
bool is_green(int red, int green, int blue) { return green > red + 8 && green > blue + 8; }

class RenderTest : public CommandTest {
 protected:
  void SetUp() override {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kTwoStrokes);
    const Outcome outcome = knead({"render", "a.ply", "-o", "probe.png", "--size", "16x16", "-q"});
    const bool is_absent = outcome.err.find("no GPU with OpenGL 3.3") != std::string::npos;
    if (is_absent) GTEST_SKIP() << "no renderer here: " << outcome.err;
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }

  Picture picture_of(const Words& words, const std::string& name = "p.png") const {
    Words all{"render"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"-o", name, "-q", "--no-ground"});
    knead_ok(all);
    const std::string bytes = read(name);
    Picture picture;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                              &picture.width, &picture.height, &channels, 3),
        stbi_image_free);
    EXPECT_NE(pixels, nullptr) << name;
    if (pixels) picture.pixels.assign(pixels.get(), pixels.get() + 3 * picture.width * picture.height);
    return picture;
  }

  // Width and height in the PNG's header.
  std::pair<unsigned, unsigned> size_of(const std::string& name) const {
    const std::string bytes = read(name);
    EXPECT_TRUE(bytes.starts_with("\x89PNG\r\n\x1a\n")) << name;
    if (bytes.size() < 24) return {};
    const auto number = [&](std::size_t at) {
      unsigned value = 0;
      for (std::size_t i = at; i < at + 4; ++i) value = value * 256 + static_cast<unsigned char>(bytes[i]);
      return value;
    };
    return {number(16), number(20)};
  }
};

TEST_F(RenderTest, PicturesHaveTheSizeAskedFor) {
  EXPECT_EQ(knead_ok({"render", "a.ply", "-o", "one.png", "--size", "200x120"}), "one.png: 200 x 120 pixels\n");
  EXPECT_EQ(size_of("one.png"), std::make_pair(200u, 120u));
  knead_ok({"render", "a.ply", "a.ply", "a.ply", "-o", "three.PNG", "--size", "200x100", "-q", "--same-scale"});
  EXPECT_EQ(size_of("three.PNG"), std::make_pair(200u, 100u));
}

TEST_F(RenderTest, OptionsChangeThePicture) {
  const auto picture = [&](const Words& words) {
    Words all{"render", "a.ply", "-o", "p.png", "--size", "96x72", "-q"};
    all.insert(all.end(), words.begin(), words.end());
    knead_ok(all);
    return read("p.png");
  };
  const std::string plain = picture({});
  EXPECT_EQ(picture({"--view", "iso"}), plain);
  EXPECT_EQ(picture({"--view", "35,25"}), plain);
  for (const Words& words :
       {Words{"--flat"}, Words{"--wireframe"}, Words{"--background", "transparent"}, Words{"--background", "dark"},
        Words{"--background", "#204060"}, Words{"--material", "jade"}, Words{"--cavity"}, Words{"--perspective", "60"},
        Words{"--perspective", "0"}, Words{"--quality", "draft"}, Words{"--quality", "fine"}, Words{"--no-ground"},
        Words{"--view", "top"}, Words{"--view", "-30,-20"}, Words{"--session", "s.knead"},
        Words{"--session", "s.knead", "--stroke", "2"}}) {
    EXPECT_NE(picture(words), plain) << ::testing::PrintToString(words);
  }
}

// A ball pulled to the right: only there it is far from the ball.
TEST_F(RenderTest, DistancesAreColours) {
  write("right.knead", R"({"knead": 1}
{"tool": "implicit", "path": [[1, 0, 0], [1.3, 0, 0]], "inner": 0.2, "outer": 0.9}
)");
  knead_ok({"deform", "a.ply", "right.knead", "-o", "b.ply", "-q"});
  const Words shown{"b.ply", "--view", "front", "--size", "160x120", "--distance-to", "a.ply"};
  const auto is_red = [](int red, int green, int blue) { return red > green + 60 && red > blue + 60; };
  const Picture far = picture_of(shown);
  EXPECT_GT(far.count(80, 160, is_red), 200);
  EXPECT_EQ(far.count(0, 60, is_red), 0);
  EXPECT_EQ(picture_of({"b.ply", "--view", "front", "--size", "160x120"}).count(0, 160, is_red), 0);
  Words of_itself = shown;
  of_itself.front() = "a.ply";
  EXPECT_EQ(picture_of(of_itself).count(0, 160, is_red), 0);
  Words less = shown;
  less.insert(less.end(), {"--distance-max", "3"});
  EXPECT_LT(picture_of(less).count(0, 160, is_red), far.count(0, 160, is_red) / 2);

  Words told{"render"};
  told.insert(told.end(), shown.begin(), shown.end());
  told.insert(told.end(), {"-o", "p.png", "--json"});
  const std::string json = knead_ok(told);
  const std::size_t at = json.find("\"greatest_distance\": ");
  ASSERT_NE(at, std::string::npos) << json;
  EXPECT_NEAR(std::strtod(json.c_str() + at + 21, nullptr), 0.3, 0.05);
  for (const Words& wrong : {Words{"--distance-max", "1"}, Words{"--distance-to", "a.ply", "--distance-max", "0"},
                             Words{"--distance-to", "a.ply", "--turntable", "2"}}) {
    Words all{"render", "a.ply", "-o", "p.png"};
    all.insert(all.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(knead(all).exit_code, 2) << ::testing::PrintToString(wrong);
  }
}

// A ball has no corner; a letter has.
TEST_F(RenderTest, OcclusionIsSeenInCorners) {
  knead_ok({"make", "letter-y", "-o", "letter.ply", "-q"});
  const auto picture = [&](const std::string& shape, const Words& words) {
    Words all{shape, "--view", "30,20", "--size", "96x72"};
    all.insert(all.end(), words.begin(), words.end());
    return picture_of(all).pixels;
  };
  EXPECT_EQ(picture("a.ply", {"--occlusion"}), picture("a.ply", {}));
  EXPECT_NE(picture("letter.ply", {"--occlusion"}), picture("letter.ply", {}));
}

// Shape and tools together reach 85% of a panel's width or height, in one panel, in several, and at one scale.
TEST_F(RenderTest, TheFramingFillsThePanel) {
  write("pull.knead", kOneStroke);
  const auto reach = [](const Picture& picture, int from, int to) {
    int left = to;
    int right = from;
    int top = picture.height;
    int bottom = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = from; x < to; ++x) {
        const std::uint8_t* p = &picture.pixels[3 * static_cast<std::size_t>(y * picture.width + x)];
        if (std::min({p[0], p[1], p[2]}) > 250) continue;  // white
        left = std::min(left, x);
        right = std::max(right, x + 1);
        top = std::min(top, y);
        bottom = std::max(bottom, y + 1);
      }
    }
    return std::max(static_cast<double>(right - left) / (to - from),
                    static_cast<double>(bottom - top) / picture.height);
  };
  for (const std::string view : {"iso", "front", "top"}) {
    const Picture alone = picture_of({"a.ply", "--view", view, "--size", "160x100"});
    EXPECT_GE(reach(alone, 0, 160), 0.85) << view;
    const Picture tool = picture_of({"a.ply", "--view", view, "--size", "120x160", "--session", "pull.knead"});
    EXPECT_GE(reach(tool, 0, 120), 0.85) << view;
    EXPECT_LT(reach(tool, 0, 120), 0.95) << view;
    const Picture scale = picture_of({"a.ply", "a.ply", "--view", view, "--size", "240x120", "--same-scale"});
    for (const int panel : {0, 1}) EXPECT_GE(reach(scale, 120 * panel, 120 * panel + 120), 0.85) << view;
  }
}

TEST_F(RenderTest, TheCutIsADiscInItsOwnColor) {
  const Words words{"a.ply", "--view", "front", "--size", "120x120"};
  const Picture whole = picture_of(words);
  EXPECT_EQ(whole.count(0, 120, is_cut), 0);
  const auto cut = [&](const std::string& plane) {
    Words all = words;
    all.insert(all.end(), {"--cut", plane});
    return picture_of(all);
  };
  // Half the ball, seen on its cut: as large as the ball, but for the outline and perspective.
  const int covered = whole.count(0, 120, is_covered);
  EXPECT_NEAR(cut("0,0,2,0").count(0, 120, is_cut), covered, 0.1 * covered);
  // At z = 0.6 the disc has the radius 0.8; in perspective, at a distance of five radii, it is a seventh larger.
  EXPECT_NEAR(cut("0,0,1,0.6").count(0, 120, is_cut), 0.64 * 1.25 * covered, 0.1 * covered);
  // From behind the cut is hidden; beyond the shape there is nothing to cut.
  EXPECT_EQ(cut("0,0,-1,0").count(0, 120, is_cut), 0);
  EXPECT_EQ(cut("0,0,1,2").pixels, whole.pixels);
}

TEST_F(RenderTest, ToolsAreNotCut) {
  write("pull.knead", kOneStroke);
  const Words words{"a.ply", "--view", "front", "--size", "160x120", "--session", "pull.knead"};
  Words cut = words;
  cut.insert(cut.end(), {"--cut", "1,0,0,0.5"});
  const int before = picture_of(words).count(80, 160, is_green);
  EXPECT_GT(before, 500);
  EXPECT_GE(picture_of(cut).count(80, 160, is_green), before / 2);
}

TEST_F(RenderTest, MomentsArePanelsOfTheDeformedShape) {
  write("pull.knead", kOneStroke);
  const Words size{"--view", "front", "--size", "240x80"};
  for (const std::string until : {"0", "0.5", "1"}) {
    knead_ok({"deform", "a.ply", "pull.knead", "--until", until, "-o", "at" + until + ".ply", "-q"});
  }
  Words files{"at0.ply", "at0.5.ply", "at1.ply"};
  files.insert(files.end(), size.begin(), size.end());
  Words moments{"a.ply", "--session", "pull.knead", "--until", "0,0.5,1", "--tools", "none"};
  moments.insert(moments.end(), size.begin(), size.end());
  // The files hold floats, the panels are drawn from doubles: a rounded pixel may differ.
  const Picture a = picture_of(files);
  const Picture b = picture_of(moments);
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  int different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (std::abs(a.pixels[i] - b.pixels[i]) > 8) ++different;
  }
  EXPECT_LT(different, 30);
}

TEST_F(RenderTest, ToolsAreInTheFirstPanelOrWhereTheyAreAtWork) {
  write("pull.knead", kOneStroke);
  const auto greens = [&](const std::string& tools, const std::string& until, int panels) {
    const Picture picture = picture_of({"a.ply", "--session", "pull.knead", "--until", until, "--view", "front",
                                        "--size", std::to_string(100 * panels) + "x100", "--tools", tools});
    std::vector<int> found;
    for (int i = 0; i < panels; ++i) found.push_back(picture.count(100 * i, 100 * (i + 1), is_green));
    return found;
  };
  const std::vector<int> first = greens("first", "0,0.5", 2);
  EXPECT_GT(first[0], 300);
  EXPECT_EQ(first[1], 0);
  const std::vector<int> each = greens("each", "0,0.5,1", 3);
  EXPECT_GT(each[0], 300);
  EXPECT_GT(each[1], 300);
  EXPECT_EQ(each[2], 0);  // the session is over
}

TEST_F(RenderTest, UpIsYOrZ) {
  knead_ok({"make", "cylinder", "-n", "400", "-o", "tall.ply", "-q"});  // along z
  const auto tallness = [&](const Words& words) {
    Words all{"tall.ply", "--size", "80x80"};
    all.insert(all.end(), words.begin(), words.end());
    const Picture picture = picture_of(all);
    int rows = 0;
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 80; ++x) {
        const std::uint8_t* p = &picture.pixels[3 * static_cast<std::size_t>(y * 80 + x)];
        if (is_covered(p[0], p[1], p[2])) {
          ++rows;
          break;
        }
      }
    }
    return rows;
  };
  const int standing = tallness({"--up", "z", "--view", "front"});
  const int lying = tallness({"--view", "right"});
  EXPECT_GT(standing, 60);
  EXPECT_LT(lying, 25);
}

TEST_F(RenderTest, CloseUpsShowSoMuchAndNoMore) {
  const Picture picture = picture_of({"a.ply", "--view", "front", "--size", "100x100", "--close-up", "0,0,0,0.5"});
  EXPECT_EQ(picture.count(0, 100, is_covered), 100 * 100);
  const Picture far = picture_of({"a.ply", "--view", "front", "--size", "100x100", "--close-up", "0,0,0,8"});
  // A disc of a quarter of the picture's height; the outline is some 80 of its 490 pixels.
  EXPECT_NEAR(far.count(0, 100, is_covered), 3.14159 * 12.5 * 12.5, 80);
}

TEST_F(RenderTest, AnyLargePictureShowsProgress) {
  RunOptions terminal;
  terminal.stderr_is_terminal = true;
  terminal.environment = {"TERM=xterm", "NO_COLOR=1"};
  const std::string bar = knead({"render", "a.ply", "-o", "large.png", "--size", "4000x3000"}, terminal).err;
  EXPECT_NE(bar.find("%"), std::string::npos) << bar;
}

TEST_F(RenderTest, JpegShowsTheSame) {
  const Words words{"a.ply", "--size", "96x72"};
  const Picture png = picture_of(words);
  const Picture jpeg = picture_of(words, "p.jpg");
  EXPECT_TRUE(read("p.jpg").starts_with("\xff\xd8\xff"));
  ASSERT_EQ(png.pixels.size(), jpeg.pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < png.pixels.size(); ++i) sum += std::abs(png.pixels[i] - jpeg.pixels[i]);
  EXPECT_LT(sum / static_cast<double>(png.pixels.size()), 3);  // of 255, what the quality leaves
}

// The pictures of an animated GIF, each of red, green, blue and alpha.
std::vector<std::vector<std::uint8_t>> pictures_of_gif(const std::string& bytes, int width, int height) {
  int w = 0;
  int h = 0;
  int count = 0;
  int channels = 0;
  int* delays = nullptr;
  std::uint8_t* const pixels =
      stbi_load_gif_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()), &delays,
                                &w, &h, &count, &channels, 4);
  EXPECT_TRUE(pixels != nullptr && w == width && h == height);
  std::vector<std::vector<std::uint8_t>> pictures;
  const auto size = static_cast<std::size_t>(4 * width * height);
  for (std::size_t k = 0; pixels != nullptr && k < static_cast<std::size_t>(count); ++k) {
    pictures.emplace_back(pixels + k * size, pixels + (k + 1) * size);
  }
  stbi_image_free(pixels);
  std::free(delays);
  return pictures;
}

// The same camera for all: the tip is the highest point of the last frame, and above that of the first.
TEST_F(RenderTest, FramesAreAGifOrNumberedPictures) {
  const Words words{"render", "a.ply", "--session", "s.knead", "--frames", "4", "--size", "64x48", "--hold", "1"};
  Words gif = words;
  gif.insert(gif.end(), {"-o", "f.gif", "-q"});
  knead_ok(gif);
  const auto pictures = pictures_of_gif(read("f.gif"), 64, 48);
  ASSERT_EQ(pictures.size(), 6U);
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_NE(pictures[1], pictures[3]);
  EXPECT_EQ(pictures[4], pictures[5]);
  Words numbered = words;
  numbered.insert(numbered.end(), {"-o", "F_%02d.png", "-q"});
  knead_ok(numbered);
  for (const char* name : {"F_00.png", "F_05.png"}) EXPECT_TRUE(read(name).starts_with("\x89PNG")) << name;
  EXPECT_EQ(read("F_00.png"), read("F_01.png"));
}

TEST_F(RenderTest, ATurntableShowsTheShapeFromAllAround) {
  knead_ok({"make", "hand", "-n", "8000", "-o", "hand.ply", "-q"});
  knead_ok({"render", "hand.ply", "--turntable", "4", "--view", "front", "--size", "64x48", "-o", "t.gif", "-q"});
  const auto pictures = pictures_of_gif(read("t.gif"), 64, 48);
  ASSERT_EQ(pictures.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NE(pictures[k], pictures[(k + 1) % 4]);
}

TEST_F(RenderTest, FilmsAreChecked) {
  const Words frames{"render", "a.ply", "--session", "s.knead", "--frames", "2", "-o"};
  for (const std::string output : {"f.png", "f.bmp", "F_%d.gif", "F_%d_%d.png"}) {
    Words words = frames;
    words.push_back(output);
    expect_error(knead(words), 2, " --help");
  }
  expect_error(knead({"render", "a.ply", "--frames", "2", "-o", "f.gif"}), 2, "--session");
  expect_error(knead({"render", "a.ply", "--turntable", "0", "-o", "f.gif"}), 2, "give 1 to");
  expect_error(knead({"render", "a.ply", "--turntable", "2", "--fps", "0", "-o", "f.gif"}), 2, "above 0");
  expect_error(knead({"render", "a.ply", "--session", "s.knead", "--frames", "2", "--turntable", "2", "-o", "f.gif"}),
               2, "one of them");
  expect_error(knead({"render", "a.ply", "--turntable", "2", "-o", "no/f.gif"}), 5, "knead: no/f.gif: ");
  EXPECT_EQ(files(), (Words{"a.ply", "probe.png", "s.knead"}));
}

TEST_F(RenderTest, ErrorsAreThoseOfTheOthers) {
  expect_error(knead({"render", "none.ply", "-o", "p.png"}), 3, "knead: none.ply: ");
  expect_error(knead({"render", "a.ply", "-o", "no/p.png"}), 5, "knead: no/p.png: ");
  expect_error(knead({"render", "a.ply", "-o", "p.png", "--session", "s.knead", "--stroke", "3"}), 2, "2 strokes");
  expect_error(knead({"render", "a.ply", "-o", "p.png", "--session", "s.knead", "--until", "2.5"}), 2, "2 strokes");
  expect_error(knead({"render", "a.ply", "-o", "p.png", "--session", "none.knead"}), 3, "knead: none.knead: ");
}

}  // namespace
}  // namespace knead::command_test::render_test
