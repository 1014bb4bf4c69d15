// The nodes of a GLB file's scene and where they are. Internal to the GLB reader.
#pragma once

#include <string>
#include <vector>

#include "knead/io/glb/accessor.h"

namespace knead::io_detail::glb {

// A node that places a mesh.
struct Instance {
  std::size_t node = 0;
  std::size_t mesh = 0;
  Placement placement;
};

// The instances of the default scene (the first one, if none is named; all of the nodes, if there is none), in
// depth-first order. A skinned node is placed nowhere (glTF 2.0, 3.7.3.3): its vertices stay local. Nodes whose
// transform has no inverse are left out. Notes say both. Throws InvalidInput for nodes that form a cycle or have two
// parents, and for transforms that are none.
std::vector<Instance> find_instances(const Document& document, std::vector<std::string>& notes);

}  // namespace knead::io_detail::glb
