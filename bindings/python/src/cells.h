// What a volume mesh has besides its points.
#pragma once

#include <functional>
#include <vector>

#include "knead/io.h"

namespace knead::python {

struct MeshParts {
  std::vector<Patch> patches;
  std::function<VolumeCells()> cells;  // which are read when they are asked for
};

}  // namespace knead::python
