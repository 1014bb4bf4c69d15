// What a file of points in text holds besides points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace knead::io_detail::xyz {

struct Layout {
  std::size_t points_begin = 0;         // the byte where the line of the first point, or a line before it, begins
  bool label_first = false;             // a word stands before x y z on each line
  bool labels = false;                  // some words after x y z are no numbers
  bool has_names = false;               // a line before the points names the columns
  bool columns_read = true;             // the numbers after x y z, if any, are attributes of the mesh
  std::vector<std::uint32_t> unplaced;  // lines, counted with all points, of points that the mesh lacks (unplaced.h)
};

}  // namespace knead::io_detail::xyz
