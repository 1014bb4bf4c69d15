// Reading points in text: tables whose columns have names, molecules, and lines of numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "io/cloud/cloud.h"
#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "math/elementary.h"

namespace knead::detail::xyz {
namespace {

// A column that is no coordinate.
struct Column {
  std::size_t place = 0;
  std::string name;
  bool is_read = true;  // all its fields are numbers, or empty
  std::vector<double> values;
};

// Throws InvalidInput where another number of points is declared, in the line that begins at `begin`, than follow.
void check_declared(std::size_t count, std::size_t rows, std::size_t begin, std::string_view bytes,
                    const std::string& name) {
  if (count == rows) return;
  fail_at_line(name, bytes, begin,
               fmt::format("{} points are declared, but {} follow; {}", count, rows,
                           count > rows ? "the file is cut short or damaged"
                                        : "correct the number, or remove the lines that are too many"));
}

// Throws InvalidInput where no point of a file has a place.
void require_placed(const Mesh& mesh, const std::string& name) {
  if (!mesh.positions.empty()) return;
  throw InvalidInput(Place{name}, "no point has finite coordinates; there is no shape in it");
}

bool are_bytes(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double c) { return c >= 0 && c <= 255 && c == std::floor(c); });
}

class TableReader {
 public:
  TableReader(ShapeFile& shape, const TableStart& start, const std::string& name)
      : shape_(shape), start_(start), name_(name), text_(shape.bytes, name) {
    layout_.points_begin = start.points_begin;
    layout_.table = start.columns;
    layout_.has_names = !start.columns.names.empty();
  }

  Layout run() {
    Rows rows(shape_.bytes, start_.points_begin, start_.columns.separator);
    while (rows.next()) read_row(rows);
    check_count();
    require_placed(shape_.mesh, name_);
    add_normals();
    add_colors();
    add_columns();
    add_notes();
    layout_.unplaced = std::move(unplaced_.rows);
    return std::move(layout_);
  }

 private:
  using Fields = std::vector<std::string_view>;

  void check_count() const {
    if (!start_.count_begin) return;
    const std::string_view line = std::string_view(shape_.bytes).substr(*start_.count_begin);
    const std::string_view word = trimmed(line.substr(0, line.find_first_of("\r\n")));
    const std::size_t count = text_.whole(word, kMaxElements, "x y z, or the number of points");
    check_declared(count, rows_, *start_.count_begin, shape_.bytes, name_);
  }

  // The places of all columns but the coordinates, from the first row.
  void plan(const Fields& fields) {
    const std::array<std::size_t, 3>& position = start_.columns.position;
    const std::vector<std::string>& names = start_.columns.names;
    const std::size_t width = std::max(fields.size(), names.size());
    for (std::size_t place = 0; place < width; ++place) {
      if (std::find(position.begin(), position.end(), place) != position.end()) continue;
      columns_.push_back({place, place < names.size() ? names[place] : "", true, {}});
    }
    constexpr std::size_t most = 64;  // each is an attribute
    layout_.columns_read = columns_.size() <= most;
    if (!layout_.columns_read) columns_.clear();
  }

  void read_row(const Rows& rows) {
    if (rows_ == kMaxElements) fail_at_line(name_, shape_.bytes, rows.begin(), "more than 4294967295 points");
    const Fields& fields = rows.fields();
    if (rows_ == 0) plan(fields);
    Vec3d p;
    for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = coordinate(rows, start_.columns.position[axis]);
    if (is_finite(p)) {
      shape_.mesh.positions.push_back(p);
      for (Column& column : columns_) read_column(column, fields);
    } else {
      unplaced_.add(rows_, rows.begin());
    }
    ++rows_;
  }

  // A coordinate that is left empty is missing, as NaN is.
  double coordinate(const Rows& rows, std::size_t column) const {
    const Fields& fields = rows.fields();
    if (column >= fields.size()) {
      fail_at_line(name_, shape_.bytes, rows.begin(),
                   fmt::format("the line has no column {}, a coordinate", column + 1));
    }
    const std::string_view word = fields[column];
    if (word.empty()) return std::numeric_limits<double>::quiet_NaN();
    const bool is_decimal_comma = start_.columns.separator != ',' && word.find(',') != std::string_view::npos;
    if (is_decimal_comma) {
      fail_at_line(name_, shape_.bytes, rows.begin(),
                   "the coordinate " + in_quotes(word) + " has a comma; write decimals with points, not commas");
    }
    return text_.real(word, "a coordinate");
  }

  void read_column(Column& column, const Fields& fields) {
    if (!column.is_read) return;
    const std::string_view word = column.place < fields.size() ? fields[column.place] : std::string_view{};
    double value = std::numeric_limits<double>::quiet_NaN();
    if (!word.empty() && parse_real(word, value) != ParseResult::ok) {
      column.is_read = false;
      layout_.labels = true;
      column.values = {};
      return;
    }
    column.values.push_back(finite_(value));
  }

  // The columns of those names, in any case; empty if not all three are read.
  std::vector<Column*> named(std::array<std::string_view, 3> names) {
    std::vector<Column*> found;
    for (const std::string_view name : names) {
      const auto is_it = [&](const Column& column) { return column.is_read && lower(column.name) == name; };
      const auto column = std::find_if(columns_.begin(), columns_.end(), is_it);
      if (column == columns_.end()) return {};
      found.push_back(&*column);
    }
    return found;
  }

  void add_three(const std::string& attribute, NumberType type, const std::vector<Column*>& columns) {
    Attribute added{attribute, Domain::vertex, type, 3, {}};
    added.values.reserve(3 * shape_.mesh.vertex_count());
    for (std::size_t i = 0; i < shape_.mesh.vertex_count(); ++i) {
      for (const Column* column : columns) added.values.push_back(column->values[i]);
    }
    for (Column* column : columns) column->is_read = false;
    shape_.mesh.attributes.push_back(std::move(added));
  }

  void add_normals() {
    using Three = std::array<std::string_view, 3>;
    for (const Three& names : {Three{"nx", "ny", "nz"}, Three{"normal_x", "normal_y", "normal_z"},
                               Three{"normalx", "normaly", "normalz"}, Three{"normals:0", "normals:1", "normals:2"}}) {
      const std::vector<Column*> columns = named(names);
      if (columns.empty()) continue;
      for (const Column* column : columns) layout_.normal.push_back(column->place);
      return add_three("normal", NumberType::float32, columns);
    }
  }

  void add_colors() {
    using Three = std::array<std::string_view, 3>;
    for (const Three& names : {Three{"r", "g", "b"}, Three{"red", "green", "blue"}}) {
      const std::vector<Column*> columns = named(names);
      const auto is_color = [](const Column* column) { return are_bytes(column->values); };
      if (columns.empty() || !std::all_of(columns.begin(), columns.end(), is_color)) continue;
      return add_three("color", NumberType::uint8, columns);
    }
  }

  void add_columns() {
    std::vector<Attribute>& attributes = shape_.mesh.attributes;
    for (Column& column : columns_) {
      if (!column.is_read) continue;
      const bool is_reserved = column.name.empty() || column.name == "normal" || column.name == "color" ||
                               column.name == "uv" || shape_.mesh.find_attribute(column.name) != nullptr;
      const std::string name = is_reserved ? fmt::format("column{}", column.place + 1) : column.name;
      if (shape_.mesh.find_attribute(name) != nullptr) continue;
      attributes.push_back({name, Domain::vertex, NumberType::float64, 1, std::move(column.values)});
    }
  }

  void add_notes() {
    const std::array<std::size_t, 3>& at = start_.columns.position;
    const char* names = layout_.has_names ? "a line names the columns: " : "";
    shape_.notes.push_back(
        fmt::format("{}x y z are the columns {}, {} and {}", names, at[0] + 1, at[1] + 1, at[2] + 1));
    if (layout_.labels) shape_.notes.emplace_back("columns with words that are no numbers are kept but not read");
    if (!layout_.columns_read)
      shape_.notes.emplace_back("lines have more than 64 other columns; they are kept but not read");
    if (!unplaced_.rows.empty()) shape_.notes.push_back(unplaced_note(unplaced_.rows.size()));
    finite_.append_note(shape_.notes);
    shape_.notes.emplace_back(kCloudNote);
  }

  ShapeFile& shape_;
  const TableStart& start_;
  const std::string& name_;
  TextCursor text_;
  Layout layout_;
  Unplaced unplaced_;
  std::vector<Column> columns_;
  std::size_t rows_ = 0;  // with those that have no place
  FiniteValues finite_;
};

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name) : shape_(shape), name_(name), words_(shape.bytes, name) {}

  Layout run() {
    read_beginning();
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) read_line(word);
    if (count_) check_declared(*count_, rows_, count_begin_, shape_.bytes, name_);
    if (rows_ == 0) throw InvalidInput(Place{name_}, "has no points (lines 'x y z'); there is no shape in it");
    require_placed(shape_.mesh, name_);
    add_attributes();
    add_notes();
    layout_.unplaced = std::move(unplaced_.rows);
    return std::move(layout_);
  }

 private:
  // The words of the line that begins with `first`; leaves the cursor at its end.
  std::vector<std::string_view> suffix_of_line(std::string_view first) {
    std::vector<std::string_view> line;
    for (std::string_view word = first; !word.empty(); word = words_.next_on_line()) line.push_back(word);
    return line;
  }

  // Goes past the number of points and the names of the columns, of which each line holds one thing, to the points.
  void read_beginning() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      const std::size_t begin = words_.text().word_begin();
      const std::vector<std::string_view> line = suffix_of_line(word);
      const bool has_numbers = std::any_of(line.begin(), line.end(), is_number);
      if (line.size() == 1 && !count_ && has_numbers) {
        count_ = words_.text().whole(word, kMaxElements, "x y z, or the number of points");
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
    if (rows_ == kMaxElements) words_.text().fail("more than 4294967295 points; split the shape");
    const std::size_t begin = words_.text().word_begin();
    if (layout_.label_first) word = words_.next_on_line();
    Vec3d p;
    for (std::size_t axis = 0; axis < 3; ++axis, word = words_.next_on_line()) {
      if (axis == 1 && word.empty() && count_ == rows_) {
        fail_at_line(name_, shape_.bytes, begin, "a second scan begins here; put each scan into a file of its own");
      }
      p[axis] = words_.text().real(word, "a coordinate");
    }
    if (is_finite(p)) {
      shape_.mesh.positions.push_back(p);
      read_columns(word);
    } else {
      unplaced_.add(rows_, begin);
      suffix_of_line(word);
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
      columns_.push_back(finite_(value));
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

  void add_attributes() {
    if (!layout_.columns_read || width_ == 0) return;
    std::vector<Attribute>& attributes = shape_.mesh.attributes;
    if (width_ == 3 && is_normal()) {
      attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, std::move(columns_)});
    } else if (width_ == 3 && are_bytes(columns_)) {
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
    if (layout_.label_first && looks_like_obj(std::string_view(shape_.bytes).substr(0, 4096))) {
      shape_.notes.emplace_back(
          "its lines are those of an OBJ file, of which each is read as a point; if it is one, let "
          "its name end in .obj");
    }
    add_columns_note();
    if (layout_.label_first || layout_.labels) {
      shape_.notes.emplace_back("words that are no numbers stand beside the coordinates; they are kept but not read");
    }
    if (!unplaced_.rows.empty()) shape_.notes.push_back(unplaced_note(unplaced_.rows.size()));
    if (!layout_.columns_read) {
      shape_.notes.push_back(
          "the numbers after x y z are kept but not read: lines differ in how many they have, or have more than 64");
    } else {
      finite_.append_note(shape_.notes);
    }
    shape_.notes.emplace_back(kCloudNote);
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
  FiniteValues finite_;
};

}  // namespace

void read(ShapeFile& shape, const std::string& name) {
  const std::optional<TableStart> table = find_table(shape.bytes, name);
  set_layout(shape, table ? TableReader(shape, *table, name).run() : Reader(shape, name).run());
}

}  // namespace knead::detail::xyz
