// The bar of tools, with their pictures.
#include <imgui.h>

#include <array>
#include <cmath>
#include <utility>

#include "panels/panels.h"

namespace knead::studio {

namespace {

// Draws in a square from -1 to 1, y downwards.
class Pen {
 public:
  Pen(ImDrawList& list, ImVec2 center, float half, ImU32 ink, ImU32 light)
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

void draw(const IconPart& part, const Pen& pen) {
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

// Scrolls the last entry into view if it is cut off.
void scroll_to_entry() {
  const float top = ImGui::GetWindowPos().y;
  const float bottom = top + ImGui::GetWindowHeight();
  if (ImGui::GetItemRectMin().y < top || ImGui::GetItemRectMax().y > bottom) ImGui::SetScrollHereY();
}

void draw_button(Studio& studio, const StudioTool& tool, float size, bool is_new) {
  const bool has_name = studio.view().tool_labels;
  const bool chosen = studio.settings().tool == &tool;
  ImGui::PushID(&tool);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  if (ImGui::Selectable("##tool", chosen, 0, {has_name ? 0 : size, size})) studio.perform(action_of(tool));
  if (chosen && is_new) scroll_to_entry();
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s  (%s)", tool.name.c_str(), keys_text(studio.preferences().keys, action_of(tool)).c_str());
  }
  const ImU32 ink = ImGui::GetColorU32(chosen ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  const Pen pen(*ImGui::GetWindowDrawList(), {corner.x + 0.5F * size, corner.y + 0.5F * size}, 0.34F * size, ink,
                ImGui::GetColorU32(ImGuiCol_TextDisabled, 0.25F));
  for (const IconPart& part : tool.icon) draw(part, pen);
  if (has_name) {
    const ImVec2 at{corner.x + 1.05F * size, corner.y + 0.5F * (size - ImGui::GetFontSize())};
    ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(ImGuiCol_Text), tool.name.c_str());
  }
  ImGui::PopID();
}

}  // namespace

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
    const int chosen = static_cast<int>(studio.settings().tool - studio_tools().data());
    const bool is_new = std::exchange(*scrolled_to, chosen) != chosen;
    for (const StudioTool& tool : studio_tools()) {
      if (tool.in_bar) draw_button(studio, tool, kToolSize * gui.unit(), is_new);
    }
  }
  ImGui::End();
  ImGui::PopStyleVar(4);
}

}  // namespace knead::studio
