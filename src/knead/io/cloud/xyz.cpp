#include "knead/io/cloud/xyz.h"
#include "knead/io/cloud/layout.h"
#include "knead/io/layout.h"

#include <algorithm>
#include <cmath>

#include "knead/io/colors.h"
#include "knead/io/corner_values.h"
#include "knead/io/cursor.h"
#include "knead/io/face_builder.h"
#include "knead/io/splice.h"

namespace knead::io_detail::xyz {
namespace {

bool is_separator(char c) { return c == ',' || c == ';'; }

// The words of each line, with blanks or one separator between them.
class Cursor {
 public:
  Cursor(std::string_view bytes, const std::string& name)
      : bytes_(bytes), text_(bytes, name, text_begin(bytes, name)) {}

  const TextCursor& text() const { return text_; }

  // The next word of this line; empty where the line, or the file, has no more.
  std::string_view next_on_line() {
    std::size_t begin = text_.position();
    std::size_t separators = 0;
    for (; begin < bytes_.size() && (is_blank(bytes_[begin]) || is_separator(bytes_[begin])); ++begin) {
      if (is_separator(bytes_[begin])) note_separator(bytes_[begin], separators);
    }
    std::size_t end = begin;
    if (!is_comment(begin)) end = word_end(begin);
    const std::string_view word = text_.take(begin, end);
    if (separators > (at_begin_ ? 0 : 1) && !word.empty()) text_.fail("expected a number between two separators");
    if (mixed_) text_.fail("commas and semicolons on one line; write numbers with points and one kind of separator");
    at_begin_ = false;
    return word;
  }

  bool next_line() {
    at_begin_ = true;
    separator_ = '\0';
    return text_.next_line();
  }

  // The first word of the next line that has any; empty at the end of the file.
  std::string_view next() {
    std::string_view word = next_on_line();
    while (word.empty() && next_line()) word = next_on_line();
    return word;
  }

 private:
  void note_separator(char c, std::size_t& count) {
    ++count;
    mixed_ = mixed_ || (separator_ != '\0' && separator_ != c);
    separator_ = c;
  }

  bool is_comment(std::size_t begin) const { return bytes_.substr(begin, 1) == "#" || bytes_.substr(begin, 2) == "//"; }

  std::size_t word_end(std::size_t begin) const {
    while (begin < bytes_.size() && !is_blank(bytes_[begin]) && !is_line_end(bytes_[begin]) &&
           !is_separator(bytes_[begin])) {
      ++begin;
    }
    return begin;
  }

  std::string_view bytes_;
  TextCursor text_;
  bool at_begin_ = true;  // of a line
  bool mixed_ = false;
  char separator_ = '\0';  // of this line
};

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name) : shape_(shape), name_(name), words_(shape.bytes, name) {}

  Layout run() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) read_line(word);
    const std::size_t count = shape_.mesh.vertex_count();
    if (layout_.has_count && count_ != count) {
      fail_at_line(name_, shape_.bytes, count_begin_,
                   std::to_string(count_) + " points are declared, but " + std::to_string(count) +
                       " follow; the file is cut short or damaged");
    }
    if (count == 0) throw InvalidInput(Place{name_}, "has no points (lines 'x y z'); there is no shape in it");
    add_attributes();
    add_notes();
    return layout_;
  }

 private:
  void read_line(std::string_view first) {
    std::string_view word = words_.next_on_line();
    if (word.empty() && shape_.mesh.positions.empty() && !layout_.has_count) {
      layout_.has_count = true;
      count_ = words_.text().whole(first, kMostElements, "x y z, or the number of points");
      count_begin_ = words_.text().position();
      return;
    }
    if (shape_.mesh.vertex_count() == kMostElements) words_.text().fail("more than 4294967295 points; split the shape");
    Vec3d p;
    p.x = words_.text().coordinate(first);
    p.y = words_.text().coordinate(word);
    p.z = words_.text().coordinate(words_.next_on_line());
    shape_.mesh.positions.push_back(p);
    read_columns();
  }

  void read_columns() {
    std::size_t columns = 0;
    for (std::string_view word = words_.next_on_line(); !word.empty(); word = words_.next_on_line()) {
      const double value = words_.text().real(word, "a number");
      ++columns;
      if (!layout_.columns_read) continue;
      columns_.push_back(std::isfinite(value) ? value : 0);
      if (!std::isfinite(value)) ++not_finite_;
    }
    if (shape_.mesh.vertex_count() == 1) width_ = columns;
    constexpr std::size_t most = 64;  // each is an attribute
    if (columns == width_ && columns <= most) return;
    layout_.columns_read = false;
    columns_ = {};
  }

  bool is_normal() const {
    std::size_t unit = 0;
    for (std::size_t i = 0; i < columns_.size(); i += 3) {
      constexpr double tolerance = 0.02;  // components may be written with two digits
      const double length = std::hypot(columns_[i], columns_[i + 1], columns_[i + 2]);
      if (std::abs(length - 1) < tolerance) ++unit;
    }
    return unit * 20 >= shape_.mesh.vertex_count() * 19;
  }

  bool is_color() const {
    return std::all_of(columns_.begin(), columns_.end(),
                       [](double c) { return c >= 0 && c <= 255 && c == std::floor(c); });
  }

  void add_attributes() {
    if (!layout_.columns_read || width_ == 0) return;
    std::vector<Attribute>& attributes = shape_.mesh.attributes;
    if (width_ == 3 && is_normal()) {
      attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, std::move(columns_)});
    } else if (width_ == 3 && is_color()) {
      attributes.push_back({"color", Domain::vertex, NumberType::uint8, 3, std::move(columns_)});
    } else {
      for (std::size_t c = 0; c < width_; ++c) add_column(c);
    }
  }

  void add_column(std::size_t column) {
    Attribute attribute{"column" + std::to_string(column + 4), Domain::vertex, NumberType::float64, 1, {}};
    attribute.values.reserve(shape_.mesh.vertex_count());
    for (std::size_t i = column; i < columns_.size(); i += width_) attribute.values.push_back(columns_[i]);
    shape_.mesh.attributes.push_back(std::move(attribute));
  }

  void add_notes() {
    if (!layout_.columns_read) {
      shape_.notes.push_back(
          "the numbers after x y z are kept but not read: lines differ in how many they have, or have more than 64");
    } else if (not_finite_ > 0) {
      shape_.notes.push_back(counted(not_finite_, "attribute value is not finite and is read as 0",
                                     "attribute values are not finite and are read as 0"));
    }
    shape_.notes.push_back("has no faces and is read as a point cloud");
  }

  ShapeFile& shape_;
  const std::string& name_;
  Cursor words_;
  Layout layout_;
  std::size_t count_ = 0;  // declared
  std::size_t count_begin_ = 0;
  std::size_t width_ = 0;        // numbers after x y z on a line
  std::vector<double> columns_;  // all of them, line by line
  std::size_t not_finite_ = 0;
};

// The one attribute that can stand after x y z.
std::optional<Attribute> held_attribute(const Mesh& mesh) {
  if (std::optional<Attribute> normal = vertex_attribute(mesh, "normal", 3)) return normal;
  if (std::optional<Attribute> color = vertex_attribute(mesh, "color", 3)) return color;
  return vertex_attribute(mesh, "color", 4);
}

}  // namespace

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "xyz";
  shape.bytes = std::move(bytes);
  set_layout(shape, Reader(shape, name).run());
  return shape;
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions&) {
  Splice splice(source.bytes);
  Cursor words(source.bytes, source.format);
  const auto next = [&] { return words.next(); };
  if (layout_of<Layout>(source).has_count) next();
  const Attribute* normal = normals.empty() ? nullptr : source.mesh.find_attribute("normal");
  for (std::size_t i = 0; i < positions.size(); ++i) {
    splice.replace_changed(source.mesh.positions[i], positions[i], next);
    if (normal != nullptr) {
      const double* old = normal->values.data() + 3 * i;
      splice.replace_changed({old[0], old[1], old[2]}, normals[i], next);
    }
    words.next_line();
  }
  return splice.finish();
}

std::string generate(const Mesh& mesh, const WriteOptions&) {
  const std::optional<Attribute> held = held_attribute(mesh);
  std::string text;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis > 0) text += ' ';
      append_real(text, mesh.positions[i][axis]);
    }
    for (std::size_t c = 0; held && c < 3; ++c) {
      const double value = held->values[i * static_cast<std::size_t>(held->components) + c];
      text += ' ';
      append_real(text, held->name == "color" ? as_byte(value, held->type) : value);
    }
    text += '\n';
  }
  return text;
}

std::vector<std::string> losses(const Mesh& mesh) {
  std::vector<std::string> losses;
  if (mesh.face_count() > 0) losses.push_back("XYZ cannot hold faces");
  const std::optional<Attribute> held = held_attribute(mesh);
  for (const Attribute& attribute : mesh.attributes) {
    if (!held || attribute.name != held->name || attribute.components != held->components) {
      losses.push_back("XYZ cannot hold '" + attribute.name + "'");
      continue;
    }
    if (attribute.name != "color") continue;
    if (attribute.components > 3) losses.push_back("XYZ cannot hold the alpha of colors");
    if (attribute.type != NumberType::uint8) losses.push_back("XYZ holds colors as whole numbers from 0 to 255");
  }
  return losses;
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  if (layout_of<Layout>(source).columns_read) return {};
  return {"the numbers after x y z are left out"};
}

}  // namespace knead::io_detail::xyz
