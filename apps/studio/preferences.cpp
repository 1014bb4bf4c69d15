#include "preferences.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

// Reads the members of the configuration one after the other.
class Reader {
 public:
  explicit Reader(LoadedPreferences& loaded) : loaded_(loaded) {}

  void read(const Json& config) {
    for (const auto& [key, value] : config.members()) {
      if (key == "keys") {
        read_keys(value);
      } else if (key == "navigation") {
        read_choice(key, value, {"blender", "maya"}, loaded_.preferences.navigation);
      } else if (key == "up") {
        read_choice(key, value, {"y", "z"}, loaded_.preferences.up);
      } else if (key == "backend") {
        read_choice(key, value, {"cpu", "gpu"}, loaded_.preferences.backend);
      } else if (key == "interface_scale") {
        read_scale(value);
      } else {
        complain(fmt::format("\"{}\" is not known; known are keys, navigation, up, backend and interface_scale", key));
      }
    }
  }

 private:
  void complain(const std::string& what) { loaded_.messages.push_back(fmt::format("{}: {}", kConfigFile, what)); }

  // An enum whose values are 0 and 1.
  template <class T>
  void read_choice(const std::string& key, const Json& value, std::array<std::string_view, 2> names, T& target) {
    const auto* const found = std::find(names.begin(), names.end(), value.is_text() ? value.text() : "");
    if (found == names.end()) {
      return complain(fmt::format("\"{}\" must be \"{}\" or \"{}\", got {}", key, names[0], names[1], to_text(value)));
    }
    target = static_cast<T>(found - names.begin());
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
  const std::array<std::pair<std::string_view, std::optional<Json>>, 4> own{
      {{"navigation", preferences.navigation == NavigationPreset::maya ? std::optional<Json>("maya") : std::nullopt},
       {"up", preferences.up == UpAxis::z ? std::optional<Json>("z") : std::nullopt},
       {"backend", preferences.backend == BackendChoice::gpu ? std::optional<Json>("gpu") : std::nullopt},
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
