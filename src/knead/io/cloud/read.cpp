// Reading points in text.
#include <algorithm>
#include <cmath>
#include <optional>

#include "knead/io/cloud/layout.h"
#include "knead/io/cloud/words.h"
#include "knead/io/cloud/xyz.h"
#include "knead/io/face_builder.h"
#include "knead/io/layout.h"
#include "knead/io/unplaced.h"
#include "knead/math/elementary.h"

namespace knead::io_detail::xyz {
namespace {

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name) : shape_(shape), name_(name), words_(shape.bytes, name) {}

  Layout run() {
    read_beginning();
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) read_line(word);
    if (count_ && *count_ != rows_) {
      fail_at_line(name_, shape_.bytes, count_begin_,
                   std::to_string(*count_) + " points are declared, but " + std::to_string(rows_) +
                       " follow; the file is cut short or damaged");
    }
    if (rows_ == 0) throw InvalidInput(Place{name_}, "has no points (lines 'x y z'); there is no shape in it");
    if (shape_.mesh.positions.empty()) {
      throw InvalidInput(Place{name_}, "no point has finite coordinates; there is no shape in it");
    }
    add_attributes();
    add_notes();
    layout_.unplaced = std::move(unplaced_.rows);
    return std::move(layout_);
  }

 private:
  // The words of the line that begins with `first`; leaves the cursor at its end.
  std::vector<std::string_view> rest_of_line(std::string_view first) {
    std::vector<std::string_view> line;
    for (std::string_view word = first; !word.empty(); word = words_.next_on_line()) line.push_back(word);
    return line;
  }

  // Goes past the number of points and the names of the columns, of which each line holds one thing, to the points.
  void read_beginning() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      const std::size_t begin = words_.text().word_begin();
      const std::vector<std::string_view> line = rest_of_line(word);
      const bool has_numbers = std::any_of(line.begin(), line.end(), is_number);
      if (line.size() == 1 && !count_ && has_numbers) {
        count_ = words_.text().whole(word, kMostElements, "x y z, or the number of points");
        count_begin_ = begin;
      } else if (line.size() >= 3 && !has_numbers && !layout_.has_names) {
        layout_.has_names = true;
      } else {
        layout_.label_first = line.size() >= 4 && !is_number(word) && is_number(line[1]);
        words_.go_to(begin);
        layout_.points_begin = begin;
        return;
      }
    }
  }

  void read_line(std::string_view word) {
    if (rows_ == kMostElements) words_.text().fail("more than 4294967295 points; split the shape");
    const std::size_t begin = words_.text().word_begin();
    if (layout_.label_first) word = words_.next_on_line();
    Vec3d p;
    for (std::size_t axis = 0; axis < 3; ++axis, word = words_.next_on_line()) {
      p[axis] = words_.text().real(word, "a coordinate");
    }
    if (is_finite(p)) {
      shape_.mesh.positions.push_back(p);
      read_columns(word);
    } else {
      unplaced_.add(rows_, begin);
      rest_of_line(word);
    }
    ++rows_;
  }

  void read_columns(std::string_view word) {
    std::size_t columns = 0;
    for (; !word.empty(); word = words_.next_on_line()) {
      double value = 0;
      const ParseResult result = parse_real(word, value);
      if (result == ParseResult::malformed) layout_.labels = true;
      if (result == ParseResult::malformed) continue;
      value = words_.text().real(word, "a number");
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
      const double length = elementary::hypot(columns_[i], columns_[i + 1], columns_[i + 2]);
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

  // Says which columns are the coordinates, where it could be others.
  void add_columns_note() {
    const std::vector<Attribute>& attributes = shape_.mesh.attributes;
    const bool has_others = !layout_.columns_read || width_ > 0 || layout_.labels || layout_.label_first;
    if (!has_others || (!attributes.empty() && attributes[0].name == "normal")) return;
    shape_.notes.emplace_back(layout_.label_first
                                  ? "x y z are the columns 2, 3 and 4; a line with names can say otherwise"
                                  : "x y z are the columns 1, 2 and 3; a line with names can say otherwise");
  }

  void add_notes() {
    if (layout_.has_names) shape_.notes.emplace_back("a line names the columns; it is kept but not read");
    add_columns_note();
    if (layout_.label_first || layout_.labels) {
      shape_.notes.emplace_back("words that are no numbers stand beside the coordinates; they are kept but not read");
    }
    if (!unplaced_.rows.empty()) shape_.notes.push_back(unplaced_note(unplaced_.rows.size()));
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
  Words words_;
  Layout layout_;
  Unplaced unplaced_;
  std::size_t rows_ = 0;              // of points, with those that have no place
  std::optional<std::size_t> count_;  // declared
  std::size_t count_begin_ = 0;
  std::size_t width_ = 0;        // numbers after x y z on a line
  std::vector<double> columns_;  // all of them, line by line
  std::size_t not_finite_ = 0;
};

}  // namespace

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "xyz";
  shape.bytes = std::move(bytes);
  const std::optional<TableStart> table = find_table(shape.bytes, name);
  set_layout(shape, table ? read_table(shape, *table, name) : Reader(shape, name).run());
  return shape;
}

}  // namespace knead::io_detail::xyz
