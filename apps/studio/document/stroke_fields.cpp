#include "document/stroke_fields.h"

#include <algorithm>
#include <string_view>
#include <variant>

#include "knead/tools.h"

namespace knead::studio {

namespace {

// Calls visit(name, help, number) for each of a stroke's numbers that a person may want to change.
template <class Visit>
void visit_fields(Stroke& stroke, const Visit& visit) {
  for (const StrokeKey& key : tool_of(stroke).keys(stroke)) {
    if (key.help.empty() || !applies(key)) continue;
    if (auto* const* number = std::get_if<double*>(&key.value)) visit(key.name, key.help, **number);
    if (auto* const* number = std::get_if<std::optional<double>*>(&key.value); number != nullptr && **number) {
      visit(key.name, key.help, ***number);
    }
    if (const auto* number = std::get_if<AutoNumber>(&key.value); number != nullptr && *number->value) {
      visit(key.name, key.help, **number->value);
    }
    if (auto* const* motion = std::get_if<HandlesMotion*>(&key.value)) {
      if (auto* turn = std::get_if<HandlesRotation>(*motion)) visit("angle_deg", key.help, turn->angle_deg);
    }
  }
}

}  // namespace

std::vector<StrokeField> fields_of(std::span<const SessionStroke> strokes) {
  std::vector<StrokeField> fields;
  for (const SessionStroke& one : strokes) {
    Stroke stroke = one.stroke;
    visit_fields(stroke, [&](std::string_view name, std::string_view help, double& value) {
      const bool known =
          std::any_of(fields.begin(), fields.end(), [&](const auto& field) { return field.name == name; });
      if (!known) fields.push_back({std::string(name), std::string(help), value});
    });
  }
  return fields;
}

void set_field(std::span<SessionStroke> strokes, const std::string& name, double value) {
  bool is_first = true;
  double factor = 1;
  for (SessionStroke& one : strokes) {
    visit_fields(one.stroke, [&](std::string_view own_name, std::string_view /*help*/, double& own) {
      if (own_name != name) return;
      if (is_first) factor = own == 0 ? 1 : value / own;
      own = is_first ? value : own * factor;
      is_first = false;
    });
  }
}

std::optional<int> falloff_of(std::span<const SessionStroke> strokes) {
  for (const SessionStroke& one : strokes) {
    if (const std::optional<int> falloff = falloff_of(one.stroke)) return falloff;
  }
  return std::nullopt;
}

void set_falloff(std::span<SessionStroke> strokes, int falloff) {
  for (SessionStroke& one : strokes) set_falloff(one.stroke, falloff);
}

}  // namespace knead::studio
