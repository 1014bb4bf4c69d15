#include <fmt/format.h>

#include <cmath>
#include <span>

#include "knead/io/json.h"
#include "knead/session/session.h"

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

std::string text_of(std::uint32_t value) { return fmt::format("{}", value); }

template <class T>
std::string text_of(const std::vector<T>& items) {
  std::string result = "[";
  for (const T& item : items) {
    if (result.size() > 1) result += ", ";
    result += text_of(item);
  }
  return result + "]";
}

// One JSON object on one line.
class LineWriter {
 public:
  template <class T>
  void add(const char* key, const T& value) {
    line_ += fmt::format("{}\"{}\": {}", line_.empty() ? "{" : ", ", key, text_of(value));
  }

  template <class T>
  void add_unless(const T& otherwise, const char* key, const T& value) {
    if (text_of(value) != text_of(otherwise)) add(key, value);  // -0 is not 0
  }

  template <class T>
  void add_optional(const char* key, const std::optional<T>& value) {
    if (value) add(key, *value);
  }

  void add_radius(const std::optional<double>& radius, bool automatic) {
    add_optional("radius", radius);
    if (automatic) add("radius", std::string("auto"));
  }

  std::string finish() const { return line_.empty() ? "{}" : line_ + "}"; }

 private:
  std::string line_;
};

void write(const ImplicitStroke& stroke, LineWriter& line) {
  line.add("path", stroke.path);
  line.add("inner", stroke.inner);
  line.add("outer", stroke.outer);
  if (stroke.region == ImplicitRegion::capsule) {
    line.add("region", std::string("capsule"));
    line.add("half_axis", stroke.half_axis);
    line.add_unless(ImplicitStroke{}.gauge, "gauge", stroke.gauge);
  }
  if (stroke.time == TimeLaw::blended) line.add("time", std::string("blended"));
}

void write(const PaintStroke& stroke, LineWriter& line) {
  line.add("outer", stroke.outer);
  line.add("depth", stroke.depth);
  if (stroke.path.empty()) {
    line.add("samples", stroke.samples);
  } else {
    line.add("path", stroke.path);
  }
}

void write(const PointsStroke& stroke, LineWriter& line) {
  if (!stroke.points.empty()) line.add("points", stroke.points);
  if (!stroke.curves.empty()) line.add("curves", stroke.curves);
  line.add("outer", stroke.outer);
  line.add("displacements", stroke.displacements);
  line.add_unless(PointsStroke{}.exponent, "exponent", stroke.exponent);
  line.add_unless(PointsStroke{}.inner, "inner", stroke.inner);
  if (stroke.center == PointsCenter::barycentre) line.add("center", std::string("barycentre"));
}

// An object within the line.
struct ObjectText {
  std::string text;
};
std::string text_of(const ObjectText& object) { return object.text; }

ObjectText object_of(const HandlesTranslation& motion) {
  LineWriter object;
  object.add("translate", motion.by);
  return {object.finish()};
}

ObjectText object_of(const HandlesRotation& motion) {
  LineWriter object;
  object.add("rotate", motion.axis);
  object.add("center", motion.center);
  object.add("angle_deg", motion.angle_deg);
  return {object.finish()};
}

ObjectText object_of(const std::optional<RemeshSettings>& settings) {
  if (!settings) return {"null"};
  LineWriter object;
  object.add_optional("max_edge", settings->max_edge);
  object.add_optional("max_angle_deg", settings->max_angle_deg);
  object.add_optional("max_chord", settings->max_chord);
  object.add_optional("min_edge", settings->min_edge);
  object.add_optional("iterations", settings->iterations);
  return {object.finish()};
}

void write(const HandlesStroke& stroke, LineWriter& line) {
  if (stroke.full_vertices.empty()) line.add("full", stroke.full);
  if (!stroke.full_vertices.empty()) line.add("full_vertices", stroke.full_vertices);
  if (stroke.zero_vertices.empty()) line.add("zero", stroke.zero);
  if (!stroke.zero_vertices.empty()) line.add("zero_vertices", stroke.zero_vertices);
  line.add("motion", std::visit([](const auto& motion) { return object_of(motion); }, stroke.motion));
  line.add_unless(HandlesStroke{}.exponent, "exponent", stroke.exponent);
}

void write(const StampStroke& stroke, LineWriter& line) {
  line.add("mesh", stroke.mesh);
  line.add("path", stroke.path);
  if (!(stroke.pose == Mat3d{}))
    line.add("pose", std::vector<Vec3d>{stroke.pose.row0, stroke.pose.row1, stroke.pose.row2});
  line.add_optional("outer", stroke.outer);
  line.add_optional("step", stroke.step);
  line.add_unless(StampStroke{}.exponent, "exponent", stroke.exponent);
}

void write(const RotateStroke& stroke, LineWriter& line) {
  line.add("center", stroke.center);
  line.add("axis", stroke.axis);
  line.add("angle_deg", stroke.angle_deg);
  line.add("inner", stroke.inner);
  line.add("outer", stroke.outer);
  line.add_unless(RotateStroke{}.gauge, "gauge", stroke.gauge);
}

void write(const StretchStroke& stroke, LineWriter& line) {
  line.add("center", stroke.center);
  line.add("axis", stroke.axis);
  line.add("factor", stroke.factor);
  line.add("inner", stroke.inner);
  line.add("outer", stroke.outer);
}

void write(const TwistStroke& stroke, LineWriter& line) {
  line.add("center", stroke.center);
  line.add("axis", stroke.axis);
  line.add("rate_deg", stroke.rate_deg);
  line.add("inner", stroke.inner);
  line.add("outer", stroke.outer);
  line.add_optional("normal", stroke.normal);
  line.add_unless(TwistStroke{}.gauge, "gauge", stroke.gauge);
  line.add_radius(stroke.radius, stroke.radius_auto);
}

void write(const BendStroke& stroke, LineWriter& line) {
  line.add("center", stroke.center);
  line.add("axis", stroke.axis);
  line.add("normal", stroke.normal);
  line.add("angle_deg", stroke.angle_deg);
  if (const auto* extent = std::get_if<BendWidth>(&stroke.extent)) {
    line.add("width", extent->width);
    line.add_unless(kCenterFraction, "center_fraction", extent->center_fraction);
  } else {
    const auto& thresholds = std::get<Thresholds<double>>(stroke.extent);
    line.add("inner", thresholds.inner);
    line.add("outer", thresholds.outer);
  }
  line.add_unless(BendStroke{}.gauge, "gauge", stroke.gauge);
  line.add_radius(stroke.radius, stroke.radius_auto);
}

}  // namespace

std::string header_line(const std::optional<std::string>& mesh, const std::optional<std::string>& note) {
  LineWriter line;
  line.add("knead", 1);
  line.add_optional("mesh", mesh);
  line.add_optional("note", note);
  return line.finish();
}

std::string stroke_line(const Stroke& stroke) {
  LineWriter line;
  line.add("tool", tool_name(stroke));
  std::visit([&](const auto& tool) { write(tool, line); }, stroke);
  return line.finish();
}

std::string remesh_line(const std::optional<RemeshSettings>& settings) {
  LineWriter line;
  line.add("remesh", object_of(settings));
  return line.finish();
}

std::string serialize_session(const Session& session) {
  std::string text = header_line(session.mesh, session.note) + "\n";
  std::optional<RemeshSettings> remesh;
  for (const SessionStroke& stroke : session.strokes) {
    if (stroke.remesh != remesh) text += remesh_line(stroke.remesh) + "\n";
    remesh = stroke.remesh;
    text += stroke_line(stroke.stroke) + "\n";
  }
  return text;
}

}  // namespace knead
