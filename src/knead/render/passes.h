// The steps of a picture, each a full drawing into textures of width * height samples.
#pragma once

#include <vector>

#include "knead/render/dome.h"
#include "knead/render/gl_objects.h"
#include "knead/render/occluder.h"
#include "knead/render/renderer.h"

namespace knead::render {

inline constexpr int kShadowMapSize = 1024;

struct Programs {
  Program clay;
  Program cap;
  Program disc;
  Program shadow;
  Program lighting;
  Program backdrop;
  Program rod;
  Program glass;
  Program copy;
  Program resolve;
  VertexArray nothing;  // for triangles made by the vertex program
  Sampler plain_depth;  // reads shadow maps as they are

  Programs();
};

// A surface on the GPU.
struct GpuSurface {
  VertexArray layout;
  Buffer vertices;
  Buffer indices;
  GLsizei count = 0;
  bool points = false;
  double point_radius = 0;  // renderer units
  Color color;              // glass: tint; shapes: the colour of the back
};

GpuSurface upload(const DrawSurface& surface);

struct GpuOccluder {
  GpuSurface triangles;
  GpuSurface points;
  Vec3d center;
  double radius = 0;
  double ground = 0;
};

GpuOccluder upload(const Occluder& occluder, double point_radius);

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
  Texture depth;
  Texture reflectance;
  Texture normal;
};

GBuffer draw_shapes(const Pass& pass, const std::vector<GpuSurface>& shapes);

// Radiance of the shapes; in alpha the light that the ground lacks.
Texture draw_light(const Pass& pass, const GBuffer& buffer, const std::vector<Light>& lights,
                   const GpuOccluder& occluder);

// Linear colour times alpha, of the lit shapes on the background.
Texture draw_backdrop(const Pass& pass, const GBuffer& buffer, const Texture& light, const GpuOccluder& occluder,
                      double ground_light);

// Adds the rods to the colour, depth and normals.
void draw_rods(const Pass& pass, const GBuffer& buffer, const Texture& color, const GpuSurface& rods);

// All translucent surfaces in front of everything solid, one over the other.
Texture draw_glass(const Pass& pass, const GBuffer& buffer, const std::vector<GpuSurface>& surfaces);

Image resolve(const Pass& pass, const Texture& base, const Texture& over);

}  // namespace knead::render
