// Small things that panels are made of.
#pragma once

#include <imgui.h>

#include <cmath>
#include <optional>
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

// Makes a decimal point of a comma that is typed into the number of this label, if it was being edited in the frame
// before. note_edited() after the widget says whether it is.
inline void take_comma_as_point(const char* label) {
  if (!ImGui::GetStateStorage()->GetBool(ImGui::GetID(label))) return;
  for (ImWchar& c : ImGui::GetIO().InputQueueCharacters) c = c == ',' ? ImWchar{'.'} : c;
}

inline void note_edited(const char* label) {
  ImGui::GetStateStorage()->SetBool(ImGui::GetID(label), ImGui::IsItemActive());
}

// Asks whether a typed number beyond the limits of a slider is meant. `asked`: it was typed in this frame.
inline void ask_about_number(const char* label, double& value, std::optional<double> asked, Limits limits) {
  ImGui::PushID(label);
  ImGuiStorage& storage = *ImGui::GetStateStorage();
  if (asked) {
    storage.SetFloat(ImGui::GetID("asked"), static_cast<float>(*asked));
    ImGui::OpenPopup("beyond");
  }
  if (ImGui::BeginPopup("beyond")) {
    const double number = storage.GetFloat(ImGui::GetID("asked"));
    ImGui::Text("%.6g is not from %.4g to %.4g, the range of the slider.", number, limits.least, limits.most);
    if (ImGui::Button("Use it")) {
      value = number;
      ImGui::CloseCurrentPopup();
    }
    ImGui::SameLine();
    if (ImGui::Button("Keep the old one")) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  ImGui::PopID();
}

// A slider, logarithmic where both limits are positive; Ctrl+click to type a number. One beyond the limits asks first.
inline void slide(const char* label, double& value, Limits limits, const char* help) {
  const int flags = limits.least > 0 ? ImGuiSliderFlags_Logarithmic : 0;
  double changed = value;
  take_comma_as_point(label);
  const bool is_changed =
      ImGui::SliderScalar(label, ImGuiDataType_Double, &changed, &limits.least, &limits.most, "%.4g", flags);
  note_edited(label);
  help_on_hover(help);
  const bool is_possible = is_changed && std::isfinite(changed) && (limits.least <= 0 || changed > 0);
  const bool is_within = changed >= limits.least && changed <= limits.most;
  if (is_possible && is_within) value = changed;
  ask_about_number(label, value, is_possible && !is_within ? std::optional(changed) : std::nullopt, limits);
}

// A number to be typed, kept within the limits.
inline bool type_number(const char* label, double& value, Limits limits, const char* help,
                        const char* format = "%.6g") {
  double changed = value;
  take_comma_as_point(label);
  const bool done = ImGui::InputDouble(label, &changed, 0, 0, format, ImGuiInputTextFlags_EnterReturnsTrue) ||
                    ImGui::IsItemDeactivatedAfterEdit();
  note_edited(label);
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
