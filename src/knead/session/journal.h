// The crash journal: what a person does is on disk as it happens, and can be had back after the program was killed.
//
// A journal is a folder with the shape as it was opened (shape.ply, shape.obj, ...) and session.knead, a session file
// that only grows. A batch of lines takes effect as a whole: every line of it but the last ends in a blank, so that
// what a kill cut off is known whatever byte it came after. To all other readers a blank at the end of a line means
// nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"
#include "knead/session/append_file.h"
#include "knead/session/session.h"

namespace knead {

// Not for several threads at once. Moved from, it may only be assigned to or destroyed.
class Journal {
 public:
  // A new folder under root (made where it is missing) named after the time in UTC, the process and a number. It holds
  // the bytes of the shape, of a shape without bytes its mesh as PLY in doubles. title: what the person calls the work.
  // The folder appears under its name when all of it is there. Throws IoError(write).
  static Journal create(const std::filesystem::path& root, const ShapeFile& shape, const std::string& title);

  // Goes on in a journal that a program left behind, after its last whole batch. Throws IoError; InvalidInput where
  // another program uses it or it is no journal.
  static Journal attach(const std::filesystem::path& folder);

  // Each of these is one batch, written by one call of write(2) before it returns; below 0.02 ms for a short stroke.
  // None throws when the disk is full or fails: see trouble(). replace takes back n strokes and appends others;
  // InvalidInput where n is more than the strokes in effect.
  void append(std::span<const SessionStroke> strokes);
  void replace(std::size_t n, std::span<const SessionStroke> strokes);
  void take_back(std::size_t n);

  // Lets a thread of the journal bring what was written to the disk, so that it outlives the machine too. Returns at
  // once. Meant for the end of a gesture.
  void sync();

  // One line for the person where the disk refuses to take what was done: it waits in memory, in order, and is written
  // by a later call (one attempt a second) when there is room again.
  std::optional<std::string> trouble() const;

  // Removes the folder: the work is saved elsewhere or given up. Nothing more may be written. What cannot be removed
  // stays.
  void discard();

  const std::filesystem::path& folder() const { return folder_; }

 private:
  Journal(std::filesystem::path folder, session_detail::AppendFile file);

  std::filesystem::path folder_;
  session_detail::AppendFile file_;
  std::size_t strokes_ = 0;  // in effect
  // That the file sets for the next stroke; the outer one empty: unknown.
  std::optional<std::optional<RemeshSettings>> remesh_ = std::optional<RemeshSettings>();
};

// A journal that no running program holds.
struct AbandonedJournal {
  std::filesystem::path folder;
  std::string title;
  std::chrono::system_clock::time_point changed{};  // when something was last written to it
  std::size_t strokes = 0;                          // that recover gives back
  std::string problem{};                            // why it cannot be recovered; empty: it can
};

// Those under root, the latest change first; empty where there is no such folder.
std::vector<AbandonedJournal> abandoned_journals(const std::filesystem::path& root);

struct RecoveredWork {
  ShapeFile shape;
  Session session;  // its name is the path of the file, relative to which stamps name their meshes
  std::string title;
};

// The shape as it was opened and the strokes up to the last whole batch. Changes nothing. Throws IoError(read) and
// InvalidInput, as reading a shape and a session do.
RecoveredWork recover_journal(const std::filesystem::path& folder);

// Removes a journal that nobody wants back; nothing where another program holds it.
void discard_journal(const std::filesystem::path& folder);

// The beginning of a journal's session file that consists of whole batches: without a last line that is not ended, and
// without lines before it that end in a blank.
std::string_view whole_batches(std::string_view text);

}  // namespace knead
