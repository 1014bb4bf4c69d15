// The list of fonts, each shown by letters in it.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

// Returns the outline of some letters in a font, given by its file; empty for a font that lacks them.
const std::vector<PlaneLine>& letters_in(const std::string& font) {
  static std::map<std::string, std::vector<PlaneLine>> outlines;
  const auto [entry, is_new] = outlines.try_emplace(font);
  try {
    if (is_new) entry->second = print_outline({.text = "Rag", .font = font, .height = 1, .depth = 1}, {});
  } catch (const InvalidInput&) {
    entry->second.clear();
  }
  return entry->second;
}

// A row of the list of fonts: letters in it, and its name.
bool choose_font(const std::string& name, const std::string& file, bool is_chosen) {
  constexpr float kLettersWidth = 3.2F;  // font sizes
  const float size = ImGui::GetFontSize();
  const float height = 1.7F * size;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float width = kLettersWidth * size + ImGui::CalcTextSize(name.c_str()).x;
  ImGui::PushID(name.c_str());
  const bool is_clicked =
      ImGui::Selectable("##font", is_chosen, 0, {std::max(width, ImGui::GetContentRegionAvail().x), height});
  ImGui::PopID();
  if (!ImGui::IsItemVisible()) return is_clicked;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImU32 colour = ImGui::GetColorU32(ImGuiCol_Text);
  const auto place = [&](const std::array<double, 2>& p) {
    return ImVec2{corner.x + size * (0.5F * kLettersWidth - 0.2F + static_cast<float>(p[0])),
                  corner.y + 0.5F * height - size * static_cast<float>(p[1])};
  };
  for (const auto& [from, to] : letters_in(file)) list.AddLine(place(from), place(to), colour);
  list.AddText({corner.x + kLettersWidth * size, corner.y + 0.5F * (height - size)}, colour, name.c_str());
  return is_clicked;
}

}  // namespace

// The fonts of this computer, which are listed once.
void draw_font(std::string& font) {
  static const std::map<std::string, std::filesystem::path> kFonts = font_files();
  if (begin_list("Font", font.empty() ? "standard" : font)) {
    if (choose_font("standard", "", font.empty())) font.clear();
    for (const auto& [name, file] : kFonts) {
      if (choose_font(name, file.string(), name == font)) font = name;
    }
    end_list();
  }
  help_on_hover("of the text; its capital letters are as high as the radius");
}

}  // namespace knead::studio
