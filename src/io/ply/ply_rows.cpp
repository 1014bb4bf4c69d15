// Reading PLY (Turk 1994): the bodies, and rows that are read one by one. Every number goes straight to its place in
// the mesh.
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/ply/ply.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"

namespace knead::detail::ply {
namespace {

std::string cut_short(const Element& element) {
  return "the file ends within element '" + element.name + "'; it is cut short, or the counts in the header are wrong";
}

std::ptrdiff_t count_lists(const Element& element) {
  return std::count_if(element.properties.begin(), element.properties.end(),
                       [](const Property& p) { return p.is_list; });
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
  const std::ptrdiff_t lists = count_lists(element);
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

bool stores_floats(const ShapeFile& source) {
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
  if (has_stray) return std::nullopt;
  ShapeSummary summary;
  summary.format = "ply";
  summary.vertices = vertices;
  summary.faces = target.faces().faces();
  summary.triangles = target.faces().corners() - 2 * summary.faces;
  summary.box = box;
  add_notes(body, layout, plan, target, summary.notes);
  for (const Attribute& attribute : block.attributes) summary.attributes.push_back(attribute.name);
  if (is_cloud && are_splats(block)) summary.notes.push_back(splat_note(block));
  return summary;
}

void read(ShapeFile& shape, const std::string& name) {
  Layout layout = parse_header(shape.bytes, name);
  if (layout.encoding == Encoding::ascii) {
    TextBody body(shape.bytes, layout, name);
    read_body(body, shape, layout, name);
  } else {
    read_binary_body(shape, layout, name);
  }
  set_layout(shape, std::move(layout));
}

bool read_in_pieces(ShapeFile& shape, const std::string& name) {
  Layout layout = read_header(shape, name);
  if (layout.encoding == Encoding::ascii) return false;
  read_binary_body(shape, layout, name);
  set_layout(shape, std::move(layout));
  return true;
}

}  // namespace knead::detail::ply
