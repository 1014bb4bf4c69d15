// The panels, driven by the events of a window.
#include "panels/interface.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "document/layers.h"
#include "gestures/gesture_kinds.h"
#include "keys.h"
#include "knead/vec.h"
#include "panels/interface_fixture.h"

namespace knead::studio::interface_test {
namespace {

class InterfaceTest : public StudioTest {
 protected:
  // A ball in the window, seen from the front and framed; all parts of the side panel are open.
  void open_ball(ShownPanels& panels) const {
    panels.studio.preferences().panels.closed.clear();
    run(panels.studio, R"({"new": "sphere", "vertices": 2562}
{"set": {"start": "surface"}})");
    run(panels.studio, R"({"key": "Alt+1"}
{"key": "Home"})");
    panels.frame();
  }

  // Leaves work behind, as a run does that was killed.
  void leave_work() const {
    Studio studio(options());
    run(studio, ball());
    run(studio, kTools[0].script);
  }

  static Pixel middle_of(const Studio& studio) { return pixel_of(studio.view().screen(), {0, 0, 0}).value(); }
};

// Where a drag of the ball began, as a pixel.
Pixel start_of(const Studio& studio) {
  const auto& stroke = std::get<ImplicitStroke>(studio.document().shown().history.back()->strokes.front().stroke);
  return pixel_of(studio.view().screen(), stroke.path.front()).value();
}

TEST_F(InterfaceTest, AWindowThatIsResizedWhileRecoveryIsOfferedShowsAndPicksRightly) {
  leave_work();
  ShownPanels panels(options(), 1440, 900);
  ASSERT_TRUE(panels.interface.is_asking());
  EXPECT_EQ(panels.studio.view().screen().width, 1440) << "the size is known before the first event";
  panels.resize(1000, 700);
  EXPECT_EQ(panels.studio.view().screen().width, 1000);
  EXPECT_EQ(panels.studio.view().screen().height, 700);
  panels.key("Enter");
  ASSERT_FALSE(panels.interface.is_asking());
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1u);
  run(panels.studio, R"({"set": {"start": "surface"}})");
  const Pixel middle = middle_of(panels.studio);
  panels.drag(middle.x - 40, middle.y, middle.x, middle.y - 30);
  ASSERT_EQ(panels.studio.document().shown().history.size(), 2u);
  EXPECT_NEAR(start_of(panels.studio).x, middle.x - 40, 0.5);
  EXPECT_NEAR(start_of(panels.studio).y, middle.y, 0.5);
}

TEST_F(InterfaceTest, WhatIsHeldWhenADialogOpensIsLetGoDuringIt) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  panels.move(middle.x, middle.y);
  panels.press(middle.x, middle.y);
  panels.move(middle.x + 30, middle.y);
  panels.frame({KeyChanged{"N", true, {false, true, false}}});
  ASSERT_TRUE(panels.interface.is_asking());
  panels.frame({KeyChanged{"N", false, {false, true, false}}});
  panels.release(middle.x + 30, middle.y);
  EXPECT_FALSE(panels.studio.gesture().has_value());
  EXPECT_EQ(panels.studio.document().shown().history.size(), 1u);
  panels.frame();
  panels.key("Escape");
  ASSERT_FALSE(panels.interface.is_asking());
  panels.frame({KeyChanged{"N", true, {false, true, false}}});
  EXPECT_TRUE(panels.interface.is_asking()) << "the key was let go, so it is no repetition";
}

TEST_F(InterfaceTest, EscapeClosesAnOpenListAndNothingElse) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  run(panels.studio, R"({"tool": "stamp"})");
  panels.click(middle.x, middle.y);
  ASSERT_TRUE(panels.studio.tools().placed().placement);
  ASSERT_TRUE(panels.open_a_list());
  panels.move(middle.x, middle.y);
  panels.key("Escape");
  EXPECT_FALSE(ShownPanels::is_list_open());
  EXPECT_TRUE(panels.studio.tools().placed().placement) << "the list took the key";
  panels.key("Escape");
  EXPECT_FALSE(panels.studio.tools().placed().placement);
}

TEST_F(InterfaceTest, AStrokeBesideAnOpenListClosesItAndIsDone) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  ASSERT_TRUE(panels.open_a_list());
  run(panels.studio, R"({"set": {"radius": 0.5}})");
  panels.drag(middle.x, middle.y, middle.x + 40, middle.y - 40);
  EXPECT_FALSE(ShownPanels::is_list_open());
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1u);
  EXPECT_NEAR(start_of(panels.studio).x, middle.x, 0.5);
}

TEST_F(InterfaceTest, AClickBesideAMenuOnlyClosesIt) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  panels.click(20, 10);
  ASSERT_TRUE(ShownPanels::is_list_open());
  panels.drag(middle.x, middle.y, middle.x + 40, middle.y - 40);
  EXPECT_FALSE(ShownPanels::is_list_open());
  EXPECT_TRUE(panels.studio.document().shown().history.empty());
  panels.click(20, 10);
  ASSERT_TRUE(ShownPanels::is_list_open());
  panels.key("Escape");
  EXPECT_FALSE(ShownPanels::is_list_open());
}

TEST_F(InterfaceTest, AClickOnAnAxisShowsTheShapeFromThereAndADragTurnsTheView) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const auto yaw = [&] { return panels.studio.view().navigation().view.yaw; };
  const Area axes = ShownPanels::area_of("Axes");
  const float x = 0.5F * (axes.left + axes.right);
  const float y = 0.5F * (axes.top + axes.bottom);
  run(panels.studio, R"({"view": {"yaw_deg": 30, "pitch_deg": 20}}
{"key": "Home"}
{"key": "Alt+1"})");
  panels.frame();
  ASSERT_NEAR(yaw(), 0, 1e-9);
  EXPECT_NEAR(panels.studio.view().screen().camera.eye.x, 0, 1e-9) << "frontal, although framed from aslant";
  const Pixel before = middle_of(panels.studio);
  panels.click(x + 30, y);  // the end of x
  EXPECT_NEAR(yaw(), 0.5 * 3.14159265, 1e-6);
  panels.click(x, y - 30);  // of y
  EXPECT_NEAR(panels.studio.view().navigation().view.pitch, 0.5 * 3.14159265, 1e-6);
  run(panels.studio, R"({"key": "Alt+1"})");
  panels.frame();
  panels.drag(x, y, x - 60, y + 20);
  EXPECT_GT(yaw(), 0.1);
  EXPECT_GT(panels.studio.view().navigation().view.pitch, 0.02);
  EXPECT_NEAR(middle_of(panels.studio).x, before.x, 0.5) << "the middle of the shape stays where it is";
  EXPECT_TRUE(panels.studio.document().shown().history.empty());
}

struct WindowCase {
  int width;
  int height;
  double unit;
};
constexpr WindowCase kWindows[] = {{1440, 900, 1}, {800, 500, 1}, {1440, 900, 2}, {640, 400, 1}};

TEST_F(InterfaceTest, TheToolBarStaysInTheWindowAndScrollsToTheChosenTool) {
  for (const auto& [width, height, unit] : kWindows) {
    ShownPanels panels(options(), width, height, unit);
    open_ball(panels);
    const Area bar = ShownPanels::area_of("Tools");
    EXPECT_GE(bar.top, panels.gui.bar_height());
    EXPECT_LE(bar.bottom, static_cast<float>(height) - panels.gui.bar_height());
    const ImGuiWindow& window = *ImGui::FindWindowByName("Tools");
    const bool scrolls = window.ScrollMax.y > 0;
    EXPECT_EQ(scrolls, panels.interface.layout().tool_bar_scrolls) << width;
    EXPECT_EQ(scrolls, width != 1440 || unit != 1) << width << " at " << unit;
    EXPECT_EQ(window.ScrollMax.x, 0);
    panels.studio.document().close();  // leaves nothing to recover
    if (!scrolls) continue;
    panels.studio.perform(action_of(studio_tools().back()));
    for (int i = 0; i < 3; ++i) panels.frame();
    EXPECT_GT(window.Scroll.y, 0.5F * window.ScrollMax.y) << "the last tool is in view";
    panels.studio.perform(action_of(studio_tools().front()));
    for (int i = 0; i < 3; ++i) panels.frame();
    EXPECT_LT(window.Scroll.y, 0.5F * window.ScrollMax.y);
    // The wheel scrolls; what is then under the pointer can be chosen.
    panels.move(bar.left + 0.3F * bar.width(), 0.5F * (bar.top + bar.bottom));
    for (int i = 0; i < 30; ++i) panels.wheel(-1);
    EXPECT_EQ(window.Scroll.y, window.ScrollMax.y);
    panels.click(bar.left + 0.3F * bar.width(), bar.bottom - kToolSize * unit * 0.5);
    EXPECT_EQ(panels.studio.tools().settings().tool, &studio_tools().back());
  }
}

TEST_F(InterfaceTest, HomeShowsTheWholeShapeBesideThePanels) {
  for (const auto& [width, height, unit] : kWindows) {
    ShownPanels panels(options(), width, height, unit);
    open_ball(panels);
    const Area& free = panels.interface.layout().free;
    const Box box = bounding_box(positions(panels.studio));
    Box seen;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                    (corner & 4) != 0 ? box.max.z : box.min.z};
      const Pixel pixel = pixel_of(panels.studio.view().screen(), p).value();
      seen.extend({pixel.x, pixel.y, 0});
    }
    EXPECT_GT(seen.min.x, free.left) << width;
    EXPECT_LT(seen.max.x, free.right) << width;
    EXPECT_GT(seen.min.y, free.top) << width;
    EXPECT_LT(seen.max.y, free.bottom) << width;
    EXPECT_LE(free.right, ShownPanels::area_of("Settings").left);
    // What is under the pointer is what is dragged.
    const Pixel middle = middle_of(panels.studio);
    panels.drag(middle.x, middle.y, middle.x + 10, middle.y);
    ASSERT_EQ(panels.studio.document().shown().history.size(), 1u) << width;
    EXPECT_NEAR(start_of(panels.studio).x, middle.x, 0.5);
    EXPECT_NEAR(start_of(panels.studio).y, middle.y, 0.5);
    // Dragged beside it, the shape turns about its own middle.
    const double x = free.left + 4;
    const double y = free.top + 4;
    panels.frame({PointerMoved{x, y}});
    panels.frame({ButtonChanged{MouseButton::middle, true, x, y}});
    panels.frame({PointerMoved{x + 60, y + 20}});
    panels.frame({ButtonChanged{MouseButton::middle, false, x + 60, y + 20}});
    EXPECT_NE(panels.studio.view().navigation().view.yaw, 0);
    EXPECT_NEAR(middle_of(panels.studio).x, middle.x, 1e-6);
    EXPECT_NEAR(middle_of(panels.studio).y, middle.y, 1e-6);
    panels.studio.document().close();
  }
}

TEST_F(InterfaceTest, WithoutPanelsHomeUsesTheWholeWindow) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  EXPECT_LT(middle_of(panels.studio).x, 650);
  panels.key("Tab");
  panels.key("Home");
  EXPECT_NEAR(middle_of(panels.studio).x, 720, 1.5);
}

TEST_F(InterfaceTest, ErrorsCloseWhenTheSameIsTriedAgain) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const auto shown = [&] {
    std::string all;
    for (const Messages::Message& message : panels.interface.messages().messages) all += message.notice.text + "\n";
    return all;
  };
  panels.studio.document().open(folder_ / "missing.ply");
  panels.frame();
  EXPECT_NE(shown().find("missing.ply"), std::string::npos);
  panels.studio.document().save("/proc/nowhere/a.knead");
  panels.frame();
  EXPECT_NE(shown().find("nowhere"), std::string::npos);
  for (int i = 0; i < 10; ++i) panels.frame();
  const Area free = panels.interface.layout().free;
  const Area area = ShownPanels::area_of("Messages");
  EXPECT_GE(area.left, free.left);
  EXPECT_LE(area.right, free.right);
  EXPECT_LE(area.bottom, free.bottom);
  panels.studio.document().save(folder_ / "a.knead");
  panels.frame();
  EXPECT_EQ(shown().find("nowhere"), std::string::npos) << "it was saved";
  EXPECT_NE(shown().find("missing.ply"), std::string::npos);
  panels.studio.document().open_made(ShapeKind::sphere, 642);
  panels.frame();
  EXPECT_EQ(shown().find("missing.ply"), std::string::npos) << "another shape is open";
}

TEST_F(InterfaceTest, AGestureWithoutTroubleWithdrawsWhatWasWrongWithTheOneBefore) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  panels.studio.document().tell({true, "Draw a line round a part of the shape.", Subject::gesture});
  panels.frame();
  ASSERT_FALSE(panels.interface.messages().messages.empty());
  run(panels.studio, R"({"tool": "ball"})");
  panels.drag(middle.x, middle.y, middle.x + 40, middle.y);
  EXPECT_TRUE(panels.interface.messages().messages.empty());
  EXPECT_EQ(panels.studio.document().shown().history.size(), 1u);
}

TEST(Messages, ErrorsEndByThemselvesAndNothingIsSaidTwice) {
  Messages messages;
  update_messages(messages, {{true, "no disk"}, {false, "done 1 of 2"}, {true, "no disk"}, {false, "done 2 of 2"}}, 0);
  ASSERT_EQ(messages.messages.size(), 2u);
  update_messages(messages, {}, 6);
  ASSERT_EQ(messages.messages.size(), 1u);
  EXPECT_EQ(messages.messages.front().notice.text, "no disk");
  update_messages(messages, {}, 31);
  EXPECT_TRUE(messages.messages.empty());
}

// The contrast of WCAG 2 between two colours.
double contrast(const ImVec4& a, const ImVec4& b) {
  const auto luminance = [](const ImVec4& c) {
    const auto linear = [](float x) { return x <= 0.04045F ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); };
    return 0.2126 * linear(c.x) + 0.7152 * linear(c.y) + 0.0722 * linear(c.z);
  };
  const double x = luminance(a) + 0.05;
  const double y = luminance(b) + 0.05;
  return std::max(x / y, y / x);
}

TEST_F(InterfaceTest, DigitsCanBeReadOnTheGrabOfASlider) {
  const Gui gui(1);
  const auto& colours = ImGui::GetStyle().Colors;
  for (const ImGuiCol grab : {ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive}) {
    EXPECT_EQ(colours[grab].w, 1);
    EXPECT_GT(contrast(colours[ImGuiCol_Text], colours[grab]), 4.5);  // WCAG's limit for text
  }
}

TEST_F(InterfaceTest, TheFalloffIsChosenForAToolAndForAnEntryOfTheHistory) {
  ShownPanels panels(options(), 1280, 900);
  open_ball(panels);
  run(panels.studio, R"({"tool": "ball"})");
  panels.frame();
  const auto set_to = [&](const std::optional<std::pair<double, double>>& place, bool most) {
    ASSERT_TRUE(place);
    panels.drag(place->first, place->second, place->first + (most ? 400 : -400), place->second);
  };
  const ImGuiID of_tool = ImGui::FindWindowByName("Tool")->GetID("##Falloff");
  const auto in_bar = [&] { return panels.place_in(panels.interface.layout().top_bar, of_tool); };
  set_to(in_bar(), false);
  EXPECT_EQ(panels.studio.tools().settings().falloff, 3);
  set_to(in_bar(), true);
  EXPECT_EQ(panels.studio.tools().settings().falloff, 7);

  panels.drag(480, 450, 480, 300);
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1U);
  EXPECT_EQ(falloff_of(panels.studio.document().shown().history[0]->strokes), 7);

  panels.studio.preferences().panels.closed = {"tool", "view"};
  panels.studio.history().select(0);
  for (int i = 0; i < 3; ++i) panels.frame();
  set_to(panels.place_of(ImGui::FindWindowByName("Entry")->GetID("##Falloff")), false);
  EXPECT_EQ(falloff_of(panels.studio.history().editor().strokes), 3);
  EXPECT_EQ(falloff_of(panels.studio.document().shown().history[0]->strokes), 7) << "not before it is applied";
  EXPECT_EQ(panels.studio.tools().settings().falloff, 7);

  panels.studio.preferences().panels.closed = {};
  panels.studio.tools().settings().tool = &studio_tool(ToolUse::mask);
  panels.frame();
  EXPECT_FALSE(in_bar()) << "a mask blends nothing";
}

TEST_F(InterfaceTest, ACommaInAFieldIsAPointAndANumberBeyondItsSliderAsks) {
  ShownPanels panels(options(), 1280, 900);
  open_ball(panels);
  const ImGuiID radius = ImGui::FindWindowByName("Tool")->GetID("##Radius");
  const auto type = [&](const std::string& text) {
    const auto place = panels.place_in(panels.interface.layout().top_bar, radius);
    ASSERT_TRUE(place);
    set_modifiers({.ctrl = true});
    panels.move(place->first, place->second);
    set_modifiers({.ctrl = true});
    panels.press(place->first, place->second);
    set_modifiers({});
    panels.release(place->first, place->second);
    panels.frame();
    for (const char c : text) panels.type(std::string(1, c));
    panels.key("Enter");
    panels.frame();
  };
  type("0,25");
  EXPECT_NEAR(panels.studio.tools().settings().radius, 0.25, 1e-9);
  EXPECT_FALSE(ShownPanels::is_list_open());
  type("55");
  EXPECT_NEAR(panels.studio.tools().settings().radius, 0.25, 1e-9) << "not before it is confirmed";
  EXPECT_TRUE(ShownPanels::is_list_open());
}

// However many settings there are, the history keeps its share of the panel, and its last line is seen.
TEST_F(InterfaceTest, TheHistoryIsSeenBelowTheSettings) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  const float whole = panels.interface.layout().side_panel.height();
  panels.frame();
  const float first = ShownPanels::area_of("History").height();
  EXPECT_LT(first, 0.2F * whole) << "as little as it needs";
  for (int i = 0; i < 20; ++i) panels.drag(480, 450, 480, 300 + 10 * i);
  ASSERT_GT(panels.studio.document().shown().history.size(), 15u);
  panels.frame();
  panels.frame();
  const Area history = ShownPanels::area_of("History");
  EXPECT_NEAR(history.height(), kMinHistory * whole, 2);
  EXPECT_NEAR(ShownPanels::area_of("Settings").bottom, history.top, 1);
  const ImGuiWindow* const window = ImGui::FindWindowByName("History");
  EXPECT_GT(window->ScrollMax.y, 50);
  EXPECT_NEAR(window->Scroll.y, window->ScrollMax.y, ImGui::GetTextLineHeightWithSpacing());
  panels.studio.preferences().panels.closed = {"tool", "view"};
  for (int i = 0; i < 3; ++i) panels.frame();
  EXPECT_GT(ShownPanels::area_of("History").height(), 0.6F * whole) << "it takes the room that the settings leave";
}

TEST_F(InterfaceTest, NumbersAtThePointerStayBesideThePanel) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  const Area& free = panels.interface.layout().free;
  panels.move(480, 400);
  panels.press(480, 400);
  for (const float x : {600.0F, free.right - 30, free.right - 2}) {
    panels.move(x, 400);
    const ImDrawList& drawn = *ImGui::GetBackgroundDrawList();
    ASSERT_GT(drawn.VtxBuffer.Size, 0);
    for (const ImDrawVert& vertex : drawn.VtxBuffer) EXPECT_LE(vertex.pos.x, free.right + 1) << x;
  }
  panels.release(free.right - 2, 400);
}

TEST_F(InterfaceTest, StatisticsStayBesideTheSidePanelAndTheKeysCoverIt) {
  for (const auto& [width, height, unit] : kWindows) {
    ShownPanels panels(options(), width, height, unit);
    open_ball(panels);
    panels.studio.view().settings().statistics = true;
    for (int i = 0; i < 4; ++i) panels.frame();
    const Area& free = panels.interface.layout().free;
    const Area statistics = ShownPanels::area_of("Statistics");
    EXPECT_GT(statistics.width(), 0);
    EXPECT_GE(statistics.left, free.left);
    EXPECT_LE(statistics.right, free.right);
    EXPECT_LE(statistics.bottom, free.bottom);
    EXPECT_EQ(ImGui::FindWindowByName("Statistics")->ScrollMax.x, 0);
    panels.studio.view().settings().help = true;
    for (int i = 0; i < 4; ++i) panels.frame();
    const Area keys = ShownPanels::area_of("Keys");
    EXPECT_GE(keys.left, 0);
    EXPECT_LE(keys.right, static_cast<float>(width));
    if (width == 1440 && unit == 1) {
      EXPECT_EQ(ImGui::FindWindowByName("Keys")->ScrollMax.y, 0) << "all keys at once";
    }
    const ImDrawList& list = *ImGui::FindWindowByName("Keys")->DrawList;
    EXPECT_EQ(list.VtxBuffer.front().col >> IM_COL32_A_SHIFT, 255U) << "its background is opaque";
    panels.key("Escape");
    panels.frame();
    EXPECT_FALSE(panels.studio.view().settings().help);
    panels.studio.document().close();
  }
}

TEST_F(InterfaceTest, ACommandIsFoundAndDoneWithTheKeyboard) {
  ShownPanels panels(options(), 1440, 900);
  open_ball(panels);
  panels.key("F3");
  panels.frame();
  ASSERT_TRUE(panels.interface.is_asking());
  panels.frame();
  panels.type("wiref");
  panels.key("Enter");
  panels.frame();
  EXPECT_FALSE(panels.interface.is_asking());
  EXPECT_TRUE(panels.studio.view().settings().wireframe);
  EXPECT_EQ(panels.studio.tools().settings().tool, &studio_tools().front()) << "letters were words, not keys";
  EXPECT_EQ(found_actions("turntable").front(), Action::turntable);
  EXPECT_EQ(found_actions("reference image").front(), Action::reference_image);
  // Arrows choose among what was found.
  const std::vector<Action> found = found_actions("mirror in");
  ASSERT_GE(found.size(), 3u);
  panels.key("F3");
  panels.frame();
  panels.frame();
  panels.type("mirror in");
  panels.key("Down");
  panels.key("Enter");
  panels.frame();
  EXPECT_EQ(found[1], Action::mirror_y);
  EXPECT_TRUE(panels.studio.tools().settings().mirror[1]);
  EXPECT_FALSE(panels.studio.tools().settings().mirror[0]);
  // Escape leaves everything as it was, and what opens a dialog opens it.
  panels.key("F3");
  panels.frame();
  panels.key("Escape");
  panels.frame();
  EXPECT_FALSE(panels.interface.is_asking());
  panels.key("F3");
  panels.frame();
  panels.frame();
  panels.type("new shape");
  panels.key("Enter");
  panels.frame();
  EXPECT_GT(ShownPanels::area_of("New shape").width(), 0) << "the dialog of the command";
}

TEST_F(InterfaceTest, ThePanelIsResizedAtItsEdgeAndComesBackAsItWasLeft) {
  {
    ShownPanels panels(options(), 1440, 900);
    open_ball(panels);
    const Area before = ShownPanels::area_of("Settings");
    EXPECT_NEAR(before.width(), kPanelWidth, 1);
    panels.drag(before.left + 2, 500, before.left - 98, 500);
    EXPECT_TRUE(panels.studio.document().shown().history.empty()) << "the panel took the drag";
    EXPECT_NEAR(ShownPanels::area_of("Settings").width(), kPanelWidth + 100, 3);
    for (int i = 0; i < 20; ++i) panels.frame();
    EXPECT_EQ(ImGui::FindWindowByName("Settings")->ScrollMax.y, 0);
    panels.key("Shift+T");
    panels.key("L");
    panels.click(before.left + 60, before.top + 20);  // folds the tool's settings
    panels.studio.document().close();
  }
  ShownPanels panels(options(), 1440, 900);
  EXPECT_EQ(panels.studio.preferences().panels.closed, std::vector<std::string>{"tool"});
  open_ball(panels);
  EXPECT_NEAR(ShownPanels::area_of("Settings").width(), kPanelWidth + 100, 3);
  EXPECT_TRUE(panels.studio.view().settings().tool_labels);
  EXPECT_FALSE(panels.studio.view().settings().history);
  EXPECT_EQ(errors(panels.studio), "");
}

TEST_F(InterfaceTest, NoRowOfTheHistoryMovesWhenAnEntryIsChosen) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  panels.studio.preferences().panels.closed = {"tool", "view"};
  for (int i = 0; i < 22; ++i) {
    panels.drag(480, 450, 480, 400 + 4 * i);
    if (i != 3 && i != 21) continue;  // where all have room, and where they scroll
    for (int k = 0; k < 3; ++k) panels.frame();
    const int entry = i - 2;
    const ImGuiID name =
        ImHashStr("###name", 0, ImHashData(&entry, sizeof entry, ImGui::FindWindowByName("History")->ID));
    const auto before = panels.place_of(name);
    ASSERT_TRUE(before) << i;
    panels.studio.history().select(i - 3);
    for (int k = 0; k < 3; ++k) panels.frame();
    EXPECT_GT(ShownPanels::area_of("Entry").height(), 100) << i;
    if (i == 3) {
      EXPECT_EQ(panels.place_of(name), before);
    }
    panels.studio.history().select(std::nullopt);
    for (int k = 0; k < 3; ++k) panels.frame();
    EXPECT_EQ(ShownPanels::area_of("Entry").height(), 0) << i;
    EXPECT_EQ(panels.place_of(name), before) << i;
  }
}

TEST_F(InterfaceTest, ADoubleClickRenamesTheEntryThatWasClicked) {
  ShownPanels panels(options(), 1280, 900);
  open_ball(panels);
  panels.studio.preferences().panels.closed = {"tool", "view"};
  for (int i = 0; i < 4; ++i) panels.drag(480, 450, 480, 400 + 10 * i);
  ASSERT_EQ(panels.studio.document().shown().history.size(), 4U);
  panels.studio.history().select(0);
  for (int i = 0; i < 3; ++i) panels.frame();
  const int entry = 3;
  const ImGuiID history = ImGui::FindWindowByName("History")->ID;
  const auto place = panels.place_of(ImHashStr("###name", 0, ImHashData(&entry, sizeof entry, history)));
  ASSERT_TRUE(place);
  panels.click(place->first, place->second);
  panels.click(place->first, place->second);
  panels.frame();
  for (const char c : std::string("Horn")) panels.type(std::string(1, c));
  panels.key("Enter");
  for (int i = 0; i < 3; ++i) panels.frame();
  EXPECT_EQ(name_of(panels.studio.document().shown().history[3]->strokes), "Horn");
  EXPECT_EQ(strength_of(panels.studio.document().shown().history[3]->strokes), 1);
}

TEST_F(InterfaceTest, ExportListsItsFormats) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  panels.key("Ctrl+E");
  for (int i = 0; i < 3; ++i) panels.frame();
  ASSERT_TRUE(panels.click_item("Export the shape", "##Format"));
  panels.frame();
  ImGuiWindow* const list = ShownPanels::popup();
  ASSERT_NE(list, nullptr);
  for (const char* format : {".ply", ".obj", ".glb", ".stl", ".3mf", ".off"}) {
    const Area area{list->Pos.x, list->Pos.y, list->Pos.x + list->Size.x, list->Pos.y + list->Size.y};
    EXPECT_TRUE(panels.place_in(area, list->GetID(format))) << format;
  }
  ASSERT_TRUE(panels.click_item(list, ".obj"));
  panels.frame();
  panels.key("Enter");
  for (int i = 0; i < 3; ++i) panels.frame();
  EXPECT_EQ(errors(panels.studio), "");
  std::vector<std::string> written;
  for (const auto& file : fs::directory_iterator(fs::current_path())) {
    if (file.path().extension() == ".obj") written.push_back(file.path().filename().string());
  }
  EXPECT_EQ(written, std::vector<std::string>{"new_sphere_kneaded.obj"});
  for (const std::string& name : written) fs::remove(name);
}

TEST(Search, SaysWhereEveryCommandIs) {
  EXPECT_EQ(place_of(action_of(*studio_tool("flatten"))), "Tools, Shape");
  EXPECT_EQ(place_of(Action::remesh), "Menu Edit");
  EXPECT_EQ(place_of(Action::mask_blur), "Mask: more settings");
  EXPECT_EQ(place_of(Action::radius), "Bar above");
}

}  // namespace
}  // namespace knead::studio::interface_test
