// Reading OFF as text.
#include <algorithm>
#include <charconv>
#include <cstdint>

#include "knead/io/cursor.h"
#include "knead/io/off/mesh.h"

namespace knead::io_detail::off {
namespace {

class TextReader {
 public:
  TextReader(MeshBuilder& builder, const Header& header, ShapeFile& shape, const std::string& name)
      : builder_(builder), fields_(header.fields), shape_(shape), text_(shape.bytes, name, header.counts_begin) {}

  Layout run() {
    read_counts();
    Layout layout;
    layout.vertex_begin = text_.position();
    for (std::size_t i = 0; i < vertices_; ++i) read_vertex(i);
    layout.width = width_;
    for (std::size_t i = 0; i < faces_; ++i) read_face(i);
    layout.faces_end = text_.position();
    if (hexadecimal_) shape_.notes.emplace_back("colors are in hexadecimal and are read as whole numbers");
    if (!text_.next().empty()) {
      shape_.notes.push_back(counted(bytes_left(), "byte follows the last face", "bytes follow the last face"));
    }
    return layout;
  }

 private:
  // From the word that was taken last on.
  std::size_t bytes_left() const { return shape_.bytes.size() - text_.word_begin(); }

  // Refuses more than the rest of the file can hold; each takes so many bytes at least, the last one less.
  void check_count(std::size_t count, std::size_t bytes, const char* what) const {
    if (count <= bytes_left() / bytes + 1) return;
    text_.fail(std::to_string(count) + " " + what + " are declared, but only " + std::to_string(bytes_left()) +
               " bytes follow; the file is cut short or damaged");
  }

  // The counts of vertices and faces, and of edges if it is there, which is not needed.
  void read_counts() {
    vertices_ = text_.whole(text_.next(), std::numeric_limits<std::size_t>::max(), "the count of vertices");
    faces_ = text_.whole(text_.next_on_line(), std::numeric_limits<std::size_t>::max(), "the count of faces");
    if (vertices_ == 0) text_.fail("0 vertices are declared; there is no shape in it");
    check_count(vertices_, 2 * fields_.without_colors(), "vertices");
    check_count(faces_, 2, "faces");
    if (vertices_ >= kMostElements) text_.fail("more than 4294967294 vertices; split the shape");
    const std::string_view edges = text_.next_on_line();
    if (!edges.empty()) text_.real(edges, "the count of edges");  // some write -1
    if (const std::string_view more = text_.next_on_line(); !more.empty()) {
      text_.fail("expected the end of the line after the counts, found " + in_quotes(more));
    }
  }

  std::string_view begin_row(std::size_t row, std::size_t rows, const char* what) {
    const std::string_view word = text_.next();
    if (word.empty()) {
      text_.fail("the file ends after " + std::to_string(row) + " of " + std::to_string(rows) + " " + what +
                 "; it is cut short, or its counts are wrong");
    }
    return word;
  }

  // A number after the coordinates or the indices; a color 0xRRGGBB or 0xRRGGBBAA is three or four. Returns whether
  // they are whole.
  bool add_number(std::string_view word, const char* expected) {
    const bool is_color = numbers_.size() >= first_color_;
    const bool is_hexadecimal = is_color && word.size() > 2 && word[0] == '0' && (word[1] == 'x' || word[1] == 'X');
    if (!is_hexadecimal) {
      numbers_.push_back(text_.real(word, expected));
      return is_whole(word);
    }
    const std::string_view digits = word.substr(2);
    std::uint32_t value = 0;
    const char* end = digits.data() + digits.size();
    const auto [stop, error] = std::from_chars(digits.data(), end, value, 16);
    const std::size_t bytes = (digits.size() + 1) / 2;
    if (error != std::errc{} || stop != end || bytes == 2 || bytes > 4) {
      text_.fail(in_quotes(word) + " is no color; expected 0xRRGGBB or 0xRRGGBBAA");
    }
    for (std::size_t i = bytes; i-- > 0;) numbers_.push_back((value >> (8 * i)) & 0xffu);
    hexadecimal_ = true;
    return true;
  }

  static bool is_whole(std::string_view word) {
    return std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
  }

  void read_vertex(std::size_t i) {
    numbers_.clear();
    whole_.clear();
    first_color_ = fields_.normals ? 6 : 3;
    for (std::string_view word = begin_row(i, vertices_, "vertices"); !word.empty(); word = text_.next_on_line()) {
      bool is_whole_number = false;
      if (numbers_.size() < 3) {
        numbers_.push_back(text_.coordinate(word));
      } else {
        is_whole_number = add_number(word, "a number");
      }
      whole_.resize(numbers_.size(), is_whole_number);
    }
    if (i == 0) check_width();
    if (numbers_.size() != width_) {
      text_.fail("expected " + std::to_string(width_) + " numbers as for the first vertex, found " +
                 std::to_string(numbers_.size()));
    }
    builder_.add_vertex(numbers_, whole_);
  }

  void check_width() {
    width_ = numbers_.size();
    const std::size_t least = fields_.without_colors();
    const std::size_t colors = width_ - std::min(width_, least);
    if (width_ < least || (fields_.colors && colors != 3 && colors != 4)) {
      const std::string expected =
          fields_.colors ? std::to_string(least + 3) + " or " + std::to_string(least + 4) : std::to_string(least);
      text_.fail("expected " + expected + " numbers for a vertex, as the keyword says, found " +
                 std::to_string(width_));
    }
  }

  void read_face(std::size_t i) {
    const std::string_view first = begin_row(i, faces_, "faces");
    const std::size_t corners = text_.whole(first, bytes_left() / 2 + 1, "the number of corners of a face");
    face_.clear();
    for (std::size_t c = 0; c < corners; ++c) {
      const std::size_t v = text_.whole(text_.next_on_line(), vertices_ - 1, "a vertex index");
      face_.push_back(static_cast<std::uint32_t>(v));
    }
    numbers_.clear();
    first_color_ = 0;
    bool whole = true;
    for (std::string_view word = text_.next_on_line(); !word.empty(); word = text_.next_on_line()) {
      whole = add_number(word, "a number of a color") && whole;
    }
    builder_.add_face(face_, numbers_, whole);
  }

  MeshBuilder& builder_;
  Fields fields_;
  ShapeFile& shape_;
  TextCursor text_;
  std::size_t vertices_ = 0;
  std::size_t faces_ = 0;
  std::size_t width_ = 0;
  std::vector<double> numbers_;  // of a line
  std::vector<bool> whole_;      // which of them are whole numbers
  std::vector<std::uint32_t> face_;
  std::size_t first_color_ = 0;  // number of the row
  bool hexadecimal_ = false;     // some color
};

}  // namespace

Layout read_text(MeshBuilder& builder, const Header& header, ShapeFile& shape, const std::string& name) {
  return TextReader(builder, header, shape, name).run();
}

}  // namespace knead::io_detail::off
