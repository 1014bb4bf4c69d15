// Writing OFF: a new file, the source's bytes with some numbers replaced, or its keyword and another mesh.
#include <algorithm>
#include <array>
#include <optional>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/off/off.h"
#include "io/text.h"

namespace knead::detail::off {
namespace {

bool is_color(const Attribute& attribute) {
  const bool has_scale = attribute.type == NumberType::uint8 || attribute.type == NumberType::uint16 ||
                         attribute.type == NumberType::float32 || attribute.type == NumberType::float64;
  return attribute.name == "color" && (attribute.components == 3 || attribute.components == 4) && has_scale;
}

bool is_color_index(const Attribute& attribute) {
  return attribute.name == "color_index" && attribute.components == 1 && attribute.type == NumberType::int32;
}

// What of a mesh's attributes OFF holds.
struct Holdings {
  std::optional<Attribute> normal;
  std::optional<Attribute> color;
  std::optional<Attribute> uv;
  const Attribute* face_color = nullptr;

  bool holds(const Attribute& attribute) const {
    if (attribute.domain == Domain::face) return &attribute == face_color;
    for (const std::optional<Attribute>* held : {&normal, &color, &uv}) {
      if (*held && (*held)->name == attribute.name && (*held)->components == attribute.components) return true;
    }
    return false;
  }
};

Holdings sort_attributes(const Mesh& mesh) {
  Holdings held;
  held.normal = vertex_attribute(mesh, "normal", 3);
  held.uv = vertex_attribute(mesh, "uv", 2);
  held.color = vertex_attribute(mesh, "color", 4);
  if (!held.color) held.color = vertex_attribute(mesh, "color", 3);
  if (held.color && !is_color(*held.color)) held.color.reset();
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.domain != Domain::face || held.face_color != nullptr) continue;
    if (is_color(attribute) || is_color_index(attribute)) held.face_color = &attribute;
  }
  return held;
}

// The shortest form of a float, or else of the double.
void append_as_held(std::string& text, bool is_float, double value) {
  is_float&& fits_float(value) ? append_real(text, static_cast<float>(value)) : append_real(text, value);
}

void append_numbers(std::string& text, const std::optional<Attribute>& attribute, std::size_t element) {
  if (!attribute) return;
  const std::size_t n = static_cast<std::size_t>(attribute->components);
  for (std::size_t c = 0; c < n; ++c) {
    const double value = attribute->values[element * n + c];
    text += ' ';
    append_as_held(text, attribute->type == NumberType::float32, value);
  }
}

// A real number has a point or an exponent, so that it is not read as one of 0 to 255.
void append_color(std::string& text, const Attribute& color, std::size_t element) {
  const std::size_t n = static_cast<std::size_t>(color.components);
  for (std::size_t c = 0; c < n; ++c) {
    const double value =
        color.values[element * n + c] * (color.type == NumberType::uint16 ? unit_scale(color.type) : 1);
    text += ' ';
    const std::size_t begin = text.size();
    append_as_held(text, color.type != NumberType::float64, value);
    const bool is_real = color.type != NumberType::uint8 && color.type != NumberType::int32;
    if (is_real && text.find_first_of(".e", begin) == std::string::npos) text += ".0";
  }
}

void append_vertex(std::string& text, const Mesh& mesh, const Holdings& held, std::size_t i,
                   std::optional<int> decimals) {
  append_point(text, mesh.positions[i], decimals);
  append_numbers(text, held.normal, i);
  if (held.color) {
    append_color(text, *held.color, i);
    // COFF means four numbers: OpenMesh and assimp read past the line of a vertex with three.
    if (held.color->components == 3) text += held.color->type == NumberType::uint8 ? " 255" : " 1.0";
  }
  append_numbers(text, held.uv, i);
  text += '\n';
}

// A new text file. A color of a vertex with three numbers gets an alpha: COFF means four.
std::string generate(const Mesh& mesh, const WriteOptions& options) {
  const Holdings held = sort_attributes(mesh);
  std::string text = held.uv ? "ST" : "";
  if (held.color) text += 'C';
  if (held.normal) text += 'N';
  text += "OFF\n" + std::to_string(mesh.vertex_count()) + ' ' + std::to_string(mesh.face_count()) + " 0\n";
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) append_vertex(text, mesh, held, i, options.decimals);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    text += std::to_string(mesh.face(f).size());
    for (const std::uint32_t v : mesh.face(f)) text += ' ' + std::to_string(v);
    if (held.face_color != nullptr) append_color(text, *held.face_color, f);
    text += '\n';
  }
  return text;
}

std::vector<std::string> losses(const Mesh& mesh) {
  const Holdings held = sort_attributes(mesh);
  std::vector<std::string> losses;
  for (const Attribute& attribute : mesh.attributes) {
    if (held.holds(attribute)) continue;
    losses.push_back("OFF cannot hold '" + attribute.name + "'" +
                     (attribute.domain == Domain::face ? " per face" : ""));
  }
  return losses;
}

Vec3d vector_at(const std::vector<double>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

std::string rewrite_text(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                         const Attribute* old_normals, const WriteOptions& options) {
  Splice splice(source.bytes, options.decimals);
  const Layout& layout = layout_of<Layout>(source);
  TextCursor text(source.bytes, source.format, layout.vertex_begin);
  const auto next = [&] { return text.next(); };
  for (std::size_t i = 0; i < positions.size(); ++i) {
    splice.replace_changed(source.mesh.positions[i], positions[i], next);
    if (!normals.empty()) {
      std::vector<std::string_view> words;
      for (std::string_view word = text.next_on_line(); !word.empty(); word = text.next_on_line()) {
        words.push_back(word);
      }
      std::size_t word = layout.colors_first ? words.size() - layout.uv - 3 : 0;
      splice.replace_direction(vector_at(old_normals->values, i), normals[i], [&] { return words[word++]; });
    }
    text.next_line();
  }
  return splice.finish();
}

std::string rewrite_binary(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                           const Attribute* old_normals, const WriteOptions&) {
  check_fits_floats(positions);
  const Layout& layout = layout_of<Layout>(source);
  std::string bytes = source.bytes;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::size_t begin = layout.vertex_begin + i * layout.width * sizeof(float);
    replace_floats(bytes, begin, source.mesh.positions[i], positions[i], layout.order);
    if (normals.empty()) continue;
    const Vec3d old = vector_at(old_normals->values, i);
    const std::size_t normal = layout.colors_first ? layout.width - layout.uv - 3 : 3;
    replace_floats(bytes, begin + normal * sizeof(float), old, normals[i], layout.order);
  }
  return bytes;
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options) {
  const auto rewrite = layout_of<Layout>(source).binary ? rewrite_binary : rewrite_text;
  return rewrite(source, positions, normals, source.mesh.find_attribute("normal"), options);
}

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  if (layout_of<Layout>(source).binary) return;
  TextCursor text(source.bytes, source.format, layout_of<Layout>(source).vertex_begin);
  for (std::size_t i = 0; i < source.mesh.vertex_count(); ++i, text.next_line()) {
    for (std::size_t axis = 0; axis < 3; ++axis) visit(text.next());
  }
}

std::vector<std::string> source_losses(const ShapeFile& source) {
  if (layout_of<Layout>(source).all_read) return {};
  return {"numbers that are not colors of one kind are left out"};
}

bool stores_floats(const ShapeFile& source) { return layout_of<Layout>(source).binary; }

const Attribute* find(const Mesh& mesh, std::string_view name, Domain domain) {
  for (const Attribute& attribute : mesh.attributes) {
    if (attribute.name == name && attribute.domain == domain) return &attribute;
  }
  return nullptr;
}

// What the new mesh has of what the keyword says.
struct Columns {
  const Attribute* normal = nullptr;
  const Attribute* color = nullptr;
  const Attribute* uv = nullptr;
  const Attribute* face_color = nullptr;

  std::array<const Attribute*, 3> in_order{};  // of those of vertices, or null

  Columns(const Mesh& mesh, bool colors_first)
      : normal(find(mesh, "normal", Domain::vertex)),
        color(find(mesh, "color", Domain::vertex)),
        uv(find(mesh, "uv", Domain::vertex)),
        face_color(find(mesh, "color", Domain::face)),
        in_order{colors_first ? color : normal, colors_first ? normal : color, uv} {
    if (face_color == nullptr) face_color = find(mesh, "color_index", Domain::face);
  }
};

std::span<const double> values_of(const Attribute& attribute, std::size_t element) {
  const std::size_t n = static_cast<std::size_t>(attribute.components);
  return std::span(attribute.values).subspan(element * n, n);
}

// The file up to its counts. Where its colors are none that were read, the keyword speaks of none.
std::string beginning(const ShapeFile& source, const Columns& columns) {
  const Header header = parse_header(source.bytes, source.format);
  if (header.fields.colors && columns.color == nullptr) {
    const std::string letters = std::string(header.fields.uv ? "ST" : "") + (header.fields.normals ? "N" : "");
    return letters + "OFF" + (header.binary ? " BINARY\n" : "\n");
  }
  if (header.binary) return source.bytes.substr(0, header.counts_begin);
  TextCursor text(source.bytes, source.format, header.counts_begin);
  text.next();
  return source.bytes.substr(0, text.word_begin());
}

class TextWriter {
 public:
  TextWriter(const NewMesh& shape, const Columns& columns, std::optional<int> decimals)
      : decimals_(decimals),
        source_(shape.source),
        mesh_(shape.mesh),
        columns_(columns),
        line_end_(line_end_of(shape.source.bytes)) {}

  std::string run() {
    text_ = beginning(source_, columns_);
    text_ += std::to_string(mesh_.vertex_count()) + ' ' + std::to_string(mesh_.face_count()) + " 0";
    text_ += line_end_;
    for (std::size_t i = 0; i < mesh_.vertex_count(); ++i) append_vertex(i);
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) append_face(f);
    append_rest();
    return std::move(text_);
  }

 private:
  void append_vertex(std::size_t i) {
    append_point(text_, mesh_.positions[i], decimals_);
    for (const Attribute* attribute : columns_.in_order) {
      if (attribute == nullptr) continue;
      attribute == columns_.color ? append_color(*attribute, i) : append_numbers(values_of(*attribute, i));
    }
    text_ += line_end_;
  }

  void append_face(std::size_t f) {
    text_ += std::to_string(mesh_.face(f).size());
    for (const std::uint32_t v : mesh_.face(f)) text_ += ' ' + std::to_string(v);
    if (columns_.face_color != nullptr) append_color(*columns_.face_color, f);
    text_ += line_end_;
  }

  void append_numbers(std::span<const double> numbers) {
    for (const double number : numbers) {
      text_ += ' ';
      append_real(text_, number);
    }
  }

  // A real number has a point or an exponent, so that it is not read as one of 0 to 255.
  void append_color(const Attribute& color, std::size_t element) {
    for (const double value : values_of(color, element)) {
      text_ += ' ';
      if (is_integer(color.type)) {
        text_ += std::to_string(static_cast<std::int64_t>(nearest_of(color.type, value)));
        continue;
      }
      const std::size_t begin = text_.size();
      append_real(text_, value);
      if (text_.find_first_of(".e", begin) == std::string::npos) text_ += ".0";
    }
  }

  void append_rest() {
    std::string_view rest = std::string_view(source_.bytes).substr(layout_of<Layout>(source_).faces_end);
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    if (!rest.empty() && is_line_end(rest.front())) rest.remove_prefix(line_end_of(rest).size());
    text_ += rest;
  }

  std::optional<int> decimals_;
  const ShapeFile& source_;
  const Mesh& mesh_;
  const Columns& columns_;
  std::string_view line_end_;
  std::string text_;
};

class BinaryWriter {
 public:
  BinaryWriter(const NewMesh& shape, const Columns& columns)
      : source_(shape.source), mesh_(shape.mesh), columns_(columns), layout_(layout_of<Layout>(shape.source)) {}

  std::string run() {
    check_fits_floats(mesh_.positions);
    bytes_ = beginning(source_, columns_);
    for (const std::size_t count : {mesh_.vertex_count(), mesh_.face_count(), std::size_t{0}}) append_whole(count);
    for (std::size_t i = 0; i < mesh_.vertex_count(); ++i) append_vertex(i);
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) append_face(f);
    return std::move(bytes_);  // the end tells the form; after it nothing may follow
  }

 private:
  void append_vertex(std::size_t i) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_real_number(mesh_.positions[i][axis]);
    for (const Attribute* attribute : columns_.in_order) {
      if (attribute == nullptr) continue;
      for (const double value : values_of(*attribute, i)) append_real_number(value);
    }
  }

  void append_face(std::size_t f) {
    append_whole(mesh_.face(f).size());
    for (const std::uint32_t v : mesh_.face(f)) append_whole(v);
    if (!layout_.color_counts) return;
    const Attribute* color = columns_.face_color;
    append_whole(color == nullptr ? 0 : static_cast<std::size_t>(color->components));
    if (color == nullptr) return;
    for (const double value : values_of(*color, f)) {
      if (color->name == "color_index") {
        append_whole(static_cast<std::size_t>(std::max(0.0, std::round(value))));
      } else {
        append_real_number(value);
      }
    }
  }

  void append_whole(std::size_t value) { append(static_cast<std::uint32_t>(value)); }
  void append_real_number(double value) { append(static_cast<float>(nearest_of(NumberType::float32, value))); }

  void append(auto value) {
    const auto stored = layout_.order == std::endian::native ? value : swap_bytes(value);
    bytes_.append(reinterpret_cast<const char*>(&stored), sizeof stored);
  }

  const ShapeFile& source_;
  const Mesh& mesh_;
  const Columns& columns_;
  const Layout& layout_;
  std::string bytes_;
};

std::string remeshed(const NewMesh& shape, const WriteOptions& options) {
  const Columns columns(shape.mesh, layout_of<Layout>(shape.source).colors_first);
  if (layout_of<Layout>(shape.source).binary) return BinaryWriter(shape, columns).run();
  return TextWriter(shape, columns, options.decimals).run();
}

std::vector<std::string> remesh_losses(const ShapeFile& source) {
  const Layout& layout = layout_of<Layout>(source);
  std::vector<std::string> losses;
  if (!layout.all_read) losses.emplace_back("numbers that are not colors of one kind are left out");
  if (layout.binary && layout.faces_end < source.bytes.size()) {
    losses.push_back(counted(source.bytes.size() - layout.faces_end, "byte after the last face is left out",
                             "bytes after the last face are left out"));
  }
  const std::string_view rows = std::string_view(source.bytes).substr(0, layout.faces_end);
  if (!layout.binary && rows.find('#', layout.vertex_begin) != std::string_view::npos) {
    losses.emplace_back("comments after the counts are left out");
  }
  return losses;
}

}  // namespace
}  // namespace knead::detail::off

const knead::detail::Codec knead::detail::off_codec{.name = "off",
                                                    .read = off::read,
                                                    .rewrite = off::rewrite,
                                                    .generate = off::generate,
                                                    .losses = off::losses,
                                                    .source_losses = off::source_losses,
                                                    .remeshed = off::remeshed,
                                                    .remesh_losses = off::remesh_losses,
                                                    .stores_floats = off::stores_floats,
                                                    .visit_coordinates = off::visit_coordinates};
