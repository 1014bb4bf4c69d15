#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include "io/formats.h"
#include "io/mesh_builder.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"

namespace knead::io_detail::ply {
namespace {

struct TypeName {
  std::string_view name;
  StoredType type;
};

constexpr std::array<TypeName, 18> kTypeNames = {{{"char", StoredType::int8},
                                                  {"uchar", StoredType::uint8},
                                                  {"short", StoredType::int16},
                                                  {"ushort", StoredType::uint16},
                                                  {"int", StoredType::int32},
                                                  {"uint", StoredType::uint32},
                                                  {"float", StoredType::float32},
                                                  {"double", StoredType::float64},
                                                  {"int8", StoredType::int8},
                                                  {"uint8", StoredType::uint8},
                                                  {"int16", StoredType::int16},
                                                  {"uint16", StoredType::uint16},
                                                  {"int32", StoredType::int32},
                                                  {"uint32", StoredType::uint32},
                                                  {"float32", StoredType::float32},
                                                  {"float64", StoredType::float64},
                                                  {"int64", StoredType::int64},
                                                  {"uint64", StoredType::uint64}}};

// Every name is compared with those before it, and every property of vertices and faces is an attribute.
constexpr std::size_t kMaxNames = 4096;

// Reads the header line by line.
class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& name)
      : bytes_(bytes), name_(name), position_(text_begin(bytes, name)) {}

  Layout parse() {
    if (position_ > 0) layout_.notes.emplace_back("begins with a byte order mark, which is kept");
    next_line();
    if (words_.size() != 1 || words_[0] != "ply") fail("does not begin with 'ply'; is it a PLY file?");
    bool has_format = false;
    for (next_line(); words_.empty() || words_[0] != "end_header" || words_.size() > 1; next_line()) {
      if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") continue;
      if (words_[0][0] == '#') {
        note_hash_lines();
      } else if (words_[0] == "format") {
        parse_format();
        has_format = true;
      } else if (words_[0] == "element") {
        parse_element();
      } else if (words_[0] == "property") {
        parse_property();
      } else {
        fail("unknown header line " + in_quotes(line_) + "; expected element, property, comment or end_header");
      }
    }
    if (!has_format) fail("the header has no line 'format'; add e.g. 'format ascii 1.0'");
    layout_.body_begin = position_;
    find_vertices();
    return std::move(layout_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InvalidInput(Place{name_, line_number_}, what); }

  // Splits the next line into words. A file whose first line ends with CR alone has such ends throughout; elsewhere a
  // binary body may begin with LF, so that CR then ends a line only together with LF.
  void next_line() {
    ++line_number_;
    line_begin_ = position_;
    const std::size_t end = bytes_.find_first_of(ends_, position_);
    if (end == std::string_view::npos) fail("the header ends without 'end_header'; the file is cut short or no PLY");
    line_ = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    if (line_number_ == 1) {
      const bool pair = bytes_[end] == '\r' && position_ < bytes_.size() && bytes_[position_] == '\n';
      ends_ = bytes_[end] == '\r' && !pair ? "\r" : "\n";
      if (pair) ++position_;
    }
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    split();
  }

  void split() {
    words_.clear();
    for (std::size_t i = 0; i < line_.size();) {
      if (is_blank(line_[i])) {
        ++i;
        continue;
      }
      const std::size_t end = token_end(line_, i);
      if (end == i) fail("a stray carriage return in the header; the file is damaged");
      words_.push_back(line_.substr(i, end - i));
      i = end;
    }
  }

  void note_hash_lines() {
    if (std::exchange(hash_lines_, true)) return;
    layout_.notes.emplace_back("header lines that begin with # are read as comments");
  }

  void parse_format() {
    if (words_.size() != 3) fail("expected 'format ENCODING 1.0'");
    if (words_[2] != "1.0") fail("PLY version " + in_quotes(words_[2]) + " is not known; only 1.0 is");
    if (words_[1] == "ascii") {
      layout_.encoding = Encoding::ascii;
    } else if (words_[1] == "binary_little_endian") {
      layout_.encoding = Encoding::little_endian;
    } else if (words_[1] == "binary_big_endian") {
      layout_.encoding = Encoding::big_endian;
    } else {
      fail("encoding " + in_quotes(words_[1]) +
           " is not known; expected ascii, binary_little_endian or binary_big_endian");
    }
  }

  void parse_element() {
    if (words_.size() != 3) fail("expected 'element NAME COUNT'");
    Element element;
    element.name = words_[1];
    element.line_begin = line_begin_;
    element.line_end = position_;
    element.count_begin = static_cast<std::size_t>(words_[2].data() - bytes_.data());
    element.count_end = element.count_begin + words_[2].size();
    const char* end = words_[2].data() + words_[2].size();
    const auto [stop, error] = std::from_chars(words_[2].data(), end, element.count);
    if (error != std::errc{} || stop != end) fail("the count " + in_quotes(words_[2]) + " is not a whole number");
    if (element.count > kMaxElements) fail("declares more than 4294967295 elements; split the shape");
    if (layout_.elements.size() == kMaxNames) fail("more than 4096 elements; remove some");
    for (const Element& other : layout_.elements) {
      if (other.name == element.name) fail("element " + in_quotes(element.name) + " is declared twice");
    }
    layout_.elements.push_back(std::move(element));
  }

  StoredType parse_type(std::string_view word) const {
    for (const TypeName& known : kTypeNames) {
      if (known.name == word) return known.type;
    }
    fail("number type " + in_quotes(word) +
         " is not known; expected char, uchar, short, ushort, int, uint, int64, uint64, float or double");
  }

  void parse_property() {
    if (layout_.elements.empty()) fail("a property before the first element");
    const bool is_list = words_.size() > 1 && words_[1] == "list";
    if (words_.size() != (is_list ? 5u : 3u)) fail("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
    Property property;
    property.is_list = is_list;
    if (is_list) property.count_type = parse_type(words_[2]);
    if (is_list && !is_integer(property.count_type)) fail("the length of a list must have an integer type");
    const std::string_view type = words_[words_.size() - 2];
    property.type = parse_type(type);
    property.type_begin = static_cast<std::size_t>(type.data() - bytes_.data());
    property.type_end = property.type_begin + type.size();
    property.line_begin = line_begin_;
    property.line_end = position_;
    property.name = words_.back();
    if (layout_.elements.back().properties.size() == kMaxNames) fail("more than 4096 properties; remove some");
    for (const Property& other : layout_.elements.back().properties) {
      if (other.name == property.name) fail("property " + in_quotes(property.name) + " is declared twice");
    }
    layout_.elements.back().properties.push_back(std::move(property));
  }

  void find_vertices() {
    for (std::size_t i = 0; i < layout_.elements.size(); ++i) {
      if (layout_.elements[i].name != "vertex") continue;
      layout_.vertex_element = i;
      return;
    }
    throw InvalidInput(Place{name_}, "the header declares no element 'vertex'; there is no shape in it");
  }

  std::string_view bytes_;
  const std::string& name_;
  const char* ends_ = "\r\n";
  std::size_t position_;
  bool hash_lines_ = false;
  std::size_t line_number_ = 0;
  std::size_t line_begin_ = 0;
  std::string_view line_;
  std::vector<std::string_view> words_;
  Layout layout_;
};

}  // namespace

Layout parse_header(std::string_view bytes, const std::string& name) { return HeaderParser(bytes, name).parse(); }

std::string_view type_name(StoredType type) {
  for (const TypeName& known : kTypeNames) {
    if (known.type == type) return known.name;
  }
  return "double";
}

StoredType stored_type(NumberType type) {
  for (const TypeName& known : kTypeNames) {
    if (number_type(known.type) == type) return known.type;
  }
  return StoredType::float64;
}

namespace {

std::string cut_short(const Element& element) {
  return "the file ends within element '" + element.name + "'; it is cut short, or the counts in the header are wrong";
}

}  // namespace

std::string not_a_length(double length, const Element& element, std::size_t left) {
  if (!(length >= 0 && length == std::floor(length))) return "a list cannot have " + shown(length) + " items";
  return "a list of element '" + element.name + "' declares " + shown(length) + " items, but only " +
         std::to_string(left) + " bytes follow; the file is cut short or damaged";
}

void BinaryBody::fail_missing(const Element& element) const { fail(cut_short(element)); }

std::string not_an_index(double value) {
  return "vertex index " + shown(value) + " is not the number of a vertex; repair the file";
}

bool TextBody::end_row() {
  const auto skip_blanks = [&] {
    while (position_ < bytes_.size() && is_blank(bytes_[position_])) ++position_;
  };
  bool surplus = false;
  for (skip_blanks(); position_ < bytes_.size() && !is_line_end(bytes_[position_]); skip_blanks()) {
    const std::string_view token = next_token();
    double value = 0;
    if (parse_real(token, value) != ParseResult::ok) fail(in_quotes(token) + " is not a number");
    position_ += token.size();
    surplus = true;
  }
  return surplus;
}

double TextBody::number(StoredType type, const Element& element) {
  skip_to_token();
  if (position_ == bytes_.size()) fail(cut_short(element));
  const std::string_view token = next_token();
  double value = 0;
  float single = 0;
  const bool is_single = type == StoredType::float32;
  const ParseResult result = is_single ? parse_real(token, single) : parse_real(token, value);
  if (result == ParseResult::malformed) fail(in_quotes(token) + " is not a number");
  if (result == ParseResult::overflow) {
    fail(in_quotes(token) + " does not fit in a " + std::string(type_name(type)));
  }
  position_ += token.size();
  return is_single ? double{single} : value;
}

std::size_t TextBody::length(const Property& property, const Element& element) {
  skip_to_token();
  const std::size_t begin = position_;
  const double value = number(property.count_type, element);
  const std::size_t most = left() / 2 + 1;  // the last number needs no blank after it
  if (!(value >= 0) || value != std::floor(value) || value > static_cast<double>(most)) {
    fail_at(begin, not_a_length(value, element, bytes_.size() - begin));
  }
  return static_cast<std::size_t>(value);
}

void TextBody::indices(const Property& property, std::size_t count, const Element& element,
                       std::vector<std::int64_t>& items) {
  items.resize(count);
  for (std::int64_t& item : items) {
    const double value = number(property.type, element);
    if (!is_index(value)) fail(not_an_index(value));
    item = static_cast<std::int64_t>(value);
  }
}

// Reading PLY (Turk 1994): every number goes straight to its place in the mesh.

namespace {

std::size_t count_lists(const Element& element) {
  return static_cast<std::size_t>(std::count_if(element.properties.begin(), element.properties.end(),
                                                [](const Property& property) { return property.is_list; }));
}

std::string more_numbers(const Element& element) {
  return "more numbers than element '" + element.name + "' declares; check the counts in the header";
}

bool is_vertex_list(const Sink& sink) { return sink.kind == Sink::Kind::faces || sink.kind == Sink::Kind::strips; }

// Whether a list of the element holds the vertices of faces as integers.
bool has_whole_faces(const Element& element, const std::vector<Sink>& sinks) {
  for (std::size_t p = 0; p < sinks.size(); ++p) {
    if (sinks[p].kind == Sink::Kind::faces) return is_integer(element.properties[p].type);
  }
  return false;
}

// Notes names and types of the lists of vertices that are not the usual ones.
void note_lists(const Layout& layout, const Plan& plan, std::vector<std::string>& notes) {
  for (std::size_t e = 0; e < layout.elements.size(); ++e) {
    for (std::size_t p = 0; p < plan.sinks[e].size(); ++p) {
      if (!is_vertex_list(plan.sinks[e][p])) continue;
      const Property& property = layout.elements[e].properties[p];
      if (property.name != "vertex_indices" && property.name != "vertex_index") {
        notes.push_back("the list '" + property.name + "' is read as the vertices of faces");
      }
      if (!is_integer(property.type)) {
        notes.push_back("the vertices of faces have the type " + std::string(type_name(property.type)) +
                        " and are read as whole numbers");
      }
    }
  }
}

// Refuses shapes of which nothing would be left.
template <class Body>
void check_unplaced(const Body& body, Target& target, const std::string& name) {
  const Unplaced& unplaced = target.unplaced();
  if (const std::optional<std::size_t> used = first_used(unplaced, target.mesh())) {
    body.fail_at(unplaced.begin[*used], "a coordinate of vertex " + std::to_string(unplaced.rows[*used]) +
                                            " is not finite, and a face uses the vertex; repair the file");
  }
  if (unplaced.rows.size() < target.vertices()) return;
  throw InvalidInput(Place{name}, "no vertex has finite coordinates; there is no shape in it");
}

// Reads an element row by row.
template <class Body>
class RowReader {
 public:
  RowReader(Body& body, const Element& element, const std::vector<Sink>& sinks, Target& target)
      : body_(body), element_(element), sinks_(sinks), target_(target) {}

  void run() {
    for (std::size_t i = 0; i < element_.count; ++i) read_row();
    for (const Sink& sink : sinks_) {
      if (sink.kind != Sink::Kind::attribute) continue;
      Attribute& attribute = target_.mesh().attributes[sink.attribute];
      attribute.values.resize(row_ * static_cast<std::size_t>(attribute.components));  // some are left out
    }
  }

 private:
  void read_row() {
    body_.begin_row();
    begin_ = body_.position();
    corners_ = 0;
    kept_ = true;
    texcoord_sink_ = nullptr;
    if (row_ == grown_) grow();
    for (std::size_t p = 0; p < element_.properties.size(); ++p) {
      const Property& property = element_.properties[p];
      if (property.is_list) {
        read_list(property, sinks_[p]);
      } else {
        read_number(property, sinks_[p]);
      }
    }
    if (body_.end_row()) {
      if (!kept_) body_.fail_at(begin_, more_numbers(element_));  // more likely a row of another element
      target_.add_surplus();
    }
    if (texcoord_sink_ != nullptr) target_.add_corner_uv(*texcoord_sink_, texcoords_, corners_, kept_);
    if (kept_) ++row_;
  }

  void grow() {
    constexpr std::size_t most = 1024;
    const std::size_t count = std::min(most, element_.count - row_);
    target_.grow(sinks_, {row_, count});
    grown_ += count;
  }

  void read_number(const Property& property, const Sink& sink) {
    const double value = body_.number(property.type, element_);
    if (sink.kind == Sink::Kind::coordinate && !std::isfinite(value)) {
      target_.unplaced().add(row_, begin_);
    }
    target_.put(value, sink, row_);
  }

  void read_list(const Property& property, const Sink& sink) {
    const std::size_t count = body_.length(property, element_);
    switch (sink.kind) {
      case Sink::Kind::faces:
        body_.indices(property, count, element_, items_);
        return add_face();
      case Sink::Kind::strips:
        body_.indices(property, count, element_, items_);
        for (const std::int64_t item : items_) check_index(item, item == -1);
        return target_.add_strips(items_);
      case Sink::Kind::corner_uv:
        texcoords_.resize(count);
        for (double& value : texcoords_) value = body_.number(property.type, element_);
        texcoord_sink_ = &sink;
        return;
      default:
        body_.skip_list(property, count, element_);
    }
  }

  void add_face() {
    face_.clear();
    for (const std::int64_t item : items_) {
      check_index(item, false);
      face_.push_back(static_cast<std::uint32_t>(item));
    }
    corners_ = face_.size();
    kept_ = target_.faces().add(face_);
  }

  void check_index(std::int64_t index, bool separator) const {
    if (separator || (index >= 0 && static_cast<std::size_t>(index) < target_.vertices())) return;
    body_.fail_at(begin_, index_message(static_cast<double>(index), target_.vertices()));
  }

  Body& body_;
  const Element& element_;
  const std::vector<Sink>& sinks_;
  Target& target_;
  std::size_t row_ = 0;      // not counting faces that are left out
  std::size_t grown_ = 0;    // rows that there is room for
  std::size_t begin_ = 0;    // byte of this row
  bool kept_ = true;         // this row is no face that is left out
  std::size_t corners_ = 0;  // of this row's face
  const Sink* texcoord_sink_ = nullptr;
  std::vector<double> texcoords_;
  std::vector<std::int64_t> items_;
  std::vector<std::uint32_t> face_;
};

// Refuses an element whose rows cannot all be in the rest of the file.
template <class Body>
void check_count(const Body& body, const Element& element) {
  const std::size_t smallest = smallest_row(element, Body::kAscii);
  const std::size_t left = body.left() + (Body::kAscii ? 1 : 0);  // the last number needs no blank after it
  if (smallest > 0 && element.count > left / smallest) {
    body.fail("the header declares " + std::to_string(element.count) + " of element '" + element.name + "', but only " +
              std::to_string(body.left()) + " bytes follow; the file is cut short");
  }
}

// Whether the rows can be read many at a time.
bool has_columns(const Element& element, const std::vector<Sink>& sinks) {
  const std::size_t lists = count_lists(element);
  return lists == 0 || (lists == 1 && has_whole_faces(element, sinks));
}

template <class Body>
void read_element(Body& body, const Element& element, const std::vector<Sink>& sinks, Target& target) {
  check_count(body, element);
  if (element.properties.empty()) return;
  reserve_rows(element, sinks, body.left(), Body::kAscii, target);
  if constexpr (!Body::kAscii) {
    if (has_columns(element, sinks)) return read_columns(body, element, sinks, target);
  }
  RowReader<Body>(body, element, sinks, target).run();
}

template <class Body>
void add_notes(const Body& body, const Layout& layout, const Plan& plan, Target& target,
               std::vector<std::string>& notes) {
  if (body.left() > 0) notes.push_back(std::to_string(body.left()) + " bytes follow the last element");
  notes.insert(notes.end(), layout.notes.begin(), layout.notes.end());
  note_lists(layout, plan, notes);
  target.finish(notes);
}

template <class Body>
void read_body(Body& body, ShapeFile& shape, Layout& layout, const std::string& name) {
  Plan plan = make_plan(layout, name);
  Target target(shape.mesh, std::move(plan.attributes), layout.elements[layout.vertex_element].count);
  for (std::size_t e = 0; e < layout.elements.size(); ++e) {
    if (e == layout.vertex_element) layout.vertex_begin = body.position();
    layout.elements[e].rows_begin = body.position();
    read_element(body, layout.elements[e], plan.sinks[e], target);
    layout.elements[e].rows_end = body.position();
  }
  check_unplaced(body, target, name);
  if constexpr (Body::kAscii) body.skip_to_token();
  if (target.has_surplus() && body.left() > 0) body.fail(more_numbers(layout.elements.back()));
  layout.unplaced = target.unplaced().rows;
  layout.surplus = target.has_surplus();
  add_notes(body, layout, plan, target, shape.notes);
}

// Reads a body whose bytes are those of the shape.
void read_binary_body(ShapeFile& shape, Layout& layout, const std::string& name) {
  SourceBytes bytes(shape);
  BinaryBody body(bytes, layout, name);
  read_body(body, shape, layout, name);
}

// Reads the header of a file, which mostly is far shorter than the piece that is looked at first.
Layout read_header(const ShapeFile& source, const std::string& name) {
  constexpr std::size_t first = std::size_t{1} << 20;
  SourceBytes bytes(source);
  const std::string_view piece = bytes.piece(0, std::min(bytes.size(), first));
  return parse_header(piece.find("end_header") != piece.npos ? piece : bytes.all(), name);
}

}  // namespace

bool reads_floats(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  for (const Property& property : layout.elements[layout.vertex_element].properties) {
    const bool is_axis = property.name == "x" || property.name == "y" || property.name == "z";
    if (is_axis && property.type == StoredType::float32) return true;
  }
  return false;
}

// Which vertices without a place are used, only the faces tell. Files with vertices astray (see shape_box) are read as
// a whole, too.
std::optional<ShapeSummary> summarize(const ShapeFile& source, const std::string& name) {
  const Layout layout = read_header(source, name);
  if (layout.encoding == Encoding::ascii) return std::nullopt;
  const Plan plan = make_plan(layout, name);
  for (std::size_t e = 0; e < layout.elements.size(); ++e) {
    if (!has_columns(layout.elements[e], plan.sinks[e])) return std::nullopt;
  }
  const std::size_t vertices = layout.elements[layout.vertex_element].count;
  Mesh block;
  SourceBytes bytes(source);
  BinaryBody body(bytes, layout, name);
  Target target(Target::OneBlock{}, block, plan.attributes, vertices);
  for (std::size_t e = 0; e < layout.elements.size(); ++e) {
    read_element(body, layout.elements[e], plan.sinks[e], target);
  }
  if (vertices == 0 || !target.unplaced().rows.empty()) return std::nullopt;
  const Box box = target.box().whole();
  const bool is_cloud = target.faces().faces() == 0;
  const bool has_stray =
      is_cloud ? target.box().box().diagonal() != box.diagonal() : target.faces().used_vertices() != vertices;
  const bool has_splats = std::any_of(block.attributes.begin(), block.attributes.end(),
                                      [](const Attribute& a) { return a.name == "rot_0"; });
  if (has_stray || has_splats) return std::nullopt;
  ShapeSummary summary;
  summary.format = "ply";
  summary.vertices = vertices;
  summary.faces = target.faces().faces();
  summary.triangles = target.faces().corners() - 2 * summary.faces;
  summary.box = box;
  add_notes(body, layout, plan, target, summary.notes);
  for (const Attribute& attribute : block.attributes) summary.attributes.push_back(attribute.name);
  return summary;
}

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "ply";
  shape.bytes = std::move(bytes);
  Layout layout = parse_header(shape.bytes, name);
  if (layout.encoding == Encoding::ascii) {
    TextBody body(shape.bytes, layout, name);
    read_body(body, shape, layout, name);
  } else {
    read_binary_body(shape, layout, name);
  }
  set_layout(shape, std::move(layout));
  return shape;
}

std::optional<ShapeFile> parse_in_pieces(const std::shared_ptr<const SourceFile>& file, const std::string& name) {
  ShapeFile shape;
  shape.format = "ply";
  shape.file = file;
  Layout layout = read_header(shape, name);
  if (layout.encoding == Encoding::ascii) return std::nullopt;
  read_binary_body(shape, layout, name);
  set_layout(shape, std::move(layout));
  return shape;
}

}  // namespace knead::io_detail::ply
