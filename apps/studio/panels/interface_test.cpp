// The panels, driven by the events of a window.
#include "panels/interface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "document/layers.h"
#include "gestures/gesture_kinds.h"
#include "keys.h"
#include "knead/vec.h"
#include "panels/interface_fixture.h"

namespace knead::studio {
namespace {

class InterfaceTest : public StudioTest {
 protected:
  // A ball in the window, seen from the front and framed.
  void open_ball(PinVertex& seat) const {
    run(seat.studio, R"({"new": "sphere", "vertices": 2562}
{"set": {"start": "surface"}})");
    run(seat.studio, R"({"key": "Alt+1"}
{"key": "Home"})");
    seat.frame();
  }

  // Leaves work behind, as a run does that was killed.
  void leave_work() const {
    Studio studio(options());
    run(studio, ball());
    run(studio, kTools[0].script);
  }

  static Pixel middle_of(const Studio& studio) { return pixel_of(studio.screen(), {0, 0, 0}).value(); }
};

// Where a drag of the ball began, as a pixel.
Pixel start_of(const Studio& studio) {
  const auto& stroke = std::get<ImplicitStroke>(studio.shown().history.back()->strokes.front().stroke);
  return pixel_of(studio.screen(), stroke.path.front()).value();
}

TEST_F(InterfaceTest, AWindowThatIsResizedWhileRecoveryIsOfferedShowsAndPicksRightly) {
  leave_work();
  PinVertex seat(options(), 1440, 900);
  ASSERT_TRUE(seat.interface.is_asking());
  EXPECT_EQ(seat.studio.screen().width, 1440) << "the size is known before the first event";
  seat.resize(1000, 700);
  EXPECT_EQ(seat.studio.screen().width, 1000);
  EXPECT_EQ(seat.studio.screen().height, 700);
  seat.key("Enter");
  ASSERT_FALSE(seat.interface.is_asking());
  ASSERT_EQ(seat.studio.shown().history.size(), 1u);
  run(seat.studio, R"({"set": {"start": "surface"}})");
  const Pixel middle = middle_of(seat.studio);
  seat.drag(middle.x - 40, middle.y, middle.x, middle.y - 30);
  ASSERT_EQ(seat.studio.shown().history.size(), 2u);
  EXPECT_NEAR(start_of(seat.studio).x, middle.x - 40, 0.5);
  EXPECT_NEAR(start_of(seat.studio).y, middle.y, 0.5);
}

TEST_F(InterfaceTest, WhatIsHeldWhenADialogOpensIsLetGoDuringIt) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  const Pixel middle = middle_of(seat.studio);
  seat.move(middle.x, middle.y);
  seat.press(middle.x, middle.y);
  seat.move(middle.x + 30, middle.y);
  seat.frame({KeyChanged{"N", true, {false, true, false}}});
  ASSERT_TRUE(seat.interface.is_asking());
  seat.frame({KeyChanged{"N", false, {false, true, false}}});
  seat.release(middle.x + 30, middle.y);
  EXPECT_FALSE(seat.studio.gesture().has_value());
  EXPECT_EQ(seat.studio.shown().history.size(), 1u);
  seat.frame();
  seat.key("Escape");
  ASSERT_FALSE(seat.interface.is_asking());
  seat.frame({KeyChanged{"N", true, {false, true, false}}});
  EXPECT_TRUE(seat.interface.is_asking()) << "the key was let go, so it is no repetition";
}

TEST_F(InterfaceTest, EscapeClosesAnOpenListAndNothingElse) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  const Pixel middle = middle_of(seat.studio);
  run(seat.studio, R"({"tool": "stamp"})");
  seat.click(middle.x, middle.y);
  ASSERT_TRUE(seat.studio.placed().placement);
  ASSERT_TRUE(seat.open_a_list());
  seat.move(middle.x, middle.y);
  seat.key("Escape");
  EXPECT_FALSE(PinVertex::is_list_open());
  EXPECT_TRUE(seat.studio.placed().placement) << "the list took the key";
  seat.key("Escape");
  EXPECT_FALSE(seat.studio.placed().placement);
}

TEST_F(InterfaceTest, AStrokeBesideAnOpenListClosesItAndIsDone) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  const Pixel middle = middle_of(seat.studio);
  ASSERT_TRUE(seat.open_a_list());
  run(seat.studio, R"({"set": {"radius": 0.5}})");
  seat.drag(middle.x, middle.y, middle.x + 40, middle.y - 40);
  EXPECT_FALSE(PinVertex::is_list_open());
  ASSERT_EQ(seat.studio.shown().history.size(), 1u);
  EXPECT_NEAR(start_of(seat.studio).x, middle.x, 0.5);
}

TEST_F(InterfaceTest, AClickBesideAMenuOnlyClosesIt) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  const Pixel middle = middle_of(seat.studio);
  seat.click(20, 10);
  ASSERT_TRUE(PinVertex::is_list_open());
  seat.drag(middle.x, middle.y, middle.x + 40, middle.y - 40);
  EXPECT_FALSE(PinVertex::is_list_open());
  EXPECT_TRUE(seat.studio.shown().history.empty());
  seat.click(20, 10);
  ASSERT_TRUE(PinVertex::is_list_open());
  seat.key("Escape");
  EXPECT_FALSE(PinVertex::is_list_open());
}

struct WindowCase {
  int width;
  int height;
  double unit;
};
constexpr WindowCase kWindows[] = {{1440, 900, 1}, {800, 500, 1}, {1440, 900, 2}, {480, 320, 1}};

TEST_F(InterfaceTest, TheToolBarStaysInTheWindowAndScrollsToTheChosenTool) {
  for (const auto& [width, height, unit] : kWindows) {
    PinVertex seat(options(), width, height, unit);
    open_ball(seat);
    const Area bar = PinVertex::area_of("Tools");
    EXPECT_GE(bar.top, seat.gui.bar_height());
    EXPECT_LE(bar.bottom, static_cast<float>(height) - seat.gui.bar_height());
    const ImGuiWindow& window = *ImGui::FindWindowByName("Tools");
    const bool scrolls = window.ScrollMax.y > 0;
    EXPECT_EQ(scrolls, seat.interface.layout().tool_bar_scrolls) << width;
    EXPECT_EQ(scrolls, width != 1440 || unit != 1) << width << " at " << unit;
    EXPECT_EQ(window.ScrollMax.x, 0);
    seat.studio.close();  // leaves nothing to recover
    if (!scrolls) continue;
    seat.studio.perform(action_of(studio_tools().back()));
    for (int i = 0; i < 3; ++i) seat.frame();
    EXPECT_GT(window.Scroll.y, 0.5F * window.ScrollMax.y) << "the last tool is in view";
    seat.studio.perform(action_of(studio_tools().front()));
    for (int i = 0; i < 3; ++i) seat.frame();
    EXPECT_LT(window.Scroll.y, 0.5F * window.ScrollMax.y);
    // The wheel scrolls; what is then under the pointer can be chosen.
    seat.move(bar.left + 0.3F * bar.width(), 0.5F * (bar.top + bar.bottom));
    for (int i = 0; i < 30; ++i) seat.wheel(-1);
    EXPECT_EQ(window.Scroll.y, window.ScrollMax.y);
    seat.click(bar.left + 0.3F * bar.width(), bar.bottom - kToolSize * unit * 0.5);
    EXPECT_EQ(seat.studio.settings().tool, &studio_tools().back());
  }
}

TEST_F(InterfaceTest, HomeShowsTheWholeShapeBesideThePanels) {
  for (const auto& [width, height, unit] : kWindows) {
    PinVertex seat(options(), width, height, unit);
    open_ball(seat);
    const Area& free = seat.interface.layout().free;
    const Box box = bounding_box(positions(seat.studio));
    Box seen;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                    (corner & 4) != 0 ? box.max.z : box.min.z};
      const Pixel pixel = pixel_of(seat.studio.screen(), p).value();
      seen.extend({pixel.x, pixel.y, 0});
    }
    EXPECT_GT(seen.min.x, free.left) << width;
    EXPECT_LT(seen.max.x, free.right) << width;
    EXPECT_GT(seen.min.y, free.top) << width;
    EXPECT_LT(seen.max.y, free.bottom) << width;
    EXPECT_LE(free.right, PinVertex::area_of("Settings").left);
    // What is under the pointer is what is dragged.
    const Pixel middle = middle_of(seat.studio);
    seat.drag(middle.x, middle.y, middle.x + 10, middle.y);
    ASSERT_EQ(seat.studio.shown().history.size(), 1u) << width;
    EXPECT_NEAR(start_of(seat.studio).x, middle.x, 0.5);
    EXPECT_NEAR(start_of(seat.studio).y, middle.y, 0.5);
    // Dragged beside it, the shape turns about its own middle.
    const double x = free.left + 4;
    const double y = free.top + 4;
    seat.frame({PointerMoved{x, y}});
    seat.frame({ButtonChanged{MouseButton::middle, true, x, y}});
    seat.frame({PointerMoved{x + 60, y + 20}});
    seat.frame({ButtonChanged{MouseButton::middle, false, x + 60, y + 20}});
    EXPECT_NE(seat.studio.navigation().view.yaw, 0);
    EXPECT_NEAR(middle_of(seat.studio).x, middle.x, 1e-6);
    EXPECT_NEAR(middle_of(seat.studio).y, middle.y, 1e-6);
    seat.studio.close();
  }
}

TEST_F(InterfaceTest, WithoutPanelsHomeUsesTheWholeWindow) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  EXPECT_LT(middle_of(seat.studio).x, 650);
  seat.key("Tab");
  seat.key("Home");
  EXPECT_NEAR(middle_of(seat.studio).x, 720, 1.5);
}

TEST_F(InterfaceTest, ErrorsCloseWhenTheSameIsTriedAgain) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  const auto shown = [&] {
    std::string all;
    for (const Messages::Message& message : seat.interface.messages().messages) all += message.notice.text + "\n";
    return all;
  };
  seat.studio.open(folder_ / "missing.ply");
  seat.frame();
  EXPECT_NE(shown().find("missing.ply"), std::string::npos);
  seat.studio.save("/proc/nowhere/a.knead");
  seat.frame();
  EXPECT_NE(shown().find("nowhere"), std::string::npos);
  for (int i = 0; i < 10; ++i) seat.frame();
  const Area free = seat.interface.layout().free;
  const Area area = PinVertex::area_of("Messages");
  EXPECT_GE(area.left, free.left);
  EXPECT_LE(area.right, free.right);
  EXPECT_LE(area.bottom, free.bottom);
  seat.studio.save(folder_ / "a.knead");
  seat.frame();
  EXPECT_EQ(shown().find("nowhere"), std::string::npos) << "it was saved";
  EXPECT_NE(shown().find("missing.ply"), std::string::npos);
  seat.studio.open_made(ShapeKind::sphere, 642);
  seat.frame();
  EXPECT_EQ(shown().find("missing.ply"), std::string::npos) << "another shape is open";
}

TEST_F(InterfaceTest, AGestureWithoutTroubleWithdrawsWhatWasWrongWithTheOneBefore) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  const Pixel middle = middle_of(seat.studio);
  run(seat.studio, R"({"tool": "handles"}
{"set": {"handle": "move"}})");
  seat.drag(middle.x, middle.y, middle.x + 40, middle.y);
  ASSERT_FALSE(seat.interface.messages().messages.empty());
  run(seat.studio, R"({"tool": "ball"})");
  seat.drag(middle.x, middle.y, middle.x + 40, middle.y);
  EXPECT_TRUE(seat.interface.messages().messages.empty());
  EXPECT_EQ(seat.studio.shown().history.size(), 1u);
}

TEST(Messages, ErrorsEndByThemselvesAndNothingIsSaidTwice) {
  Messages messages;
  update_messages(messages, {{true, "no disk"}, {false, "done"}, {true, "no disk"}}, 0);
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
  PinVertex seat(options(), 1280, 900);
  open_ball(seat);
  const auto set_to = [&](ImGuiID slider, bool most) {
    const auto place = seat.place_of(slider);
    ASSERT_TRUE(place);
    const Area& panel = seat.interface.layout().side_panel;
    seat.drag(place->first, place->second, most ? panel.right : panel.left + 8, place->second);
  };
  const ImGuiID of_tool = ImGui::FindWindowByName("Settings")->GetID("Falloff");
  set_to(of_tool, false);
  EXPECT_EQ(seat.studio.settings().falloff, 3);
  set_to(of_tool, true);
  EXPECT_EQ(seat.studio.settings().falloff, 7);

  seat.drag(480, 450, 480, 300);
  ASSERT_EQ(seat.studio.shown().history.size(), 1U);
  EXPECT_EQ(falloff_of(seat.studio.shown().history[0]->strokes), 7);

  seat.studio.preferences().panels.closed = {"tool", "view"};
  seat.studio.select_layer(0);
  seat.frame();
  const int entry = 0;
  const ImGuiID in_entry = ImGui::FindWindowByName("History")->ID;
  set_to(ImHashStr("Falloff", 0, ImHashData(&entry, sizeof entry, in_entry)), false);
  EXPECT_EQ(falloff_of(seat.studio.layers().strokes), 3);
  EXPECT_EQ(falloff_of(seat.studio.shown().history[0]->strokes), 7) << "not before it is applied";
  EXPECT_EQ(seat.studio.settings().falloff, 7);

  seat.studio.preferences().panels.closed = {};
  seat.studio.settings().tool = &studio_tool(ToolUse::mask);
  seat.frame();
  EXPECT_FALSE(seat.place_of(of_tool)) << "a mask blends nothing";
}

TEST_F(InterfaceTest, ACommaInAFieldIsAPointAndANumberBeyondItsSliderAsks) {
  PinVertex seat(options(), 1280, 900);
  open_ball(seat);
  const ImGuiID radius = ImGui::FindWindowByName("Settings")->GetID("Radius");
  const auto type = [&](const std::string& text) {
    const auto place = seat.place_of(radius);
    ASSERT_TRUE(place);
    ImGui::GetIO().KeyCtrl = true;
    seat.move(place->first, place->second);
    ImGui::GetIO().KeyCtrl = true;
    seat.press(place->first, place->second);
    ImGui::GetIO().KeyCtrl = false;
    seat.release(place->first, place->second);
    seat.frame();
    for (const char c : text) seat.type(std::string(1, c));
    seat.key("Enter");
    seat.frame();
  };
  type("0,25");
  EXPECT_NEAR(seat.studio.settings().radius, 0.25, 1e-9);
  EXPECT_FALSE(PinVertex::is_list_open());
  type("55");
  EXPECT_NEAR(seat.studio.settings().radius, 0.25, 1e-9) << "not before it is confirmed";
  EXPECT_TRUE(PinVertex::is_list_open());
}

// However many settings there are, the history keeps its share of the panel, and its last line is seen.
TEST_F(InterfaceTest, TheHistoryIsSeenBelowTheSettings) {
  PinVertex seat(options(), 1280, 800);
  open_ball(seat);
  const float whole = seat.interface.layout().side_panel.height();
  seat.frame();
  const float first = PinVertex::area_of("History").height();
  EXPECT_LT(first, 0.2F * whole) << "as little as it needs";
  for (int i = 0; i < 20; ++i) seat.drag(480, 450, 480, 300 + 10 * i);
  ASSERT_GT(seat.studio.shown().history.size(), 15u);
  seat.frame();
  seat.frame();
  const Area history = PinVertex::area_of("History");
  EXPECT_NEAR(history.height(), kMinHistory * whole, 2);
  EXPECT_NEAR(PinVertex::area_of("Settings").bottom, history.top, 1);
  const ImGuiWindow* const window = ImGui::FindWindowByName("History");
  EXPECT_GT(window->ScrollMax.y, 50);
  EXPECT_NEAR(window->Scroll.y, window->ScrollMax.y, ImGui::GetTextLineHeightWithSpacing());
  seat.studio.preferences().panels.closed = {"tool", "view"};
  for (int i = 0; i < 3; ++i) seat.frame();
  EXPECT_GT(PinVertex::area_of("History").height(), 0.6F * whole) << "it takes the room that the settings leave";
}

TEST_F(InterfaceTest, NumbersAtThePointerStayBesideThePanel) {
  PinVertex seat(options(), 1280, 800);
  open_ball(seat);
  const Area& free = seat.interface.layout().free;
  seat.move(480, 400);
  seat.press(480, 400);
  for (const float x : {600.0F, free.right - 30, free.right - 2}) {
    seat.move(x, 400);
    const ImDrawList& drawn = *ImGui::GetBackgroundDrawList();
    ASSERT_GT(drawn.VtxBuffer.Size, 0);
    for (const ImDrawVert& vertex : drawn.VtxBuffer) EXPECT_LE(vertex.pos.x, free.right + 1) << x;
  }
  seat.release(free.right - 2, 400);
}

TEST_F(InterfaceTest, StatisticsStayBesideTheSidePanelAndTheKeysCoverIt) {
  for (const auto& [width, height, unit] : kWindows) {
    PinVertex seat(options(), width, height, unit);
    open_ball(seat);
    seat.studio.view().statistics = true;
    for (int i = 0; i < 4; ++i) seat.frame();
    const Area& free = seat.interface.layout().free;
    const Area statistics = PinVertex::area_of("Statistics");
    EXPECT_GT(statistics.width(), 0);
    EXPECT_GE(statistics.left, free.left);
    EXPECT_LE(statistics.right, free.right);
    EXPECT_LE(statistics.bottom, free.bottom);
    EXPECT_EQ(ImGui::FindWindowByName("Statistics")->ScrollMax.x, 0);
    seat.studio.view().help = true;
    for (int i = 0; i < 4; ++i) seat.frame();
    const Area keys = PinVertex::area_of("Keys");
    EXPECT_GE(keys.left, 0);
    EXPECT_LE(keys.right, static_cast<float>(width));
    if (width == 1440 && unit == 1) {
      EXPECT_EQ(ImGui::FindWindowByName("Keys")->ScrollMax.y, 0) << "all keys at once";
    }
    const ImDrawList& list = *ImGui::FindWindowByName("Keys")->DrawList;
    EXPECT_EQ(list.VtxBuffer.front().col >> IM_COL32_A_SHIFT, 255U) << "its background is opaque";
    seat.key("Escape");
    seat.frame();
    EXPECT_FALSE(seat.studio.view().help);
    seat.studio.close();
  }
}

TEST_F(InterfaceTest, ACommandIsFoundAndDoneWithTheKeyboard) {
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  seat.key("F3");
  seat.frame();
  ASSERT_TRUE(seat.interface.is_asking());
  seat.frame();
  seat.type("wiref");
  seat.key("Enter");
  seat.frame();
  EXPECT_FALSE(seat.interface.is_asking());
  EXPECT_TRUE(seat.studio.view().wireframe);
  EXPECT_EQ(seat.studio.settings().tool, &studio_tools().front()) << "letters were words, not keys";
  EXPECT_EQ(found_actions("turntable").front(), Action::turntable);
  EXPECT_EQ(found_actions("reference image").front(), Action::reference_image);
  // Arrows choose among what was found.
  const std::vector<Action> found = found_actions("mirror in");
  ASSERT_GE(found.size(), 3u);
  seat.key("F3");
  seat.frame();
  seat.frame();
  seat.type("mirror in");
  seat.key("Down");
  seat.key("Enter");
  seat.frame();
  EXPECT_EQ(found[1], Action::mirror_y);
  EXPECT_TRUE(seat.studio.settings().mirror[1]);
  EXPECT_FALSE(seat.studio.settings().mirror[0]);
  // Escape leaves everything as it was, and what opens a dialog opens it.
  seat.key("F3");
  seat.frame();
  seat.key("Escape");
  seat.frame();
  EXPECT_FALSE(seat.interface.is_asking());
  seat.key("F3");
  seat.frame();
  seat.frame();
  seat.type("new shape");
  seat.key("Enter");
  seat.frame();
  EXPECT_GT(PinVertex::area_of("New shape").width(), 0) << "the dialog of the command";
}

TEST_F(InterfaceTest, ThePanelIsResizedAtItsEdgeAndComesBackAsItWasLeft) {
  {
    PinVertex seat(options(), 1440, 900);
    open_ball(seat);
    const Area before = PinVertex::area_of("Settings");
    EXPECT_NEAR(before.width(), kPanelWidth, 1);
    seat.drag(before.left + 2, 500, before.left - 98, 500);
    EXPECT_TRUE(seat.studio.shown().history.empty()) << "the panel took the drag";
    EXPECT_NEAR(PinVertex::area_of("Settings").width(), kPanelWidth + 100, 3);
    for (int i = 0; i < 20; ++i) seat.frame();
    EXPECT_EQ(ImGui::FindWindowByName("Settings")->ScrollMax.y, 0);
    seat.key("Shift+T");
    seat.key("L");
    seat.click(before.left + 60, before.top + 20);  // folds the tool's settings
    seat.studio.close();
  }
  PinVertex seat(options(), 1440, 900);
  open_ball(seat);
  EXPECT_NEAR(PinVertex::area_of("Settings").width(), kPanelWidth + 100, 3);
  EXPECT_TRUE(seat.studio.view().tool_labels);
  EXPECT_FALSE(seat.studio.view().history);
  EXPECT_EQ(seat.studio.preferences().panels.closed, std::vector<std::string>{"tool"});
  EXPECT_EQ(errors(seat.studio), "");
}

TEST_F(InterfaceTest, NamesOfTheToolsFitBesideTheirIcons) {
  for (const double unit : {1.0, 2.0}) {
    PinVertex seat(options(), 1440, 900, unit);
    open_ball(seat);
    const float narrow = PinVertex::area_of("Tools").width();
    seat.key("Shift+T");
    seat.frame();
    EXPECT_NEAR(PinVertex::area_of("Tools").width(), narrow + kToolLabelWidth * unit, 1.5);
    EXPECT_EQ(ImGui::FindWindowByName("Tools")->ScrollMax.x, 0);
    for (const StudioTool& tool : studio_tools()) {
      EXPECT_LT(ImGui::CalcTextSize(tool.name.c_str()).x, kToolLabelWidth * unit) << tool.name;
    }
    seat.key("Shift+T");
    seat.frame();
    seat.studio.close();
  }
}

}  // namespace
}  // namespace knead::studio
