// Writing an OFF file anew with its keyword and another mesh.
#include "knead/io/binary_floats.h"
#include "knead/io/layout.h"
#include "knead/io/new_mesh.h"
#include "knead/io/number_types.h"
#include "knead/io/off/layout.h"
#include "knead/io/off/mesh.h"
#include "knead/io/off/off.h"

namespace knead::io_detail::off {
namespace {

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

  explicit Columns(const Mesh& mesh)
      : normal(find(mesh, "normal", Domain::vertex)),
        color(find(mesh, "color", Domain::vertex)),
        uv(find(mesh, "uv", Domain::vertex)),
        face_color(find(mesh, "color", Domain::face)) {
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
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis > 0) text_ += ' ';
      append_decimals(text_, mesh_.positions[i][axis], decimals_);
    }
    if (columns_.normal != nullptr) append_numbers(values_of(*columns_.normal, i));
    if (columns_.color != nullptr) append_color(*columns_.color, i);
    if (columns_.uv != nullptr) append_numbers(values_of(*columns_.uv, i));
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
    for (const Attribute* attribute : {columns_.normal, columns_.color, columns_.uv}) {
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

}  // namespace

std::string remeshed(const NewMesh& shape, const WriteOptions& options) {
  const Columns columns(shape.mesh);
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

}  // namespace knead::io_detail::off
