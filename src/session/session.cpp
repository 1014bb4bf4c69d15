// What the keys that every stroke may have mean.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "io/numbers.h"
#include "io/text.h"
#include "knead/io.h"
#include "knead/session.h"
#include "knead/tools.h"
#include "session/stroke_json.h"
#include "strokes/mirror.h"

namespace knead {

bool is_applied(const SessionStroke& stroke) { return !stroke.off && stroke.strength > 0; }

bool is_plain(const SessionStroke& stroke) {
  return stroke.name.empty() && !stroke.off && stroke.strength == 1 && stroke.duration == 1 && stroke.mirror.empty();
}

Flow flow_of(const SessionStroke& stroke) {
  if (!is_applied(stroke)) return {};
  if (stroke.strength > 1) return flow_of(prolonged(stroke.stroke, stroke.strength), stroke.mirror);
  Flow flow = flow_of(stroke.stroke, stroke.mirror);
  return stroke.strength == 1 ? flow : prefix(flow, stroke.strength * static_cast<double>(flow.segments.size()));
}

namespace {

// Whether the stroke does the same without its mirror.
bool is_own_image(const SessionStroke& stroke) {
  if (reads_surface(stroke.stroke)) return false;
  return flow_of(stroke.stroke, stroke.mirror) == flow_of(stroke.stroke);
}

}  // namespace

std::vector<SessionStroke> mirrored_in(std::vector<SessionStroke> strokes, const Mirror& mirror) {
  validate(mirror);
  const std::vector<SymmetryImage> images = images_in(mirror);
  for (SessionStroke& stroke : strokes) {
    if (mirror.empty()) continue;
    if (tool_of(stroke.stroke).is_event) {
      if (!is_flow(stroke.stroke)) stroke.stroke = symmetric_strokes({{stroke.stroke}}, images, 0, {}).front();
      continue;
    }
    SessionStroke with = stroke;
    for (const MirrorPlane& plane : mirror) {
      if (std::find(with.mirror.begin(), with.mirror.end(), plane) == with.mirror.end()) with.mirror.push_back(plane);
    }
    validate(with.mirror);
    if (!is_own_image(with)) stroke = std::move(with);
  }
  return strokes;
}

Session without_off(Session session) {
  std::erase_if(session.strokes, [](const SessionStroke& stroke) { return stroke.off; });
  return session;
}

namespace {

using session_detail::JsonObject;
using session_detail::JsonValue;

constexpr int kFormatVersion = 1;
// Bytes of a line: a hundred thousand samples of a painted stroke are some 10 MB, and hold 25 times as much in memory.
constexpr std::size_t kLongestLine = std::size_t{16} << 20;
constexpr std::string_view kBlanks = " \t\r\n";

std::string line_of(const SessionStroke& stroke, bool names_parameters);

// The value of a key of a stroke as stroke_line writes it, also of one with its default value. Empty: it has none.
std::string key_text(const SessionStroke& stroke, std::string_view key);

SessionStroke read_numbers(const JsonValue& line, const Place& place) {
  const JsonObject event(line, place, place.line > 0 ? "an event" : "a stroke");
  const Tool* tool = session_detail::event_tool(event);
  if (tool == nullptr || event.has("tool")) return session_detail::read_stroke(line, place);
  event.allow({tool->name});
  return session_detail::read_event_stroke(*tool, event.at(tool->name), place);
}

SessionStroke read_stroke_line(const Json& line, std::span<const Parameter> parameters, const Place& place) {
  session_detail::FilledLine filled = session_detail::fill_in(line, parameters, place);
  SessionStroke stroke = read_numbers(JsonValue(filled.line, "", place), place);
  stroke.uses = std::move(filled.uses);
  for (ParameterUse& use : stroke.uses) use.numbers = key_text(stroke, use.key);
  return stroke;
}

struct Line {
  std::string_view text;
  bool ended = false;  // by a line end
};

// The text up to the next LF, without it and a CR before it; takes it away from `rest`.
Line next_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  Line line{rest.substr(0, end), end != std::string_view::npos};
  rest.remove_prefix(line.ended ? end + 1 : rest.size());
  if (line.ended && line.text.ends_with('\r')) line.text.remove_suffix(1);
  return line;
}

// Follows the events of a session one line after the other.
class SessionReader {
 public:
  explicit SessionReader(const std::string& name) : place_{name, 0} { session_.name = name; }

  Session read(std::string_view rest) {
    rest.remove_prefix(io_detail::text_begin(rest, place_.file));
    while (rest.find_first_not_of(kBlanks) != std::string_view::npos) {
      const Line line = next_line(rest);
      ++place_.line;
      if (line.text.size() > kLongestLine) {
        throw InvalidInput(place_, fmt::format("the line has {} bytes, more than {}; split the stroke into several",
                                               line.text.size(), kLongestLine));
      }
      if (line.text.find_first_not_of(kBlanks) == std::string_view::npos) {
        throw InvalidInput(place_, "the line is empty; every line must be a JSON object");
      }
      const std::optional<Json> json = session_detail::parse_line(line.text, place_);
      if (json) {
        read_line(JsonValue(*json, "", place_));
      } else {
        read_incomplete(line, rest);
      }
    }
    if (place_.line == 0) {
      throw InvalidInput({place_.file, 1}, R"(the file is empty; its first line must be the header {"knead": 1})");
    }
    return std::move(session_);
  }

 private:
  void read_line(const JsonValue& line) {
    if (!line.json().is_object()) throw InvalidInput(place_, "the line must be a JSON object {...}");
    if (place_.line == 1) {
      read_header(JsonObject(line, place_, "the header"));
    } else {
      read_event(line);
    }
  }

  void read_incomplete(const Line& line, std::string_view rest) {
    if (goes_on(line, std::string(next_line(rest).text))) {
      throw InvalidInput(place_, fmt::format("the object goes on in line {}; write each on one line", place_.line + 1));
    }
    if (line.ended || place_.line == 1) {
      throw InvalidInput(place_, "the JSON object of this line is incomplete; complete it or remove the line");
    }
    session_.warnings.push_back(to_string(place_) + ": the last line is incomplete and was left out");
  }

  // Returns whether a text is JSON, or the beginning of JSON.
  static bool is_json(const std::string& text, bool is_whole) {
    try {
      return !parse_json(text).is_null();
    } catch (const JsonError& error) {
      return !is_whole && error.kind() == JsonError::Kind::incomplete;
    }
  }

  // Returns whether an incomplete line and the next one, which is no object of its own, are JSON together.
  static bool goes_on(const Line& line, const std::string& next) {
    const bool has_text = next.find_first_not_of(kBlanks) != std::string::npos;
    return has_text && !is_json(next, true) && is_json(std::string(line.text) + "\n" + next, false);
  }

  void read_header(const JsonObject& header) {
    if (!header.has("knead")) {
      throw InvalidInput(place_, R"("knead" is missing; the first line must be the header {"knead": 1})");
    }
    const long long version = header.at("knead").integer();
    if (version != kFormatVersion) {
      throw InvalidInput(place_, fmt::format("\"knead\" must be {}, the format that this version reads, got {}",
                                             kFormatVersion, version));
    }
    header.allow({"knead", "mesh", "also", "note", "parameters", "walls"});
    if (header.has("mesh")) session_.mesh = header.at("mesh").text();
    if (header.has("also")) {
      for (const JsonValue& shape : header.at("also").items()) session_.also.push_back(shape.text());
    }
    if (header.has("note")) session_.note = header.at("note").text();
    if (header.has("parameters")) {
      session_.parameters = session_detail::read_parameters(header.at("parameters"), place_);
    }
    if (header.has("walls")) session_.walls = session_detail::read_walls(header.at("walls"), place_);
  }

  void read_event(const JsonValue& line) {
    const JsonObject event(line, place_, "an event");
    if (event.has("tool") || session_detail::event_tool(event) != nullptr) {
      add(read_stroke_line(line.json(), session_.parameters, place_));
    } else if (event.has("undo")) {
      event.allow({"undo"});
      move_last(event.at("undo"), session_.strokes, undone_, "in effect");
    } else if (event.has("redo")) {
      event.allow({"redo"});
      move_last(event.at("redo"), undone_, session_.strokes, "to be redone");
    } else if (event.has("remesh")) {
      event.allow({"remesh"});
      remesh_ = session_detail::read_remesh(event.at("remesh"), place_);
    } else {
      event.allow({"tool", "relax", "mask", "undo", "redo", "remesh"});
      throw InvalidInput(
          place_, R"(the line is an empty object; an event has the key "tool", "relax", "mask", "undo", "redo" or )"
                  R"("remesh")");
    }
  }

  void add(SessionStroke stroke) {
    session_.strokes.push_back(std::move(stroke));
    session_.strokes.back().remesh = remesh_;
    undone_.clear();
  }

  // Moves the last n strokes, one after the other.
  void move_last(const JsonValue& count, std::vector<SessionStroke>& from, std::vector<SessionStroke>& to,
                 const char* what) const {
    const long long n = count.integer();
    if (n < 1 || static_cast<std::size_t>(n) > from.size()) {
      count.fail(fmt::format("a whole number from 1 to the {} strokes {}", from.size(), what));
    }
    for (long long i = 0; i < n; ++i) {
      to.push_back(std::move(from.back()));
      from.pop_back();
    }
  }

  Place place_;
  Session session_;
  std::vector<SessionStroke> undone_;     // the one to be redone first at the end
  std::optional<RemeshSettings> remesh_;  // of the strokes that follow
};

}  // namespace

Session parse_session(std::string_view text, const std::string& name) { return SessionReader(name).read(text); }

SessionStroke parse_stroke(std::string_view text, const std::string& name, std::span<const Parameter> parameters) {
  const Place place{name, 0};
  const std::optional<Json> json = session_detail::parse_line(text, place);
  if (!json || !json->is_object()) throw InvalidInput(place, "a stroke must be a JSON object {...}");
  return read_stroke_line(*json, parameters, place);
}

Session with_values(Session session, const ParameterValues& values) {
  session.parameters = session_detail::changed(std::move(session.parameters), values, Place{session.name});
  for (SessionStroke& stroke : session.strokes) {
    if (stroke.uses.empty()) continue;
    const Place place{session.name, stroke.line};
    SessionStroke read = read_stroke_line(parse_json(line_of(stroke, true)), session.parameters, place);
    read.remesh = stroke.remesh;
    stroke = std::move(read);
  }
  return session;
}

Session read_session(const std::filesystem::path& path) { return parse_session(read_text(path), path.string()); }

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
  return '"' + io_detail::to_base64(bytes) + '"';
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

std::string stroke_line(const SessionStroke& stroke) { return line_of(stroke, false); }

namespace {

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

// With the names of parameters where the session can be read so.
std::string line_in(const Session& session, const SessionStroke& stroke) {
  if (stroke.uses.empty() || session.parameters.empty()) return stroke_line(stroke);
  std::string line = line_of(stroke, true);
  try {
    const std::string read = stroke_line(parse_stroke(line, session.name, session.parameters));
    if (read == stroke_line(stroke)) return line;
  } catch (const InvalidInput&) {
    // The session does not have such parameters.
  }
  return stroke_line(stroke);
}

}  // namespace

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
