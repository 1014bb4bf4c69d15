// At the lower left end of the view: the legend of stretches, and offers: what was reached or found, and what to do
// about it. Beside the placed tool: what it would do.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "panels/panels.h"
#include "panels/widgets.h"
#include "view/overlay.h"

namespace knead::studio {

namespace {

constexpr int kSheet = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize |
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
  const StretchView since = studio.view().settings().stretch;
  const Margins& covered = studio.view().navigation().covered;
  const float gap = kPanelGap * gui.unit();
  const float above_offer = ImGui::GetFrameHeightWithSpacing() + 4 * gap;
  ImGui::SetNextWindowPos({static_cast<float>(covered.left) + gap,
                           ImGui::GetIO().DisplaySize.y - static_cast<float>(covered.bottom) - above_offer},
                          ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowBgAlpha(0.75F);
  if (ImGui::Begin("Stretch", nullptr, kSheet | ImGuiWindowFlags_NoInputs)) {
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
  const auto& placement = studio.tools().placed().placement;
  const auto at = placement ? pixel_of(studio.view().screen(), placement->center) : std::nullopt;
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

// Says what was reached or found, and below it what to do about it, at the lower left end of the view. Returns the
// height that it takes.
template <class Buttons>
float draw_offer(const Studio& studio, const Gui& gui, const std::string& what, const Buttons& buttons) {
  const Margins& covered = studio.view().navigation().covered;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float gap = kPanelGap * gui.unit();
  const float room = size.x - static_cast<float>(covered.left + covered.right) - 2 * gap;
  ImGui::SetNextWindowPos({static_cast<float>(covered.left) + gap, size.y - static_cast<float>(covered.bottom) - gap},
                          ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowBgAlpha(0.9F);
  if (ImGui::Begin("Offer", nullptr, kSheet)) {
    ImGui::PushTextWrapPos(room - 2 * gap);
    ImGui::TextUnformatted(what.c_str());
    ImGui::PopTextWrapPos();
    buttons();
  }
  const float height = ImGui::GetWindowHeight();
  ImGui::End();
  return height + gap;
}

float draw_remesh_offer(Studio& studio, const Gui& gui) {
  const DocumentState& shown = studio.document().shown();
  const std::size_t count = shown.poor_triangles;
  const std::string what = shown.is_coarse ? "The triangles are too large to show the last stroke."
                           : count == 1    ? "The last stroke made 1 triangle thin or angular."
                                           : fmt::format("The last stroke made {} triangles thin or angular.", count);
  return draw_offer(studio, gui, what, [&] {
    if (ImGui::Button("Remesh")) studio.perform(Action::remesh_last);
    help_on_hover("Applies the last stroke again and remeshes what it moved.");
    ImGui::SameLine();
    if (ImGui::Button("Always")) {
      studio.tools().settings().remesh = true;
      studio.perform(Action::remesh_last);
    }
    help_on_hover("Remeshes this stroke and all that follow.");
  });
}

// Of a pose that fell short.
float draw_pose_offer(Studio& studio, const Gui& gui, const StrokeNotes& notes) {
  const std::string what = notes.reached < 1 ? fmt::format("The pose came {:.0f}% as far as you dragged it.",
                                                           std::floor(100 * notes.reached))
                                             : "The pose ends a little beside its place.";
  const bool refines = studio.can_refine_pose();
  return draw_offer(studio, gui, what, [&] {
    if (ImGui::Button(refines ? "Finer" : "Hold less")) studio.improve_pose();
    help_on_hover(refines ? "Poses it again, as fine as its parts are thin."
                          : "Poses it again, and lets more of what is beside it move along.");
  });
}

// Of a twist or bend that finds no part.
float draw_bend_offer(Studio& studio, const Gui& gui) {
  return draw_offer(studio, gui, fmt::format("{} finds no part here.", studio.tools().settings().tool->name),
                    [&] { draw_pose_button(studio); });
}

// One at a time.
float draw_offers(Studio& studio, const Gui& gui) {
  const DocumentState& shown = studio.document().shown();
  if (studio.gesture() || shown.looked_at || studio.document().worker().is_busy()) return 0;
  if (!Overlay::placement_problem(studio).empty()) return draw_bend_offer(studio, gui);
  if (!shown.history.empty() && !shown.history.back()->notes.shortfall.empty()) {
    const HistoryEntry& last = *shown.history.back();
    const bool is_lattice = std::holds_alternative<LatticeStroke>(last.strokes.back().stroke);
    if (is_lattice) return draw_offer(studio, gui, in_words(last.notes.shortfall), [] {});
    return draw_pose_offer(studio, gui, last.notes);
  }
  return shown.is_coarse || shown.poor_triangles > 0 ? draw_remesh_offer(studio, gui) : 0;
}

}  // namespace

bool draw_pose_button(Studio& studio) {
  const bool is_clicked = small_button("Pose it");
  help_on_hover("Turns what is beyond this place as a pose.");
  if (is_clicked) studio.pose_placed();
  return is_clicked;
}

float draw_stretch(Studio& studio, const Gui& gui, const Stretched& stretched) {
  if (studio.view().settings().stretch != StretchView::off) draw_legend(studio, gui, stretched.is_known);
  if (stretched.estimate && studio.view().settings().tool) draw_label(studio, gui, *stretched.estimate);
  return draw_offers(studio, gui);
}

}  // namespace knead::studio
