// The history as layers: what a person calls its entries, and how they are renamed, moved, joined, split, switched off
// and made weaker or stronger. Changes are functions, so that the worker applies them to the history as it then is.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "document/document.h"
#include "document/layer_handles.h"

namespace knead::studio {

// Returns the name of an entry: its own, else that of its tool in Studio, "Ball".
std::string name_of(std::span<const SessionStroke> strokes);

// Returns what is worth knowing of an entry besides: "Ball, 34 pieces", "2 x Bend".
std::string description_of(std::span<const SessionStroke> strokes);

// Returns whether an entry is switched off: none of its strokes is applied.
bool is_off(std::span<const SessionStroke> strokes);

// Return a change of one entry, counted from 0. An entry that is not there is left alone.
LayerChange renamed(std::size_t entry, const std::string& name);  // an empty name: none
LayerChange switched(std::size_t entry, bool off);
LayerChange with_strength(std::size_t entry, double strength);  // from 0 to kMaxStrength
LayerChange moved(std::size_t entry, std::size_t to);           // `to`: its number afterwards
LayerChange joined(std::size_t entry);  // with the entry before it, under the name of that or else of its own tool
LayerChange split(std::size_t entry);   // into its strokes, which get names of their own
LayerChange removed(std::size_t entry);
LayerChange replaced(std::size_t entry, std::vector<SessionStroke> strokes);

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

// Follows the history: the selected entry may have been changed, moved or removed. Changes that were not applied are
// dropped if their entry has changed.
void follow(LayerEditor& editor, const DocumentState& shown);

// Changes the strokes, and the text with them; or the text, and the strokes if it can be used.
void set_strokes(LayerEditor& editor, std::vector<SessionStroke> strokes);
void set_text(LayerEditor& editor, std::string text);

}  // namespace knead::studio
