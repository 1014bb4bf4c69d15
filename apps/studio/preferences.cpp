// Reads and writes what Studio remembers: preferences, the files opened last, pictures behind the shape.
#include "preferences.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include "json/json.h"
#include "knead/error.h"
#include "knead/io.h"
#include "platform/system.h"
#include "setting.h"

namespace knead::studio {

namespace fs = std::filesystem;

namespace {

constexpr const char* kConfigFile = "studio.json";
constexpr const char* kRecentFile = "recent.json";
fs::path folder_of(const char* variable, const char* under_home) {
  const char* const value = std::getenv(variable);
  if (value != nullptr && fs::path(value).is_absolute()) return fs::path(value) / "knead";
  const fs::path home = home_folder();
  if (!home.empty()) return home / under_home / "knead";
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
    const std::vector<Setting> settings = settings_of(loaded_.preferences);
    for (const auto& [key, value] : config.members()) {
      if (key == "keys") {
        read_keys(value);
      } else if (key == "panels") {
        read_group(key, value, settings_of(loaded_.preferences.panels));
      } else if (key == "window") {
        read_group(key, value, settings_of(loaded_.preferences.window));
      } else {
        read_setting("", key, value, settings);
      }
    }
  }

 private:
  void complain(const std::string& what) { loaded_.messages.push_back(fmt::format("{}: {}", kConfigFile, what)); }

  // `group`: before what is said of its members.
  void read_setting(const std::string& group, const std::string& key, const Json& value,
                    const std::vector<Setting>& settings) {
    const Setting* const setting = find_setting(settings, key);
    try {
      if (setting != nullptr) return set(*setting, value);
      std::string keys;
      for (const Setting& each : settings) keys += (keys.empty() ? "" : ", ") + each.key;
      if (group.empty()) keys += ", keys, panels, window";
      complain(fmt::format("{}\"{}\" is not a setting; the settings are {}", group, key, keys));
    } catch (const InvalidInput& error) {
      complain(group + error.what());
    }
  }

  void read_group(const std::string& group, const Json& value, const std::vector<Setting>& settings) {
    if (!value.is_object()) return complain(fmt::format("\"{}\" must be an object, as in {{\"width\": 360}}", group));
    for (const auto& [key, each] : value.members()) read_setting(group + ": ", key, each, settings);
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

constexpr const char* kReferencesFile = "references.json";
constexpr double kStraight = 0.9995;  // the cosine up to which a view is that of a plane
constexpr std::array kPlanes{ReferencePlane::front, ReferencePlane::right, ReferencePlane::top};

StandardView side_of(ReferencePlane plane) {
  switch (plane) {
    case ReferencePlane::front:
      return StandardView::front;
    case ReferencePlane::right:
      return StandardView::right;
    case ReferencePlane::top:
      return StandardView::top;
  }
  return StandardView::front;
}

// How directly a view looks at a plane: 1 from the front or the back, 0 along it.
double straightness(const View& view, ReferencePlane plane) {
  const Vec3d forward = render::camera_frame(camera_of(view)).forward;
  return std::abs(dot(forward, frame_of(plane, view.up).forward));
}

// An object without members where there is no file, or another one.
Json read_all(const fs::path& folder) {
  Json all = read_json(folder / kReferencesFile).value_or(Json());
  return all.is_object() ? all : Json::object();
}

Json json_of(const Reference& reference) {
  Json center = Json::array();
  for (std::size_t i = 0; i < 3; ++i) center.push_back(reference.center[i]);
  return Json{
      {"file", reference.file.string()},      {"plane", name_of(reference.plane)}, {"center", center},
      {"height", reference.height},           {"opacity", reference.opacity},      {"shown", reference.is_shown},
      {"every_view", reference.in_every_view}};
}

// Throws where a member is missing or of another type.
Reference reference_of(const Json& json) {
  Reference reference;
  reference.file = json.at("file").text();
  for (const ReferencePlane plane : kPlanes) {
    if (json.at("plane").text() == name_of(plane)) reference.plane = plane;
  }
  const std::vector<Json>& center = json.at("center").items();
  if (center.size() != 3) throw InvalidInput("a centre has three numbers");
  for (std::size_t i = 0; i < 3; ++i) reference.center[i] = center[i].number();
  reference.height = json.at("height").number();
  reference.opacity = std::clamp(json.at("opacity").number(), 0.0, 1.0);
  reference.is_shown = json.at("shown").flag();
  reference.in_every_view = json.at("every_view").flag();
  if (!(reference.height > 0)) throw InvalidInput("the height is not above 0");
  reference.image = read_reference(reference.file);
  return reference;
}

std::string key_of(const fs::path& document) {
  std::error_code error;
  const fs::path absolute = fs::absolute(document, error);
  return (error ? document : absolute.lexically_normal()).string();
}

}  // namespace

fs::path config_folder() { return folder_of("XDG_CONFIG_HOME", kConfigUnderHome); }

fs::path state_folder() { return folder_of("XDG_STATE_HOME", kStateUnderHome); }

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
  Preferences own = preferences;
  Preferences plain;
  const std::vector<Setting> settings = settings_of(own);
  Json config = Json::object();
  const Json before = read_json(folder / kConfigFile).value_or(Json());
  if (before.is_object()) {
    for (const JsonMember& member : before.members()) {
      const bool is_own =
          find_setting(settings, member.key) != nullptr || member.key == "panels" || member.key == "window";
      if (!is_own) config.set(member.key, member.value);
    }
  }
  const Json changed = json_of(settings, settings_of(plain));
  for (const auto& [key, value] : changed.members()) config.set(key, value);
  const Json panels = json_of(settings_of(own.panels), settings_of(plain.panels));
  if (!panels.members().empty()) config.set("panels", panels);
  const Json window = json_of(settings_of(own.window), settings_of(plain.window));
  if (!window.members().empty()) config.set("window", window);
  write_json(folder, kConfigFile, config);
}

const char* text_of(LengthUnit unit) { return std::array{"", "mm", "cm", "m"}[static_cast<std::size_t>(unit)]; }

std::vector<fs::path> load_recent(const fs::path& folder) {
  std::vector<fs::path> recent;
  const std::optional<Json> list = read_json(folder / kRecentFile);
  if (!list || !list->is_array()) return recent;
  for (const Json& item : list->items()) {
    std::error_code error;
    if (item.is_text() && fs::exists(item.text(), error)) recent.emplace_back(item.text());
    if (recent.size() == kMaxRecent) break;
  }
  return recent;
}

void add_recent(std::vector<fs::path>& recent, const fs::path& file) {
  std::error_code error;
  fs::path absolute = fs::absolute(file, error).lexically_normal();
  if (error) absolute = file;
  std::erase(recent, absolute);
  recent.insert(recent.begin(), absolute);
  if (recent.size() > kMaxRecent) recent.resize(kMaxRecent);
}

void save_recent(const fs::path& folder, std::span<const fs::path> recent) {
  Json list = Json::array();
  for (const fs::path& file : recent) list.push_back(file.string());
  write_json(folder, kRecentFile, list);
}

const char* name_of(ReferencePlane plane) {
  return std::array{"front", "right", "top"}[static_cast<std::size_t>(plane)];
}

render::CameraFrame frame_of(ReferencePlane plane, UpAxis up) {
  View view;
  view.up = up;
  return render::camera_frame(camera_of(seen_from(view, side_of(plane))));
}

ReferencePlane plane_of(const View& view) {
  return *std::max_element(kPlanes.begin(), kPlanes.end(), [&](ReferencePlane a, ReferencePlane b) {
    return straightness(view, a) < straightness(view, b);
  });
}

std::vector<render::PlacedImage> placed_images(const std::vector<Reference>& references, const View& view) {
  std::vector<render::PlacedImage> placed;
  for (const Reference& reference : references) {
    if (!reference.is_shown || reference.image == nullptr) continue;
    if (!reference.in_every_view && straightness(view, reference.plane) < kStraight) continue;
    const render::CameraFrame frame = frame_of(reference.plane, view.up);
    const double aspect = static_cast<double>(reference.image->width) / reference.image->height;
    placed.push_back({reference.image, reference.center, frame.right * (0.5 * reference.height * aspect),
                      frame.up * (0.5 * reference.height), static_cast<float>(reference.opacity)});
  }
  return placed;
}

std::shared_ptr<const render::Image> read_reference(const fs::path& file) {
  const std::optional<std::string> bytes = read_text(file);
  if (!bytes) throw IoError(IoError::Operation::read, file.string(), "the picture cannot be opened");
  try {
    return std::make_shared<const render::Image>(render::decode_image(*bytes));
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("{}: {}", file.string(), error.what()));
  }
}

LoadedReferences load_references(const fs::path& folder, const fs::path& document) {
  LoadedReferences loaded;
  const Json all = read_all(folder);
  const Json* const own = document.empty() ? nullptr : all.find(key_of(document));
  if (own == nullptr || !own->is_array()) return loaded;
  for (const Json& item : own->items()) {
    try {
      loaded.references.push_back(reference_of(item));
    } catch (const std::exception& error) {
      loaded.messages.push_back(fmt::format("A reference image is left out: {}", error.what()));
    }
  }
  return loaded;
}

void save_references(const fs::path& folder, const fs::path& document, const std::vector<Reference>& references) {
  if (document.empty()) return;
  const std::string key = key_of(document);
  Json all = Json::object();
  const Json before = read_all(folder);
  for (const JsonMember& member : before.members()) {
    if (member.key != key) all.set(member.key, member.value);
  }
  Json own = Json::array();
  for (const Reference& reference : references) own.push_back(json_of(reference));
  if (!references.empty()) all.set(key, own);
  std::error_code error;
  fs::create_directories(folder, error);
  write_file_atomically(folder / kReferencesFile, to_indented_text(all));
}

}  // namespace knead::studio
