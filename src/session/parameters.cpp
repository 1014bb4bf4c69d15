// Parameters of a session: how the header gives them, and where strokes name them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "session/stroke_json.h"

namespace knead::detail {

namespace {

constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
constexpr std::string_view kDigits = "0123456789";

bool is_parameter_name(std::string_view name) {
  const auto is_in = [](std::string_view set, char c) { return set.find(c) != std::string_view::npos; };
  return !name.empty() && !is_in(kDigits, name[0]) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return is_in(kLetters, c) || is_in(kDigits, c); });
}

void require_within_bounds(const Parameter& parameter, const Place& place) {
  const auto& [name, value, least, greatest] = parameter;
  const bool is_within = std::isfinite(value) && !(least && value < *least) && !(greatest && value > *greatest);
  if (is_within) return;
  std::string range = "a finite number";
  if (least && greatest) {
    range = fmt::format("from {} to {}", *least, *greatest);
  } else if (least) {
    range = fmt::format("at least {}", *least);
  } else if (greatest) {
    range = fmt::format("at most {}", *greatest);
  }
  throw InvalidInput(place, fmt::format("parameter \"{}\" must be {}, got {}", name, range, value));
}

const Parameter& named(std::string_view name, std::span<const Parameter> parameters, const Place& place) {
  const auto is_it = [&](const Parameter& parameter) { return parameter.name == name; };
  const auto found = std::find_if(parameters.begin(), parameters.end(), is_it);
  if (found != parameters.end()) return *found;
  std::string known;
  for (const Parameter& parameter : parameters) {
    known += fmt::format("{}\"{}\"", known.empty() ? "the session has " : ", ", parameter.name);
  }
  if (known.empty()) known = "the session has none: its first line needs the key \"parameters\"";
  throw InvalidInput(place,
                     fmt::format("no parameter {}; {}", to_text(Json(std::string(name)), {.ascii = true}), known));
}

// Texts at these keys are no numbers.
bool holds_text(std::string_view key) { return key == "tool" || key == "name" || key == "mesh"; }

bool names_parameter(const Json& json) {
  if (json.is_array()) return std::any_of(json.items().begin(), json.items().end(), names_parameter);
  if (!json.is_object()) return json.is_text() && json.text().starts_with('$');
  return std::any_of(json.members().begin(), json.members().end(),
                     [](const JsonMember& member) { return !holds_text(member.key) && names_parameter(member.value); });
}

Json with_numbers(const Json& json, std::span<const Parameter> parameters, const Place& place) {
  if (!names_parameter(json)) return json;
  if (json.is_text()) return Json(named(std::string_view(json.text()).substr(1), parameters, place).value);
  if (json.is_array()) {
    std::vector<Json> items;
    for (const Json& item : json.items()) items.push_back(with_numbers(item, parameters, place));
    return Json(std::move(items));
  }
  Json object = Json::object();
  for (const auto& [key, value] : json.members()) {
    object.set(key, holds_text(key) ? value : with_numbers(value, parameters, place));
  }
  return object;
}

// Writes a blank after each comma and colon, as session files do.
std::string spaced_text(const Json& json) {
  std::string text;
  if (json.is_array()) {
    for (const Json& item : json.items()) text += (text.empty() ? "" : ", ") + spaced_text(item);
    return "[" + text + "]";
  }
  if (!json.is_object()) return to_text(json);
  for (const auto& [key, value] : json.members()) {
    text += (text.empty() ? "" : ", ") + to_text(Json(key)) + ": " + spaced_text(value);
  }
  return "{" + text + "}";
}

}  // namespace

std::vector<Parameter> read_parameters(const JsonValue& value, const Place& place) {
  const JsonObject object(value, place, "\"parameters\"");
  std::vector<Parameter> parameters;
  for (const auto& [key, member] : value.json().members()) {
    const JsonValue given = object.at(key);
    if (!is_parameter_name(key)) {
      throw InvalidInput(place, fmt::format("{} is no name of a parameter; use letters, digits and underscores, and no "
                                            "digit first",
                                            to_text(Json(key), {.ascii = true})));
    }
    Parameter& parameter = parameters.emplace_back(Parameter{key});
    if (given.is_number()) {
      parameter.value = given.number();
    } else {
      if (!member.is_object()) given.fail(R"(a number, or {"value": ..., "min": ..., "max": ...})");
      const JsonObject bounded(given, place, "a parameter");
      bounded.allow({"value", "min", "max"});
      parameter.value = bounded.number("value");
      parameter.least = bounded.optional_number("min");
      parameter.greatest = bounded.optional_number("max");
    }
    if (parameter.least && parameter.greatest && *parameter.least > *parameter.greatest) {
      throw InvalidInput(place, fmt::format("parameter \"{}\": \"min\" must not be above \"max\", got {} and {}", key,
                                            *parameter.least, *parameter.greatest));
    }
    require_within_bounds(parameter, place);
  }
  return parameters;
}

std::vector<Parameter> changed(std::vector<Parameter> parameters, const ParameterValues& values, const Place& place) {
  for (const auto& [name, value] : values) {
    const auto index = static_cast<std::size_t>(&named(name, parameters, place) - parameters.data());
    parameters[index].value = value;
    require_within_bounds(parameters[index], place);
  }
  return parameters;
}

FilledLine fill_in(const Json& line, std::span<const Parameter> parameters, const Place& place) {
  FilledLine filled{line, {}};
  if (!line.is_object() || !names_parameter(line)) return filled;
  const bool is_event = !line.has("tool") && line.members().size() == 1 && line.members().front().value.is_object();
  const Json& stroke = is_event ? line.members().front().value : line;
  for (const auto& [key, value] : stroke.members()) {
    if (!holds_text(key) && names_parameter(value)) filled.uses.push_back({key, spaced_text(value), ""});
  }
  filled.line = with_numbers(line, parameters, place);
  return filled;
}

}  // namespace knead::detail
