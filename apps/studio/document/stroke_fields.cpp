#include "document/stroke_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

namespace knead::studio {

namespace {

// Calls visit(name, help, number) for each of a stroke's numbers.
template <class Stroke, class Visit>
void visit_thresholds(Stroke& stroke, const Visit& visit) {
  visit("inner", "what is nearer moves as a whole", stroke.inner);
  visit("outer", "what is farther does not move", stroke.outer);
}

template <class Visit>
struct FieldVisitor {
  const Visit& visit;

  void operator()(ImplicitStroke& stroke) const { visit_thresholds(stroke, visit); }
  void operator()(PaintStroke& stroke) const {
    visit("outer", "the radius of a dab", stroke.outer);
    visit("depth", "how far a dab moves the surface; negative pulls out", stroke.depth);
  }
  void operator()(PointsStroke& stroke) const { visit_thresholds(stroke, visit); }
  void operator()(HandlesStroke& stroke) const {
    if (auto* turn = std::get_if<HandlesRotation>(&stroke.motion)) visit("angle_deg", "of the turn", turn->angle_deg);
  }
  void operator()(StampStroke& stroke) const {
    if (stroke.outer) visit("outer", "how far below the contact it reaches", *stroke.outer);
  }
  void operator()(RotateStroke& stroke) const {
    visit("angle_deg", "that the inner region turns", stroke.angle_deg);
    visit_thresholds(stroke, visit);
  }
  void operator()(StretchStroke& stroke) const {
    visit("factor", "longer along the axis; below 1 shorter", stroke.factor);
    visit_thresholds(stroke, visit);
  }
  void operator()(TwistStroke& stroke) const {
    visit("rate_deg", "degrees for one unit of length", stroke.rate_deg);
    visit_thresholds(stroke, visit);
    if (stroke.radius) visit("radius", "of the barrel", *stroke.radius);
  }
  void operator()(BendStroke& stroke) const {
    visit("angle_deg", "that the part turns", stroke.angle_deg);
    if (auto* width = std::get_if<BendWidth>(&stroke.extent)) {
      visit("width", "of the zone that is bent", width->width);
    } else {
      auto& thresholds = std::get<Thresholds<double>>(stroke.extent);
      visit("inner", "where the moved side begins", thresholds.inner);
      visit("outer", "where the still side begins", thresholds.outer);
    }
    if (stroke.radius) visit("radius", "of the barrel", *stroke.radius);
  }
};

template <class Visit>
void visit_fields(Stroke& stroke, const Visit& visit) {
  std::visit(FieldVisitor<Visit>{visit}, stroke);
}

}  // namespace

std::vector<StrokeField> fields_of(std::span<const SessionStroke> strokes) {
  std::vector<StrokeField> fields;
  for (const SessionStroke& one : strokes) {
    Stroke stroke = one.stroke;
    visit_fields(stroke, [&](const char* name, const char* help, double& value) {
      const bool known =
          std::any_of(fields.begin(), fields.end(), [&](const auto& field) { return field.name == name; });
      if (!known) fields.push_back({name, help, value});
    });
  }
  return fields;
}

void set_field(std::span<SessionStroke> strokes, const std::string& name, double value) {
  bool is_first = true;
  double factor = 1;
  for (SessionStroke& one : strokes) {
    visit_fields(one.stroke, [&](const char* own_name, const char* /*help*/, double& own) {
      if (own_name != name) return;
      if (is_first) factor = own == 0 ? 1 : value / own;
      own = is_first ? value : own * factor;
      is_first = false;
    });
  }
}

std::string description_of(std::span<const SessionStroke> strokes) {
  if (strokes.empty()) return "nothing";
  const Stroke& first = strokes.front().stroke;
  const std::string name = tool_name(first);
  std::string text = strokes.size() == 1 ? name : fmt::format("{} x {}", strokes.size(), name);
  if (const auto* implicit = std::get_if<ImplicitStroke>(&first)) {
    const std::size_t pieces = implicit->path.size() - 1;
    text += pieces == 1 ? ", 1 piece" : fmt::format(", {} pieces", pieces);
  } else if (const auto* paint = std::get_if<PaintStroke>(&first)) {
    text += fmt::format(", {} dabs", paint->samples.size() + paint->path.size());
  }
  return text;
}

}  // namespace knead::studio
