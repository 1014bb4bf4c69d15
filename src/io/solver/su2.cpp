// SU2's meshes: where their points stand, and their markers.
#include <algorithm>
#include <array>
#include <optional>

#include "io/mesh_builder.h"
#include "io/solver/solver.h"
#include "knead/error.h"

namespace knead::detail::solver {
namespace {

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
  std::size_t value = sign + 1;
  while (value < end && is_blank(bytes[value])) ++value;
  return KeyLine{trimmed(bytes.substr(begin, sign - begin)), bytes.substr(value, token_end(bytes, value) - value)};
}

void scan_su2_points(std::size_t dimensions, std::size_t count, std::string_view bytes, TextCursor& text,
                     const PointVisitor& visit) {
  if (dimensions == 0) text.fail("NDIME= must come before NPOIN=; is it an SU2 mesh?");
  text.next_line();
  require_room(count, bytes.size() - text.position(), 2 * dimensions, text);
  for (std::size_t i = 0; i < count; ++i) {
    visit(words_from(next_line_word(text), dimensions, text));
    text.next_line();
  }
}

// The points of a cell of a type, as VTK numbers them; 0: no cell of a boundary.
std::size_t points_of_vtk_type(std::size_t type) {
  if (type == 1) return 1;
  if (type == 3) return 2;
  return type == 5 ? 3 : type == 9 ? 4 : 0;
}

void read_marker(std::size_t count, std::size_t first, std::size_t end, TextCursor& text, Patch& patch) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!text.next_line()) text.fail("a marker is cut short");
    const std::size_t size = points_of_vtk_type(text.whole(next_line_word(text), 99, "the type of an element"));
    if (size == 0) text.fail("the elements of a marker must be points, lines, triangles or quadrilaterals");
    std::array<std::uint32_t, 4> points{};
    for (std::size_t k = 0; k < size; ++k) {
      const std::size_t point = first + text.whole(text.next_on_line(), kMaxElements, "the number of a point");
      if (point >= end) text.fail("a marker names a point that the mesh lacks");
      points[k] = static_cast<std::uint32_t>(point);
      patch.points.push_back(points[k]);
    }
    constexpr std::array<std::int64_t, 5> types{0, 15, 1, 2, 3};  // of gmsh
    add_faces(types[size], std::span(points).first(size), patch.faces);
  }
}

// A type of element, with VTK's number and its order of the corners.
struct Su2Element {
  std::size_t type = 0;
  std::size_t corners = 0;
  std::optional<CellKind> kind;  // none: of two dimensions
};
constexpr std::array kSu2Elements{Su2Element{5, 3, {}},
                                  Su2Element{9, 4, {}},
                                  Su2Element{10, 4, CellKind::tetrahedron},
                                  Su2Element{12, 8, CellKind::hexahedron},
                                  Su2Element{13, 6, CellKind::wedge},
                                  Su2Element{14, 5, CellKind::pyramid}};

void read_elements(std::size_t count, std::size_t first, std::span<const Vec3d> positions, TextCursor& text,
                   VolumeCells& cells) {
  const bool has_flat_cells = is_flat(positions);
  for (std::size_t i = 0; i < count; ++i) {
    if (!text.next_line()) text.fail("the elements are cut short");
    const std::size_t type = text.whole(next_line_word(text), kMaxElements, "the type of an element");
    const auto* const found = std::find_if(kSu2Elements.begin(), kSu2Elements.end(),
                                           [&](const Su2Element& element) { return element.type == type; });
    const bool is_known = found != kSu2Elements.end() || points_of_vtk_type(type) > 0;
    if (!is_known) text.fail("elements of the type " + std::to_string(type) + " are not known");
    if (found == kSu2Elements.end() || found->kind.has_value() == has_flat_cells) continue;
    std::array<std::uint32_t, 8> points{};
    for (std::size_t k = 0; k < found->corners; ++k) {
      const std::size_t point = first + text.whole(text.next_on_line(), kMaxElements, "the number of a point");
      if (point >= positions.size()) text.fail("an element names a point that the mesh lacks");
      points[k] = static_cast<std::uint32_t>(point);
    }
    const std::span<const std::uint32_t> corners = std::span(points).first(found->corners);
    found->kind ? cells.cells.add(*found->kind, corners) : knead::add_flat_cell(corners, {}, positions, cells);
  }
}

// Calls visit(line, text, first) for each line with a key; `first`: the number of the zone's first point.
template <class Visit>
void visit_keys(std::string_view bytes, const std::string& name, const Visit& visit) {
  TextCursor text(bytes, name, text_begin(bytes, name));
  std::size_t first = 0;
  std::size_t read = 0;
  for (std::string_view word = next_line_word(text); !word.empty(); word = next_line_word(text)) {
    const std::optional<KeyLine> line = key_line(bytes, text.word_begin());
    if (line && line->key == "IZONE") first = read;
    if (line && line->key == "NPOIN") read += text.whole(line->value, kMaxElements, "the number of points");
    if (line) visit(*line, text, first);
    if (!text.next_line()) break;
  }
}

}  // namespace

void scan_su2(std::string_view bytes, const std::string& name, const PointVisitor& visit) {
  TextCursor text(bytes, name, text_begin(bytes, name));
  std::size_t dimensions = 0;
  bool has_points = false;
  for (std::string_view word = next_line_word(text); !word.empty(); word = next_line_word(text)) {
    const std::optional<KeyLine> line = key_line(bytes, text.word_begin());
    if (line && line->key == "NDIME") {
      dimensions = text.whole(line->value, 3, "the number of dimensions, NDIME=");
      if (dimensions < 2) text.fail("NDIME= must be 2 or 3");
    } else if (line && line->key == "NPOIN") {
      const std::size_t count = text.whole(line->value, kMaxElements, "the number of points, NPOIN=");
      scan_su2_points(dimensions, count, bytes, text, visit);
      has_points = true;
      continue;
    }
    if (!text.next_line()) break;
  }
  if (!has_points) throw InvalidInput(Place{name}, "has no points (NPOIN=); is it an SU2 mesh?");
}

std::vector<Patch> su2_patches(std::string_view bytes, const std::string& name, std::size_t points) {
  std::vector<Patch> patches;
  visit_keys(bytes, name, [&](const KeyLine& line, TextCursor& text, std::size_t first) {
    if (line.key == "MARKER_TAG") patches.push_back({std::string(line.value), {}});
    if (line.key != "MARKER_ELEMS") return;
    if (patches.empty()) text.fail("MARKER_TAG= must come before MARKER_ELEMS=");
    read_marker(text.whole(line.value, kMaxElements, "the number of elements"), first, points, text, patches.back());
  });
  return patches;
}

VolumeCells su2_cells(std::string_view bytes, const std::string& name, std::span<const Vec3d> points) {
  VolumeCells cells;
  visit_keys(bytes, name, [&](const KeyLine& line, TextCursor& text, std::size_t first) {
    if (line.key != "NELEM") return;
    read_elements(text.whole(line.value, kMaxElements, "the number of elements"), first, points, text, cells);
  });
  return cells;
}

}  // namespace knead::detail::solver
