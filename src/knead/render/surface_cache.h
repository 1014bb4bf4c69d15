// The surfaces of point sets, remembered.
#pragma once

#include <cstddef>
#include <vector>

#include "knead/field/field.h"
#include "knead/mesh/mesh.h"
#include "knead/render/tool_surface.h"

namespace knead::render {

// While a tool is dragged its point sets only travel: their surfaces, which take long to find, travel along. Remembers
// the few used last.
class SurfaceCache {
 public:
  // region_surface of a field whose region is a point set, with the field's own centre and level > 0; where such a set
  // was asked for before, apart from a shift (to 10^-6 of the level), that surface, shifted.
  Mesh surface(const Field& field, double level, const SurfaceDetail& detail);

  // How many surfaces were not remembered.
  std::size_t made() const { return made_; }

 private:
  struct Entry {
    PointSet<double> set;
    Vec3d center;
    double level = 0;
    SurfaceDetail detail;
    Mesh mesh;
  };
  std::vector<Entry> entries_;  // the one used last at the end
  std::size_t made_ = 0;
};

}  // namespace knead::render
