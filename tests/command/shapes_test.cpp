// knead make, info and render.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "knead/mesh/shapes.h"
#include "process.h"

namespace knead::command_test {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

using ShapesTest = CommandTest;

TEST_F(ShapesTest, EveryKindIsClosedAndManifold) {
  for (const std::string_view name : shape_names()) {
    const std::string kind(name);
    SCOPED_TRACE(kind);
    const std::size_t wish = std::max<std::size_t>(3000, shape_counts(shape_kind(kind)).minimum);
    for (const std::string extension : {".ply", ".obj"}) {
      const std::string file = kind + extension;
      EXPECT_EQ(knead_ok({"make", kind, "-n", std::to_string(wish), "-o", file, "-q"}), "");
      const json info = json::parse(knead_ok({"info", file, "--json"}));
      EXPECT_EQ(info["format"], extension.substr(1));
      EXPECT_TRUE(info["closed"].get<bool>());
      EXPECT_TRUE(info["manifold"].get<bool>());
      EXPECT_TRUE(info["oriented"].get<bool>());
      EXPECT_EQ(info["components"], 1);
      EXPECT_EQ(info["boundary_loops"], 0);
      EXPECT_GT(info["volume"].get<double>(), 0);
      EXPECT_GE(10 * info["vertices"].get<std::size_t>(), 9 * wish);
      EXPECT_LE(10 * info["vertices"].get<std::size_t>(), 11 * wish);
      EXPECT_EQ(info["notes"], json::array());
    }
  }
}

TEST_F(ShapesTest, MakeSaysWhatItMade) {
  EXPECT_EQ(knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply"}), "s.ply: 642 vertices, 1280 faces\n");
  const json made = json::parse(knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply", "--json"}));
  EXPECT_EQ(made["vertices"], 642);
}

TEST_F(ShapesTest, InfoOfASphere) {
  knead_ok({"make", "sphere", "-n", "642", "-o", "s.ply", "-q"});
  const json info = json::parse(knead_ok({"info", "s.ply", "--json"}));
  const Words keys{"format",   "vertices",   "faces",          "triangles",  "closed", "manifold",
                   "oriented", "components", "boundary_loops", "euler",      "volume", "area",
                   "box_min",  "box_max",    "diagonal",       "attributes", "notes"};
  for (const std::string& key : keys) EXPECT_TRUE(info.contains(key)) << key;
  EXPECT_EQ(info.size(), keys.size());
  EXPECT_EQ(info["vertices"], 642);
  EXPECT_EQ(info["euler"], 2);
  EXPECT_EQ(info["box_min"].size(), 3u);
  const std::string table = knead_ok({"info", "s.ply"});
  EXPECT_NE(table.find("vertices              642\n"), std::string::npos) << table;
  EXPECT_EQ(knead_ok({"info", "s.ply", "-q"}), "");
}

TEST_F(ShapesTest, InfoOfAnOpenShape) {
  write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const json open = json::parse(knead_ok({"info", "open.obj", "--json"}));
  EXPECT_TRUE(open["volume"].is_null());
  EXPECT_EQ(open["boundary_loops"], 1);
  EXPECT_EQ(open["closed"], false);
}

class RenderTest : public CommandTest {
 protected:
  void SetUp() override {
    knead_ok({"make", "sphere", "-n", "642", "-o", "a.ply", "-q"});
    write("s.knead", kTwoStrokes);
    const Outcome outcome = knead({"render", "a.ply", "-o", "probe.png", "--size", "16x16", "-q"});
    if (outcome.exit_code == 1) GTEST_SKIP() << "no renderer here: " << outcome.err;
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
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
  for (const Words& words : {Words{"--flat"}, Words{"--wireframe"}, Words{"--background", "transparent"},
                             Words{"--no-ground"}, Words{"--view", "top"}, Words{"--view", "-30,-20"},
                             Words{"--session", "s.knead"}, Words{"--session", "s.knead", "--stroke", "2"}}) {
    EXPECT_NE(picture(words), plain) << ::testing::PrintToString(words);
  }
}

TEST_F(RenderTest, ErrorsAreThoseOfTheOthers) {
  expect_error(knead({"render", "none.ply", "-o", "p.png"}), 3, "knead: none.ply: ");
  expect_error(knead({"render", "a.ply", "-o", "no/p.png"}), 5, "knead: no/p.png: ");
  expect_error(knead({"render", "a.ply", "-o", "p.png", "--session", "s.knead", "--stroke", "3"}), 2, "2 strokes");
  expect_error(knead({"render", "a.ply", "-o", "p.png", "--session", "none.knead"}), 3, "knead: none.knead: ");
}

}  // namespace
}  // namespace knead::command_test
