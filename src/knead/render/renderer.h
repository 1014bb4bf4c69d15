// Draws a scene with OpenGL: clay under a studio's soft light, with glassy tool surfaces.
//
// Light comes from 64 directions, each with its own shadow map: this gives ambient occlusion in folds and
// a soft shadow on the ground without screen-space approximations. Translucent surfaces are sorted per pixel by depth
// peeling (Everitt, "Interactive order-independent transparency", 2001).
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "knead/render/image.h"
#include "knead/render/scene.h"

namespace knead::render {

struct Programs;  // the compiled shaders (passes.h)

enum class Shading { smooth, flat };

// Size and appearance of the picture.
struct Options {
  int width = 1600;
  int height = 1200;
  Color background{1, 1, 1, 1};            // alpha 0: a transparent picture
  std::optional<Color> background_bottom;  // if it is a gradient, from `background` at the top
  std::optional<Matcap> matcap;            // the shapes' material; nothing: clay under the studio's light
  Relief relief;
  Shading shading = Shading::smooth;
  double crease_angle_deg = 40;          // smooth shading stops at edges that bend more than this
  bool wireframe = false;                // the polygons' edges, as thin dark lines
  bool ambient_occlusion = true;         // off: no shadows at all, and much faster
  bool ground = true;                    // the soft shadow on a ground plane under the shapes
  int light_samples = 64;                // directions of light; valid: 16 to 1024
  int supersampling = 2;                 // samples per pixel along each side; valid: 1 to 4
  std::function<void(double)> progress;  // called with the part that is done, from 0 to 1; empty: is not
  double point_radius = 0;  // of a point cloud's discs, in scene units; 0: from the cloud's size and number of points
};

// Returns a picture of the scene, drawn in a new context without a window. One driver always returns the same bits.
// Throws InvalidInput for options or a camera outside their ranges, and GpuError if there is no OpenGL 3.3. Cost: draws
// the shapes light_samples times, and looks up width * height * light_samples texels.
Image render(const Scene& scene, const Options& options);

// Renders many pictures in the OpenGL context that is current; keeps its compiled shaders. A call leaves OpenGL's
// default framebuffer bound and other OpenGL state unspecified.
class Renderer {
 public:
  Renderer();  // throws GpuError if the current context is below OpenGL 3.3
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // Returns a picture of the scene, as render() does.
  Image render(const Scene& scene, const Options& options);

 private:
  std::unique_ptr<Programs> programs_;
};

}  // namespace knead::render
