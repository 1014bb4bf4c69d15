// Places and normals of drawn vertices made on the GPU, of points that are there.
#pragma once

#include <cstdint>
#include <span>

#include "knead/gl/objects.h"
#include "knead/render/live_gpu.h"
#include "knead/render/live_mesh.h"
#include "knead/render/live_view.h"

namespace knead::render {

// What LiveMesh::move does, by compute shaders; for one mesh. Normals are those of set_ring_normals up to rounding.
class LiveCompute {
 public:
  // Throws std::runtime_error, one line, where the driver has no OpenGL 4.3 or no room for a mesh of this size.
  explicit LiveCompute(const LiveMesh& mesh);

  // Takes the places of all vertices, and fills in the drawn ones.
  void move(std::span<const PointBuffer> points, const Placement& placement, const LiveBuffers& drawn) const;

 private:
  gl::Program place_;
  gl::Program shade_;
  gl::Buffer placed_;      // three floats per vertex of the mesh
  gl::Buffer source_;      // per drawn vertex: the vertex of the mesh
  gl::Buffer ring_begin_;  // as Rings
  gl::Buffer ring_list_;
  std::uint32_t drawn_count_ = 0;
  bool has_rings_ = false;  // else a cloud
};

}  // namespace knead::render
