#include "knead/session/stroke_json.h"

#include <fmt/format.h>

#include <array>

namespace knead::session_detail {

namespace {

[[noreturn]] void fail_unavailable(const Place& place, const std::string& what) {
  throw InvalidInput(place, what +
                                " is not available in this version of knead; take the line out, or resolve the "
                                "session with a version that has it");
}

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
    line.vectors("path");
    fail_unavailable(place, R"(tool "paint" with a "path")");
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
  stroke.radius = line.optional_number("radius");
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
  stroke.radius = line.optional_number("radius");
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
    Tool{"points", as_stroke<read_points>},     Tool{"rotate", as_stroke<read_rotate>},
    Tool{"stretch", as_stroke<read_stretch>},   Tool{"twist", as_stroke<read_twist>},
    Tool{"bend", as_stroke<read_bend>},
};

const Tool& find_tool(const JsonValue& name, const Place& place) {
  const std::string text = name.text();
  for (const Tool& tool : kTools) {
    if (tool.name == text) return tool;
  }
  if (text == "stamp" || text == "handles") fail_unavailable(place, fmt::format("tool \"{}\"", text));
  std::string names;
  for (const Tool& tool : kTools) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", tool.name);
  name.fail("one of " + names);
}

}  // namespace

Stroke read_stroke(const JsonValue& line, const Place& place) {
  const Tool& tool = find_tool(JsonObject(line, place, "a stroke").at("tool"), place);
  Stroke stroke = tool.read(JsonObject(line, place, fmt::format("tool \"{}\"", tool.name)), place);
  try {
    validate(stroke);
  } catch (const InvalidInput& error) {
    throw InvalidInput(place, error.what());
  }
  return stroke;
}

}  // namespace knead::session_detail
