// How the shape is drawn: material, relief, background, perspective.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

void draw_matcaps(Look& look, const Gui& gui) {
  const std::string chosen(title_of(look.matcap));
  if (ImGui::BeginCombo("Matcap", chosen.c_str())) {
    for (const render::Matcap matcap : render::all_matcaps()) {
      gui.draw_ball(matcap);
      ImGui::SameLine();
      if (ImGui::Selectable(std::string(title_of(matcap)).c_str(), matcap == look.matcap)) look.matcap = matcap;
    }
    ImGui::EndCombo();
  }
  ImGui::SameLine();
  gui.draw_ball(look.matcap);
}

void draw_background(std::string& background) {
  constexpr std::array<const char*, 3> names{"gradient", "light", "dark"};
  constexpr std::array<const char*, 3> titles{"Gradient", "Light", "Dark"};
  const std::optional<render::Color> own = render::color_from(background);
  const auto* const known = std::find(names.begin(), names.end(), background);
  if (ImGui::BeginCombo("Background", own ? "Colour" : titles[static_cast<std::size_t>(known - names.begin())])) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (ImGui::Selectable(titles[i], background == names[i])) background = names[i];
    }
    if (ImGui::Selectable("Colour", own.has_value()) && !own) {
      background = text_of(render::background_named(background)->bottom);
    }
    ImGui::EndCombo();
  }
  if (!own) return;
  std::array<float, 3> channels{own->red, own->green, own->blue};
  if (ImGui::ColorEdit3("##background", channels.data(), ImGuiColorEditFlags_DisplayHex)) {
    background = text_of(render::Color{channels[0], channels[1], channels[2], 1});
  }
}

void draw_projection(View& view) {
  bool is_perspective = view.projection == render::Projection::perspective;
  if (ImGui::Checkbox("Perspective", &is_perspective)) view = toggled_projection(view);
  if (!is_perspective) return;
  slide("Field of view", view.field_of_view_deg, {kSmallestFieldDeg, kLargestFieldDeg}, "degrees from bottom to top");
  view.field_of_view_deg = std::clamp(view.field_of_view_deg, kSmallestFieldDeg, kLargestFieldDeg);
}

}  // namespace

void draw_look_settings(Studio& studio, const Gui& gui) {
  Look& look = studio.view().look;
  constexpr std::array materials{render::Material::clay, render::Material::matcap, render::Material::flat};
  choose_one("Shading", look.material, materials, [](render::Material material) {
    return std::array{"Clay", "Matcap", "Flat"}[static_cast<std::size_t>(material)];
  });
  if (look.material == render::Material::matcap) draw_matcaps(look, gui);
  ImGui::Checkbox("Cavity", &look.relief.cavity);
  help_on_hover("darkens grooves and brightens ridges");
  ImGui::SameLine();
  ImGui::Checkbox("Occlusion", &look.relief.occlusion);
  help_on_hover("darkens folds and corners");
  draw_background(look.background);
  draw_projection(studio.navigation().view);
}

}  // namespace knead::studio
