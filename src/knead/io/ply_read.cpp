// Reading PLY (Turk 1994). The body is read row by row into columns of numbers, which ply_mesh.cpp makes a mesh of.
#include <cmath>
#include <limits>

#include "knead/io/ply.h"
#include "knead/io/ply_header.h"
#include "knead/io/text.h"
#include "knead/math/error.h"

namespace knead {
namespace {

// Bounds-checked reading of one number after the other.
class BodyReader {
 public:
  BodyReader(std::string_view bytes, const PlyLayout& layout, const std::string& name)
      : bytes_(bytes),
        position_(layout.body_begin),
        ascii_(layout.encoding == PlyEncoding::ascii),
        swapped_(is_swapped(layout.encoding)),
        name_(name) {}

  std::size_t position() const { return position_; }

  [[noreturn]] void fail(const std::string& what) const { fail_at(bytes_, position_, ascii_, name_, what); }

  [[noreturn]] static void fail_at(std::string_view bytes, std::size_t position, bool ascii, const std::string& name,
                                   const std::string& what) {
    if (ascii) throw InvalidInput(Place{name, line_of(bytes, position)}, what);
    throw InvalidInput(Place{name}, "byte " + std::to_string(position) + ": " + what);
  }

  // Refuses an element whose rows cannot all be in the rest of the file.
  void check_count(const PlyElement& element) const {
    std::size_t smallest = 0;
    for (const PlyProperty& p : element.properties) {
      smallest += ascii_ ? 2 : (p.is_list ? size_of(p.count_type) : size_of(p.type));
    }
    const std::size_t left = bytes_.size() - position_ + (ascii_ ? 1 : 0);  // the last number needs no blank after it
    if (smallest > 0 && element.count > left / smallest) {
      fail("the header declares " + std::to_string(element.count) + " of element '" + element.name + "', but only " +
           std::to_string(bytes_.size() - position_) + " bytes follow; the file is cut short");
    }
  }

  void begin_row() {
    if (ascii_) skip_to_token();
  }

  // In text, a row may span lines but ends with one.
  void end_row(const PlyElement& element) {
    if (!ascii_) return;
    while (position_ < bytes_.size() && is_blank(bytes_[position_])) ++position_;
    if (position_ < bytes_.size() && !is_line_end(bytes_[position_])) {
      fail("more numbers on the line than element '" + element.name + "' declares, from " + in_quotes(next_token()) +
           " on; check the counts in the header");
    }
  }

  double number(NumberType type, const PlyElement& element) {
    return ascii_ ? text_number(type, element) : binary_number(type, element);
  }

  // The length of a list, checked against what the file can hold.
  std::size_t length(const PlyProperty& property, const PlyElement& element) {
    const double value = number(property.count_type, element);
    if (value < 0 || value != std::floor(value)) fail("a list cannot have " + shown(value) + " items");
    const std::size_t left = bytes_.size() - position_;
    const std::size_t most = ascii_ ? left / 2 + 1 : left / size_of(property.type);
    if (value > static_cast<double>(most)) {
      fail("a list of element '" + element.name + "' declares " + shown(value) + " items, but only " +
           std::to_string(left) + " bytes follow; the file is cut short or damaged");
    }
    return static_cast<std::size_t>(value);
  }

  bool anything_left() {
    if (ascii_) skip_to_token();
    return position_ < bytes_.size();
  }

 private:
  void skip_to_token() {
    while (position_ < bytes_.size() && (is_blank(bytes_[position_]) || is_line_end(bytes_[position_]))) ++position_;
  }

  std::string_view next_token() const { return bytes_.substr(position_, token_end(bytes_, position_) - position_); }

  [[noreturn]] void fail_missing(const PlyElement& element) const {
    fail("the file ends within element '" + element.name + "'; it is cut short, or the counts in the header are wrong");
  }

  double binary_number(NumberType type, const PlyElement& element) {
    const std::size_t size = size_of(type);
    if (bytes_.size() - position_ < size) fail_missing(element);
    const double value = read_binary(bytes_.data() + position_, type, swapped_);
    position_ += size;
    return value;
  }

  double text_number(NumberType type, const PlyElement& element) {
    skip_to_token();
    if (position_ == bytes_.size()) fail_missing(element);
    const std::string_view token = next_token();
    double value = 0;
    float single = 0;
    const bool is_single = type == NumberType::float32;
    const ParseResult result = is_single ? parse_real(token, single) : parse_real(token, value);
    if (result == ParseResult::malformed) fail(in_quotes(token) + " is not a number");
    if (result == ParseResult::overflow)
      fail(in_quotes(token) + " does not fit in a " + std::string(ply_type_name(type)));
    position_ += token.size();
    return is_single ? double{single} : value;
  }

  std::string_view bytes_;
  std::size_t position_;
  bool ascii_;
  bool swapped_;
  const std::string& name_;
};

// Whether the numbers of a property go into the mesh; others are read over.
bool is_kept(const PlyElement& element, const PlyProperty& property) {
  if (!property.is_list) return element.name == "vertex" || element.name == "face";
  return is_index_list(element, property) || (element.name == "face" && property.name == "texcoord");
}

PlyColumns read_element(BodyReader& reader, const PlyElement& element) {
  reader.check_count(element);
  PlyColumns columns;
  columns.values.resize(element.properties.size());
  columns.ends.resize(element.properties.size());
  std::vector<bool> kept;
  bool any = false;
  for (const PlyProperty& property : element.properties) {
    kept.push_back(is_kept(element, property));
    any = any || kept.back();
  }
  if (element.properties.empty()) return columns;
  for (std::size_t row = 0; row < element.count; ++row) {
    reader.begin_row();
    if (any) columns.row_begin.push_back(reader.position());
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      const std::size_t items = property.is_list ? reader.length(property, element) : 1;
      for (std::size_t i = 0; i < items; ++i) {
        const double value = reader.number(property.type, element);
        if (kept[p]) columns.values[p].push_back(value);
      }
      if (kept[p] && property.is_list) columns.ends[p].push_back(columns.values[p].size());
    }
    reader.end_row(element);
  }
  columns.row_begin.push_back(reader.position());
  return columns;
}

}  // namespace

bool is_index_list(const PlyElement& element, const PlyProperty& property) {
  return property.is_list && (element.name == "face" || element.name == "tristrips") &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

void fail_in_ply(std::string_view bytes, const PlyLayout& layout, std::size_t position, const std::string& name,
                 const std::string& what) {
  BodyReader::fail_at(bytes, position, layout.encoding == PlyEncoding::ascii, name, what);
}

ShapeFile parse_ply(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "ply";
  shape.bytes = std::move(bytes);
  PlyLayout layout = parse_ply_header(shape.bytes, name);
  BodyReader reader(shape.bytes, layout, name);
  std::vector<PlyColumns> columns;
  for (const PlyElement& element : layout.elements) columns.push_back(read_element(reader, element));
  if (reader.anything_left()) {
    shape.notes.push_back(std::to_string(shape.bytes.size() - reader.position()) + " bytes follow the last element");
  }
  layout.row_begin = std::move(columns[layout.vertex_element].row_begin);
  shape.layout = std::move(layout);
  build_ply_mesh(shape, columns, name);
  return shape;
}

}  // namespace knead
