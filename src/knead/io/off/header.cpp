// The keyword of an OFF file.
#include <algorithm>

#include "knead/io/cursor.h"
#include "knead/io/layout.h"
#include "knead/io/off/layout.h"
#include "knead/io/off/mesh.h"

namespace knead::io_detail::off {
namespace {

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

// What the letters before OFF say. Whether `n` is among them.
bool parse_letters(std::string_view letters, const TextCursor& text, Fields& fields) {
  bool has_dimension = false;
  while (!letters.empty()) {
    if (take_prefix(letters, "ST")) {
      fields.uv = true;
    } else if (take_prefix(letters, "C")) {
      fields.colors = true;
    } else if (take_prefix(letters, "N")) {
      fields.normals = true;
    } else if (take_prefix(letters, "n")) {
      has_dimension = true;
    } else if (take_prefix(letters, "4")) {
      text.fail("4OFF has four coordinates per vertex; only three dimensions are supported");
    } else {
      text.fail("expected a keyword such as OFF or COFF, found " + in_quotes(std::string(letters) + "...OFF"));
    }
  }
  return has_dimension;
}

// In upper case unless it has OFF in that case already; then as it is, because n and N differ.
std::string keyword_of(std::string_view word) {
  std::string upper(word);
  if (word.find("OFF") != std::string_view::npos) return upper;
  for (char& c : upper) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return upper;
}

bool is_number(std::string_view word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

Header parse_header(std::string_view bytes, const std::string& name) {
  Header header;
  TextCursor text(bytes, name, text_begin(bytes, name));
  header.counts_begin = text.position();
  const std::string_view word = text.next();
  if (is_number(word)) return header;  // the keyword may be missing
  const std::string in_upper_case = keyword_of(word);
  header.lower_case = in_upper_case != word;
  const std::size_t keyword = in_upper_case.find("OFF");
  if (keyword == std::string_view::npos) {
    text.fail("expected the keyword OFF, or the counts of vertices and faces, found " +
              (word.empty() ? "the end of the file" : in_quotes(word)));
  }
  const bool has_dimension = parse_letters(std::string_view(in_upper_case).substr(0, keyword), text, header.fields);
  // The first count may follow without a blank.
  const std::size_t end = text.word_begin() + keyword + 3;
  text.take(text.word_begin(), end);
  const std::string_view encoding = text.next_on_line();
  if (encoding == "BINARY" || (header.lower_case && encoding == "binary")) {
    if (has_dimension) text.fail("binary nOFF is not supported; write it as text");
    header.binary = true;
    text.next_line();
    header.counts_begin = text.position();
    return header;
  }
  header.counts_begin = end;
  if (!has_dimension) return header;
  text.take(end, end);
  const std::size_t dimension = text.whole(text.next(), 1'000'000, "the number of dimensions after nOFF");
  if (dimension != 3) text.fail(std::to_string(dimension) + " dimensions; only three are supported");
  header.counts_begin = text.position();
  return header;
}

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "off";
  shape.bytes = std::move(bytes);
  const Header header = parse_header(shape.bytes, name);
  if (header.lower_case) shape.notes.emplace_back("the keyword has letters in lower case and is read as in upper case");
  MeshBuilder builder(shape, header.fields);
  const auto read = header.binary ? read_binary : read_text;
  Layout layout = read(builder, header, shape, name);
  layout.all_read = builder.finish();
  set_layout(shape, layout);
  return shape;
}

}  // namespace knead::io_detail::off
