// What the GPU is given of a mesh: triangles with one normal per smooth group of faces round a vertex.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "knead/render/view.h"

namespace knead::render {

using Bytes4 = std::array<std::uint8_t, 4>;

struct DrawVertex {
  Vec3f position;  // renderer units
  Vec3f normal;    // unit; zero in a point cloud
  Bytes4 color{255, 255, 255, 255};
  Bytes4 edge{255, 255, 255, 255};  // barycentric; held at 255 across an edge not to be drawn
};

// Three indices per triangle; without indices the vertices are points.
struct DrawSurface {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> indices;
};

struct SurfaceOptions {
  double crease_angle = 0.7;  // radians; faces meet smoothly where they bend by at most this; negative: nowhere
  bool wireframe = false;     // fill in DrawVertex::edge, at the price of three vertices per triangle
};

// Normals are weighted by the corners' angles. Faces without area, or with a corner that is not finite, are left out,
// and so are points that are not finite. vertex_colors has one colour per vertex, or none (white).
DrawSurface make_surface(const Mesh& mesh, const std::vector<Bytes4>& vertex_colors, const Placement& placement,
                         const SurfaceOptions& options);

// The colour of every vertex of a shape by vertex_colors, the mesh's attribute or shape.color, in this order.
std::vector<Bytes4> colors_of(const Shape& shape);

Bytes4 to_bytes(const Color& color);

}  // namespace knead::render
