// Settings as data. One row for each: its key in scripts and files, where its value lies, what it may be, and what
// panels show of it. Scripts, the journal's view, the preferences and the panels read these rows.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "json/json.h"
#include "knead/vec.h"

namespace knead::studio {

struct PanelState;
struct Preferences;
struct ToolSettings;
struct View;
struct ViewSettings;
struct WindowPlace;

// The range of a slider. A strict range refuses other numbers. Otherwise a whole number is clamped to it, and any other
// number is accepted, but above 0 if the range is.
struct Range {
  double least = -kInfinity;
  double most = kInfinity;
  bool is_strict = false;
};
inline constexpr Range kAboveZero{std::numeric_limits<double>::min(), kInfinity};

// An enum whose values are 0, 1, ... in the order of the words. Panels show the titles, if there are any.
struct WordChoice {
  std::vector<std::string_view> words;
  std::size_t chosen = 0;
  std::function<void(std::size_t)> choose;
  std::vector<const char*> titles{};
};

// A value with a form of its own in JSON. `read` returns false for an invalid value; messages then say what is
// expected.
struct OwnForm {
  std::string_view expected;
  Json value;
  std::function<bool(const Json&)> read;
};

struct Setting {
  std::string key;
  std::variant<bool*, int*, double*, std::optional<double>*, WordChoice, OwnForm> value;
  Range range{};
  const char* label = "";  // in panels; empty: no panel shows it by this row
  const char* help = nullptr;
};

// Return the rows of an object, which must outlive them.
std::vector<Setting> settings_of(ToolSettings& to);
std::vector<Setting> settings_of(View& view);
std::vector<Setting> settings_of(ViewSettings& view);
std::vector<Setting> settings_of(Preferences& to);
std::vector<Setting> settings_of(PanelState& panels);
std::vector<Setting> settings_of(WindowPlace& window);

// Returns the row with this key, or a null pointer.
const Setting* find_setting(std::span<const Setting> settings, std::string_view key);

// Returns the value as scripts and files have it.
Json json_of(const Setting& setting);

// Returns an object with the values of all rows, or of those that differ from the same rows of `defaults`.
Json json_of(std::span<const Setting> settings, std::span<const Setting> defaults = {});

// Gives the setting a value. Throws InvalidInput that says what the value must be.
void set(const Setting& setting, const Json& value);

// Switches a flag, or chooses the next word. Returns false for other values, and for a null pointer.
bool step(const Setting* setting);

}  // namespace knead::studio
