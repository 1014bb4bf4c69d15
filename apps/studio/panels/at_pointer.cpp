// The numbers of a gesture beside the pointer, and the word at the arrow that points into the picture.
#include <imgui.h>

#include <algorithm>

#include "panels/panels.h"
#include "view/labels.h"

namespace knead::studio {

namespace {

constexpr ImU32 kInk = IM_COL32(245, 245, 240, 255);
constexpr ImU32 kPaper = IM_COL32(25, 27, 32, 205);

// Within `room`, if it fits there.
void draw_box(const Area& room, ImVec2 at, const std::vector<std::string>& lines, float unit) {
  const float height = ImGui::GetTextLineHeight();
  float width = 0;
  for (const std::string& line : lines) width = std::max(width, ImGui::CalcTextSize(line.c_str()).x);
  const float margin = 6 * unit;
  const ImVec2 size{width + 2 * margin, height * static_cast<float>(lines.size()) + 2 * margin};
  at.x = std::clamp(at.x, room.left, std::max(room.right - size.x, room.left));
  at.y = std::clamp(at.y, room.top, std::max(room.bottom - size.y, room.top));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled(at, {at.x + size.x, at.y + size.y}, kPaper, 4 * unit);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    list.AddText({at.x + margin, at.y + margin + height * static_cast<float>(i)}, kInk, lines[i].c_str());
  }
}

}  // namespace

void draw_numbers(const Studio& studio, const Gui& gui, const Layout& layout) {
  const Area& room = layout.free;
  const std::vector<std::string> lines = numbers_at_pointer(studio);
  const auto x = static_cast<float>(studio.pointer().x);
  const auto y = static_cast<float>(studio.pointer().y);
  if (!lines.empty()) draw_box(room, {x + 22 * gui.unit(), y + 18 * gui.unit()}, lines, gui.unit());
  const std::optional<InArrow> arrow = studio.view().tool ? in_arrow(studio) : std::nullopt;
  if (!arrow) return;
  const auto tip = pixel_of(studio.screen(), arrow->to);
  if (!tip) return;
  draw_box(room, {static_cast<float>(tip->x) + 8 * gui.unit(), static_cast<float>(tip->y)}, {"in"}, gui.unit());
}

}  // namespace knead::studio
