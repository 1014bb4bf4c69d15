// PLY (Turk 1994), text and binary: what the header declares, the numbers after it, and where they go in a mesh.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "knead/io.h"
#include "knead/mesh.h"

namespace knead::detail::ply {

struct Property {
  std::string name;
  StoredType type = StoredType::float32;  // of the number, or of the list's items
  bool is_list = false;
  StoredType count_type = StoredType::uint8;  // of a list's length
  std::size_t type_begin = 0;                 // the bytes of the word for `type` in the header
  std::size_t type_end = 0;
  std::size_t line_begin = 0;  // the bytes of the line, with its end
  std::size_t line_end = 0;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
  std::size_t count_begin = 0;  // the bytes of the word for `count` in the header
  std::size_t count_end = 0;
  std::size_t line_begin = 0;  // the bytes of the line, with its end
  std::size_t line_end = 0;
  std::size_t rows_begin = 0;  // the bytes of its rows; in text from the end of the line before to that of the last
  std::size_t rows_end = 0;
};

enum class Encoding { ascii, little_endian, big_endian };

struct Layout {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t body_begin = 0;      // the byte after the header
  std::size_t vertex_element = 0;  // index of the element "vertex"
  std::size_t vertex_begin = 0;    // the first byte of its first row; in text, a blank or line end before it at most
  std::vector<std::uint32_t> unplaced;  // rows of vertices that the mesh lacks (mesh_builder.h)
  bool surplus = false;                 // lines have more numbers than the header declares
  std::vector<std::string> notes;       // on the header
};

// The functions of the format's Codec.
void read(ShapeFile& shape, const std::string& name);
bool read_in_pieces(ShapeFile& shape, const std::string& name);
std::optional<ShapeSummary> summarize(const ShapeFile& source, const std::string& name);
void rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
             const WriteOptions& options, const ByteSink& out);
std::string with_copies(const ShapeFile& source, std::span<const std::uint32_t> vertices);
bool writes_edits(const ShapeFile& source);
bool stores_floats(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

// Reads the header: encoding, elements and properties, and where the body begins. Throws
// InvalidInput that names the line.
Layout parse_header(std::string_view bytes, const std::string& name);

// "float", "uchar", ...
std::string_view type_name(StoredType type);

// Returns the type in new files for numbers of that type.
StoredType stored_type(NumberType type);

inline bool is_swapped(Encoding encoding) {
  return (encoding == Encoding::big_endian) == (std::endian::native == std::endian::little);
}

// Returns the message on a list of an element whose length is no count of items, `left` bytes before the end of the
// file.
std::string not_a_length(double length, const Element& element, std::size_t left);

// Return whether a number can be the index of a vertex, and the message on one that cannot.
inline bool is_index(double value) { return value == std::floor(value) && std::abs(value) <= 0x1p32; }
std::string not_an_index(double value);

// The numbers after the header, one after the other. Both bodies, in binary and in text, have the same members.
class BinaryBody {
 public:
  // The bytes must outlive the body.
  BinaryBody(SourceBytes& bytes, const Layout& layout, const std::string& name)
      : bytes_(bytes),
        size_(bytes.size()),
        position_(layout.body_begin),
        window_begin_(position_),
        swapped_(is_swapped(layout.encoding)),
        name_(name) {}

  static constexpr bool kAscii = false;
  std::size_t position() const { return position_; }
  std::size_t left() const { return size_ - position_; }
  bool swapped() const { return swapped_; }
  [[noreturn]] void fail(const std::string& what) const { fail_at_byte(name_, position_, what); }
  [[noreturn]] void fail_at(std::size_t position, const std::string& what) const {
    fail_at_byte(name_, position, what);
  }

  // Returns the next bytes, which are valid until more are asked for; the caller has checked that they are there.
  const char* data(std::size_t count) {
    if (position_ + count > window_begin_ + window_.size()) {
      window_ = bytes_.piece(position_, std::min(left(), std::max(count, kWindow)));
      window_begin_ = position_;
    }
    return window_.data() + (position_ - window_begin_);
  }

  // Returns the next bytes and moves behind them.
  const char* skip(std::size_t count) {
    const char* const from = data(count);
    position_ += count;
    return from;
  }

  void begin_row() {}
  bool end_row() { return false; }

  double number(StoredType type, const Element& element) {
    const std::size_t size = size_of(type);
    if (left() < size) fail_missing(element);
    return read_binary(skip(size), type, swapped_);
  }

  std::size_t length(const Property& property, const Element& element) {
    if (left() < size_of(property.count_type)) fail_missing(element);
    const std::size_t value = length_at(0, property, element);
    skip(size_of(property.count_type));
    return value;
  }

  // Returns the length of the list that begins `offset` bytes after the position; its count must be within the file.
  std::size_t length_at(std::size_t offset, const Property& property, const Element& element) {
    const std::size_t end = offset + size_of(property.count_type);
    const double value = read_binary(data(end) + offset, property.count_type, swapped_);
    const std::size_t most = (left() - end) / size_of(property.type);
    if (!(value >= 0) || value > static_cast<double>(most)) {
      fail_at(position_ + offset, not_a_length(value, element, left() - offset));
    }
    return static_cast<std::size_t>(value);
  }

  // The items of a list whose length was just read.
  void indices(const Property& property, std::size_t count, const Element&, std::vector<std::int64_t>& items) {
    items.resize(count);
    visit_type(property.type, [&](auto value) {
      const char* from = skip(count * sizeof value);
      for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(&value, from + i * sizeof value, sizeof value);
        if (swapped_) value = swap_bytes(value);
        if constexpr (std::is_floating_point_v<decltype(value)>) {
          if (!is_index(double{value})) fail_index(double{value});
        }
        // NOLINTNEXTLINE(bugprone-signed-char-misuse): a number, no character
        items[i] = static_cast<std::int64_t>(value);
      }
    });
  }

  void skip_list(const Property& property, std::size_t count, const Element&) { skip(count * size_of(property.type)); }

  [[noreturn]] void fail_missing(const Element& element) const;

 private:
  [[noreturn]] void fail_index(double value) const { fail(not_an_index(value)); }

  static constexpr std::size_t kWindow = std::size_t{1} << 20;  // bytes that are read at a time

  SourceBytes& bytes_;
  std::size_t size_;
  std::size_t position_;
  std::string_view window_;  // of the bytes
  std::size_t window_begin_;
  bool swapped_;
  const std::string& name_;
};

class TextBody {
 public:
  TextBody(std::string_view bytes, const Layout& layout, const std::string& name)
      : bytes_(bytes), position_(layout.body_begin), name_(name) {}

  static constexpr bool kAscii = true;
  std::size_t position() const { return position_; }
  std::size_t left() const { return bytes_.size() - position_; }
  [[noreturn]] void fail(const std::string& what) const { fail_at_line(name_, bytes_, position_, what); }
  [[noreturn]] void fail_at(std::size_t position, const std::string& what) const {
    fail_at_line(name_, bytes_, position, what);
  }

  void begin_row() { skip_to_token(); }

  // A row may span lines but ends with one. Returns true if the last line has further numbers, which are read over.
  bool end_row();

  double number(StoredType type, const Element& element);
  std::size_t length(const Property& property, const Element& element);

  void indices(const Property& property, std::size_t count, const Element& element, std::vector<std::int64_t>& items);

  void skip_list(const Property& property, std::size_t count, const Element& element) {
    for (std::size_t i = 0; i < count; ++i) number(property.type, element);
  }

  void skip_to_token() {
    while (position_ < bytes_.size() && (is_blank(bytes_[position_]) || is_line_end(bytes_[position_]))) ++position_;
  }

 private:
  std::string_view next_token() const { return bytes_.substr(position_, token_end(bytes_, position_) - position_); }

  std::string_view bytes_;
  std::size_t position_;
  const std::string& name_;
};

// The use of one property's numbers: skipped, a coordinate (component: the axis), a component of an attribute, the
// vertices of faces or of strips of triangles, or u v of each corner of a face.
struct Sink {
  enum class Kind { skip, coordinate, attribute, faces, strips, corner_uv };

  Kind kind = Kind::skip;
  std::size_t attribute = 0;  // number in the mesh
  std::size_t component = 0;
};

struct Plan {
  std::vector<std::vector<Sink>> sinks;  // of each element's properties
  std::vector<Attribute> attributes;     // without values
};

// Throws InvalidInput if the vertices or the faces lack properties of a shape.
Plan make_plan(const Layout& layout, const std::string& name);

// Whether a list holds the vertices of faces, or of strips of triangles.
bool is_index_list(const Element& element, const Property& property);

// Rows of an element, counted without those that are left out.
struct Rows {
  std::size_t first = 0;
  std::size_t count = 0;
};

// The mesh that a file is read into, and the notes of reading.
class Target {
 public:
  Target(Mesh& mesh, std::vector<Attribute> attributes, std::size_t vertices)
      : mesh_(mesh), faces_(mesh), vertices_(vertices) {
    mesh_.attributes = std::move(attributes);
  }

  // Keeps one block of rows at a time, in the mesh, and counts the faces.
  struct OneBlock {};
  Target(OneBlock, Mesh& mesh, std::vector<Attribute> attributes, std::size_t vertices)
      : mesh_(mesh), vertices_(vertices), is_one_block_(true) {
    mesh_.attributes = std::move(attributes);
  }
  bool is_one_block() const { return is_one_block_; }
  const CloudBox& box() const { return box_; }  // of the vertices, if one block is kept

  Mesh& mesh() { return mesh_; }
  std::size_t vertices() const { return vertices_; }
  FaceBuilder& faces() { return faces_; }
  Unplaced& unplaced() { return unplaced_; }  // rows whose coordinates are not finite, in the file's order

  // Counts a line of text with more numbers than the header declares.
  void add_surplus() { ++surplus_; }
  bool has_surplus() const { return surplus_ > 0; }

  // Makes room for a number of each of these rows.
  void grow(const std::vector<Sink>& sinks, Rows rows);

  // Looks at the coordinates of rows that have been read; `stride` bytes each, the first at `position`.
  void check_coordinates(Rows rows, std::size_t position, std::size_t stride);

  // The place of a number, and the distance to that of the next row; null for a number that is neither a coordinate nor
  // an attribute of a row.
  double* place(const Sink& sink, std::size_t row);
  std::size_t place_stride(const Sink& sink) const;

  // One number of a row for which there is room.
  void put(double value, const Sink& sink, std::size_t row) {
    if (double* to = place(sink, row)) *to = sink.kind == Sink::Kind::attribute ? finite(value) : value;
  }

  double finite(double value) { return finite_(value); }

  // Strips of triangles with -1 between them; the numbers have been checked.
  void add_strips(std::span<const std::int64_t> items);

  // u v for the corners of one face that was kept or not.
  void add_corner_uv(const Sink& sink, std::span<const double> values, std::size_t corners, bool kept);

  // Adds the notes. Drops attributes of faces where there are strips too, texture coordinates that some face lacks, and
  // the vertices without a place.
  void finish(std::vector<std::string>& notes);

 private:
  Mesh& mesh_;
  FaceBuilder faces_;
  std::size_t vertices_;
  FiniteValues finite_;
  std::size_t surplus_ = 0;
  Unplaced unplaced_;
  bool is_one_block_ = false;
  std::size_t first_ = 0;  // row of the block
  CloudBox box_;
  bool strips_ = false;
  bool corner_uv_complete_ = true;
};

// Reads an element whose only list, if it has one, is that of the faces' vertices. Rows are read together as long as
// their lists have the same length.
void read_columns(BinaryBody& body, const Element& element, const std::vector<Sink>& sinks, Target& target);

// Returns the fewest bytes that a row takes: in text a digit and what ends it for each number, else those of empty
// lists.
std::size_t smallest_row(const Element& element, bool ascii);

// Reserves memory for an element, at most for the rows that `left` bytes can hold.
void reserve_rows(const Element& element, const std::vector<Sink>& sinks, std::size_t left, bool ascii, Target& target);

std::string index_message(double index, std::size_t vertices);

}  // namespace knead::detail::ply
