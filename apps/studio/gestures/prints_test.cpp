// Texts and pictures that are printed with the pointer.
#include <algorithm>
#include <fstream>

#include "gestures/gestures_fixture.h"
#include "knead/editor/tools.h"

namespace knead::studio {
namespace {

class PrintsTest : public GesturesTest {
 protected:
  // A white square with a black border.
  std::string picture(const std::string& folder, int border) const {
    constexpr int kSide = 32;
    fs::create_directories(folder_ / folder);
    const fs::path path = folder_ / folder / "logo.pgm";
    std::ofstream file(path, std::ios::binary);
    file << "P5 " << kSide << ' ' << kSide << " 255\n";
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const int edge = std::min({row, column, kSide - 1 - row, kSide - 1 - column});
        file.put(static_cast<char>(edge < border ? 0 : 255));
      }
    }
    return path.string();
  }

  static PrintStroke last_print(const Studio& studio) { return std::get<PrintStroke>(last_strokes(studio).front()); }

  // How far the shape lies outside of the ball of radius 1, at most, and inside.
  static std::pair<double, double> rise_and_dip(const Studio& studio) {
    double rise = 0;
    double dip = 0;
    for (const Vec3d& p : positions(studio)) {
      rise = std::max(rise, norm(p) - 1);
      dip = std::max(dip, 1 - norm(p));
    }
    return {rise, dip};
  }
};

constexpr const char* kPrint = R"({"tool": "print"}
{"set": {"radius": 0.5, "depth": 0.16, "text": "I"}}
)";

TEST_F(PrintsTest, ATextIsRaisedWhereTheDragEndsAndPressedInWithCtrl) {
  if (font_files().empty())
    GTEST_SKIP() << "this system has no font in the usual folders; install one, such as fonts-dejavu-core";
  Studio studio(options());
  run(studio, ball(40962) + R"({"set": {"remesh": false}}
)" + kPrint + R"({"drag": [[-0.3, 0.2, 0.93], [0, 0, 1]]})");
  EXPECT_EQ(errors(studio), "");
  ASSERT_EQ(studio.document().shown().history.size(), 1U);
  const PrintStroke stroke = last_print(studio);
  EXPECT_EQ(stroke.text, "I");
  EXPECT_LT(norm(*stroke.point - Vec3d{0, 0, 1}), 0.01);
  EXPECT_LT(norm(*stroke.up - Vec3d{0, 1, 0}), 1e-9);
  EXPECT_DOUBLE_EQ(stroke.height, 0.5);
  EXPECT_NEAR(rise_and_dip(studio).first, 0.08, 0.02);
  EXPECT_LT(rise_and_dip(studio).second, 0.02);
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
  run(studio, R"({"key": "Ctrl+Z"}
{"drag": [[-0.3, 0.2, 0.93], [0, 0, 1]], "modifiers": ["ctrl"]})");
  EXPECT_NEAR(rise_and_dip(studio).second, 0.08, 0.02);
}

TEST_F(PrintsTest, APictureFromAFileIsPrintedAndGoesWithTheSession) {
  Studio studio(options());
  run(studio, ball(10242) + kPrint + R"({"stamp": ")" + picture("a", 4) + R"("}
{"set": {"radius": 0.5, "depth": 0.16}}
{"click": [0, 0, 1]}
{"stamp": ")" + picture("b", 12) +
                  R"("}
{"click": [0, 0.7, 0.7]})");
  EXPECT_EQ(errors(studio), "");
  EXPECT_GE(studio.tools().placed().picture->outline.size(), 4U) << "the pointer shows it without reading the file";
  ASSERT_EQ(studio.document().shown().history.size(), 2U);
  EXPECT_EQ(last_print(studio).file, "stamps/logo_2.pgm") << "the first one has this name already";
  EXPECT_EQ(saved_and_replayed(studio).shape.positions(), positions(studio));
  const std::vector<Vec3d> before = positions(studio);
  run(studio, R"({"new": "sphere"}
{"open": ")" + (folder_ / "work.knead").string() +
                  "\"}");
  EXPECT_EQ(errors(studio), "");
  EXPECT_EQ(positions(studio), before) << "opened again, the pictures are found";
}

TEST_F(PrintsTest, WithoutATextThePersonIsToldAndNothingMoves) {
  Studio studio(options());
  run(studio, ball() + kPrint + R"({"set": {"text": ""}}
{"click": [0, 0, 1]})");
  EXPECT_NE(errors(studio), "");
  EXPECT_LT(rise_and_dip(studio).first, 1e-6);
  EXPECT_TRUE(studio.document().shown().history.empty());
}

}  // namespace
}  // namespace knead::studio
