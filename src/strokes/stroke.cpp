#include "knead/stroke.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "knead/error.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace tool_detail;

template <class... S>
std::array<const Tool*, sizeof...(S)> tools_of(std::variant<S...>* /*type only*/) {
  return {&S::tool()...};
}

// Checks one value by what it means. (Pointers to const would lose against the template below.)
struct Check {
  const StrokeKey& key;

  // NOLINTBEGIN(readability-non-const-parameter)
  void operator()(double* number) const {
    if (key.quantity == Quantity::finite || key.quantity == Quantity::rate) require_finite(key.name, *number);
    if (key.quantity == Quantity::positive) require_positive(key.name, *number);
    if (key.quantity == Quantity::angle) require_angle(key.name, *number);
  }
  void operator()(int* number) const {
    if (key.quantity == Quantity::falloff) require_falloff(key.name, *number);
  }
  // NOLINTEND(readability-non-const-parameter)
  void operator()(std::optional<double>* number) const {
    if (*number) (*this)(&**number);
  }
  void operator()(const AutoNumber& number) const {
    (*this)(number.value);
    if (*number.value && *number.is_auto) {
      throw InvalidInput(fmt::format("\"{}\" must be a number or \"auto\", not both", key.name));
    }
  }
  void operator()(Vec3d* vector) const {
    if (key.quantity == Quantity::finite) require_finite(key.name, *vector);
    if (key.quantity == Quantity::direction) require_direction(key.name, *vector);
  }
  void operator()(std::optional<Vec3d>* vector) const {
    if (*vector) (*this)(&**vector);
  }
  void operator()(std::vector<Vec3d>* list) const { require_finite(key.name, *list); }
  void operator()(std::vector<double>* list) const {
    for (double& number : *list) (*this)(&number);
  }
  void operator()(Mat3d* m) const {
    for (const Vec3d& row : {m->row0, m->row1, m->row2}) require_finite(key.name, row);
  }
  template <class T>
  void operator()(const T& /*by the tool itself*/) const {}
};

}  // namespace

std::span<const Tool* const> tools() {
  static const auto kTools = tools_of(static_cast<Stroke*>(nullptr));
  return kTools;
}

const Tool& tool_of(const Stroke& stroke) { return *tools()[stroke.index()]; }

const Tool* find_tool(std::string_view name) {
  const auto all = tools();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Tool* tool) { return tool->name == name; });
  return found == all.end() ? nullptr : *found;
}

bool applies(const StrokeKey& key) {
  return std::visit(
      [](const auto& value) {
        if constexpr (std::is_pointer_v<std::decay_t<decltype(value)>>) {
          return value != nullptr;
        } else {
          return true;
        }
      },
      key.value);
}

std::string tool_name(const Stroke& stroke) { return std::string(tool_of(stroke).name); }

void validate(const Stroke& stroke) {
  const Tool& tool = tool_of(stroke);
  Stroke copy = stroke;
  for (const StrokeKey& key : tool.keys(copy)) {
    if (applies(key)) std::visit(Check{key}, key.value);
  }
  tool.validate(stroke);
}

bool reads_surface(const Stroke& stroke) { return tool_of(stroke).reads_surface(stroke); }

bool is_flow(const Stroke& stroke) { return tool_of(stroke).is_flow; }

Flow flow_of(const Stroke& stroke) {
  validate(stroke);
  if (reads_surface(stroke)) throw InvalidInput("this stroke reads the surface, so resolve it first");
  Flow flow = tool_of(stroke).flow(stroke);
  const std::optional<int> falloff = falloff_of(stroke);
  if (!falloff) return flow;
  for (Segment& segment : flow.segments) {
    for (Field& field : segment.fields) field.thresholds.falloff = *falloff;
  }
  return flow;
}

std::optional<int> falloff_of(const Stroke& stroke) {
  return std::visit(
      []<class S>(const S& own) -> std::optional<int> {
        if constexpr (std::is_same_v<S, StampStroke>) {
          if (contact_of(own) == StampContact::slip) return std::nullopt;
        }
        if constexpr (kBlends<S>) {
          return own.falloff;
        } else {
          return std::nullopt;
        }
      },
      stroke);
}

void set_falloff(Stroke& stroke, int falloff) {
  require_falloff("falloff", falloff);
  if (!falloff_of(stroke)) return;
  std::visit(
      [&]<class S>(S& own) {
        if constexpr (std::is_same_v<S, BendStroke>) move_center(own, falloff);
        if constexpr (kBlends<S>) own.falloff = falloff;
      },
      stroke);
}

std::vector<std::string> warnings(const Stroke& stroke) {
  std::vector<std::string> result;
  tool_of(stroke).warn(stroke, result);
  return result;
}

namespace {

// Multiplies the angles of a stroke. Returns false if it has none.
bool multiply_angles(Stroke& stroke, double factor) {
  bool has_angle = false;
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    auto* const* angle = std::get_if<double*>(&key.value);
    const bool is_angle = key.quantity == Quantity::angle || key.quantity == Quantity::rate;
    if (!is_angle || angle == nullptr || *angle == nullptr) continue;
    **angle *= factor;
    has_angle = true;
  }
  return has_angle;
}

}  // namespace

Stroke prolonged(const Stroke& stroke, double strength) {
  Stroke result = stroke;
  const Tool& tool = tool_of(result);
  if (tool.prolong) {
    tool.prolong(result, strength);
  } else if (!multiply_angles(result, strength)) {
    throw InvalidInput(fmt::format("\"strength\" must be from 0 to 1 for tool \"{}\", got {}", tool.name, strength));
  }
  validate(result);
  return result;
}

namespace tool_detail {

void prolong_path(std::vector<Vec3d>& path, double strength) {
  double length = 0;
  Vec3d direction{0, 0, 0};
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec3d piece = path[i + 1] - path[i];
    if (piece == Vec3d{0, 0, 0}) continue;
    direction = unit(piece);
    length += norm(piece);
  }
  if (length > 0) path.push_back(path.back() + direction * ((strength - 1) * length));
}

namespace {

constexpr double kThinShell = 0.9;

// How fast, in units of the tool's speed, a translating ball's field flows back on its equator, where
// v = (w + r/2 dw/dr) u.
double counter_flow(const Thresholds<double>& thresholds) {
  constexpr int kSamples = 1000;
  double least = 0;
  for (int i = 0; i <= kSamples; ++i) {
    const double r = thresholds.inner + (thresholds.outer - thresholds.inner) * i / kSamples;
    const Weight<double> w = blend_weight(r, thresholds);
    least = std::min(least, w.value + 0.5 * r * w.derivative);
  }
  return -least;
}

}  // namespace

Segment transported_segment(Field field, const Vec3d& displacement, TimeLaw time_law) {
  Segment segment;
  segment.fields.push_back(std::move(field));
  segment.displacement = displacement;
  segment.time_law = time_law;
  return segment;
}

Segment resting_segment(Field field) { return transported_segment(std::move(field), {0, 0, 0}); }

void warn_of_thin_shell(const Thresholds<double>& thresholds, Warnings& warnings) {
  const auto& [inner, outer, falloff] = thresholds;
  if (inner <= kThinShell * outer) return;
  warnings.push_back(
      fmt::format("\"inner\" is {:.3g} of \"outer\": beside the tool the flow runs back at {:.2g} times its speed; "
                  "make \"outer\" larger or \"inner\" smaller",
                  inner / outer, counter_flow(thresholds)));
}

}  // namespace tool_detail

}  // namespace knead
