// The sheet that Studio begins with, and the tour of one minute.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>
#include <vector>

#include "panels/interface.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

// A shape that the program makes, with the tool to begin with.
struct Example {
  const char* title;
  const char* what;  // one sentence: what to do first
  ShapeKind kind;
  ToolUse use;
  const char* tool;  // its word
};
constexpr std::array kExamples{
    Example{"Pose a hand", "Double click on a finger, and drag it.", ShapeKind::hand, ToolUse::pose, "pose"},
    Example{"Bend a figure", "Click on an arm, then drag beside the gizmo.", ShapeKind::figure, ToolUse::turn, "bend"},
    Example{"Engrave a bar", "Click on the bar, then drag the letter down into it.", ShapeKind::box, ToolUse::stamp,
            "stamp"}};

constexpr float kSheetWidth = 560;  // points
constexpr float kRowHeight = 46;
constexpr std::size_t kRecentShown = 4;
constexpr std::size_t kVertices = 40'000;

void open_example(Studio& studio, const Example& example) {
  const std::size_t count =
      std::clamp(kVertices, shape_counts(example.kind).minimum, shape_counts(example.kind).maximum);
  studio.document().open_made(example.kind, count);
  studio.perform(action_of(*studio_tool(example.tool)));
  ToolSettings& settings = studio.tools().settings();
  settings.mirror = {};
  settings.symmetry = {};
  settings.drag = settings.tool->drag;
  if (example.use == ToolUse::stamp) studio.tools().use_stamp(ShapeKind::letter_y);
}

// A row with an icon, a title and a sentence. Returns whether it was clicked.
bool draw_example(const Example& example, const Gui& gui) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float height = kRowHeight * gui.unit();
  const bool is_clicked = ImGui::Selectable(fmt::format("##{}", example.title).c_str(), false, 0, {0, height});
  draw_icon(*studio_tool(example.tool), {corner.x + 0.5F * height, corner.y + 0.5F * height}, 0.34F * height);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float left = corner.x + 1.1F * height;
  const float line = ImGui::GetTextLineHeight();
  const ImVec2 end{corner.x + ImGui::GetItemRectSize().x, corner.y + height};
  list.PushClipRect(corner, end, true);
  list.AddText({left, corner.y + 0.5F * height - 1.1F * line}, ImGui::GetColorU32(ImGuiCol_Text), example.title);
  list.AddText({left, corner.y + 0.5F * height + 0.1F * line}, ImGui::GetColorU32(ImGuiCol_TextDisabled), example.what);
  list.PopClipRect();
  return is_clicked;
}

// Returns whether a file was chosen.
bool draw_recent_files(Studio& studio, Dialogs& dialogs) {
  const std::vector<std::filesystem::path>& recent = studio.document().recent();
  if (recent.empty()) return false;
  ImGui::TextDisabled("Recent");
  begin_rows();
  bool is_chosen = false;
  for (std::size_t i = 0; i < std::min(recent.size(), kRecentShown); ++i) {
    const std::filesystem::path path = recent[i];
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable(path.filename().string().c_str())) {
      is_chosen = true;
      do_or_ask(studio, dialogs, [&studio, path] { studio.document().open(path); });
    }
    help_on_hover(path.string().c_str());
    ImGui::PopID();
  }
  end_rows();
  return is_chosen;
}

// Returns whether the sheet is done.
bool draw_beginnings(Studio& studio, Dialogs& dialogs) {
  const float spacing = ImGui::GetStyle().ItemSpacing.x;
  const float width = (ImGui::GetContentRegionAvail().x - 2 * spacing) / 3;
  const ImVec2 size{width, 1.7F * ImGui::GetFrameHeight()};
  bool is_done = ImGui::Button("New sphere", size) || enter_pressed();
  if (is_done && studio.document().shown().title != "new sphere") {
    do_or_ask(studio, dialogs, [&studio] { studio.document().open_made(ShapeKind::sphere, kVertices); });
  }
  for (const auto& [label, action] : {std::pair{"Open...", Action::open}, {"Other shapes...", Action::new_shape}}) {
    ImGui::SameLine();
    if (!ImGui::Button(label, size)) continue;
    studio.perform(action);
    is_done = true;
  }
  return is_done;
}

// What a step is about, and where that is.
struct TourStep {
  const char* title = nullptr;
  const char* text = nullptr;
  Area (*place)(const Layout&) = nullptr;
  const char* by_touch = nullptr;  // the text where fingers press, if it is another one
};

Area middle_of_picture(const Layout& layout) {
  const float x = 0.5F * (layout.free.left + layout.free.right);
  const float y = 0.5F * (layout.free.top + layout.free.bottom);
  const float half = 0.2F * std::min(layout.free.width(), layout.free.height());
  return {x - half, y - half, x + half, y + half};
}

Area edge_of_picture(const Layout& layout) {
  const float height = 0.2F * layout.free.height();
  return {layout.free.left, layout.free.bottom - height, layout.free.right, layout.free.bottom};
}

Area place_of_tools(const Layout& layout) { return layout.is_compact ? layout.bottom_bar : layout.tool_bar; }

Area place_of_settings(const Layout& layout) { return layout.is_compact ? layout.bottom_bar : layout.top_bar; }

Area place_of_history(const Layout& layout) {
  if (layout.is_compact) return layout.bottom_bar;
  const Area& panel = layout.side_panel;
  return panel.width() > 0 ? panel : layout.free;
}

Area place_of_menus(const Layout& layout) { return {0, 0, layout.free.right, layout.menu_height}; }

constexpr std::array kTour{
    TourStep{"Pull", "Drag on the shape: the surface follows the pointer.", middle_of_picture},
    TourStep{"Look around", "Drag beside the shape to turn it; the wheel zooms.", edge_of_picture,
             "Drag beside the shape to turn it. Two fingers turn and zoom, three move it."},
    TourStep{"Tools", "Choose another tool here; each colour is one kind of work.", place_of_tools},
    TourStep{"Settings", "Set radius, strength, falloff and mirror here, or with a right click.", place_of_settings,
             "Set radius and strength here. More opens mirror, falloff and everything else."},
    TourStep{"History", "Every drag is a line here that you can change later.", place_of_history,
             "More shows the history, too: every drag is a line that you can change later."},
    TourStep{"Save", "Save with Ctrl+S; after a crash Studio offers your work again.", place_of_menus,
             "Save and export with the menu File. If the page closes, it offers your work again."}};

constexpr float kCardWidth = 300;  // points

// Below the place, above it, or in the middle of the window, whichever has room.
ImVec2 place_of_card(const Area& lit, ImVec2 card, float gap) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const auto within = [](float x, float least, float most) { return std::clamp(x, least, std::max(least, most)); };
  const float x = within(0.5F * (lit.left + lit.right - card.x), gap, size.x - card.x - gap);
  if (lit.bottom + gap + card.y <= size.y) return {x, lit.bottom + gap};
  if (lit.top - gap - card.y >= 0) return {x, lit.top - gap - card.y};
  if (lit.right + gap + card.x <= size.x) return {lit.right + gap, within(lit.top, gap, size.y - card.y)};
  return {within(lit.left - gap - card.x, gap, size.x - card.x), 0.4F * size.y};
}

}  // namespace

void draw_welcome(Studio& studio, Dialogs& dialogs, const Gui& gui) {
  constexpr const char* kTitle = "Welcome";
  Welcome& welcome = dialogs.welcome;
  if (!welcome.is_open) return;
  if (!ImGui::IsPopupOpen(kTitle)) ImGui::OpenPopup(kTitle);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, 0.5F * size.y}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::min(kSheetWidth * gui.unit(), 0.96F * size.x), 0});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {size.x, 0.96F * size.y});
  constexpr int flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove;
  if (!ImGui::BeginPopupModal(kTitle, nullptr, flags)) return;
  Gui::begin_heading();
  ImGui::TextUnformatted("What do you want to shape?");
  Gui::end_heading();
  ImGui::Spacing();
  bool is_done = draw_beginnings(studio, dialogs);
  ImGui::Spacing();
  is_done = draw_recent_files(studio, dialogs) || is_done;
  ImGui::TextDisabled("Examples");
  for (const Example& example : kExamples) {
    if (!draw_example(example, gui)) continue;
    do_or_ask(studio, dialogs, [&studio, &example] { open_example(studio, example); });
    is_done = true;
  }
  if (const std::vector<std::filesystem::path> files = std::exchange(dialogs.file.brought, {}); !files.empty()) {
    do_or_ask(studio, dialogs, [&studio, files] { studio.handle(FilesDropped{files}); });
    is_done = true;
  }
  ImGui::Separator();
  if (ImGui::Button("Tour of one minute")) {
    studio.perform(Action::tour);
    is_done = true;
  }
  ImGui::SameLine();
  if (ImGui::Checkbox("Show this at the start", &studio.preferences().welcome)) studio.save_preferences();
  constexpr int on_it = ImGuiHoveredFlags_RootAndChildWindows | ImGuiHoveredFlags_AllowWhenBlockedByActiveItem;
  const bool is_beside = ImGui::IsMouseClicked(0) && !ImGui::IsWindowHovered(on_it) && !ImGui::IsWindowAppearing();
  if (is_done || is_beside || escape_pressed()) {
    welcome.is_open = false;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

// --- the tour --------------------------------------------------------------------------------------------------------

void draw_tour(Studio& studio, Welcome& welcome, const Gui& gui, const Layout& layout) {
  if (!welcome.tour || welcome.is_open) return;
  const TourStep& step = kTour[*welcome.tour];
  const Area lit = step.place(layout);
  const float edge = 2 * gui.unit();
  ImGui::GetForegroundDrawList()->AddRect({lit.left + edge, lit.top + edge}, {lit.right - edge, lit.bottom - edge},
                                          ImGui::GetColorU32(ImGuiCol_CheckMark), 6 * gui.unit(), 0, 3 * gui.unit());
  const float width = std::min(kCardWidth * gui.unit(), 0.9F * ImGui::GetIO().DisplaySize.x);
  const float height = welcome.card_height > 0 ? welcome.card_height : 5 * ImGui::GetFrameHeight();
  ImGui::SetNextWindowPos(place_of_card(lit, {width, height}, kPanelGap * gui.unit()));
  ImGui::SetNextWindowSize({width, 0});
  constexpr int flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoFocusOnAppearing;
  if (ImGui::Begin("Tour", nullptr, flags)) {
    Gui::begin_heading();
    ImGui::TextUnformatted(step.title);
    Gui::end_heading();
    ImGui::TextWrapped("%s", is_touched() && step.by_touch != nullptr ? step.by_touch : step.text);
    ImGui::AlignTextToFramePadding();
    ImGui::TextDisabled("%s", fmt::format("{} of {}", *welcome.tour + 1, kTour.size()).c_str());
    ImGui::SameLine();
    const bool is_last = *welcome.tour + 1 == kTour.size();
    const bool goes_on = ImGui::Button(is_last ? "Begin" : "Next");
    ImGui::SameLine();
    const bool ends = !is_last && ImGui::Button("End the tour");
    // The first step is done once the person has pulled.
    const bool has_pulled =
        *welcome.tour == 0 && studio.document().shown().history.size() > welcome.entries && !studio.gesture();
    if (ends || (goes_on && is_last)) {
      welcome.tour.reset();
    } else if (goes_on || has_pulled) {
      ++*welcome.tour;
    }
  }
  welcome.card_height = ImGui::GetWindowHeight();
  ImGui::End();
}

}  // namespace knead::studio
