#include "knead/session/stroke_json.h"

#include <fmt/format.h>

#include <array>

namespace knead::session_detail {

namespace {

ImplicitStroke read_implicit(const JsonObject& line, const Place& place) {
  line.allow({"tool", "path", "inner", "outer", "region", "half_axis", "gauge", "time"});
  ImplicitStroke stroke;
  stroke.path = line.vectors("path");
  stroke.inner = line.number("inner");
  stroke.outer = line.number("outer");
  stroke.time = line.choice("time", {"swept", "blended"}) == 0 ? TimeLaw::swept : TimeLaw::blended;
  if (line.choice("region", {"ball", "capsule"}) == 1) {
    stroke.region = ImplicitRegion::capsule;
    stroke.half_axis = line.vector("half_axis");
    stroke.gauge = line.number("gauge", stroke.gauge);
    return stroke;
  }
  for (const char* key : {"half_axis", "gauge"}) {
    if (line.has(key)) throw InvalidInput(place, fmt::format("\"{}\" needs \"region\": \"capsule\"", key));
  }
  return stroke;
}

PaintSample read_sample(const JsonValue& value, const Place& place) {
  const JsonObject sample(value, place, "a sample");
  sample.allow({"point", "normal"});
  return {sample.vector("point"), sample.vector("normal")};
}

PaintStroke read_paint(const JsonObject& line, const Place& place) {
  line.allow({"tool", "outer", "depth", "samples", "path"});
  if (line.has("samples") && line.has("path")) {
    throw InvalidInput(place, R"(a paint stroke has either "samples" or "path", not both)");
  }
  PaintStroke stroke;
  stroke.outer = line.number("outer");
  stroke.depth = line.number("depth");
  if (line.has("path")) {
    stroke.path = line.vectors("path");
    if (stroke.path.empty()) line.at("path").fail("1 or more points");
    return stroke;
  }
  for (const JsonValue& item : line.at("samples").items()) stroke.samples.push_back(read_sample(item, place));
  return stroke;
}

PointsStroke read_points(const JsonObject& line, const Place& place) {
  line.allow({"tool", "points", "curves", "outer", "displacements", "exponent", "inner", "center"});
  if (!line.has("points") && !line.has("curves")) {
    throw InvalidInput(place, R"("points" or "curves" is missing; a points stroke needs one of them or both)");
  }
  PointsStroke stroke;
  if (line.has("points")) stroke.points = line.vectors("points");
  if (line.has("curves")) {
    for (const JsonValue& curve : line.at("curves").items()) stroke.curves.push_back(curve.vectors());
  }
  stroke.outer = line.number("outer");
  stroke.displacements = line.vectors("displacements");
  if (line.has("exponent")) stroke.exponent = static_cast<int>(line.at("exponent").integer());
  stroke.inner = line.number("inner", stroke.inner);
  stroke.center = line.choice("center", {"parts", "barycentre"}) == 0 ? PointsCenter::parts : PointsCenter::barycentre;
  return stroke;
}

std::vector<std::uint32_t> read_vertices(const JsonValue& list) {
  std::vector<std::uint32_t> vertices;
  for (const JsonValue& item : list.items()) {
    const long long vertex = item.integer();
    if (vertex < 0) item.fail("the number of a vertex, from 0 on");
    vertices.push_back(static_cast<std::uint32_t>(vertex));
  }
  if (vertices.empty()) list.fail("1 or more vertices");
  return vertices;
}

// A set as points at `key`, or as vertices at `vertices_key`.
void read_set(const JsonObject& line, const Place& place, const char* key, const char* vertices_key,
              std::vector<Vec3d>& points, std::vector<std::uint32_t>& vertices) {
  if (line.has(key) == line.has(vertices_key)) {
    throw InvalidInput(place, fmt::format(R"(a handles stroke has either "{}" or "{}", {})", key, vertices_key,
                                          line.has(key) ? "not both" : "got neither"));
  }
  if (line.has(key)) {
    points = line.vectors(key);
  } else {
    vertices = read_vertices(line.at(vertices_key));
  }
}

std::variant<HandlesTranslation, HandlesRotation> read_motion(const JsonValue& value, const Place& place) {
  const JsonObject motion(value, place, "the motion");
  if (motion.has("rotate")) {
    motion.allow({"rotate", "center", "angle_deg"});
    return HandlesRotation{motion.vector("rotate"), motion.vector("center"), motion.number("angle_deg")};
  }
  motion.allow({"translate"});
  return HandlesTranslation{motion.vector("translate")};
}

HandlesStroke read_handles(const JsonObject& line, const Place& place) {
  line.allow({"tool", "full", "zero", "full_vertices", "zero_vertices", "motion", "exponent"});
  HandlesStroke stroke;
  read_set(line, place, "full", "full_vertices", stroke.full, stroke.full_vertices);
  read_set(line, place, "zero", "zero_vertices", stroke.zero, stroke.zero_vertices);
  stroke.motion = read_motion(line.at("motion"), place);
  if (line.has("exponent")) stroke.exponent = static_cast<int>(line.at("exponent").integer());
  return stroke;
}

StampStroke read_stamp(const JsonObject& line, const Place& /*place*/) {
  line.allow({"tool", "mesh", "path", "pose", "outer", "step", "exponent"});
  StampStroke stroke;
  stroke.mesh = line.at("mesh").text();
  stroke.path = line.vectors("path");
  if (line.has("pose")) {
    const std::vector<Vec3d> rows = line.vectors("pose");
    if (rows.size() != 3) line.at("pose").fail("a 3x3 matrix: three rows of three numbers");
    stroke.pose = {rows[0], rows[1], rows[2]};
  }
  stroke.outer = line.optional_number("outer");
  stroke.step = line.optional_number("step");
  if (line.has("exponent")) stroke.exponent = static_cast<int>(line.at("exponent").integer());
  return stroke;
}

// "radius": a number, or "auto".
void read_radius(const JsonObject& line, std::optional<double>& radius, bool& automatic) {
  if (!line.has("radius")) return;
  const JsonValue value = line.at("radius");
  automatic = value.json().is_text() && value.text() == "auto";
  if (automatic) return;
  if (!value.json().is_number()) value.fail("a number, or \"auto\"");
  radius = value.number();
}

RotateStroke read_rotate(const JsonObject& line, const Place& /*place*/) {
  line.allow({"tool", "center", "axis", "angle_deg", "inner", "outer", "gauge"});
  return {line.vector("center"), line.vector("axis"),  line.number("angle_deg"),
          line.number("inner"),  line.number("outer"), line.number("gauge", RotateStroke{}.gauge)};
}

StretchStroke read_stretch(const JsonObject& line, const Place& /*place*/) {
  line.allow({"tool", "center", "axis", "factor", "inner", "outer"});
  return {line.vector("center"), line.vector("axis"), line.number("factor"), line.number("inner"),
          line.number("outer")};
}

TwistStroke read_twist(const JsonObject& line, const Place& /*place*/) {
  line.allow({"tool", "center", "axis", "rate_deg", "inner", "outer", "normal", "gauge", "radius"});
  TwistStroke stroke;
  stroke.center = line.vector("center");
  stroke.axis = line.vector("axis");
  stroke.rate_deg = line.number("rate_deg");
  stroke.inner = line.number("inner");
  stroke.outer = line.number("outer");
  if (line.has("normal")) stroke.normal = line.vector("normal");
  stroke.gauge = line.number("gauge", stroke.gauge);
  read_radius(line, stroke.radius, stroke.radius_auto);
  return stroke;
}

std::variant<BendWidth, Thresholds<double>> read_extent(const JsonObject& line, const Place& place) {
  const bool by_width = line.has("width") || line.has("center_fraction");
  const bool by_thresholds = line.has("inner") || line.has("outer");
  if (by_width == by_thresholds) {
    throw InvalidInput(place,
                       std::string(R"(a bend has either "width" (and "center_fraction") or "inner" and "outer", )") +
                           (by_width ? "not both" : "got neither"));
  }
  if (by_thresholds) return Thresholds<double>{line.number("inner"), line.number("outer")};
  return BendWidth{line.number("width"), line.number("center_fraction", kCenterFraction)};
}

BendStroke read_bend(const JsonObject& line, const Place& place) {
  line.allow({"tool", "center", "axis", "normal", "angle_deg", "width", "center_fraction", "inner", "outer", "gauge",
              "radius"});
  BendStroke stroke;
  stroke.center = line.vector("center");
  stroke.axis = line.vector("axis");
  stroke.normal = line.vector("normal");
  stroke.angle_deg = line.number("angle_deg");
  stroke.extent = read_extent(line, place);
  stroke.gauge = line.number("gauge", stroke.gauge);
  read_radius(line, stroke.radius, stroke.radius_auto);
  return stroke;
}

struct Tool {
  std::string_view name;
  Stroke (*read)(const JsonObject& line, const Place& place);
};

template <auto read>
Stroke as_stroke(const JsonObject& line, const Place& place) {
  return read(line, place);
}

constexpr std::array kTools{
    Tool{"implicit", as_stroke<read_implicit>}, Tool{"paint", as_stroke<read_paint>},
    Tool{"points", as_stroke<read_points>},     Tool{"handles", as_stroke<read_handles>},
    Tool{"stamp", as_stroke<read_stamp>},       Tool{"rotate", as_stroke<read_rotate>},
    Tool{"stretch", as_stroke<read_stretch>},   Tool{"twist", as_stroke<read_twist>},
    Tool{"bend", as_stroke<read_bend>},
};

const Tool& find_tool(const JsonValue& name) {
  const std::string text = name.text();
  for (const Tool& tool : kTools) {
    if (tool.name == text) return tool;
  }
  std::string names;
  for (const Tool& tool : kTools) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", tool.name);
  name.fail("one of " + names);
}

}  // namespace

Stroke read_stroke(const JsonValue& line, const Place& place) {
  const Tool& tool = find_tool(JsonObject(line, place, "a stroke").at("tool"));
  Stroke stroke = tool.read(JsonObject(line, place, fmt::format("tool \"{}\"", tool.name)), place);
  try {
    validate(stroke);
  } catch (const InvalidInput& error) {
    throw InvalidInput(place, error.what());
  }
  return stroke;
}

std::optional<RemeshSettings> read_remesh(const JsonValue& value, const Place& place) {
  if (value.json().is_null()) return std::nullopt;
  if (!value.json().is_object()) value.fail("null, or an object {...}");
  const JsonObject object(value, place, "a remesh event");
  object.allow({"max_edge", "max_angle_deg", "max_chord", "min_edge", "iterations"});
  RemeshSettings settings;
  settings.max_edge = object.optional_number("max_edge");
  settings.max_angle_deg = object.optional_number("max_angle_deg");
  settings.max_chord = object.optional_number("max_chord");
  settings.min_edge = object.optional_number("min_edge");
  if (object.has("iterations")) settings.iterations = static_cast<int>(object.at("iterations").integer());
  try {
    validate(settings);
  } catch (const InvalidInput& error) {
    throw InvalidInput(place, fmt::format("{} {}", value.name(), error.what()));
  }
  return settings;
}

}  // namespace knead::session_detail
