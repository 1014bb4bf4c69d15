// The JSON of a GLB file: read strictly, and found again in the text. Internal to the GLB reader and writer.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knead/io/json.h"

namespace knead::io_detail::glb {

// Returns the text as a JSON object. Throws InvalidInput for what parse_json refuses and for other values than objects;
// `begin`, the byte of the file where the text begins, is for messages.
Json parse_object(std::string_view text, std::size_t begin, const std::string& name);

// Where the text that a value was read from stands: for messages.
struct Source {
  std::string file;
  std::string_view text;
  std::size_t begin = 0;  // byte of the file
};

// A value that knows its path, e.g. accessors[3].count, for messages. The value and the source must outlive it.
class Value {
 public:
  Value(const Json& json, const Source& source, std::string path = {})
      : json_(&json), source_(&source), path_(std::move(path)) {}

  // The value at a key; nothing where this is no object or has no such key.
  std::optional<Value> find(const char* key) const;

  // The same; fails where it is missing.
  Value at(const char* key) const;

  // The size of an array; fails for anything else.
  std::size_t size() const;

  // The item of an array; fails where there is none.
  Value item(std::size_t i) const;

  // The item of the array at the key, e.g. item("accessors", 3).
  Value item(const char* key, std::size_t i) const;

  // The size of the array at the key; 0 where it is missing.
  std::size_t count(const char* key) const;

  double number() const;
  std::size_t whole() const;                                // from 0 to 2^53
  std::optional<std::size_t> whole(const char* key) const;  // nothing where the key is missing
  std::vector<double> numbers(std::size_t count) const;
  std::string text() const;
  bool flag(const char* key) const;  // false where the key is missing

  const Json& json() const { return *json_; }

  // Throws InvalidInput "FILE: byte N: PATH: what", the byte where the value begins.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  const Json* json_;
  const Source* source_;
  std::string path_;
};

// Bytes [begin, end) of a text.
struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// The span of the value at a path such as accessors[3].count, or of the last value on the way to it that the text has.
Span span_at(std::string_view text, std::string_view path);

struct Member {
  std::string key;  // empty for the items of an array
  Span value;
};

// The object that a text which parse_json has read consists of.
Span root_span(std::string_view text);

// The members of an object, or the items of an array; none for anything else. Takes time in proportion to the span.
std::vector<Member> members(std::string_view text, const Span& container);

// The span of the value at the key of an object, or nothing.
std::optional<Span> member(std::string_view text, const Span& object, std::string_view key);

// Replaces [begin, end), or inserts where both are the same.
struct Patch {
  Span span;
  std::string text;
};

// Appends an item to the array at `array`.
Patch appended_item(std::string_view text, const Span& array, const std::string& items);

// The text with its patches, which do not overlap.
std::string patched(std::string_view text, std::vector<Patch> patches);

}  // namespace knead::io_detail::glb
