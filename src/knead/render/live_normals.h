// Normals of many drawn vertices at once.
#pragma once

#include <span>
#include <vector>

#include "knead/render/live_rings.h"
#include "knead/render/live_view.h"

namespace knead::render {

struct LiveVertex {
  Vec3f position;  // renderer units
  Vec3f normal;    // unit; zero in a point cloud
};

// Fills in the normals of the drawn vertices in the range, whose positions are there already: the mean of the normals
// of the faces round each, weighted by about the corners' angles (within a tenth up to 120 degrees); (0, 0, 1) where
// there is none. points: of all vertices of the mesh. The same bits whatever the range.
void set_ring_normals(const Rings& rings, std::span<const Vec3f> points, const VertexRange& drawn,
                      std::vector<LiveVertex>& vertices);

}  // namespace knead::render
