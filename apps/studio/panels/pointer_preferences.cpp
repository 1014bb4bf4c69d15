// Preferences of the pointer: the unit of lengths, what a pen's pressure changes, the colours of the cursor.
#include <imgui.h>

#include <array>

#include "panels/panels.h"

namespace knead::studio {

namespace {

template <class T, std::size_t N>
bool choose_in_menu(const char* label, T& value, const std::array<const char*, N>& names) {
  bool changed = false;
  if (!ImGui::BeginMenu(label)) return false;
  for (std::size_t i = 0; i < N; ++i) {
    const T each = static_cast<T>(i);
    if (!ImGui::MenuItem(names[i], nullptr, value == each)) continue;
    changed = value != each;
    value = each;
  }
  ImGui::EndMenu();
  return changed;
}

bool choose_color(const char* label, render::Color& color) {
  std::array<float, 3> parts{color.red, color.green, color.blue};
  const bool changed = ImGui::ColorEdit3(label, parts.data(), ImGuiColorEditFlags_NoInputs);
  if (changed) color = {parts[0], parts[1], parts[2], 1};
  return changed;
}

}  // namespace

bool draw_pointer_preferences(Preferences& preferences) {
  bool changed =
      choose_in_menu("Unit of the file", preferences.unit, std::array{"None", "Millimetres", "Centimetres", "Metres"});
  changed = choose_in_menu("Pen pressure", preferences.pressure, std::array{"None", "Radius", "Depth"}) || changed;
  if (ImGui::BeginMenu("Cursor colours")) {
    changed = choose_color("Outer ring", preferences.outer_ring) || changed;
    changed = choose_color("Inner ring", preferences.inner_ring) || changed;
    if (ImGui::MenuItem("Defaults")) {
      preferences.outer_ring = Preferences{}.outer_ring;
      preferences.inner_ring = Preferences{}.inner_ring;
      changed = true;
    }
    ImGui::EndMenu();
  }
  return changed;
}

}  // namespace knead::studio
