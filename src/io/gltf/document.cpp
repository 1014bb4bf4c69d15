// The chunks of a GLB file, and its JSON: read strictly, with the place of each value in the text.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>

#include "io/gltf/gltf.h"
#include "io/text.h"
#include "knead/error.h"

namespace knead::detail::gltf {
namespace {

// What the header says that the file's length is.
std::size_t declared_length(std::string_view bytes, const std::string& name) {
  ByteCursor cursor(bytes, name);
  if (cursor.take_bytes(4, "'glTF'") != "glTF") {
    fail_at_byte(name, 0, "this is no GLB file: it does not begin with 'glTF'");
  }
  const auto version = cursor.take<std::uint32_t>("the version");
  if (version != 2) fail_at_byte(name, 4, fmt::format("glTF {} is not supported; use version 2", version));
  const auto length = cursor.take<std::uint32_t>("the length");
  if (length > bytes.size()) {
    fail_at_byte(
        name, 8,
        fmt::format("the file should have {} bytes, but has {}; it is cut short or damaged", length, bytes.size()));
  }
  return length;
}

bool is_space(char c) { return is_blank(c) || is_line_end(c); }

std::size_t skip_space(std::string_view text, std::size_t i) {
  while (i < text.size() && is_space(text[i])) ++i;
  return i;
}

// The byte after the string whose opening quote is at i.
std::size_t string_end(std::string_view text, std::size_t i) {
  for (++i; i < text.size() && text[i] != '"'; ++i) {
    if (text[i] == '\\') ++i;
  }
  return i + 1;
}

// The byte after the value that begins at i.
std::size_t value_end(std::string_view text, std::size_t i) {
  std::size_t depth = 0;
  while (i < text.size()) {
    const char c = text[i];
    if (c == '"') {
      i = string_end(text, i);
    } else if (c == '{' || c == '[') {
      ++depth;
      ++i;
    } else if (c == '}' || c == ']') {
      --depth;
      ++i;
    } else {
      const std::size_t end = text.find_first_of(depth == 0 ? ",]} \t\r\n" : "\"[]{}", i);
      i = end == std::string_view::npos ? text.size() : end;
    }
    if (depth == 0) return i;
  }
  return i;
}

}  // namespace

Layout parse_chunks(std::string_view bytes, const std::string& name) {
  ByteCursor cursor(bytes.substr(0, declared_length(bytes, name)), name);
  cursor.take_bytes(12, "the header");
  Layout layout;
  while (cursor.left() > 0) {
    Chunk chunk;
    chunk.size = cursor.take<std::uint32_t>("the length of a chunk");
    chunk.type = cursor.take<std::uint32_t>("the type of a chunk");
    chunk.begin = cursor.position();
    cursor.take_bytes(chunk.size, "the contents of a chunk");
    if (chunk.type == kBin && !layout.bin) layout.bin = layout.chunks.size();
    layout.chunks.push_back(chunk);
  }
  layout.end = cursor.position();
  if (layout.chunks.empty() || layout.chunks.front().type != kJson) {
    fail_at_byte(name, 12, "the first chunk is not JSON; the file is damaged");
  }
  return layout;
}

std::optional<Layout> layout_of_file(const SourceFile& file) {
  constexpr std::size_t kHead = 12;
  constexpr std::size_t kChunkHead = 8;
  constexpr std::size_t kMagic = 0x46546C67;
  const auto number = [&](std::size_t at) {
    std::array<char, 4> bytes{};
    file.read(at, bytes);
    return static_cast<std::size_t>(
        read_binary(bytes.data(), NumberType::uint32, std::endian::native != std::endian::little));
  };
  const bool is_glb = file.size() >= kHead && number(0) == kMagic && number(4) == 2 && number(8) == file.size();
  if (!is_glb) return std::nullopt;
  Layout layout;
  layout.end = kHead;
  for (const std::size_t type : {kJson, kBin}) {
    if (file.size() - layout.end < kChunkHead) return std::nullopt;
    const Chunk chunk{static_cast<std::uint32_t>(type), layout.end + kChunkHead, number(layout.end)};
    if (number(layout.end + 4) != type || chunk.size > file.size() - chunk.begin) return std::nullopt;
    layout.chunks.push_back(chunk);
    layout.end = chunk.begin + chunk.size;
  }
  if (layout.end != file.size()) return std::nullopt;
  layout.bin = 1;
  layout.text.resize(layout.chunks[0].size);
  file.read(layout.chunks[0].begin, layout.text);
  return layout;
}

std::string_view Bin::piece(std::size_t begin, std::size_t count, std::string& buffer) const {
  if (file_ == nullptr) return bytes_.substr(begin, count);
  buffer.resize(count);
  file_->read(begin_ + begin, buffer);
  return buffer;
}

Document open_document(std::string_view bytes, const Layout& layout, const std::string& name, const SourceFile* file) {
  const Chunk& json = layout.chunks.front();
  Document document;
  document.bytes = bytes;
  document.text = file != nullptr ? layout.text : bytes.substr(json.begin, json.size);
  document.size = file != nullptr ? file->size() : bytes.size();
  document.source = {name, document.text, json.begin};
  if (layout.bin) {
    const Chunk& bin = layout.chunks[*layout.bin];
    document.bin = file != nullptr ? Bin(*file, bin) : Bin(bytes.substr(bin.begin, bin.size));
  }
  document.json = parse_object(document.text, json.begin, name);
  const Value asset = document.root().at("asset");
  for (const char* key : {"version", "minVersion"}) {
    const std::optional<Value> version = asset.find(key);
    if (version && version->text().substr(0, 2) != "2.") version->fail("only glTF 2 is supported");
  }
  asset.at("version");
  return document;
}

Document open_source(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  const std::string_view bytes = layout.wrapping ? layout.wrapping->glb : source.bytes;
  return open_document(bytes, layout, "source", source.file.get());
}

Json parse_object(std::string_view text, std::size_t begin, const std::string& name) {
  using Kind = JsonError::Kind;
  try {
    Json json = parse_json(text);
    if (!json.is_object()) fail_at_byte(name, begin, "the JSON is not an object; repair the file");
    return json;
  } catch (const JsonError& error) {
    if (error.kind() == Kind::not_json || error.kind() == Kind::incomplete || error.kind() == Kind::bad_escape) {
      fail_at_byte(name, begin + error.byte(), "this is not JSON; the file is damaged");
    }
    if (error.kind() == Kind::too_large) {
      throw InvalidInput(Place{name}, "the JSON has a number that is too large; repair the file");
    }
    if (error.kind() == Kind::too_deep) {
      throw InvalidInput(Place{name}, fmt::format("the JSON is nested deeper than {}; repair the file", kDeepestJson));
    }
    throw InvalidInput(Place{name}, fmt::format("the JSON gives the key {} twice; repair the file",
                                                in_quotes(error.key().value_or(""))));
  }
}

std::optional<Value> Value::find(const char* key) const {
  const Json* found = json_->find(key);
  if (found == nullptr) return std::nullopt;
  return Value(*found, *source_, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key));
}

Value Value::at(const char* key) const {
  std::optional<Value> found = find(key);
  if (!found) fail(fmt::format("'{}' is missing; repair the file", key));
  return *std::move(found);
}

std::size_t Value::size() const {
  if (!json_->is_array()) fail("must be an array; repair the file");
  return json_->items().size();
}

Value Value::item(std::size_t i) const {
  if (i >= size()) fail(fmt::format("there is no item {}, only {} (counted from 0); repair the file", i, size()));
  return {json_->items()[i], *source_, fmt::format("{}[{}]", path_, i)};
}

Value Value::item(const char* key, std::size_t i) const { return at(key).item(i); }

std::size_t Value::count(const char* key) const {
  const std::optional<Value> found = find(key);
  return found ? found->size() : 0;
}

double Value::number() const {
  if (!json_->is_number()) fail("must be a number; repair the file");
  return json_->number();
}

std::size_t Value::whole() const {
  constexpr double kMax = 9007199254740992.0;
  const double value = json_->is_number() ? json_->number() : -1;
  if (!(value >= 0 && value <= kMax && value == std::floor(value))) {
    fail("must be a whole number from 0 on; repair the file");
  }
  return static_cast<std::size_t>(value);
}

std::optional<std::size_t> Value::whole(const char* key) const {
  const std::optional<Value> found = find(key);
  if (!found) return std::nullopt;
  return found->whole();
}

std::vector<double> Value::numbers(std::size_t count) const {
  if (size() != count) fail(fmt::format("must be {} numbers, found {}; repair the file", count, size()));
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(item(i).number());
  return result;
}

std::string Value::text() const {
  if (!json_->is_text()) fail("must be text; repair the file");
  return json_->text();
}

bool Value::flag(const char* key) const {
  const std::optional<Value> found = find(key);
  if (!found) return false;
  if (!found->json().is_flag()) found->fail("must be true or false; repair the file");
  return found->json().flag();
}

void Value::fail(const std::string& what) const {
  const std::size_t position = source_->begin + span_at(source_->text, path_).begin;
  fail_at_byte(source_->file, position, path_.empty() ? what : fmt::format("{}: {}", path_, what));
}

Span span_at(std::string_view text, std::string_view path) {
  Span span = root_span(text);
  while (!path.empty()) {
    const bool is_item = path[0] == '[';
    if (is_item || path[0] == '.') path.remove_prefix(1);
    const std::size_t end = std::min(path.find_first_of(is_item ? "]" : ".["), path.size());
    const std::string_view step = path.substr(0, end);
    path.remove_prefix(is_item ? std::min(end + 1, path.size()) : end);
    std::optional<Span> next;
    if (is_item) {
      std::size_t i = 0;
      std::from_chars(step.data(), step.data() + step.size(), i);
      const std::vector<Member> items = members(text, span);
      if (i < items.size()) next = items[i].value;
    } else if (text[span.begin] == '{') {
      next = member(text, span, step);
    }
    if (!next) break;
    span = *next;
  }
  return span;
}

Span root_span(std::string_view text) {
  const std::size_t begin = text.find('{');  // a byte-order mark may stand before it
  return {begin, value_end(text, begin)};
}

std::vector<Member> members(std::string_view text, const Span& container) {
  std::vector<Member> result;
  const bool is_object = text[container.begin] == '{';
  if (!is_object && text[container.begin] != '[') return result;
  std::size_t i = skip_space(text, container.begin + 1);
  while (i + 1 < container.end) {
    Member member;
    if (is_object) {
      const std::size_t end = string_end(text, i);
      member.key = parse_json(text.substr(i, end - i)).text();
      i = skip_space(text, skip_space(text, end) + 1);  // after the colon
    }
    member.value = {i, value_end(text, i)};
    i = skip_space(text, member.value.end);
    if (text[i] == ',') i = skip_space(text, i + 1);
    result.push_back(std::move(member));
  }
  return result;
}

std::optional<Span> member(std::string_view text, const Span& object, std::string_view key) {
  for (const Member& member : members(text, object)) {
    if (member.key == key) return member.value;
  }
  return std::nullopt;
}

Patch appended_item(std::string_view text, const Span& array, const std::string& items) {
  std::size_t end = array.end - 1;
  const bool is_empty = skip_space(text, array.begin + 1) == end;
  while (is_space(text[end - 1])) --end;
  return {{end, end}, is_empty ? items : "," + items};
}

std::string patched(std::string_view text, std::vector<Patch> patches) {
  std::sort(patches.begin(), patches.end(), [](const Patch& a, const Patch& b) { return a.span.begin < b.span.begin; });
  std::string result;
  std::size_t copied = 0;
  for (const Patch& patch : patches) {
    result += text.substr(copied, patch.span.begin - copied);
    result += patch.text;
    copied = patch.span.end;
  }
  result += text.substr(copied);
  return result;
}

}  // namespace knead::detail::gltf
