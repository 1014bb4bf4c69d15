#include "knead/session/json_object.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace knead::session_detail {

namespace {

constexpr std::size_t kLongestQuote = 40;

// A value for a message: as it stands where it is short, else its kind.
std::string describe(const Json& value) {
  if (value.is_array()) return fmt::format("an array of {}", value.size());
  if (value.is_object()) return "an object";
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kLongestQuote) text = text.substr(0, kLongestQuote) + "...";
  return text;
}

std::string shortened(const std::string& key) { return describe(Json(key)); }

// Goes through JSON for keys that an object has twice, and remembers the latest key for messages. What is no JSON is
// left to the parser, whose own hook would take a time that grows with the square of an array's length.
class KeyWatch : public nlohmann::json_sax<Json> {
 public:
  explicit KeyWatch(const Place& place) : place_(place) {}

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(Json::number_integer_t) override { return true; }
  bool number_unsigned(Json::number_unsigned_t) override { return true; }
  bool number_float(Json::number_float_t, const Json::string_t&) override { return true; }
  bool string(Json::string_t&) override { return true; }
  bool binary(Json::binary_t&) override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool parse_error(std::size_t, const std::string&, const Json::exception&) override { return false; }

  bool start_object(std::size_t) override {
    keys_.emplace_back();
    return true;
  }

  bool end_object() override {
    keys_.pop_back();
    return true;
  }

  bool key(Json::string_t& key) override {
    latest_ = key;
    if (keys_.back().insert(key).second) return true;
    throw InvalidInput(place_, fmt::format("the key {} is given twice; give it once", shortened(key)));
  }

  // "at \"outer\", ", or nothing before the first key.
  std::string position() const { return latest_ ? fmt::format("at {}, ", shortened(*latest_)) : ""; }

 private:
  const Place& place_;
  std::vector<std::set<std::string>> keys_;
  std::optional<std::string> latest_;
};

}  // namespace

void JsonValue::fail(const std::string& expected) const {
  throw InvalidInput(place_, fmt::format("{} must be {}, got {}", name_, expected, describe(value_)));
}

double JsonValue::number() const {
  if (!value_.is_number()) fail("a number");
  return value_.get<double>();
}

long long JsonValue::integer() const {
  constexpr double kMost = 999'999'999;
  if (!value_.is_number()) fail("a whole number");
  const double value = value_.get<double>();
  if (value != std::floor(value) || std::abs(value) > kMost) fail("a whole number of at most 9 digits");
  return static_cast<long long>(value);
}

std::string JsonValue::text() const {
  if (!value_.is_string()) fail("text in double quotes");
  return value_.get<std::string>();
}

Vec3d JsonValue::vector() const {
  const bool numbers = value_.is_array() && value_.size() == 3 &&
                       std::all_of(value_.begin(), value_.end(), [](const Json& item) { return item.is_number(); });
  if (!numbers) fail("three numbers [x, y, z]");
  return {value_[0].get<double>(), value_[1].get<double>(), value_[2].get<double>()};
}

std::vector<JsonValue> JsonValue::items() const {
  if (!value_.is_array()) fail("a list [...]");
  std::vector<JsonValue> result;
  for (std::size_t i = 0; i < value_.size(); ++i) {
    result.emplace_back(value_[i], fmt::format("{}[{}]", name_, i), place_);
  }
  return result;
}

std::vector<Vec3d> JsonValue::vectors() const {
  std::vector<Vec3d> result;
  for (const JsonValue& item : items()) result.push_back(item.vector());
  return result;
}

JsonObject::JsonObject(const JsonValue& value, const Place& place, std::string what)
    : value_(value.json()), place_(place), prefix_(value.name()), what_(std::move(what)) {
  if (!value_.is_object()) value.fail("a JSON object {...}");
}

void JsonObject::allow(std::initializer_list<std::string_view> keys) const {
  for (const auto& [key, value] : value_.items()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    throw InvalidInput(place_, fmt::format("unknown key {}; {} has the keys \"{}\"", shortened(key), what_,
                                           fmt::join(keys, "\", \"")));
  }
}

JsonValue JsonObject::at(std::string_view key) const {
  std::string name = prefix_.empty() ? fmt::format("\"{}\"", key) : fmt::format("{} \"{}\"", prefix_, key);
  const auto found = value_.find(key);
  if (found == value_.end()) throw InvalidInput(place_, fmt::format("{} is missing; {} needs it", name, what_));
  return {*found, std::move(name), place_};
}

std::optional<double> JsonObject::optional_number(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return number(key);
}

std::size_t JsonObject::choice(std::string_view key, std::initializer_list<std::string_view> choices) const {
  if (!has(key)) return 0;
  const JsonValue value = at(key);
  const auto* found =
      value.json().is_string() ? std::find(choices.begin(), choices.end(), value.text()) : choices.end();
  if (found == choices.end()) value.fail(fmt::format("one of \"{}\"", fmt::join(choices, "\", \"")));
  return static_cast<std::size_t>(found - choices.begin());
}

std::optional<Json> parse_line(std::string_view line, const Place& place) {
  KeyWatch watch(place);
  Json::sax_parse(line, &watch);
  try {
    return Json::parse(line);
  } catch (const Json::parse_error& error) {
    if (error.byte > line.size()) return std::nullopt;
    throw InvalidInput(place, fmt::format("{}column {} is not JSON; a line must be one object, with keys and text in "
                                          "double quotes and finite numbers",
                                          watch.position(), error.byte));
  } catch (const Json::out_of_range&) {
    throw InvalidInput(place, fmt::format("{}a number is too large; numbers must be finite", watch.position()));
  }
}

}  // namespace knead::session_detail
