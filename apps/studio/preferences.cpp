#include "preferences.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>

#include "knead/io/atomic_file.h"
#include "knead/io/json.h"
#include "knead/math/error.h"

namespace knead::studio {

namespace fs = std::filesystem;

namespace {

constexpr const char* kConfigFile = "studio.json";
constexpr const char* kRecentFile = "recent.json";
constexpr std::array<std::string_view, 2> kNavigations{"blender", "maya"};
constexpr std::array<std::string_view, 2> kUps{"y", "z"};
constexpr std::array<std::string_view, 2> kBackends{"cpu", "gpu"};
constexpr std::array<std::string_view, 4> kUnits{"", "mm", "cm", "m"};
constexpr std::array<std::string_view, 3> kPressures{"none", "radius", "depth"};
constexpr double kSmallestScale = 0.5;
constexpr double kLargestScale = 3;

fs::path folder_of(const char* variable, const char* under_home) {
  const char* const value = std::getenv(variable);
  if (value != nullptr && value[0] == '/') return fs::path(value) / "knead";
  const char* const home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/') return fs::path(home) / under_home / "knead";
  return fs::temp_directory_path() / "knead";
}

std::optional<std::string> read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open()) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Returns the JSON of a file: null if the file is missing, nothing if it holds something else.
std::optional<Json> read_json(const fs::path& path) {
  const std::optional<std::string> text = read_text(path);
  if (!text) return Json();
  try {
    return parse_json(*text, JsonDialect::by_hand);
  } catch (const JsonError&) {
    return std::nullopt;
  }
}

void write_json(const fs::path& folder, const char* name, const Json& json) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw IoError(IoError::Operation::write, folder.string(),
                  "the folder cannot be made (" + error.message() + "); check its permissions");
  }
  write_file_atomically(folder / name, to_indented_text(json));
}

// "#rrggbb"
std::string text_of(const render::Color& color) {
  const auto byte = [](float part) { return std::clamp(std::lround(255 * part), 0L, 255L); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(color.red), byte(color.green), byte(color.blue));
}

std::optional<render::Color> color_of(std::string_view text) {
  const bool is_hex = text.size() == 7 && text[0] == '#' &&
                      std::all_of(text.begin() + 1, text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
  if (!is_hex) return std::nullopt;
  const auto part = [&](std::size_t at) {
    return static_cast<float>(std::stoi(std::string(text.substr(at, 2)), nullptr, 16)) / 255;
  };
  return render::Color{part(1), part(3), part(5), 1};
}

// Reads the members of the configuration one after the other.
class Reader {
 public:
  explicit Reader(LoadedPreferences& loaded) : loaded_(loaded) {}

  void read(const Json& config) {
    for (const auto& [key, value] : config.members()) {
      if (key == "keys") {
        read_keys(value);
      } else if (key == "navigation") {
        read_choice(key, value, kNavigations, loaded_.preferences.navigation);
      } else if (key == "up") {
        read_choice(key, value, kUps, loaded_.preferences.up);
      } else if (key == "backend") {
        read_choice(key, value, kBackends, loaded_.preferences.backend);
      } else if (key == "unit") {
        read_choice(key, value, kUnits, loaded_.preferences.unit);
      } else if (key == "pen_pressure") {
        read_choice(key, value, kPressures, loaded_.preferences.pressure);
      } else if (key == "outer_ring") {
        read_color(key, value, loaded_.preferences.outer_ring);
      } else if (key == "inner_ring") {
        read_color(key, value, loaded_.preferences.inner_ring);
      } else if (key == "panels") {
        read_panels(value);
      } else if (key == "interface_scale") {
        read_scale(value);
      } else {
        complain(
            fmt::format("\"{}\" is not a setting; the settings are keys, navigation, up, backend, unit, pen_pressure, "
                        "outer_ring, inner_ring, "
                        "panels and interface_scale",
                        key));
      }
    }
  }

 private:
  void complain(const std::string& what) { loaded_.messages.push_back(fmt::format("{}: {}", kConfigFile, what)); }

  // An enum whose values are 0, 1, ... in the order of the names.
  template <class T, std::size_t N>
  void read_choice(const std::string& key, const Json& value, const std::array<std::string_view, N>& names, T& target) {
    const auto found = std::find(names.begin(), names.end(), value.is_text() ? value.text() : "?");
    if (found == names.end()) {
      return complain(fmt::format("\"{}\" must be \"{}\", got {}", key, fmt::join(names, "\" or \""), to_text(value)));
    }
    target = static_cast<T>(found - names.begin());
  }

  void read_color(const std::string& key, const Json& value, render::Color& target) {
    const std::optional<render::Color> color = color_of(value.is_text() ? value.text() : "");
    if (!color)
      return complain(fmt::format("\"{}\" must be a colour such as \"#0073b3\", got {}", key, to_text(value)));
    target = *color;
  }

  void read_panels(const Json& value) {
    if (!value.is_object()) return complain("\"panels\" must be an object, as in {\"width\": 360}");
    PanelState& panels = loaded_.preferences.panels;
    for (const auto& [key, each] : value.members()) {
      bool* const flag = key == "shown"     ? &panels.shown
                         : key == "history" ? &panels.history
                         : key == "labels"  ? &panels.labels
                                            : nullptr;
      if (flag != nullptr && each.is_flag()) {
        *flag = each.flag();
      } else if (key == "width" && each.is_number() && each.number() > 0) {
        panels.width = each.number();
      } else if (key == "closed" && each.is_array()) {
        for (const Json& part : each.items()) {
          if (part.is_text()) panels.closed.push_back(part.text());
        }
      } else {
        complain(fmt::format("panels: \"{}\" cannot be {}", key, to_text(each)));
      }
    }
  }

  void read_scale(const Json& value) {
    if (!value.is_number() || !(value.number() >= kSmallestScale && value.number() <= kLargestScale)) {
      return complain(fmt::format("\"interface_scale\" must be a number from {} to {}, got {}", kSmallestScale,
                                  kLargestScale, to_text(value)));
    }
    loaded_.preferences.interface_scale = value.number();
  }

  void read_keys(const Json& keys) {
    if (!keys.is_object()) return complain("\"keys\" must be an object, as in {\"undo\": \"Ctrl+Z\"}");
    std::vector<KeyChoice> choices;
    for (const auto& [action, value] : keys.members()) {
      KeyChoice choice{action, {}};
      if (value.is_text() && !value.text().empty()) choice.chords.push_back(value.text());
      bool good = value.is_text() || value.is_array() || value.is_null();
      if (value.is_array()) {
        for (const Json& item : value.items()) {
          good = good && item.is_text();
          if (item.is_text()) choice.chords.push_back(item.text());
        }
      }
      if (good) {
        choices.push_back(choice);
      } else {
        complain(fmt::format("keys: \"{}\" must be a key or a list of keys, got {}", action, to_text(value)));
      }
    }
    for (const std::string& message : choose_keys(loaded_.preferences.keys, choices)) complain(message);
  }

  LoadedPreferences& loaded_;
};

}  // namespace

namespace {

// What differs from the defaults; nothing if all is as by default.
std::optional<Json> json_of(const PanelState& panels) {
  const PanelState usual;
  if (panels == usual) return std::nullopt;
  Json json = Json::object();
  if (panels.shown != usual.shown) json.set("shown", panels.shown);
  if (panels.history != usual.history) json.set("history", panels.history);
  if (panels.labels != usual.labels) json.set("labels", panels.labels);
  if (panels.width != usual.width) json.set("width", panels.width);
  if (panels.closed.empty()) return json;
  Json closed = Json::array();
  for (const std::string& part : panels.closed) closed.push_back(part);
  json.set("closed", std::move(closed));
  return json;
}

}  // namespace

fs::path config_folder() { return folder_of("XDG_CONFIG_HOME", ".config"); }

fs::path state_folder() { return folder_of("XDG_STATE_HOME", ".local/state"); }

LoadedPreferences load_preferences(const fs::path& folder) {
  LoadedPreferences loaded;
  const fs::path path = folder / kConfigFile;
  const std::optional<Json> config = read_json(path);
  if (config && config->is_null()) return loaded;
  if (config && config->is_object()) {
    Reader(loaded).read(*config);
    return loaded;
  }
  fs::path aside = path;
  aside += ".broken";
  std::error_code error;
  fs::rename(path, aside, error);
  loaded.messages.push_back(fmt::format("{} is no JSON object; {}, and Studio starts with its defaults", path.string(),
                                        error ? "it was left as it is" : "it is kept as " + aside.string()));
  return loaded;
}

void save_preferences(const fs::path& folder, const Preferences& preferences) {
  const Preferences usual;
  const auto color = [](const render::Color& now, const render::Color& by_default) {
    return now == by_default ? std::nullopt : std::optional<Json>(text_of(now));
  };
  const std::array<std::pair<std::string_view, std::optional<Json>>, 9> own{
      {{"navigation", preferences.navigation == NavigationPreset::maya ? std::optional<Json>("maya") : std::nullopt},
       {"up", preferences.up == UpAxis::z ? std::optional<Json>("z") : std::nullopt},
       {"backend", preferences.backend == BackendChoice::gpu ? std::optional<Json>("gpu") : std::nullopt},
       {"unit", preferences.unit == usual.unit ? std::nullopt : std::optional<Json>(text_of(preferences.unit))},
       {"pen_pressure",
        preferences.pressure == usual.pressure
            ? std::nullopt
            : std::optional<Json>(std::string(kPressures[static_cast<std::size_t>(preferences.pressure)]))},
       {"outer_ring", color(preferences.outer_ring, usual.outer_ring)},
       {"inner_ring", color(preferences.inner_ring, usual.inner_ring)},
       {"panels", json_of(preferences.panels)},
       {"interface_scale",
        preferences.interface_scale != 1 ? std::optional<Json>(preferences.interface_scale) : std::nullopt}}};
  Json config = Json::object();
  const Json before = read_json(folder / kConfigFile).value_or(Json());
  if (before.is_object()) {
    for (const JsonMember& member : before.members()) {
      const bool is_own = std::ranges::any_of(own, [&](const auto& each) { return each.first == member.key; });
      if (!is_own) config.set(member.key, member.value);
    }
  }
  for (const auto& [key, value] : own) {
    if (value) config.set(key, *value);
  }
  write_json(folder, kConfigFile, config);
}

const char* text_of(LengthUnit unit) { return kUnits[static_cast<std::size_t>(unit)].data(); }

std::vector<fs::path> load_recent(const fs::path& folder) {
  std::vector<fs::path> recent;
  const std::optional<Json> list = read_json(folder / kRecentFile);
  if (!list || !list->is_array()) return recent;
  for (const Json& item : list->items()) {
    std::error_code error;
    if (item.is_text() && fs::exists(item.text(), error)) recent.emplace_back(item.text());
    if (recent.size() == kMostRecent) break;
  }
  return recent;
}

void add_recent(std::vector<fs::path>& recent, const fs::path& file) {
  std::error_code error;
  fs::path absolute = fs::absolute(file, error).lexically_normal();
  if (error) absolute = file;
  std::erase(recent, absolute);
  recent.insert(recent.begin(), absolute);
  if (recent.size() > kMostRecent) recent.resize(kMostRecent);
}

void save_recent(const fs::path& folder, std::span<const fs::path> recent) {
  Json list = Json::array();
  for (const fs::path& file : recent) list.push_back(file.string());
  write_json(folder, kRecentFile, list);
}

}  // namespace knead::studio
