// Reads the .knead file, and applies the keys that every stroke may have.
#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "io/text.h"
#include "knead/editor/tools.h"
#include "knead/io.h"
#include "knead/session.h"
#include "session/point_constraint.h"
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
    const bool is_own_image = !reads_surface(with.stroke) && flow_of(with.stroke, with.mirror) == flow_of(with.stroke);
    if (!is_own_image) stroke = std::move(with);
  }
  return strokes;
}

bool puts_points_back(const Session& session) { return session.constraint && !session.constraint->is_flow(); }

Session without_off(Session session) {
  std::erase_if(session.strokes, [](const SessionStroke& stroke) { return stroke.off; });
  return session;
}

namespace {

using namespace detail;

constexpr int kFormatVersion = 1;
// Bytes of a line: a hundred thousand samples of a painted stroke are some 10 MB, and hold 25 times as much in memory.
constexpr std::size_t kLongestLine = std::size_t{16} << 20;
constexpr std::string_view kBlanks = " \t\r\n";

SessionStroke read_numbers(const JsonValue& line, const Place& place) {
  const JsonObject event(line, place, place.line > 0 ? "an event" : "a stroke");
  const Tool* tool = detail::event_tool(event);
  if (tool == nullptr || event.has("tool")) return detail::read_stroke(line, place);
  event.allow({tool->name});
  return detail::read_event_stroke(*tool, event.at(tool->name), place);
}

SessionStroke read_stroke_line(const Json& line, std::span<const Parameter> parameters, const Place& place) {
  detail::FilledLine filled = detail::fill_in(line, parameters, place);
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

std::vector<Wall> read_walls(const JsonValue& value, const Place& place) {
  std::vector<Wall> walls;
  for (const JsonValue& item : value.items()) {
    const JsonObject object(item, place, "a wall");
    object.allow({"patch", "hold", "slide", "periodic", "layers", "width"});
    Wall wall{object.at("patch").text()};
    const bool holds = object.has("hold") && object.at("hold").flag();
    wall.slides = object.has("slide") && object.at("slide").flag();
    if (object.has("periodic")) wall.periodic = object.at("periodic").text();
    wall.keeps_layers = object.has("layers") && object.at("layers").flag();
    const bool is_periodic = !wall.periodic.empty();
    if (int{holds} + int{wall.slides} + int{is_periodic} + int{wall.keeps_layers} != 1 || wall.periodic == wall.patch) {
      throw InvalidInput(place,
                         fmt::format("the wall \"{}\" needs one of \"hold\": true, \"slide\": true, \"layers\": true "
                                     "and \"periodic\": \"another patch\"",
                                     wall.patch));
    }
    wall.width = object.optional_number("width");
    if (wall.width && !(*wall.width > 0)) object.at("width").fail("a length greater than 0");
    walls.push_back(std::move(wall));
  }
  return walls;
}

// Follows the events of a session one line after the other.
class SessionReader {
 public:
  explicit SessionReader(const std::string& name) : place_{name, 0} { session_.name = name; }

  Session read(std::string_view rest) {
    rest.remove_prefix(detail::text_begin(rest, place_.file));
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
      const std::optional<Json> json = detail::parse_line(line.text, place_);
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
      session_.parameters = detail::read_parameters(header.at("parameters"), place_);
    }
    if (header.has("walls")) session_.walls = read_walls(header.at("walls"), place_);
  }

  void read_event(const JsonValue& line) {
    const JsonObject event(line, place_, "an event");
    if (event.has("tool") || detail::event_tool(event) != nullptr) {
      add(read_stroke_line(line.json(), session_.parameters, place_));
    } else if (event.has("undo")) {
      event.allow({"undo"});
      move_last(event.at("undo"), session_.strokes, undone_, "in effect");
    } else if (event.has("redo")) {
      event.allow({"redo"});
      move_last(event.at("redo"), undone_, session_.strokes, "to be redone");
    } else if (event.has("remesh")) {
      event.allow({"remesh"});
      remesh_ = detail::read_remesh(event.at("remesh"), place_);
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

// A number, numbers between commas, such lists between semicolons, or a text.
Json value_of_word(std::string_view word) {
  for (const char between : {';', ','}) {
    if (word.find(between) == std::string_view::npos) continue;
    Json list = Json::array();
    for (std::size_t at = 0; at < word.size();) {
      const std::size_t end = std::min(word.find(between, at), word.size());
      list.push_back(value_of_word(word.substr(at, end - at)));
      at = end + 1;
    }
    return list;
  }
  try {
    return parse_json(word);
  } catch (const JsonError&) {
    return word;
  }
}

// How deep the lists of a key's values nest: 1 for numbers, 2 for points, 3 for curves. 0: as they are written.
std::size_t depth_of(const KeyValue& value) {
  const auto holds = [&]<class... Lists>(Lists...) { return (std::holds_alternative<Lists>(value) || ...); };
  using Curves = std::vector<std::vector<Vec3d>>;
  if (holds(static_cast<Curves*>(nullptr))) return 3;
  if (holds(static_cast<std::vector<Vec3d>*>(nullptr), static_cast<std::vector<PaintSample>*>(nullptr),
            static_cast<SharedVectors*>(nullptr))) {
    return 2;
  }
  return holds(static_cast<std::vector<double>*>(nullptr), static_cast<std::vector<std::uint32_t>*>(nullptr)) ? 1 : 0;
}

// Completes a list of which a word shows less: "points=0,0,1" is a list of one point.
Json nested(Json value, std::string_view tool, std::string_view name) {
  const Tool* const known = find_tool(tool);
  if (known == nullptr || value.is_text()) return value;
  Stroke start = known->start;
  std::size_t missing = 0;
  for (const StrokeKey& key : known->keys(start)) {
    if (key.name == name) missing = depth_of(key.value);
  }
  for (const Json* at = &value; missing > 0 && at->is_array(); --missing) {
    if (at->items().empty()) return value;
    at = &at->items().front();
  }
  for (; missing > 0; --missing) {
    Json list = Json::array();
    list.push_back(std::move(value));
    value = std::move(list);
  }
  return value;
}

// The stroke "TOOL key=value key=value" as JSON.
Json stroke_of_words(std::string_view words, const Place& place) {
  Json stroke = Json::object();
  for (std::size_t at = words.find_first_not_of(kBlanks); at < words.size();) {
    const std::size_t end = std::min(words.find_first_of(kBlanks, at), words.size());
    const std::string_view word = words.substr(at, end - at);
    const std::size_t equals = word.find('=');
    const bool is_tool = stroke.members().empty();
    if (is_tool ? equals != std::string_view::npos : equals == std::string_view::npos || equals == 0) {
      throw InvalidInput(place, fmt::format("\"{}\": a stroke is TOOL key=value key=value, as in \"rotate center=0,0,0 "
                                            "axis=0,0,1 angle_deg=30 inner=1 outer=2\", or a JSON object",
                                            word));
    }
    if (is_tool) {
      stroke.set("tool", word);
    } else {
      const std::string_view name = word.substr(0, equals);
      const std::string_view value = word.substr(equals + 1);
      const bool is_json = value.starts_with('[') || value.starts_with('{');
      stroke.set(name, is_json ? parse_json(value) : nested(value_of_word(value), stroke.at("tool").text(), name));
    }
    at = words.find_first_not_of(kBlanks, end);
  }
  return stroke;
}

}  // namespace

Session parse_session(std::string_view text, const std::string& name) { return SessionReader(name).read(text); }

SessionStroke parse_stroke(std::string_view text, const std::string& name, std::span<const Parameter> parameters) {
  const Place place{name, 0};
  const std::size_t first = text.find_first_not_of(kBlanks);
  const bool is_words = first != std::string_view::npos && std::isalpha(static_cast<unsigned char>(text[first])) != 0;
  const std::optional<Json> json =
      is_words ? std::optional(stroke_of_words(text, place)) : detail::parse_line(text, place);
  if (!json || !json->is_object()) throw InvalidInput(place, "a stroke must be a JSON object {...}");
  return read_stroke_line(*json, parameters, place);
}

Session with_values(Session session, const ParameterValues& values) {
  session.parameters = detail::changed(std::move(session.parameters), values, Place{session.name});
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

}  // namespace knead
