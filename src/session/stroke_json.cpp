// One line of a session as a strict JSON object: keys, types, messages.
#include "session/stroke_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "io/numbers.h"
#include "io/text.h"

namespace knead::detail {

void JsonValue::fail(const std::string& expected) const {
  throw InvalidInput(place_, fmt::format("{} must be {}, got {}", name_, expected, described(value_)));
}

double JsonValue::number() const {
  double quoted = 0;
  const bool is_quoted = value_.is_text() && parse_real(value_.text(), quoted) == ParseResult::ok;
  if (!value_.is_number()) fail(is_quoted ? "a number, without quotes" : "a number");
  return value_.number();
}

long long JsonValue::integer() const {
  constexpr double kMax = 999'999'999;
  if (!value_.is_number()) fail("a whole number");
  const double value = value_.number();
  if (value != std::floor(value) || std::abs(value) > kMax) fail("a whole number of at most 9 digits");
  return static_cast<long long>(value);
}

std::string JsonValue::text() const {
  if (!value_.is_text()) fail("text in double quotes");
  return value_.text();
}

bool JsonValue::flag() const {
  if (!value_.is_flag()) fail("true or false");
  return value_.flag();
}

Vec3d JsonValue::vector() const {
  if (!value_.is_array() || value_.items().size() != 3) fail("three numbers [x, y, z]");
  const std::vector<Json>& numbers = value_.items();
  for (std::size_t i = 0; i < 3; ++i) {
    if (!numbers[i].is_number()) items()[i].number();  // names the one that is none
  }
  return {numbers[0].number(), numbers[1].number(), numbers[2].number()};
}

std::vector<JsonValue> JsonValue::items() const {
  if (!value_.is_array()) fail("a list [...]");
  std::vector<JsonValue> result;
  for (const Json& item : value_.items()) {
    result.emplace_back(item, fmt::format("{}[{}]", name_, result.size()), place_);
  }
  return result;
}

std::vector<Vec3d> JsonValue::vectors() const {
  std::vector<Vec3d> result;
  for (const JsonValue& item : items()) result.push_back(item.vector());
  return result;
}

std::size_t JsonValue::choice(std::span<const std::string_view> choices) const {
  const auto found = is_text() ? std::find(choices.begin(), choices.end(), text()) : choices.end();
  if (found == choices.end()) fail(fmt::format("one of \"{}\"", fmt::join(choices, "\", \"")));
  return static_cast<std::size_t>(found - choices.begin());
}

JsonObject::JsonObject(const JsonValue& value, const Place& place, std::string what)
    : value_(value.json()), place_(place), prefix_(value.name()), what_(std::move(what)) {
  if (!value_.is_object()) value.fail("a JSON object {...}");
}

void JsonObject::allow(const std::vector<std::string_view>& keys) const {
  for (const auto& [key, value] : value_.members()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    throw InvalidInput(place_, fmt::format("unknown key {}; {} has the keys \"{}\"", described(key), what_,
                                           fmt::join(keys, "\", \"")));
  }
}

JsonValue JsonObject::at(std::string_view key) const {
  std::string name = prefix_.empty() ? fmt::format("\"{}\"", key) : fmt::format("{} \"{}\"", prefix_, key);
  const Json* found = value_.find(key);
  if (found == nullptr) throw InvalidInput(place_, fmt::format("{} is missing; {} needs it", name, what_));
  return {*found, std::move(name), place_};
}

std::optional<double> JsonObject::optional_number(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return number(key);
}

namespace {

// Returns "at \"outer\", ", or nothing before the first key.
std::string position(const JsonError& error) {
  return error.key() ? fmt::format("at {}, ", described(*error.key())) : "";
}

std::string complaint(const JsonError& error) {
  if (error.kind() == JsonError::Kind::repeated_key) return error.what();
  if (error.kind() == JsonError::Kind::not_json) {
    return fmt::format(
        "{}column {} is not JSON; a line must be one object, with keys and text in double quotes and "
        "finite numbers",
        position(error), error.byte());
  }
  return position(error) + error.what();
}

// Gives what `check` throws its place in the file.
template <class Function>
void at_place(const Place& place, const std::string& prefix, const Function& check) {
  try {
    check();
  } catch (const InvalidInput& error) {
    throw InvalidInput(place, prefix + error.what());
  }
}

const Tool& tool_at(const JsonValue& name) {
  if (const Tool* tool = find_tool(name.text()); tool != nullptr && !tool->is_event) return *tool;
  std::string names;
  for (const Tool* tool : tools()) {
    if (!tool->is_event) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", tool->name);
  }
  name.fail("one of " + names);
}

std::uint32_t read_vertex(const JsonValue& value) {
  const long long vertex = value.integer();
  if (vertex < 0) value.fail("the number of a vertex, from 0 on");
  return static_cast<std::uint32_t>(vertex);
}

std::vector<VertexRange> read_ranges(const JsonValue& value) {
  std::vector<VertexRange> ranges;
  for (const JsonValue& item : value.items()) {
    const std::vector<JsonValue> ends = item.is_number() ? std::vector<JsonValue>{item, item} : item.items();
    if (ends.size() != 2) item.fail("the number of a vertex, or two: [first, last]");
    ranges.push_back({read_vertex(ends[0]), read_vertex(ends[1])});
  }
  if (ranges.empty()) value.fail("1 or more vertices");
  return ranges;
}

PinRotation read_rotation(const JsonValue& value, const Place& place) {
  const JsonObject rotation(value, place, "a turn");
  rotation.allow({"axis", "angle_deg"});
  return {rotation.vector("axis"), rotation.number("angle_deg")};
}

PosePart read_part(const JsonObject& object) {
  object.allow({"vertices", "points", "hold", "rotate", "center", "angle_deg", "translate"});
  PosePart part;
  if (object.has("vertices")) part.vertices = read_ranges(object.at("vertices"));
  if (object.has("points")) part.points = object.vectors("points");
  if (object.has("hold")) part.hold = object.at("hold").flag();
  if (object.has("rotate") || object.has("center") || object.has("angle_deg")) {
    part.rotation = HandlesRotation{object.vector("rotate"), object.vector("center"), object.number("angle_deg")};
  }
  if (object.has("translate")) part.translation = object.vector("translate");
  return part;
}

PosePin read_pin(const JsonObject& object, const Place& place) {
  object.allow({"pin", "pin_point", "hold", "to", "path", "size", "turn"});
  PosePin pin;
  if (object.has("pin")) pin.vertex = read_vertex(object.at("pin"));
  if (object.has("pin_point")) pin.point = object.vector("pin_point");
  if (object.has("hold")) pin.hold = object.at("hold").flag();
  if (object.has("to") && object.has("path")) object.at("to").fail("left out where \"path\" is given");
  if (object.has("to")) pin.path = {object.vector("to")};
  if (object.has("path")) pin.path = object.vectors("path");
  if (object.has("size")) pin.size = object.number("size");
  if (!object.has("turn")) return pin;
  pin.turns_freely = false;
  const JsonValue turn = object.at("turn");
  if (!turn.json().is_null()) pin.rotation = read_rotation(turn, place);
  return pin;
}

// Reads what is at one key into the stroke's member.
struct ReadValue {
  const JsonValue& json;
  const Place& place;
  Presence presence;

  void operator()(double* value) const { *value = json.number(); }
  void operator()(std::optional<double>* value) const { *value = json.number(); }
  void operator()(const AutoNumber& number) const {
    *number.is_auto = json.is_text() && json.text() == "auto";
    if (*number.is_auto) return;
    if (!json.is_number()) json.fail("a number, or \"auto\"");
    *number.value = json.number();
  }
  void operator()(int* value) const { *value = static_cast<int>(json.integer()); }
  void operator()(Vec3d* value) const { *value = json.vector(); }
  void operator()(std::optional<Vec3d>* value) const { *value = json.vector(); }
  void operator()(std::vector<Vec3d>* list) const {
    *list = json.vectors();
    if (list->empty() && presence == Presence::not_empty) json.fail("1 or more points");
  }
  void operator()(std::vector<std::vector<Vec3d>>* curves) const {
    for (const JsonValue& curve : json.items()) curves->push_back(curve.vectors());
  }
  void operator()(std::vector<std::uint32_t>* vertices) const {
    for (const JsonValue& item : json.items()) vertices->push_back(read_vertex(item));
    if (vertices->empty()) json.fail("1 or more vertices");
  }
  void operator()(std::vector<VertexRange>* ranges) const { *ranges = read_ranges(json); }
  void operator()(bool* value) const { *value = json.flag(); }
  void operator()(std::vector<PoseItem>* parts) const {
    for (const JsonValue& item : json.items()) {
      const JsonObject object(item, place, "a part");
      const bool is_pin = object.has("pin") || object.has("pin_point");
      parts->push_back(is_pin ? PoseItem(read_pin(object, place)) : PoseItem(read_part(object)));
    }
  }
  void operator()(std::vector<PoseStiffness>* regions) const {
    for (const JsonValue& item : json.items()) {
      const JsonObject region(item, place, "a region");
      region.allow({"vertices", "value"});
      regions->push_back({read_ranges(region.at("vertices")), region.number("value")});
    }
  }
  void operator()(std::vector<double>* numbers) const {
    for (const JsonValue& item : json.items()) numbers->push_back(item.number());
  }
  void operator()(std::vector<std::optional<PinRotation>>* rotations) const {
    for (const JsonValue& item : json.items()) {
      if (item.json().is_null()) {
        rotations->emplace_back();
        continue;
      }
      rotations->push_back(read_rotation(item, place));
    }
  }
  void operator()(std::vector<PaintSample>* samples) const {
    for (const JsonValue& item : json.items()) {
      const JsonObject sample(item, place, "a sample");
      sample.allow({"point", "normal"});
      samples->push_back({sample.vector("point"), sample.vector("normal")});
    }
  }
  void operator()(Mat3d* matrix) const {
    const std::vector<Vec3d> rows = json.vectors();
    if (rows.size() != 3) json.fail("a 3x3 matrix: three rows of three numbers");
    *matrix = {rows[0], rows[1], rows[2]};
  }
  void operator()(HandlesMotion* value) const {
    const JsonObject motion(json, place, "the motion");
    const bool turns = motion.has("rotate");
    turns ? motion.allow({"rotate", "center", "angle_deg"}) : motion.allow({"translate"});
    if (turns) {
      *value = HandlesRotation{motion.vector("rotate"), motion.vector("center"), motion.number("angle_deg")};
    } else {
      *value = HandlesTranslation{motion.vector("translate")};
    }
  }
  void operator()(std::array<int, 3>* value) const {
    const std::vector<JsonValue> items = json.items();
    if (items.size() != 3) json.fail("three whole numbers");
    for (std::size_t i = 0; i < 3; ++i) (*value)[i] = static_cast<int>(items[i].integer());
  }
  void operator()(SharedVectors* value) const { *value = list<Vec3d>("vectors of three numbers, of 8 bytes each"); }
  void operator()(SharedNumbers* value) const { *value = list<double>("numbers of 8 bytes each"); }
  void operator()(std::string* value) const { *value = json.text(); }
  void operator()(const Choice& choice) const { choice.choose(json.choice(choice.words)); }

  // `what` the bytes hold.
  template <class T>
  SharedList<T> list(std::string_view what) const {
    if (!json.is_text()) json.fail("numbers as base64, text in double quotes");
    const std::optional<std::string> bytes = from_base64(json.text());
    if (!bytes) throw InvalidInput(place, json.name() + " is no base64");
    if (bytes->size() % sizeof(T) != 0) {
      throw InvalidInput(place, fmt::format("{} must hold {}, got {} bytes", json.name(), what, bytes->size()));
    }
    std::vector<T> items(bytes->size() / sizeof(T));
    if (!items.empty()) std::memcpy(items.data(), bytes->data(), bytes->size());
    return SharedList<T>(std::move(items));
  }
};

// The number of "wide" is no falloff of a line.
int read_wide_falloff(const JsonValue& value) {
  if (value.is_text() && value.text() == "wide") return kWideFalloff;
  if (value.is_text()) value.fail("a whole number from 3 to 7, or \"wide\"");
  const auto falloff = static_cast<int>(value.integer());
  if (falloff == kWideFalloff) value.fail("a whole number from 3 to 7, or \"wide\"");
  return falloff;
}

bool decides(const StrokeKey& key) {
  return std::holds_alternative<Choice>(key.value) || key.quantity == Quantity::wide_falloff;
}

void read_key(const StrokeKey& key, const JsonObject& line, const Place& place) {
  const bool is_given = line.has(key.name);
  if (!applies(key)) {
    if (is_given) throw InvalidInput(place, fmt::format("\"{}\" needs {}", key.name, key.needs));
  } else if (is_given && key.quantity == Quantity::wide_falloff) {
    *std::get<int*>(key.value) = read_wide_falloff(line.at(key.name));
  } else if (is_given || key.presence == Presence::required) {
    std::visit(ReadValue{line.at(key.name), place, key.presence}, key.value);
  }
}

void read_keys(const Tool& tool, const JsonObject& line, const Place& place, Stroke& stroke) {
  std::vector<std::string_view> names;
  if (!tool.is_event) names.emplace_back("tool");
  for (const StrokeKey& key : tool.keys(stroke)) names.push_back(key.name);
  names.insert(names.end(), {"name", "off", "strength", "duration", "new_entry"});
  if (!tool.is_event) names.emplace_back("mirror");
  line.allow(names);
  const auto has = [&](std::string_view key) { return line.has(key); };
  at_place(place, "", [&] { tool.prepare(stroke, has); });
  // These first that decide which other keys apply.
  for (const bool first : {true, false}) {
    for (const StrokeKey& key : tool.keys(stroke)) {
      if (decides(key) == first) read_key(key, line, place);
    }
  }
}

double read_strength(const JsonValue& value) {
  const double strength = value.number();
  if (!(strength >= 0 && strength <= kMaxStrength)) value.fail(fmt::format("a number from 0 to {}", kMaxStrength));
  return strength;
}

MirrorPlane read_plane(const JsonValue& value, const Place& place) {
  if (!value.json().is_object()) value.fail(R"(a text such as "x" or "xz", or planes {"normal": ..., "point": ...})");
  const JsonObject object(value, place, "a plane of \"mirror\"");
  object.allow({"normal", "point"});
  MirrorPlane plane{object.vector("normal")};
  if (object.has("point")) plane.point = object.vector("point");
  return plane;
}

Mirror read_mirror(const JsonValue& value, const Place& place) {
  Mirror mirror;
  at_place(place, "", [&] {
    if (value.is_text()) {
      mirror = coordinate_mirror(value.text());
    } else if (value.json().is_array()) {
      for (const JsonValue& item : value.items()) mirror.push_back(read_plane(item, place));
      if (mirror.empty()) value.fail("1 to 3 planes");
    } else {
      mirror = {read_plane(value, place)};
    }
    validate(mirror);
  });
  return mirror;
}

// What is known to be wrong with the images before the stroke begins.
void check_images(const SessionStroke& stroke, const Place& place) {
  at_place(place, "", [&] {
    if (!reads_surface(stroke.stroke)) flow_of(stroke.stroke, stroke.mirror);
  });
}

// The keys that the strokes of every tool may have.
void read_common_keys(const JsonObject& line, const Place& place, SessionStroke& stroke) {
  if (line.has("name")) stroke.name = line.at("name").text();
  if (line.has("off")) stroke.off = line.at("off").flag();
  if (line.has("new_entry")) stroke.new_entry = line.at("new_entry").flag();
  if (line.has("duration")) {
    constexpr double most = 1e9;  // sums of many stay numbers
    stroke.duration = line.number("duration");
    if (!(stroke.duration > 0 && stroke.duration <= most)) line.at("duration").fail("a number above 0, at most 1e9");
  }
  if (line.has("mirror")) {
    stroke.mirror = read_mirror(line.at("mirror"), place);
    check_images(stroke, place);
  }
  if (!line.has("strength")) return;
  stroke.strength = read_strength(line.at("strength"));
  at_place(place, "\"strength\" asks for too much: ", [&] {
    if (stroke.strength > 1) prolonged(stroke.stroke, stroke.strength);
  });
}

SessionStroke read_as(const Tool& tool, const JsonObject& object, const Place& place) {
  SessionStroke result{tool.start, place.line};
  read_keys(tool, object, place, result.stroke);
  at_place(place, "", [&] { validate(result.stroke); });
  read_common_keys(object, place, result);
  return result;
}

}  // namespace

std::optional<Json> parse_line(std::string_view line, const Place& place) {
  try {
    return parse_json(line);
  } catch (const JsonError& error) {
    if (error.kind() == JsonError::Kind::incomplete) return std::nullopt;
    throw InvalidInput(place, complaint(error));
  }
}

SessionStroke read_stroke(const JsonValue& line, const Place& place) {
  const Tool& tool = tool_at(JsonObject(line, place, "a stroke").at("tool"));
  return read_as(tool, JsonObject(line, place, fmt::format("tool \"{}\"", tool.name)), place);
}

const Tool* event_tool(const JsonObject& line) {
  const auto all = tools();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Tool* tool) { return tool->is_event && line.has(tool->name); });
  return found == all.end() ? nullptr : *found;
}

SessionStroke read_event_stroke(const Tool& tool, const JsonValue& value, const Place& place) {
  Stroke start = tool.start;
  const std::vector<StrokeKey> keys = tool.keys(start);
  const bool may_be_null =
      std::none_of(keys.begin(), keys.end(), [](const StrokeKey& key) { return key.presence == Presence::required; });
  if (may_be_null && value.json().is_null()) return {std::move(start), place.line};
  if (!value.json().is_object()) value.fail(may_be_null ? "null, or an object {...}" : "an object {...}");
  return read_as(tool, JsonObject(value, place, fmt::format("\"{}\"", tool.name)), place);
}

std::optional<RemeshSettings> read_remesh(const JsonValue& value, const Place& place) {
  if (value.json().is_null()) return std::nullopt;
  if (!value.json().is_object()) value.fail("null, or an object {...}");
  const JsonObject object(value, place, "a remesh event");
  object.allow({"max_edge", "max_angle_deg", "max_chord", "min_edge", "iterations", "max_vertices"});
  RemeshSettings settings;
  settings.max_edge = object.optional_number("max_edge");
  settings.max_angle_deg = object.optional_number("max_angle_deg");
  settings.max_chord = object.optional_number("max_chord");
  settings.min_edge = object.optional_number("min_edge");
  if (object.has("iterations")) settings.iterations = static_cast<int>(object.at("iterations").integer());
  if (object.has("max_vertices")) {
    settings.max_vertices = static_cast<std::size_t>(std::max(0LL, object.at("max_vertices").integer()));
  }
  at_place(place, value.name() + " ", [&] { validate(settings); });
  return settings;
}

}  // namespace knead::detail
