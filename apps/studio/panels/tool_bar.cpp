// The bar of tools, with their pictures.
#include <imgui.h>

#include <array>
#include <cmath>
#include <numbers>

#include "gestures/tool_names.h"
#include "panels/panels.h"

namespace knead::studio {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

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

void draw_icon(ToolKind tool, const Pen& pen) {
  switch (tool) {
    case ToolKind::ball:
      pen.halo(-0.2F, 0.2F, 0.75F);
      pen.circle(-0.2F, 0.2F, 0.42F);
      return pen.arrow(-0.2F, 0.2F, 0.85F, -0.85F);
    case ToolKind::capsule:
      pen.arc(-0.45F, 0.25F, 0.42F, 0.5F * kPi, 1.5F * kPi);
      pen.arc(0.45F, 0.25F, 0.42F, -0.5F * kPi, 0.5F * kPi);
      pen.line(-0.45F, -0.17F, 0.45F, -0.17F);
      pen.line(-0.45F, 0.67F, 0.45F, 0.67F);
      return pen.arrow(0, 0.25F, 0, -0.9F);
    case ToolKind::paint:
      pen.wave({-1, 0.8F, -0.3F, 0.8F, -0.5F, 0.1F, 0, 0.1F});
      pen.wave({0, 0.1F, 0.5F, 0.1F, 0.3F, 0.8F, 1, 0.8F});
      pen.line(0.1F, -0.25F, 0.7F, -0.95F);
      return pen.disc(0.03F, -0.17F, 0.2F);
    case ToolKind::points:
      pen.disc(-0.55F, 0.45F, 0.2F);
      pen.disc(0.1F, 0.65F, 0.2F);
      pen.disc(0.6F, 0.3F, 0.2F);
      return pen.arrow(0, 0.15F, 0, -0.9F);
    case ToolKind::curve:
      pen.wave({-0.9F, 0.3F, -0.4F, 1.1F, 0.3F, -0.1F, 0.9F, 0.6F});
      return pen.arrow(0, 0.2F, 0, -0.9F);
    case ToolKind::stamp:
      pen.box(-0.35F, -0.9F, 0.35F, 0);
      pen.wave({-1, 0.2F, -0.4F, 0.2F, -0.7F, 0.8F, 0, 0.8F});
      return pen.wave({0, 0.8F, 0.7F, 0.8F, 0.4F, 0.2F, 1, 0.2F});
    case ToolKind::rotate:
      pen.disc(0, 0, 0.16F);
      pen.arc(0, 0, 0.75F, -0.3F * kPi, 1.3F * kPi);
      return pen.head(0.44F, -0.61F, -0.75F * kPi);
    case ToolKind::stretch:
      pen.box(-0.3F, -0.3F, 0.3F, 0.3F);
      pen.arrow(0.45F, 0, 0.98F, 0);
      return pen.arrow(-0.45F, 0, -0.98F, 0);
    case ToolKind::twist:
      pen.wave({-0.5F, 0.95F, -0.5F, 0.1F, 0.5F, -0.1F, 0.5F, -0.95F});
      pen.wave({0.5F, 0.95F, 0.5F, 0.1F, -0.5F, -0.1F, -0.5F, -0.95F});
      pen.line(-0.5F, 0.95F, 0.5F, 0.95F);
      return pen.line(-0.5F, -0.95F, 0.5F, -0.95F);
    case ToolKind::bend:
      pen.wave({-0.7F, 0.95F, -0.7F, -0.1F, -0.4F, -0.75F, 0.5F, -0.85F});
      pen.wave({-0.05F, 0.95F, -0.05F, 0.3F, 0.1F, -0.1F, 0.75F, -0.25F});
      pen.line(0.5F, -0.85F, 0.75F, -0.25F);
      return pen.line(-0.7F, 0.95F, -0.05F, 0.95F);
    case ToolKind::handles:
      pen.halo(-0.45F, -0.3F, 0.5F);
      pen.disc(-0.45F, -0.3F, 0.26F);
      pen.circle(0.45F, 0.45F, 0.4F);
      return pen.line(0.17F, 0.73F, 0.73F, 0.17F);
  }
}

void draw_button(Studio& studio, ToolKind tool, float size) {
  const bool chosen = studio.settings().tool == tool;
  ImGui::PushID(static_cast<int>(tool));
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  if (ImGui::Selectable("##tool", chosen, 0, {size, size})) studio.perform(action_of(tool));
  if (ImGui::IsItemHovered()) {
    ImGui::SetTooltip("%s  (%s)", name_of(tool), keys_text(studio.preferences().keys, action_of(tool)).c_str());
  }
  const ImU32 ink = ImGui::GetColorU32(chosen ? ImGuiCol_Text : ImGuiCol_TextDisabled);
  const Pen pen(*ImGui::GetWindowDrawList(), {corner.x + 0.5F * size, corner.y + 0.5F * size}, 0.34F * size, ink,
                ImGui::GetColorU32(ImGuiCol_TextDisabled, 0.25F));
  draw_icon(tool, pen);
  ImGui::PopID();
}

}  // namespace

void draw_tool_bar(Studio& studio, const Gui& gui) {
  const float size = 38 * gui.unit();
  const float gap = 8 * gui.unit();
  ImGui::SetNextWindowPos({gap, ImGui::GetFrameHeight() + gap});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.5F * gap, 0.5F * gap});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, 0.25F * gap});
  constexpr int flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize |
                        ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (ImGui::Begin("Tools", nullptr, flags)) {
    for (int i = 0; i < kToolCount; ++i) draw_button(studio, static_cast<ToolKind>(i), size);
  }
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace knead::studio
