// The interactive picture of one shape while it deforms, in a window's framebuffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "knead/math/box.h"
#include "knead/mesh/mesh.h"
#include "knead/render/camera.h"
#include "knead/render/image.h"
#include "knead/render/scene.h"

namespace knead::render {

// How the shape is shaded. clay: under a sky and a key light, as `knead render` shows it but without shadows; matcap:
// by what a ball of the material looks like from the front, the same from all sides; flat: clay with every triangle
// plane.
enum class Material { clay, matcap, flat };

// Vertices [begin, end) of a mesh.
struct VertexRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  friend bool operator==(const VertexRange&, const VertexRange&) = default;
};

// An OpenGL buffer with the places of vertices [begin, end) of a mesh, three doubles each.
struct PointBuffer {
  unsigned int buffer = 0;
  VertexRange vertices;
};

// What is seen besides the shape, and from where. Colours are those that appear on the screen.
struct LiveScene {
  Camera camera;
  Material material = Material::clay;
  int samples = 0;              // per pixel; 0: as many as the view was made for
  bool wireframe = false;       // the polygons' edges
  bool show_influence = false;  // as set by set_influence
  std::optional<Clip> clip;     // shape only
  std::vector<TranslucentSurface> surfaces;
  std::vector<Arrow> arrows;
  std::vector<Line> lines;
  Color background_top{0.86f, 0.87f, 0.89f, 1};
  Color background_bottom{0.66f, 0.68f, 0.71f, 1};
};

// What the last call of LiveView::move sent to the GPU.
struct UploadCounts {
  std::size_t bytes = 0;
  std::size_t ranges = 0;
};

// Draws into the framebuffer that is bound when draw is called, in the context that was current when the view was made;
// that context must be current whenever a member is called, and when the view is destroyed. Other OpenGL state is
// unspecified after a call, but scissor, blending, depth and stencil tests and culling are off.
//
// Nothing is drawn of faces without area and of faces and points that are not finite when the shape is set; smooth
// shading stops at edges that then bend by more than 40 degrees. Renderer units are chosen when the shape is set, too.
class LiveView {
 public:
  // samples: per pixel, for smooth edges; the driver may give fewer. 1: none. Throws std::runtime_error where the
  // context is below OpenGL 3.3.
  explicit LiveView(int samples = 4);
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;
  LiveView(LiveView&&) noexcept;
  LiveView& operator=(LiveView&&) noexcept;

  // A new shape, in the colours of its vertex attribute "color" where it has one. Without faces: a cloud of discs. The
  // mesh need not outlive the call. Forgets the influence.
  void set_shape(const Mesh& mesh);

  // Takes over the places of the vertices in `changed` (in any order), and makes the normals anew there and in the one
  // ring around. positions: of all vertices of the mesh. threads: 0 for all. Throws InvalidInput for another number of
  // positions or a range beyond it.
  void move(std::span<const Vec3d> positions, std::span<const VertexRange> changed, int threads = 0);

  // Takes over the places of all vertices from buffers of the view's context, which together have each of them; places
  // and normals are then made on the GPU, and nothing is read back. box: of the shape as it then is, or
  // larger. Throws InvalidInput where the buffers have not all vertices, and std::runtime_error, one line, where the
  // driver has no OpenGL 4.3 or no room for a shape of this size; then nothing has changed. The next call of the other
  // kind takes all vertices over, whatever it is told of changes.
  void move_on_gpu(std::span<const PointBuffer> points, const Box& box);

  // One value per vertex: 0 outside of the region of influence, 1 within its inner part; shown, where the scene asks
  // for it, in green and red. Empty: none. Throws InvalidInput for another number of values.
  void set_influence(std::span<const float> per_vertex);

  // width and height: of the framebuffer, in its pixels; nothing happens if one is not positive. Throws InvalidInput
  // for a camera or a clipping plane without direction, or a picture too large for the driver.
  void draw(const LiveScene& scene, int width, int height);

  // The same as a picture in memory; leaves the caller's framebuffers as they are. Throws as draw, and InvalidInput for
  // a width or height that is not positive.
  Image picture(const LiveScene& scene, int width, int height);

  UploadCounts counts() const;

  // Whether the driver draws without a GPU: then one sample per pixel is several times faster than four.
  bool draws_in_software() const;

  // Whether the driver has lost the context, e.g. because the GPU was reset: then nothing is drawn any more,
  // and what it is drawn in has to be made anew. Only contexts that were asked to notice tell.
  bool is_lost() const;

  // The shape as it stands, in scene coordinates (to the digits of a float); empty without a vertex.
  Box box() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace knead::render
