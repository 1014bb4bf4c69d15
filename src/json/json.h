// JSON values: read strictly, inspected, built and written. Session files, glTF, reports and preferences use them.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "knead/error.h"

namespace knead {

struct JsonMember;

// One JSON value. Objects keep their members in the order in which they were read or added.
// Copies share memory until one of them changes, so a copy is cheap.
class Json {
 public:
  // Makes null.
  Json() = default;
  Json(std::nullptr_t) {}
  Json(bool value) : value_(value) {}
  Json(double value) : value_(value) {}  // infinity and NaN are written as null
  template <std::signed_integral T>
  Json(T value) : value_(static_cast<std::int64_t>(value)) {}
  template <std::unsigned_integral T>
  Json(T value) : value_(static_cast<std::uint64_t>(value)) {}
  Json(const char* text) : Json(std::string(text)) {}
  Json(std::string_view text) : Json(std::string(text)) {}
  Json(std::string text);

  // Makes null for nothing.
  template <class T>
  Json(const std::optional<T>& value) : Json(value ? Json(*value) : Json()) {}

  // Makes an array.
  Json(std::vector<Json> items);
  template <class T>
  Json(const std::vector<T>& items) : Json(std::vector<Json>(items.begin(), items.end())) {}
  // Returns an empty array.
  static Json array() { return std::vector<Json>(); }

  // Makes an object; a later member replaces an earlier one of the same key.
  Json(std::initializer_list<JsonMember> members);
  // Returns an empty object.
  static Json object();

  // Returns whether the value is of the kind that the name says.
  bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
  bool is_flag() const { return std::holds_alternative<bool>(value_); }
  bool is_number() const;
  bool is_whole() const { return std::holds_alternative<std::uint64_t>(value_); }  // written as 0, 1, 2 ...
  // Returns whether the value is of the kind that the name says.
  bool is_text() const { return std::holds_alternative<SharedText>(value_); }
  bool is_array() const { return std::holds_alternative<SharedItems>(value_); }
  bool is_object() const { return std::holds_alternative<SharedObject>(value_); }

  // Return the value as what the name says. They throw InvalidInput for a value of another kind.
  bool flag() const;
  double number() const;
  std::size_t whole() const;
  const std::string& text() const;
  const std::vector<Json>& items() const&;
  const std::vector<Json>& items() && = delete;  // would refer into a value that is gone
  const std::vector<JsonMember>& members() const&;
  const std::vector<JsonMember>& members() && = delete;

  // Returns the member with this key, or a null pointer if there is none or this is not an object. Takes time in
  // proportion to the logarithm of the number of members. The pointer is valid until this object changes.
  const Json* find(std::string_view key) const;

  // Returns whether this is an object that has the key.
  bool has(std::string_view key) const { return find(key) != nullptr; }

  // Returns the member with this key. Throws InvalidInput if there is none.
  const Json& at(std::string_view key) const;

  // Adds a member at the end, or replaces the value of the one that has this key. Null becomes an object first.
  void set(std::string_view key, Json value);

  // Adds an item at the end. Null becomes an array first.
  void push_back(Json item);

 private:
  friend class JsonBuilder;
  friend class JsonWriter;
  struct Object;
  using SharedText = std::shared_ptr<const std::string>;
  using SharedItems = std::shared_ptr<std::vector<Json>>;
  using SharedObject = std::shared_ptr<Object>;

  Object& own_object();
  std::vector<Json>& own_items();

  std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, SharedText, SharedItems, SharedObject> value_;
};

// A key of an object with its value.
struct JsonMember {
  std::string key;
  Json value;
};

// A text is not the JSON that parse_json accepts. what() is a whole sentence; the members serve better messages.
class JsonError : public InvalidInput {
 public:
  // What is wrong with the text.
  enum class Kind { not_json, incomplete, repeated_key, too_deep, too_large, bad_escape };

  JsonError(Kind kind, std::size_t byte, std::optional<std::string> key);

  // Returns what is wrong with the text.
  Kind kind() const { return kind_; }
  std::size_t byte() const { return byte_; }                      // where reading stopped, counted from 1
  const std::optional<std::string>& key() const { return key_; }  // the last one that was read; the repeated one

 private:
  Kind kind_;
  std::size_t byte_;
  std::optional<std::string> key_;
};

inline constexpr std::size_t kDeepestJson = 128;

// How strictly a text is read.
enum class JsonDialect {
  strict,
  by_hand,  // comments are skipped, and the last value of a repeated key counts
};

// Returns the value that a text in UTF-8 holds; a byte-order mark may precede it. Throws JsonError for text that is not
// JSON, for a key that an object has twice, for arrays and objects nested deeper than kDeepestJson, and for numbers too
// large for a double. Takes time in proportion to the text's length, and the logarithm of an object's members for each.
Json parse_json(std::string_view text, JsonDialect dialect = JsonDialect::strict);

// How a value is written.
struct JsonStyle {
  int indent = -1;     // spaces for each level, each value on a line of its own; negative: all on one line
  bool ascii = false;  // writes other characters as \u....
};

// Returns the value as text. Doubles have the fewest digits that read back the same; bytes that are not UTF-8 are
// replaced by U+FFFD.
std::string to_text(const Json& json, const JsonStyle& style = {});

// Says what a value is, for messages: the value itself if it is short, else its kind.
std::string described(const Json& json);

// Returns the value as files and standard output hold it: indented by two spaces, ending in a line end.
std::string to_indented_text(const Json& json);

}  // namespace knead
