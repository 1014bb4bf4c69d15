// The dialog that asks for a file to read or write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "document/document.h"
#include "platform/gui.h"
#include "platform/system.h"

namespace knead::studio {

// A file or folder in the list of a file dialog.
struct ListedFile {
  std::string name;
  bool is_folder = false;
  std::uintmax_t bytes = 0;
};

struct FileList {
  std::vector<ListedFile> files;  // folders first, each group by name, upper and lower case alike
  std::string problem;            // why the folder cannot be listed; empty: it can
};

// Returns the folders in a folder, and the files whose names end in one of the extensions (".ply", upper or lower case;
// all files without extensions). Names that begin with a dot are left out.
FileList list_files(const std::filesystem::path& folder, std::span<const std::string> extensions);

// Returns the name with the extension, unless it ends in one of `extensions`.
std::string with_extension(const std::string& name, std::span<const std::string> extensions,
                           const std::string& extension);

// Returns a size as text: "417 bytes", "3.4 MB".
std::string size_text(std::uintmax_t bytes);

enum class FileUse {
  open,
  add,
  stamp,
  target,
  reference,
  save,
  export_shape,
  export_frames,
  picture,
  poster,
  turntable
};

struct FileDialog {
  FileUse use = FileUse::open;
  bool is_open = false;
  std::optional<DesktopDialog> desktop;  // asks in the place of this dialog
  std::filesystem::path folder;
  std::string typed_folder;
  std::string name;
  FileList list;
  std::vector<std::filesystem::path> brought;  // dropped on it or on the welcome, or chosen in a page's browser
  bool is_sure = false;                        // the file may be replaced
  bool has_faces = true;                       // the exported shape has faces
  bool as_double = false;                      // of export_shape: coordinates of PLY as doubles
  FrameExport motion;                          // of export_frames
  int frame = 0;                               // of export_frames: the shown frame, from 1; 0: none
  int pictures = 24;                           // of turntable
  Poster poster;                               // of poster
};

// Opens the dialog. `near`: a file or folder to begin at; its name is proposed for the file to write. With `by_desktop`
// the desktop's own dialog asks, if there is one and the file is the only question.
void open_file_dialog(FileDialog& dialog, FileUse use, const std::filesystem::path& near, bool by_desktop);

// Returns whether the dialog is open and asks for a file to read.
bool asks_for_files(const FileDialog& dialog);

// Draws the dialog while it is open. Returns the file once the user has chosen one, or all that were brought.
std::vector<std::filesystem::path> draw_file_dialog(FileDialog& dialog, const Gui& gui);

}  // namespace knead::studio
