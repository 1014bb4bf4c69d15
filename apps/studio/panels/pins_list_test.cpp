// The list of pins in the panel.
#include <gtest/gtest.h>

#include <string>

#include "panels/interface_fixture.h"

namespace knead::studio {
namespace {

using PinsListTest = StudioTest;

TEST_F(PinsListTest, ChangesPins) {
  PinVertex seat(options(), 1440, 900);
  run(seat.studio, R"({"new": "sphere", "vertices": 2562}
{"key": "Alt+1"}
{"key": "Home"})");
  seat.frame();
  seat.key("P");
  seat.studio.settings().pose = PoseMode::exact;
  for (const double x : {480.0, 560.0, 640.0}) seat.click(x, 450);
  ASSERT_EQ(seat.studio.placed().pins.size(), 3u);
  seat.frame();
  const auto list = [] {
    for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
      if (std::string(window->Name).find("##pins") != std::string::npos) return window;
    }
    return static_cast<const ImGuiWindow*>(nullptr);
  };
  ASSERT_TRUE(list() != nullptr);
  const double left = list()->Pos.x;
  const double row = ImGui::GetFrameHeightWithSpacing();
  const double second = list()->Pos.y + 1.5 * row;
  const double font = ImGui::GetFontSize();

  seat.click(left + 0.5 * font, second);
  EXPECT_FALSE(seat.studio.placed().pins[1].holds);
  EXPECT_EQ(seat.studio.pointed_pin(), 1u) << "the pin of the row is lit";
  seat.click(left + 0.5 * font, second);
  EXPECT_TRUE(seat.studio.placed().pins[1].holds);

  const Vec3d before = seat.studio.placed().pins[1].place;
  seat.click(left + 4.5 * font, second);
  seat.type(std::to_string(before.x + 0.125));
  seat.key("Enter");
  seat.frame();
  ASSERT_EQ(seat.studio.shown().history.size(), 1u);
  const auto stroke = std::get<PinsStroke>(seat.studio.shown().history[0]->strokes[0].stroke);
  EXPECT_NEAR(stroke.to[1].x - before.x, 0.125, 1e-6);  // six digits were typed
  EXPECT_EQ(stroke.to[1].y, before.y);
  EXPECT_EQ(stroke.to[1].z, before.z);

  seat.frame();
  // The panel has a scroll bar now, and the list is narrower.
  seat.click(list()->Pos.x + list()->Size.x - 0.6 * font, list()->Pos.y + 1.5 * row);
  EXPECT_EQ(seat.studio.placed().pins.size(), 2u);
  EXPECT_EQ(seat.studio.shown().history.size(), 1u);
  seat.move(480, 700);
  EXPECT_FALSE(seat.studio.pointed_pin());
}

}  // namespace
}  // namespace knead::studio
