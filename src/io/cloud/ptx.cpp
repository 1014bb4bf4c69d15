// PTX, the text files of laser scanners. A file has one or more scans, each of ten lines (columns, rows, the scanner's
// pose twice) and a line x y z intensity [red green blue] for each of its directions.
#include <array>
#include <cmath>
#include <limits>

#include "io/cloud/cloud.h"
#include "io/mesh_builder.h"
#include "io/text.h"
#include "knead/error.h"
#include "math/geometry.h"

namespace knead::detail::ptx {
namespace {

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
    scan.inverse = inverse(scan.linear);
    if (!is_finite(scan.inverse.row0 + scan.inverse.row1 + scan.inverse.row2) || !is_finite(scan.offset)) {
      text_.fail("the matrix of a scan has no inverse; repair the file");
    }
    const std::size_t left = shape_.bytes.size() - text_.position();
    constexpr std::size_t least = 6;  // bytes of a line
    if (columns * rows > left / least + 1 || rows_ + columns * rows > kMaxElements) {
      text_.fail(too_many(std::to_string(columns) + " times " + std::to_string(rows) + " lines", left));
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
    intensities_.push_back(finite_(more[0]));
    for (std::size_t c = 1; c < 4; ++c) colors_.push_back(finite_(more[c]));
    for (std::size_t c = 1; c < 4; ++c) {
      are_bytes_ = are_bytes_ && more[c] >= 0 && more[c] <= 255 && more[c] == std::floor(more[c]);
    }
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
    finite_.append_note(notes);
    notes.emplace_back(kCloudNote);
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
  FiniteValues finite_;
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
      if (is_unplaced(layout.unplaced, row, point)) continue;
      const std::string_view second = text.next_on_line();
      visit(scan, point++, std::array{first, second, text.next_on_line()});
    }
  }
}

// The points in world coordinates. Directions from which nothing came back, 0 0 0 or coordinates that are not finite,
// are left out of the mesh. Attributes: "intensity", and "color" (3) if every line has one.
void read(ShapeFile& shape, const std::string& name) { set_layout(shape, Reader(shape, name).run()); }

// Replaces the numbers, in the coordinates of its scan, of each point that moved.
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

}  // namespace
}  // namespace knead::detail::ptx

const knead::detail::Codec knead::detail::ptx_codec{.name = "ptx",
                                                    .read = ptx::read,
                                                    .rewrite = ptx::rewrite,
                                                    .source_losses = ptx::source_losses,
                                                    .visit_coordinates = ptx::visit_coordinates};
