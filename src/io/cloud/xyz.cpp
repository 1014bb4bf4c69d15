#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "io/cloud/cloud.h"
#include "io/formats.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/text.h"

namespace knead::io_detail::ptx {
namespace {

Mat3d inverse_of(const Mat3d& m) {
  const double volume = determinant(m);
  return {cross(m.column(1), m.column(2)) / volume, cross(m.column(2), m.column(0)) / volume,
          cross(m.column(0), m.column(1)) / volume};
}

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name)
      : shape_(shape), name_(name), text_(shape.bytes, name, text_begin(shape.bytes, name)) {}

  Layout run() {
    for (std::string_view word = text_.next(); !word.empty(); word = text_.next()) read_scan(word);
    if (rows_ == 0) throw InvalidInput(Place{name_}, "has no scans (lines of columns, rows and poses); is it PTX?");
    if (shape_.mesh.positions.empty()) {
      throw InvalidInput(Place{name_}, "no direction has a point; there is no shape in it");
    }
    add_attributes();
    add_notes();
    return std::move(layout_);
  }

 private:
  void read_scan(std::string_view word) {
    Scan scan;
    const std::size_t columns = text_.whole(word, kMaxElements, "the number of columns of a scan");
    end_line();
    const std::size_t rows = text_.whole(text_.next(), kMaxElements, "the number of rows of a scan");
    end_line();
    for (int line = 0; line < 4; ++line) read_numbers(3);  // the scanner's position and axes, which the matrix repeats
    std::array<Vec3d, 3> row;
    for (Vec3d& v : row) v = read_numbers(4);
    scan.offset = read_numbers(4);
    scan.linear = {{row[0].x, row[1].x, row[2].x}, {row[0].y, row[1].y, row[2].y}, {row[0].z, row[1].z, row[2].z}};
    scan.inverse = inverse_of(scan.linear);
    if (!is_finite(scan.inverse.row0 + scan.inverse.row1 + scan.inverse.row2) || !is_finite(scan.offset)) {
      text_.fail("the matrix of a scan has no inverse; repair the file");
    }
    const std::size_t left = shape_.bytes.size() - text_.position();
    constexpr std::size_t least = 6;  // bytes of a line
    if (columns * rows > left / least + 1 || rows_ + columns * rows > kMaxElements) {
      text_.fail(std::to_string(columns) + " times " + std::to_string(rows) + " lines are declared, but only " +
                 std::to_string(left) + " bytes follow; the file is cut short or damaged");
    }
    scan.begin = text_.position();
    scan.rows = columns * rows;
    for (std::size_t i = 0; i < scan.rows; ++i) read_point(scan);
    layout_.scans.push_back(scan);
  }

  void end_line() {
    const std::string_view more = text_.next_on_line();
    if (!more.empty()) text_.fail("expected the end of the line, found " + in_quotes(more) + "; is it a PTX file?");
  }

  Vec3d read_numbers(std::size_t count) {
    Vec3d v;
    std::string_view word = text_.next();
    for (std::size_t i = 0; i < count; ++i, word = i < count ? text_.next_on_line() : word) {
      const double value = text_.real(word, "a number of the scanner's pose");
      if (i < 3) v[i] = value;
    }
    end_line();
    return v;
  }

  void read_point(const Scan& scan) {
    std::string_view word = text_.next();
    const std::size_t begin = text_.word_begin();
    Vec3d local;
    for (std::size_t axis = 0; axis < 3; ++axis, word = text_.next_on_line()) {
      local[axis] = text_.real(word, "a coordinate");
    }
    std::array<double, 4> more{};
    std::size_t count = 0;
    for (; !word.empty(); word = text_.next_on_line(), ++count) {
      const double value = text_.real(word, "a number");
      if (count < more.size()) more[count] = value;
    }
    const Vec3d world = scan.is_identity() ? local : scan.linear * local + scan.offset;
    if (local == Vec3d{} || !is_finite(world)) {
      unplaced_.add(rows_++, begin);
      return;
    }
    ++rows_;
    shape_.mesh.positions.push_back(world);
    if (shape_.mesh.vertex_count() == 1) width_ = count;
    same_width_ = same_width_ && width_ == count;
    intensities_.push_back(finite(more[0]));
    for (std::size_t c = 1; c < 4; ++c) colors_.push_back(finite(more[c]));
    for (std::size_t c = 1; c < 4; ++c) {
      are_bytes_ = are_bytes_ && more[c] >= 0 && more[c] <= 255 && more[c] == std::floor(more[c]);
    }
  }

  double finite(double value) {
    if (std::isfinite(value)) return value;
    ++not_finite_;
    return 0;
  }

  void add_attributes() {
    layout_.columns_read = same_width_ && (width_ == 0 || width_ == 1 || (width_ == 4 && are_bytes_));
    if (!same_width_ || width_ == 0) return;
    shape_.mesh.attributes.push_back({"intensity", Domain::vertex, NumberType::float64, 1, std::move(intensities_)});
    if (width_ != 4 || !are_bytes_) return;
    shape_.mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 3, std::move(colors_)});
  }

  void add_notes() {
    std::vector<std::string>& notes = shape_.notes;
    if (layout_.scans.size() > 1)
      notes.push_back(std::to_string(layout_.scans.size()) + " scans are read as one shape");
    if (!unplaced_.rows.empty()) {
      notes.push_back(counted(unplaced_.rows.size(), "direction has no point; its line is kept and does not move",
                              "directions have no point; their lines are kept and do not move"));
    }
    if (!layout_.columns_read) notes.emplace_back("some numbers after x y z are kept but not read");
    if (not_finite_ > 0) {
      notes.push_back(counted(not_finite_, "attribute value is not finite and is read as 0",
                              "attribute values are not finite and are read as 0"));
    }
    notes.emplace_back("has no faces and is read as a point cloud");
    layout_.unplaced = std::move(unplaced_.rows);
  }

  ShapeFile& shape_;
  const std::string& name_;
  TextCursor text_;
  Layout layout_;
  Unplaced unplaced_;
  std::size_t rows_ = 0;   // of points, so far
  std::size_t width_ = 0;  // numbers after x y z
  bool same_width_ = true;
  bool are_bytes_ = true;  // the last three of four
  std::vector<double> intensities_;
  std::vector<double> colors_;
  std::size_t not_finite_ = 0;
};

// Calls visit(scan, point, words) for the three words of each point that the mesh has.
template <class Visit>
void for_each_point(const ShapeFile& source, Visit visit) {
  const Layout& layout = layout_of<Layout>(source);
  std::size_t row = 0;
  std::size_t point = 0;
  for (const Scan& scan : layout.scans) {
    TextCursor text(source.bytes, source.format, scan.begin);
    for (std::size_t i = 0; i < scan.rows; ++i, ++row, text.next_line()) {
      const std::string_view first = text.next();
      const bool is_unplaced = row - point < layout.unplaced.size() && layout.unplaced[row - point] == row;
      if (is_unplaced) continue;
      const std::string_view second = text.next_on_line();
      visit(scan, point++, std::array{first, second, text.next_on_line()});
    }
  }
}

}  // namespace

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "ptx";
  shape.bytes = std::move(bytes);
  set_layout(shape, Reader(shape, name).run());
  return shape;
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d>,
                    const WriteOptions& options) {
  Splice splice(source.bytes, options.decimals);
  for_each_point(source, [&](const Scan& scan, std::size_t point, const std::array<std::string_view, 3>& words) {
    if (positions[point] == source.mesh.positions[point]) return;
    Vec3d old;
    for (std::size_t axis = 0; axis < 3; ++axis) parse_real(words[axis], old[axis]);  // read before: well formed
    Vec3d local = scan.is_identity() ? positions[point] : scan.inverse * (positions[point] - scan.offset);
    if (local == Vec3d{}) local.z = std::numeric_limits<double>::min();  // 0 0 0 would be no point
    if (!is_finite(local)) {
      throw InvalidInput("point " + std::to_string(point) + " has moved further than its scan's numbers reach");
    }
    std::size_t next = 0;
    splice.replace_changed(old, local, [&] { return words[next++]; });
  });
  return splice.finish();
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::string> losses{"the scanner's rows, columns and poses are left out"};
  if (!layout.columns_read) losses.emplace_back("some numbers after x y z are left out");
  if (!layout.unplaced.empty()) losses.emplace_back("directions without a point are left out");
  return losses;
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  for_each_point(source, [&](const Scan&, std::size_t, const std::array<std::string_view, 3>& words) {
    for (const std::string_view word : words) visit(word);
  });
}

}  // namespace knead::io_detail::ptx

namespace knead::io_detail::xyz {
namespace {

std::string_view next_number(Words& words) {
  std::string_view word = words.next_on_line();
  while (!word.empty() && !is_number(word)) word = words.next_on_line();
  return word;
}

// Calls visit(row's fields, number of the point) for each point of a table that the mesh has.
template <class Visit>
void for_each_point(const ShapeFile& source, const Visit& visit) {
  const Layout& layout = layout_of<Layout>(source);
  Rows rows(source.bytes, layout.points_begin, layout.table->separator);
  std::size_t point = 0;
  for (std::size_t row = 0; rows.next(); ++row) {
    const bool is_unplaced = row - point < layout.unplaced.size() && layout.unplaced[row - point] == row;
    if (!is_unplaced) visit(rows.fields(), point++);
  }
}

std::string rewrite_table(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                          const WriteOptions& options) {
  const Layout& layout = layout_of<Layout>(source);
  struct Change {
    std::string_view word;
    double from = 0;
    double to = 0;
    bool is_normal = false;
  };
  Splice splice(source.bytes, options.decimals);
  const Attribute* normal = normals.empty() ? nullptr : source.mesh.find_attribute("normal");
  for_each_point(source, [&](const std::vector<std::string_view>& fields, std::size_t point) {
    std::vector<Change> changes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from = source.mesh.positions[point][axis];
      changes.push_back({fields[layout.table->position[axis]], from, positions[point][axis]});
    }
    for (std::size_t axis = 0; axis < layout.normal.size() && normal != nullptr; ++axis) {
      if (layout.normal[axis] >= fields.size() || fields[layout.normal[axis]].empty()) continue;
      const double from = normal->values[3 * point + axis];
      changes.push_back({fields[layout.normal[axis]], from, normals[point][axis], true});
    }
    const auto is_before = [](const Change& a, const Change& b) { return a.word.data() < b.word.data(); };
    std::sort(changes.begin(), changes.end(), is_before);
    for (const Change& change : changes) {
      if (change.is_normal) splice.replace_component(change.word, change.from, change.to);
      if (!change.is_normal) splice.replace_coordinate(change.word, change.from, change.to);
    }
  });
  return splice.finish();
}

// The one attribute that can stand after x y z.
std::optional<Attribute> held_attribute(const Mesh& mesh) {
  if (std::optional<Attribute> normal = vertex_attribute(mesh, "normal", 3)) return normal;
  if (std::optional<Attribute> color = vertex_attribute(mesh, "color", 3)) return color;
  return vertex_attribute(mesh, "color", 4);
}

}  // namespace

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options) {
  const Layout& layout = layout_of<Layout>(source);
  if (layout.table) return rewrite_table(source, positions, normals, options);
  Splice splice(source.bytes, options.decimals);
  Words words(source.bytes, source.format);
  words.go_to(layout.points_begin);
  const Attribute* normal = normals.empty() ? nullptr : source.mesh.find_attribute("normal");
  std::size_t point = 0;
  for (std::size_t row = 0; row < positions.size() + layout.unplaced.size(); ++row, words.next_line()) {
    const bool is_unplaced = row - point < layout.unplaced.size() && layout.unplaced[row - point] == row;
    std::string_view first = words.next();
    if (is_unplaced) continue;
    if (layout.label_first) first = words.next_on_line();
    const auto next = [&] { return first.empty() ? words.next_on_line() : std::exchange(first, {}); };
    splice.replace_changed(source.mesh.positions[point], positions[point], next);
    if (normal != nullptr) {
      const double* old = normal->values.data() + 3 * point;
      splice.replace_direction({old[0], old[1], old[2]}, normals[point], [&] { return next_number(words); });
    }
    ++point;
  }
  return splice.finish();
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  const Layout& layout = layout_of<Layout>(source);
  if (layout.table) {
    for_each_point(source, [&](const std::vector<std::string_view>& fields, std::size_t) {
      for (const std::size_t column : layout.table->position) visit(fields[column]);
    });
    return;
  }
  Words words(source.bytes, source.format);
  words.go_to(layout.points_begin);
  for (std::size_t i = source.mesh.vertex_count() + layout.unplaced.size(); i > 0; --i, words.next_line()) {
    std::string_view word = words.next();
    if (layout.label_first) word = words.next_on_line();
    for (std::size_t axis = 0; axis < 3; ++axis, word = words.next_on_line()) visit(word);
  }
}

std::string generate(const Mesh& mesh, const WriteOptions& options) {
  const std::optional<Attribute> held = held_attribute(mesh);
  std::string text;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis > 0) text += ' ';
      append_decimals(text, mesh.positions[i][axis], options.decimals);
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
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::string> losses;
  if (!layout.columns_read) losses.emplace_back("the numbers after x y z are left out");
  if (layout.has_names) losses.emplace_back("the names of the columns are left out");
  if (layout.labels || layout.label_first) losses.emplace_back("words that are no numbers are left out");
  if (!layout.unplaced.empty()) losses.push_back(unplaced_loss(layout.unplaced.size()));
  return losses;
}

}  // namespace knead::io_detail::xyz
