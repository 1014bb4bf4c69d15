// Questions to the person, and the search of commands.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "keys.h"
#include "panels/interface.h"
#include "panels/widgets.h"

namespace knead::studio {

namespace fs = std::filesystem;

namespace {

// Begins a question in the middle of the window; to be ended with EndPopup where it returns true.
bool begin_question(const char* title) {
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * size.x, 0.5F * size.y}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {0.9F * size.x, 0.9F * size.y});
  return ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);
}

// What the file dialogs begin at.
fs::path nearby(const Studio& studio, FileUse use) {
  const DocumentState& shown = studio.document().shown();
  if (use == FileUse::save && !shown.session_path.empty()) return shown.session_path;
  if (!shown.shape_path.empty()) return shown.shape_path;
  if (!shown.session_path.empty()) return shown.session_path;
  std::string name = shown.title;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

void draw_new_shape(Studio& studio, Dialogs& dialogs) {
  if (!begin_question("New shape")) return;
  const std::span<const std::string_view> names = shape_names();
  const auto kind = static_cast<std::size_t>(dialogs.new_kind);
  if (begin_list("Kind", std::string(names[kind]), 20 * ImGui::GetFontSize())) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (ImGui::Selectable(std::string(names[i]).c_str(), i == kind)) dialogs.new_kind = static_cast<ShapeKind>(i);
    }
    end_list();
  }
  const ShapeCounts counts = shape_counts(dialogs.new_kind);
  const int least = static_cast<int>(counts.minimum);
  const int most = static_cast<int>(std::min<std::size_t>(counts.maximum, 1'000'000));
  const double part = std::log(static_cast<double>(dialogs.new_vertices) / least) / std::log(1.0 * most / least);
  draw_filled("Vertices", part, fmt::format("{}", dialogs.new_vertices), -1, [&](const char* hidden) {
    return ImGui::SliderInt(hidden, &dialogs.new_vertices, least, most, "%d", ImGuiSliderFlags_Logarithmic);
  });
  dialogs.new_vertices = std::clamp(dialogs.new_vertices, least, most);
  if (ImGui::Button("Create") || enter_pressed()) {
    dialogs.is_new_shape_open = false;
    do_or_ask(studio, dialogs, [&studio, kind_wanted = dialogs.new_kind, count = dialogs.new_vertices] {
      studio.document().open_made(kind_wanted, static_cast<std::size_t>(count));
    });
  }
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || escape_pressed()) dialogs.is_new_shape_open = false;
  if (!dialogs.is_new_shape_open) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

std::string title_of(const AbandonedJournal& journal) {
  const std::time_t changed = std::chrono::system_clock::to_time_t(journal.changed);
  return fmt::format(
      "{}: {}, {}", fmt::format("{:%d %b %H:%M}", fmt::localtime(changed)), journal.title,
      journal.entries == 1 ? "1 entry of the history" : fmt::format("{} entries of the history", journal.entries));
}

// Returns the journal that is to be opened.
std::optional<fs::path> draw_journal(Studio& studio, Dialogs& dialogs, const AbandonedJournal& journal) {
  std::optional<fs::path> chosen;
  ImGui::PushID(journal.folder.c_str());
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(title_of(journal).c_str());
  if (journal.problem.empty()) {
    if (ImGui::Button("Recover")) chosen = journal.folder;
    ImGui::SameLine();
  } else {
    text_in_colour(kWarning, journal.problem);
  }
  const bool sure = dialogs.to_discard == journal.folder;
  if (ImGui::Button(sure ? "Click again to delete" : "Delete")) {
    if (sure) studio.document().discard(fs::path(journal.folder));
    dialogs.to_discard = sure ? std::nullopt : std::optional(journal.folder);
  }
  ImGui::PopID();
  return chosen;
}

void draw_recovery(Studio& studio, Dialogs& dialogs) {
  if (!begin_question("Recover unsaved work")) return;
  ImGui::TextUnformatted("Studio ended unexpectedly. This work was not saved:");
  ImGui::Separator();
  std::optional<fs::path> chosen;
  const std::vector<AbandonedJournal> journals = studio.document().abandoned();
  for (const AbandonedJournal& journal : journals) {
    if (const auto folder = draw_journal(studio, dialogs, journal)) chosen = folder;
    ImGui::Separator();
  }
  if (enter_pressed() && !journals.empty() && journals.front().problem.empty()) chosen = journals.front().folder;
  if (ImGui::Button("Later") || escape_pressed() || studio.document().abandoned().empty())
    dialogs.is_recovery_open = false;
  ImGui::SameLine();
  ImGui::TextDisabled("File > Recover unsaved work... opens this dialog again.");
  if (chosen) {
    dialogs.is_recovery_open = false;
    do_or_ask(studio, dialogs, [&studio, folder = *chosen] { studio.document().recover(folder); });
  }
  if (!dialogs.is_recovery_open) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

// Goes on once the work is saved, gives up where that failed.
void follow_saving(Studio& studio, Dialogs& dialogs) {
  if (dialogs.file.is_open || studio.document().worker().is_busy()) return;
  dialogs.is_saving = false;
  const std::function<void()> what = std::exchange(dialogs.pending, nullptr);
  if (!studio.document().shown().is_changed) what();
}

void draw_question(Studio& studio, Dialogs& dialogs) {
  if (!begin_question("Save the changes?")) return;
  ImGui::Text("%s has changes that are not saved.", studio.document().shown().title.c_str());
  bool done = true;
  if (ImGui::Button("Save") || enter_pressed()) {
    dialogs.is_saving = true;
    studio.perform(Action::save);
  } else if (ImGui::SameLine(), ImGui::Button("Do not save")) {
    const std::function<void()> what = std::exchange(dialogs.pending, nullptr);
    what();
  } else if (ImGui::SameLine(), ImGui::Button("Cancel") || escape_pressed()) {
    dialogs.pending = nullptr;
  } else {
    done = false;
  }
  if (done) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

// Shows the frame that the dialog asks for, and the present shape once it asks for none.
void show_frame(Studio& studio, Dialogs& dialogs) {
  const FileDialog& asked = dialogs.file;
  const int frame = asked.is_open && asked.use == FileUse::export_frames ? asked.frame : 0;
  if (frame == dialogs.frame && (frame == 0 || asked.motion == dialogs.motion)) return;
  dialogs.frame = frame;
  dialogs.motion = asked.motion;
  if (frame > 0) {
    studio.history().look_at_frame(asked.motion, frame - 1);
  } else {
    studio.history().look_at(std::nullopt);
  }
}

constexpr int kRowsShown = 12;

// Returns the action that was clicked.
std::optional<Action> draw_found(const Studio& studio, CommandSearch& search, const std::vector<Action>& found) {
  std::optional<Action> clicked;
  if (ImGui::BeginChild("found", {-1, kRowsShown * ImGui::GetTextLineHeightWithSpacing()}, true)) {
    if (found.empty()) ImGui::TextDisabled("No command has these words.");
    begin_rows();
    for (std::size_t i = 0; i < found.size(); ++i) {
      const bool is_chosen = i == search.chosen;
      const std::string keys =
          place_of(found[i]) + (is_touched() ? "" : "   " + keys_text(studio.preferences().keys, found[i]));
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Selectable(std::string(title_of(found[i])).c_str(), is_chosen)) clicked = found[i];
      if (is_chosen && !ImGui::IsItemVisible()) ImGui::SetScrollHereY();
      ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(keys.c_str()).x);
      ImGui::TextDisabled("%s", keys.c_str());
      ImGui::PopID();
    }
    end_rows();
  }
  ImGui::EndChild();
  return clicked;
}

}  // namespace

void do_or_ask(Studio& studio, Dialogs& dialogs, std::function<void()> what) {
  if (!studio.document().shown().is_changed) return what();
  dialogs.is_saving = false;
  dialogs.pending = std::move(what);
}

bool answer_request(Studio& studio, Dialogs& dialogs, Action action) {
  const auto ask_for_file = [&](FileUse use) {
    const std::shared_ptr<const Mesh>& mesh = studio.document().shown().state.mesh;
    dialogs.file.has_faces = mesh == nullptr || mesh->face_count() > 0;
    open_file_dialog(dialogs.file, use, nearby(studio, use), studio.preferences().desktop_dialogs);
  };
  switch (action) {
    case Action::new_shape:
      dialogs.is_new_shape_open = true;
      return true;
    case Action::open:
      ask_for_file(FileUse::open);
      return true;
    case Action::add_shape:
      ask_for_file(studio.document().shown().opened != 0 ? FileUse::add : FileUse::open);
      return true;
    case Action::save_as:
      ask_for_file(FileUse::save);
      return true;
    case Action::export_shape:
      ask_for_file(FileUse::export_shape);
      return true;
    case Action::export_frames:
      ask_for_file(FileUse::export_frames);
      return true;
    case Action::picture:
      ask_for_file(FileUse::picture);
      return true;
    case Action::poster:
      ask_for_file(FileUse::poster);
      return true;
    case Action::turntable:
      ask_for_file(FileUse::turntable);
      return true;
    case Action::stamp_file:
      ask_for_file(FileUse::stamp);
      return true;
    case Action::fit:
      if (studio.document().shown().opened != 0) ask_for_file(FileUse::target);
      return true;
    case Action::reference_image:
      ask_for_file(FileUse::reference);
      return true;
    case Action::recover:
      dialogs.is_recovery_open = !studio.document().abandoned().empty();
      if (!dialogs.is_recovery_open) studio.document().tell({false, "There is no unsaved work to recover."});
      return true;
    case Action::welcome:
      dialogs.welcome.is_open = true;
      return true;
    case Action::tour:
      dialogs.welcome.tour = 0;
      dialogs.welcome.entries = studio.document().shown().history.size();
      return true;
    case Action::search:
      dialogs.search.is_open = true;
      return true;
    default:
      return false;
  }
}

void draw_dialogs(Studio& studio, Dialogs& dialogs, const Gui& gui,
                  const std::function<void(const fs::path&)>& picture) {
  const std::vector<fs::path> files = draw_file_dialog(dialogs.file, gui);
  show_frame(studio, dialogs);
  if (!files.empty()) {
    const fs::path& file = files.front();
    switch (dialogs.file.use) {
      case FileUse::open:
        do_or_ask(studio, dialogs, [&studio, files] { studio.handle(FilesDropped{files}); });
        break;
      case FileUse::add:
        for (const fs::path& each : files) studio.add_shape(each);
        break;
      case FileUse::stamp:
        studio.tools().use_stamp(file);
        break;
      case FileUse::target:
        studio.fit().open(file, studio.view().navigation());
        break;
      case FileUse::reference:
        studio.view().add_reference(file);
        break;
      case FileUse::save:
        studio.document().save(file);
        break;
      case FileUse::export_shape:
        studio.document().export_shape(file, dialogs.file.as_double);
        break;
      case FileUse::export_frames:
        studio.document().export_frames(file, dialogs.file.motion);
        break;
      case FileUse::picture:
        picture(file);
        break;
      case FileUse::poster:
        studio.view().write_poster(file, dialogs.file.poster);
        break;
      case FileUse::turntable:
        studio.view().record_turntable(file, dialogs.file.pictures);
        break;
    }
  }
  draw_search(studio, gui, dialogs.search);
  draw_welcome(studio, dialogs, gui);
  if (dialogs.is_new_shape_open) draw_new_shape(studio, dialogs);
  if (dialogs.is_recovery_open) draw_recovery(studio, dialogs);
  if (dialogs.pending && dialogs.is_saving) {
    follow_saving(studio, dialogs);
  } else if (dialogs.pending) {
    draw_question(studio, dialogs);
  }
}

// --- the search of commands ------------------------------------------------------------------------------------------

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
  if (is_pressed(ImGuiKey_DownArrow)) ++search.chosen;
  if (is_pressed(ImGuiKey_UpArrow) && search.chosen > 0) --search.chosen;
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
