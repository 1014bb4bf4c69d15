// The fit of the shape to another one: numbers of the pairs in both views, and a window for what can be done with them.
#include <fmt/format.h>
#include <imgui.h>

#include "knead/editor/render.h"
#include "panels/panels.h"
#include "panels/widgets.h"
#include "view/overlay.h"

namespace knead::studio {

namespace {

constexpr float kNumberGap = 7;  // points, from the dot of a pair
constexpr float kRampHeight = 8;

void draw_number(const Screen& screen, const Area& area, const Vec3d& place, std::size_t pair, float unit) {
  const auto at = pixel_of(screen, place);
  if (!at) return;
  const ImVec2 corner{area.left + static_cast<float>(at->x) + kNumberGap * unit,
                      area.top + static_cast<float>(at->y) - kNumberGap * unit};
  if (corner.x > area.right || corner.y > area.bottom || corner.y < area.top) return;
  const std::string number = std::to_string(pair + 1);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddText({corner.x + 1, corner.y + 1}, IM_COL32(255, 255, 255, 200), number.c_str());
  list.AddText(corner, IM_COL32(20, 20, 25, 255), number.c_str());
}

void draw_numbers_of_pairs(const Studio& studio, const Gui& gui, const Layout& layout) {
  const StudioFit& fit = studio.fit();
  const Snapshot& positions = studio.document().shown().state.positions;
  const Area picture{0, 0, layout.free.right, layout.free.bottom};
  for (std::size_t i = 0; i < fit.pairs().size(); ++i) {
    const ClickedPair& pair = fit.pairs()[i];
    if (pair.source && *pair.source < positions.size()) {
      draw_number(studio.view().screen(), picture, positions[*pair.source], i, gui.unit());
    }
    if (pair.target) draw_number(fit.screen(), layout.target, fit.target().positions[*pair.target], i, gui.unit());
  }
}

const char* hint_of(const StudioFit& fit) {
  if (fit.pairs().empty()) return "Click a point of the shape, then its place here. Fit also works without pairs.";
  const ClickedPair& last = fit.pairs().back();
  if (!last.target) return "Now click its place here.";
  if (!last.source) return "Now click its point of the shape.";
  return "Click the next point, or press Fit.";
}

void draw_ramp_of_distances(const StudioFit& fit, float unit) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const auto color = [](std::size_t i) {
    const render::Color& c = render::kStretchColors[i];
    return ImGui::ColorConvertFloat4ToU32({c.red, c.green, c.blue, 1});
  };
  const std::size_t pieces = render::kStretchColors.size() - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const float left = corner.x + width * static_cast<float>(i) / static_cast<float>(pieces);
    const float right = corner.x + width * static_cast<float>(i + 1) / static_cast<float>(pieces);
    ImGui::GetWindowDrawList()->AddRectFilledMultiColor({left, corner.y}, {right, corner.y + kRampHeight * unit},
                                                        color(i), color(i + 1), color(i + 1), color(i));
  }
  ImGui::Dummy({width, kRampHeight * unit});
  ImGui::TextWrapped("%s", fmt::format("Distance: mean {:.2f}%, dark from {:.0f}% of the size on",
                                       100 * fit.mean_distance(), 100 * kFarFromTarget)
                               .c_str());
}

void draw_report(const BodyFitReport& report) {
  ImGui::Text("Stretch up to %.2f, %zu new crossings", report.greatest_stretch, report.crossings_new);
  if (report.volume_error) ImGui::Text("Volume %+.1f%%", 100 * *report.volume_error);
}

}  // namespace

void draw_fit(Studio& studio, const Gui& gui, const Layout& layout) {
  StudioFit& fit = studio.fit();
  if (!fit.is_open()) return;
  draw_numbers_of_pairs(studio, gui, layout);
  const Area& area = layout.target;
  ImGui::GetBackgroundDrawList()->AddRect({area.left, area.top}, {area.right, area.bottom}, IM_COL32(60, 65, 75, 255));
  const float height = std::min(kFitPanelHeight * gui.unit(), area.height());
  ImGui::SetNextWindowPos({area.left, area.bottom - height});
  ImGui::SetNextWindowSize({area.width(), height});
  bool stays = true;
  const std::string title = fmt::format("Fit to {}###Fit", fit.name());
  if (ImGui::Begin(title.c_str(), &stays,
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) {
    const bool is_free = !studio.document().worker().is_busy() && !studio.is_in_hand();
    ImGui::TextWrapped("%s", hint_of(fit));
    ImGui::Checkbox("Whole surface", &fit.settings().surface);
    help_on_hover("Brings the whole surface to the target's; without it the pairs alone.");
    ImGui::SameLine();
    ImGui::Checkbox("May grow", &fit.settings().grows);
    help_on_hover("The body grows and shrinks where the target asks for it; without it the volume stays.");
    ImGui::BeginDisabled(!is_free || (!fit.settings().surface && fit.complete_pairs() == 0));
    if (ImGui::Button("Fit")) fit.run();
    ImGui::EndDisabled();
    ImGui::BeginDisabled(fit.pairs().empty());
    ImGui::SameLine();
    if (ImGui::Button("Remove last")) fit.remove_last_pair();
    ImGui::SameLine();
    if (ImGui::Button("Remove all")) fit.clear_pairs();
    ImGui::EndDisabled();
    draw_ramp_of_distances(fit, gui.unit());
    if (fit.report()) draw_report(*fit.report());
  }
  ImGui::End();
  if (!stays) fit.close();
}

}  // namespace knead::studio
