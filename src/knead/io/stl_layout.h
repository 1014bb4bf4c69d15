// What is in an STL file besides triangles.
#pragma once

#include <cstddef>

namespace knead {

// The corners of the mesh are those of the file, in its order.
struct StlLayout {
  bool binary = false;
  std::size_t solids = 1;  // a text may have several
};

}  // namespace knead
