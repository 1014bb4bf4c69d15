// The dialog that asks where to read from, and where to write to.
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

// What a file dialog shows of a folder.
struct ListedFile {
  std::string name;
  bool is_folder = false;
  std::uintmax_t bytes = 0;
};

struct FileList {
  std::vector<ListedFile> files;  // folders first, each group by name, upper and lower case alike
  std::string problem;            // why the folder cannot be listed; empty: it can
};

// The folders, and the files whose names end in one of the extensions (".ply", upper or lower case; all files if there
// are none). Names that begin with a dot are left out.
FileList list_files(const std::filesystem::path& folder, std::span<const std::string> extensions);

// The name with the extension unless it ends in one of those given.
std::string with_extension(const std::string& name, std::span<const std::string> extensions,
                           const std::string& extension);

// "417 bytes", "3.4 MB".
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
  std::optional<DesktopDialog> desktop;  // asks in its place
  std::filesystem::path folder;
  std::string typed_folder;
  std::string name;
  FileList list;
  bool is_sure = false;    // that the file may be replaced
  bool has_faces = true;   // what is exported
  bool as_double = false;  // of export_shape: coordinates of PLY as doubles
  FrameExport motion;      // of export_frames
  int frame = 0;           // of export_frames: that is looked at, from 1; 0 if none is
  int pictures = 24;       // of turntable
  Poster poster;           // of poster
};

// `near`: a file or folder to begin at; its name is proposed for what is written. With `by_desktop` the desktop's own
// dialog asks where there is one, unless there is more to be set than a file.
void open_file_dialog(FileDialog& dialog, FileUse use, const std::filesystem::path& near, bool by_desktop);

// Draws it while it is open. Returns the file once the person has chosen one.
std::optional<std::filesystem::path> draw_file_dialog(FileDialog& dialog, const Gui& gui);

}  // namespace knead::studio
