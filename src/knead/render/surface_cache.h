// A cache of the surfaces of point sets.
#pragma once

#include <cstddef>
#include <vector>

#include "knead/field/field.h"
#include "knead/mesh/mesh.h"
#include "knead/render/tool_surface.h"

namespace knead::render {

// Keeps the few surfaces that were used last. A tool that is dragged only translates its point sets, so their surfaces,
// which are slow to compute, can be translated, too.
class SurfaceCache {
 public:
  // Returns region_surface of a field whose region is a point set, about the field's own centre; level > 0. If the
  // cache has the surface of a translated set (equal to 10^-6 of the level), translates that surface instead.
  Mesh surface(const Field& field, double level, const SurfaceDetail& detail);

  // Returns how many surfaces were computed.
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
