// The tools and the settings that one changes all the time: the bar of tools, the bar above the picture, and the same
// settings at the pointer.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "panels/panels.h"
#include "panels/widgets.h"
#include "view/overlay.h"

namespace knead::studio {

namespace {

// Draws in a square from -1 to 1, y downwards.
class IconPen {
 public:
  IconPen(ImDrawList& list, ImVec2 center, float half, ImU32 ink, ImU32 light)
      : list_(list), center_(center), half_(half), ink_(ink), light_(light) {}

  ImVec2 at(float x, float y) const { return {center_.x + half_ * x, center_.y + half_ * y}; }
  void line(float x0, float y0, float x1, float y1) const { list_.AddLine(at(x0, y0), at(x1, y1), ink_, width()); }
  void circle(float x, float y, float r) const { list_.AddCircle(at(x, y), half_ * r, ink_, 0, width()); }
  void disc(float x, float y, float r) const { list_.AddCircleFilled(at(x, y), half_ * r, ink_); }
  void halo(float x, float y, float r) const { list_.AddCircleFilled(at(x, y), half_ * r, light_); }
  void box(float x0, float y0, float x1, float y1) const {
    list_.AddRect(at(x0, y0), at(x1, y1), ink_, 0.2F * half_, 0, width());
  }
  // A cubic Bezier curve by its four points, x and y of each.
  void wave(const std::array<float, 8>& p) const {
    list_.AddBezierCubic(at(p[0], p[1]), at(p[2], p[3]), at(p[4], p[5]), at(p[6], p[7]), ink_, width());
  }
  void arc(float x, float y, float r, float from, float to) const {
    list_.PathArcTo(at(x, y), half_ * r, from, to);
    list_.PathStroke(ink_, 0, width());
  }
  void arrow(float x0, float y0, float x1, float y1) const {
    line(x0, y0, x1, y1);
    head(x1, y1, std::atan2(y1 - y0, x1 - x0));
  }
  // The head of an arrow that flies at an angle.
  void head(float x, float y, float angle) const {
    const float r = 0.38F;
    for (const float turn : {2.6F, -2.6F}) line(x, y, x + r * std::cos(angle + turn), y + r * std::sin(angle + turn));
  }

 private:
  float width() const { return 0.16F * half_; }

  ImDrawList& list_;
  ImVec2 center_;
  float half_;
  ImU32 ink_;
  ImU32 light_;
};

void draw_part(const IconPart& part, const IconPen& pen) {
  const std::array<float, 8>& n = part.numbers;
  switch (part.shape) {
    case IconShape::line:
      return pen.line(n[0], n[1], n[2], n[3]);
    case IconShape::circle:
      return pen.circle(n[0], n[1], n[2]);
    case IconShape::disc:
      return pen.disc(n[0], n[1], n[2]);
    case IconShape::halo:
      return pen.halo(n[0], n[1], n[2]);
    case IconShape::box:
      return pen.box(n[0], n[1], n[2], n[3]);
    case IconShape::wave:
      return pen.wave(n);
    case IconShape::arc:
      return pen.arc(n[0], n[1], n[2], n[3], n[4]);
    case IconShape::arrow:
      return pen.arrow(n[0], n[1], n[2], n[3]);
    case IconShape::arrow_head:
      return pen.head(n[0], n[1], n[2]);
  }
}

ImVec4 colour_in_bar(ToolGroup group) {
  static const std::array colours{ImVec4{0.95F, 0.63F, 0.36F, 1}, ImVec4{0.55F, 0.80F, 0.45F, 1},
                                  ImVec4{0.47F, 0.70F, 0.98F, 1}, ImVec4{0.78F, 0.62F, 0.95F, 1}};
  return colours[static_cast<std::size_t>(group)];
}

constexpr float kPictureSize = 64;  // points, of the icon in a tooltip
constexpr float kTipWidth = 230;

void draw_tip(const Studio& studio, const StudioTool& tool, const Gui& gui) {
  place_tooltip();
  ImGui::BeginTooltip();
  const float size = kPictureSize * gui.unit();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  draw_icon(tool, {corner.x + 0.5F * size, corner.y + 0.5F * size}, 0.42F * size);
  ImGui::Dummy({size, size});
  ImGui::SameLine();
  ImGui::BeginGroup();
  Gui::begin_heading();
  ImGui::TextUnformatted(tool.name.c_str());
  Gui::end_heading();
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + kTipWidth * gui.unit());
  ImGui::TextUnformatted(tool.tip);
  ImGui::PopTextWrapPos();
  ImGui::TextDisabled("Key %s", keys_text(studio.preferences().keys, action_of(tool)).c_str());
  ImGui::EndGroup();
  ImGui::EndTooltip();
}

// Scrolls the last entry into view if it is cut off.
void scroll_to_entry() {
  const float top = ImGui::GetWindowPos().y;
  const float bottom = top + ImGui::GetWindowHeight();
  if (ImGui::GetItemRectMin().y < top || ImGui::GetItemRectMax().y > bottom) ImGui::SetScrollHereY();
}

// Returns whether the tool was chosen.
bool draw_tool_button(Studio& studio, const StudioTool& tool, const Gui& gui, ImVec2 size, bool has_name) {
  const bool chosen = studio.tools().settings().tool == &tool;
  ImGui::PushID(&tool);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  ImVec4 back = colour_in_bar(tool.group);
  back.w = 0.30F;
  ImGui::PushStyleColor(ImGuiCol_Header, back);
  const bool is_clicked = ImGui::Selectable("##tool", chosen, 0, size);
  ImGui::PopStyleColor();
  if (is_clicked) studio.perform(action_of(tool));
  if (ImGui::IsItemHovered()) draw_tip(studio, tool, gui);
  draw_icon(tool, {corner.x + 0.5F * size.y, corner.y + 0.5F * size.y}, 0.34F * size.y);
  if (has_name) {
    const ImVec2 at{corner.x + 0.95F * size.y, corner.y + 0.5F * (size.y - ImGui::GetFontSize())};
    ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(ImGuiCol_Text), tool.name.c_str());
  }
  ImGui::PopID();
  return is_clicked;
}

}  // namespace

void draw_icon(const StudioTool& tool, ImVec2 center, float half) {
  const ImVec4 colour = colour_in_bar(tool.group);
  const ImVec4 light{colour.x, colour.y, colour.z, 0.25F};
  const IconPen pen(*ImGui::GetWindowDrawList(), center, half, ImGui::GetColorU32(colour), ImGui::GetColorU32(light));
  for (const IconPart& part : tool.icon) draw_part(part, pen);
}

void draw_tool_bar(Studio& studio, const Gui& gui, const Layout& layout) {
  const Area& area = layout.tool_bar;
  const float padding = kToolBarPadding * gui.unit();
  ImGui::SetNextWindowPos({area.left, area.top});
  ImGui::SetNextWindowSize({area.width(), area.height()});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {padding, padding});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, kToolGap * gui.unit()});
  ImGui::PushStyleVar(ImGuiStyleVar_ScrollbarSize, kToolScrollbar * gui.unit());
  int flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
              ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (!layout.tool_bar_scrolls) flags |= ImGuiWindowFlags_NoScrollbar;
  if (ImGui::Begin("Tools", nullptr, flags)) {
    // A tool that a key chose is scrolled into view once; later the person may scroll away from it.
    int* const scrolled_to = ImGui::GetStateStorage()->GetIntRef(ImGui::GetID("scrolled to"), -1);
    const int chosen = static_cast<int>(studio.tools().settings().tool - studio_tools().data());
    const bool is_new = std::exchange(*scrolled_to, chosen) != chosen;
    const bool has_names = studio.view().settings().tool_labels;
    const float size = layout.tool_size;
    for (const ToolGroup group : kToolGroups) {
      if (group != kToolGroups.front()) ImGui::Dummy({1, kGroupGap * gui.unit()});
      int count = 0;
      for (const StudioTool& tool : studio_tools()) {
        if (tool.group != group) continue;
        if (count++ % layout.tool_columns != 0) ImGui::SameLine(0, 0);
        draw_tool_button(studio, tool, gui, {has_names ? 0 : size, size}, has_names);
        if (is_new && studio.tools().settings().tool == &tool) scroll_to_entry();
      }
    }
  }
  ImGui::End();
  ImGui::PopStyleVar(4);
}

// --- the settings that one changes all the time ----------------------------------------------------------------------

namespace {

// A setting of the tool in use: `draw` makes its widget, which takes so many points.
struct HandSetting {
  float width;
  std::function<void(float pixels)> draw;
  bool is_fixed = false;  // its width
};

constexpr float kSliderWidth = 165;  // points
constexpr float kNarrowest = 0.5F;   // of their widths, in a narrow window
constexpr float kNameFrom = 820;     // points of a bar that has room for the tool's name

void draw_hand_radius(Studio& studio, float width) {
  const double diagonal = studio.document().shown().diagonal;
  const double before = studio.tools().radius();
  double radius = before;
  slide("Radius", radius, {1e-3 * diagonal, diagonal}, "how far the tool reaches (F, [ and ])",
        {text_of(studio.preferences().unit), width});
  if (radius == before) return;
  studio.tools().fix_radius();
  studio.tools().settings().radius = radius;
}

void draw_hand_amount(Studio& studio, std::string_view key, float width) {
  ToolSettings& settings = studio.tools().settings();
  const std::vector<Setting> rows = settings_of(settings);
  const Setting& row = *find_setting(rows, key);
  double& value = *std::get<double*>(row.value);
  const double unit = settings.radius;
  const std::string sign = sign_of(AmountKind::length, studio.preferences().unit);
  const double before = value * unit;
  double amount = before;
  slide(row.label, amount, {row.range.least * unit, row.range.most * unit}, row.help, {sign.c_str(), width});
  if (amount != before) value = amount / unit;
}

void draw_hand_inner(Studio& studio, float width) {
  ToolSettings& settings = studio.tools().settings();
  const double before = 100 * settings.inner_ratio;
  double percent = before;
  slide("Inner ratio", percent, {1, 95}, "which part of the radius moves rigidly (Shift+F)", {"%", width});
  if (percent != before) settings.inner_ratio = std::clamp(percent / 100, 0.01, 0.95);
}

void draw_hand_mirrors(Studio& studio) {
  ToolSettings& settings = studio.tools().settings();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Mirror");
  for (std::size_t i = 0; i < 3; ++i) {
    ImGui::SameLine(0, (i == 0 ? 6 : 2) * ImGui::GetFontSize() / 15);
    const bool is_on = settings.mirror[i];
    if (is_on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    const char* const label = std::array{"X##mirror", "Y##mirror", "Z##mirror"}[i];
    if (ImGui::Button(label, {is_touched() ? 1.3F * ImGui::GetFrameHeight() : 0, 0})) settings.mirror[i] = !is_on;
    if (is_on) ImGui::PopStyleColor();
    help_on_hover(std::array{"mirrors everything in the plane x = 0 (Alt+X)",
                             "mirrors everything in the plane y = 0 (Alt+Y)",
                             "mirrors everything in the plane z = 0 (Alt+Z)"}[i]);
  }
}

std::vector<HandSetting> hand_settings(Studio& studio) {
  const ToolSettings& settings = studio.tools().settings();
  const StudioTool& tool = *settings.tool;
  std::vector<HandSetting> all;
  all.push_back({142, [&](float /*pixels*/) { draw_hand_mirrors(studio); }, true});  // where it is, whatever the tool
  if (has_mode(studio)) all.push_back({130, [&](float width) { draw_mode(studio, width); }});
  if (has_radius(settings)) all.push_back({kSliderWidth, [&](float width) { draw_hand_radius(studio, width); }});
  for (const std::string_view slider : tool.sliders) {
    all.push_back({kSliderWidth, [&studio, slider](float width) { draw_hand_amount(studio, slider, width); }});
  }
  if (!tool.strength.empty()) {
    all.push_back({kSliderWidth, [&](float width) { draw_tool_setting(studio, tool.strength, width); }});
  }
  if (tool.has_inner && has_radius(settings)) {
    all.push_back({125, [&](float width) { draw_hand_inner(studio, width); }});
  }
  if (blends(settings)) {
    all.push_back({110, [&](float width) { draw_tool_setting(studio, "falloff", width); }});
  }
  if (has_drag_mode(settings)) {
    all.push_back({170, [&](float width) { draw_tool_setting(studio, "drag", width); }});
  }
  return all;
}

constexpr int kBar = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoFocusOnAppearing;

// The icon of the tool in use, and its name where there is room.
void draw_tool_name(const Studio& studio, const Gui& gui, bool has_room = true) {
  const StudioTool& tool = *studio.tools().settings().tool;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetFrameHeight();
  draw_icon(tool, {corner.x + 0.5F * height, corner.y + 0.5F * height}, 0.45F * height);
  ImGui::Dummy({height, height});
  help_on_hover(tool.tip);
  ImGui::SameLine();
  if (!has_room) return;
  Gui::begin_heading();
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 0.5F * (height - ImGui::GetFontSize()));
  ImGui::TextUnformatted(tool.name.c_str());
  Gui::end_heading();
  help_on_hover(tool.tip);
  // A place for the longest name, so that the sliders stay where they are.
  ImGui::SameLine(std::max(kNameWidth * gui.unit(), ImGui::GetItemRectMax().x - ImGui::GetWindowPos().x));
}

}  // namespace

void draw_top_bar(Studio& studio, const Gui& gui, const Layout& layout) {
  const Area& area = layout.top_bar;
  ImGui::SetNextWindowPos({area.left, area.top});
  ImGui::SetNextWindowSize({area.width(), area.height()});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {kPanelGap * gui.unit(), kTopBarPadding * gui.unit()});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  if (ImGui::Begin("Tool", nullptr, kBar)) {
    draw_tool_name(studio, gui, area.width() > kNameFrom * gui.unit());
    const float spacing = ImGui::GetStyle().ItemSpacing.x;
    float left = ImGui::GetCursorPosX();
    const std::vector<HandSetting> settings = hand_settings(studio);
    float room = area.width() - spacing - left;
    float wanted = 0;
    for (const HandSetting& setting : settings) {
      (setting.is_fixed ? room : wanted) += (setting.is_fixed ? -1 : 1) * setting.width * gui.unit();
      room -= spacing;
    }
    const float part = std::clamp(room / std::max(wanted, 1.0F), kNarrowest, 1.0F);
    bool is_first = true;
    // What does not fit is at the pointer.
    for (const HandSetting& setting : settings) {
      const float width = setting.width * gui.unit() * (setting.is_fixed ? 1 : part);
      if (left + width > area.width() - spacing) break;
      if (!std::exchange(is_first, false)) ImGui::SameLine(left);
      setting.draw(width);
      left += width + spacing;
    }
  }
  ImGui::End();
  ImGui::PopStyleVar(3);
}

void draw_pointer_menu(Studio& studio, const Gui& gui, std::optional<Pixel>& asked) {
  constexpr const char* kName = "At the pointer";
  if (const auto at = std::exchange(asked, std::nullopt)) {
    ImGui::OpenPopup(kName);
    ImGui::SetNextWindowPos({static_cast<float>(at->x), static_cast<float>(at->y)}, ImGuiCond_Always, {0.5F, 0});
  }
  if (!ImGui::BeginPopup(kName)) return;
  draw_tool_name(studio, gui);
  ImGui::NewLine();
  draw_hand_settings(studio, 1.4F * kSliderWidth * gui.unit());
  ImGui::EndPopup();
}

void draw_hand_settings(Studio& studio, float width) {
  for (const HandSetting& setting : hand_settings(studio)) setting.draw(width);
}

// --- the bar of a compact window -------------------------------------------------------------------------------------

namespace {

constexpr const char* kToolsPopup = "Choose a tool";
constexpr float kSmallText = 0.85F;

void draw_tools_popup(Studio& studio, const Gui& gui, const Layout& layout) {
  const Area& bar = layout.bottom_bar;
  const float gap = kPanelGap * gui.unit();
  ImGui::SetNextWindowPos({bar.left + gap, bar.top}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {bar.width(), bar.top - layout.menu_height});
  if (!ImGui::BeginPopup(kToolsPopup)) return;
  ImGui::SetWindowFontScale(kSmallText);
  const int columns = layout.is_wide ? 5 : 3;
  const float room = std::min(bar.width() - 5 * gap, 0.9F * static_cast<float>(columns) * kNameWidth * gui.unit());
  const ImVec2 size{room / static_cast<float>(columns), kTouchSize * gui.unit()};
  for (const ToolGroup group : kToolGroups) {
    ImGui::TextDisabled("%s", name_of(group));
    int column = 0;
    for (const StudioTool& tool : studio_tools()) {
      if (tool.group != group) continue;
      if (column++ % columns != 0) ImGui::SameLine(0, 0);
      if (draw_tool_button(studio, tool, gui, size, true)) ImGui::CloseCurrentPopup();
    }
  }
  ImGui::EndPopup();
}

bool has_strength(const StudioTool& tool) {
  return tool.brush == nullptr || !tool.sliders.empty() || !tool.strength.empty();
}

// The strength of the tool, or what comes nearest to it.
void draw_strength_of_tool(Studio& studio, float width) {
  const StudioTool& tool = *studio.tools().settings().tool;
  if (tool.use == ToolUse::print || tool.use == ToolUse::stamp) return draw_mode(studio, width);
  if (!tool.sliders.empty() && tool.use != ToolUse::pull) return draw_hand_amount(studio, tool.sliders.front(), width);
  if (tool.has_inner) return draw_hand_inner(studio, width);
  if (has_mode(studio)) return draw_mode(studio, width);
  draw_tool_setting(studio, tool.strength.empty() ? "falloff" : tool.strength, width);
}

bool draw_touch_button(const char* label, float width, float height, bool is_on = false) {
  if (is_on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
  const bool is_clicked = ImGui::Button(label, {width, height});
  if (is_on) ImGui::PopStyleColor();
  return is_clicked;
}

// What Ctrl does to the tool, and Shift.
const char* word_of_ctrl(const StudioTool& tool) {
  if (tool.use == ToolUse::mask) return "Erase";
  if (tool.use == ToolUse::smooth) return "Even";
  if (tool.use == ToolUse::pose) return "Lasso";
  return has_two_signs(tool.use) ? "Invert" : "Snap";
}

const char* word_of_shift(const StudioTool& tool) { return tool.use == ToolUse::pose ? "Select" : "Smooth"; }

// A button that holds a key, with what the key does.
void draw_held_key(const char* key, const char* word, ImVec2 size, bool& is_held) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  if (draw_touch_button((std::string("##") + key).c_str(), size.x, size.y, is_held)) is_held = !is_held;
  const float font = kSmallText * ImGui::GetFontSize();
  float y = corner.y + 0.5F * size.y - 1.1F * font;
  for (const char* line : {word, key}) {
    const float x = corner.x + 0.5F * (size.x - kSmallText * ImGui::CalcTextSize(line).x);
    ImGui::GetWindowDrawList()->AddText(nullptr, font, {x, y}, ImGui::GetColorU32(ImGuiCol_Text), line);
    y += 1.2F * font;
  }
  ImGui::SameLine();
}

void draw_touch_buttons(Studio& studio, const Gui& gui, float width, CompactBar& bar) {
  constexpr int count = 6;
  const float spacing = ImGui::GetStyle().ItemSpacing.x;
  const float each = (width - (count - 1) * spacing) / count;
  const float height = kTouchSize * gui.unit();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  if (draw_touch_button("##tools", each, height)) ImGui::OpenPopup(kToolsPopup);
  draw_icon(*studio.tools().settings().tool, {corner.x + 0.5F * each, corner.y + 0.5F * height}, 0.34F * height);
  ImGui::SameLine();
  if (draw_touch_button("Undo", each, height)) studio.perform(Action::undo);
  ImGui::SameLine();
  if (draw_touch_button("Redo", each, height)) studio.perform(Action::redo);
  ImGui::SameLine();
  const StudioTool& tool = *studio.tools().settings().tool;
  draw_held_key("Ctrl", word_of_ctrl(tool), {each, height}, bar.held.ctrl);
  draw_held_key("Shift", word_of_shift(tool), {each, height}, bar.held.shift);
  if (draw_touch_button("More", each, height, bar.is_side_open)) bar.is_side_open = !bar.is_side_open;
}

}  // namespace

void draw_bottom_bar(Studio& studio, const Gui& gui, const Layout& layout, CompactBar& bar) {
  const Area& area = layout.bottom_bar;
  ImGui::SetNextWindowPos({area.left, area.top});
  ImGui::SetNextWindowSize({area.width(), area.height()});
  const float gap = kPanelGap * gui.unit();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {gap, gap});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  if (ImGui::Begin("Bottom bar", nullptr, kBar)) {
    const float spacing = ImGui::GetStyle().ItemSpacing.x;
    const float room = area.width() - 2 * gap;
    const float for_sliders = layout.is_wide ? 0.5F * (room - spacing) : room;
    // Sliders as high as a finger is wide.
    const float tall = 0.5F * (kTouchSize * gui.unit() - ImGui::GetFontSize());
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {ImGui::GetStyle().FramePadding.x, tall});
    const bool has_one = has_radius(studio.tools().settings());
    const bool has_other = has_strength(*studio.tools().settings().tool);
    const float half = has_one && has_other ? 0.5F * (for_sliders - spacing) : for_sliders;
    if (has_one) draw_hand_radius(studio, half);
    if (has_one && has_other) ImGui::SameLine();
    if (has_other) draw_strength_of_tool(studio, half);
    ImGui::PopStyleVar();
    if (layout.is_wide) ImGui::SameLine(gap + for_sliders + spacing);
    draw_touch_buttons(studio, gui, layout.is_wide ? for_sliders : room, bar);
    draw_tools_popup(studio, gui, layout);
  }
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace knead::studio
