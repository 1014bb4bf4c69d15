// Reading OFF BINARY: 32-bit numbers.
#include <array>
#include <utility>

#include "knead/io/cursor.h"
#include "knead/io/off/mesh.h"

namespace knead::io_detail::off {
namespace {

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
      if (corners > cursor.left() / 4) cursor.fail(too_many(corners, "corners", cursor));
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

  static std::string too_many(std::uint32_t count, const char* what, const ByteCursor& cursor) {
    return std::to_string(count) + " " + what + " are declared, but only " + std::to_string(cursor.left()) +
           " bytes follow; the file is cut short or damaged";
  }

  // Of vertices and faces.
  std::pair<std::uint32_t, std::uint32_t> read_counts(ByteCursor& cursor) const {
    const std::uint32_t vertices = cursor.take<std::uint32_t>("the count of vertices");
    const std::uint32_t faces = cursor.take<std::uint32_t>("the count of faces");
    cursor.take<std::uint32_t>("the count of edges");
    if (vertices == 0) cursor.fail("0 vertices are declared; there is no shape in it");
    if (vertices > cursor.left() / (4 * width_)) cursor.fail(too_many(vertices, "vertices", cursor));
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

}  // namespace

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

}  // namespace knead::io_detail::off
