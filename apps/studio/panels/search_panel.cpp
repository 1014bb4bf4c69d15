// The search of commands.
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <optional>
#include <string>

#include "panels/dialogs.h"
#include "panels/widgets.h"
#include "search.h"

namespace knead::studio {

namespace {

constexpr int kRowsShown = 12;

// Returns the action that was clicked.
std::optional<Action> draw_found(const Studio& studio, CommandSearch& search, const std::vector<Action>& found) {
  std::optional<Action> clicked;
  if (ImGui::BeginChild("found", {-1, kRowsShown * ImGui::GetTextLineHeightWithSpacing()}, true)) {
    if (found.empty()) ImGui::TextDisabled("No command has these words.");
    for (std::size_t i = 0; i < found.size(); ++i) {
      const bool is_chosen = i == search.chosen;
      const std::string keys = keys_text(studio.preferences().keys, found[i]);
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Selectable(std::string(title_of(found[i])).c_str(), is_chosen)) clicked = found[i];
      if (is_chosen && !ImGui::IsItemVisible()) ImGui::SetScrollHereY();
      ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(keys.c_str()).x);
      ImGui::TextDisabled("%s", keys.c_str());
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
  return clicked;
}

}  // namespace

void draw_search(Studio& studio, const Gui& gui, CommandSearch& search) {
  constexpr const char* kTitle = "Search commands";
  if (!search.is_open) return;
  if (!ImGui::IsPopupOpen(kTitle)) ImGui::OpenPopup(kTitle);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, 0.12F * size.y}, ImGuiCond_Always, {0.5F, 0});
  ImGui::SetNextWindowSize({std::min(440 * gui.unit(), 0.95F * size.x), 0});
  if (!ImGui::BeginPopupModal(kTitle, nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove)) return;
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-1);
  std::optional<Action> action;
  const bool enters = ImGui::InputText("##words", &search.text, ImGuiInputTextFlags_EnterReturnsTrue);
  if (ImGui::IsItemEdited()) search.chosen = 0;
  const std::vector<Action> found = found_actions(search.text);
  const auto pressed = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); };
  if (pressed(ImGuiKey_DownArrow)) ++search.chosen;
  if (pressed(ImGuiKey_UpArrow) && search.chosen > 0) --search.chosen;
  search.chosen = std::min(search.chosen, found.empty() ? 0 : found.size() - 1);
  if (enters && !found.empty()) action = found[search.chosen];
  if (const auto clicked = draw_found(studio, search, found)) action = clicked;
  if (action || escape_pressed()) {
    search = {};
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
  if (action) studio.perform(*action);
}

}  // namespace knead::studio
