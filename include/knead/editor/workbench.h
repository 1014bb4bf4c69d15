// The shape in an editor: strokes that are applied while they are made, undone, redone and edited.
//
// The shape has the bits that a replay (knead/replay.h) of strokes() gives with the default options, those of the
// command, except during a gesture that follows a pointer (set_live), and until settle() after finish_later(). During
// any gesture only the centres of splats move; settle() or finish() changes the rest.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/editor/shape_state.h"
#include "knead/flow.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/session.h"

namespace knead {

// What is left to do when the strokes of a gesture are replaced by others. Remesh settings have no effect on it.
struct StrokeDelta {
  bool from_start = false;    // apply all of the new strokes, to the shape at the start of the gesture
  std::size_t first_new = 0;  // else apply the strokes from this one on,
  std::optional<Flow> rest;   // after this rest of the stroke before it
  // The rest as a stroke, which is applied if it is no flow. Nothing: the session file gets the whole stroke again.
  std::optional<SessionStroke> rest_as_line;

  // Returns true if nothing is left to apply.
  bool is_nothing(std::size_t new_strokes) const {
    return !from_start && !rest && !rest_as_line && first_new == new_strokes;
  }
};

// Returns the difference between the strokes applied before and those to apply now.
StrokeDelta stroke_delta(std::span<const SessionStroke> before, std::span<const SessionStroke> now);

// What there is to say about applied strokes.
struct StrokeNotes {
  std::vector<std::string> warnings;  // a sentence each
  std::string shortfall{};            // where the last of them that fell short did so; empty if none did
  double reached = 1;                 // the least part of a stroke that was made, from 0 to 1
};

// What a finished gesture became.
struct HistoryEntry {
  std::vector<SessionStroke> strokes;  // in order
  double seconds = 0;                  // of computing
  std::uint64_t steps = 0;             // accepted, of all vertices
  StrokeNotes notes;
};

// The change of a session file that holds the strokes: undo the last `undone` lines, then append these.
struct LineChange {
  std::size_t undone = 0;
  std::vector<SessionStroke> appended;

  // Returns true if nothing changed.
  bool empty() const { return undone == 0 && appended.empty(); }
};

// The result of a call. Unless is_done(), the call did not change the shape.
struct WorkResult {
  AdvectStatus status = AdvectStatus::done;
  std::string refusal;  // why a stroke cannot be applied to the shape; empty: it was applied
  LineChange lines;
  // For strokes that read the surface: the last stroke that they became, e.g. the contacts of a stamp with their
  // positions and displacements.
  std::optional<Stroke> part{};

  // Returns true if the work is complete.
  bool is_done() const { return status == AdvectStatus::done && refusal.empty(); }
};

namespace detail {

class MemoryAccount;
class KeptState;

}  // namespace detail

// The memory of the states that a workbench keeps for undo.
struct UndoMemory {
  std::size_t bytes = 0;   // besides the shape at the start; equal parts of states count once
  std::size_t states = 0;  // that undo, redo and state_after() reach without computing
};

// For one thread at a time. A call that takes a Progress can be cancelled from another thread.
class Workbench {
 public:
  // `folder`: the paths of stamps are relative to it. `face_labels`: see knead/io.h. Throws InvalidInput for a mesh
  // without vertices, and for splats as splat_degree().
  explicit Workbench(Mesh mesh, std::filesystem::path folder = {}, std::vector<std::uint32_t> face_labels = {},
                     int threads = 0);

  // Return the present shape, including the current gesture; and the shape at the start.
  const ShapeState& state() const { return live_.empty() ? last_state() : live_state_; }
  const ShapeState& base() const { return base_; }

  // Returns the shape before the current gesture; without a gesture, the shape before the last entry of the history.
  // Returns nothing if that state is not kept, or if there is no entry.
  std::optional<ShapeState> state_before() const;

  // Replaces the strokes of the current gesture. If the new list only extends the old one, only the new part is
  // computed; otherwise the gesture is recomputed from its start. An empty list gives the gesture up. Remesh settings
  // have no effect before finish.
  // `follows`: the strokes come from a moving pointer. A pose then continues from its last position by a few steps, and
  // the shape is an approximation. A call without `follows`, or the end of the gesture, computes it completely.
  WorkResult set_live(std::vector<SessionStroke> strokes, Progress* progress = nullptr, bool follows = false);
  const std::vector<SessionStroke>& live() const { return live_; }

  // Prepares the first step of the next gesture (about 60 ns a vertex), which then takes no longer than later steps.
  void prepare();

  // Appends the current gesture to the history, and remeshes its strokes that have settings. Drops what redo would
  // bring back. Does nothing without a gesture. If it is not done, the gesture remains the current one.
  WorkResult finish(Progress* progress = nullptr);

  // Does the same, but leaves remeshing, and everything that depends on it, to settle(): until then the shape is an
  // approximation. strokes() and the lines of the session file are correct at once.
  WorkResult finish_later(Progress* progress = nullptr);

  // Returns true if the shape is exact: nothing is left for settle().
  bool is_settled() const { return now_.empty() || !now_.back()->is_provisional; }

  // Computes what finish_later() left, with the bits of finish(). Removes entries that cannot be applied to the exact
  // shape; `refusal` says why. If it is cancelled, it keeps what is complete. The calls below that need an exact shape
  // call it first. Must not be called during a gesture.
  WorkResult settle(Progress* progress = nullptr);

  // Return the history, first to last, and the entries that redo would restore, next first. Entries are immutable.
  std::vector<std::shared_ptr<const HistoryEntry>> done() const;
  std::vector<std::shared_ptr<const HistoryEntry>> redoable() const;

  // Returns true if there is something to undo.
  bool can_undo() const { return !undo_.empty() || !live_.empty(); }
  // Returns true if there is something to redo.
  bool can_redo() const { return !redo_.empty(); }

  // Undo or redo the last change of the history: an entry, or an edit. During a gesture, undo only discards the
  // gesture, and redo discards it first. Do nothing if there is nothing to undo or redo.
  WorkResult undo(Progress* progress = nullptr);
  WorkResult redo(Progress* progress = nullptr);

  // Replaces the strokes of an entry (empty: removes the entry), and applies the entries after it again. Can be undone.
  // Throws std::out_of_range.
  WorkResult edit(std::size_t entry, std::vector<SessionStroke> strokes, Progress* progress = nullptr);

  // Replaces the history by these entries (without those that have no strokes), as one change for undo. Computes only
  // what follows the first stroke with another effect than before; names and strokes that are off have none. `again`:
  // replaces the last change, which was an arrangement, too.
  WorkResult arrange(const std::vector<std::vector<SessionStroke>>& entries, bool again, Progress* progress = nullptr);

  // Appends strokes to the history, an entry for every gesture (`strokes_of_gestures`).
  WorkResult append(const std::vector<SessionStroke>& strokes, Progress* progress = nullptr);

  // Returns the shape after the first `entries` entries, for viewing; nothing if it was cancelled.
  std::optional<ShapeState> state_after(std::size_t entries, Progress* progress = nullptr);

  // Returns all strokes in effect, those of the current gesture included; painted and implicit strokes of an entry are
  // joined.
  std::vector<SessionStroke> strokes() const;

  // Returns how much of the motion of the last entry its faces miss because they are too large: the greatest distance
  // of a point of the exact image from them, divided by the greatest motion of such a point. 0 for an entry that was
  // remeshed, that moved points alone, or whose distance is below 0.001 of the shape's size; also if there is no entry,
  // during a gesture, if the state before is not kept, and if it was cancelled. Time: that of applying the entry.
  double missed_motion(Progress* progress = nullptr) const;

  // Limits the memory of the states that are kept for undo. Above the limit, drops states: first every second one of
  // those farther than a hundred entries from the present, then nearer ones. The present state always stays. When undo,
  // redo or state_after() needs a dropped state, it is computed again, with the same bits, from the kept one before it;
  // this takes as long as applying the strokes between. Default: 1 GiB.
  void limit_memory(std::size_t bytes);
  UndoMemory undo_memory() const;

 private:
  struct Entry {
    HistoryEntry info;
    std::shared_ptr<const detail::KeptState> after;  // null: dropped, and computed again when needed
    bool is_provisional = false;  // `after` is an approximation; then those of all later entries are, too
  };
  using History = std::vector<std::shared_ptr<Entry>>;
  class Comparison;

  // A change to another history: keep the first entries of this one, then append others.
  struct Change {
    std::size_t common = 0;
    History rest;
  };

  // A state that the shape is often restored to, ready to be moved.
  struct Kept {
    ShapeState state;
    DeformedShape shape;
  };

  const ShapeState& last_state() const;
  void go_to(const ShapeState& state, bool again = false);
  template <class Work>
  WorkResult compute(const ShapeState& from, bool again, const Work& work);
  AdvectStatus apply(std::span<const SessionStroke> strokes, Progress* progress);
  WorkResult follow(const PoseStroke& pose, Progress* progress);
  WorkResult apply_change(const StrokeDelta& change, const std::vector<SessionStroke>& strokes, Progress* progress);
  LineChange live_lines(const StrokeDelta& change, const std::vector<SessionStroke>& strokes);
  std::vector<SessionStroke> lines_of(std::size_t index, std::vector<SessionStroke> strokes) const;
  WorkResult make_entry(const std::vector<SessionStroke>& strokes, const ShapeState& from, Entry& entry,
                        Progress* progress);
  WorkResult make_rest(const std::vector<std::vector<SessionStroke>>& gestures, Change& change, Progress* progress);
  WorkResult make_arrangement(const std::vector<std::vector<SessionStroke>>& entries, History& next,
                              Progress* progress);
  std::optional<ShapeState> make_state(std::size_t count, Progress* progress, std::string* refusal = nullptr);
  std::optional<ShapeState> make_state(History& history, std::size_t count, Progress* progress, std::string* refusal);
  static Change change_between(const History& from, const History& to);
  LineChange remove_refused();
  void add_finished(std::vector<SessionStroke> strokes, std::shared_ptr<Entry> entry, std::size_t lines);
  void keep(Entry& entry, const ShapeState& state);
  Change exchange(Change change);
  WorkResult step(std::vector<Change>& from, std::vector<Change>& to, Progress* progress);
  LineChange lines_from(std::size_t common);
  LineChange change_to(Change change);
  std::vector<Entry*> kept_entries(std::size_t present) const;
  void thin_out(std::size_t present);

  std::filesystem::path folder_;
  DeformedShape shape_;
  ShapeState base_;
  std::optional<ShapeState> at_;  // the state of shape_; std::nullopt: between two states
  std::optional<Kept> kept_;
  std::uint64_t steps_ = 0;     // accepted, of all work
  std::optional<Stroke> part_;  // for WorkResult::part of the current call
  StrokeNotes notes_;           // for HistoryEntry::notes of the current entry
  History now_;
  std::vector<std::size_t> lines_;  // in the session file, of each entry of now_
  std::vector<Change> undo_;
  std::vector<Change> redo_;
  std::vector<SessionStroke> live_;
  ShapeState live_state_;
  struct Following;  // a pose that follows a pointer
  std::shared_ptr<Following> following_;
  bool is_approximate_ = false;  // live_state_ is an approximation
  std::size_t live_lines_ = 0;
  double live_seconds_ = 0;
  std::uint64_t live_steps_ = 0;
  std::size_t memory_ = std::size_t{1} << 30;
  std::shared_ptr<detail::MemoryAccount> account_;
};

// Groups strokes by the gestures that probably made them: each stroke of a group continues one of the last eight before
// it, or is the mirror image of one of these. Neighbours with equal names are one group, those with different names are
// not. SessionStroke::new_entry, if set, decides; it is not set in the result.
std::vector<std::vector<SessionStroke>> strokes_of_gestures(const std::vector<SessionStroke>& strokes);

// Returns the strokes of an entry of the history as a session holds them, with `new_entry` set where
// strokes_of_gestures() would group them differently. `before`: the strokes of the entry before; empty for the first.
std::vector<SessionStroke> strokes_of_entry(const std::vector<SessionStroke>& before,
                                            std::vector<SessionStroke> strokes);

// Returns fewer strokes with the same result bit for bit: joins strokes that are not remeshed to those that they
// continue. Strokes that are named, off or not of strength 1 stay as they are.
std::vector<SessionStroke> joined_strokes(std::vector<SessionStroke> strokes);

// Returns the change that has the effect of both.
LineChange joined_changes(LineChange first, LineChange second);

// Return and set the strength of a gesture, from 0 to kMaxStrength. Each path of the gesture is cut or extended as a
// whole, also if it consists of several strokes; every other stroke gets the strength itself. If the strengths of the
// paths differ, the first one is returned.
double strength_of(std::span<const SessionStroke> gesture);
void set_strength(std::vector<SessionStroke>& gesture, double strength);

// The crash journal: writes every stroke to the disk at once, and recovers the work after the program was killed.
//
// A journal is a folder with the shape as it was opened (shape.ply, shape.obj, ...), further shapes (shape_2.ply, ...)
// and session.knead, a session file that only grows. A batch of lines takes effect as a whole: every line but the last
// ends in a blank, which shows a reader that a batch is incomplete. Other readers ignore the blank.

namespace detail {
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
  // number. It holds the bytes of the shape, or its mesh as PLY in doubles if it has none, and further shapes that the
  // work is on. title: the user's name for the work. The folder appears under its name once it is complete. Throws
  // IoError(write).
  static Journal create(const std::filesystem::path& root, const ShapeFile& shape, const std::string& title,
                        std::span<const std::shared_ptr<const ShapeFile>> also = {});

  // Continues a journal that a program left behind, after its last whole batch. Throws IoError, and InvalidInput if
  // another program uses it or it is no journal.
  static Journal attach(const std::filesystem::path& folder);

  // Each call writes one batch by one call of write(2); below 0.02 ms for a short stroke. Does not throw if the disk is
  // full or fails: see trouble(). replace undoes n strokes and appends others; throws InvalidInput if n is more
  // than the strokes in effect.
  void append(std::span<const SessionStroke> strokes);
  void replace(std::size_t n, std::span<const SessionStroke> strokes);
  void undo(std::size_t n);

  // Starts to flush the file to the disk on a thread of the journal, so that it also survives a crash of the machine.
  // Returns at once. Meant for the end of a gesture.
  void sync();

  // Returns one line for the user while the disk refuses to be written. The batches then wait in memory, in order;
  // later calls try again, once a second at most.
  std::optional<std::string> trouble() const;

  // Notes the session file of the work, whose name a recovered work keeps. `holds_all`: the file holds the present
  // work; AbandonedJournal::is_saved is then true until something is written again or the file is gone.
  void note_saved(const std::filesystem::path& file, bool holds_all = true) const;

  // Removes the folder, after the work was saved elsewhere or given up. Nothing may be written afterwards. Files that
  // cannot be removed stay.
  void discard();

  // Returns the folder of the journal.
  const std::filesystem::path& folder() const { return folder_; }

 private:
  Journal(std::filesystem::path folder, std::unique_ptr<detail::AppendFile> file);

  std::filesystem::path folder_;
  std::unique_ptr<detail::AppendFile> file_;
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
  std::vector<ShapeFile> also{};  // as many as the session has
  std::filesystem::path saved{};  // the session file that was noted last (Journal::note_saved); empty: none
  // The files of `shape` and `also`, as the saved session names them. Empty where it names none with the same bytes.
  std::vector<std::filesystem::path> files{};
};

// Returns the shapes as they were opened and the strokes up to the last whole batch. A stroke that was being made when
// the program ended is one stroke, with its remesh settings. Changes nothing. Throws IoError(read) and InvalidInput, as
// read_shape and read_session do.
RecoveredWork recover_journal(const std::filesystem::path& folder);

// Removes a journal; does nothing if another program uses it.
void discard_journal(const std::filesystem::path& folder);

// Returns the beginning of a journal's session file that consists of whole batches: without a last line that has no
// line end, and without the lines before it that end in a blank.
std::string_view whole_batches(std::string_view text);

}  // namespace knead
