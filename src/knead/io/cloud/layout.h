// What is in an XYZ file besides points.
#pragma once

namespace knead::io_detail::xyz {

struct Layout {
  bool has_count = false;    // the first line that holds anything is the number of points
  bool columns_read = true;  // the numbers after x y z, if any, are attributes of the mesh
};

}  // namespace knead::io_detail::xyz
