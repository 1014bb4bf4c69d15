// The points of solvers' meshes, and the rows of their formats in the format table (formats.h). Points move; elements,
// groups and all other bytes stay.
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

#include "io/formats.h"
#include "io/numbers.h"
#include "io/text.h"
#include "knead/io.h"
#include "knead/vec.h"

namespace knead::io_detail::solver {

// How coordinates are spelled.
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

// Where the coordinates of a point stand.
struct PointSite {
  std::array<std::string_view, 3> words;  // pieces of the file: text, with the blanks of its field, or the bytes
  std::size_t dimensions = 3;             // coordinates that the file has; the others are 0
  Spelling spelling = Spelling::words;
  bool swapped = false;  // binary: in the other byte order
};

using PointVisitor = std::function<void(const PointSite&)>;

// Calls visit for each point of a file, front to back. Throws InvalidInput with the line, or the byte.
using Scan = void (*)(std::string_view bytes, const std::string& name, const PointVisitor& visit);

struct Kind {
  std::string_view format;  // name in the format table
  const char* what;         // of the files, e.g. "SU2"
  const char* stays;        // all else
  Scan scan;
};

void scan_su2(std::string_view bytes, const std::string& name, const PointVisitor& visit);
// Gmsh's files, versions 2 to 2.2 and 4.1, as text or binary.
void scan_gmsh(std::string_view bytes, const std::string& name, const PointVisitor& visit);
// OpenFOAM's file `points`, as text or binary.
void scan_foam(std::string_view bytes, const std::string& name, const PointVisitor& visit);
// Nastran's bulk data: GRID in small, large and free fields.
void scan_nastran(std::string_view bytes, const std::string& name, const PointVisitor& visit);
// Abaqus' input files: *NODE.
void scan_abaqus(std::string_view bytes, const std::string& name, const PointVisitor& visit);
// Universal files: dataset 2411.
void scan_unv(std::string_view bytes, const std::string& name, const PointVisitor& visit);

inline constexpr Kind kSu2{"su2", "SU2", "elements and markers", scan_su2};
inline constexpr Kind kGmsh{"msh", "gmsh's format", "elements, groups and the geometry", scan_gmsh};
inline constexpr Kind kFoam{"foam", "OpenFOAM's file of points", "faces and cells, in other files,", scan_foam};
inline constexpr Kind kNastran{"bdf", "Nastran's bulk data", "all cards but GRID", scan_nastran};
inline constexpr Kind kAbaqus{"inp", "Abaqus' format", "all keywords but *NODE", scan_abaqus};
inline constexpr Kind kUnv{"unv", "a universal file", "all datasets but 2411", scan_unv};

// What the reader leaves for the writer.
struct Layout {
  const Kind* kind = nullptr;
  bool floats = false;  // coordinates are 32-bit floats
  bool rounds = false;  // fields or words may be too short for all digits
};

// The points, without faces.
ShapeFile parse(const Kind& kind, std::string bytes, const std::string& name);

// Replaces the coordinates that moved. Throws InvalidInput where a coordinate that the file lacks is no longer 0.
std::string rewrite(const ShapeFile& source, std::span<const Vec3d> positions, std::span<const Vec3d> normals,
                    const WriteOptions& options);
std::vector<std::string> source_losses(const ShapeFile& source);
bool stores_floats(const ShapeFile& source);
void visit_coordinates(const ShapeFile& source, const WordVisitor& visit);

// Returns the kind's row of the format table.
template <const Kind& kind>
constexpr Format format(std::span<const std::string_view> extensions = {}) {
  Format row{};
  row.name = kind.format;
  row.parse = [](std::string bytes, const std::string& name) { return parse(kind, std::move(bytes), name); };
  row.rewrite = rewrite;
  row.source_losses = source_losses;
  row.rewrites_floats = stores_floats;
  row.reads_floats = stores_floats;
  row.visit_coordinates = visit_coordinates;
  row.extensions = extensions;
  return row;
}

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

// The text without the blanks around it.
std::string_view trimmed(std::string_view text);

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

// Throws InvalidInput if the bytes that follow cannot hold so many points.
void require_room(std::size_t points, std::size_t left, std::size_t bytes_for_each, const TextCursor& text);

}  // namespace knead::io_detail::solver
