// What is in an STL file besides triangles.
#pragma once

#include <cstddef>

namespace knead::io_detail::stl {

// The corners of the mesh are those of the file, in its order.
struct Layout {
  bool binary = false;
  std::size_t solids = 1;  // a text may have several
};

}  // namespace knead::io_detail::stl
