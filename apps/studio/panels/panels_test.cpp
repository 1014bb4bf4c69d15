// The list of pins, files and the dialogs that ask for them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <thread>
#include <tuple>

#include "panels/file_dialog.h"
#include "panels/interface_fixture.h"
#include "panels/panels.h"

namespace knead::studio::panels_test {

namespace {

using PinsListTest = StudioTest;

TEST_F(PinsListTest, ChangesPins) {
  ShownPanels panels(options(), 1440, 900);
  panels.studio.preferences().panels.closed.clear();
  run(panels.studio, R"({"new": "sphere", "vertices": 2562}
{"key": "Alt+1"}
{"key": "Home"})");
  panels.frame();
  panels.key("P");
  panels.studio.tools().settings().pose = PoseMode::exact;
  for (const double x : {480.0, 560.0, 640.0}) panels.click(x, 450);
  ASSERT_EQ(panels.studio.tools().placed().pins.size(), 3u);
  panels.frame();
  const auto list = [] {
    for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
      if (std::string(window->Name).find("##pins") != std::string::npos) return window;
    }
    return static_cast<const ImGuiWindow*>(nullptr);
  };
  ASSERT_TRUE(list() != nullptr);
  const double left = list()->Pos.x;
  constexpr double kRows = 6;
  const double row = ImGui::GetFrameHeightWithSpacing();
  const double second = list()->Pos.y + 1.5 * row;
  const double font = ImGui::GetFontSize();

  panels.click(left + 0.5 * font, second);
  EXPECT_FALSE(panels.studio.tools().placed().pins[1].holds);
  EXPECT_EQ(panels.studio.pointed_pin(), 1u) << "the pin of the row is lit";
  panels.click(left + 0.5 * font, second);
  EXPECT_TRUE(panels.studio.tools().placed().pins[1].holds);

  const Vec3d before = panels.studio.tools().placed().pins[1].place;
  panels.click(left + 4.5 * font, second);
  panels.type(std::to_string(before.x + 0.125));
  panels.key("Enter");
  panels.frame();
  ASSERT_EQ(panels.studio.document().shown().history.size(), 1u);
  const auto stroke = std::get<PinsStroke>(panels.studio.document().shown().history[0]->strokes[0].stroke);
  EXPECT_NEAR(stroke.to[1].x - before.x, 0.125, 1e-6);  // six digits were typed
  EXPECT_EQ(stroke.to[1].y, before.y);
  EXPECT_EQ(stroke.to[1].z, before.z);

  panels.frame();
  panels.click(left + 2.2 * font, second);
  EXPECT_TRUE(panels.studio.tools().placed().pins[1].is_selected);
  const ImVec2 place = list()->Pos;
  ASSERT_TRUE(panels.click_item("Settings", "Remove"));
  EXPECT_EQ(panels.studio.tools().placed().pins.size(), 2u);
  EXPECT_EQ(panels.studio.document().shown().history.size(), 1u);
  ASSERT_TRUE(panels.click_item("Settings", "Clear"));
  panels.frame();
  EXPECT_TRUE(panels.studio.tools().placed().pins.empty());
  EXPECT_EQ(list()->Pos.y, place.y);
  EXPECT_EQ(list()->Size.y, kRows * row + 2) << "as high as before: what is below has not moved";
  panels.move(480, 700);
  EXPECT_FALSE(panels.studio.pointed_pin());
}

}  // namespace

namespace {

LayoutQuery query_of(float width, float height, float unit) {
  LayoutQuery query{width, height, unit};
  query.bar = 23 * unit;
  query.item = 38 * unit;
  query.item_gap = 2 * unit;
  query.tools = 19;
  query.tool_pairs = 11;
  query.panel_width = kPanelWidth;
  return query;
}

TEST(Layout, PanelsStayInTheWindowAndApart) {
  for (const float width : {480.0F, 800.0F, 1440.0F, 3840.0F}) {
    for (const float height : {320.0F, 500.0F, 900.0F, 2160.0F}) {
      for (const float unit : {0.5F, 1.0F, 2.0F, 3.0F}) {
        for (const bool labels : {false, true}) {
          LayoutQuery query = query_of(width, height, unit);
          query.labels = labels;
          const Layout layout = layout_of(query);
          if (layout.is_compact) continue;
          EXPECT_GE(layout.tool_bar.left, 0);
          EXPECT_GE(layout.tool_bar.top, query.bar);
          EXPECT_LE(layout.tool_bar.bottom, height - query.bar);
          EXPECT_LE(layout.tool_bar.right, layout.side_panel.left);
          EXPECT_LE(layout.side_panel.right, width);
          EXPECT_LE(layout.side_panel.bottom, height - query.bar);
          EXPECT_LE(layout.side_panel.width(), 0.45F * width + 0.01F);
          EXPECT_GE(layout.free.width(), 0);
          EXPECT_GE(layout.free.height(), 0);
        }
      }
    }
  }
}

TEST(Layout, APhoneAndATabletHaveOneBarAtTheBottom) {
  for (const auto& [width, height, unit] :
       {std::tuple{390.0F, 844.0F, 1.0F}, {1170.0F, 2532.0F, 3.0F}, {1024.0F, 1366.0F, 1.0F}, {480.0F, 320.0F, 1.0F}}) {
    for (const bool side : {false, true}) {
      LayoutQuery query = query_of(width, height, unit);
      query.top_bar = 35 * unit;
      query.side = side;
      const Layout layout = layout_of(query);
      ASSERT_TRUE(layout.is_compact);
      EXPECT_EQ(layout.tool_bar.width(), 0);
      EXPECT_EQ(layout.top_bar.width(), 0);
      EXPECT_EQ(layout.bottom_bar.bottom, height);
      EXPECT_EQ(layout.bottom_bar.width(), width);
      EXPECT_LE(layout.free.bottom, layout.bottom_bar.top);
      EXPECT_EQ(layout.side_panel.height() > 0, side);
      if (!side) continue;
      EXPECT_GE(layout.side_panel.left, 0);
      EXPECT_LE(layout.side_panel.right, width);
      EXPECT_LE(layout.side_panel.bottom, layout.bottom_bar.top);
      EXPECT_TRUE(layout.free.right <= layout.side_panel.left || layout.free.bottom <= layout.side_panel.top);
    }
  }
  EXPECT_FALSE(layout_of(query_of(1280, 800, 1)).is_compact);
}

TEST(Layout, TheToolBarScrollsWhereItDoesNotFit) {
  EXPECT_EQ(layout_of(query_of(1440, 900, 1)).tool_columns, 1);
  EXPECT_EQ(layout_of(query_of(1280, 720, 1)).tool_columns, 2);
  EXPECT_FALSE(layout_of(query_of(1280, 720, 1)).tool_bar_scrolls);
  EXPECT_TRUE(layout_of(query_of(800, 450, 1)).tool_bar_scrolls);
  EXPECT_TRUE(layout_of(query_of(1440, 900, 2)).tool_bar_scrolls);
}

TEST(Layout, ThePersonChoosesTheWidthOfThePanelWithinLimits) {
  LayoutQuery query = query_of(1440, 900, 1);
  query.panel_width = 400;
  EXPECT_FLOAT_EQ(layout_of(query).side_panel.width(), 400);
  query.panel_width = 5;
  EXPECT_FLOAT_EQ(layout_of(query).side_panel.width(), kMinPanelWidth);
  query.panel_width = 5000;
  EXPECT_FLOAT_EQ(layout_of(query).side_panel.width(), kMaxPanelWidth);
}

TEST(Layout, MarginsAreWhatIsNotFree) {
  const Layout layout = layout_of(query_of(1440, 900, 1));
  const Margins margins = margins_of(layout, 1440, 900);
  EXPECT_NEAR(margins.right, 1440 - layout.side_panel.left, 0.5);
  EXPECT_NEAR(margins.left, layout.tool_bar.right, 0.5);
  EXPECT_EQ(margins.top, 23);
  EXPECT_EQ(margins.bottom, 23);
  LayoutQuery hidden = query_of(1440, 900, 1);
  hidden.panels = false;
  EXPECT_EQ(margins_of(layout_of(hidden), 1440, 900), (Margins{0, 23, 0, 23}));
}

}  // namespace

namespace {

// --- fingers ---------------------------------------------------------------------------------------------------------

class FingersTest : public StudioTest {
 protected:
  void open_ball(ShownPanels& panels, int width, int height) const {
    panels.gui.set_touch(true);
    panels.resize(width, height);
    run(panels.studio, R"({"new": "sphere", "vertices": 2562}
{"key": "Home"})");
    panels.frame();
    panels.frame();
  }
};

// Where the middle of the ball is seen, from the middle of the free part of the picture.
Pixel from_middle(ShownPanels& panels) {
  const Area& free = panels.interface.layout().free;
  const Pixel at = pixel_of(panels.studio.view().screen(), {0, 0, 0}).value();
  return {at.x - 0.5 * (free.left + free.right), at.y - 0.5 * (free.top + free.bottom)};
}

// How high the item at a place is for the pointer.
double height_at(ShownPanels& panels, double x, double y) {
  panels.move(x, y);
  const ImGuiID item = ImGui::GetCurrentContext()->HoveredId;
  if (item == 0) return 0;
  double height = 1;
  for (const double step : {-1.0, 1.0}) {
    for (double at = y + step;; at += step, ++height) {
      panels.move(x, at);
      if (at < 0 || ImGui::GetCurrentContext()->HoveredId != item) break;
    }
  }
  return height;
}

TEST_F(FingersTest, WhatTheyPressIsHighEnough) {
  for (const auto& [width, height] : {std::pair{390, 844}, {844, 390}, {820, 1180}, {1180, 820}}) {
    ShownPanels panels(options(), width, height);
    open_ball(panels, width, height);
    ASSERT_TRUE(panels.interface.layout().is_compact);
    EXPECT_GE(height_at(panels, 20, 20), 37);  // File
    panels.click(20, 20);
    panels.frame();
    const ImGuiWindow* const menu = ShownPanels::popup();
    ASSERT_NE(menu, nullptr);
    EXPECT_GE(height_at(panels, menu->Pos.x + 30, menu->Pos.y + 70), 37);
    panels.key("Escape");
    for (const char* name : {"##tools", "Undo", "##Ctrl", "More"}) {
      ImGuiWindow* const bar = ImGui::FindWindowByName("Bottom bar");
      const auto at = panels.place_in(ShownPanels::area_of("Bottom bar"), bar->GetID(name));
      ASSERT_TRUE(at) << name;
      EXPECT_GE(height_at(panels, at->first, at->second), 44) << name;
    }
    const Pixel before = from_middle(panels);
    ASSERT_TRUE(panels.click_item("Bottom bar", "More"));
    for (int i = 0; i < 4; ++i) panels.frame();
    const Area sheet = panels.interface.layout().side_panel;
    EXPECT_GE(height_at(panels, sheet.left + 100, sheet.top + 100), 37);
    EXPECT_GT(panels.interface.layout().free.height(), 0.25 * height);
    EXPECT_NEAR(from_middle(panels).x, before.x, 2) << "the shape is seen beside the sheet";
    EXPECT_NEAR(from_middle(panels).y, before.y, 2);
    panels.studio.document().close();
  }
}

TEST_F(FingersTest, TurnTheDeviceAndTheShapeStaysAsLarge) {
  ShownPanels panels(options(), 390, 844);
  open_ball(panels, 390, 844);
  const auto place = [&](const Vec3d& p) { return pixel_of(panels.studio.view().screen(), p).value(); };
  const Vec3d up{0, 1, 0};
  const double before = place({0, 0, 0}).y - place(up).y;
  const Pixel was = from_middle(panels);
  panels.resize(844, 390);
  EXPECT_NEAR(from_middle(panels).x, was.x, 3);
  EXPECT_NEAR(from_middle(panels).y, was.y, 3);
  EXPECT_NEAR(place({0, 0, 0}).y - place(up).y, before, 0.05 * before);
  EXPECT_GT(place(up).y, panels.interface.layout().free.top);
  panels.resize(390, 500);  // the keyboard is open
  EXPECT_NEAR(place({0, 0, 0}).y - place(up).y, before, 0.05 * before);
}

TEST_F(FingersTest, ScrollAMenuThatIsHigherThanTheWindow) {
  ShownPanels panels(options(), 390, 600);
  open_ball(panels, 390, 600);
  EXPECT_FALSE(Gui::scroll(200, 300, 0)) << "the picture";
  panels.click(105, 20);  // View
  for (int i = 0; i < 3; ++i) panels.frame();
  const ImGuiWindow* const menu = ShownPanels::popup();
  ASSERT_NE(menu, nullptr);
  ASSERT_GT(menu->ScrollMax.y, 100);
  const ImVec2 at{menu->Pos.x + 20, menu->Pos.y + 60};
  EXPECT_TRUE(Gui::scroll(at.x, at.y, 0));
  Gui::scroll(at.x, at.y, -30);
  Gui::scroll(at.x, at.y, -40);  // before the next picture
  for (int i = 0; i < 2; ++i) panels.frame();
  EXPECT_NEAR(menu->Scroll.y, 70, 1);
  Gui::scroll(at.x, at.y, 500);
  for (int i = 0; i < 2; ++i) panels.frame();
  EXPECT_EQ(menu->Scroll.y, 0);
}

TEST_F(FingersTest, TwoTurnTheViewWhileCtrlIsHeld) {
  ShownPanels panels(options(), 390, 844);
  open_ball(panels, 390, 844);
  ASSERT_TRUE(panels.click_item("Bottom bar", "##Ctrl"));
  const View before = panels.studio.view().navigation().view;
  panels.move(200, 300);
  panels.frame({ButtonChanged{MouseButton::middle, true, 200, 300}});
  panels.move(240, 300);
  panels.frame({ButtonChanged{MouseButton::middle, false, 240, 300}});
  EXPECT_NE(panels.studio.view().navigation().view.yaw, before.yaw);
  EXPECT_EQ(panels.studio.view().navigation().view.height, before.height);
}

TEST_F(FingersTest, CancelByAButton) {
  ShownPanels panels(options(), 390, 844);
  open_ball(panels, 390, 844);
  const auto has_button = [] { return ShownPanels::area_of("Cancel").width() > 0; };
  EXPECT_FALSE(has_button());
  run(panels.studio, R"({"tool": "rotate"})");
  const Pixel middle = pixel_of(panels.studio.view().screen(), {0, 0, 0}).value();
  panels.click(middle.x, middle.y);
  ASSERT_TRUE(panels.studio.tools().placed().placement);
  panels.frame();
  ASSERT_TRUE(has_button());
  ASSERT_TRUE(panels.click_item("Cancel", "Remove the gizmo"));
  EXPECT_FALSE(panels.studio.tools().placed().placement);
  for (int i = 0; i < 2; ++i) panels.frame();
  EXPECT_FALSE(has_button());
}

TEST_F(FingersTest, GrabWithinPointsNotPixels) {
  for (const double unit : {1.0, 3.0}) {
    const int width = static_cast<int>(390 * unit);
    const int height = static_cast<int>(844 * unit);
    ShownPanels panels(options(), width, height, unit);
    open_ball(panels, width, height);
    panels.key("P");
    panels.studio.tools().settings().pose = PoseMode::exact;
    const Pixel middle = pixel_of(panels.studio.view().screen(), {0, 0, 0}).value();
    panels.click(middle.x, middle.y);
    ASSERT_EQ(panels.studio.tools().placed().pins.size(), 1U) << unit;
    const Pixel pin = pixel_of(panels.studio.view().screen(), panels.studio.tools().placed().pins[0].place).value();
    panels.click(pin.x + 15 * unit, pin.y);
    EXPECT_EQ(panels.studio.tools().placed().pins.size(), 1U) << "the finger met the pin";
    panels.click(pin.x + 25 * unit, pin.y);
    EXPECT_EQ(panels.studio.tools().placed().pins.size(), 2U);
    panels.studio.document().close();
  }
}

}  // namespace

namespace {

namespace fs = std::filesystem;

TEST(FileList, FoldersComeFirstAndOnlyTheFormatsAskedFor) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("knead_file_list_{}", ::getpid());
  fs::create_directories(folder / "zebra");
  fs::create_directories(folder / ".hidden");
  for (const char* name : {"b.ply", "A.PLY", "c.txt", ".d.ply"}) std::ofstream(folder / name) << "12345";
  const std::vector<std::string> shapes{".ply", ".obj"};
  const FileList list = list_files(folder, shapes);
  ASSERT_EQ(list.files.size(), 3U);
  EXPECT_EQ(list.files[0].name, "zebra");
  EXPECT_TRUE(list.files[0].is_folder);
  EXPECT_EQ(list.files[1].name, "A.PLY");
  EXPECT_EQ(list.files[1].bytes, 5U);
  EXPECT_EQ(list.files[2].name, "b.ply");
  EXPECT_EQ(list.problem, "");
  EXPECT_EQ(list_files(folder, {}).files.size(), 4U);
  EXPECT_NE(list_files(folder / "nothing", {}).problem, "");
  fs::remove_all(folder);
}

TEST(FileList, NamesGetTheExtensionThatTheyLack) {
  const std::vector<std::string> shapes{".ply", ".obj"};
  EXPECT_EQ(with_extension("hand", shapes, ".ply"), "hand.ply");
  EXPECT_EQ(with_extension("hand.OBJ", shapes, ".ply"), "hand.OBJ");
  EXPECT_EQ(with_extension("hand.v2", shapes, ".ply"), "hand.v2.ply");
  EXPECT_EQ(with_extension("hand.xyzw", shapes, ".ply"), "hand.xyzw") << "there is no such format, which is said";
}

TEST(FileList, SizesAreShort) {
  EXPECT_EQ(size_text(0), "0 bytes");
  EXPECT_EQ(size_text(999), "999 bytes");
  EXPECT_EQ(size_text(1000), "1.0 KB");
  EXPECT_EQ(size_text(41'700), "42 KB");
  EXPECT_EQ(size_text(999'700), "1.0 MB");
  EXPECT_EQ(size_text(3'400'000'000), "3.4 GB");
}

// --- keys and text between two frames

constexpr int kControl = 1;
constexpr int kShift = 2;
constexpr int kHome = 3;
Typed goes_down(int key) { return {Typed::What::down, key, key == kShift}; }
Typed goes_up(int key) { return {Typed::What::up, key, key == kShift}; }

// Returns how many of these each frame gets.
std::vector<std::size_t> frames_of(std::span<const Typed> typed) {
  std::vector<std::size_t> counts;
  while (!typed.empty()) {
    counts.push_back(typed_in_a_frame(typed));
    typed = typed.subspan(counts.back());
  }
  return counts;
}

TEST(Typed, TextComesInOneFrame) {
  std::vector<Typed> typed;
  for (const int key : {10, 11, 12}) {
    typed.push_back(goes_down(kShift));
    typed.insert(typed.end(), {goes_down(key), Typed{}, goes_up(key), goes_up(kShift)});
  }
  EXPECT_EQ(frames_of(typed), (std::vector<std::size_t>{15}));
}

TEST(Typed, AKeyIsSeenWhileItIsDownAndBeforeWhatFollows) {
  const std::vector<Typed> typed{goes_down(kControl), goes_down(9),  goes_up(9),  goes_up(kControl),  // select all
                                 goes_down(10),       Typed{},       goes_up(10),                     // replace it
                                 goes_down(kHome),    goes_up(kHome)};
  EXPECT_EQ(frames_of(typed), (std::vector<std::size_t>{2, 5, 1, 1}));
  const std::vector<Typed> selects{goes_down(kShift), goes_down(kHome), goes_up(kHome), goes_up(kShift)};
  EXPECT_EQ(frames_of(selects), (std::vector<std::size_t>{2, 2}));
  const std::vector<Typed> places{goes_down(kHome), goes_down(10), Typed{}, goes_up(10), goes_up(kHome)};
  EXPECT_EQ(frames_of(places), (std::vector<std::size_t>{1, 4}));
}

TEST(TakeFrame, AButtonChangesOnceInAFrameAndThePointerStaysThen) {
  const ButtonChanged down{MouseButton::left, true, 1, 1};
  const ButtonChanged up{MouseButton::left, false, 1, 1};
  std::vector<Event> events{PointerMoved{1, 1}, down, WheelTurned{1},     up, KeyChanged{"A", true},
                            PointerMoved{2, 2}, down, PointerMoved{3, 3}, up};
  std::vector<std::size_t> counts;
  while (!events.empty()) counts.push_back(take_frame(events).size());
  EXPECT_EQ(counts, (std::vector<std::size_t>{3, 2, 2, 2}));
  EXPECT_TRUE(take_frame(events).empty());
}

// --- the desktop's own dialog: here a script in the place of zenity
// ---------------------------------------------------

class DesktopDialogTest : public StudioTest {
 protected:
  void SetUp() override {
    StudioTest::SetUp();
    ::setenv("DISPLAY", ":0", 1);
    ::unsetenv("XDG_CURRENT_DESKTOP");
    ::setenv("PATH", (path("bin").string() + ":/usr/bin:/bin").c_str(), 1);
    fs::create_directory(path("bin"));
  }
  void TearDown() override {
    restore("DISPLAY", display_);
    restore("XDG_CURRENT_DESKTOP", desktop_);
    restore("PATH", path_);
    StudioTest::TearDown();
  }

  fs::path path(const std::string& name) const { return folder_ / name; }

  // A desktop that answers with what the lines of the script write.
  void answer(const std::string& lines) const {
    const fs::path file = path("bin") / "zenity";
    std::ofstream(file) << "#!/bin/sh\nprintf '%s\\n' \"$@\" > " << path("asked").string() << "\n" << lines << "\n";
    fs::permissions(file, fs::perms::owner_all);
  }

  // Presses the keys, and shows pictures until nothing is asked.
  static void ask(ShownPanels& panels, const std::string& keys) {
    panels.studio.preferences().desktop_dialogs = true;
    panels.key(keys);
    for (int i = 0; i < 1000 && panels.interface.is_asking(); ++i) {
      panels.frame();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    run(panels.studio, "");
    panels.frame();
  }

  std::string asked() const {
    std::ifstream file(path("asked"));
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  static std::optional<std::string> value_of(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  }
  static void restore(const char* name, const std::optional<std::string>& value) {
    if (value) {
      ::setenv(name, value->c_str(), 1);
    } else {
      ::unsetenv(name);
    }
  }

  std::optional<std::string> display_ = value_of("DISPLAY");
  std::optional<std::string> desktop_ = value_of("XDG_CURRENT_DESKTOP");
  std::optional<std::string> path_ = value_of("PATH");
};

TEST_F(DesktopDialogTest, OpensAndSavesWhatTheDesktopAnswers) {
  ShownPanels panels(options(), 1280, 800);
  const Mesh ball = make_shape(ShapeKind::sphere, 500);
  write_mesh(path("ball.ply"), ball, {});
  answer("echo " + path("ball.ply").string());
  ask(panels, "Ctrl+O");
  EXPECT_EQ(panels.studio.document().shown().state.positions.size(), ball.vertex_count());
  EXPECT_NE(asked().find("--file-filter=*.ply"), std::string::npos) << asked();
  EXPECT_EQ(asked().find("--save"), std::string::npos);

  answer("echo " + path("mine").string());
  ask(panels, "Ctrl+Shift+S");
  EXPECT_TRUE(fs::exists(path("mine.knead"))) << "the extension is added";
  EXPECT_NE(asked().find("--save"), std::string::npos);
}

TEST_F(DesktopDialogTest, ACancelledDialogChangesNothing) {
  ShownPanels panels(options(), 1280, 800);
  answer("exit 1");
  ask(panels, "Ctrl+O");
  EXPECT_FALSE(panels.interface.is_asking());
  EXPECT_EQ(panels.studio.document().shown().opened, 0u);
}

TEST_F(DesktopDialogTest, EscapeClosesTheDesktopsDialog) {
  ShownPanels panels(options(), 1280, 800);
  answer("exec sleep 100");
  panels.studio.preferences().desktop_dialogs = true;
  panels.key("Ctrl+O");
  panels.frame();
  EXPECT_TRUE(panels.interface.is_asking());
  panels.key("Escape");
  panels.frame();
  EXPECT_FALSE(panels.interface.is_asking());
}

TEST_F(DesktopDialogTest, WithoutADesktopStudioAsks) {
  ShownPanels panels(options(), 1280, 800);
  ::setenv("PATH", path("bin").c_str(), 1);
  panels.studio.preferences().desktop_dialogs = true;
  panels.key("Ctrl+O");
  panels.frame();
  EXPECT_TRUE(panels.interface.is_asking());
  ASSERT_NE(ImGui::FindWindowByName("Open a shape or a session"), nullptr);
  panels.key("Escape");
}

TEST_F(DesktopDialogTest, AFileDialogTakesWhatIsBroughtToIt) {
  ShownPanels panels(options(), 1280, 800);
  std::vector<fs::path> files;
  for (const char* name : {"one.obj", "two.obj"}) {
    files.push_back(folder_ / name);
    std::ofstream(files.back().string()) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  }
  const auto bring = [&](std::ptrdiff_t count) {
    panels.frame();
    EXPECT_TRUE(panels.interface.is_asking());
    panels.frame({FilesDropped{{files.begin(), files.begin() + count}}});
    for (int i = 0; i < 3; ++i) panels.frame();
    EXPECT_FALSE(panels.interface.is_asking());
    EXPECT_EQ(errors(panels.studio), "");
    return panels.studio.document().shown().objects.list.size();
  };
  panels.interface.welcome();
  EXPECT_EQ(bring(1), 1u);
  panels.key("Ctrl+O");
  EXPECT_EQ(bring(1), 1u);
  panels.key("Ctrl+Alt+O");
  EXPECT_EQ(bring(2), 3u);
  panels.key("Ctrl+E");
  panels.frame({FilesDropped{files}});
  EXPECT_TRUE(panels.interface.is_asking()) << "a file to write is none that is there";
  EXPECT_EQ(panels.studio.document().shown().objects.list.size(), 3u);
}

}  // namespace

}  // namespace knead::studio::panels_test
