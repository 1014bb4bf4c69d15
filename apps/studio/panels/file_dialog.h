// Where to read from, and where to write to.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "document/document.h"
#include "platform/file_list.h"
#include "platform/gui.h"

namespace knead::studio {

enum class FileUse { open, stamp, reference, save, export_shape, export_frames, picture, turntable };

struct FileDialog {
  FileUse use = FileUse::open;
  bool is_open = false;
  std::filesystem::path folder;
  std::string typed_folder;
  std::string name;
  FileList list;
  bool is_sure = false;    // that the file may be replaced
  bool as_double = false;  // of export_shape: coordinates of PLY as doubles
  FrameExport motion;      // of export_frames
  int frame = 0;           // likewise: that is looked at, from 1; 0: none
  int pictures = 24;       // of turntable
};

// `near`: a file or folder to begin at; its name is proposed for what is written.
void open_file_dialog(FileDialog& dialog, FileUse use, const std::filesystem::path& near);

// Draws it while it is open. Returns the file once the person has chosen one.
std::optional<std::filesystem::path> draw_file_dialog(FileDialog& dialog, const Gui& gui);

}  // namespace knead::studio
