// The numbers of a gesture beside the pointer, and the word at the arrow that points into the picture.
#include <imgui.h>

#include <algorithm>

#include "panels/panels.h"
#include "view/labels.h"

namespace knead::studio {

namespace {

constexpr ImU32 kInk = IM_COL32(245, 245, 240, 255);
constexpr ImU32 kPaper = IM_COL32(25, 27, 32, 205);

void draw_box(ImDrawList& list, ImVec2 at, const std::vector<std::string>& lines, float unit) {
  const float height = ImGui::GetTextLineHeight();
  float width = 0;
  for (const std::string& line : lines) width = std::max(width, ImGui::CalcTextSize(line.c_str()).x);
  const float margin = 6 * unit;
  const ImVec2 size{width + 2 * margin, height * static_cast<float>(lines.size()) + 2 * margin};
  const ImVec2 view = ImGui::GetIO().DisplaySize;
  at.x = std::clamp(at.x, 0.0F, std::max(view.x - size.x, 0.0F));
  at.y = std::clamp(at.y, 0.0F, std::max(view.y - size.y, 0.0F));
  list.AddRectFilled(at, {at.x + size.x, at.y + size.y}, kPaper, 4 * unit);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    list.AddText({at.x + margin, at.y + margin + height * static_cast<float>(i)}, kInk, lines[i].c_str());
  }
}

}  // namespace

void draw_numbers(const Studio& studio, const Gui& gui) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const std::vector<std::string> lines = numbers_at_pointer(studio);
  const auto x = static_cast<float>(studio.pointer().x);
  const auto y = static_cast<float>(studio.pointer().y);
  if (!lines.empty()) draw_box(list, {x + 22 * gui.unit(), y + 18 * gui.unit()}, lines, gui.unit());
  const std::optional<InArrow> arrow = studio.view().tool ? in_arrow(studio) : std::nullopt;
  if (!arrow) return;
  const auto tip = pixel_of(studio.screen(), arrow->to);
  if (tip)
    draw_box(list, {static_cast<float>(tip->x) + 8 * gui.unit(), static_cast<float>(tip->y)}, {"in"}, gui.unit());
}

}  // namespace knead::studio
