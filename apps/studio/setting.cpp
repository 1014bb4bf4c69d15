// The rows of all settings; and how the value of a row becomes JSON, comes from it, and goes on to the next one.
#include "setting.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <tuple>

#include "gestures/tools.h"
#include "knead/error.h"
#include "preferences.h"
#include "studio_view.h"

namespace knead::studio {

namespace {

template <class E>
WordChoice choice_of(E& value, std::vector<std::string_view> words, std::vector<const char*> titles = {}) {
  return {std::move(words), static_cast<std::size_t>(value),
          [&value](std::size_t chosen) { value = static_cast<E>(chosen); }, std::move(titles)};
}

// `parse` returns the value that JSON stands for, or nothing.
template <class T, class Parse>
OwnForm own_form(std::string_view expected, T& value, Json now, const Parse& parse) {
  return {expected, std::move(now), [&value, parse](const Json& json) {
            const auto found = parse(json);
            if (found) value = *found;
            return found.has_value();
          }};
}

std::optional<std::vector<double>> numbers_from(const Json& json, std::size_t count) {
  if (!json.is_array() || json.items().size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& item : json.items()) {
    if (!item.is_number()) return std::nullopt;
    numbers.push_back(item.number());
  }
  return numbers;
}

std::optional<Vec3d> place_from(const Json& json) {
  const auto found = numbers_from(json, 3);
  return found ? std::optional(Vec3d{(*found)[0], (*found)[1], (*found)[2]}) : std::nullopt;
}

std::optional<Vec3d> direction_from(const Json& json) {
  const std::optional<Vec3d> found = place_from(json);
  return found && norm(*found) > 0 ? found : std::nullopt;
}

Json json_of(const Vec3d& v) { return std::vector<double>{v.x, v.y, v.z}; }

OwnForm place_form(Vec3d& value) { return own_form("three numbers [x, y, z]", value, json_of(value), place_from); }

OwnForm direction_form(Vec3d& value) {
  return own_form("a direction [x, y, z]", value, json_of(value), direction_from);
}

OwnForm degrees_form(double& radians) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  return own_form("a number of degrees", radians, radians * kDegrees, [](const Json& json) {
    return json.is_number() ? std::optional(json.number() / kDegrees) : std::nullopt;
  });
}

OwnForm flags_form(std::array<bool, 3>& value) {
  return own_form(
      "three of true and false", value, std::vector<Json>(value.begin(), value.end()), [](const Json& json) {
        using Flags = std::array<bool, 3>;
        const bool is_good =
            json.is_array() && json.items().size() == 3 &&
            std::all_of(json.items().begin(), json.items().end(), [](const Json& j) { return j.is_flag(); });
        if (!is_good) return std::optional<Flags>();
        return std::optional(Flags{json.items()[0].flag(), json.items()[1].flag(), json.items()[2].flag()});
      });
}

OwnForm color_form(render::Color& value) {
  return own_form("a colour such as \"#0073b3\"", value, text_of(value),
                  [](const Json& json) { return render::color_from(json.is_text() ? json.text() : ""); });
}

OwnForm background_form(std::string& name) {
  return own_form("gradient, light, dark or #rrggbb", name, name, [](const Json& json) {
    const bool is_known = json.is_text() && render::background_named(json.text());
    return is_known ? std::optional(json.text()) : std::nullopt;
  });
}

OwnForm text_form(std::string& value) {
  return own_form("a text", value, value,
                  [](const Json& json) { return json.is_text() ? std::optional(json.text()) : std::nullopt; });
}

OwnForm texts_form(std::vector<std::string>& list) {
  return own_form("a list of texts", list, list, [](const Json& json) {
    std::vector<std::string> found;
    if (!json.is_array()) return std::optional<std::vector<std::string>>();
    for (const Json& item : json.items()) {
      if (item.is_text()) found.push_back(item.text());
    }
    return std::optional(std::move(found));
  });
}

OwnForm plane_form(std::optional<Symmetry::Plane>& plane) {
  Json now;
  if (plane) now = {{"point", json_of(plane->point)}, {"normal", json_of(plane->normal)}};
  return {"null, or {\"point\": [x, y, z], \"normal\": [x, y, z]}", now, [&plane](const Json& json) {
            const Json* const point = json.find("point");
            const Json* const normal = json.find("normal");
            const auto place = point != nullptr ? place_from(*point) : std::nullopt;
            const auto direction = normal != nullptr ? direction_from(*normal) : std::nullopt;
            if (!json.is_null() && !(place && direction)) return false;
            plane.reset();
            if (place) plane = {*place, normalized(*direction)};
            return true;
          }};
}

OwnForm shift_form(View& view) {
  return {"[across, up], each from -1 to 1", std::vector<double>{view.shift_x, view.shift_y},
          [&view](const Json& json) {
            const auto found = numbers_from(json, 2);
            if (found) std::tie(view.shift_x, view.shift_y) = std::pair((*found)[0], (*found)[1]);
            return found.has_value();
          }};
}

Setting projection_row(render::Projection& projection) {
  return {"projection", choice_of(projection, {"orthographic", "perspective"})};
}

Setting field_row(double& degrees) {
  return {"field_of_view_deg",
          &degrees,
          {kSmallestFieldDeg, kLargestFieldDeg, true},
          "Field of view",
          "degrees from bottom to top"};
}

std::vector<Setting> look_rows(Look& look) {
  std::vector<std::string_view> matcaps;
  for (const render::Matcap matcap : render::all_matcaps()) matcaps.push_back(name_of(matcap));
  return {{"shading", choice_of(look.material, {"clay", "matcap", "flat"}, {"Clay", "Matcap", "Flat"}), {}, "Shading"},
          {"matcap", choice_of(look.matcap, std::move(matcaps))},
          {"cavity", &look.relief.cavity, {}, "Cavity", "darkens grooves and brightens ridges"},
          {"occlusion", &look.relief.occlusion, {}, "Occlusion", "darkens folds and corners"},
          {"background", background_form(look.background)}};
}

struct JsonOf {
  Json operator()(const WordChoice& choice) const { return choice.words[choice.chosen]; }
  Json operator()(const OwnForm& form) const { return form.value; }
  template <class T>
  Json operator()(const T* value) const {
    return *value;
  }
};

struct Set {
  const Setting& setting;
  const Json& json;

  [[noreturn]] void refuse(const std::string& expected) const {
    throw InvalidInput(fmt::format("\"{}\" must be {}, got {}", setting.key, expected, to_text(json)));
  }
  double number() const {
    const auto& [least, most, is_strict] = setting.range;
    const double found = json.is_number() ? json.number() : std::numeric_limits<double>::quiet_NaN();
    const bool is_good =
        is_strict ? found >= least && found <= most : std::isfinite(found) && (found > 0 || !(least > 0));
    if (is_good) return found;
    refuse(is_strict   ? fmt::format("a number from {} to {}", least, most)
           : least > 0 ? "a number above 0"
                       : "a number");
  }
  void operator()(bool* flag) const {
    if (!json.is_flag()) refuse("true or false");
    *flag = json.flag();
  }
  void operator()(double* value) const { *value = number(); }
  void operator()(int* value) const {
    constexpr double greatest = std::numeric_limits<int>::max();
    const double most = std::min(setting.range.most, greatest);
    *value = static_cast<int>(std::clamp(number(), std::max(setting.range.least, -greatest), most));
  }
  void operator()(std::optional<double>* value) const {
    *value = json.is_null() ? std::nullopt : std::optional(number());
  }
  void operator()(const WordChoice& choice) const {
    const auto found = std::find(choice.words.begin(), choice.words.end(), json.is_text() ? json.text() : "?");
    if (found == choice.words.end()) refuse(fmt::format("\"{}\"", fmt::join(choice.words, "\" or \"")));
    choice.choose(static_cast<std::size_t>(found - choice.words.begin()));
  }
  void operator()(const OwnForm& form) const {
    if (!form.read(json)) refuse(std::string(form.expected));
  }
};

void append(std::vector<Setting> more, std::vector<Setting>& rows) {
  std::move(more.begin(), more.end(), std::back_inserter(rows));
}

constexpr const char* kLatticeHelp = "another number lays a new lattice about the shape as it is";

std::vector<Setting> whole_shape_rows(ToolSettings& to) {
  return {
      {"bend_length",
       choice_of(to.bend_length, {"keep", "fit"}, {"Keep length", "Reach both ends"}),
       {},
       "##length",
       "Keep length: the shape lies on a part of the new line, or goes straight on beyond it. Reach both ends: it is "
       "stretched to the line's ends, and grows thinner or thicker."},
      {"bend_keep",
       choice_of(to.bend_keep, {"volume", "thickness"}, {"Volume", "Thickness"}),
       {},
       "Keep",
       "Volume: the inner side of a bend grows thicker, the outer side thinner. Thickness: walls and reliefs keep "
       "their height, and bends may be twice as tight."},
      {"lattice_mode",
       choice_of(to.lattice_mode, {"volume", "rigid", "spline"}, {"Keep volume", "Near rigid", "Plain"}),
       {},
       "##lattice",
       "Keep volume: the shape comes as near as it can without a change of its volume. Near rigid: it also strains as "
       "little as it can. Plain: exactly as the control points have it; volume changes."},
      {"lattice_x", &to.lattice_counts[0], {2, kMaxLatticePoints}, "Points in x", kLatticeHelp},
      {"lattice_y", &to.lattice_counts[1], {2, kMaxLatticePoints}, "Points in y", kLatticeHelp},
      {"lattice_z", &to.lattice_counts[2], {2, kMaxLatticePoints}, "Points in z", kLatticeHelp},
  };
}

std::vector<Setting> brush_rows(ToolSettings& to) {
  return {
      {"radius", &to.radius, kAboveZero},
      {"auto_radius", &to.auto_radius},
      {"inner_ratio",
       &to.inner_ratio,
       {0.01, 0.95, true},
       "Inner ratio",
       "which part of the radius moves rigidly (Shift+F)"},
      {"falloff",
       &to.falloff,
       {kMinFalloff, kGreatestFalloff},
       "Falloff",
       "how the motion fades: 3 takes more of the surroundings along, 7 stays near"},
      {"depth",
       &to.depth,
       {0.005, to.tool->use == ToolUse::inflate ? kMaxInflateDepth : 1},
       "Depth",
       "how far a dab or line moves the surface; it grows with the radius"},
      {"pinch",
       &to.pinch,
       {0.02, 2},
       "Strength",
       "how much one layer of paint draws the surface together, or flattens it"},
      {"smoothing", &to.smoothing, {0.02, 1}, "Strength", "how much of a bump one touch removes"},
      {"capsule_length",
       &to.capsule_length,
       {0.05, 5},
       "Length",
       "half the length of the capsule; it grows with the radius"},
      {"stamp_size", &to.stamp_size, {0.05, 3}, "Size", "half the extent of the stamp; it grows with the radius"},
      {"contact",
       choice_of(to.stamp_contact, {"auto", "stick", "slip"}, {"Print", "Carry along", "Groove"}),
       {},
       "Leaves",
       "Print: pressed in, the stamp leaves a flat floor and upright walls. Groove: a round stamp is dragged along and "
       "leaves a groove. Carry along: the surface goes with the stamp."},
      {"text", text_form(to.text)},
      {"font", text_form(to.font)},
      {"exponent", &to.exponent},
      {"drag",
       choice_of(to.drag, {"view", "surface", "normal", "axis"},
                 {"In the view plane", "Along the surface", "Along the normal", "Along an axis"}),
       {},
       "##drag",
       "where a drag takes the tool (D)"},
      {"axis", direction_form(to.axis)},
      {"start",
       choice_of(to.start, {"inside", "surface", "plane"}, {"Round end", "Flat end", "From the view's middle plane"}),
       {},
       "Start",
       "Round end: begins under the surface. Flat end: begins on it, and lifts a disc. The third begins in the plane "
       "through the middle of the view."},
      {"paint_in", &to.paint_in, {}, to.tool->use == ToolUse::inflate ? "Shrink" : "Press in"},
  };
}

std::vector<Setting> pose_and_mask_rows(ToolSettings& to) {
  return {
      {"pose",
       choice_of(to.pose, {"pins", "lasso", "brush", "exact"}, {"Pins", "Lasso", "Brush", "Exact points"}),
       {},
       "##pose",
       "Pins: click to set a pin, drag it or a part. Lasso, Brush: choose a part, which holds, and moves by its gizmo. "
       "Exact points: each pin goes to its place alone, with what is within its radius."},
      {"detail", &to.pose_detail, {0, 0.5, true}},
      {"lasso_selects",
       &to.lasso_selects,
       {},
       "Select pins by a line",
       "Draw a line round pins to select them (Shift+click selects one). Selected pins move together."},
      {"mask_mode",
       choice_of(to.mask_mode, {"paint", "lasso", "box"}, {"Paint", "Lasso", "Box"}),
       {},
       "##mask",
       "paint what stays, or draw a line or a box round it"},
      {"mask_width", &to.mask_width, {0.05, 2}, "Border", "from what stays to what is free; it grows with the radius"},
      {"limit_cylinder",
       &to.uses_limit_cylinder,
       {},
       "Automatic limb",
       "Moves only the finger, arm or leg that was clicked: what lies in the grey limit cylinder. Off: everything."},
      {"widens_zone",
       &to.widens_zone,
       {},
       "Widen a zone that is too thin",
       "A strong bend or twist over a short zone crushes the shape. The zone grows with the angle."},
  };
}

std::vector<Setting> symmetry_rows(ToolSettings& to) {
  return {
      {"mirror", flags_form(to.mirror)},
      {"mirror_plane", plane_form(to.symmetry.plane)},
      {"symmetry_center", place_form(to.symmetry.center)},
      {"radial", &to.symmetry.turns, {1, kMaxTurns}, "Radial", "repeats everything about an axis"},
      {"radial_axis", direction_form(to.symmetry.axis)},
  };
}

}  // namespace

std::vector<Setting> settings_of(ToolSettings& to) {
  std::vector<Setting> rows = brush_rows(to);
  append(whole_shape_rows(to), rows);
  append(pose_and_mask_rows(to), rows);
  append(symmetry_rows(to), rows);
  append({{"remesh", &to.remesh, {}, "Remesh when a drag ends"},
          {"max_edge", &to.remesh_settings.max_edge, {1e-9, 1e9}, "Resolution"}},
         rows);
  return rows;
}

std::vector<Setting> settings_of(View& view) {
  return {{"yaw_deg", degrees_form(view.yaw)}, {"pitch_deg", degrees_form(view.pitch)},
          {"target", place_form(view.target)}, {"height", &view.height, kAboveZero},
          {"shift", shift_form(view)},         projection_row(view.projection),
          field_row(view.field_of_view_deg)};
}

std::vector<Setting> settings_of(ViewSettings& view) {
  std::vector<Setting> rows = look_rows(view.look);
  std::vector<Setting> own{
      {"wireframe", &view.wireframe, {}, "Wireframe"},
      {"references", &view.references, {}, "Show"},
      {"influence", &view.influence, {}, "Influence"},
      {"tool", &view.tool, {}, "Tool"},
      {"region",
       &view.region,
       {},
       "Region at the cursor",
       "shows the inner and outer region of the tool as translucent surfaces (B)"},
      {"cut", &view.cut, {}, "Cutting plane"},
      {"cut_normal", direction_form(view.cut_normal)},
      {"cut_offset", &view.cut_offset},
      {"stretch",
       choice_of(view.stretch, {"off", "since_start", "last_stroke"}, {"Off", "Since the start", "By the last stroke"}),
       {},
       "Stretch",
       "colours the shape by how far its triangles are stretched"},
      {"panels", &view.panels},
      {"tool_labels", &view.tool_labels},
      {"help", &view.help},
      {"history", &view.history},
      {"statistics", &view.statistics}};
  std::move(own.begin(), own.end(), std::back_inserter(rows));
  return rows;
}

std::vector<Setting> settings_of(Preferences& to) {
  std::vector<Setting> rows{{"navigation", choice_of(to.navigation, {"blender", "maya"})},
                            {"up", choice_of(to.up, {"y", "z"})},
                            {"backend", choice_of(to.backend, {"cpu", "gpu"})},
                            {"unit", choice_of(to.unit, {"", "mm", "cm", "m"})},
                            {"pen_pressure", choice_of(to.pressure, {"none", "radius", "depth"})},
                            {"outer_ring", color_form(to.outer_ring)},
                            {"inner_ring", color_form(to.inner_ring)},
                            {"welcome", &to.welcome},
                            {"desktop_dialogs", &to.desktop_dialogs},
                            {"interface_scale", &to.interface_scale, {0.5, 3, true}},
                            {"undo_memory_mb", &to.undo_memory_mb, {0, 1e6, true}},
                            projection_row(to.look.projection),
                            field_row(to.look.field_of_view_deg)};
  std::vector<Setting> look = look_rows(to.look);
  std::move(look.begin(), look.end(), std::back_inserter(rows));
  return rows;
}

std::vector<Setting> settings_of(PanelState& panels) {
  return {{"shown", &panels.shown},
          {"history", &panels.history},
          {"labels", &panels.labels},
          {"width", &panels.width, kAboveZero},
          {"closed", texts_form(panels.closed)}};
}

std::vector<Setting> settings_of(WindowPlace& window) {
  constexpr Range points{320, 20000, true};
  return {{"width", &window.width, points}, {"height", &window.height, points}, {"maximized", &window.maximized}};
}

const Setting* find_setting(std::span<const Setting> settings, std::string_view key) {
  const auto found =
      std::find_if(settings.begin(), settings.end(), [&](const Setting& each) { return each.key == key; });
  return found == settings.end() ? nullptr : &*found;
}

Json json_of(const Setting& setting) { return std::visit(JsonOf{}, setting.value); }

Json json_of(std::span<const Setting> settings, std::span<const Setting> defaults) {
  Json object = Json::object();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const Json value = json_of(settings[i]);
    if (defaults.empty() || to_text(value) != to_text(json_of(defaults[i]))) object.set(settings[i].key, value);
  }
  return object;
}

bool step(const Setting* setting) {
  if (setting == nullptr) return false;
  if (bool* const* flag = std::get_if<bool*>(&setting->value)) {
    **flag = !**flag;
    return true;
  }
  const auto* const choice = std::get_if<WordChoice>(&setting->value);
  if (choice != nullptr) choice->choose((choice->chosen + 1) % choice->words.size());
  return choice != nullptr;
}

void set(const Setting& setting, const Json& value) { std::visit(Set{setting, value}, setting.value); }

}  // namespace knead::studio
