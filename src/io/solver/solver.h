// The points of solvers' meshes. Points move; elements, groups and all other bytes stay.
//
// A format is a function that goes through a file and says where the coordinates of each point stand. Reading collects
// their numbers, and writing goes through the file again and replaces those that changed.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/codec.h"
#include "io/numbers.h"
#include "io/text.h"
#include "knead/io.h"
#include "knead/vec.h"

namespace knead::detail::solver {

// The spelling of coordinates.
enum class Spelling {
  words,        // as text, the shortest that reads back the same
  short_words,  // the same in at most 20 characters, as Abaqus reads them
  bulk_words,   // the same with a point in every number, as Nastran wants it
  field_8,      // as many digits as fit into a field of 8 characters, of Nastran's
  field_16,
  columns,  // 17 digits with D before the exponent, right-aligned; each word begins with the blanks before it
  float32,  // binary
  float64
};

// The coordinates of a point in a file.
struct PointSite {
  std::array<std::string_view, 3> words;  // pieces of the file: text, with the blanks of its field, or the bytes
  std::size_t dimensions = 3;             // coordinates that the file has; the others are 0
  Spelling spelling = Spelling::words;
  bool swapped = false;  // binary: in the other byte order
};

using PointVisitor = std::function<void(const PointSite&)>;

// Calls visit for each point of a file, front to back. Throws InvalidInput with the line, or the byte.
using Scan = void(std::string_view bytes, const std::string& name, const PointVisitor& visit);
Scan scan_su2;
Scan scan_gmsh;     // versions 2 to 2.2 and 4.1, as text or binary
Scan scan_foam;     // OpenFOAM's file `points`, as text or binary
Scan scan_nastran;  // bulk data: GRID in small, large and free fields
Scan scan_abaqus;   // *NODE
Scan scan_unv;      // universal files: dataset 2411

struct Kind {
  std::string_view format;  // the codec's name
  const char* stays;        // all but the points
  Scan* scan;
  std::span<const std::string_view> extensions{};
};

// The data that the reader keeps for the writer.
struct Layout {
  const Kind* kind = nullptr;
  bool floats = false;  // coordinates are 32-bit floats
  bool rounds = false;  // fields or words may be too short for all digits
};

// Front to back through the lines of a text, which end with LF, CR LF or CR.
class Lines {
 public:
  // The bytes and the name must outlive this.
  Lines(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name), next_(text_begin(bytes, name)) {}

  // Goes to the next line; false at the end.
  bool next();

  // The line without its end.
  std::string_view line() const { return line_; }

  // The number that a word of the file spells, as C, Fortran or Nastran do; an empty one is 0. Throws InvalidInput.
  double number(std::string_view word) const;

  // Throws InvalidInput that names the line.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view bytes_;
  const std::string& name_;
  std::size_t next_;
  std::string_view line_;
};

// Returns the words of a line whose first one is given. Throws InvalidInput if it has fewer.
PointSite words_from(std::string_view first, std::size_t dimensions, TextCursor& text);

// An element of gmsh: of a point, an edge, a triangle, and so on.
struct GmshElement {
  enum class Form : std::uint8_t { point, edge, triangle, quadrilateral, tetrahedron, hexahedron, wedge, pyramid };
  std::uint8_t type = 0;
  Form form = Form::point;
  std::uint8_t order = 1;
  std::uint8_t points = 1;

  std::int64_t dimension() const {
    return form >= Form::tetrahedron ? 3 : form >= Form::triangle ? 2 : form == Form::edge;
  }
};

// Returns the element of gmsh's number: those up to the fifth order, and up to the third also those without nodes
// inside faces and cells; null for others.
const GmshElement* gmsh_element(std::int64_t type);

// Appends the triangles of a face, or an edge, of an element of gmsh's type; none for a point or a cell.
void add_faces(std::int64_t type, std::span<const std::uint32_t> points, std::vector<Triangle>& faces);

// Appends a cell of gmsh's type, with its nodes in gmsh's order; nothing for other elements.
void add_cell(std::int64_t type, std::span<const std::uint32_t> points, VolumeCells& cells);
// Does this for a triangle or quadrilateral of a mesh of two dimensions with these points.
void add_flat_cell(std::int64_t type, std::span<const std::uint32_t> numbers, std::span<const Vec3d> points,
                   VolumeCells& cells);
// Returns whether all z are alike.
bool is_flat(std::span<const Vec3d> points);

// Return the named patches, whose points may repeat.
std::vector<Patch> su2_patches(std::string_view bytes, const std::string& name, std::size_t points);
std::vector<Patch> gmsh_patches(std::string_view bytes, const std::string& name);
// `name` is the folder's; the bytes are those of its files `boundary` and `faces`.
std::vector<Patch> foam_patches(std::string_view boundary, std::string_view faces, const std::string& name);

// Return the cells of the mesh with these points. Of foam_cells the bytes are those of the files `faces`, `owner` and
// `neighbour`.
VolumeCells su2_cells(std::string_view bytes, const std::string& name, std::span<const Vec3d> points);
VolumeCells gmsh_cells(std::string_view bytes, const std::string& name, std::span<const Vec3d> points);
VolumeCells foam_cells(std::string_view faces, std::string_view owner, std::string_view neighbour,
                       const std::string& name);

// Throws InvalidInput if `left` bytes cannot hold `points` points.
void require_room(std::size_t points, std::size_t left, std::size_t bytes_for_each, const TextCursor& text);

}  // namespace knead::detail::solver
