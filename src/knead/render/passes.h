// The steps of a picture, each a full drawing into textures of width * height samples.
#pragma once

#include <map>
#include <vector>

#include "knead/gl/objects.h"
#include "knead/render/dome.h"
#include "knead/render/occluder.h"
#include "knead/render/renderer.h"
#include "knead/render/shaders.h"

namespace knead::render {

inline constexpr int kShadowMapSize = 512;

struct Programs {
  gl::Program clay;
  gl::Program cap;
  gl::Program disc;
  std::map<ShapeLook, gl::Program> shape_light;  // those that were needed
  gl::Program ground_light;
  gl::Program even;
  gl::Program uneven;
  gl::Program sees_ground;
  gl::Program ground;
  gl::Program backdrop;
  gl::Program rod;
  gl::Program glass;
  gl::Program copy;
  gl::Program resolve;
  gl::VertexArray nothing;  // for triangles made by the vertex program

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

// What the passes have in common.
struct Pass {
  Programs& programs;
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

// What lights the scene, and what keeps the light off.
struct Lighting {
  std::vector<Light> lights;  // those that light the ground first
  Occluder occluder;
  double point_radius = 0;  // renderer units
  double ground_light = 0;  // what the ground gets without shadow

  bool has_shadows(const Options& options) const { return options.ambient_occlusion && occluder.radius > 0; }
  bool has_ground(const Options& options) const { return has_shadows(options) && options.ground; }
};

// Returns true if the light casts shadows on the ground, whose normal is `up`.
bool lights_ground(const Light& light, const Vec3d& up);

// Radiance of the shapes, for pixels where that suffices and for samples elsewhere; and how dark the ground is.
struct LightMaps {
  gl::Texture pixels;
  gl::Texture samples;
  gl::Texture darkness;
};

LightMaps draw_light(const Pass& pass, const GBuffer& buffer, const Lighting& lighting);

// Linear colour times alpha, of the lit shapes on the background.
gl::Texture draw_backdrop(const Pass& pass, const GBuffer& buffer, const LightMaps& light, const Lighting& lighting);

// Adds the rods to the colour, depth and normals.
void draw_rods(const Pass& pass, const GBuffer& buffer, const gl::Texture& color, const SurfaceBuffers& rods);

// Adds all translucent surfaces in front of everything solid, one over the other.
void draw_glass(const Pass& pass, const GBuffer& buffer, const gl::Texture& color,
                const std::vector<SurfaceBuffers>& surfaces);

Image resolve(const Pass& pass, const gl::Texture& color);

// Tells how much of the picture is done, after the GPU has done it.
void report(const Pass& pass, double part);

}  // namespace knead::render
