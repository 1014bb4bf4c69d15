// Entries of the history: their names, words, paths and numbers, and changes of them.
#include "document/layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>
#include <utility>
#include <variant>

#include "knead/editor/tools.h"
#include "knead/editor/workbench.h"
#include "knead/error.h"

namespace knead::studio {

namespace {

constexpr std::size_t kMaxHandles = 9;  // of one path
constexpr double kReach = 10;           // points

// The word by which scripts and keys of Studio name the tool of a stroke.
std::string tool_word(const Stroke& stroke) {
  std::string word = tool_name(stroke);
  if (const auto* implicit = std::get_if<ImplicitStroke>(&stroke)) {
    const char* const wide = implicit->taper > 0 ? "snakehook" : "move";
    word = implicit->region == ImplicitRegion::capsule ? "capsule" : implicit->bump > 0 ? wide : "ball";
  }
  if (const auto* paint = std::get_if<PaintStroke>(&stroke); paint != nullptr && paint->pinch != 0) {
    word = paint->pinch < 0 ? "flatten" : paint->depth == 0 ? "pinch" : "crease";
  }
  if (const auto* points = std::get_if<PointsStroke>(&stroke); points != nullptr && points->points.empty()) {
    word = "curve";
  }
  if (std::holds_alternative<CurveStroke>(stroke)) word = "bend_along";
  if (word == "relax") word = "smooth";
  if (word == "pins" || word == "grid") word = "pose";
  return word;
}

// Returns Studio's name for the tool of a stroke.
std::string title_of(const Stroke& stroke) {
  std::string word = tool_word(stroke);
  if (const StudioTool* const tool = studio_tool(word)) return tool->name;
  word[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[0])));
  return word;
}

std::string lines_of(const std::vector<SessionStroke>& strokes) {
  std::string text;
  for (const SessionStroke& stroke : strokes) text += stroke_line(stroke) + "\n";
  return text;
}

// Returns the strokes of typed lines, with the remesh settings of the strokes before.
std::vector<SessionStroke> strokes_of_lines(const std::string& text, const std::optional<RemeshSettings>& remesh) {
  Session session = parse_session(header_line({}, {}) + "\n" + text, "history");
  for (SessionStroke& stroke : session.strokes) stroke.remesh = remesh;
  if (session.strokes.empty()) throw InvalidInput("no stroke is left; use \"Remove\" instead");
  return session.strokes;
}

// A change of the strokes of one entry.
template <class Change>
LayerChange change_of(std::size_t entry, Change change) {
  return [entry, change = std::move(change)](Layers& layers) {
    if (entry < layers.size()) change(layers[entry]);
  };
}

void give_name(std::vector<SessionStroke>& strokes, const std::string& name) {
  for (SessionStroke& stroke : strokes) stroke.name = name;
}

Layers::iterator at(Layers& layers, std::size_t entry) { return layers.begin() + static_cast<std::ptrdiff_t>(entry); }

// A path with the numbers of strokes that it is made of.
struct OwnedPath {
  std::vector<Vec3d> points;
  std::vector<std::vector<Vec3d*>> owners;  // of each point: where two strokes meet, of both
  std::size_t tool = 0;                     // of its strokes
  bool is_whole = false;                    // all owners move alike: a set of points
};

// The points of a stroke's key if it is a path or a place.
struct Places {
  std::vector<Vec3d>* path = nullptr;
  Vec3d* center = nullptr;
};

Places places_of(Stroke& stroke) {
  Places places;
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    if (key.quantity != Quantity::finite) continue;
    auto* const* list = std::get_if<std::vector<Vec3d>*>(&key.value);
    auto* const* place = std::get_if<Vec3d*>(&key.value);
    if (list != nullptr && *list != nullptr && key.name == "path") places.path = *list;
    if (place != nullptr && *place != nullptr) places.center = *place;
  }
  return places;
}

void add_path(std::size_t tool, std::vector<Vec3d>& path, std::vector<OwnedPath>& paths) {
  if (path.empty()) return;
  const auto found = std::find_if(paths.rbegin(), paths.rend(), [&](const OwnedPath& before) {
    return before.tool == tool && before.points.size() > 1 && before.points.back() == path.front();
  });
  OwnedPath& whole = found == paths.rend() ? paths.emplace_back() : *found;
  whole.tool = tool;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i == 0 && !whole.points.empty()) {
      whole.owners.back().push_back(path.data());
    } else {
      whole.points.push_back(path[i]);
      whole.owners.push_back({&path[i]});
    }
  }
}

// A set of points moves as a whole, by its middle.
void add_set(std::size_t tool, PointsStroke& stroke, std::vector<OwnedPath>& paths) {
  OwnedPath whole{{}, {{}}, tool, true};
  const auto add = [&](std::vector<Vec3d>& points) {
    for (Vec3d& p : points) whole.owners.front().push_back(&p);
  };
  add(stroke.points);
  for (std::vector<Vec3d>& curve : stroke.curves) add(curve);
  Vec3d sum{0, 0, 0};
  for (const Vec3d* p : whole.owners.front()) sum += *p;
  whole.points.push_back(sum / static_cast<double>(whole.owners.front().size()));
  paths.push_back(std::move(whole));
}

// The displacement of each pin that moves.
void add_pins(std::size_t tool, PinsStroke& stroke, std::vector<OwnedPath>& paths) {
  for (std::size_t i = 0; i < stroke.points.size(); ++i) {
    Vec3d& from = stroke.points[i];
    Vec3d& to = stroke.to[i];
    if (!(from == to)) paths.push_back({{from, to}, {{&from}, {&to}}, tool});
  }
}

// Resets the strength of an entry above 1, because the prolonged part of its paths has no handles. Returns the
// strength.
double without_beyond(std::vector<SessionStroke>& strokes) {
  const double strength = strength_of(strokes);
  if (strength > 1) set_strength(strokes, 1);
  return strength;
}

std::vector<OwnedPath> owned_paths(std::vector<SessionStroke>& strokes) {
  std::vector<OwnedPath> paths;
  for (SessionStroke& each : strokes) {
    const std::size_t tool = each.stroke.index();
    if (auto* points = std::get_if<PointsStroke>(&each.stroke)) {
      add_set(tool, *points, paths);
      continue;
    }
    if (auto* pins = std::get_if<PinsStroke>(&each.stroke)) {
      add_pins(tool, *pins, paths);
      continue;
    }
    const Places places = places_of(each.stroke);
    if (places.path != nullptr) add_path(tool, *places.path, paths);
    if (places.path == nullptr && places.center != nullptr)
      paths.push_back({{*places.center}, {{places.center}}, tool});
  }
  return paths;
}

std::vector<std::size_t> handles_of(std::size_t points) {
  const std::size_t count = std::min(points, kMaxHandles);
  std::vector<std::size_t> handles;
  for (std::size_t k = 0; k < count; ++k) handles.push_back(count == 1 ? 0 : k * (points - 1) / (count - 1));
  return handles;
}

// Returns for each point of a path its fraction of a handle's motion: 1 at the handle, 0 at its neighbours.
std::vector<double> weights_of(const LayerPath& path, std::size_t handle) {
  const std::size_t at = path.handles[handle];
  const std::size_t first = handle == 0 ? at : path.handles[handle - 1];
  const std::size_t last = handle + 1 == path.handles.size() ? at : path.handles[handle + 1];
  std::vector<double> weights(path.points.size(), 0.0);
  for (std::size_t i = first; i < at; ++i) {
    weights[i] = static_cast<double>(i - first) / static_cast<double>(at - first);
  }
  for (std::size_t i = at; i < last; ++i) {
    weights[i] = static_cast<double>(last - i) / static_cast<double>(last - at);
  }
  weights[at] = 1;
  return weights;
}

Vec3d mirrored_in(const Vec3d& p, unsigned planes) {
  return {(planes & 1U) != 0 ? -p.x : p.x, (planes & 2U) != 0 ? -p.y : p.y, (planes & 4U) != 0 ? -p.z : p.z};
}

// The planes in which one path is the image of another; nothing if it is not.
std::optional<unsigned> planes_between(const OwnedPath& path, const OwnedPath& image) {
  if (path.tool != image.tool || path.points.size() != image.points.size()) return std::nullopt;
  for (unsigned planes = 1; planes < 8; ++planes) {
    const auto is_image = [&](const Vec3d& p, const Vec3d& q) { return mirrored_in(p, planes) == q; };
    if (std::equal(path.points.begin(), path.points.end(), image.points.begin(), is_image)) return planes;
  }
  return std::nullopt;
}

void move(const OwnedPath& path, const std::vector<double>& weights, const Vec3d& by) {
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (weights[i] == 0) continue;
    for (Vec3d* owner : path.owners[i]) *owner = path.is_whole ? *owner + by : path.points[i] + by * weights[i];
  }
}

// Calls visit(name, help, number) for each of a stroke's numbers that can be changed afterwards.
template <class Visit>
void visit_fields(Stroke& stroke, const Visit& visit) {
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    if (key.help.empty() || !applies(key)) continue;
    if (auto* const* number = std::get_if<double*>(&key.value)) visit(key.name, key.help, **number);
    if (auto* const* number = std::get_if<std::optional<double>*>(&key.value); number != nullptr && **number) {
      visit(key.name, key.help, ***number);
    }
    if (const auto* number = std::get_if<AutoNumber>(&key.value); number != nullptr && *number->value) {
      visit(key.name, key.help, **number->value);
    }
    if (auto* const* motion = std::get_if<HandlesMotion*>(&key.value)) {
      if (auto* turn = std::get_if<HandlesRotation>(*motion)) visit("angle_deg", key.help, turn->angle_deg);
    }
  }
}

}  // namespace

std::string name_of(std::span<const SessionStroke> strokes) {
  if (strokes.empty()) return "Nothing";
  const std::string& own = strokes.front().name;
  return own.empty() ? title_of(strokes.front().stroke) : own;
}

std::string description_of(std::span<const SessionStroke> strokes) {
  if (strokes.empty()) return "nothing";
  const Stroke& first = strokes.front().stroke;
  const std::string name = title_of(first);
  std::string text = strokes.size() == 1 ? name : fmt::format("{} x {}", strokes.size(), name);
  if (const auto* implicit = std::get_if<ImplicitStroke>(&first)) {
    const std::size_t pieces = implicit->path.size() - 1;
    text += pieces == 1 ? ", 1 piece" : fmt::format(", {} pieces", pieces);
  } else if (const auto* paint = std::get_if<PaintStroke>(&first)) {
    text += fmt::format(", {} dabs", paint->samples.size() + paint->path.size());
  } else if (const auto* relax = std::get_if<RelaxStroke>(&first)) {
    text += fmt::format(", {} dabs", relax->points.size());
  }
  return text;
}

std::string words_of(std::span<const SessionStroke> strokes, const std::string& unit) {
  if (strokes.empty()) return "Nothing";
  Stroke first = strokes.front().stroke;
  if (const auto way = stamp_way(strokes)) *find_value<std::vector<Vec3d>>(first, "path") = {way->from, way->to};
  return words_of(first, unit);
}

std::optional<StampWay> stamp_way(std::span<const SessionStroke> strokes) {
  std::optional<StampWay> way;
  for (const SessionStroke& line : strokes) {
    Stroke stroke = line.stroke;
    const auto* const keyed = find_value<std::vector<Vec3d>>(stroke, "path");
    if (file_of(stroke).empty() || keyed == nullptr) break;
    const std::vector<Vec3d>& path = *keyed;
    if (!way) way = {path.front(), path.front()};
    if (path.front() == way->to) way->to = path.back();  // else an image in a mirror
  }
  return way;
}

const StudioTool* tool_of(std::span<const SessionStroke> strokes) {
  return strokes.empty() ? nullptr : studio_tool(tool_word(strokes.front().stroke));
}

bool is_found(std::span<const SessionStroke> strokes, const std::string& text) {
  const std::string where = lower(name_of(strokes) + " " + words_of(strokes, {}));
  std::istringstream words(lower(text));
  for (std::string word; words >> word;) {
    if (where.find(word) == std::string::npos) return false;
  }
  return true;
}

bool is_off(std::span<const SessionStroke> strokes) {
  return std::all_of(strokes.begin(), strokes.end(), [](const SessionStroke& stroke) { return stroke.off; });
}

LayerChange renamed(std::size_t entry, const std::string& name) {
  return change_of(entry, [name](std::vector<SessionStroke>& strokes) { give_name(strokes, name); });
}

LayerChange switched(std::size_t entry, bool off) {
  return change_of(entry, [off](std::vector<SessionStroke>& strokes) {
    for (SessionStroke& stroke : strokes) stroke.off = off;
  });
}

LayerChange with_strength(std::size_t entry, double strength) {
  const double kept = std::clamp(strength, 0.0, kMaxStrength);
  return change_of(entry, [kept](std::vector<SessionStroke>& strokes) { set_strength(strokes, kept); });
}

LayerChange moved(std::size_t entry, std::size_t to) {
  return [entry, to](Layers& layers) {
    if (entry >= layers.size() || to >= layers.size()) return;
    if (entry < to) std::rotate(at(layers, entry), at(layers, entry + 1), at(layers, to + 1));
    if (to < entry) std::rotate(at(layers, to), at(layers, entry), at(layers, entry + 1));
  };
}

LayerChange joined(std::size_t entry) {
  return [entry](Layers& layers) {
    if (entry == 0 || entry >= layers.size()) return;
    std::vector<SessionStroke>& before = layers[entry - 1];
    const std::string name = name_of(before);
    before.insert(before.end(), layers[entry].begin(), layers[entry].end());
    give_name(before, name);
    layers.erase(at(layers, entry));
  };
}

LayerChange split(std::size_t entry) {
  return [entry](Layers& layers) {
    if (entry >= layers.size() || layers[entry].size() < 2) return;
    const std::vector<SessionStroke> strokes = layers[entry];
    layers.erase(at(layers, entry));
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      SessionStroke own = strokes[i];
      own.name = fmt::format("{} {}", name_of({&own, 1}), i + 1);
      layers.insert(at(layers, entry + i), {std::move(own)});
    }
  };
}

LayerChange removed(std::size_t entry) { return replaced(entry, {}); }

LayerChange replaced(std::size_t entry, std::vector<SessionStroke> strokes) {
  return change_of(entry, [strokes = std::move(strokes)](std::vector<SessionStroke>& old) { old = strokes; });
}

LayerChange grown(std::size_t entry, const SessionStroke& stroke) {
  return [entry, stroke](Layers& layers) {
    if (entry >= layers.size()) return layers.push_back({stroke});
    SessionStroke& old = layers[entry].front();
    old.stroke = stroke.stroke;
    old.remesh = stroke.remesh;
  };
}

void select(LayerEditor& editor, const DocumentState& shown, std::optional<std::size_t> entry) {
  editor = {};
  if (!entry || *entry >= shown.history.size()) return;
  editor.entry = entry;
  editor.source = shown.history[*entry];
  editor.entries = shown.history.size();
  set_strokes(editor, editor.source->strokes);
}

void follow(LayerEditor& editor, const DocumentState& shown) {
  if (!editor.entry) return;
  const auto& history = shown.history;
  if (*editor.entry < history.size() && history[*editor.entry] == editor.source) return;
  const auto is_it = [&](const auto& entry) {
    return entry == editor.source || entry->strokes == editor.source->strokes;
  };
  const bool is_as_long = history.size() == editor.entries;
  editor.entries = history.size();
  if (*editor.entry < history.size() && is_it(history[*editor.entry])) {
    editor.source = history[*editor.entry];
    return;
  }
  const auto found = std::find_if(history.begin(), history.end(), is_it);
  if (found != history.end()) return select(editor, shown, static_cast<std::size_t>(found - history.begin()));
  select(editor, shown, is_as_long ? editor.entry : std::nullopt);
}

void set_strokes(LayerEditor& editor, std::vector<SessionStroke> strokes) {
  editor.strokes = std::move(strokes);
  editor.paths = paths_of(editor.strokes);
  editor.text = lines_of(editor.strokes);
  editor.problem.clear();
}

void set_text(LayerEditor& editor, std::string text) {
  editor.text = std::move(text);
  try {
    editor.strokes =
        strokes_of_lines(editor.text, editor.source ? editor.source->strokes.front().remesh : std::nullopt);
    editor.paths = paths_of(editor.strokes);
    editor.problem.clear();
  } catch (const InvalidInput& error) {
    editor.problem = error.what();
  }
}

std::vector<LayerPath> paths_of(std::span<const SessionStroke> strokes) {
  std::vector<SessionStroke> own(strokes.begin(), strokes.end());
  without_beyond(own);
  std::vector<LayerPath> paths;
  for (OwnedPath& path : owned_paths(own)) {
    std::vector<std::size_t> handles = handles_of(path.points.size());
    paths.push_back({std::move(path.points), std::move(handles)});
  }
  return paths;
}

std::optional<LayerHandle> handle_at(const Screen& screen, std::span<const LayerPath> paths, double x, double y) {
  std::optional<LayerHandle> nearest;
  double least = kReach * screen.unit;
  for (std::size_t path = 0; path < paths.size(); ++path) {
    for (std::size_t handle = 0; handle < paths[path].handles.size(); ++handle) {
      const auto pixel = pixel_of(screen, place_of(paths, {path, handle}));
      const double distance = pixel ? std::hypot(pixel->x - x, pixel->y - y) : least;
      if (distance >= least) continue;
      least = distance;
      nearest = LayerHandle{path, handle};
    }
  }
  return nearest;
}

Vec3d place_of(std::span<const LayerPath> paths, const LayerHandle& handle) {
  const LayerPath& path = paths[handle.path];
  return path.points[path.handles[handle.handle]];
}

std::vector<SessionStroke> with_handle_moved(std::vector<SessionStroke> strokes, const LayerHandle& handle,
                                             const Vec3d& by) {
  const double strength = without_beyond(strokes);
  const std::vector<OwnedPath> paths = owned_paths(strokes);
  if (handle.path >= paths.size()) return strokes;
  const OwnedPath& path = paths[handle.path];
  const LayerPath shown{path.points, handles_of(path.points.size())};
  if (handle.handle >= shown.handles.size()) return strokes;
  const std::vector<double> weights = weights_of(shown, handle.handle);
  move(path, weights, by);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto planes = i == handle.path ? std::nullopt : planes_between(path, paths[i]);
    if (planes) move(paths[i], weights, mirrored_in(by, *planes));
  }
  if (strength > 1) set_strength(strokes, strength);
  return strokes;
}

std::vector<StrokeField> fields_of(std::span<const SessionStroke> strokes) {
  std::vector<StrokeField> fields;
  for (const SessionStroke& one : strokes) {
    Stroke stroke = one.stroke;
    const bool is_wide = find_value<double>(stroke, "bump") != nullptr;
    visit_fields(stroke, [&](std::string_view name, std::string_view help, double& value) {
      const bool known =
          std::any_of(fields.begin(), fields.end(), [&](const auto& field) { return field.name == name; });
      const bool is_automatic = is_wide && name == "outer" && value == 0;
      if (known || is_automatic) return;
      std::string label = word_for_key(std::string(name));
      if (is_wide && (name == "bump" || name == "outer")) label = name == "bump" ? "radius" : "reach";
      fields.push_back({std::string(name), std::move(label), std::string(help), value});
    });
  }
  return fields;
}

void set_field(std::span<SessionStroke> strokes, const std::string& name, double value) {
  bool is_first = true;
  double factor = 1;
  for (SessionStroke& one : strokes) {
    visit_fields(one.stroke, [&](std::string_view own_name, std::string_view /*help*/, double& own) {
      if (own_name != name) return;
      if (is_first) factor = own == 0 ? 1 : value / own;
      own = is_first ? value : own * factor;
      is_first = false;
    });
  }
}

std::optional<int> falloff_of(std::span<const SessionStroke> strokes) {
  for (const SessionStroke& one : strokes) {
    if (const std::optional<int> falloff = falloff_of(one.stroke)) return falloff;
  }
  return std::nullopt;
}

void set_falloff(std::span<SessionStroke> strokes, int falloff) {
  for (SessionStroke& one : strokes) set_falloff(one.stroke, falloff);
}

}  // namespace knead::studio
