// The settings at the pointer, the welcome sheet and the tour, and the bar of a phone, driven by the events of a
// window.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "document/layers.h"
#include "knead/editor/workbench.h"
#include "panels/interface.h"
#include "panels/interface_fixture.h"

namespace knead::studio::tool_bar_test {
namespace {

class ToolBarTest : public StudioTest {
 protected:
  void open_ball(ShownPanels& panels) const {
    run(panels.studio, R"({"new": "sphere", "vertices": 2562}
{"key": "Alt+1"}
{"key": "Home"}
{"set": {"start": "surface"}})");
    panels.frame();
    panels.frame();
  }

  static Pixel middle_of(const Studio& studio) { return pixel_of(studio.view().screen(), {0, 0, 0}).value(); }

  // Types a number into a slider.
  static void type_into(ShownPanels& panels, const char* window, const char* slider, const std::string& text) {
    ImGuiWindow& in = *ImGui::FindWindowByName(window);
    const Area area{in.Pos.x, in.Pos.y, in.Pos.x + in.Size.x, in.Pos.y + in.Size.y};
    const auto place = panels.place_in(area, in.GetID(slider));
    ASSERT_TRUE(place) << slider;
    set_modifiers({.ctrl = true});
    panels.press(place->first, place->second);
    set_modifiers({});
    panels.release(place->first, place->second);
    panels.frame();
    for (const char c : text) panels.type(std::string(1, c));
    panels.key("Enter");
    panels.frame();
  }
};

TEST_F(ToolBarTest, NamesOfTheToolsFitBesideTheirIcons) {
  for (const double unit : {1.0, 2.0}) {
    ShownPanels panels(options(), static_cast<int>(1440 * unit), static_cast<int>(1200 * unit),
                       unit);  // high enough for one column
    open_ball(panels);
    const float narrow = ShownPanels::area_of("Tools").width();
    panels.key("Shift+T");
    panels.frame();
    EXPECT_NEAR(ShownPanels::area_of("Tools").width(), narrow + kToolLabelWidth * unit, 1.5);
    EXPECT_EQ(ImGui::FindWindowByName("Tools")->ScrollMax.x, 0);
    for (const StudioTool& tool : studio_tools()) {
      EXPECT_LT(ImGui::CalcTextSize(tool.name.c_str()).x, kToolLabelWidth * unit) << tool.name;
    }
    panels.key("Shift+T");
    panels.frame();
    panels.studio.document().close();
  }
}

// A picture may be so late that the pointer is elsewhere by then, and the button let go.
TEST_F(ToolBarTest, AClickCountsWhereItWas) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  const auto middle = middle_of(panels.studio);
  const Area bar = panels.interface.layout().tool_bar;
  const double x = bar.left + 0.3 * (bar.right - bar.left);
  std::vector<const StudioTool*> by_hand;
  std::vector<const StudioTool*> late;
  for (double y = bar.top + 12; y < bar.bottom; y += 12) {
    panels.click(x, y);
    by_hand.push_back(panels.studio.tools().settings().tool);
  }
  for (double y = bar.top + 12; y < bar.bottom; y += 12) {
    std::vector<Event> events{PointerMoved{x, y}, ButtonChanged{MouseButton::left, true, x, y},
                              ButtonChanged{MouseButton::left, false, x, y}, PointerMoved{middle.x, middle.y}};
    while (!events.empty()) panels.frame(take_frame(events));
    late.push_back(panels.studio.tools().settings().tool);
  }
  EXPECT_EQ(late, by_hand);
  EXPECT_GT(std::set<const StudioTool*>(late.begin(), late.end()).size(), 8U) << "of 10 in the first column";
}

TEST_F(ToolBarTest, LengthsAreAbsolute) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  ToolSettings& settings = panels.studio.tools().settings();
  run(panels.studio, R"({"tool": "paint"})");
  settings.radius = 0.5;
  panels.frame();
  type_into(panels, "Tool", "##Depth", "0.1");
  EXPECT_NEAR(settings.depth, 0.2, 1e-12);
  run(panels.studio, R"({"tool": "stamp"})");
  settings.radius = 0.5;
  panels.frame();
  type_into(panels, "Tool", "##Size", "0.75");
  EXPECT_NEAR(settings.stamp_size, 1.5, 1e-12);
  type_into(panels, "Tool", "##Radius", "0.25");
  EXPECT_NEAR(settings.radius, 0.25, 1e-12);
  EXPECT_NEAR(settings.stamp_size, 1.5, 1e-12) << "the size grows with the radius";
}

TEST_F(ToolBarTest, ASlidersTooltipCanBeRead) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  ImGuiWindow& bar = *ImGui::FindWindowByName("Tool");
  const Area area{bar.Pos.x, bar.Pos.y, bar.Pos.x + bar.Size.x, bar.Pos.y + bar.Size.y};
  const auto place = panels.place_in(area, bar.GetID("##Radius"));
  ASSERT_TRUE(place);
  panels.frame({PointerMoved{place->first, place->second}});
  for (int i = 0; i < 4; ++i) panels.frame();
  const ImGuiWindow* const tooltip = ImGui::FindWindowByName("##Tooltip_00");
  ASSERT_NE(tooltip, nullptr);
  EXPECT_TRUE(tooltip->Active);
  const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
  const ImVector<ImDrawVert>& drawn = tooltip->DrawList->VtxBuffer;
  EXPECT_GT(std::count_if(drawn.begin(), drawn.end(), [&](const ImDrawVert& v) { return v.col == ink; }), 40);
}

TEST_F(ToolBarTest, TheBarHasTheMirrorsAndWhatRarelyChangesIsFolded) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  EXPECT_EQ(panels.studio.preferences().panels.closed, (std::vector<std::string>{"tool", "view"}));
  EXPECT_LT(ShownPanels::area_of("Settings").height(), 90) << "two headings";
  ASSERT_TRUE(panels.click_item("Tool", "Y##mirror"));
  EXPECT_TRUE(panels.studio.tools().settings().mirror[1]);
  ASSERT_TRUE(panels.click_item("Tool", "Y##mirror"));
  EXPECT_FALSE(panels.studio.tools().settings().mirror[1]);
  // No setting of any tool is cut off at the window's right end.
  const ImGuiID mirror = ImGui::FindWindowByName("Tool")->GetID("X##mirror");
  const auto place = panels.place_in(panels.interface.layout().top_bar, mirror);
  for (const StudioTool& tool : studio_tools()) {
    panels.studio.perform(action_of(tool));
    panels.frame();
    panels.frame();
    EXPECT_LE(ImGui::FindWindowByName("Tool")->ContentSize.x, 1280) << tool.name;
    panels.click(place->first, place->second);
    EXPECT_TRUE(panels.studio.tools().settings().mirror[0]) << tool.name << ": the mirrors stay where they are";
    panels.studio.tools().settings().mirror = {};
  }
}

TEST_F(ToolBarTest, ABoxOrLassoOfAMaskHasNoRadius) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  run(panels.studio, R"({"tool": "mask"})");
  for (const MaskMode mode : {MaskMode::paint, MaskMode::lasso, MaskMode::box}) {
    panels.studio.tools().settings().mask_mode = mode;
    panels.frame();
    ImGuiWindow& bar = *ImGui::FindWindowByName("Tool");
    for (const char* label : {"##Radius", "##Inner ratio"}) {
      const bool is_there = panels.place_in(panels.interface.layout().top_bar, bar.GetID(label)).has_value();
      EXPECT_EQ(is_there, mode == MaskMode::paint) << label;
    }
  }
}

TEST_F(ToolBarTest, ARightClickOpensTheSameSettingsAtThePointer) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  panels.right_click(middle.x, middle.y);
  ASSERT_NE(ShownPanels::popup(), nullptr);
  panels.frame();
  ImGuiWindow& menu = *ShownPanels::popup();
  EXPECT_NEAR(menu.Pos.x + 0.5 * menu.Size.x, middle.x, 0.5 * menu.Size.x);
  EXPECT_NEAR(menu.Pos.y, middle.y, 2);
  ASSERT_TRUE(panels.click_item(&menu, "Z##mirror"));
  EXPECT_TRUE(panels.studio.tools().settings().mirror[2]);
  const auto radius = panels.place_in({menu.Pos.x, menu.Pos.y, menu.Pos.x + menu.Size.x, menu.Pos.y + menu.Size.y},
                                      menu.GetID("##Radius"));
  ASSERT_TRUE(radius);
  const double before = panels.studio.tools().settings().radius;
  panels.drag(radius->first, radius->second, radius->first + 60, radius->second);
  EXPECT_NE(panels.studio.tools().settings().radius, before);
  panels.key("Escape");
  panels.frame();
  EXPECT_EQ(ShownPanels::popup(), nullptr);
  EXPECT_TRUE(panels.studio.document().shown().history.empty());
}

TEST_F(ToolBarTest, ARightButtonThatCancelsOrIsDraggedOpensNothing) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  panels.move(middle.x, middle.y);
  panels.press(middle.x, middle.y);
  panels.move(middle.x + 40, middle.y);
  panels.frame({ButtonChanged{MouseButton::right, true, middle.x + 40, middle.y}});
  EXPECT_FALSE(panels.studio.gesture());
  panels.frame({ButtonChanged{MouseButton::right, false, middle.x + 40, middle.y}});
  panels.release(middle.x + 40, middle.y);
  panels.frame();
  EXPECT_EQ(ShownPanels::popup(), nullptr) << "it has cancelled the drag";
  panels.frame({ButtonChanged{MouseButton::right, true, middle.x, middle.y}});
  panels.move(middle.x + 50, middle.y);
  panels.frame({ButtonChanged{MouseButton::right, false, middle.x + 50, middle.y}});
  panels.frame();
  EXPECT_EQ(ShownPanels::popup(), nullptr) << "it was dragged";
  panels.frame({KeyChanged{"F", true, {}}});
  panels.frame({KeyChanged{"F", false, {}}});
  panels.right_click(middle.x + 30, middle.y);
  EXPECT_EQ(ShownPanels::popup(), nullptr) << "it has given up the number";
}

TEST(Tools, EachHasAGroupAndOneSentence) {
  for (const StudioTool& tool : studio_tools()) {
    const std::string tip = tool.tip;
    EXPECT_EQ(std::count(tip.begin(), tip.end(), '.'), 1) << tool.name;
    EXPECT_EQ(tip.back(), '.') << tool.name;
    EXPECT_LT(tip.size(), 80U) << tool.name;
  }
  for (const ToolGroup group : kToolGroups) {
    EXPECT_TRUE(std::any_of(studio_tools().begin(), studio_tools().end(), [&](const StudioTool& tool) {
      return tool.group == group;
    })) << name_of(group);
  }
}

TEST_F(ToolBarTest, AnErrorOffersTheOneThingToDo) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  panels.studio.document().save("/proc/nowhere/a.knead");
  for (int i = 0; i < 3; ++i) panels.frame();
  ASSERT_EQ(panels.interface.messages().messages.size(), 1U);
  ImGuiWindow* const messages = ImGui::FindWindowByName("Messages");
  const int number = 0;
  const ImGuiID button = ImHashStr("Save as...", 0, ImHashData(&number, sizeof number, messages->ID));
  const auto place = panels.place_in(ShownPanels::area_of("Messages"), button);
  ASSERT_TRUE(place);
  panels.click(place->first, place->second);
  EXPECT_TRUE(panels.interface.is_asking()) << "for a file";
  EXPECT_TRUE(panels.interface.messages().messages.empty());
}

// At 1280 x 720 every tool is seen, with names and without; in a narrow bar every setting of every tool.
TEST_F(ToolBarTest, ASmallWindowHasAllToolsAndAllTheirSettings) {
  {
    ShownPanels panels(options(), 1280, 720);
    open_ball(panels);
    for (int names = 0; names < 2; ++names) {
      panels.frame();
      EXPECT_EQ(ImGui::FindWindowByName("Tools")->ScrollMax.y, 0) << names;
      EXPECT_LT(ShownPanels::area_of("Tools").bottom, 720 - panels.gui.bar_height());
      panels.key("Shift+T");
    }
    panels.studio.document().close();
  }
  ShownPanels panels(options(), 1280, 800, 2);
  open_ball(panels);
  for (const StudioTool& tool : studio_tools()) {
    panels.studio.perform(action_of(tool));
    for (int i = 0; i < 2; ++i) panels.frame();
    ImGuiWindow& bar = *ImGui::FindWindowByName("Tool");
    const Area area{bar.Pos.x, bar.Pos.y, bar.Pos.x + bar.Size.x, bar.Pos.y + bar.Size.y};
    EXPECT_LE(bar.ContentSize.x, 1280) << tool.name;
    if (has_drag_mode(panels.studio.tools().settings())) {
      EXPECT_TRUE(panels.place_in(area, bar.GetID("##drag"))) << tool.name;
    }
  }
}

TEST_F(ToolBarTest, ATooltipStandsBesideItsPanelAndGoesWhileASliderIsDragged) {
  ShownPanels panels(options(), 1280, 800);
  panels.studio.preferences().panels.closed.clear();
  open_ball(panels);
  const auto tip = [&]() -> const ImGuiWindow* {
    for (int i = 0; i < 3; ++i) panels.frame();
    const ImGuiWindow* const window = ImGui::FindWindowByName("##Tooltip_00");
    return window != nullptr && window->Active ? window : nullptr;
  };
  for (const auto& [panel, label] : {std::pair{"Tool", "##Radius"}, {"Settings", "##Radial"}}) {
    ImGuiWindow& window = *ImGui::FindWindowByName(panel);
    const Area area{window.Pos.x, window.Pos.y, window.Pos.x + window.Size.x, window.Pos.y + window.Size.y};
    const auto place = panels.place_in(area, window.GetID(label));
    ASSERT_TRUE(place) << label;
    panels.move(place->first, place->second);
    const ImGuiWindow* const shown = tip();
    ASSERT_NE(shown, nullptr) << label;
    const bool is_beside = shown->Pos.y >= area.bottom || shown->Pos.x + shown->Size.x <= area.left;
    EXPECT_TRUE(is_beside) << label;
    EXPECT_GE(shown->Pos.x, 0);
    panels.press(place->first, place->second);
    panels.move(place->first + 5, place->second);
    EXPECT_EQ(tip(), nullptr) << label;
    panels.release(place->first + 5, place->second);
  }
}

// --- welcome and tour ------------------------------------------------------------------------------------------------

TEST_F(ToolBarTest, TheWelcomeSheetOpensAnExampleWithItsTool) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  panels.interface.welcome();
  panels.frame();
  panels.frame();
  ASSERT_TRUE(panels.interface.is_asking());
  ASSERT_TRUE(panels.click_item("Welcome", "##Pose a hand"));
  EXPECT_FALSE(panels.interface.is_asking());
  panels.frame();
  EXPECT_EQ(panels.studio.document().shown().title, "new hand");
  EXPECT_EQ(panels.studio.tools().settings().tool->use, ToolUse::pose);
  // Unsaved work is asked about before it goes.
  run(panels.studio, R"({"tool": "ball"})");
  const Pixel middle = middle_of(panels.studio);
  panels.drag(middle.x, middle.y, middle.x + 30, middle.y);
  ASSERT_TRUE(panels.studio.document().shown().is_changed);
  panels.key("Ctrl+F1");
  panels.frame();
  panels.frame();
  ASSERT_TRUE(panels.click_item("Welcome", "##Engrave a bar"));
  panels.frame();
  panels.frame();
  EXPECT_GT(ShownPanels::area_of("Save the changes?").width(), 0);
  EXPECT_EQ(panels.studio.document().shown().title, "new hand");
}

TEST_F(ToolBarTest, TheWelcomeSheetClosesAndCanBeTurnedOff) {
  {
    ShownPanels panels(options(), 1280, 800);
    open_ball(panels);
    panels.interface.welcome();
    panels.frame();
    panels.frame();
    panels.key("Escape");
    panels.frame();
    EXPECT_FALSE(panels.interface.is_asking());
    panels.interface.welcome();
    panels.frame();
    panels.frame();
    panels.click(100, 700);  // beside it
    EXPECT_FALSE(panels.interface.is_asking());
    EXPECT_TRUE(panels.studio.document().shown().history.empty());
    panels.interface.welcome();
    panels.frame();
    panels.frame();
    ASSERT_TRUE(panels.click_item("Welcome", "Show this at the start"));
    panels.studio.document().close();
  }
  ShownPanels panels(options(), 1280, 800);
  panels.interface.welcome();
  EXPECT_FALSE(panels.interface.is_asking());
  EXPECT_EQ(errors(panels.studio), "");
}

TEST_F(ToolBarTest, TheTourGoesOnWithAPullAndEndsWithEscape) {
  for (const auto& [width, height] : {std::pair{1280, 800}, {390, 844}, {1024, 1366}}) {
    ShownPanels panels(options(), width, height);
    open_ball(panels);
    panels.key("Shift+F1");
    panels.frame();
    panels.frame();
    const auto step = [] {
      const Area card = ShownPanels::area_of("Tour");
      return card.width() > 0;
    };
    ASSERT_TRUE(step());
    const Pixel middle = middle_of(panels.studio);
    panels.drag(middle.x, middle.y, middle.x + 30, middle.y - 10);
    ASSERT_EQ(panels.studio.document().shown().history.size(), 1U) << "one can work during the tour";
    for (int clicks = 0; clicks < 4; ++clicks) {
      panels.frame();
      const Area card = ShownPanels::area_of("Tour");
      EXPECT_GE(card.left, 0);
      EXPECT_GE(card.top, 0);
      EXPECT_LE(card.right, static_cast<float>(width)) << clicks;
      EXPECT_LE(card.bottom, static_cast<float>(height)) << clicks;
      ASSERT_TRUE(panels.click_item("Tour", "Next")) << clicks << " at " << width;
    }
    panels.frame();
    EXPECT_FALSE(panels.click_item("Tour", "Next")) << "that was the last step but one";
    panels.key("Escape");
    panels.frame();
    panels.frame();
    EXPECT_FALSE(step());
    EXPECT_EQ(panels.studio.document().shown().history.size(), 1U);
    panels.studio.document().close();
  }
}

// --- phone and tablet ------------------------------------------------------------------------------------------------

struct Screens {
  int width;
  int height;
  double unit;
};
constexpr Screens kTouchScreens[] = {{390, 844, 1}, {1170, 2532, 3}, {1024, 1366, 1}};

void expect_within(const ShownPanels& panels, const Screens& screen) {
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    const bool is_child = (window->Flags & ImGuiWindowFlags_ChildWindow) != 0;
    if (!window->Active || is_child || window->Hidden || std::string(window->Name) == "Debug##Default") continue;
    EXPECT_GE(window->Pos.x, -1) << window->Name;
    EXPECT_GE(window->Pos.y, -1) << window->Name;
    EXPECT_LE(window->Pos.x + window->Size.x, screen.width + 1) << window->Name;
    EXPECT_LE(window->Pos.y + window->Size.y, screen.height + 1) << window->Name;
    const bool is_bar = std::string(window->Name) == "Bottom bar" || std::string(window->Name) == "Status";
    if (is_bar) {
      EXPECT_LE(window->ContentSize.x, window->Size.x + 1) << window->Name;
      EXPECT_LE(window->ContentSize.y, window->Size.y + 1) << window->Name;
    }
  }
  EXPECT_GT(panels.interface.layout().free.height(), 0.25F * static_cast<float>(screen.height));
}

TEST_F(ToolBarTest, APhoneHasItsBarAndNothingIsCutOff) {
  for (const Screens& screen : kTouchScreens) {
    ShownPanels panels(options(), screen.width, screen.height, screen.unit);
    open_ball(panels);
    EXPECT_EQ(ShownPanels::area_of("Settings").width(), 0) << "closed at first";
    EXPECT_EQ(ShownPanels::area_of("Tools").width(), 0);
    for (const StudioTool& tool : studio_tools()) {
      panels.studio.perform(action_of(tool));
      for (int i = 0; i < 3; ++i) panels.frame();
      expect_within(panels, screen);
    }
    for (const char* key : {"Ctrl+N", "Ctrl+O", "Ctrl+S", "F3", "Ctrl+F1"}) {
      panels.key(key);
      for (int i = 0; i < 4; ++i) panels.frame();
      EXPECT_TRUE(panels.interface.is_asking()) << key;
      expect_within(panels, screen);
      panels.key("Escape");
      panels.frame();
    }
    panels.studio.view().settings().help = true;
    for (int i = 0; i < 4; ++i) panels.frame();
    expect_within(panels, screen);
    EXPECT_EQ(ImGui::FindWindowByName("Keys")->ScrollMax.x, 0);
    panels.studio.view().settings().help = false;
    panels.studio.document().close();
  }
}

TEST_F(ToolBarTest, ThePhonesBarChoosesUndoesAndOpensThePanel) {
  ShownPanels panels(options(), 390, 844);
  open_ball(panels);
  ASSERT_TRUE(panels.click_item("Bottom bar", "##tools"));
  panels.frame();
  const ImGuiWindow* const tools = ShownPanels::popup();
  ASSERT_NE(tools, nullptr);
  expect_within(panels, kTouchScreens[0]);
  const StudioTool* const paint = studio_tool("paint");
  const ImGuiID button =
      ImHashStr("##tool", 0, ImHashData(static_cast<const void*>(&paint), sizeof(std::uintptr_t), tools->ID));
  const auto place =
      panels.place_in({tools->Pos.x, tools->Pos.y, tools->Pos.x + tools->Size.x, tools->Pos.y + tools->Size.y}, button);
  ASSERT_TRUE(place);
  panels.click(place->first, place->second);
  EXPECT_EQ(panels.studio.tools().settings().tool, paint);
  EXPECT_EQ(ShownPanels::popup(), nullptr);
  const Pixel middle = middle_of(panels.studio);
  panels.drag(middle.x - 20, middle.y, middle.x + 20, middle.y);
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1U);
  ASSERT_TRUE(panels.click_item("Bottom bar", "Undo"));
  EXPECT_TRUE(panels.studio.document().shown().history.empty());
  ASSERT_TRUE(panels.click_item("Bottom bar", "Redo"));
  EXPECT_EQ(panels.studio.document().shown().history.size(), 1U);
  const double radius = panels.studio.tools().settings().radius;
  ASSERT_TRUE(panels.click_item("Bottom bar", "##Radius"));
  EXPECT_NE(panels.studio.tools().settings().radius, radius);
  ASSERT_TRUE(panels.click_item("Bottom bar", "More"));
  for (int i = 0; i < 3; ++i) panels.frame();
  EXPECT_GT(ShownPanels::area_of("Settings").width(), 300);
  EXPECT_LE(ShownPanels::area_of("Status").bottom, ShownPanels::area_of("Settings").top + 1);
  expect_within(panels, kTouchScreens[0]);
  ASSERT_TRUE(panels.click_item("Bottom bar", "More"));
  panels.frame();
  EXPECT_EQ(ShownPanels::area_of("Settings").width(), 0);
}

TEST_F(ToolBarTest, CtrlAndShiftStayUntilTheyAreTappedAgain) {
  ShownPanels panels(options(), 1024, 1366);
  open_ball(panels);
  run(panels.studio, R"({"tool": "paint"})");
  const Pixel middle = middle_of(panels.studio);
  const auto stroke = [&]() -> const Stroke& {
    panels.drag(middle.x - 20, middle.y, middle.x + 20, middle.y);
    return panels.studio.document().shown().history.back()->strokes.front().stroke;
  };
  EXPECT_LT(std::get<PaintStroke>(stroke()).depth, 0);
  ASSERT_TRUE(panels.click_item("Bottom bar", "##Ctrl"));
  EXPECT_GT(std::get<PaintStroke>(stroke()).depth, 0) << "pressed in";
  EXPECT_GT(std::get<PaintStroke>(stroke()).depth, 0) << "it stays";
  ASSERT_TRUE(panels.click_item("Bottom bar", "##Ctrl"));
  ASSERT_TRUE(panels.click_item("Bottom bar", "##Shift"));
  EXPECT_TRUE(std::holds_alternative<RelaxStroke>(stroke()));
  ASSERT_TRUE(panels.click_item("Bottom bar", "##Shift"));
  EXPECT_LT(std::get<PaintStroke>(stroke()).depth, 0);
}

TEST_F(ToolBarTest, OnAPhoneMessagesStandBesideTheStatusAndTheBar) {
  ShownPanels panels(options(), 390, 844);
  open_ball(panels);
  panels.studio.document().save("/proc/nowhere/a.knead");
  panels.studio.document().open(folder_ / "missing.ply");
  for (int i = 0; i < 4; ++i) panels.frame();
  const Area messages = ShownPanels::area_of("Messages");
  const Area status = ShownPanels::area_of("Status");
  const Area bar = ShownPanels::area_of("Bottom bar");
  EXPECT_GT(messages.width(), 300);
  EXPECT_LE(messages.bottom, status.top + 1);
  EXPECT_LE(status.bottom, bar.top + 1);
  EXPECT_LE(bar.bottom, 845);
  EXPECT_EQ(ImGui::FindWindowByName("Messages")->ScrollMax.y, 0);
}

// --- the history -----------------------------------------------------------------------------------------------------

TEST_F(ToolBarTest, TheHistoryIsSearchedAndItsStrengthShowsWhatIsMade) {
  ShownPanels panels(options(), 1280, 800);
  open_ball(panels);
  const Pixel middle = middle_of(panels.studio);
  panels.studio.tools().settings().radius = 0.3;
  for (int i = 0; i < 5; ++i) panels.drag(middle.x, middle.y - 60 + 30 * i, middle.x + 20, middle.y - 60 + 30 * i);
  run(panels.studio, R"({"tool": "paint"})");
  panels.drag(middle.x, middle.y, middle.x + 20, middle.y);
  ASSERT_EQ(panels.studio.document().shown().history.size(), 6U);
  for (int i = 0; i < 3; ++i) panels.frame();
  const float all = ShownPanels::area_of("History").height();
  ASSERT_TRUE(panels.click_item("History", "##search"));
  panels.type("dab");
  for (int i = 0; i < 3; ++i) panels.frame();
  EXPECT_LT(ShownPanels::area_of("History").height(), all - 4 * ImGui::GetFrameHeight()) << "one entry is left";
  const int entry = 5;
  const ImGuiID history = ImGui::FindWindowByName("History")->ID;
  const auto name = panels.place_of(ImHashStr("###name", 0, ImHashData(&entry, sizeof entry, history)));
  ASSERT_TRUE(name);
  panels.click(name->first, name->second);
  for (int i = 0; i < 3; ++i) panels.frame();
  const auto strength = panels.place_of(ImGui::FindWindowByName("Entry")->GetID("##Strength"));
  ASSERT_TRUE(strength);
  panels.drag(strength->first, strength->second, strength->first - 400, strength->second);
  EXPECT_EQ(strength_of(panels.studio.document().shown().history[5]->strokes), 0);
  EXPECT_EQ(panels.studio.document().shown().history.size(), 6U);
}

}  // namespace
}  // namespace knead::studio::tool_bar_test
