// Questions to the person, and the menus that lead to them.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "panels/file_dialog.h"
#include "platform/gui.h"
#include "studio.h"

namespace knead::studio {

// The search of commands.
struct CommandSearch {
  bool is_open = false;
  std::string text;
  std::size_t chosen = 0;  // of those found
};

struct Dialogs {
  CommandSearch search;
  FileDialog file;
  FrameExport motion;  // that was looked at last
  int frame = 0;       // of it, from 1; 0: the present shape

  bool is_new_shape_open = false;
  ShapeKind new_kind = ShapeKind::sphere;
  int new_vertices = 40'000;

  bool is_recovery_open = false;
  std::optional<std::filesystem::path> to_discard;  // a journal that is thrown away at the next click

  // What would put unsaved work away, until the person has decided.
  std::function<void()> pending;
  bool is_saving = false;  // first
};

// Whether a dialog waits for the person: nothing else is then meant by keys and pointer.
inline bool is_asking(const Dialogs& dialogs) {
  return dialogs.file.is_open || dialogs.is_new_shape_open || dialogs.is_recovery_open || dialogs.search.is_open ||
         dialogs.pending != nullptr;
}

// Does it, or asks first where there is unsaved work.
void do_or_ask(Studio& studio, Dialogs& dialogs, std::function<void()> what);

// Does what Studio handed on; false if it is about the window itself (quit, full_screen).
bool answer_request(Studio& studio, Dialogs& dialogs, Action action);

// Returns whether a menu is open.
bool draw_menus(Studio& studio, Dialogs& dialogs);

void draw_search(Studio& studio, const Gui& gui, CommandSearch& search);

// Draws the dialogs that are open. picture: writes what is seen to a file.
void draw_dialogs(Studio& studio, Dialogs& dialogs, const Gui& gui,
                  const std::function<void(const std::filesystem::path&)>& picture);

}  // namespace knead::studio
