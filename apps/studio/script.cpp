// Scripts: the lines that drive Studio, and what each does.
#include "script.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "gestures/gesture_kinds.h"
#include "json/json.h"
#include "knead/error.h"
#include "knead/io.h"
#include "setting.h"

namespace knead::studio {

namespace {

[[noreturn]] void fail(const std::string& what) { throw InvalidInput(what); }

Json member_or(const Json& object, std::string_view key, const Json& otherwise) {
  const Json* found = object.find(key);
  return found != nullptr ? *found : otherwise;
}

// The index of a word among the choices.
std::size_t choice(const Json& value, std::initializer_list<std::string_view> choices) {
  const auto found = std::find(choices.begin(), choices.end(), value.text());
  if (found == choices.end()) fail(fmt::format("'{}' is not one of {}", value.text(), fmt::join(choices, ", ")));
  return static_cast<std::size_t>(found - choices.begin());
}

Vec3d vector_of(const Json& value) {
  const std::vector<Json>& numbers = value.items();
  if (numbers.size() != 3) fail(fmt::format("three numbers [x, y, z] are needed, not {}", to_text(value)));
  return {numbers[0].number(), numbers[1].number(), numbers[2].number()};
}

Modifiers modifiers_of(const Json& line) {
  Modifiers result;
  const Json names = member_or(line, "modifiers", Json::array());
  for (const Json& each : names.items()) {
    const std::size_t which = choice(each, {"shift", "ctrl", "alt"});
    (which == 0 ? result.shift : which == 1 ? result.ctrl : result.alt) = true;
  }
  return result;
}

const StudioTool& tool_named(const std::string& name) {
  const StudioTool* const tool = studio_tool(name);
  if (tool == nullptr) fail(fmt::format("there is no tool '{}'", name));
  return *tool;
}

class Script {
 public:
  Script(Studio& studio, const ScriptHost& host) : studio_(studio), host_(host) {}

  void run(const Json& line) {
    if (!line.is_object() || line.members().empty()) fail("a line is a JSON object such as {\"key\": \"Ctrl+Z\"}");
    studio_.refresh();
    if (!pointer(line) && !settings(line) && !files(line) && !pauses(line)) {
      fail(fmt::format("no command has the keys of {}", to_text(line)));
    }
  }

 private:
  void send(const Event& event) {
    studio_.handle(event);
    if (host_.after_event) host_.after_event();
  }

  Pixel place_of(const Json& value) const {
    const std::vector<Json>& numbers = value.items();
    if (numbers.size() == 2) return {numbers[0].number(), numbers[1].number()};
    const auto pixel = pixel_of(studio_.view().screen(), vector_of(value));
    if (!pixel) fail("the place is behind the camera");
    return *pixel;
  }

  void move_to(const Pixel& p, const Modifiers& modifiers, double pressure = 1) {
    send(PointerMoved{p.x, p.y, pressure, modifiers});
  }

  // Of a pen, at each place of a drag.
  static std::vector<double> pressures_of(const Json& line, std::size_t places) {
    std::vector<double> pressures(places, 1.0);
    if (!line.has("pressure")) return pressures;
    const std::vector<Json>& given = line.at("pressure").items();
    if (given.size() != places) fail("\"pressure\" has a number for each place of the drag");
    for (std::size_t i = 0; i < places; ++i) pressures[i] = given[i].number();
    return pressures;
  }

  void drag(const Json& line) {
    const Modifiers modifiers = modifiers_of(line);
    const MouseButton button = button_of(line);
    const int steps = static_cast<int>(member_or(line, "steps", 10).number());
    std::vector<Pixel> places;
    for (const Json& place : line.at("drag").items()) places.push_back(place_of(place));
    if (places.size() < 2) fail("a drag goes through two places or more");
    const std::vector<double> pressures = pressures_of(line, places.size());
    move_to(places.front(), modifiers, pressures.front());
    send(ButtonChanged{button, true, places.front().x, places.front().y, modifiers});
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      for (int k = 1; k <= steps; ++k) {
        const double t = static_cast<double>(k) / steps;
        move_to({places[i].x + (places[i + 1].x - places[i].x) * t, places[i].y + (places[i + 1].y - places[i].y) * t},
                modifiers, pressures[i] + (pressures[i + 1] - pressures[i]) * t);
        if (line.has("pause")) pause(line.at("pause").number());
      }
    }
    send(ButtonChanged{button, false, places.back().x, places.back().y, modifiers});
  }

  static MouseButton button_of(const Json& line) {
    return static_cast<MouseButton>(choice(member_or(line, "button", "left"), {"left", "middle", "right"}));
  }

  void press(const Json& place, const Json& line, bool down, bool is_double = false) {
    const Pixel p = place_of(place);
    send(ButtonChanged{button_of(line), down, p.x, p.y, modifiers_of(line), is_double});
  }

  void click(const Json& place, const Json& line, bool is_double = false) {
    move_to(place_of(place), modifiers_of(line));
    press(place, line, true, is_double);
    press(place, line, false);
  }

  bool pointer(const Json& line) {
    if (line.has("drag")) {
      drag(line);
    } else if (line.has("move")) {
      move_to(place_of(line.at("move")), modifiers_of(line), member_or(line, "pressure", 1.0).number());
    } else if (line.has("press")) {
      press(line.at("press"), line, true);
    } else if (line.has("release")) {
      press(line.at("release"), line, false);
    } else if (line.has("click")) {
      click(line.at("click"), line);
    } else if (line.has("double_click")) {
      click(line.at("double_click"), line);
      click(line.at("double_click"), line, true);
    } else if (line.has("wheel")) {
      send(WheelTurned{line.at("wheel").number(), modifiers_of(line)});
    } else if (line.has("key")) {
      const std::optional<Chord> chord = chord_of(line.at("key").text());
      if (!chord) fail(fmt::format("there is no key {}", to_text(line.at("key"))));
      send(KeyChanged{chord->key, true, chord->modifiers});
      send(KeyChanged{chord->key, false, chord->modifiers});
    } else if (line.has("drop")) {
      std::vector<std::filesystem::path> paths;
      for (const Json& file : line.at("drop").items()) paths.emplace_back(file.text());
      send(FilesDropped{paths});
    } else if (line.has("size")) {
      const std::vector<Json>& size = line.at("size").items();
      if (size.size() != 2) fail("a size is two numbers [width, height]");
      send(Resized{static_cast<int>(size[0].number()), static_cast<int>(size[1].number())});
    } else {
      return false;
    }
    return true;
  }

  bool settings(const Json& line) {
    if (line.has("tool")) {
      choose_tool(line.at("tool").text());
    } else if (line.has("pins")) {
      set_pins(line);
    } else if (line.has("parts")) {
      set_parts(line);
    } else if (line.has("set")) {
      set_tools(line.at("set"));
    } else if (line.has("view")) {
      set_view(line.at("view"));
    } else if (line.has("show")) {
      show(line.at("show"));
    } else if (line.has("mask")) {
      const std::optional<MaskEdit> edit = mask_edit(line.at("mask").text());
      if (!edit) fail("a mask is changed by fill, clear, invert, blur, grow or shrink");
      studio_.change_mask(*edit);
      if (host_.after_event) host_.after_event();
    } else if (line.has("stamp")) {
      const std::string& name = line.at("stamp").text();
      const auto names = shape_names();
      const bool is_known = std::find(names.begin(), names.end(), name) != names.end();
      is_known ? studio_.tools().use_stamp(shape_kind(name)) : studio_.tools().use_stamp(std::filesystem::path(name));
      settle();
    } else {
      return false;
    }
    return true;
  }

  void choose_tool(const std::string& name) {
    const bool is_pins = name == "pins";  // a tool of its own before pose came
    studio_.perform(action_of(is_pins ? studio_tool(ToolUse::pose) : tool_named(name)));
    if (is_pins) studio_.tools().settings().pose = PoseMode::exact;
  }

  void set_pins(const Json& line) {
    const ShapeState& state = studio_.document().shown().state;
    if (state.mesh == nullptr) fail("there is no shape to set pins on");
    const bool knows_vertices = line.has("of") && line.at("of").whole() == state.positions.size();
    std::vector<Pin> pins;
    for (const Json& one : line.at("pins").items()) {
      Pin pin{vector_of(one.at("place")), member_or(one, "holds", true).flag()};
      if (knows_vertices && one.has("vertex") && one.at("vertex").whole() < state.positions.size()) {
        pin.vertices.push_back({state.mesh, static_cast<std::uint32_t>(one.at("vertex").whole())});
      }
      pins.push_back(std::move(pin));
    }
    studio_.tools().set_pins(std::move(pins));
  }

  // A shape with other vertices gets none.
  void set_parts(const Json& line) {
    const ShapeState& state = studio_.document().shown().state;
    if (state.mesh == nullptr) fail("there is no shape to make parts of");
    PartMarks parts;
    if (line.at("of").whole() != state.positions.size()) return;
    for (const Json& one : line.at("parts").items()) {
      std::vector<std::uint32_t> vertices;
      for (const Json& range : one.at("vertices").items()) {
        const std::size_t last = range.items().at(1).whole();
        if (last >= state.positions.size()) fail("a part has a vertex that the shape has not");
        for (std::size_t v = range.items().at(0).whole(); v <= last; ++v) {
          vertices.push_back(static_cast<std::uint32_t>(v));
        }
      }
      const std::optional<std::size_t> part = add_part(vertices, state, parts);
      if (!part) continue;
      parts.holds[*part] = member_or(one, "holds", true).flag();
      parts.stiffness[*part] = std::clamp(one.has("stiffness") ? one.at("stiffness").number() : 1.0, 0.01, 100.0);
    }
    select_part(std::nullopt, parts);
    studio_.tools().placed().parts = std::move(parts);
  }

  // Gives settings the values of an object, whose keys may be names of earlier versions.
  static void set_all(const std::vector<Setting>& settings, const Json& values) {
    for (const auto& [key, value] : values.members()) {
      const bool is_cylinder = key == "barrel" || key == "whole_limb";
      const Setting* const setting = find_setting(settings, is_cylinder         ? "limit_cylinder"
                                                            : key == "material" ? "shading"
                                                                                : std::string_view(key));
      if (setting == nullptr) fail(fmt::format("there is no setting '{}'", key));
      set(*setting, value);
    }
  }

  void set_tools(const Json& values) {
    ToolSettings& to = studio_.tools().settings();
    Json known = Json::object();
    for (const auto& [key, value] : values.members()) {
      if (key == "on_surface") to.start = value.flag() ? PullStart::surface : PullStart::plane;
      const bool is_old = key == "on_surface" || key == "handle";  // until version 0.9; of a tool that is gone
      if (!is_old) known.set(key, value);
    }
    set_all(settings_of(to), known);
  }

  void set_view(const Json& values) {
    set_all(settings_of(studio_.view().navigation().view), values);
    if (values.has("target")) studio_.view().navigation().home.reset();
  }

  void show(const Json& values) {
    set_all(settings_of(studio_.view().settings()), values);
    if (values.has("matcap")) studio_.view().settings().look.material = render::Material::matcap;
  }

  void change_layer(const Json& line) {
    if (line.at("layer").is_null()) return studio_.history().select(std::nullopt);
    const std::size_t entry = line.at("layer").whole();
    if (entry >= studio_.document().shown().history.size()) fail(fmt::format("the history has no entry {}", entry));
    if (line.has("name")) studio_.history().change(renamed(entry, line.at("name").text()));
    if (line.has("off")) studio_.history().change(switched(entry, line.at("off").flag()));
    if (line.has("strength")) studio_.history().change(with_strength(entry, line.at("strength").number()));
    if (line.has("drag_strength")) drag_strength(entry, line.at("drag_strength"));
    if (line.has("move_to")) studio_.history().change(moved(entry, line.at("move_to").whole()));
    if (line.has("join")) studio_.history().change(joined(entry));
    if (line.has("split")) studio_.history().change(split(entry));
    if (line.has("remove")) studio_.history().change(removed(entry));
    if (line.has("select")) studio_.history().select(entry);
  }

  // As a slider does it, which goes through these values.
  void drag_strength(std::size_t entry, const Json& values) {
    for (const Json& value : values.items()) studio_.history().drag(with_strength(entry, value.number()));
    studio_.history().end_drag(true);
  }

  void add_reference(const Json& line) {
    if (line.at("reference").is_null()) return studio_.view().references().clear();
    if (!studio_.view().add_reference(line.at("reference").text())) return;
    Reference& reference = studio_.view().references().back();
    if (line.has("plane")) {
      reference.plane = static_cast<ReferencePlane>(choice(line.at("plane"), {"front", "right", "top"}));
    }
    reference.opacity = member_or(line, "opacity", reference.opacity).number();
    reference.height = member_or(line, "height", reference.height).number();
    if (!(reference.height > 0)) fail("the height of a reference is above 0");
    if (line.has("center")) reference.center = vector_of(line.at("center"));
    reference.in_every_view = member_or(line, "every_view", false).flag();
  }

  void write_poster(const Json& line) {
    require_shape("draw");
    Poster poster;
    const auto read = [&](const char* key, int& value) {
      if (line.has(key)) value = static_cast<int>(line.at(key).whole());
    };
    read("width", poster.width);
    read("height", poster.height);
    read("pictures", poster.pictures);
    if (poster.pictures < 1) fail("a poster has 1 picture or more");
    poster.is_transparent = member_or(line, "transparent", poster.is_transparent).flag();
    poster.has_ground = member_or(line, "ground", poster.has_ground).flag();
    studio_.view().write_poster(line.at("poster").text(), poster);
    settle();
  }

  void fit(const Json& line) {
    require_shape("fit");
    StudioFit& fit = studio_.fit();
    fit.open(line.at("fit").text(), studio_.view().navigation());
    settle();
    if (!fit.is_open()) return;
    std::vector<ClickedPair> pairs;
    if (line.has("pairs")) {
      for (const Json& pair : line.at("pairs").items()) {
        const std::vector<Json>& both = pair.items();
        if (both.size() != 2) fail("a pair is two vertices, as [3, 17]");
        pairs.push_back({static_cast<std::uint32_t>(both[0].whole()), static_cast<std::uint32_t>(both[1].whole())});
      }
    }
    if (!fit.set_pairs(std::move(pairs))) fail("a pair names a vertex that a shape does not have");
    fit.settings().surface = member_or(line, "surface", fit.settings().surface).flag();
    fit.settings().grows = member_or(line, "grows", fit.settings().grows).flag();
    if (member_or(line, "run", true).flag()) fit.run();
    settle();
  }

  void require_shape(const char* what) {
    settle();
    if (studio_.document().shown().opened != 0) return;
    fail(fmt::format("there is no shape to {}; open one before, or make one: {{\"new\": \"sphere\"}}", what));
  }

  void change_object(const Json& line) {
    if (line.at("object").is_null()) return studio_.document().make_active(std::nullopt);
    const std::size_t object = line.at("object").whole();
    if (object >= studio_.document().shown().objects.list.size()) fail(fmt::format("there is no object {}", object));
    if (line.has("visible")) studio_.document().show_object(object, line.at("visible").flag());
    if (member_or(line, "active", false).flag()) studio_.document().make_active(object);
    if (member_or(line, "remove", false).flag()) studio_.remove_object(object);
  }

  bool files(const Json& line) {
    const auto path = [&](const char* key) { return std::filesystem::path(line.at(key).text()); };
    if (line.has("open")) {
      studio_.document().open(path("open"));
      settle();
    } else if (line.has("add")) {
      studio_.add_shape(path("add"));
      settle();
    } else if (line.has("object")) {
      change_object(line);
      settle();
    } else if (line.has("new")) {
      studio_.document().open_made(shape_kind(line.at("new").text()), member_or(line, "vertices", 0U).whole());
      settle();
      studio_.tools().settings().remesh = false;
    } else if (line.has("recover")) {
      if (studio_.document().abandoned().empty()) fail("there is no unsaved work to recover");
      studio_.document().recover(studio_.document().abandoned().front().folder);
      settle();
    } else if (line.has("reference")) {
      add_reference(line);
    } else if (line.has("save")) {
      require_shape("save");
      studio_.document().save(path("save"));
    } else if (line.has("export")) {
      require_shape("export");
      studio_.document().export_shape(path("export"), true);
    } else if (line.has("picture")) {
      if (!host_.picture) fail("pictures cannot be written here");
      settle();
      host_.picture(path("picture"));
    } else if (line.has("fit") && line.at("fit").is_null()) {
      studio_.fit().close();
    } else if (line.has("fit")) {
      fit(line);
    } else if (line.has("poster")) {
      write_poster(line);
    } else if (line.has("turntable")) {
      if (!host_.picture) fail("pictures cannot be written here");
      settle();
      studio_.view().record_turntable(path("turntable"), static_cast<int>(member_or(line, "pictures", 36U).whole()));
      while (studio_.view().step_turntable(host_.picture)) {
      }
    } else if (line.has("edit")) {
      std::string session = "{\"knead\": 1}\n";
      for (const Json& stroke : line.at("strokes").items()) session += to_text(stroke) + "\n";
      studio_.history().change(replaced(line.at("edit").whole(), parse_session(session, "edit").strokes));
    } else if (line.has("layer")) {
      change_layer(line);
    } else if (line.has("look_at")) {
      const Json& entry = line.at("look_at");
      studio_.history().look_at(entry.is_null() ? std::nullopt : std::optional(entry.whole()));
    } else if (line.has("close")) {
      studio_.document().close();
    } else {
      return false;
    }
    if (host_.after_event) host_.after_event();
    return true;
  }

  // What has been done may ask for more, as a remesh does for the limit cylinder of the new mesh.
  void settle() {
    do {
      studio_.document().worker().wait();
      studio_.refresh();
    } while (studio_.document().worker().is_busy());
  }

  static void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

  bool pauses(const Json& line) {
    if (line.has("sleep")) {
      pause(line.at("sleep").number());
    } else if (line.has("wait")) {
      settle();
      if (host_.after_event) host_.after_event();
    } else {
      return false;
    }
    return true;
  }

  Studio& studio_;
  const ScriptHost& host_;
};

}  // namespace

void run_script(std::istream& script, const std::string& name, Studio& studio, const ScriptHost& host) {
  Script runner(studio, host);
  std::string text;
  for (std::size_t number = 1; std::getline(script, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      runner.run(parse_json(text));
    } catch (const InvalidInput& error) {
      throw InvalidInput({name, number}, error.what());
    }
  }
}

}  // namespace knead::studio
