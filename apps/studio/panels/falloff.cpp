// The shape of a tool's blend, as a number and as a curve.
#include <imgui.h>

#include <array>

#include "knead/field.h"
#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

constexpr std::size_t kPlaces = 65;
constexpr float kLines = 3;  // of text: the height of the curve

}  // namespace

bool choose_falloff(int& falloff) {
  const bool is_changed =
      ImGui::SliderInt("Falloff", &falloff, kMinFalloff, kGreatestFalloff, "%d", ImGuiSliderFlags_AlwaysClamp);
  help_on_hover("how the motion fades from the inner region, at the left of the curve, to the outer one");
  std::array<float, kPlaces> weights{};
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const double s = static_cast<double>(i) / (kPlaces - 1);
    weights[i] = static_cast<float>(blend_weight(s, Thresholds<double>{0, 1, falloff}).value);
  }
  ImGui::PushStyleColor(ImGuiCol_PlotLines, ImGui::GetStyleColorVec4(ImGuiCol_Text));
  ImGui::PlotLines("##curve", weights.data(), static_cast<int>(kPlaces), 0, nullptr, 0, 1,
                   {0, kLines * ImGui::GetTextLineHeight()});
  ImGui::PopStyleColor();
  return is_changed;
}

}  // namespace knead::studio
