// A shape under work: strokes that are done while they are being made, undone, redone and changed afterwards.
//
// Whatever is done here, the shape has the bits that replay() (session/replay.h) gives for strokes() with the default
// options, those of the command.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knead/flow/advect.h"
#include "knead/mesh/mesh.h"
#include "knead/session/session.h"
#include "knead/session/snapshot.h"

namespace knead {

namespace session_detail {
struct RemeshedShape;
class Bench;
}  // namespace session_detail

// The shape at one moment. Does not change; copies are cheap, and may be read from any thread.
struct ShapeState {
  std::shared_ptr<const Mesh> mesh;  // faces and attributes; its positions are of when these came about
  Snapshot positions;
  std::shared_ptr<const session_detail::RemeshedShape> trail;  // where vertices and faces come from

  // The mesh with the positions.
  Mesh to_mesh() const;
  // For each face that of the shape at the beginning in which it lies.
  std::span<const std::uint32_t> face_source() const;
};

// What a gesture became.
struct HistoryEntry {
  std::vector<SessionStroke> strokes;  // in order
  double seconds = 0;                  // that the work took
  std::uint64_t steps = 0;             // accepted, of all vertices
  std::vector<std::string> warnings;   // a sentence each
};

// How the lines of a session file that holds the strokes follow a change: the last `taken_back` lines are undone, then
// these are appended.
struct LineChange {
  std::size_t taken_back = 0;
  std::vector<SessionStroke> appended;

  bool empty() const { return taken_back == 0 && appended.empty(); }
};

// What came of a call.
struct WorkResult {
  AdvectStatus status = AdvectStatus::done;  // else the shape is as it was before the call
  std::string refusal;  // not empty: why a stroke cannot be done here; the shape is as it was before the call
  LineChange lines;
  // Where strokes read the surface: the last of those that they became, e.g. the contacts of a stamp as they went.
  std::optional<Stroke> part{};

  bool is_done() const { return status == AdvectStatus::done && refusal.empty(); }
};

// For one thread at a time. Calls that take a Progress can be cancelled from another one.
class Workbench {
 public:
  // `folder`: what files of stamps are relative to. `face_labels`: io/remeshed.h. Throws InvalidInput for a mesh
  // without vertices.
  explicit Workbench(Mesh mesh, const std::filesystem::path& folder = {}, std::vector<std::uint32_t> face_labels = {},
                     int threads = 0);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;
  Workbench(Workbench&&) noexcept;
  Workbench& operator=(Workbench&&) noexcept;

  // The shape as it is, the gesture under way included; and at the beginning.
  const ShapeState& state() const;
  const ShapeState& base() const;

  // The gesture under way is now these strokes. What it was before is gone on with where these do (tool/continued.h),
  // or where they only add strokes, which costs what is new; else it is done anew from its beginning. No strokes: the
  // gesture is given up. Their remesh settings are looked at by finish only.
  WorkResult set_live(std::vector<SessionStroke> strokes, Progress* progress = nullptr);
  const std::vector<SessionStroke>& live() const;

  // Makes ready what the first step of the next gesture needs (some 60 ns a vertex), so that it takes no longer than
  // others.
  void prepare();

  // The gesture under way becomes an entry of the history; strokes with remesh settings are remeshed. Drops what could
  // be redone. Without a gesture nothing happens. Where it is not done, the gesture is still under way.
  WorkResult finish(Progress* progress = nullptr);

  // The history, first to last, and what redo would bring back, next first.
  // They do not change, and may be kept.
  std::vector<std::shared_ptr<const HistoryEntry>> done() const;
  std::vector<std::shared_ptr<const HistoryEntry>> redoable() const;

  bool can_undo() const;
  bool can_redo() const;

  // Takes back, or does again, the last change of the history: an entry, or an edit. Gives up a gesture under way first
  // (undo then does only that). Nothing to be undone: nothing happens.
  WorkResult undo(Progress* progress = nullptr);
  WorkResult redo(Progress* progress = nullptr);

  // The strokes of an entry replaced (none: the entry is taken out), and those that follow done again on top of it. Can
  // be undone. Throws std::out_of_range.
  WorkResult edit(std::size_t entry, std::vector<SessionStroke> strokes, Progress* progress = nullptr);

  // Does strokes after all that there is, an entry for every gesture: those that go on where the last ended belong
  // together, and mirror images made in turn (`strokes_of_gestures`).
  WorkResult append(const std::vector<SessionStroke>& strokes, Progress* progress = nullptr);

  // The shape after the first `entries` entries, to be looked at.
  // Nothing where it was cancelled.
  std::optional<ShapeState> state_after(std::size_t entries, Progress* progress = nullptr);

  // All strokes in effect, those of the gesture under way included; painted and implicit ones of an entry joined.
  std::vector<SessionStroke> strokes() const;

  // Snapshots are kept up to about so many bytes beyond the shape itself, then every second of the older ones is
  // dropped, which makes undoing that far back take as long as doing the strokes again. Default: 2 GiB.
  void limit_memory(std::size_t bytes);

 private:
  std::unique_ptr<session_detail::Bench> bench_;
};

// Strokes by the gestures that made them, as far as they tell: in each group, every stroke continues (tool/continued.h)
// one of the last eight before it, or is the mirror image of one of these.
std::vector<std::vector<SessionStroke>> strokes_of_gestures(const std::vector<SessionStroke>& strokes);

// Fewer strokes that do the same to the bit: those that are not remeshed joined with what they continue.
std::vector<SessionStroke> joined_strokes(std::vector<SessionStroke> strokes);

}  // namespace knead
