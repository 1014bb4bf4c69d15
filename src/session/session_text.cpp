// Writes the .knead file: every value as text that is read back to the same bits.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "io/numbers.h"
#include "knead/editor/tools.h"
#include "knead/session.h"
#include "session/stroke_json.h"

namespace knead {

namespace {

std::string text_of(double value) {
  if (value == 0) return std::signbit(value) ? "-0.0" : "0";  // -0 reads as the integer 0
  return fmt::format("{}", value);
}

std::string text_of(int value) { return fmt::format("{}", value); }

std::string text_of(const Vec3d& v) { return fmt::format("[{}, {}, {}]", text_of(v.x), text_of(v.y), text_of(v.z)); }

std::string text_of(const std::string& text) { return to_text(Json(text)); }

std::string text_of(const PaintSample& sample) {
  return fmt::format(R"({{"point": {}, "normal": {}}})", text_of(sample.point), text_of(sample.normal));
}

std::string text_of(const std::optional<PinRotation>& rotation) {
  if (!rotation) return "null";
  return fmt::format(R"({{"axis": {}, "angle_deg": {}}})", text_of(rotation->axis), text_of(rotation->angle_deg));
}

std::string text_of(std::uint32_t value) { return fmt::format("{}", value); }

std::string text_of(const VertexRange& range) {
  return range.first == range.last ? text_of(range.first) : fmt::format("[{}, {}]", range.first, range.last);
}

std::string text_of(const std::array<int, 3>& counts) {
  return fmt::format("[{}, {}, {}]", counts[0], counts[1], counts[2]);
}

template <class T>
std::string text_of(const SharedList<T>& items) {
  if (items.empty()) return "";
  const std::string_view bytes(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(T));
  return '"' + detail::to_base64(bytes) + '"';
}

std::string text_of(const PoseItem& item);
std::string text_of(const MirrorPlane& plane);
std::string text_of(const Wall& wall);
std::string text_of(const PoseStiffness& region);

template <class T>
std::string text_of(const std::vector<T>& items) {
  std::string result = "[";
  for (const T& item : items) {
    if (result.size() > 1) result += ", ";
    result += text_of(item);
  }
  return result + "]";
}

// One JSON object on one line, of members whose values are text already.
class LineWriter {
 public:
  void add_text(std::string_view key, const std::string& value) {
    line_ += fmt::format("{}\"{}\": {}", line_.empty() ? "{" : ", ", key, value);
  }

  template <class T>
  void add(std::string_view key, const T& value) {
    add_text(key, text_of(value));
  }

  template <class T>
  void add_optional(std::string_view key, const std::optional<T>& value) {
    if (value) add(key, *value);
  }

  std::string finish() const { return line_.empty() ? "{}" : line_ + "}"; }

 private:
  std::string line_;
};

std::string text_of(const HandlesMotion& motion) {
  LineWriter object;
  if (const auto* rotation = std::get_if<HandlesRotation>(&motion)) {
    object.add("rotate", rotation->axis);
    object.add("center", rotation->center);
    object.add("angle_deg", rotation->angle_deg);
  } else {
    object.add("translate", std::get<HandlesTranslation>(motion).by);
  }
  return object.finish();
}

std::string text_of(const PosePart& part) {
  LineWriter object;
  if (!part.vertices.empty()) object.add("vertices", part.vertices);
  if (!part.points.empty()) object.add("points", part.points);
  if (part.hold) object.add_text("hold", "true");
  if (part.rotation) {
    object.add("rotate", part.rotation->axis);
    object.add("center", part.rotation->center);
    object.add("angle_deg", part.rotation->angle_deg);
  }
  object.add_optional("translate", part.translation);
  return object.finish();
}

std::string text_of(const PosePin& pin) {
  LineWriter object;
  object.add_optional("pin", pin.vertex);
  object.add_optional("pin_point", pin.point);
  if (pin.hold) object.add_text("hold", "true");
  if (pin.path.size() == 1) object.add("to", pin.path.front());
  if (pin.path.size() > 1) object.add("path", pin.path);
  if (pin.size != PosePin{}.size) object.add("size", pin.size);
  if (!pin.turns_freely) object.add("turn", pin.rotation);
  return object.finish();
}

std::string text_of(const PoseItem& item) {
  return std::visit([](const auto& of_kind) { return text_of(of_kind); }, item);
}

std::string text_of(const PoseStiffness& region) {
  LineWriter object;
  object.add("vertices", region.vertices);
  object.add("value", region.value);
  return object.finish();
}

std::string text_of(const Wall& wall) {
  LineWriter object;
  object.add("patch", wall.patch);
  if (!wall.periodic.empty()) object.add("periodic", wall.periodic);
  if (wall.periodic.empty()) object.add_text(wall.slides ? "slide" : wall.keeps_layers ? "layers" : "hold", "true");
  object.add_optional("width", wall.width);
  return object.finish();
}

std::string text_of(bool value) { return value ? "true" : "false"; }

// The identity with zeros of either sign is written as the identity.
std::string text_of(const Mat3d& m) {
  const Mat3d plain = m == Mat3d{} ? Mat3d{} : m;
  return text_of(std::vector<Vec3d>{plain.row0, plain.row1, plain.row2});
}

std::string text_of(const AutoNumber& number) {
  return *number.is_auto ? "\"auto\"" : *number.value ? text_of(**number.value) : "";
}

std::string text_of(const Choice& choice) { return text_of(std::string(choice.words[choice.chosen])); }

// The value of a stroke's key; empty where there is none.
struct KeyText {
  template <class T>
  std::string operator()(T* value) const {
    return text_of(*value);
  }
  template <class T>
  std::string operator()(std::optional<T>* value) const {
    return *value ? text_of(**value) : "";
  }
  template <class T>
  std::string operator()(const T& value) const {
    return text_of(value);
  }
};

std::string text_of(const StrokeKey& key) {
  if (key.quantity == Quantity::wide_falloff && *std::get<int*>(key.value) == kWideFalloff) return "\"wide\"";
  return applies(key) ? std::visit(KeyText{}, key.value) : "";
}

// Returns the keys of `start` with the choices of the given keys, so that the same keys apply.
std::vector<StrokeKey> defaults_for(const std::vector<StrokeKey>& keys, const Tool& tool, Stroke& start) {
  const std::vector<StrokeKey> defaults = tool.keys(start);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (const auto* choice = std::get_if<Choice>(&keys[i].value)) {
      std::get<Choice>(defaults[i].value).choose(choice->chosen);
    }
  }
  return tool.keys(start);
}

std::string text_of(const MirrorPlane& plane) {
  LineWriter object;
  object.add("normal", plane.normal);
  if (plane.point != Vec3d{0, 0, 0}) object.add("point", plane.point);
  return object.finish();
}

// The names of coordinate planes; else the planes.
std::string text_of_mirror(const Mirror& mirror) {
  for (const char* const names : {"x", "y", "z", "xy", "xz", "yz", "xyz"}) {
    if (mirror == coordinate_mirror(names)) return text_of(std::string(names));
  }
  return mirror.size() == 1 ? text_of(mirror.front()) : text_of(mirror);
}

std::string text_of(const std::optional<RemeshSettings>& settings) {
  if (!settings) return "null";
  LineWriter object;
  object.add_optional("max_edge", settings->max_edge);
  object.add_optional("max_angle_deg", settings->max_angle_deg);
  object.add_optional("max_chord", settings->max_chord);
  object.add_optional("min_edge", settings->min_edge);
  object.add_optional("iterations", settings->iterations);
  if (settings->max_vertices) object.add("max_vertices", static_cast<std::uint32_t>(*settings->max_vertices));
  return object.finish();
}

// With the names of parameters where the session can be read so.
std::string line_in(const Session& session, const SessionStroke& stroke) {
  if (stroke.uses.empty() || session.parameters.empty()) return stroke_line(stroke);
  std::string line = detail::line_of(stroke, true);
  try {
    const std::string read = stroke_line(parse_stroke(line, session.name, session.parameters));
    if (read == stroke_line(stroke)) return line;
  } catch (const InvalidInput&) {
    // The session does not have such parameters.
  }
  return stroke_line(stroke);
}

}  // namespace

std::string header_line(const std::optional<std::string>& mesh, const std::optional<std::string>& note,
                        std::span<const Parameter> parameters, std::span<const std::string> also,
                        std::span<const Wall> walls) {
  LineWriter line;
  line.add("knead", 1);
  line.add_optional("mesh", mesh);
  if (!also.empty()) line.add_text("also", text_of(std::vector<std::string>(also.begin(), also.end())));
  line.add_optional("note", note);
  if (!walls.empty()) line.add("walls", std::vector<Wall>(walls.begin(), walls.end()));
  if (parameters.empty()) return line.finish();
  LineWriter values;
  for (const Parameter& parameter : parameters) {
    LineWriter bounded;
    bounded.add("value", parameter.value);
    bounded.add_optional("min", parameter.least);
    bounded.add_optional("max", parameter.greatest);
    const bool is_bounded = parameter.least || parameter.greatest;
    values.add_text(parameter.name, is_bounded ? bounded.finish() : text_of(parameter.value));
  }
  line.add_text("parameters", values.finish());
  return line.finish();
}

std::string stroke_line(const Stroke& stroke) { return stroke_line(SessionStroke{stroke}); }

std::string stroke_line(const SessionStroke& stroke) { return detail::line_of(stroke, false); }

namespace detail {

std::string key_text(const SessionStroke& stroke, std::string_view key) {
  if (key == "strength") return text_of(stroke.strength);
  if (key == "duration") return text_of(stroke.duration);
  if (key == "mirror") return stroke.mirror.empty() ? "" : text_of_mirror(stroke.mirror);
  Stroke own = stroke.stroke;
  for (const StrokeKey& each : tool_of(own).keys(own)) {
    if (each.name == key) return text_of(each);
  }
  return "";
}

std::string line_of(const SessionStroke& stroke, bool names_parameters) {
  const Tool& tool = tool_of(stroke.stroke);
  LineWriter line;
  const auto add = [&](std::string_view key, const std::string& text, bool is_default) {
    const auto is_it = [&](const ParameterUse& use) { return use.key == key && use.numbers == text; };
    const auto use = std::find_if(stroke.uses.begin(), stroke.uses.end(), is_it);
    if (names_parameters && use != stroke.uses.end()) {
      line.add_text(key, use->text);
    } else if (!is_default) {
      line.add_text(key, text);
    }
  };
  Stroke own = stroke.stroke;
  Stroke start = tool.start;
  const std::vector<StrokeKey> keys = tool.keys(own);
  const std::vector<StrokeKey> defaults = defaults_for(keys, tool, start);
  if (!tool.is_event) line.add("tool", std::string(tool.name));
  if (!stroke.name.empty()) line.add("name", stroke.name);
  if (stroke.off) line.add_text("off", "true");
  add("strength", text_of(stroke.strength), stroke.strength == 1);
  add("duration", text_of(stroke.duration), stroke.duration == 1);
  if (!stroke.mirror.empty()) add("mirror", text_of_mirror(stroke.mirror), false);
  if (stroke.new_entry) line.add_text("new_entry", *stroke.new_entry ? "true" : "false");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!applies(keys[i])) continue;
    const std::string text = text_of(keys[i]);
    const auto* choice = std::get_if<Choice>(&keys[i].value);
    const bool is_default = choice != nullptr ? choice->chosen == 0
                                              : keys[i].presence != Presence::required && text == text_of(defaults[i]);
    add(keys[i].name, text, is_default);
  }
  if (!tool.is_event) return line.finish();
  const bool is_bare = stroke == SessionStroke{tool.start, stroke.line, stroke.remesh};
  LineWriter event;
  event.add_text(tool.name, is_bare ? "null" : line.finish());
  return event.finish();
}

}  // namespace detail

std::string stroke_values(const SessionStroke& stroke) {
  Stroke own = stroke.stroke;
  LineWriter line;
  line.add("name", stroke.name);
  line.add_text("off", stroke.off ? "true" : "false");
  line.add("strength", stroke.strength);
  line.add("duration", stroke.duration);
  if (!stroke.mirror.empty()) line.add_text("mirror", text_of_mirror(stroke.mirror));
  for (const StrokeKey& key : tool_of(own).keys(own)) {
    const std::string text = text_of(key);
    if (!text.empty()) line.add_text(key.name, text);
  }
  return line.finish();
}

std::string remesh_line(const std::optional<RemeshSettings>& settings) {
  LineWriter line;
  line.add_text("remesh", text_of(settings));
  return line.finish();
}

std::string serialize_session(const Session& session) {
  std::string text = header_line(session.mesh, session.note, session.parameters, session.also, session.walls) + "\n";
  std::optional<RemeshSettings> remesh;
  for (const SessionStroke& stroke : session.strokes) {
    if (stroke.remesh != remesh) text += remesh_line(stroke.remesh) + "\n";
    remesh = stroke.remesh;
    text += line_in(session, stroke) + "\n";
  }
  return text;
}

}  // namespace knead
