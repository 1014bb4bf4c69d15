// Strict reading of one line's JSON object, and a stroke as such a line.
//
// Every failure is an InvalidInput with the line's place, the key in quotes, what was expected and what was got.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "json/json.h"
#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/remesh.h"
#include "knead/session.h"
#include "knead/vec.h"

namespace knead::detail {

// The value of a key, or an item of it, with its name for messages.
class JsonValue {
 public:
  JsonValue(const Json& value, std::string name, const Place& place)
      : value_(value), name_(std::move(name)), place_(place) {}

  double number() const;
  long long integer() const;  // a number without a fraction, of at most 9 digits
  std::string text() const;
  bool flag() const;
  Vec3d vector() const;
  std::vector<JsonValue> items() const;
  std::vector<Vec3d> vectors() const;

  // Returns the index of the text among the choices.
  std::size_t choice(std::span<const std::string_view> choices) const;

  bool is_number() const { return value_.is_number(); }
  bool is_text() const { return value_.is_text(); }

  const Json& json() const { return value_; }
  const std::string& name() const { return name_; }

  [[noreturn]] void fail(const std::string& expected) const;

 private:
  const Json& value_;
  std::string name_;
  const Place& place_;
};

// The object outlives its values; the place outlives both.
class JsonObject {
 public:
  // `what` names the object in messages, e.g. "a rotate stroke".
  JsonObject(const JsonValue& value, const Place& place, std::string what);

  // Fails for a key that is not one of these; the message lists them.
  void allow(const std::vector<std::string_view>& keys) const;

  bool has(std::string_view key) const { return value_.has(key); }
  JsonValue at(std::string_view key) const;  // fails if the key is missing

  double number(std::string_view key) const { return at(key).number(); }
  std::optional<double> optional_number(std::string_view key) const;
  Vec3d vector(std::string_view key) const { return at(key).vector(); }
  std::vector<Vec3d> vectors(std::string_view key) const { return at(key).vectors(); }

 private:
  const Json& value_;
  const Place& place_;
  std::string prefix_;
  std::string what_;
};

// Returns one line as JSON, or nothing if the text ends before its JSON does. Throws InvalidInput for everything else
// that parse_json refuses.
std::optional<Json> parse_line(std::string_view line, const Place& place);

// Strokes and the settings of a remesh event from JSON, and as JSON.

// Returns the stroke of an object with the key "tool", with the keys that every stroke may have. Throws InvalidInput
// for anything that is not exactly a valid stroke of a tool of this version.
SessionStroke read_stroke(const JsonValue& line, const Place& place);

// Returns the tool whose event (Tool::is_event) the line is, or a null pointer.
const Tool* event_tool(const JsonObject& line);

// Returns the stroke of such an event from the value of its key: null, or an object. Throws InvalidInput as above.
SessionStroke read_event_stroke(const Tool& tool, const JsonValue& value, const Place& place);

// Returns the value at the header's key "parameters". Throws InvalidInput as above.
std::vector<Parameter> read_parameters(const JsonValue& value, const Place& place);

// Returns the parameters with these values. Throws InvalidInput with the place for an unknown name, and for a value
// that is not finite or beyond its bounds.
std::vector<Parameter> changed(std::vector<Parameter> parameters, const ParameterValues& values, const Place& place);

// A stroke's line with numbers in the place of parameters.
struct FilledLine {
  Json line;
  std::vector<ParameterUse> uses;  // without `numbers`
};

// Returns the line with the values of parameters in the place of texts "$name". Texts at the keys "tool", "name" and
// "mesh" do not change. Throws InvalidInput for an unknown name.
FilledLine fill_in(const Json& line, std::span<const Parameter> parameters, const Place& place);

// Returns the value at the key "remesh": null or an object. Throws InvalidInput as above.
std::optional<RemeshSettings> read_remesh(const JsonValue& value, const Place& place);

// Returns the stroke as one line. `names_parameters`: with parameters' names for the keys that use them.
std::string line_of(const SessionStroke& stroke, bool names_parameters);

// Returns the value of a stroke's key as stroke_line writes it, even if it is the default. Empty if the stroke has
// none.
std::string key_text(const SessionStroke& stroke, std::string_view key);

}  // namespace knead::detail
