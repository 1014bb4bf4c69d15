// The steps of a picture, each a full drawing into textures of width * height samples.
#pragma once

#include <vector>

#include "knead/gl/objects.h"
#include "knead/render/dome.h"
#include "knead/render/occluder.h"
#include "knead/render/renderer.h"

namespace knead::render {

inline constexpr int kShadowMapSize = 1024;

struct Programs {
  gl::Program clay;
  gl::Program cap;
  gl::Program disc;
  gl::Program shadow;
  gl::Program lighting;
  gl::Program backdrop;
  gl::Program rod;
  gl::Program glass;
  gl::Program copy;
  gl::Program resolve;
  gl::VertexArray nothing;  // for triangles made by the vertex program
  gl::Sampler plain_depth;  // reads shadow maps as they are

  Programs();
};

// A surface on the GPU.
struct SurfaceBuffers {
  gl::VertexArray layout;
  gl::Buffer vertices;
  gl::Buffer indices;
  GLsizei count = 0;
  bool points = false;
  double point_radius = 0;  // renderer units
  Color color;              // glass: tint; shapes: the colour of the back
};

SurfaceBuffers upload(const DrawSurface& surface);

struct OccluderBuffers {
  SurfaceBuffers triangles;
  SurfaceBuffers points;
  Vec3d center;
  double radius = 0;
  double ground = 0;
};

OccluderBuffers upload(const Occluder& occluder, double point_radius);

// What the passes have in common.
struct Pass {
  const Programs& programs;
  const View& view;
  const Options& options;
  int width = 0;  // in samples
  int height = 0;
  std::array<float, 4> clip{0, 0, 0, 1};  // dot(xyz, p) > w is taken away, in renderer units
  bool clipped = false;
  Color cut{};
};

struct GBuffer {
  gl::Texture depth;
  gl::Texture reflectance;
  gl::Texture normal;
};

GBuffer draw_shapes(const Pass& pass, const std::vector<SurfaceBuffers>& shapes);

// Radiance of the shapes; in alpha the light that the ground lacks.
gl::Texture draw_light(const Pass& pass, const GBuffer& buffer, const std::vector<Light>& lights,
                       const OccluderBuffers& occluder);

// Linear colour times alpha, of the lit shapes on the background.
gl::Texture draw_backdrop(const Pass& pass, const GBuffer& buffer, const gl::Texture& light,
                          const OccluderBuffers& occluder, double ground_light);

// Adds the rods to the colour, depth and normals.
void draw_rods(const Pass& pass, const GBuffer& buffer, const gl::Texture& color, const SurfaceBuffers& rods);

// All translucent surfaces in front of everything solid, one over the other.
gl::Texture draw_glass(const Pass& pass, const GBuffer& buffer, const std::vector<SurfaceBuffers>& surfaces);

Image resolve(const Pass& pass, const gl::Texture& base, const gl::Texture& over);

}  // namespace knead::render
