// Files of points: text (xyz), the scans of laser scanners (ptx), and those of the Point Cloud Library (pcd).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/codec.h"
#include "io/numbers.h"
#include "io/text.h"
#include "knead/io.h"
#include "knead/vec.h"

namespace knead::detail::xyz {

// The columns of a table, counted from 0.
struct Columns {
  char separator = ' ';  // ' ' stands for any number of blanks
  std::array<std::size_t, 3> position{};
  std::vector<std::string> names;  // of all columns; empty: they have none
};

// The beginning of a file's points, and its columns.
struct TableStart {
  Columns columns;
  std::size_t points_begin = 0;            // the byte where the line of the first point begins
  std::size_t names_begin = 0;             // the line that names the columns; begin == end: none does
  std::size_t names_end = 0;               // with its line end
  std::optional<std::size_t> count_begin;  // of the declared number of points
};

// Returns the columns of a file that names them: x, y and z in any case, also with units ("X [m]"), as in "//X" or
// "pos_x"; easting, northing and height (elevation, altitude); the point coordinates of ParaView ("Points:0"). Also
// returns those of a molecule, which is a number of atoms, a line of text, and lines "O 0.1 0 0.2", and those of rows
// in quotes. Empty for other files: their columns are taken by position. Throws InvalidInput where the names say that
// the first three numbers are no coordinates: longitude and latitude, x and y without z, names of which none is known.
std::optional<TableStart> find_table(std::string_view bytes, const std::string& name);

// The rows of a table, front to back. Empty lines and comments (#, % or // at the beginning) are passed over.
class Rows {
 public:
  // The bytes must outlive this; `begin` is the beginning of a line.
  Rows(std::string_view bytes, std::size_t begin, char separator)
      : bytes_(bytes), next_(begin), separator_(separator) {}

  // Goes to the next row; false at the end.
  bool next();

  std::size_t begin() const { return begin_; }

  // The fields, without the blanks and quotes around them.
  const std::vector<std::string_view>& fields() const { return fields_; }

 private:
  std::string_view bytes_;
  std::size_t next_;
  std::size_t begin_ = 0;
  char separator_;
  std::vector<std::string_view> fields_;
};

struct Layout {
  std::size_t points_begin = 0;     // the byte where the line of the first point, or a line before it, begins
  bool label_first = false;         // a word stands before x y z on each line
  bool labels = false;              // some words after x y z are no numbers
  bool has_names = false;           // a line before the points names the columns
  bool columns_read = true;         // the numbers after x y z, if any, are attributes of the mesh
  std::optional<Columns> table;     // of files whose columns have names, and of molecules
  std::vector<std::size_t> normal;  // the three columns of the normals in a table, if it has any
  std::vector<std::uint32_t>
      unplaced;  // lines, counted with all points, of points that the mesh lacks (mesh_builder.h)
};

// Whether a word begins as a number does; "nan" and "inf" are numbers too.
bool is_number(std::string_view word);

// The words of a file of points in text: between blanks, or between commas or semicolons.
class Words {
 public:
  // The bytes and the name must outlive this.
  Words(std::string_view bytes, const std::string& name) : bytes_(bytes), text_(bytes, name, text_begin(bytes, name)) {}

  const TextCursor& text() const { return text_; }

  // The next word of this line; empty where the line, or the file, has no more. Comments begin with #, % or //. Throws
  // InvalidInput where separators are mixed: commas among blanks may be those of decimals.
  std::string_view next_on_line();
  bool next_line();

  // The first word of the next line that has any; empty at the end of the file.
  std::string_view next();

  // Goes back to a byte at the beginning of a line.
  void go_to(std::size_t position);

 private:
  void note_separator(char c, std::size_t& count);
  void note_gap(std::size_t separators, bool is_number);
  std::size_t word_end(std::size_t begin) const;

  std::string_view bytes_;
  TextCursor text_;
  bool at_begin_ = true;       // of a line
  bool after_number_ = false;  // the word before is a number
  bool separated_ = false;     // two numbers of this line have a comma between them
  bool by_blanks_ = false;     // two numbers of this line have only blanks between them
  bool mixed_ = false;
  char separator_ = '\0';  // of this line
};

// A point on each line: x y z and any further numbers, between blanks, or between commas or semicolons. Lines that are
// empty or begin with #, % or // are passed over; the number of points and the names of the columns may stand before
// them. Where columns are named x, y and z (find_table says how), these are the coordinates; otherwise they are the
// first three numbers, and a note says which columns these are where more follow. Words that are no numbers (labels)
// may stand in other columns; points whose coordinates are not finite are left out of the mesh. Other columns have
// their names; nx, ny, nz are "normal" and r, g, b from 0 to 255 "color". Without names three further numbers that are
// of unit length in at least 95% of the lines are "normal", three whole numbers from 0 to 255 "color", others "column4"
// and so on; none if lines differ in how many they have, or have more than 64.
void read(ShapeFile& shape, const std::string& name);

}  // namespace knead::detail::xyz

namespace knead::detail::ptx {

// The pose of a scan: world = linear * local + offset.
struct Scan {
  std::size_t begin = 0;  // the byte of its first point's line
  std::size_t rows = 0;   // lines
  Mat3d linear;
  Vec3d offset;
  Mat3d inverse;

  bool is_identity() const { return linear == Mat3d{} && offset == Vec3d{}; }
};

struct Layout {
  std::vector<Scan> scans;
  bool columns_read = true;             // all numbers after x y z are attributes of the mesh
  std::vector<std::uint32_t> unplaced;  // rows, counted over all scans, of directions without a point (mesh_builder.h)
};

}  // namespace knead::detail::ptx

namespace knead::detail::pcd {

// A column of numbers and its meaning.
enum class Role { other, position, normal, color };

struct Field {
  std::string name;
  StoredType type = StoredType::float32;
  std::size_t count = 1;   // numbers
  std::size_t offset = 0;  // of its first byte in a row, or of its first word
  Role role = Role::other;
  std::size_t axis = 0;  // of a position or a normal
};

struct Layout {
  std::vector<Field> fields;
  bool ascii = true;
  std::size_t compressed = 0;  // where the word 'binary_compressed' begins; 0: none
  std::size_t points = 0;
  std::size_t row_size = 0;             // bytes, or words
  std::size_t body_begin = 0;           // the byte after the header
  std::vector<std::uint32_t> unplaced;  // rows of points that the mesh lacks (mesh_builder.h)
};

// Reads the header. Throws InvalidInput that names the line.
Layout parse_header(std::string_view bytes, const std::string& name);

// Turns a file with 'DATA binary_compressed' into one with 'DATA binary'; leaves others as they are and returns false.
// Throws InvalidInput for a damaged one.
bool uncompress(std::string& bytes, const std::string& name);

}  // namespace knead::detail::pcd
