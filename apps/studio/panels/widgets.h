// Small things that panels are made of.
#pragma once

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>

#include "platform/imgui_keys.h"

namespace knead::studio {

inline const ImVec4 kWarning{0.95F, 0.72F, 0.35F, 1};
inline const ImVec4 kError{0.96F, 0.50F, 0.44F, 1};

// Whether fingers press (Gui::set_touch).
inline bool is_touched() { return ImGui::GetStyle().TouchExtraPadding.y > 0; }

// Between these two, rows of lists and menus are as high as a finger.
inline void begin_rows() {
  const ImVec2 spacing = ImGui::GetStyle().ItemSpacing;
  const float gap = is_touched() ? ImGui::GetFrameHeight() - ImGui::GetFontSize() : spacing.y;
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {spacing.x, gap});
}

inline void end_rows() { ImGui::PopStyleVar(); }

// A button within a text; as high as others where fingers press.
inline bool small_button(const char* label) { return is_touched() ? ImGui::Button(label) : ImGui::SmallButton(label); }

struct Limits {
  double least;
  double most;
};

// The next tooltip stands beside the window of the last item, where it covers no other item.
inline void place_tooltip() {
  const ImGuiWindow& window = *ImGui::GetCurrentWindow()->RootWindow;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const ImVec2 from = ImGui::GetItemRectMin();
  const ImVec2 to = ImGui::GetItemRectMax();
  const float gap = 0.4F * ImGui::GetFontSize();
  const bool is_left = from.x < 0.6F * display.x;
  const bool is_high = from.y < 0.6F * display.y;
  ImVec2 at{is_left ? from.x : to.x, is_high ? from.y : to.y};
  ImVec2 pivot{is_left ? 0.0F : 1.0F, is_high ? 0.0F : 1.0F};
  if (window.Size.x > 0.5F * display.x) {
    at.y = is_high ? window.Pos.y + window.Size.y + gap : window.Pos.y - gap;
  } else {
    const bool is_beside = window.Pos.x + 0.5F * window.Size.x < 0.5F * display.x;
    at.x = is_beside ? window.Pos.x + window.Size.x + gap : window.Pos.x - gap;
    pivot.x = is_beside ? 0.0F : 1.0F;
  }
  ImGui::SetNextWindowPos(at, ImGuiCond_Always, pivot);
}

// None while something is edited.
inline void help_on_hover(const char* help) {
  if (help == nullptr || *help == '\0' || !ImGui::IsItemHovered() || ImGui::IsAnyItemActive()) return;
  place_tooltip();
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

// How a slider is shown: the sign of its unit, and its width in pixels; a negative one is measured from the right end.
struct SliderLook {
  const char* unit = "";
  float width = -1;
};

// Draws a slider as a bar that is filled from its left end by `fraction`, with its name and its value in it. `slider`
// makes the widget, with this hidden label. Returns what it returns.
template <class Slider>
bool draw_filled(const char* label, double fraction, const std::string& value, float width, const Slider& slider) {
  const std::string hidden = std::string("##").append(label);
  ImGui::SetNextItemWidth(width);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 end{corner.x + ImGui::CalcItemWidth(), corner.y + ImGui::GetFrameHeight()};
  const ImGuiStyle& style = ImGui::GetStyle();
  const ImGuiID id = ImGui::GetID(hidden.c_str());
  const bool is_typed = ImGui::TempInputIsActive(id);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const bool is_lit = ImGui::GetHoveredID() == id || ImGui::GetActiveID() == id;
  list.AddRectFilled(corner, end, ImGui::GetColorU32(is_lit ? ImGuiCol_FrameBgHovered : ImGuiCol_FrameBg),
                     style.FrameRounding);
  const float filled = corner.x + static_cast<float>(std::clamp(fraction, 0.0, 1.0)) * (end.x - corner.x);
  if (!is_typed && filled > corner.x + 1) {
    const ImGuiCol fill = ImGui::GetActiveID() == id ? ImGuiCol_SliderGrabActive : ImGuiCol_SliderGrab;
    list.AddRectFilled(corner, {filled, end.y}, ImGui::GetColorU32(fill), style.FrameRounding);
  }
  const ImVec4 none{0, 0, 0, 0};
  for (const ImGuiCol part : {ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive, ImGuiCol_SliderGrab,
                              ImGuiCol_SliderGrabActive}) {
    ImGui::PushStyleColor(part, none);
  }
  ImGui::PushStyleColor(ImGuiCol_Text, is_typed ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : none);
  const bool is_changed = slider(hidden.c_str());
  ImGui::PopStyleColor(6);
  if (is_typed) return is_changed;
  const ImU32 ink = ImGui::GetColorU32(ImGuiCol_Text);
  const float y = corner.y + style.FramePadding.y;
  const float right = end.x - style.FramePadding.x - ImGui::CalcTextSize(value.c_str()).x;
  list.PushClipRect(corner, {right - style.FramePadding.x, end.y}, true);
  list.AddText({corner.x + style.FramePadding.x, y}, ink, label);
  list.PopClipRect();
  list.AddText({right, y}, ink, value.c_str());
  return is_changed;
}

// A slider, logarithmic where both limits are positive; Ctrl+click to type a number. One beyond the limits asks first.
inline void slide(const char* label, double& value, Limits limits, const char* help, const SliderLook& look = {}) {
  const bool is_logarithmic = limits.least > 0;
  const auto place = [&](double x) { return is_logarithmic ? std::log(std::max(x, limits.least)) : x; };
  const double fraction = (place(value) - place(limits.least)) / (place(limits.most) - place(limits.least));
  const bool is_apart = std::isalpha(static_cast<unsigned char>(look.unit[0])) != 0;
  const std::string text = fmt::format("{:.4g}{}{}", value, is_apart ? " " : "", look.unit);
  double changed = value;
  bool is_changed = false;
  bool is_typed = false;
  draw_filled(label, fraction, text, look.width, [&](const char* hidden) {
    take_comma_as_point(hidden);
    is_typed = ImGui::TempInputIsActive(ImGui::GetID(hidden));
    is_changed = ImGui::SliderScalar(hidden, ImGuiDataType_Double, &changed, &limits.least, &limits.most, "%.4g",
                                     is_logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
    note_edited(hidden);
    return is_changed;
  });
  help_on_hover(help);
  const bool is_possible = is_changed && std::isfinite(changed) && (!is_logarithmic || changed > 0);
  // A slider rounds what it gives, at its ends beyond them.
  if (!is_typed) changed = std::clamp(changed, limits.least, limits.most);
  const bool is_within = changed >= limits.least && changed <= limits.most;
  if (is_possible && is_within) value = changed;
  ask_about_number(label, value, is_possible && !is_within ? std::optional(changed) : std::nullopt, limits);
}

// The same for a whole number, which is kept within its limits. `text` is its value as a person reads it.
inline bool slide_whole(const char* label, int& value, int least, int most, const std::string& text, float width = -1) {
  const double fraction = static_cast<double>(value - least) / (most - least);
  return draw_filled(label, fraction, text, width, [&](const char* hidden) {
    return ImGui::SliderInt(hidden, &value, least, most, "%d", ImGuiSliderFlags_AlwaysClamp);
  });
}

// A number to be typed, kept within the limits.
inline bool type_number(const char* label, double& value, Limits limits, const char* help,
                        const char* format = "%.6g") {
  double changed = value;
  take_comma_as_point(label);
  ImGui::InputDouble(label, &changed, 0, 0, format);
  const bool done = ImGui::IsItemDeactivatedAfterEdit();
  note_edited(label);
  help_on_hover(help);
  if (!done || !(changed >= limits.least && changed <= limits.most) || changed == value) return false;
  value = changed;
  return true;
}

// Begins a list that folds out, with its name and what is chosen in it, as sliders have them. A label that begins with
// "##" has no name. Call end_list() if it is open.
inline bool begin_list(const char* label, const std::string& chosen, float width = -1) {
  const bool has_name = label[0] != '#';
  ImGui::SetNextItemWidth(width);
  const bool is_open = ImGui::BeginCombo((has_name ? std::string("##") + label : label).c_str(),
                                         (has_name ? fmt::format("{}: {}", label, chosen) : chosen).c_str());
  if (is_open) begin_rows();
  return is_open;
}

inline void end_list() {
  end_rows();
  ImGui::EndCombo();
}

// One of several. name(value) gives what a person reads.
template <class T, class Values, class Name>
bool choose_one(const char* label, T& value, const Values& values, const Name& name, float width = -1) {
  bool changed = false;
  if (!begin_list(label, name(value), width)) return false;
  for (const T& each : values) {
    if (!ImGui::Selectable(name(each), each == value)) continue;
    changed = each != value;
    value = each;
  }
  end_list();
  return changed;
}

// Keys in a dialog. Enter means its first button: not in the frame in which it appears, nor in a field.
inline bool escape_pressed() { return is_pressed(ImGuiKey_Escape, false); }

inline bool enter_pressed() {
  return !ImGui::IsWindowAppearing() && !ImGui::IsAnyItemActive() &&
         (is_pressed(ImGuiKey_Enter, false) || is_pressed(kNumpadEnter, false));
}

inline void text_in_colour(const ImVec4& colour, const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

}  // namespace knead::studio
