// Draws one shape interactively while it deforms, in a window's framebuffer.
#pragma once

#include <array>
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

// How the shape is shaded.
//   clay    under a sky and a key light, as in `knead render` but without shadows
//   matcap  by the picture of a ball (LiveScene::matcap)
//   flat    each triangle evenly, without gloss, under lamps of different colours that tell its slope
enum class Material { clay, matcap, flat };

// Vertices [begin, end) of a mesh.
struct VertexRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  friend bool operator==(const VertexRange&, const VertexRange&) = default;
};

// An OpenGL buffer with the positions of vertices [begin, end) of a mesh, three doubles each.
struct PointBuffer {
  unsigned int buffer = 0;
  VertexRange vertices;
};

// A picture that stands in the scene, behind the shape and everything else.
struct PlacedImage {
  std::shared_ptr<const Image> image;  // with pixels
  Vec3d center;
  Vec3d right;  // from the centre to the middle of the right side
  Vec3d up;     // and of the upper side
  float opacity = 1;
};
// The colours of stretches, from none to the strongest, evenly spaced: told apart by lightness alone, too.
inline constexpr std::array<Color, 5> kStretchColors{{{0.86f, 0.86f, 0.84f, 1},
                                                      {0.99f, 0.80f, 0.35f, 1},
                                                      {0.93f, 0.44f, 0.20f, 1},
                                                      {0.62f, 0.14f, 0.36f, 1},
                                                      {0.22f, 0.05f, 0.32f, 1}}};

// The camera, the material and everything that is drawn besides the shape. Colours are those on the screen.
struct LiveScene {
  Camera camera;
  Material material = Material::clay;
  Matcap matcap = Matcap::terracotta;  // of Material::matcap
  Relief relief;                       // of the shape; a point cloud has none
  int samples = 0;                     // per pixel; 0: the number given to the view
  bool wireframe = false;              // the polygons' edges
  bool show_influence = false;         // as set by set_influence
  bool show_stretch = false;           // the values of set_influence along kStretchColors instead
  std::optional<Clip> clip;            // shape only
  std::vector<PlacedImage> images;
  std::vector<TranslucentSurface> surfaces;
  std::vector<Arrow> arrows;
  std::vector<Line> lines;
  Color background_top{0.86f, 0.87f, 0.89f, 1};
  Color background_bottom{0.66f, 0.68f, 0.71f, 1};
};

// The data that the last call of LiveView::move sent to the GPU.
struct UploadCounts {
  std::size_t bytes = 0;
  std::size_t ranges = 0;
};

// Returns a picture of a ball of the material with a transparent background, size * size pixels. Throws InvalidInput if
// size < 2.
Image matcap_ball(Matcap matcap, int size);

// Draws one shape and its tools into the framebuffer that is bound when `draw` is called.
//
// The OpenGL context that is current when the view is made must be current at every call, and when the view is
// destroyed. A call leaves scissor, blending, depth and stencil tests and culling off, and other OpenGL state
// unspecified.
//
// When the shape is set, faces without area, and faces and points that are not finite, are left out for good. Smooth
// shading stops at edges that bend by more than 40 degrees at that time.
class LiveView {
 public:
  // samples: per pixel, for smooth edges; the driver may give fewer. 1: no smoothing. Throws GpuError if the context is
  // below OpenGL 3.3.
  explicit LiveView(int samples = 4);
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;
  LiveView(LiveView&&) noexcept;
  LiveView& operator=(LiveView&&) noexcept;

  // Sets the shape, in the colours of its vertex attribute "color" if it has one. A mesh without faces is drawn as
  // discs. The mesh need not outlive the call. Clears the influence.
  void set_shape(const Mesh& mesh);

  // Moves the vertices in the ranges `changed` (in any order), and computes the normals there and in the one-ring
  // around. positions: of all vertices of the mesh. threads: 0 for all. Throws InvalidInput if the number of positions
  // differs from the mesh's, or a range lies beyond it.
  void move(std::span<const Vec3d> positions, std::span<const VertexRange> changed, int threads = 0);

  // Moves all vertices to positions that are in buffers of the view's context, computes the normals on the GPU, and
  // reads nothing back. box: contains the moved shape. The next call of `move` sends all vertices, whatever its ranges
  // are. Throws InvalidInput if the buffers do not hold each vertex once, in order, and GpuError if the driver has no
  // OpenGL 4.3 or no memory for a shape of this size; then nothing has changed.
  void move_on_gpu(std::span<const PointBuffer> points, const Box& box);

  // Sets the influence of a tool, which is drawn in green and red if the scene asks for it. One value per vertex: 0 in
  // the outer region, 1 in the inner region; empty: no influence. Throws InvalidInput for another number of values.
  void set_influence(std::span<const float> per_vertex);

  // Sets how much each vertex is masked, which darkens it: from 0, its own colour, to 1. Empty: no vertex. Setting the
  // shape clears it. Throws InvalidInput for another number of values.
  void set_mask(std::span<const float> per_vertex);

  // Draws the scene. width and height: of the framebuffer in pixels; does nothing if one is not positive. Throws
  // InvalidInput for a camera or a clipping plane without direction, or a picture too large for the driver.
  void draw(const LiveScene& scene, int width, int height);

  // Returns what `draw` would draw as a picture in memory. Throws as draw, and InvalidInput if width or height is not
  // positive.
  Image picture(const LiveScene& scene, int width, int height);

  // Returns what the last call of move() sent to the GPU.
  UploadCounts counts() const;

  // Returns true if the driver draws on the CPU: then one sample per pixel is several times faster than four.
  bool draws_in_software() const;

  // Returns true if the driver has lost the context, e.g. because the GPU was reset: then nothing is drawn any more,
  // and the context and the view must be made again. Contexts report this only if they were made to.
  bool is_lost() const;

  // Returns the bounding box of the shape in scene coordinates, to the precision of a float; empty without a vertex.
  Box box() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace knead::render
