// The description of each tool: its name, the keys of its strokes, and what a stroke becomes. Session files, the
// command, Studio and the check of the documentation all read it, so that a tool is described in one place.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "knead/tool/stroke.h"

namespace knead {

// A number, or "auto" in its place.
struct AutoNumber {
  std::optional<double>* value = nullptr;
  bool* is_auto = nullptr;
};

// One of several words; the first is the default.
struct Choice {
  std::vector<std::string_view> words;
  std::size_t chosen = 0;
  std::function<void(std::size_t)> choose;  // makes words[i] the choice
};

// Points at the member of a stroke that a key stands for. Null: the key does not apply to this stroke.
using KeyValue =
    std::variant<double*, std::optional<double>*, AutoNumber, int*, Vec3d*, std::optional<Vec3d>*, std::vector<Vec3d>*,
                 std::vector<std::vector<Vec3d>>*, std::vector<std::uint32_t>*, std::vector<PaintSample>*,
                 std::vector<VertexRange>*, std::vector<double>*, std::vector<std::optional<PinRotation>>*, Mat3d*,
                 HandlesMotion*, std::vector<PoseItem>*, std::vector<PoseStiffness>*, bool*, std::array<int, 3>*,
                 SharedVectors*, std::string*, Choice>;

// What a value means, and so how it is checked and mirrored. A vector is a place unless this says otherwise.
enum class Quantity {
  finite,        // a number or a place: any finite value
  positive,      // a number greater than 0
  angle,         // degrees; changes its sign in a mirror
  rate,          // degrees for a length, of any size; changes its sign in a mirror
  direction,     // a vector of any length but 0
  displacement,  // a difference of two places: any finite vector
  falloff,       // a whole number from 3 to 7
  other,         // checked by the tool itself
};

// Says whether a line must give a key.
enum class Presence {
  required,
  optional,   // left out, the value is that of a stroke without it
  not_empty,  // optional, but an empty list is an error
};

// One key of a stroke in a session file.
struct StrokeKey {
  std::string_view name;
  Quantity quantity = Quantity::other;
  KeyValue value;
  Presence presence = Presence::required;
  std::string_view help{};   // what a person may want to know before changing the number; empty: not offered for that
  std::string_view needs{};  // the key and value without which this one does not apply, for messages
};

// Returns false for a key whose value is a null pointer.
bool applies(const StrokeKey& key);

// One tool. The strokes given to its functions are its own.
struct Tool {
  std::string_view name;  // in session files
  Stroke start;           // a stroke with every key at its default
  bool is_flow = true;    // false: its strokes are no flows
  // An event of the session: its line is {"NAME": {...}}, and {"NAME": null} for `start`. Else {"tool": "NAME", ...}.
  bool is_event = false;

  // Returns the keys, in the order of the session file. The pointers are valid as long as the stroke.
  std::function<std::vector<StrokeKey>(Stroke&)> keys;

  // Prepares an empty stroke for the keys that a line has, where these decide which others apply. Throws InvalidInput
  // for keys that exclude each other.
  std::function<void(Stroke&, const std::function<bool(std::string_view)>& has)> prepare;

  std::function<void(const Stroke&)> validate;       // throws InvalidInput for values that the tool cannot use
  std::function<bool(const Stroke&)> reads_surface;  // says whether the stroke must be resolved on a surface first
  std::function<Flow(const Stroke&)> flow;           // of a valid stroke that reads no surface
  std::function<void(const Stroke&, std::vector<std::string>&)> warn;  // adds sentences about a valid stroke
  std::function<void(Stroke&, double strength)>
      prolong;  // as prolonged(), which checks the result; empty: cannot go on
};

// Returns the tools in the order of the alternatives of Stroke.
std::span<const Tool* const> tools();

// Returns the tool of a stroke.
const Tool& tool_of(const Stroke& stroke);

// Returns the tool with this name in session files, or a null pointer.
const Tool* find_tool(std::string_view name);

}  // namespace knead
