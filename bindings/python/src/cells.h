// What a volume mesh has besides its points.
#pragma once

#include <vector>

#include "knead/io.h"

namespace knead::python {

struct MeshParts {
  std::vector<Patch> patches;
  VolumeCells cells;
};

}  // namespace knead::python
