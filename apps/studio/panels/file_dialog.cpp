// Studio's own file dialog: the list of a folder, the name, and what the formats are.
#include "panels/file_dialog.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "gestures/tools.h"
#include "knead/editor/tools.h"
#include "knead/io.h"
#include "panels/widgets.h"
#include "platform/gui.h"

namespace knead::studio {

namespace fs = std::filesystem;

namespace {

constexpr float kFormatWidth = 12;  // font sizes

bool ends_in(const std::string& name, std::span<const std::string> extensions) {
  const std::string end = lower(fs::path(name).extension().string());
  return extensions.empty() || std::find(extensions.begin(), extensions.end(), end) != extensions.end();
}

}  // namespace

FileList list_files(const fs::path& folder, std::span<const std::string> extensions) {
  FileList list;
  std::error_code error;
  fs::directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    ListedFile file{entry->path().filename().string()};
    if (file.name.starts_with('.')) continue;
    std::error_code ignored;
    file.is_folder = entry->is_directory(ignored);
    if (!file.is_folder) file.bytes = entry->file_size(ignored);
    if (ignored) file.bytes = 0;
    if (file.is_folder || ends_in(file.name, extensions)) list.files.push_back(file);
  }
  if (error) list.problem = folder.string() + " cannot be listed: " + error.message();
  std::sort(list.files.begin(), list.files.end(), [](const ListedFile& a, const ListedFile& b) {
    if (a.is_folder != b.is_folder) return a.is_folder;
    const std::string x = lower(a.name);
    const std::string y = lower(b.name);
    return x != y ? x < y : a.name < b.name;
  });
  return list;
}

std::string with_extension(const std::string& name, std::span<const std::string> extensions,
                           const std::string& extension) {
  const std::string own = std::filesystem::path(name).extension().string();
  const bool are_letters = std::all_of(own.begin(), own.end(), [](char c) { return c == '.' || (c | 0x20) >= 'a'; });
  // What looks like the extension of another kind of file is left for the message that there is none.
  const bool is_meant = extensions.size() > 1 && own.size() >= 4 && own.size() <= 6 && are_letters;
  return is_meant || (!extensions.empty() && ends_in(name, extensions)) ? name : name + extension;
}

std::string size_text(std::uintmax_t bytes) {
  constexpr std::array<const char*, 4> units{"KB", "MB", "GB", "TB"};
  if (bytes < 1000) return fmt::format("{} bytes", bytes);
  double size = static_cast<double>(bytes) / 1000;
  std::size_t unit = 0;
  while (size >= 999.5 && unit + 1 < units.size()) {
    size /= 1000;
    ++unit;
  }
  return fmt::format("{:.{}f} {}", size, size < 9.95 ? 1 : 0, units[unit]);
}

namespace fs = std::filesystem;

namespace {

bool writes(FileUse use) { return use > FileUse::reference; }

// Whether more is set in the dialog than a file.
bool has_settings(FileUse use) { return writes(use) && use != FileUse::save && use != FileUse::picture; }

const char* title_of(FileUse use) {
  constexpr std::array titles{"Open a shape or a session",
                              "Add a shape to those that are open",
                              "Choose a closed shape as the stamp, or a picture to print",
                              "Choose the shape to fit to",
                              "Choose a picture to model after",
                              "Save the session",
                              "Export the shape",
                              "Export frames",
                              "Picture",
                              "Poster",
                              "Record a turntable"};
  return titles[static_cast<std::size_t>(use)];
}

std::vector<std::string> extensions_of(FileUse use) {
  if (use == FileUse::save) return {".knead"};
  if (use == FileUse::picture || use == FileUse::poster || use == FileUse::turntable) return {".png"};
  if (use == FileUse::reference) return {".png", ".jpg", ".jpeg"};
  std::vector<std::string> extensions;
  for (const std::string_view name : shape_extensions()) extensions.push_back(fmt::format(".{}", name));
  if (use == FileUse::open) extensions.emplace_back(".knead");
  if (use == FileUse::stamp) extensions.insert(extensions.end(), kPictureExtensions.begin(), kPictureExtensions.end());
  if (use == FileUse::export_frames) extensions.insert(extensions.end(), {".pc2", ".mdd", ".usda", ".pvd"});
  return extensions;
}

std::string proposed_name(FileUse use, const fs::path& near) {
  const std::string stem = near.stem().empty() ? "shape" : near.stem().string();
  switch (use) {
    case FileUse::open:
    case FileUse::add:
    case FileUse::stamp:
    case FileUse::target:
    case FileUse::reference:
      return {};
    case FileUse::save:
      return stem + ".knead";
    case FileUse::export_shape:
      return stem + "_kneaded" +
             (near.has_extension() && near.extension() != ".knead" ? near.extension().string() : ".ply");
    case FileUse::export_frames:
      return stem + "_%04d.ply";
    case FileUse::picture:
      return stem + ".png";
    case FileUse::poster:
      return stem + "_poster.png";
    case FileUse::turntable:
      return stem + "_%04d.png";
  }
  return {};
}

void go_to(FileDialog& dialog, const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(folder, error);
  dialog.folder = error ? folder : whole;
  dialog.typed_folder = dialog.folder.string();
  dialog.list = list_files(dialog.folder, extensions_of(dialog.use));
  dialog.is_sure = false;
}

void draw_places(FileDialog& dialog) {
  // A phone has no folders that its user knows.
  if (must_bring_files() && is_touched()) {
    if (!writes(dialog.use) && ImGui::Button("Choose a file...", {-1, 0})) choose_files_to_bring();
    return;
  }
  if (ImGui::Button("Up")) go_to(dialog, dialog.folder.parent_path());
  ImGui::SameLine();
  const fs::path home = home_folder();
  if (!home.empty() && ImGui::Button("Home")) go_to(dialog, home);
  if (!home.empty()) ImGui::SameLine();
  for (const fs::path& drive : drives()) {
    if (ImGui::Button(drive.string().c_str())) go_to(dialog, drive);
    ImGui::SameLine();
  }
  if (!writes(dialog.use) && must_bring_files()) {
    if (ImGui::Button("From your computer...")) choose_files_to_bring();
    ImGui::SameLine();
  }
  ImGui::SetNextItemWidth(-1);
  if (ImGui::InputText("##folder", &dialog.typed_folder, ImGuiInputTextFlags_EnterReturnsTrue)) {
    go_to(dialog, dialog.typed_folder);
  }
}

// True where a file was chosen by a double click.
bool draw_list(FileDialog& dialog, float height) {
  bool chosen = false;
  std::optional<fs::path> next;
  if (ImGui::BeginChild("files", {-1, height}, true)) {
    begin_rows();
    if (!dialog.list.problem.empty()) text_in_colour(kWarning, dialog.list.problem);
    for (const ListedFile& file : dialog.list.files) {
      const std::string label = file.is_folder ? file.name + "/" : file.name;
      if (ImGui::Selectable(label.c_str(), !file.is_folder && file.name == dialog.name,
                            ImGuiSelectableFlags_AllowDoubleClick | ImGuiSelectableFlags_DontClosePopups)) {
        if (file.is_folder) {
          next = dialog.folder / file.name;
        } else {
          dialog.name = file.name;
          dialog.is_sure = false;
          chosen = ImGui::IsMouseDoubleClicked(0) && !writes(dialog.use);
        }
      }
      if (!file.is_folder) {
        ImGui::SameLine(ImGui::GetContentRegionMax().x - 5 * ImGui::GetFontSize());
        ImGui::TextDisabled("%s", size_text(file.bytes).c_str());
      }
    }
    end_rows();
  }
  ImGui::EndChild();
  if (next) go_to(dialog, *next);
  return chosen;
}

fs::path chosen_path(const FileDialog& dialog) {
  if (!writes(dialog.use)) return dialog.folder / dialog.name;
  const std::vector<std::string> extensions = extensions_of(dialog.use);
  return dialog.folder / with_extension(dialog.name, extensions, extensions.front());
}

// The button that ends it; true once the person is sure.
bool draw_choice(FileDialog& dialog, bool chosen) {
  std::error_code error;
  const bool replaces = writes(dialog.use) && !dialog.name.empty() && fs::exists(chosen_path(dialog), error);
  const char* const label = !writes(dialog.use)          ? "Open"
                            : replaces && dialog.is_sure ? "Replace the existing file"
                                                         : "Save";
  ImGui::BeginDisabled(dialog.name.empty());
  const bool pressed = ImGui::Button(label);
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button("Cancel") || escape_pressed()) {
    dialog.is_open = false;
    return false;
  }
  if ((!pressed && !chosen) || dialog.name.empty()) return false;
  if (fs::is_directory(dialog.folder / dialog.name, error)) {
    go_to(dialog, dialog.folder / std::exchange(dialog.name, {}));
    return false;
  }
  if (replaces && !dialog.is_sure) {
    dialog.is_sure = true;
    return false;
  }
  return true;
}

}  // namespace

void open_file_dialog(FileDialog& dialog, FileUse use, const fs::path& near, bool by_desktop) {
  dialog.use = use;
  dialog.is_open = true;
  dialog.name = proposed_name(use, near);
  dialog.frame = 0;
  std::error_code error;
  fs::path folder = near.parent_path();
  if (folder.empty() || !fs::is_directory(folder, error)) folder = dialog.folder;
  if (folder.empty()) folder = fs::current_path(error);
  go_to(dialog, folder);
  dialog.desktop.reset();
  if (!by_desktop || has_settings(use)) return;
  dialog.desktop = DesktopDialog::ask({title_of(use), dialog.folder / dialog.name, extensions_of(use), writes(use)});
}

namespace {

// How the frames are spaced, in one row, and which of them is looked at.
void draw_motion(FrameExport& motion, int& frame) {
  const float width = 7 * ImGui::GetFontSize();
  ImGui::SetNextItemWidth(width);
  ImGui::SliderInt("Frames", &motion.frames, 2, 600);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(width);
  ImGui::SliderInt("A second", &motion.frames_per_second, 1, 120);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(width);
  ImGui::SliderInt("Hold", &motion.hold, 0, 100);
  help_on_hover("Shows the first and the last frame so many frames longer");
  ImGui::SameLine();
  ImGui::Checkbox("Smooth", &motion.is_smooth);
  help_on_hover("Begins and ends slowly");
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 4);
  frame = std::min(frame, motion.frames);
  ImGui::SliderInt("Preview", &frame, 1, motion.frames, frame == 0 ? "drag to see the motion" : "frame %d",
                   ImGuiSliderFlags_AlwaysClamp);
}

void draw_poster(Poster& poster) {
  struct Size {
    const char* name;
    int width;
    int height;
  };
  constexpr std::array sizes{Size{"1920 x 1080", 1920, 1080}, Size{"3840 x 2160 (4k)", 3840, 2160},
                             Size{"2160 x 3840 (4k, upright)", 2160, 3840}, Size{"4096 x 4096", 4096, 4096}};
  const auto* const chosen =
      std::find_if(sizes.begin(), sizes.end(), [&](const Size& size) { return size.width == poster.width; });
  ImGui::SetNextItemWidth(13 * ImGui::GetFontSize());
  if (ImGui::BeginCombo("##size", chosen != sizes.end() ? chosen->name : "")) {
    for (const Size& size : sizes) {
      if (!ImGui::Selectable(size.name, chosen == &size)) continue;
      poster.width = size.width;
      poster.height = size.height;
    }
    ImGui::EndCombo();
  }
  ImGui::SameLine();
  ImGui::Checkbox("Transparent", &poster.is_transparent);
  ImGui::SameLine();
  ImGui::Checkbox("Ground", &poster.has_ground);
  help_on_hover("a soft dark place on the ground, also where the background is transparent");
  const std::string count = poster.pictures == 1 ? "1" : fmt::format("{} from all around", poster.pictures);
  slide_whole("Pictures", poster.pictures, 1, 120, count);
}

// Opens it in the middle of the window, or at its foot, where it leaves the shape to be seen.
bool begin_dialog(const char* title, const Gui& gui, bool at_foot) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float height = std::min((at_foot ? 300 : 480) * gui.unit(), 0.95F * size.y);
  const ImVec2 at =
      at_foot ? ImVec2{0.5F * size.x, size.y - ImGui::GetFrameHeight()} : ImVec2{0.5F * size.x, 0.5F * size.y};
  ImGui::SetNextWindowPos(at, ImGuiCond_Always, {0.5F, at_foot ? 1.0F : 0.5F});
  ImGui::SetNextWindowSize({std::min(620 * gui.unit(), 0.95F * size.x), height});
  return ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove);
}

// The formats that can be exported, by the ends of names.
void draw_formats(FileDialog& dialog) {
  std::vector<std::string> formats;
  for (const std::string_view name : written_extensions(dialog.has_faces)) formats.push_back(fmt::format(".{}", name));
  if (dialog.use == FileUse::export_frames) formats.insert(formats.end(), {".pc2", ".mdd", ".usda", ".pvd"});
  std::string format = fs::path(dialog.name).extension().string();
  if (choose_one(
          "Format", format, formats, [](const std::string& name) { return name.c_str(); },
          kFormatWidth * ImGui::GetFontSize())) {
    dialog.name = fs::path(dialog.name).replace_extension(format).string();
    dialog.is_sure = false;
  }
}

// Rows below the list of files.
float rows_below(FileUse use) {
  if (use == FileUse::export_frames) return 5.2F;
  if (use == FileUse::poster) return 4.2F;
  return use == FileUse::export_shape || use == FileUse::turntable ? 3.2F : 2.2F;
}

}  // namespace

namespace {

// While the desktop asks, Studio waits.
std::vector<fs::path> draw_desktop_dialog(FileDialog& dialog) {
  const char* const title = title_of(dialog.use);
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Always, {0.5F, 0.5F});
  constexpr int kSheet = ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize;
  if (!ImGui::BeginPopupModal(title, nullptr, kSheet)) return {};
  ImGui::TextUnformatted("Choose the file in the window that has opened.");
  std::optional<fs::path> answer = dialog.desktop->answer();
  if (ImGui::Button("Cancel") || escape_pressed()) answer.emplace();
  if (answer) {
    dialog.desktop.reset();
    dialog.is_open = false;
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
  if (!answer || answer->empty()) return {};
  dialog.folder = answer->parent_path();
  dialog.name = answer->filename().string();
  const fs::path chosen = chosen_path(dialog);
  std::error_code error;
  if (chosen == *answer || !fs::exists(chosen, error)) return {chosen};
  // With its extension the name is that of a file that the desktop has not asked about.
  go_to(dialog, dialog.folder);
  dialog.is_open = true;
  return {};
}

}  // namespace

bool asks_for_files(const FileDialog& dialog) { return dialog.is_open && !dialog.desktop && !writes(dialog.use); }

std::vector<fs::path> draw_file_dialog(FileDialog& dialog, const Gui& gui) {
  const char* const title = title_of(dialog.use);
  // The shape is seen as it is while a frame of it is looked at. Dear ImGui reads this colour at the end of the
  // picture.
  ImGui::GetStyle().Colors[ImGuiCol_ModalWindowDimBg].w = dialog.is_open && dialog.frame > 0 ? 0 : kDimmed;
  if (!dialog.is_open) return {};
  if (dialog.desktop) return draw_desktop_dialog(dialog);
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  if (!begin_dialog(title, gui, dialog.use == FileUse::export_frames)) return {};
  // Also where a file was chosen by the mouse; in a field the key is the field's.
  bool chosen = enter_pressed();
  draw_places(dialog);
  if (draw_list(dialog, -ImGui::GetFrameHeightWithSpacing() * rows_below(dialog.use))) chosen = true;
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 4);
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  if (ImGui::InputText("Name", &dialog.name, ImGuiInputTextFlags_EnterReturnsTrue)) chosen = true;
  if (ImGui::IsItemEdited()) dialog.is_sure = false;
  if (dialog.use == FileUse::export_shape || dialog.use == FileUse::export_frames) draw_formats(dialog);
  if (dialog.use == FileUse::export_shape && !is_touched()) {  // a phone has no room for it
    ImGui::SameLine();
    ImGui::BeginDisabled(fs::path(dialog.name).extension() != ".ply");
    ImGui::Checkbox("Coordinates as doubles", &dialog.as_double);
    ImGui::EndDisabled();
  }
  if (dialog.use == FileUse::turntable) ImGui::SliderInt("Pictures", &dialog.pictures, 2, 600);
  if (dialog.use == FileUse::poster) draw_poster(dialog.poster);
  if (dialog.use == FileUse::export_frames) draw_motion(dialog.motion, dialog.frame);
  std::vector<fs::path> result = std::exchange(dialog.brought, {});
  if (draw_choice(dialog, chosen)) result = {chosen_path(dialog)};
  if (!result.empty()) dialog.is_open = false;
  if (!dialog.is_open) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  return result;
}

}  // namespace knead::studio
