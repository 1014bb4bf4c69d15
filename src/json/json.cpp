// Reads and writes JSON with nlohmann's library.
#include "json/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

namespace knead {

// Small objects are searched from the front. Larger ones have the numbers of their members sorted by key, so that a
// hostile file with a million keys cannot make every search long.
struct Json::Object {
  static constexpr std::size_t kFew = 16;

  std::vector<JsonMember> members;
  std::vector<std::size_t> sorted;  // empty for at most kFew members

  std::vector<std::size_t>::const_iterator lower_bound(std::string_view key) const {
    return std::lower_bound(sorted.begin(), sorted.end(), key,
                            [&](std::size_t i, std::string_view k) { return members[i].key < k; });
  }

  std::optional<std::size_t> find(std::string_view key) const {
    if (sorted.empty()) {
      for (std::size_t i = 0; i < members.size(); ++i) {
        if (members[i].key == key) return i;
      }
      return std::nullopt;
    }
    const auto found = lower_bound(key);
    return found != sorted.end() && members[*found].key == key ? std::optional(*found) : std::nullopt;
  }

  void sort() {
    sorted.clear();
    if (members.size() <= kFew) return;
    for (std::size_t i = 0; i < members.size(); ++i) sorted.push_back(i);
    std::sort(sorted.begin(), sorted.end(),
              [&](std::size_t a, std::size_t b) { return members[a].key < members[b].key; });
  }

  void set(std::string_view key, Json value) {
    if (const std::optional<std::size_t> found = find(key)) {
      members[*found].value = std::move(value);
      return;
    }
    if (!sorted.empty()) sorted.insert(lower_bound(key), members.size());
    members.push_back({std::string(key), std::move(value)});
    if (sorted.empty()) sort();
  }
};

namespace {

[[noreturn]] void fail(const char* expected, const Json& json) {
  throw InvalidInput(fmt::format("expected {}, got {}", expected, described(json)));
}

std::string sentence(JsonError::Kind kind, std::size_t byte, const std::optional<std::string>& key) {
  switch (kind) {
    case JsonError::Kind::repeated_key:
      return fmt::format("the key {} is given twice; give it once", described(key.value_or("")));
    case JsonError::Kind::too_deep:
      return fmt::format("the JSON is nested deeper than {}; use fewer levels", kDeepestJson);
    case JsonError::Kind::too_large:
      return "a number is too large; numbers must be finite";
    case JsonError::Kind::incomplete:
      return "the JSON ends too early; complete it";
    case JsonError::Kind::bad_escape:
      return R"(a backslash in a text begins no escape of JSON; write / or \\ in its place)";
    case JsonError::Kind::not_json:
      break;
  }
  return fmt::format("byte {} is not JSON; keys and text stand in double quotes, numbers are finite", byte);
}

}  // namespace

Json::Json(std::string text) : value_(std::make_shared<const std::string>(std::move(text))) {}

Json::Json(std::vector<Json> items) : value_(std::make_shared<std::vector<Json>>(std::move(items))) {}

Json::Json(std::initializer_list<JsonMember> members) : Json(object()) {
  for (const JsonMember& member : members) set(member.key, member.value);
}

Json Json::object() {
  Json result;
  result.value_ = std::make_shared<Object>();
  return result;
}

bool Json::is_number() const {
  return std::holds_alternative<double>(value_) || std::holds_alternative<std::int64_t>(value_) || is_whole();
}

bool Json::flag() const {
  if (!is_flag()) fail("true or false", *this);
  return std::get<bool>(value_);
}

double Json::number() const {
  if (is_whole()) return static_cast<double>(std::get<std::uint64_t>(value_));
  if (const auto* integer = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*integer);
  if (!std::holds_alternative<double>(value_)) fail("a number", *this);
  return std::get<double>(value_);
}

std::size_t Json::whole() const {
  if (!is_whole()) fail("a whole number from 0 on", *this);
  return std::get<std::uint64_t>(value_);
}

const std::string& Json::text() const {
  if (!is_text()) fail("text in double quotes", *this);
  return *std::get<SharedText>(value_);
}

const std::vector<Json>& Json::items() const& {
  if (!is_array()) fail("a list [...]", *this);
  return *std::get<SharedItems>(value_);
}

const std::vector<JsonMember>& Json::members() const& {
  if (!is_object()) fail("an object {...}", *this);
  return std::get<SharedObject>(value_)->members;
}

const Json* Json::find(std::string_view key) const {
  if (!is_object()) return nullptr;
  const Object& object = *std::get<SharedObject>(value_);
  const std::optional<std::size_t> found = object.find(key);
  return found ? &object.members[*found].value : nullptr;
}

const Json& Json::at(std::string_view key) const {
  const Json* found = find(key);
  if (found == nullptr) throw InvalidInput(fmt::format("\"{}\" is missing", key));
  return *found;
}

void Json::set(std::string_view key, Json value) {
  if (is_null()) *this = object();
  own_object().set(key, std::move(value));
}

void Json::push_back(Json item) {
  if (is_null()) *this = array();
  own_items().push_back(std::move(item));
}

Json::Object& Json::own_object() {
  if (!is_object()) fail("an object {...}", *this);
  SharedObject& shared = std::get<SharedObject>(value_);
  if (shared.use_count() > 1) shared = std::make_shared<Object>(*shared);
  return *shared;
}

std::vector<Json>& Json::own_items() {
  if (!is_array()) fail("a list [...]", *this);
  SharedItems& shared = std::get<SharedItems>(value_);
  if (shared.use_count() > 1) shared = std::make_shared<std::vector<Json>>(*shared);
  return *shared;
}

JsonError::JsonError(Kind kind, std::size_t byte, std::optional<std::string> key)
    : InvalidInput(sentence(kind, byte, key)), kind_(kind), byte_(byte), key_(std::move(key)) {}

// Builds a value from what nlohmann's parser finds, and refuses what parse_json refuses.
class JsonBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  JsonBuilder(std::size_t size, JsonDialect dialect) : size_(size), dialect_(dialect) {}

  bool null() override { return add(Json()); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(std::int64_t value) override { return add(value); }
  bool number_unsigned(std::uint64_t value) override { return add(value); }
  bool number_float(double value, const std::string&) override { return add(value); }
  bool string(std::string& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_array() override { return close(); }

  bool end_object() override {
    open_.back().json.own_object().sort();
    return close();
  }

  bool key(std::string& key) override {
    Open& object = open_.back();
    latest_ = key;
    const bool is_new = object.keys.insert(key).second;
    if (!is_new && dialect_ == JsonDialect::strict) throw_error(JsonError::Kind::repeated_key, 0);
    object.key = std::move(key);
    return true;
  }

  bool parse_error(std::size_t byte, const std::string& token, const nlohmann::json::exception& error) override {
    constexpr int kNumberOverflow = 406;
    constexpr std::size_t kLongestEscape = 6;  // of \u0000
    const std::size_t escape = token.starts_with('"') ? token.rfind('\\') : token.npos;
    const bool is_escape = byte <= size_ && escape != token.npos && token.size() - escape <= kLongestEscape;
    if (is_escape) throw_error(JsonError::Kind::bad_escape, byte);
    if (error.id == kNumberOverflow) throw_error(JsonError::Kind::too_large, byte);
    throw_error(byte > size_ ? JsonError::Kind::incomplete : JsonError::Kind::not_json, byte);
  }

  Json result() { return std::move(result_); }

 private:
  // An array or object whose end was not read yet.
  struct Open {
    Json json;
    std::set<std::string> keys;
    std::string key;  // of the member that is read next
  };

  [[noreturn]] void throw_error(JsonError::Kind kind, std::size_t byte) const { throw JsonError(kind, byte, latest_); }

  bool open(Json json) {
    if (open_.size() == kDeepestJson) throw_error(JsonError::Kind::too_deep, 0);
    open_.push_back({std::move(json), {}, {}});
    return true;
  }

  bool close() {
    Json closed = std::move(open_.back().json);
    open_.pop_back();
    return add(std::move(closed));
  }

  bool add(Json value) {
    if (open_.empty()) {
      result_ = std::move(value);
    } else if (Open& parent = open_.back(); parent.json.is_array()) {
      parent.json.own_items().push_back(std::move(value));
    } else if (dialect_ == JsonDialect::by_hand) {
      parent.json.own_object().set(parent.key, std::move(value));
    } else {
      parent.json.own_object().members.push_back({std::move(parent.key), std::move(value)});
    }
    return true;
  }

  std::size_t size_;
  JsonDialect dialect_;
  Json result_;
  std::vector<Open> open_;
  std::optional<std::string> latest_;
};

Json parse_json(std::string_view text, JsonDialect dialect) {
  JsonBuilder builder(text.size(), dialect);
  const bool skips_comments = dialect == JsonDialect::by_hand;
  nlohmann::json::sax_parse(text.begin(), text.end(), &builder, nlohmann::json::input_format_t::json, true,
                            skips_comments);
  return builder.result();
}

// Writes a value as nlohmann does; text and numbers are left to that library.
class JsonWriter {
 public:
  explicit JsonWriter(const JsonStyle& style) : style_(style) {}

  void write(const Json& json) {
    if (json.is_array()) {
      write_all('[', json.items(), ']', [&](const Json& item) { write(item); });
    } else if (json.is_object()) {
      write_all('{', json.members(), '}', [&](const JsonMember& member) {
        text_ += scalar(member.key) + (style_.indent < 0 ? ":" : ": ");
        write(member.value);
      });
    } else {
      text_ += std::visit([&](const auto& value) { return scalar(value); }, json.value_);
    }
  }

  std::string text() { return std::move(text_); }

 private:
  template <class Items, class Write>
  void write_all(char opening, const Items& items, char closing, Write write_item) {
    text_ += opening;
    ++depth_;
    for (const auto& item : items) {
      if (&item != &items.front()) text_ += ',';
      break_line();
      write_item(item);
    }
    --depth_;
    if (!items.empty()) break_line();
    text_ += closing;
  }

  void break_line() {
    if (style_.indent < 0) return;
    text_ += '\n';
    text_.append(depth_ * static_cast<std::size_t>(style_.indent), ' ');
  }

  template <class T>
  std::string scalar(const T& value) const {
    if constexpr (std::is_same_v<T, std::monostate>) {
      return "null";
    } else if constexpr (std::is_same_v<T, Json::SharedText>) {
      return scalar(*value);
    } else if constexpr (std::is_same_v<T, Json::SharedItems> || std::is_same_v<T, Json::SharedObject>) {
      return {};  // write has dealt with these
    } else {
      using Scalar = nlohmann::json;
      return Scalar(value).dump(-1, ' ', style_.ascii, Scalar::error_handler_t::replace);
    }
  }

  JsonStyle style_;
  std::string text_;
  std::size_t depth_ = 0;
};

std::string to_text(const Json& json, const JsonStyle& style) {
  JsonWriter writer(style);
  writer.write(json);
  return writer.text();
}

std::string described(const Json& json) {
  constexpr std::size_t most = 40;
  if (json.is_array()) return fmt::format("an array of {}", json.items().size());
  if (json.is_object()) return "an object";
  const std::string text = to_text(json, {.ascii = true});
  return text.size() > most ? text.substr(0, most) + "..." : text;
}

std::string to_indented_text(const Json& json) { return to_text(json, {.indent = 2}) + "\n"; }

}  // namespace knead
