// The steps of the interactive picture, each drawing into the bound framebuffer over what is there.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "knead/render/live_gpu.h"
#include "knead/render/view.h"

namespace knead::render {

// In renderer units: dot(normal, p) > offset is taken away.
struct LiveCut {
  Vec3d normal;  // unit
  double offset = 0;
  Color color;
};

struct LiveFrame {
  const LivePrograms& programs;
  const View& view;
  const LiveScene& scene;
  BoundingBall bounds;  // of the shape
  int width = 0;
  int height = 0;
  std::optional<LiveCut> cut;
  const gl::Texture* matcap = nullptr;  // of Material::matcap
  bool has_normals = false;             // the shape's normals are drawn too, for its relief
};

// The plane of the scene's clip, if there is one. Throws InvalidInput for a plane without direction.
std::optional<LiveCut> live_cut(const LiveScene& scene, const Placement& placement);

struct LiveShape {
  const LiveMesh& mesh;
  const LiveBuffers& buffers;
  Box box;  // renderer units
};

// Clears the targets and gets the state ready.
void begin_live_picture(const LiveFrame& frame, const LiveTargets& targets);

// The shape, its edges, and the flat face of the cut.
void draw_live_shape(const LiveFrame& frame, const LiveShape& shape);

// Where nothing is yet.
void draw_live_background(const LiveFrame& frame);

struct LiveImage {
  const gl::Texture& texture;
  const PlacedImage& placed;
};

// Over the background, each over those before it.
void draw_live_images(const LiveFrame& frame, std::span<const LiveImage> images);

// Faintly where they are hidden.
void draw_live_rods(const LiveFrame& frame, const LiveBuffers& rods);

struct LiveGlass {
  const LiveBuffers& buffers;
  Color color;
  double near = 0;  // extent along the view
  double far = 0;
};

// Backs and fronts from far to near. depths: of what is solid.
void draw_live_glass(const LiveFrame& frame, std::span<const LiveGlass> surfaces, const gl::Texture& depths);

// Leaves the depth test and blending off.
void present_live(const LivePrograms& programs, const LiveTargets& targets);

}  // namespace knead::render
