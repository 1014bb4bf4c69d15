// Functions of strokes of every tool, by the rows of the tools.
#include "knead/stroke.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <tuple>

#include "knead/error.h"
#include "strokes/describe.h"

namespace knead {

namespace {

using namespace detail;

// Returns the public description of a row.
template <class S>
Tool described(const ToolRow<S>& row) {
  Tool tool{row.name, S{}, row.is_flow, row.is_event, {}, {}};
  tool.keys = [&row](Stroke& stroke) {
    S& own = std::get<S>(stroke);
    std::vector<StrokeKey> keys = row.keys(own);
    if constexpr (kBlends<S>) {
      const Quantity quantity = kMayBeWide<S> ? Quantity::wide_falloff : Quantity::falloff;
      keys.push_back({"falloff", quantity, &own.falloff, Presence::optional});
    }
    return keys;
  };
  tool.prepare = [&row](Stroke& stroke, const HasKey& has) {
    if constexpr (kMayBeWide<S>) {
      if (has("bump") && has("falloff")) std::get<S>(stroke).falloff = kWideFalloff;
    }
    if (row.prepare != nullptr) row.prepare(std::get<S>(stroke), has);
  };
  return tool;
}

template <class... S>
std::span<const Tool* const> described_tools(std::variant<S...>* /*type only*/) {
  static const std::array<Tool, sizeof...(S)> kTools{described(S::tool)...};
  static const auto kPointers = std::apply([](const auto&... tool) { return std::array{&tool...}; }, kTools);
  return kPointers;
}

// Checks one value by the quantity that it is. (Pointers to const would lose against the template below.)
struct Check {
  const StrokeKey& key;

  // NOLINTBEGIN(readability-non-const-parameter)
  void operator()(double* number) const {
    if (key.quantity == Quantity::finite || key.quantity == Quantity::rate) require_finite(key.name, *number);
    if (key.quantity == Quantity::positive) require_positive(key.name, *number);
    if (key.quantity == Quantity::angle) require_angle(key.name, *number);
  }
  void operator()(int* number) const {
    const bool is_wide = key.quantity == Quantity::wide_falloff && *number == kWideFalloff;
    if (key.quantity == Quantity::falloff || (key.quantity == Quantity::wide_falloff && !is_wide)) {
      require_falloff(key.name, *number);
    }
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

// Returns advice for a key that names vertices; empty if it names none. (Pointers to const would lose against the
// template.)
struct InsteadOfVertices {
  std::string_view key;

  std::string operator()(std::vector<std::uint32_t>* vertices) const {
    if (vertices->empty()) return "";
    return fmt::format("name points instead, with \"{}\"", key.substr(0, key.find('_')));
  }
  std::string operator()(std::vector<VertexRange>* ranges) const {
    return ranges->empty() ? "" : "name points instead, with \"points\"";
  }
  std::string operator()(std::vector<PoseItem>* items) const {
    const bool has_some = std::any_of(items->begin(), items->end(), [](const PoseItem& item) {
      const auto* part = std::get_if<PosePart>(&item);
      return part != nullptr ? !part->vertices.empty() : std::get<PosePin>(item).vertex.has_value();
    });
    return has_some ? "name points instead, with \"points\" and \"pin_point\"" : "";
  }
  std::string operator()(std::vector<PoseStiffness>* regions) const { return regions->empty() ? "" : "leave it out"; }
  template <class T>
  std::string operator()(const T& /*names no vertices*/) const {
    return "";
  }
};

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

constexpr double kThinShell = 0.9;

// Returns the greatest speed of the flow back on the equator of a translating ball's field, in units of the tool's
// speed; there v = (w + r/2 dw/dr) u.
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

std::span<const Tool* const> tools() { return described_tools(static_cast<Stroke*>(nullptr)); }

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
  Stroke copy = stroke;
  for (const StrokeKey& key : tool_of(stroke).keys(copy)) {
    if (applies(key)) std::visit(Check{key}, key.value);
  }
  with_row(stroke, [](const auto& row, const auto& own) {
    if (row.validate != nullptr) row.validate(own);
  });
}

bool reads_surface(const Stroke& stroke) {
  return with_row(stroke, [](const auto& row, const auto& own) {
    return row.reads_surface != nullptr ? row.reads_surface(own) : row.flow == nullptr;
  });
}

bool is_flow(const Stroke& stroke) { return tool_of(stroke).is_flow; }

Flow flow_of(const Stroke& stroke) {
  validate(stroke);
  if (reads_surface(stroke)) throw InvalidInput("this stroke reads the surface, so resolve it first");
  Flow flow = with_row(stroke, [](const auto& row, const auto& own) { return row.flow(own); });
  const std::optional<int> falloff = falloff_of(stroke);
  if (!falloff) return flow;
  for (Segment& segment : flow.segments) {
    for (Field& field : segment.fields) field.thresholds.falloff = *falloff;
  }
  return flow;
}

std::optional<int> falloff_of(const Stroke& stroke) {
  return with_row(stroke, []<class S>(const ToolRow<S>& row, const S& own) -> std::optional<int> {
    if constexpr (kBlends<S>) {
      if (own.falloff != kWideFalloff && (row.blends == nullptr || row.blends(own))) return own.falloff;
    }
    return std::nullopt;
  });
}

void set_falloff(Stroke& stroke, int falloff) {
  require_falloff("falloff", falloff);
  if (!falloff_of(stroke)) return;
  with_row(stroke, [&]<class S>(const ToolRow<S>& row, S& own) {
    if (row.keep_zone != nullptr) row.keep_zone(own, falloff);
    if constexpr (kBlends<S>) own.falloff = falloff;
  });
}

std::vector<std::string> warnings(const Stroke& stroke) {
  std::vector<std::string> result;
  with_row(stroke, [&](const auto& row, const auto& own) {
    if (row.warn != nullptr) row.warn(own, result);
  });
  return result;
}

std::string words_of(const Stroke& stroke, const std::string& unit) {
  return with_row(stroke, [&](const auto& row, const auto& own) {
    if (row.words != nullptr) return row.words(own, unit);
    std::string name(row.name);
    name.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(name.front())));
    return name;
  });
}

Stroke prolonged(const Stroke& stroke, double strength) {
  Stroke result = stroke;
  const bool has_changed = with_row(result, [&](const auto& row, auto& own) {
    if (row.prolong != nullptr) row.prolong(own, strength);
    return row.prolong != nullptr || multiply_angles(result, strength);
  });
  if (!has_changed) {
    throw InvalidInput(
        fmt::format("\"strength\" must be from 0 to 1 for tool \"{}\", got {}", tool_name(stroke), strength));
  }
  validate(result);
  return result;
}

namespace detail {

std::string instead_of_vertices(const StrokeKey& key) {
  return applies(key) ? std::visit(InsteadOfVertices{key.name}, key.value) : "";
}

std::size_t segments_of(const Stroke& stroke, const Mesh* mesh) {
  return with_row(stroke, [&](const auto& row, const auto& own) {
    return row.segments != nullptr ? row.segments(own, mesh) : std::size_t{1};
  });
}

std::string degrees_text(double angle) { return fmt::format("{:.0f}\u00b0", angle); }

std::string length_text(double length, const std::string& unit) {
  return fmt::format("{:.2g}{}{}", length, unit.empty() ? "" : " ", unit);
}

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

Segment transported_segment(Field field, const Vec3d& displacement, TimeLaw time_law) {
  Segment segment;
  segment.fields.push_back(std::move(field));
  segment.displacement = displacement;
  segment.time_law = time_law;
  return segment;
}

Segment resting_segment(Field field) { return transported_segment(std::move(field), {0, 0, 0}); }

void warn_of_thin_shell(const Thresholds<double>& thresholds, Warnings& warnings) {
  const auto& [inner, outer, falloff, bump] = thresholds;
  if (inner <= kThinShell * outer) return;
  warnings.push_back(
      fmt::format("\"inner\" is {:.3g} of \"outer\": beside the tool the flow runs back at {:.2g} times its speed; "
                  "make \"outer\" larger or \"inner\" smaller",
                  inner / outer, counter_flow(thresholds)));
}

}  // namespace detail

}  // namespace knead
