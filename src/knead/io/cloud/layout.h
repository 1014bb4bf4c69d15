// What a file of points in text holds besides points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "knead/io/cloud/table.h"

namespace knead::io_detail::xyz {

struct Layout {
  std::size_t points_begin = 0;         // the byte where the line of the first point, or a line before it, begins
  bool label_first = false;             // a word stands before x y z on each line
  bool labels = false;                  // some words after x y z are no numbers
  bool has_names = false;               // a line before the points names the columns
  bool columns_read = true;             // the numbers after x y z, if any, are attributes of the mesh
  std::optional<Columns> table;         // of files whose columns have names, and of molecules (table.h)
  std::vector<std::size_t> normal;      // the three columns of the normals in a table, if it has any
  std::vector<std::uint32_t> unplaced;  // lines, counted with all points, of points that the mesh lacks (unplaced.h)
};

}  // namespace knead::io_detail::xyz
