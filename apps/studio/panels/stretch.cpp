// Over the picture: the legend of stretches, what the placed tool would do, and the offer to remesh.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "panels/layout.h"
#include "panels/panels.h"
#include "panels/widgets.h"
#include "view/stretch.h"

namespace knead::studio {

namespace {

constexpr int kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize |
                       ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus;

ImU32 colour_of(const render::Color& c) { return ImGui::GetColorU32(ImVec4{c.red, c.green, c.blue, c.alpha}); }

void draw_ramp(const Gui& gui) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 size{210 * gui.unit(), 12 * gui.unit()};
  const auto& colours = render::kStretchColors;
  const float part = size.x / static_cast<float>(colours.size() - 1);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  for (std::size_t i = 0; i + 1 < colours.size(); ++i) {
    const float left = corner.x + part * static_cast<float>(i);
    const ImU32 from = colour_of(colours[i]);
    const ImU32 to = colour_of(colours[i + 1]);
    list.AddRectFilledMultiColor({left, corner.y}, {left + part, corner.y + size.y}, from, to, to, from);
  }
  const float below = corner.y + size.y + 2 * gui.unit();
  for (const double stretch : {1.0, 2.0, 4.0, kGreatestShown}) {
    const std::string text = fmt::format("{:g}{}", stretch, stretch == kGreatestShown ? "+" : "");
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    const float at = corner.x + size.x * shade_of_stretch(stretch);
    const float left = std::clamp(at - 0.5F * width, corner.x, corner.x + size.x - width);
    list.AddText({left, below}, ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
  }
  ImGui::Dummy({size.x, size.y + 2 * gui.unit() + ImGui::GetTextLineHeight()});
}

void draw_legend(const Studio& studio, const Gui& gui, bool is_known) {
  const StretchView since = studio.view().stretch;
  const Margins& covered = studio.navigation().covered;
  const float gap = kPanelGap * gui.unit();
  const float above_offer = ImGui::GetFrameHeightWithSpacing() + 4 * gap;
  ImGui::SetNextWindowPos({static_cast<float>(covered.left) + gap,
                           ImGui::GetIO().DisplaySize.y - static_cast<float>(covered.bottom) - above_offer},
                          ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowBgAlpha(0.75F);
  if (ImGui::Begin("Stretch", nullptr, kPlain | ImGuiWindowFlags_NoInputs)) {
    ImGui::TextUnformatted(since == StretchView::since_start ? "Greatest stretch since the start"
                                                             : "Greatest stretch by the last stroke");
    if (is_known) {
      draw_ramp(gui);
    } else {
      ImGui::TextDisabled("Not known for this shape.");
    }
  }
  ImGui::End();
}

// Beside the gizmo.
void draw_label(const Studio& studio, const Gui& gui, const GreatestStretch& estimate) {
  const auto& placement = studio.placed().placement;
  const auto at = placement ? pixel_of(studio.screen(), placement->center) : std::nullopt;
  if (!at || estimate.samples == 0) return;
  const std::string factor = fmt::format("stretches up to {:.1f} times", estimate.greatest);
  const std::string text = std::isinf(estimate.greatest) ? "crushes the shape: the zone is too thin"
                           : estimate.is_strong()        ? factor + ": triangles become thin"
                                                         : factor;
  const float width = ImGui::CalcTextSize(text.c_str()).x;
  const ImVec2 corner{static_cast<float>(at->x) - 0.5F * width, static_cast<float>(at->y) + 120 * gui.unit()};
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float pad = 4 * gui.unit();
  list.AddRectFilled({corner.x - pad, corner.y - pad},
                     {corner.x + width + pad, corner.y + ImGui::GetTextLineHeight() + pad},
                     ImGui::GetColorU32(ImGuiCol_WindowBg, 0.8F), pad);
  const ImVec4 colour = estimate.is_strong() ? kWarning : ImGui::GetStyleColorVec4(ImGuiCol_Text);
  list.AddText(corner, ImGui::GetColorU32(colour), text.c_str());
}

// Returns the height that it takes at the bottom of the view.
float draw_remesh_offer(Studio& studio, const Gui& gui) {
  const DocumentState& shown = studio.shown();
  if (shown.thin_triangles == 0 || studio.gesture() || shown.looked_at || studio.is_busy()) return 0;
  const Margins& covered = studio.navigation().covered;
  const float gap = kPanelGap * gui.unit();
  ImGui::SetNextWindowPos(
      {static_cast<float>(covered.left) + gap, ImGui::GetIO().DisplaySize.y - static_cast<float>(covered.bottom) - gap},
      ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowBgAlpha(0.9F);
  if (ImGui::Begin("Thin triangles", nullptr, kPlain)) {
    const char* const what = shown.thin_triangles == 1 ? "triangle" : "triangles";
    ImGui::TextUnformatted(fmt::format("The last stroke made {} {} thin.", shown.thin_triangles, what).c_str());
    ImGui::SameLine();
    if (ImGui::Button("Remesh")) studio.perform(Action::remesh_last);
    help_on_hover("Applies the last stroke again and remeshes what it moved.");
  }
  const float height = ImGui::GetWindowHeight();
  ImGui::End();
  return height + gap;
}

}  // namespace

float draw_stretch(Studio& studio, const Gui& gui, const Stretched& stretched) {
  if (studio.view().stretch != StretchView::off) draw_legend(studio, gui, stretched.is_known);
  if (stretched.estimate && studio.view().tool) draw_label(studio, gui, *stretched.estimate);
  return draw_remesh_offer(studio, gui);
}

}  // namespace knead::studio
