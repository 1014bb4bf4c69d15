// What Studio offers where a stroke fell short or was refused: what was reached, and one button.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "document/document.h"
#include "panels/interface_fixture.h"

namespace knead::studio::offers_test {
namespace {

using OffersTest = StudioTest;

// What a pose fell short of is shown with one button, and so is a bend that finds no part.
TEST_F(OffersTest, APoseThatFallsShortOffersTheOneThingToDo) {
  ShownPanels panels(options(), 1280, 800);
  panels.studio.preferences().panels.closed.clear();
  run(panels.studio, R"({"new": "sphere", "vertices": 642}
{"key": "Alt+1"}
{"key": "Home"}
{"tool": "pose"}
{"set": {"pose": "lasso", "detail": 0.1}}
)");
  const auto round = [&](double from, double to) {
    const auto a = pixel_of(panels.studio.view().screen(), {from, 1.1, 0});
    const auto b = pixel_of(panels.studio.view().screen(), {to, -1.1, 0});
    return fmt::format(R"({{"drag": [[{0}, {1}], [{2}, {1}], [{2}, {3}], [{0}, {3}], [{0}, {4}]], "steps": 4}})", a->x,
                       a->y, b->x, b->y, a->y + 10);
  };
  run(panels.studio, round(-1.1, -0.1) + "\n" + round(0.1, 1.1));
  ASSERT_EQ(panels.studio.tools().placed().parts.holds.size(), 2U);
  run(panels.studio, R"({"press": [0.6, 0, 0.8]}
{"move": [0.5, 0.2, 0.8]}
{"key": "1"}
{"key": "2"}
{"key": "0"}
{"key": "Enter"})");
  const auto last = [&] { return panels.studio.document().shown().history.back(); };
  const auto detail = [&] { return std::get<PoseStroke>(last()->strokes.front().stroke).detail; };
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1U);
  ASSERT_NE(last()->notes.shortfall, "");
  EXPECT_EQ(detail(), 0.1);
  const double reached = last()->notes.reached;
  for (int i = 0; i < 3; ++i) panels.frame();
  EXPECT_TRUE(panels.interface.messages().messages.empty()) << panels.interface.messages().messages.front().notice.text;
  ASSERT_TRUE(panels.click_item("Offer", "Finer"));
  for (int i = 0; i < 3; ++i) panels.frame();
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1U);
  EXPECT_EQ(detail(), 0);
  for (int tries = 0; tries < 3 && !last()->notes.shortfall.empty(); ++tries) {
    ASSERT_TRUE(panels.click_item("Offer", "Hold less"));
    for (int i = 0; i < 3; ++i) panels.frame();
  }
  EXPECT_GT(last()->notes.reached, reached);
  EXPECT_EQ(last()->notes.shortfall, "");
  EXPECT_FALSE(panels.click_item("Offer", "Hold less"));
  EXPECT_EQ(errors(panels.studio), "");
}

TEST_F(OffersTest, ABendThatFindsNoPartOffersThePose) {
  ShownPanels panels(options(), 1280, 800);
  panels.studio.preferences().panels.closed.clear();
  run(panels.studio, R"({"new": "torus", "vertices": 4000}
{"key": "Alt+3"}
{"key": "Home"}
{"tool": "bend"}
{"click": [1.3, 0, 0]})");
  for (int i = 0; i < 3; ++i) panels.frame();
  ASSERT_TRUE(panels.studio.tools().placed().placement);
  ASSERT_TRUE(panels.click_item("Offer", "Pose it"));
  panels.frame();
  EXPECT_EQ(panels.studio.tools().settings().tool->use, ToolUse::pose);
  EXPECT_EQ(ShownPanels::area_of("Offer").width(), 0);
}

TEST_F(OffersTest, ABendThatIsRefusedOffersThePoseInItsMessage) {
  ShownPanels panels(options(), 1280, 800);
  run(panels.studio, R"({"new": "hand", "vertices": 4000}
{"key": "Alt+1"}
{"key": "Home"}
{"tool": "bend"}
{"click": [0.11, 0.6, 0.09]})");
  panels.studio.document().tell({true, in_words("\"angle_deg\": the part would meet itself"), Subject::strokes});
  for (int i = 0; i < 3; ++i) panels.frame();
  ASSERT_EQ(panels.interface.messages().messages.size(), 1U);
  EXPECT_EQ(panels.interface.messages().messages.front().notice.text, "The part would meet itself.");
  ImGuiWindow* const messages = ImGui::FindWindowByName("Messages");
  const int number = 0;
  const ImGuiID button = ImHashStr("Pose it", 0, ImHashData(&number, sizeof number, messages->ID));
  const auto place = panels.place_in(ShownPanels::area_of("Messages"), button);
  ASSERT_TRUE(place);
  panels.click(place->first, place->second);
  EXPECT_EQ(panels.studio.tools().settings().tool->use, ToolUse::pose);
  EXPECT_EQ(panels.studio.tools().placed().parts.holds.size(), 2U);
  EXPECT_TRUE(panels.interface.messages().messages.empty());
}

}  // namespace
}  // namespace knead::studio::offers_test
