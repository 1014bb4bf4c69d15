// The crash journal: writes every stroke to the disk at once, and recovers the work after the program was killed.
//
// A journal is a folder with the shape as it was opened (shape.ply, shape.obj, ...) and session.knead, a session file
// that only grows. A batch of lines takes effect as a whole: every line but the last ends in a blank, so that a reader
// recognises a batch that was cut off at any byte. To all other readers a blank at the end of a line means nothing.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/shape_file.h"
#include "knead/session/session.h"

namespace knead {

namespace io_detail {
class AppendFile;
}

// For one thread at a time. An object that was moved from may only be assigned to or destroyed.
class Journal {
 public:
  Journal(Journal&&) noexcept;
  Journal& operator=(Journal&&) noexcept;
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  ~Journal();

  // Makes a new folder under root (which is made if it is missing), named after the time in UTC, the process and a
  // number. It holds the bytes of the shape, or its mesh as PLY in doubles if it has none. title: the user's name for
  // the work. The folder appears under its name once it is complete. Throws IoError(write).
  static Journal create(const std::filesystem::path& root, const ShapeFile& shape, const std::string& title);

  // Continues a journal that a program left behind, after its last whole batch. Throws IoError, and InvalidInput if
  // another program uses it or it is no journal.
  static Journal attach(const std::filesystem::path& folder);

  // Each call writes one batch by one call of write(2); below 0.02 ms for a short stroke. Does not throw if the disk is
  // full or fails: see trouble(). replace takes back n strokes and appends others; throws InvalidInput if n is more
  // than the strokes in effect.
  void append(std::span<const SessionStroke> strokes);
  void replace(std::size_t n, std::span<const SessionStroke> strokes);
  void take_back(std::size_t n);

  // Starts to flush the file to the disk on a thread of the journal, so that it also survives a crash of the machine.
  // Returns at once. Meant for the end of a gesture.
  void sync();

  // Returns one line for the user while the disk refuses to be written. The batches then wait in memory, in order;
  // later calls try again, once a second at most.
  std::optional<std::string> trouble() const;

  // Notes that the file holds the work as it is now. After a crash the journal is then no unsaved work (is_saved),
  // until something is written again, or the file is gone.
  void note_saved(const std::filesystem::path& file) const;

  // Removes the folder, after the work was saved elsewhere or given up. Nothing may be written afterwards. Files that
  // cannot be removed stay.
  void discard();

  // Returns the folder of the journal.
  const std::filesystem::path& folder() const { return folder_; }

 private:
  Journal(std::filesystem::path folder, std::unique_ptr<io_detail::AppendFile> file);

  std::filesystem::path folder_;
  std::unique_ptr<io_detail::AppendFile> file_;
  std::size_t strokes_ = 0;  // in effect
  // The settings that the file gives the next stroke; the outer optional empty: unknown.
  std::optional<std::optional<RemeshSettings>> remesh_ = std::optional<RemeshSettings>();
};

// A journal that no running program uses.
struct AbandonedJournal {
  std::filesystem::path folder;
  std::string title;
  std::chrono::system_clock::time_point changed{};  // when something was last written to it
  std::size_t strokes = 0;                          // that recover_journal returns
  std::size_t entries = 0;                          // of the history that they make (strokes_of_gestures)
  bool is_saved = false;                            // a session file holds all of it
  std::string problem{};                            // why it cannot be recovered; empty: it can
};

// Returns the abandoned journals under root, the latest change first; none if there is no such folder.
std::vector<AbandonedJournal> abandoned_journals(const std::filesystem::path& root);

// What a journal holds after a crash.
struct RecoveredWork {
  ShapeFile shape;
  Session session;  // its name is the path of the file, relative to which stamps name their meshes
  std::string title;
};

// Returns the shape as it was opened and the strokes up to the last whole batch. Changes nothing. Throws IoError(read)
// and InvalidInput, as read_shape and read_session do.
RecoveredWork recover_journal(const std::filesystem::path& folder);

// Removes a journal; does nothing if another program uses it.
void discard_journal(const std::filesystem::path& folder);

// Returns the beginning of a journal's session file that consists of whole batches: without a last line that has no
// line end, and without the lines before it that end in a blank.
std::string_view whole_batches(std::string_view text);

}  // namespace knead
