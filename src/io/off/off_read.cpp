// Reading OFF, text and binary.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/off/off.h"
#include "io/text.h"

namespace knead::detail::off {
namespace {

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

// What the letters before OFF say. Whether `n` is among them.
bool parse_letters(std::string_view letters, const TextCursor& text, Fields& fields) {
  bool has_dimension = false;
  while (!letters.empty()) {
    if (take_prefix(letters, "ST")) {
      fields.uv = true;
    } else if (take_prefix(letters, "C")) {
      fields.colors = true;
    } else if (take_prefix(letters, "N")) {
      fields.normals = true;
    } else if (take_prefix(letters, "n")) {
      has_dimension = true;
    } else if (take_prefix(letters, "4")) {
      text.fail("4OFF has four coordinates per vertex; only three dimensions are supported");
    } else {
      text.fail("expected a keyword such as OFF or COFF, found " + in_quotes(std::string(letters) + "...OFF"));
    }
  }
  return has_dimension;
}

// In upper case unless it has OFF in that case already; then as it is, because n and N differ.
std::string keyword_of(std::string_view word) {
  return word.find("OFF") != std::string_view::npos ? std::string(word) : upper(word);
}

// Colors as they come, one vertex or face after the other.
class Colors {
 public:
  // are_whole: written as whole numbers.
  void add(std::span<const double> numbers, bool are_whole);

  // Whether attribute() is all that was added.
  bool readable(Domain domain) const;
  std::optional<Attribute> attribute(Domain domain) const;

 private:
  std::vector<double> values_;
  std::size_t width_ = 0;
  std::size_t elements_ = 0;
  bool same_width_ = true;
  bool whole_ = true;
};

class MeshBuilder {
 public:
  MeshBuilder(ShapeFile& shape, const Fields& fields) : shape_(shape), fields_(fields), faces_(shape.mesh) {}

  // All numbers of a vertex, as many as fields.without_colors() at least, the first three finite; the others are whole
  // numbers where is_whole says so.
  void add_vertex(std::span<const double> numbers, const std::vector<bool>& is_whole);

  // The vertices of a face, each of which there is, and the numbers of its color.
  void add_face(std::span<const std::uint32_t> vertices, std::span<const double> color, bool is_whole);

  // Adds attributes and notes to the shape. Whether every number is in an attribute.
  bool finish();

  // After finish(): whether the color stands before the normal.
  bool colors_first() const { return colors_first_; }

 private:
  void split_vertices();
  void add_attribute(const char* name, int components, std::vector<double>& values);
  bool add_colors(const Colors& colors, Domain domain);

  ShapeFile& shape_;
  Fields fields_;
  FaceBuilder faces_;
  std::vector<std::uint32_t> face_;
  std::size_t width_ = 0;     // numbers after x y z
  std::vector<double> rest_;  // those of all vertices
  std::vector<bool> is_whole_;
  bool colors_first_ = false;
  std::vector<double> normals_;
  std::vector<double> uv_;
  Colors vertex_colors_;
  Colors face_colors_;
  FiniteValues finite_;
};

void Colors::add(std::span<const double> numbers, bool are_whole) {
  if (elements_++ == 0) width_ = numbers.size();
  same_width_ = same_width_ && numbers.size() == width_;
  whole_ = whole_ && are_whole;
  if (same_width_) {
    values_.insert(values_.end(), numbers.begin(), numbers.end());
  } else {
    values_ = {};
  }
}

bool Colors::readable(Domain domain) const {
  const auto all_within = [&](double most) {
    return std::all_of(values_.begin(), values_.end(), [&](double value) { return value >= 0 && value <= most; });
  };
  if (!same_width_) return false;
  if (width_ == 0) return true;
  if (width_ == 1) return domain == Domain::face && whole_ && all_within(std::numeric_limits<std::int32_t>::max());
  return (width_ == 3 || width_ == 4) && all_within(whole_ ? 255 : std::numeric_limits<float>::max());
}

std::optional<Attribute> Colors::attribute(Domain domain) const {
  if (width_ == 0 || !readable(domain)) return std::nullopt;
  if (width_ == 1) return Attribute{"color_index", domain, NumberType::int32, 1, values_};
  // Whole numbers that are all 0 or 1 are those of a program that prints reals without a point.
  const double most = *std::max_element(values_.begin(), values_.end());
  return Attribute{"color", domain, whole_ && most != 1 ? NumberType::uint8 : NumberType::float32,
                   static_cast<int>(width_), values_};
}

void MeshBuilder::add_vertex(std::span<const double> numbers, const std::vector<bool>& is_whole) {
  shape_.mesh.positions.push_back({numbers[0], numbers[1], numbers[2]});
  width_ = numbers.size() - 3;
  rest_.insert(rest_.end(), numbers.begin() + 3, numbers.end());
  is_whole_.insert(is_whole_.end(), is_whole.begin() + 3,
                   is_whole.begin() + static_cast<std::ptrdiff_t>(numbers.size()));
}

// How well numbers can be a color, mostly an opaque one, and a normal: 0 to 3.
int fitness(std::span<const double> color, std::span<const double> normal) {
  const auto is_unit = [](double c) { return c >= 0 && c <= 1; };
  const auto is_byte = [](double c) { return c >= 0 && c <= 255 && c == std::floor(c); };
  if (!std::all_of(color.begin(), color.end(), is_unit) && !std::all_of(color.begin(), color.end(), is_byte)) return 0;
  constexpr double tolerance = 0.02;  // components may be written with two digits
  const bool is_normal = std::abs(norm(Vec3d{normal[0], normal[1], normal[2]}) - 1) < tolerance;
  const bool is_opaque = color.size() == 4 && (color[3] == 1 || color[3] == 255);
  return 1 + (is_normal ? 1 : 0) + (is_opaque ? 1 : 0);
}

void MeshBuilder::split_vertices() {
  const std::size_t normals = fields_.normals ? 3 : 0;
  const std::size_t uv = fields_.uv ? 2 : 0;
  const std::size_t colors = width_ - normals - uv;
  const std::span<const double> all(rest_);
  std::int64_t better = 0;  // with the color first
  for (std::size_t at = 0; at < all.size() && normals > 0 && colors > 0; at += width_) {
    better += fitness(all.subspan(at, colors), all.subspan(at + colors, 3)) -
              fitness(all.subspan(at + 3, colors), all.subspan(at, 3));
  }
  colors_first_ = better > 0;
  const std::size_t color_begin = colors_first_ ? 0 : normals;
  const std::size_t normal_begin = colors_first_ ? colors : 0;
  for (std::size_t at = 0; at < all.size(); at += width_) {
    for (std::size_t i = 0; i < normals; ++i) normals_.push_back(finite_(all[at + normal_begin + i]));
    for (std::size_t i = width_ - uv; i < width_; ++i) uv_.push_back(finite_(all[at + i]));
    bool whole = true;
    for (std::size_t i = 0; i < colors; ++i) whole = whole && is_whole_[at + color_begin + i];
    vertex_colors_.add(all.subspan(at + color_begin, colors), whole);
  }
  rest_ = {};
  is_whole_ = {};
}

void MeshBuilder::add_face(std::span<const std::uint32_t> vertices, std::span<const double> color, bool is_whole) {
  face_.assign(vertices.begin(), vertices.end());
  if (faces_.add(face_)) face_colors_.add(color, is_whole);
}

void MeshBuilder::add_attribute(const char* name, int components, std::vector<double>& values) {
  shape_.mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, components, std::move(values)});
}

bool MeshBuilder::add_colors(const Colors& colors, Domain domain) {
  if (std::optional<Attribute> attribute = colors.attribute(domain)) {
    shape_.mesh.attributes.push_back(*std::move(attribute));
  }
  if (colors.readable(domain)) return true;
  shape_.notes.push_back(std::string("the numbers after the ") +
                         (domain == Domain::face ? "indices of faces" : "coordinates of vertices") +
                         " are not colors of one kind; they are kept but not read");
  return false;
}

bool MeshBuilder::finish() {
  faces_.append_notes(shape_.notes);
  split_vertices();
  if (colors_first_) shape_.notes.emplace_back("colors stand before normals, as MeshLab writes them");
  if (fields_.normals) add_attribute("normal", 3, normals_);
  if (fields_.uv) add_attribute("uv", 2, uv_);
  const bool vertices_read = add_colors(vertex_colors_, Domain::vertex);
  const bool faces_read = add_colors(face_colors_, Domain::face);
  finite_.append_note(shape_.notes);
  if (shape_.mesh.face_count() == 0) shape_.notes.emplace_back(kCloudNote);
  return vertices_read && faces_read;
}

// Reading OFF BINARY: 32-bit numbers.

// Geomview's is big-endian with the count of color numbers after each face; PMP writes what the machine has, and none.
struct Form {
  std::endian order = std::endian::big;
  bool color_counts = true;
};

constexpr std::array<Form, 4> kForms{
    {{std::endian::big, true}, {std::endian::little, false}, {std::endian::big, false}, {std::endian::little, true}}};

class BinaryReader {
 public:
  BinaryReader(const Header& header, const ShapeFile& shape, const std::string& name)
      : bytes_(shape.bytes),
        begin_(header.counts_begin),
        width_(header.fields.without_colors() + (header.fields.colors ? 4 : 0)),
        name_(name) {}

  std::size_t width() const { return width_; }

  // That which takes up the whole file; else the first that fits into it; else, so that the error speaks of it, the
  // first whose counts do.
  Form find_form() const {
    const Form* fitting = nullptr;
    for (const Form& form : kForms) {
      const std::size_t end = end_as(form);
      if (end == bytes_.size()) return form;
      if (end > 0 && fitting == nullptr) fitting = &form;
    }
    if (fitting != nullptr) return *fitting;
    return has_vertices(kForms[0]) || !has_vertices(kForms[1]) ? kForms[0] : kForms[1];
  }

  // Reads the vertices and faces into the builder, or without one looks only whether they are there. The byte after
  // them.
  std::size_t read(const Form& form, MeshBuilder* builder) const {
    ByteCursor cursor = counts_at(form);
    const auto [vertices, faces] = read_counts(cursor);
    read_vertices(cursor, vertices, builder);
    std::vector<std::uint32_t> face;
    for (std::uint32_t f = 0; f < faces; ++f) {
      face.clear();
      const std::uint32_t corners = cursor.take<std::uint32_t>("the number of corners of a face");
      if (corners > cursor.left() / 4) cursor.fail(too_many(std::to_string(corners) + " corners", cursor.left()));
      for (std::uint32_t c = 0; c < corners; ++c) {
        face.push_back(cursor.take<std::uint32_t>("a vertex index"));
        if (face.back() >= vertices) {
          cursor.fail("a vertex index is " + std::to_string(face.back()) + ", more than " +
                      std::to_string(vertices - 1) + "; repair the file");
        }
      }
      read_color(cursor, form, face, builder);
    }
    return cursor.position();
  }

 private:
  ByteCursor counts_at(const Form& form) const {
    ByteCursor cursor(bytes_, name_, form.order);
    cursor.take_bytes(begin_, "the header");
    return cursor;
  }

  // Of vertices and faces.
  std::pair<std::uint32_t, std::uint32_t> read_counts(ByteCursor& cursor) const {
    const std::uint32_t vertices = cursor.take<std::uint32_t>("the count of vertices");
    const std::uint32_t faces = cursor.take<std::uint32_t>("the count of faces");
    cursor.take<std::uint32_t>("the count of edges");
    if (vertices == 0) cursor.fail("0 vertices are declared; there is no shape in it");
    if (vertices > cursor.left() / (4 * width_))
      cursor.fail(too_many(std::to_string(vertices) + " vertices", cursor.left()));
    return {vertices, faces};
  }

  void read_vertices(ByteCursor& cursor, std::uint32_t vertices, MeshBuilder* builder) const {
    if (builder == nullptr) {
      cursor.take_bytes(4 * width_ * vertices, "the vertices");
      return;
    }
    std::vector<double> numbers(width_);
    const std::vector<bool> whole(width_, false);
    for (std::uint32_t i = 0; i < vertices; ++i) {
      const std::size_t begin = cursor.position();
      for (double& number : numbers) number = double{cursor.take<float>("a vertex")};
      if (!is_finite(Vec3d{numbers[0], numbers[1], numbers[2]})) {
        fail_at_byte(name_, begin, "a coordinate of vertex " + std::to_string(i) + " is not finite; repair the file");
      }
      builder->add_vertex(numbers, whole);
    }
  }

  void read_color(ByteCursor& cursor, const Form& form, const std::vector<std::uint32_t>& face,
                  MeshBuilder* builder) const {
    std::array<double, 4> color{};
    std::uint32_t count = 0;
    if (form.color_counts) {
      count = cursor.take<std::uint32_t>("the count of color numbers of a face");
      if (count > 4 || count == 2)
        cursor.fail("a face has " + std::to_string(count) + " color numbers, not 0, 1, 3 or 4");
    }
    for (std::uint32_t i = 0; i < count; ++i) {  // one is an index, more are from 0 to 1
      color[i] = count == 1 ? static_cast<double>(cursor.take<std::int32_t>("a color index"))
                            : double{cursor.take<float>("a color")};
    }
    if (builder != nullptr) builder->add_face(face, std::span(color).first(count), count == 1);
  }

  // The byte after the last face, or 0 where the file is not of this form.
  std::size_t end_as(const Form& form) const {
    try {
      return read(form, nullptr);
    } catch (const InvalidInput&) {
      return 0;
    }
  }

  bool has_vertices(const Form& form) const {
    try {
      ByteCursor cursor = counts_at(form);
      read_counts(cursor);
      return true;
    } catch (const InvalidInput&) {
      return false;
    }
  }

  std::string_view bytes_;
  std::size_t begin_;
  std::size_t width_;
  const std::string& name_;
};

Layout read_binary(MeshBuilder& builder, const Header& header, ShapeFile& shape, const std::string& name) {
  const BinaryReader reader(header, shape, name);
  const Form form = reader.find_form();
  const std::size_t end = reader.read(form, &builder);
  if (end < shape.bytes.size()) {
    shape.notes.push_back(
        counted(shape.bytes.size() - end, "byte follows the last face", "bytes follow the last face"));
  }
  Layout layout;
  layout.binary = true;
  layout.order = form.order;
  layout.color_counts = form.color_counts;
  layout.faces_end = end;
  layout.vertex_begin = header.counts_begin + 3 * sizeof(std::uint32_t);
  layout.width = reader.width();
  return layout;
}

// Reading OFF as text.

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
    if (count > bytes_left() / bytes + 1) text_.fail(too_many(std::to_string(count) + what, bytes_left()));
  }

  // The counts of vertices and faces, and of edges if it is there, which is not needed.
  void read_counts() {
    vertices_ = text_.whole(text_.next(), std::numeric_limits<std::size_t>::max(), "the count of vertices");
    faces_ = text_.whole(text_.next_on_line(), std::numeric_limits<std::size_t>::max(), "the count of faces");
    if (vertices_ == 0) text_.fail("0 vertices are declared; there is no shape in it");
    check_count(vertices_, 2 * fields_.without_colors(), " vertices");
    check_count(faces_, 2, " faces");
    if (vertices_ >= kMaxElements) text_.fail("more than 4294967294 vertices; split the shape");
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
      return is_digits(word);
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

  void read_vertex(std::size_t i) {
    numbers_.clear();
    whole_.clear();
    first_color_ = 3;
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

Header parse_header(std::string_view bytes, const std::string& name) {
  Header header;
  TextCursor text(bytes, name, text_begin(bytes, name));
  header.counts_begin = text.position();
  const std::string_view word = text.next();
  if (is_digits(word)) return header;  // the keyword may be missing
  const std::string in_upper_case = keyword_of(word);
  header.lower_case = in_upper_case != word;
  const std::size_t keyword = in_upper_case.find("OFF");
  if (keyword == std::string_view::npos) {
    text.fail("expected the keyword OFF, or the counts of vertices and faces, found " +
              (word.empty() ? "the end of the file" : in_quotes(word)));
  }
  const bool has_dimension = parse_letters(std::string_view(in_upper_case).substr(0, keyword), text, header.fields);
  // The first count may follow without a blank.
  const std::size_t end = text.word_begin() + keyword + 3;
  text.take(text.word_begin(), end);
  const std::string_view encoding = text.next_on_line();
  if (encoding == "BINARY" || (header.lower_case && encoding == "binary")) {
    if (has_dimension) text.fail("binary nOFF is not supported; write it as text");
    header.binary = true;
    text.next_line();
    header.counts_begin = text.position();
    return header;
  }
  header.counts_begin = end;
  if (!has_dimension) return header;
  text.take(end, end);
  const std::size_t dimension = text.whole(text.next(), 1'000'000, "the number of dimensions after nOFF");
  if (dimension != 3) text.fail(std::to_string(dimension) + " dimensions; only three are supported");
  header.counts_begin = text.position();
  return header;
}

void read(ShapeFile& shape, const std::string& name) {
  const Header header = parse_header(shape.bytes, name);
  if (header.lower_case) shape.notes.emplace_back("the keyword has letters in lower case and is read as in upper case");
  MeshBuilder builder(shape, header.fields);
  Layout layout =
      header.binary ? read_binary(builder, header, shape, name) : TextReader(builder, header, shape, name).run();
  layout.all_read = builder.finish();
  layout.uv = header.fields.uv ? 2 : 0;
  layout.colors_first = builder.colors_first();
  set_layout(shape, layout);
}

}  // namespace knead::detail::off
