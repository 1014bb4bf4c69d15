#include "knead/session/json_object.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace knead::session_detail {

namespace {

constexpr std::size_t kLongestQuote = 40;

// A value for a message: as it stands where it is short, else its kind.
std::string describe(const Json& value) {
  if (value.is_array()) return fmt::format("an array of {}", value.items().size());
  if (value.is_object()) return "an object";
  std::string text = to_text(value, {.ascii = true});
  if (text.size() > kLongestQuote) text = text.substr(0, kLongestQuote) + "...";
  return text;
}

std::string shortened(const std::string& key) { return describe(Json(key)); }

// Returns "at \"outer\", ", or nothing before the first key.
std::string position(const JsonError& error) {
  return error.key() ? fmt::format("at {}, ", shortened(*error.key())) : "";
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

}  // namespace

void JsonValue::fail(const std::string& expected) const {
  throw InvalidInput(place_, fmt::format("{} must be {}, got {}", name_, expected, describe(value_)));
}

double JsonValue::number() const {
  if (!value_.is_number()) fail("a number");
  return value_.number();
}

long long JsonValue::integer() const {
  constexpr double kMost = 999'999'999;
  if (!value_.is_number()) fail("a whole number");
  const double value = value_.number();
  if (value != std::floor(value) || std::abs(value) > kMost) fail("a whole number of at most 9 digits");
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
  constexpr auto is_number = [](const Json& item) { return item.is_number(); };
  if (!value_.is_array() || value_.items().size() != 3 ||
      !std::all_of(value_.items().begin(), value_.items().end(), is_number)) {
    fail("three numbers [x, y, z]");
  }
  const std::vector<Json>& numbers = value_.items();
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
    throw InvalidInput(place_, fmt::format("unknown key {}; {} has the keys \"{}\"", shortened(key), what_,
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

std::optional<Json> parse_line(std::string_view line, const Place& place) {
  try {
    return parse_json(line);
  } catch (const JsonError& error) {
    if (error.kind() == JsonError::Kind::incomplete) return std::nullopt;
    throw InvalidInput(place, complaint(error));
  }
}

}  // namespace knead::session_detail
