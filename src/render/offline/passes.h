// The parts of the offline renderer: shaders, occluders and shadow maps, lights, and the passes of a picture. Internal
// to render.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gl/objects.h"
#include "knead/editor/render.h"
#include "render/surface.h"

namespace knead::render {

// Light whose direction makes a smaller cosine with the ground's normal casts no shadow on the ground.
inline constexpr float kGrazingCosine = 0.15F;

// The sizes of relief (kRelief in surface.h).
inline constexpr double kFinestCavity = 0.0016;  // of the picture's height: the step of cavities
inline constexpr double kOcclusionReach = 0.16;  // of the scene's radius, within which surfaces darken each other

struct ShaderSource {
  std::string vertex;
  std::string fragment;
};

// Compiles and links. Throws GpuError with the first line of the driver's log.
inline gl::Program compile(const ShaderSource& source) { return gl::make_program(source.vertex, source.fragment); }

// A program that runs `fragment` once for every texel, with the declarations of `kView` before it.
ShaderSource full_screen_program(const std::string& fragment);

ShaderSource clay_source();   // triangles -> reflectance, normal
ShaderSource wired_source();  // and their edges
ShaderSource cap_source();    // what a clipping plane has cut open, closed
ShaderSource disc_source();   // points -> reflectance, normal
ShaderSource rod_source();    // solid things that are lit without shadows
ShaderSource glass_source();  // one layer of translucent surfaces
ShaderSource copy_source();   // a layer under those before it

// The shapes that cast shadows, in a coarser copy if they are finer than a shadow map.
struct Occluder {
  std::vector<Vec3f> positions;
  std::vector<std::uint32_t> indices;  // three per triangle
  std::vector<Vec3f> points;           // of point clouds
  bool is_solid = false;               // the triangles are closed and turned outwards
  Vec3d center;                        // of a ball that holds everything
  double radius = 0;                   // 0: nothing casts a shadow
  double ground = 0;                   // the lowest dot(up, p)
};

// Merges the vertices in each cell of this size if there are more than max_triangles triangles (Rossignac and Borrel,
// "Multi-resolution 3D approximations for rendering complex scenes", 1993). Deterministic.
Occluder make_occluder(const std::vector<DrawSurface>& surfaces, const Vec3d& up, double cell,
                       std::size_t max_triangles, double point_radius);

// Removes everything beyond the plane: dot(plane xyz, p) > plane w. Cuts triangles across it.
void clip_occluder(Occluder& occluder, const std::array<float, 4>& plane);

// From renderer units to 0..1 in a light's map, by columns (four of three numbers); the third is the depth, 0 nearest
// to the light.
using LightMatrix = std::array<float, 12>;

// Fills one shadow map of size * size depths for each light, by rows: from 0 to 65535, which also means nothing. On the
// CPU: triangles are about as small as a texel, and a software driver takes twenty times as long. Triangles are pushed
// back by one and a half times their slope over a texel. Points are squares with this half side.
void draw_shadow_maps(const Occluder& occluder, std::span<const LightMatrix> lights, int size, double point_radius,
                      std::span<std::uint16_t> maps);

// Light arriving from a direction. The irradiance of all lights on a plane facing up, with nothing in between, is
// about 1.
struct Light {
  Vec3f direction;  // unit, towards the light
  Vec3f radiance;   // linear red, green, blue; the share of this light included
};

// Returns `count` lights, at least 2, that sample a studio evenly: a soft sky, a large key light, a fill and a rim.
std::vector<Light> studio_lights(const View& view, int count);

inline constexpr int kShadowMapSize = 512;
inline constexpr int kMaxSupersampling = 4;

struct Programs {
  gl::Program clay;
  gl::Program wired;
  gl::Program cap;
  gl::Program disc;
  gl::Program rod;
  gl::Program glass;
  gl::Program copy;
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

// A part of a picture, in samples.
struct Part {
  int left = 0;
  int bottom = 0;
  int width = 0;
  int height = 0;

  bool contains(int x, int y) const { return x >= left && x < left + width && y >= bottom && y < bottom + height; }
};

// The common data of the passes, each of which draws into textures of width * height samples.
struct Pass {
  Programs& programs;
  const View& view;
  const Options& options;
  int width = 0;  // in samples
  int height = 0;
  Part part;                              // of whole pixels; the textures contain only this part
  std::array<float, 4> clip{0, 0, 0, 1};  // dot(xyz, p) > w is clipped, in renderer units
  bool clipped = false;
  Color cut{};
  double* reported = nullptr;  // the part that was reported last
};

struct GBuffer {
  gl::Texture depth;
  gl::Texture reflectance;
  gl::Texture normal;
};

GBuffer draw_shapes(const Pass& pass, const std::vector<SurfaceBuffers>& shapes);

// The lights and the shapes that block them.
struct Lighting {
  std::vector<Light> lights;
  Occluder occluder;
  double point_radius = 0;  // renderer units

  bool has_shadows(const Options& options) const { return options.ambient_occlusion && occluder.radius > 0; }
  bool has_ground(const Options& options) const { return has_shadows(options) && options.ground; }
};

// Adds the rods to the colour, depth and normals.
void draw_rods(const Pass& pass, const GBuffer& buffer, const gl::Texture& color, const SurfaceBuffers& rods);

// Adds all translucent surfaces in front of everything solid, one over the other.
void draw_glass(const Pass& pass, const GBuffer& buffer, const gl::Texture& color,
                const std::vector<SurfaceBuffers>& surfaces);

// The samples of the part that the GPU has drawn, rows from the bottom up. Numbers from 0 to 1 are stored as 0 to
// 65535.
using Shorts4 = std::array<std::uint16_t, 4>;
struct Samples {
  std::unique_ptr<float[]> depth;         // 1: no shape
  std::unique_ptr<Bytes4[]> reflectance;  // in sRGB
  std::unique_ptr<Shorts4[]> normal;      // from -1 to 1
  std::unique_ptr<Shorts4[]> front;       // colour times alpha of rods and glass; null: there are none
};

// Lights the shapes, draws background and ground shadow behind them, and makes pixels of the samples.
Image shade(const Pass& pass, const Samples& samples, const Lighting& lighting);

// Reports the finished part of the picture, after the GPU has finished it.
void report(const Pass& pass, double part);

void set(const gl::Program& program, const char* name, const Vec3d& v);
void set(const gl::Program& program, const char* name, double x);
void set(const gl::Program& program, const char* name, const Color& c);
void set_with_alpha(const gl::Program& program, const char* name, const Color& c);

// Makes the program current and sets the camera; the last also the clipping plane, if there is one.
void use(const gl::Program& program, const View& view, int width, int height);
void use(const gl::Program& program, const Pass& pass);
void use_clipped(const gl::Program& program, const Pass& pass);

// Sets the light of things that neither cast nor receive shadows.
void set_simple_light(const gl::Program& program, const View& view);
// Sets the uniforms of kRelief without the maps. samples_high: of the picture.
void set_relief(const gl::Program& program, const View& view, int samples_high);

void draw(const SurfaceBuffers& surface);
// Draws some of its points, or of its triangles' corners.
void draw(const SurfaceBuffers& surface, GLsizei first, GLsizei count);
void draw_full_screen(const Pass& pass);

// Turns everything off; the depth test will be GL_LESS.
void reset_state(int width, int height);
void reset_state(const Pass& pass);

gl::Texture make_texture(const Pass& pass, GLenum internal_format);

// Clear the bound framebuffer.
void clear(float red, float green, float blue, float alpha);
void clear_depth();

}  // namespace knead::render
