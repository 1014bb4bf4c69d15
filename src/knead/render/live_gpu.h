// What the live view keeps on the GPU.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "knead/gl/objects.h"
#include "knead/render/live_mesh.h"
#include "knead/render/live_view.h"
#include "knead/render/surface.h"

namespace knead::render {

struct LivePrograms {
  std::array<gl::Program, 3> shape;  // by Material
  gl::Program cloud;
  gl::Program wire;
  gl::Program depth;
  gl::Program cut;
  gl::Program background;
  gl::Program image;
  gl::Program rod;
  gl::Program glass;
  gl::Program present;
  gl::VertexArray nothing;   // for vertices made by the vertex program
  bool in_software = false;  // the driver has no GPU

  LivePrograms();
};

// The buffers of a LiveMesh, or of rods, which have no edges.
struct LiveBuffers {
  gl::VertexArray layout;
  gl::Buffer vertices;
  gl::Buffer colors;  // red, green, blue, influence
  gl::Buffer triangles;
  gl::Buffer edges;
  GLsizei vertex_count = 0;
  GLsizei triangle_indices = 0;
  GLsizei edge_indices = 0;
};

// colors: one per drawn vertex, or none.
LiveBuffers make_live_buffers(const LiveMesh& mesh, std::span<const Bytes4> colors);
LiveBuffers make_live_buffers(const DrawSurface& surface);

// Sends the ranges of drawn vertices.
UploadCounts update(const LiveBuffers& buffers, const LiveMesh& mesh, std::span<const VertexRange> drawn);
void update_colors(const LiveBuffers& buffers, std::span<const Bytes4> colors, const VertexRange& drawn);

void draw_triangles(const LiveBuffers& buffers);
void draw_edges(const LiveBuffers& buffers);
void draw_points(const LiveBuffers& buffers);

// What a picture's targets must fit.
struct LiveTargetSize {
  int width = 0;
  int height = 0;
  int samples = 0;      // the driver may give others
  bool relief = false;  // with what LiveScene::relief needs

  friend bool operator==(const LiveTargetSize&, const LiveTargetSize&) = default;
};

// For the relief: normals of the shape, and the light that gets through, of every second sample each way.
struct LiveReliefTargets {
  gl::Renderbuffer normal_of_many;  // the second colour of LiveTargets::many
  gl::Texture normal;
  gl::Framebuffer gathered;
  std::array<gl::Texture, 2> occlusion;
  std::array<gl::Framebuffer, 2> occlusion_target;
};

// Where the picture is made: several samples per pixel, and the same after they are put together.
struct LiveTargets {
  LiveTargetSize size;
  gl::Renderbuffer color;
  gl::Renderbuffer depth;  // and stencil
  gl::Framebuffer many;
  gl::Texture one_color;
  gl::Texture one_depth;
  gl::Framebuffer one;
  LiveReliefTargets relief;  // if size.relief
};

// Throws InvalidInput where the driver has no memory for them, or no pictures of this size.
LiveTargets make_live_targets(const LiveTargetSize& size);

// Puts the samples of each pixel together: of the colour, the depth or both. Leaves `many` bound.
void gather(const LiveTargets& targets, GLbitfield what);

// The same for the normals.
void gather_normals(const LiveTargets& targets);

// Returns the image for PlacedImage, with mipmaps.
gl::Texture make_image_texture(const Image& image);

// Returns the picture of a ball of the material for Material::matcap.
gl::Texture make_matcap_texture(Matcap matcap);

}  // namespace knead::render
