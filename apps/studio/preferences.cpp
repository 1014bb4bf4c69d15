#include "preferences.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>

#include "json/json.h"
#include "knead/error.h"
#include "knead/io.h"
#include "platform/system.h"

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
constexpr std::array<std::string_view, 3> kShadings{"clay", "matcap", "flat"};
constexpr std::array<std::string_view, 2> kProjections{"orthographic", "perspective"};
constexpr double kSmallestWindow = 320;  // points
constexpr double kLargestWindow = 20000;
constexpr double kSmallestScale = 0.5;
constexpr double kLargestScale = 3;
constexpr double kMaxUndoMemory = 1e6;  // MB

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
      } else if (key == "window") {
        read_window(value);
      } else if (key == "desktop_dialogs" && value.is_flag()) {
        loaded_.preferences.desktop_dialogs = value.flag();
      } else if (key == "welcome" && value.is_flag()) {
        loaded_.preferences.welcome = value.flag();
      } else if (key == "interface_scale") {
        read_number(key, value, {kSmallestScale, kLargestScale}, loaded_.preferences.interface_scale);
      } else if (key == "undo_memory_mb") {
        read_number(key, value, {0, kMaxUndoMemory}, loaded_.preferences.undo_memory_mb);
      } else if (!read_look(key, value)) {
        complain(fmt::format(
            "\"{}\" is not a setting; the settings are keys, navigation, up, backend, unit, pen_pressure, outer_ring, "
            "inner_ring, panels, window, welcome, desktop_dialogs, interface_scale, undo_memory_mb, shading, matcap, "
            "cavity, occlusion, "
            "background, "
            "projection and "
            "field_of_view_deg",
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
    const std::optional<render::Color> color = render::color_from(value.is_text() ? value.text() : "");
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
        panels.closed.clear();
        for (const Json& part : each.items()) {
          if (part.is_text()) panels.closed.push_back(part.text());
        }
      } else {
        complain(fmt::format("panels: \"{}\" cannot be {}", key, to_text(each)));
      }
    }
  }

  void read_window(const Json& value) {
    if (!value.is_object()) return complain("\"window\" must be an object, as in {\"width\": 1440, \"height\": 900}");
    WindowPlace& window = loaded_.preferences.window;
    for (const auto& [key, each] : value.members()) {
      int* const size = key == "width" ? &window.width : key == "height" ? &window.height : nullptr;
      if (size != nullptr && each.is_number() && each.number() >= kSmallestWindow && each.number() <= kLargestWindow) {
        *size = static_cast<int>(each.number());
      } else if (key == "maximized" && each.is_flag()) {
        window.maximized = each.flag();
      } else {
        complain(fmt::format("window: \"{}\" cannot be {}", key, to_text(each)));
      }
    }
  }

  void read_number(const std::string& key, const Json& value, std::pair<double, double> limits, double& target) {
    if (!value.is_number() || !(value.number() >= limits.first && value.number() <= limits.second)) {
      return complain(fmt::format("\"{}\" must be a number from {} to {}, got {}", key, limits.first, limits.second,
                                  to_text(value)));
    }
    target = value.number();
  }

  void read_flag(const std::string& key, const Json& value, bool& target) {
    if (!value.is_flag()) return complain(fmt::format("\"{}\" must be true or false, got {}", key, to_text(value)));
    target = value.flag();
  }

  // Returns false for a key that is not about the look.
  bool read_look(const std::string& key, const Json& value) {
    Look& look = loaded_.preferences.look;
    const std::string text = value.is_text() ? value.text() : "";
    if (key == "shading") {
      read_choice(key, value, kShadings, look.material);
    } else if (key == "matcap") {
      const auto found = render::matcap_named(text);
      if (!found) complain(fmt::format("there is no matcap {}; docs/studio.md lists them", to_text(value)));
      look.matcap = found.value_or(look.matcap);
    } else if (key == "cavity") {
      read_flag(key, value, look.relief.cavity);
    } else if (key == "occlusion") {
      read_flag(key, value, look.relief.occlusion);
    } else if (key == "background") {
      const bool is_known = render::background_named(text).has_value();
      if (!is_known)
        complain(fmt::format("\"background\" must be gradient, light, dark or #rrggbb, got {}", to_text(value)));
      if (is_known) look.background = text;
    } else if (key == "projection") {
      read_choice(key, value, kProjections, look.projection);
    } else if (key == "field_of_view_deg") {
      read_number(key, value, {kSmallestFieldDeg, kLargestFieldDeg}, look.field_of_view_deg);
    } else {
      return false;
    }
    return true;
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
  if (panels.closed == usual.closed) return json;
  Json closed = Json::array();
  for (const std::string& part : panels.closed) closed.push_back(part);
  json.set("closed", std::move(closed));
  return json;
}

std::optional<Json> json_of(const WindowPlace& window) {
  if (window == WindowPlace()) return std::nullopt;
  Json json = Json::object();
  json.set("width", static_cast<double>(window.width));
  json.set("height", static_cast<double>(window.height));
  if (window.maximized) json.set("maximized", true);
  return json;
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

namespace {

using OwnMember = std::pair<std::string_view, std::optional<Json>>;  // std::nullopt: as by default

template <class T>
OwnMember member(std::string_view key, const T& value, const T& by_default, const Json& json) {
  return {key, value == by_default ? std::nullopt : std::optional(json)};
}

std::vector<OwnMember> own_members(const Preferences& preferences) {
  const Preferences plain;
  const Look& look = preferences.look;
  return {member("navigation", preferences.navigation, plain.navigation, "maya"),
          member("up", preferences.up, plain.up, "z"),
          member("backend", preferences.backend, plain.backend, "gpu"),
          member("unit", preferences.unit, plain.unit, text_of(preferences.unit)),
          member("pen_pressure", preferences.pressure, plain.pressure,
                 std::string(kPressures[static_cast<std::size_t>(preferences.pressure)])),
          member("outer_ring", preferences.outer_ring, plain.outer_ring, text_of(preferences.outer_ring)),
          member("inner_ring", preferences.inner_ring, plain.inner_ring, text_of(preferences.inner_ring)),
          {"panels", json_of(preferences.panels)},
          {"window", json_of(preferences.window)},
          member("welcome", preferences.welcome, plain.welcome, preferences.welcome),
          member("desktop_dialogs", preferences.desktop_dialogs, plain.desktop_dialogs, preferences.desktop_dialogs),
          member("interface_scale", preferences.interface_scale, plain.interface_scale, preferences.interface_scale),
          member("undo_memory_mb", preferences.undo_memory_mb, plain.undo_memory_mb, preferences.undo_memory_mb),
          member("shading", look.material, plain.look.material,
                 std::string(kShadings[static_cast<std::size_t>(look.material)])),
          member("matcap", look.matcap, plain.look.matcap, std::string(name_of(look.matcap))),
          member("cavity", look.relief.cavity, plain.look.relief.cavity, look.relief.cavity),
          member("occlusion", look.relief.occlusion, plain.look.relief.occlusion, look.relief.occlusion),
          member("background", look.background, plain.look.background, look.background),
          member("projection", look.projection, plain.look.projection, "orthographic"),
          member("field_of_view_deg", look.field_of_view_deg, plain.look.field_of_view_deg, look.field_of_view_deg)};
}

}  // namespace

void save_preferences(const fs::path& folder, const Preferences& preferences) {
  const std::vector<OwnMember> own = own_members(preferences);
  Json config = Json::object();
  const Json before = read_json(folder / kConfigFile).value_or(Json());
  if (before.is_object()) {
    for (const JsonMember& member : before.members()) {
      const bool is_own =
          std::any_of(own.begin(), own.end(), [&](const auto& each) { return each.first == member.key; });
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

namespace fs = std::filesystem;

namespace {

constexpr const char* kFile = "references.json";
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

std::optional<std::string> bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream.is_open()) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

// An object without members where there is no file, or another one.
Json read_all(const fs::path& folder) {
  const std::optional<std::string> text = bytes_of(folder / kFile);
  if (!text) return Json::object();
  try {
    Json all = parse_json(*text);
    return all.is_object() ? all : Json::object();
  } catch (const JsonError&) {
    return Json::object();
  }
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
  const std::optional<std::string> bytes = bytes_of(file);
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
  write_file_atomically(folder / kFile, to_indented_text(all));
}

}  // namespace knead::studio
