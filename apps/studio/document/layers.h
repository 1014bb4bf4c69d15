// The history as layers: names of entries, and functions that rename, move, join, split and switch them off, or change
// their strength. Changes are functions, so that the worker applies them to the current history.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "document/document.h"
#include "gestures/picker.h"
#include "knead/session.h"

namespace knead::studio {

// Returns the name of an entry: its own, else that of its tool in Studio, "Ball".
std::string name_of(std::span<const SessionStroke> strokes);

// Returns the details of an entry: "Ball, 34 pieces", "2 x Bend".
std::string description_of(std::span<const SessionStroke> strokes);

// Returns what an entry does, in a word or two and a number: "Move 0.14 mm", "Bend 30\u00b0", "Paint, 18 dabs".
// `unit` is the sign of the unit of lengths, or empty.
std::string words_of(std::span<const SessionStroke> strokes, const std::string& unit);

// Returns the start and the end of a drag of a stamp, which may be several strokes; nothing if the first is no stamp.
struct StampWay {
  Vec3d from;
  Vec3d to;
};
std::optional<StampWay> stamp_way(std::span<const SessionStroke> strokes);

// Returns the tool of Studio that makes such an entry, for its icon; null if none does.
const StudioTool* tool_of(std::span<const SessionStroke> strokes);

// Returns whether every word of the text occurs in the entry's name or words_of(), in upper or lower case.
bool is_found(std::span<const SessionStroke> strokes, const std::string& text);

// Returns whether an entry is switched off: none of its strokes is applied.
bool is_off(std::span<const SessionStroke> strokes);

// Return a change of one entry, counted from 0. A number without an entry changes nothing.
LayerChange renamed(std::size_t entry, const std::string& name);  // an empty name: none
LayerChange switched(std::size_t entry, bool off);
LayerChange with_strength(std::size_t entry, double strength);  // from 0 to kMaxStrength
LayerChange moved(std::size_t entry, std::size_t to);           // `to`: its number afterwards
LayerChange joined(std::size_t entry);  // with the entry before it, under the name of that, or else of its own tool
LayerChange split(std::size_t entry);   // into its strokes, which get names of their own
LayerChange removed(std::size_t entry);
LayerChange replaced(std::size_t entry, std::vector<SessionStroke> strokes);
// Gives an entry of one stroke another one, and its remesh settings, or adds an entry where there is none.
LayerChange grown(std::size_t entry, const SessionStroke& stroke);

// A path of an entry, or the place of a tool, which is a path of one point.
struct LayerPath {
  std::vector<Vec3d> points;
  std::vector<std::size_t> handles;  // which of them have a handle: at most nine, the first and the last among them
};

// The selected entry, and its strokes as changed so far.
struct LayerEditor {
  std::optional<std::size_t> entry;
  std::shared_ptr<const HistoryEntry> source;  // as it was when the changes began
  std::size_t entries = 0;                     // of the history then
  std::vector<SessionStroke> strokes;
  std::vector<LayerPath> paths;  // of the strokes
  std::string text;              // the same as lines of a session, as typed
  std::string problem;           // why the text cannot be used; empty: it can
};

// Selects an entry, or none. The strokes are those of the history.
void select(LayerEditor& editor, const DocumentState& shown, std::optional<std::size_t> entry);

// Adapts to the history, in which the selected entry may have been changed, moved or removed. Drops changes that were
// not applied if their entry has changed.
void follow(LayerEditor& editor, const DocumentState& shown);

// set_strokes() changes the strokes and the text; set_text() changes the text, and the strokes if it is valid.
void set_strokes(LayerEditor& editor, std::vector<SessionStroke> strokes);
void set_text(LayerEditor& editor, std::string text);

// --- handles in the view: points of an entry's paths, centres of its tools
// --------------------------------------------

// Returns the paths of an entry; strokes that continue the stroke before share its path. Strokes without a path or a
// place have none.
std::vector<LayerPath> paths_of(std::span<const SessionStroke> strokes);

// One handle of an entry.
struct LayerHandle {
  std::size_t path = 0;
  std::size_t handle = 0;  // of that path's

  friend bool operator==(const LayerHandle&, const LayerHandle&) = default;
};

// Returns the handle within a few pixels of a place; the nearest of several.
std::optional<LayerHandle> handle_at(const Screen& screen, std::span<const LayerPath> paths, double x, double y);

// Returns the place of a handle.
Vec3d place_of(std::span<const LayerPath> paths, const LayerHandle& handle);

// Returns the strokes after a handle was moved. The points between it and its neighbours follow in part. Paths that are
// mirror images of this one in coordinate planes stay mirror images.
std::vector<SessionStroke> with_handle_moved(std::vector<SessionStroke> strokes, const LayerHandle& handle,
                                             const Vec3d& by);

// --- numbers of strokes
// -----------------------------------------------------------------------------------------------

// A number of strokes that can be changed afterwards.
struct StrokeField {
  std::string name;   // its key in the session file
  std::string label;  // for people
  std::string help;
  double value = 0;  // of the first stroke that has it
};

// Of the strokes of one entry, each name once.
std::vector<StrokeField> fields_of(std::span<const SessionStroke> strokes);

// Sets the field of the first stroke that has it, and multiplies that of all others by the same factor: mirror images
// keep their signs. Does nothing if no stroke has such a field.
void set_field(std::span<SessionStroke> strokes, const std::string& name, double value);

// Returns the falloff of the first stroke that has one.
std::optional<int> falloff_of(std::span<const SessionStroke> strokes);

// Sets the falloff of all strokes that have one.
void set_falloff(std::span<SessionStroke> strokes, int falloff);

}  // namespace knead::studio
