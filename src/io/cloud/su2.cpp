// SU2 meshes: their points.
#include <algorithm>
#include <cmath>
#include <optional>

#include "io/cloud/cloud.h"
#include "io/formats.h"
#include "io/mesh_builder.h"
#include "io/numbers.h"
#include "io/text.h"

namespace knead::io_detail::su2 {
namespace {

constexpr std::size_t kMaxDimensions = 3;
constexpr double kFlat = 1e-6;  // of the diagonal of the box: how far a mesh of two dimensions may leave its plane

// The first word of the next line that is no comment; empty at the end of the file.
std::string_view next_line_word(TextCursor& text) {
  std::string_view word = text.next();
  while (word.starts_with('%') || word.starts_with('#')) {
    if (!text.next_line()) return {};
    word = text.next();
  }
  return word;
}

// A line KEY= VALUE, with or without blanks.
struct KeyLine {
  std::string_view key;
  std::string_view value;  // the first word after the sign
};

std::optional<KeyLine> key_line(std::string_view bytes, std::size_t begin) {
  const std::size_t end = std::min(bytes.find_first_of("\r\n", begin), bytes.size());
  const std::size_t sign = bytes.substr(0, end).find('=', begin);
  if (sign == std::string_view::npos) return std::nullopt;
  std::size_t key_end = sign;
  while (key_end > begin && is_blank(bytes[key_end - 1])) --key_end;
  std::size_t value = sign + 1;
  while (value < end && is_blank(bytes[value])) ++value;
  return KeyLine{bytes.substr(begin, key_end - begin), bytes.substr(value, token_end(bytes, value) - value)};
}

class Reader {
 public:
  Reader(ShapeFile& shape, const std::string& name)
      : shape_(shape), name_(name), text_(shape.bytes, name, text_begin(shape.bytes, name)) {}

  Layout run() {
    for (std::string_view word = next_line_word(text_); !word.empty(); word = next_line_word(text_)) {
      const std::optional<KeyLine> line = key_line(shape_.bytes, text_.word_begin());
      if (line && line->key == "NDIME") {
        layout_.dimensions = text_.whole(line->value, kMaxDimensions, "the number of dimensions, NDIME=");
        if (layout_.dimensions < 2) text_.fail("NDIME= must be 2 or 3");
      } else if (line && line->key == "NPOIN") {
        read_points(text_.whole(line->value, kMaxElements, "the number of points, NPOIN="));
        continue;
      }
      if (!text_.next_line()) break;
    }
    if (layout_.blocks.empty()) throw InvalidInput(Place{name_}, "has no points (NPOIN=); is it an SU2 mesh?");
    if (shape_.mesh.positions.empty()) throw InvalidInput(Place{name_}, "has no points; there is no shape in it");
    shape_.notes.emplace_back("its points are read and moved; elements and markers stay as they are");
    return std::move(layout_);
  }

 private:
  void read_points(std::size_t count) {
    if (layout_.dimensions == 0) text_.fail("NDIME= must come before NPOIN=; is it an SU2 mesh?");
    text_.next_line();
    const std::size_t left = shape_.bytes.size() - text_.position();
    if (count > left / (2 * layout_.dimensions) + 1) {
      text_.fail(std::to_string(count) + " points are declared, but only " + std::to_string(left) +
                 " bytes follow; the file is cut short or damaged");
    }
    if (shape_.mesh.positions.size() + count > kMaxElements) text_.fail("more than 4294967295 points; split the mesh");
    layout_.blocks.push_back({text_.position(), count});
    for (std::size_t i = 0; i < count; ++i) {
      Vec3d p{};
      std::string_view word = next_line_word(text_);
      for (std::size_t axis = 0; axis < layout_.dimensions; ++axis) {
        p[axis] = text_.coordinate(word);
        if (axis + 1 < layout_.dimensions) word = text_.next_on_line();
      }
      shape_.mesh.positions.push_back(p);
      text_.next_line();
    }
  }

  ShapeFile& shape_;
  const std::string& name_;
  TextCursor text_;
  Layout layout_;
};

// Calls visit(point, words) for the two or three words of each point; the third of two is empty.
template <class Visit>
void for_each_point(const ShapeFile& source, Visit visit) {
  const Layout& layout = layout_of<Layout>(source);
  std::size_t point = 0;
  for (const Block& block : layout.blocks) {
    TextCursor text(source.bytes, source.format, block.begin);
    for (std::size_t i = 0; i < block.points; ++i, text.next_line()) {
      std::array<std::string_view, kMaxDimensions> words;
      words[0] = next_line_word(text);
      for (std::size_t axis = 1; axis < layout.dimensions; ++axis) words[axis] = text.next_on_line();
      visit(point++, words);
    }
  }
}

void require_flat(std::span<const Vec3d> positions) {
  Box box;
  for (const Vec3d& p : positions) box.extend(p);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (std::abs(positions[i].z) <= kFlat * box.diagonal()) continue;
    throw InvalidInput("the mesh has two dimensions, but point " + std::to_string(i) +
                       " has left its plane; use strokes that keep z = 0");
  }
}

}  // namespace

ShapeFile parse(std::string bytes, const std::string& name) {
  ShapeFile shape;
  shape.format = "su2";
  shape.bytes = std::move(bytes);
  set_layout(shape, Reader(shape, name).run());
  return shape;
}

std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d>,
                    const WriteOptions& options) {
  const std::size_t dimensions = layout_of<Layout>(source).dimensions;
  if (dimensions < kMaxDimensions) require_flat(positions);
  Splice splice(source.bytes, options.decimals);
  for_each_point(source, [&](std::size_t point, const std::array<std::string_view, kMaxDimensions>& words) {
    for (std::size_t axis = 0; axis < dimensions; ++axis) {
      splice.replace_coordinate(words[axis], source.mesh.positions[point][axis], positions[point][axis]);
    }
  });
  return splice.finish();
}

std::string generate(const Mesh&, const WriteOptions&) {
  throw InvalidInput("SU2 holds the elements of a solver's mesh, which this shape has not; write .ply or .xyz");
}

std::vector<std::string> losses(const Mesh&) {
  return {"SU2 holds the elements of a solver's mesh, which this shape has not"};
}

std::vector<std::string> source_losses(const ShapeFile&) { return {"elements and markers are left out"}; }

void visit_coordinates(const ShapeFile& source, const WordVisitor& visit) {
  const std::size_t dimensions = layout_of<Layout>(source).dimensions;
  for_each_point(source, [&](std::size_t, const std::array<std::string_view, kMaxDimensions>& words) {
    for (std::size_t axis = 0; axis < dimensions; ++axis) visit(words[axis]);
  });
}

}  // namespace knead::io_detail::su2
