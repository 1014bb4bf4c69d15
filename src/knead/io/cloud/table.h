// Points in text whose columns have names, and molecules: which columns hold the coordinates, and the fields of a row.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace knead::io_detail::xyz {

// The columns of a table, counted from 0.
struct Columns {
  char separator = ' ';  // ' ' stands for any number of blanks
  std::array<std::size_t, 3> position{};
  std::vector<std::string> names;  // of all columns; empty: they have none
};

// Where the points of a file begin.
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

}  // namespace knead::io_detail::xyz
