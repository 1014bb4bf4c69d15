// Small things that panels are made of.
#pragma once

#include <imgui.h>

#include <cmath>
#include <string>

namespace knead::studio {

inline const ImVec4 kWarning{0.95F, 0.72F, 0.35F, 1};
inline const ImVec4 kError{0.96F, 0.50F, 0.44F, 1};

struct Limits {
  double least;
  double most;
};

inline void help_on_hover(const char* help) {
  if (help == nullptr || !ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
  ImGui::TextUnformatted(help);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

// A slider, logarithmic where both limits are positive; Ctrl+click to type a number, which may lie beyond them.
inline void slide(const char* label, double& value, Limits limits, const char* help) {
  const int flags = limits.least > 0 ? ImGuiSliderFlags_Logarithmic : 0;
  double changed = value;
  if (ImGui::SliderScalar(label, ImGuiDataType_Double, &changed, &limits.least, &limits.most, "%.4g", flags) &&
      std::isfinite(changed) && (limits.least <= 0 || changed > 0)) {
    value = changed;
  }
  help_on_hover(help);
}

// A number to be typed, kept within the limits.
inline bool type_number(const char* label, double& value, Limits limits, const char* help,
                        const char* format = "%.6g") {
  double changed = value;
  const bool done = ImGui::InputDouble(label, &changed, 0, 0, format, ImGuiInputTextFlags_EnterReturnsTrue) ||
                    ImGui::IsItemDeactivatedAfterEdit();
  help_on_hover(help);
  if (!done || !(changed >= limits.least && changed <= limits.most) || changed == value) return false;
  value = changed;
  return true;
}

// One of several, in a list that folds out. name(value) gives what a person reads.
template <class T, class Values, class Name>
bool choose_one(const char* label, T& value, const Values& values, const Name& name) {
  bool changed = false;
  if (!ImGui::BeginCombo(label, name(value))) return false;
  for (const T& each : values) {
    if (!ImGui::Selectable(name(each), each == value)) continue;
    changed = each != value;
    value = each;
  }
  ImGui::EndCombo();
  return changed;
}

// Keys in a dialog. Enter means its first button: not in the frame in which it appears, nor in a field.
inline bool escape_pressed() { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false); }

inline bool enter_pressed() {
  return !ImGui::IsWindowAppearing() && !ImGui::IsAnyItemActive() &&
         (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), false) ||
          ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_KeyPadEnter), false));
}

inline void text_in_colour(const ImVec4& colour, const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

}  // namespace knead::studio
