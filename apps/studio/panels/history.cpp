// The history: what was done, looking back, and changing what was done.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "document/stroke_fields.h"
#include "knead/math/error.h"
#include "panels/panels.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace {

std::string lines_of(const std::vector<SessionStroke>& strokes) {
  std::string text;
  for (const SessionStroke& stroke : strokes) text += stroke_line(stroke.stroke) + "\n";
  return text;
}

// The strokes of the lines as typed, remeshed as those before were.
std::vector<SessionStroke> strokes_of_lines(const std::string& text, const std::optional<RemeshSettings>& remesh) {
  Session session = parse_session(header_line({}, {}) + "\n" + text, "history");
  for (SessionStroke& stroke : session.strokes) stroke.remesh = remesh;
  if (session.strokes.empty()) throw InvalidInput("no stroke is left; use \"Remove\" instead");
  return session.strokes;
}

void start_editing(HistoryEditor& editor, const DocumentState& shown, std::size_t entry) {
  editor.entry = entry;
  editor.opened = shown.opened;
  editor.strokes = shown.history[entry]->strokes;
  editor.text = lines_of(editor.strokes);
  editor.problem.clear();
}

void draw_numbers(HistoryEditor& editor) {
  for (const StrokeField& field : fields_of(editor.strokes)) {
    double value = field.value;
    if (!type_number(field.name.c_str(), value, {-1e9, 1e9}, field.help.c_str())) continue;
    set_field(editor.strokes, field.name, value);
    editor.text = lines_of(editor.strokes);
    editor.problem.clear();
  }
}

void draw_text(HistoryEditor& editor) {
  if (!ImGui::TreeNode("Edit as session lines")) return;
  const ImVec2 size{-1, ImGui::GetTextLineHeight() * 7};
  if (ImGui::InputTextMultiline("##lines", &editor.text, size)) {
    try {
      const auto remesh = editor.strokes.empty() ? std::nullopt : editor.strokes.front().remesh;
      editor.strokes = strokes_of_lines(editor.text, remesh);
      editor.problem.clear();
    } catch (const InvalidInput& error) {
      editor.problem = error.what();
    }
  }
  ImGui::TreePop();
}

void draw_editor(Studio& studio, HistoryEditor& editor) {
  ImGui::Indent();
  draw_numbers(editor);
  draw_text(editor);
  if (!editor.problem.empty()) text_in_colour(kWarning, editor.problem);
  const bool changed = editor.strokes != studio.shown().history[*editor.entry]->strokes;
  ImGui::BeginDisabled(!changed || !editor.problem.empty());
  if (ImGui::Button("Apply and redo the rest")) studio.edit(*editor.entry, editor.strokes);
  ImGui::EndDisabled();
  if (ImGui::Button("Show")) studio.look_at(*editor.entry + 1);
  ImGui::SameLine();
  if (ImGui::Button("Remove")) {
    studio.edit(*editor.entry, {});
    editor.entry.reset();
  }
  ImGui::Unindent();
}

// "12  implicit, 34 pieces, 18 ms".
std::string label_of(const HistoryEntry& entry, std::size_t number) {
  const std::string what = entry.strokes.empty() ? "nothing" : description_of(entry.strokes);
  return fmt::format("{}  {}, {:.0f} ms###entry{}", number, what, 1000 * entry.seconds, number);
}

void draw_past_banner(Studio& studio) {
  const DocumentState& shown = studio.shown();
  if (!shown.looked_at) return;
  text_in_colour(kWarning,
                 fmt::format("This is the shape after {} of {} strokes.", *shown.looked_at, shown.history.size()));
  if (ImGui::Button("Back to the present")) studio.look_at(std::nullopt);
}

}  // namespace

void draw_history(Studio& studio, HistoryEditor& editor) {
  const DocumentState& shown = studio.shown();
  if (shown.opened == 0) return;
  if (editor.entry && (editor.opened != shown.opened || *editor.entry >= shown.history.size())) editor.entry.reset();
  draw_past_banner(studio);
  if (ImGui::Selectable("0  as it was opened", shown.looked_at == 0U)) {
    studio.look_at(std::size_t{0});
    editor.entry.reset();
  }
  for (std::size_t i = 0; i < shown.history.size(); ++i) {
    const bool open = editor.entry == i;
    if (ImGui::Selectable(label_of(*shown.history[i], i + 1).c_str(), open || shown.looked_at == i + 1)) {
      if (open) {
        editor.entry.reset();
      } else {
        start_editing(editor, shown, i);
      }
    }
    if (editor.entry == i) draw_editor(studio, editor);
  }
  for (std::size_t i = 0; i < shown.redoable.size(); ++i) {
    ImGui::BeginDisabled();
    ImGui::Selectable(label_of(*shown.redoable[i], shown.history.size() + i + 1).c_str());
    ImGui::EndDisabled();
  }
}

}  // namespace knead::studio
