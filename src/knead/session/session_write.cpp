#include <fmt/format.h>

#include <array>
#include <cmath>
#include <span>

#include "knead/io/base64.h"
#include "knead/io/json.h"
#include "knead/session/session.h"
#include "knead/tool/tool.h"

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

std::string text_of(const SharedVectors& vectors) {
  if (vectors.empty()) return "";
  const std::string_view bytes(reinterpret_cast<const char*>(vectors.data()), vectors.size() * sizeof(Vec3d));
  return '"' + io_detail::to_base64(bytes) + '"';
}

std::string text_of(const PoseItem& item);
std::string text_of(const MirrorPlane& plane);
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

std::string text_of(const StrokeKey& key) { return applies(key) ? std::visit(KeyText{}, key.value) : ""; }

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

std::string header_line(const std::optional<std::string>& mesh, const std::optional<std::string>& note) {
  LineWriter line;
  line.add("knead", 1);
  line.add_optional("mesh", mesh);
  line.add_optional("note", note);
  return line.finish();
}

std::string stroke_line(const Stroke& stroke) { return stroke_line(SessionStroke{stroke}); }

std::string stroke_line(const SessionStroke& stroke) {
  const Tool& tool = tool_of(stroke.stroke);
  if (tool.is_event && stroke == SessionStroke{tool.start, stroke.line, stroke.remesh}) {
    return fmt::format("{{\"{}\": null}}", tool.name);
  }
  Stroke own = stroke.stroke;
  Stroke start = tool.start;
  const std::vector<StrokeKey> keys = tool.keys(own);
  const std::vector<StrokeKey> defaults = defaults_for(keys, tool, start);
  LineWriter line;
  if (!tool.is_event) line.add("tool", std::string(tool.name));
  if (!stroke.name.empty()) line.add("name", stroke.name);
  if (stroke.off) line.add_text("off", "true");
  if (stroke.strength != 1) line.add("strength", stroke.strength);
  if (stroke.duration != 1) line.add("duration", stroke.duration);
  if (!stroke.mirror.empty()) line.add_text("mirror", text_of_mirror(stroke.mirror));
  if (stroke.new_entry) line.add_text("new_entry", *stroke.new_entry ? "true" : "false");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto* choice = std::get_if<Choice>(&keys[i].value);
    const bool is_default = choice != nullptr
                                ? choice->chosen == 0
                                : keys[i].presence != Presence::required && text_of(keys[i]) == text_of(defaults[i]);
    if (applies(keys[i]) && !is_default) line.add_text(keys[i].name, text_of(keys[i]));
  }
  if (!tool.is_event) return line.finish();
  LineWriter event;
  event.add_text(tool.name, line.finish());
  return event.finish();
}

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
  std::string text = header_line(session.mesh, session.note) + "\n";
  std::optional<RemeshSettings> remesh;
  for (const SessionStroke& stroke : session.strokes) {
    if (stroke.remesh != remesh) text += remesh_line(stroke.remesh) + "\n";
    remesh = stroke.remesh;
    text += stroke_line(stroke) + "\n";
  }
  return text;
}

}  // namespace knead
