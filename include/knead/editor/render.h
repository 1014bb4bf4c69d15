// Pictures of shapes: cameras, images and their files, scenes, the offline renderer, the surfaces of tools, and the
// interactive view.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/field.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::render {

// The projection of a camera.
enum class Projection { orthographic, perspective };

// Looks from eye to target. The picture shows `height` units from bottom to top in the plane through the target, in
// both projections, so that both show it at the same scale. Valid: eye != target, height > 0, up not zero. If `up` is
// parallel to the view, an orthogonal direction replaces it. `up` is also the normal of the ground. The shift moves the
// lens: the target is seen off the middle of the picture, and what is level stays level.
struct Camera {
  Projection projection = Projection::perspective;
  Vec3d eye{0, 0, 5};
  Vec3d target{0, 0, 0};
  Vec3d up{0, 1, 0};
  double height = 2;
  double shift_x = 0;  // where the target is seen, from -1, the left side, to 1
  double shift_y = 0;  // from -1, the bottom, to 1

  friend bool operator==(const Camera&, const Camera&) = default;
};

// The unit vectors of the picture: right, up, and forward (from the eye into the scene).
struct CameraFrame {
  Vec3d right;
  Vec3d up;
  Vec3d forward;
};

// Returns the unit vectors of a valid camera.
CameraFrame camera_frame(const Camera& camera);

// Projection and margin of fit_camera().
struct FitOptions {
  Projection projection = Projection::perspective;
  double field_of_view_deg = 25;  // vertical; perspective only
  double margin = 0.06;           // of the picture's height or width, whichever is tighter, on each side
};

// The direction of a camera, and the direction that is up in its picture.
struct ViewDirection {
  Vec3d direction;
  Vec3d up;
};

// Returns the direction of a camera at an azimuth, degrees from the front towards +x, and an elevation, degrees from
// -90 to 90. These are the numbers of `knead render --view`. is_z_up: z is up instead of y, and the front looks along
// +y.
inline ViewDirection view_direction(double azimuth_deg, double elevation_deg, bool is_z_up) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180;
  const double elevation = elevation_deg * std::numbers::pi / 180;
  ViewDirection view{
      -Vec3d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation)},
      {0, 1, 0}};
  if (std::abs(elevation_deg) > 89.9) view.up = {0, 0, elevation_deg > 0 ? -1.0 : 1.0};
  if (!is_z_up) return view;
  for (Vec3d* v : {&view.direction, &view.up}) *v = {v->x, -v->z, v->y};
  return view;
}

// Returns the rotation about the axis that is up by `step` of `count` parts of a full turn: that of picture `step` of
// a turntable.
inline Mat3d turntable_turn(int step, int count, bool is_z_up) {
  const double c = std::cos(2 * std::numbers::pi * step / count);
  const double s = std::sin(2 * std::numbers::pi * step / count);
  return is_z_up ? Mat3d{{c, s, 0}, {-s, c, 0}, {0, 0, 1}} : Mat3d{{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
}

// Returns places that the outermost points of a shape have in the pictures of a turntable, turned about `middle`. A
// camera that shows them shows the whole shape from all around.
std::vector<Vec3d> turntable_points(std::span<const Vec3d> positions, const Vec3d& middle, int count, bool is_z_up);

// Returns points of a shape that are the farthest in many directions.
std::vector<Vec3d> outermost_points(std::span<const Vec3d> positions);

// Returns the camera that looks along `direction` (not zero) and shows all points, which are finite, as large as
// possible in a picture of width / height = aspect: they reach the margins on two sides at least. Without points, as
// for an empty box.
Camera fit_points(std::span<const Vec3d> points, const Vec3d& direction, const Vec3d& up, double aspect,
                  const FitOptions& options = {});

// Returns the camera that looks along `direction` (not zero) at the centre of the box and shows the whole box in a
// picture of width / height = aspect. An empty box counts as the unit cube about the origin.
Camera fit_camera(const Box& box, const Vec3d& direction, const Vec3d& up, double aspect,
                  const FitOptions& options = {});

// A picture in memory. Rows from the top down, pixels from the left, four bytes per pixel: red, green, blue (sRGB, not
// multiplied by alpha) and alpha. pixels.size() == 4 * width * height.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  friend bool operator==(const Image&, const Image&) = default;
};

// Returns the bytes of a PNG file (8 bits, RGBA). Throws InvalidInput for an empty image.
std::string encode_png(const Image& image);

// Returns the bytes of a JPEG file: small, but lossy and without alpha. quality: from 1 to 100. Throws
// InvalidInput for an empty image or a quality outside its range.
std::string encode_jpeg(const Image& image, int quality = 88);

// Returns the picture in the bytes of a PNG or JPEG file. Throws InvalidInput for other bytes, and for more than 8192
// pixels along a side.
Image decode_image(const std::string& bytes);

// Returns the images in a row from left to right, centred vertically. The rest is transparent if any image has a
// transparent corner, else white. Throws InvalidInput if there are no images.
Image side_by_side(std::span<const Image> images);

// Return the parts of an animated GIF: a header, the pictures, the end. It is played in a loop. Source: CompuServe,
// "Graphics Interchange Format, Version 89a" (1990), with the looping extension of Netscape.
std::string gif_header(int width, int height);

// Returns a picture that is shown for so many hundredths of a second. Only what differs from the picture before it is
// stored; null: there is none. Of more than 255 colours it keeps 255 by median cut. Transparent pixels become white.
// Throws InvalidInput for a picture of another size than `before`, or of more than 65535 pixels along a side.
std::string gif_picture(const Image& image, const Image* before, int hundredths);

// Returns the end of the file.
std::string gif_end();

// sRGB, each from 0 to 1; alpha 1 is opaque.
struct Color {
  float red = 1;
  float green = 1;
  float blue = 1;
  float alpha = 1;

  friend bool operator==(const Color&, const Color&) = default;
};

// A material as the picture of a ball of it: each point has the colour that the ball has where its normal is the same.
// Colours of a shape tint it.
enum class Matcap { terracotta, red_wax, porcelain, chrome, jade, skin, dark_metal, normals };
inline constexpr std::size_t kMatcapCount = 8;

// Returns all matcaps, in the order of the enum.
std::span<const Matcap> all_matcaps();

// Return the name in options and files ("red-wax"), and the name that a person reads ("Red wax").
std::string_view name_of(Matcap matcap);
std::string_view title_of(Matcap matcap);

// Returns the matcap with this name_of(), if there is one.
std::optional<Matcap> matcap_named(std::string_view name);

// The colours behind a scene, from the top of the picture to its bottom.
struct Background {
  Color top;
  Color bottom;

  friend bool operator==(const Background&, const Background&) = default;
};

// Returns the background with this name: "gradient", "light", "dark", or a colour "#rrggbb". Nothing for another text.
std::optional<Background> background_named(std::string_view name);

// Returns the colour "#rrggbb", in upper or lower case; nothing for another text. Returns it as such a text.
std::optional<Color> color_from(std::string_view text);
std::string text_of(const Color& color);

// Shading that brings out the form, computed from what is around a point in the picture.
struct Relief {
  bool cavity = false;     // darkens grooves and brightens ridges
  bool occlusion = false;  // darkens folds and corners

  friend bool operator==(const Relief&, const Relief&) = default;
};

inline constexpr Color kClay{0.80f, 0.755f, 0.70f, 1};
inline constexpr Color kInnerRed{0.88f, 0.08f, 0.06f, 0.36f};
inline constexpr Color kOuterGreen{0.10f, 0.62f, 0.20f, 0.16f};

// An opaque surface, or a point cloud if the mesh has no faces. The mesh is not owned and must outlive the call of
// `render`. Vertices and faces that are not finite are left out. The inside (the back of the faces) has its own colour,
// which makes open shapes easy to recognise.
struct Shape {
  const Mesh* mesh = nullptr;
  Color color = kClay;
  Color back_color{0.50f, 0.56f, 0.64f, 1};
  bool use_mesh_colors = false;      // the vertex attribute "color", if the mesh has one, instead of color
  std::vector<Color> vertex_colors;  // one per vertex, or empty; overrides use_mesh_colors
};

// A glassy shell, e.g. the surface r = inner of a tool. alpha is its opacity seen from the front; its rim is denser.
// The line where it meets a shape has the same colour.
struct TranslucentSurface {
  Mesh mesh;
  Color color = kInnerRed;

  // Compares everything that is drawn, without the mesh's attributes.
  friend bool operator==(const TranslucentSurface& a, const TranslucentSurface& b) {
    return a.mesh.positions == b.mesh.positions && a.mesh.corner_vertex == b.mesh.corner_vertex &&
           a.mesh.face_begin == b.mesh.face_begin && a.color == b.color;
  }
};

// A solid arrow; its length includes the head. It shines faintly through shapes that hide it. Nothing is drawn if its
// length or radius is zero.
struct Arrow {
  Vec3d from;
  Vec3d to;
  double radius = 0.01;  // of the shaft; the head is 2.4 times as wide
  Color color{0.20f, 0.25f, 0.85f, 1};

  friend bool operator==(const Arrow&, const Arrow&) = default;
};

// A round rod along a polyline (an axis, a path, a ring). It shines through shapes like an arrow.
struct Line {
  std::vector<Vec3d> points;
  double radius = 0.005;
  bool closed = false;
  Color color{0.15f, 0.15f, 0.20f, 1};
  bool round = true;  // with balls at its points

  friend bool operator==(const Line&, const Line&) = default;
};

// Removes the side dot(normal, x) > offset. The cut through a closed shape is a plane with its own colour.
struct Clip {
  Vec3d normal{1, 0, 0};
  double offset = 0;
  Color color{0.86f, 0.42f, 0.30f, 1};

  friend bool operator==(const Clip&, const Clip&) = default;
};

// The contents of a picture.
struct Scene {
  std::vector<Shape> shapes;
  std::vector<TranslucentSurface> surfaces;
  std::vector<Arrow> arrows;
  std::vector<Line> lines;
  std::optional<Clip> clip;  // shapes only
  Camera camera;
};

// Returns the points of a circle, for a closed Line. axis need not be a unit vector but is not zero.
std::vector<Vec3d> ring(const Vec3d& center, const Vec3d& axis, double radius, int points = 96);

// Returns all points of the scene that are finite, in scene coordinates.
std::vector<Vec3d> scene_points(const Scene& scene);

// Return the bounding box of the shapes, and of everything in the scene, in scene coordinates.
Box shapes_box(const Scene& scene);
Box scene_box(const Scene& scene);

struct Programs;  // the compiled shaders (passes.h)

enum class Shading { smooth, flat };

// Size and appearance of the picture.
struct Options {
  int width = 1600;
  int height = 1200;
  Color background{1, 1, 1, 1};            // alpha 0: a transparent picture
  std::optional<Color> background_bottom;  // if it is a gradient, from `background` at the top
  std::optional<Matcap> matcap;            // the shapes' material; std::nullopt: clay under the studio's light
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

// Returns a picture of the scene, drawn with OpenGL in a new context without a window: clay under a studio's soft
// light, with glassy tool surfaces. Light comes from many directions, each with its own shadow map, which gives ambient
// occlusion in folds and a soft shadow on the ground. Translucent surfaces are sorted per pixel by depth peeling
// (Everitt, "Interactive order-independent transparency", 2001). One driver always returns the same bits. Throws
// InvalidInput for options or a camera outside their ranges, and GpuError if there is no OpenGL 3.3. Cost: draws the
// shapes light_samples times, and looks up width * height * light_samples texels.
Image render(const Scene& scene, const Options& options);

// Returns a picture of Gaussian splats (splats.h) as they are drawn by Kerbl et al. (2023): sorted by depth, and
// blended from front to back, each with the colour that its spherical harmonics have in the direction from the eye to
// its centre. Drawn by the CPU; the same bits for every number of threads. Uses width, height, background and progress
// of the options. Throws InvalidInput as splat_degree().
Image render_splats(const Mesh& splats, const Camera& camera, const Options& options);

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

// The resolution of the surfaces r = level of a field's region.
struct SurfaceDetail {
  int cells = 64;            // of the grid for a point set's surface, along its longest side
  int relaxations = 8;       // of that surface (mesh/polygonise.h)
  int sides = 64;            // of round surfaces; small ones have half as many
  double straightening = 0;  // curves may deviate by this fraction of the level, to have fewer points

  friend bool operator==(const SurfaceDetail&, const SurfaceDetail&) = default;
};

// For pictures during a drag: some tens of milliseconds for a curve of 200 points, a few for other regions.
inline constexpr SurfaceDetail kLiveDetail{.cells = 24, .relaxations = 1, .sides = 32, .straightening = 0.05};

// Returns the surface {r = level} at t = 0 with the field's centre at `center`.
//   plane          cut to about the box, or to the limit cylinder if there is one
//   ball, capsule, point set with level <= 0: a small ball at each centre or point, scaled by the outer threshold
//   handles        whose levels 0 and 1 are the sets themselves: some of their points, and the surface r = 1/4 or 3/4
//   function of the caller: empty
Mesh region_surface(const Field& field, const Vec3d& center, double level, const Box& around,
                    const std::optional<LimitCylinder>& limit_cylinder, const SurfaceDetail& detail = {});

// Returns the limit cylinder from the far end of the box to the field's outer plane. The field's region is a
// half-space.
Mesh limit_cylinder_surface(const LimitCylinder& limit_cylinder, const Field& field, const Box& around,
                            const SurfaceDetail& detail = {});

// A cache of the few surfaces of point sets that were used last. A tool that is dragged only translates its point sets,
// so their surfaces, which are slow to compute, can be translated, too.
class SurfaceCache {
 public:
  // Returns region_surface of a field whose region is a point set, about the field's own centre; level > 0. If the
  // cache has the surface of a translated set (equal to 10^-6 of the level), translates that surface instead.
  Mesh surface(const Field& field, double level, const SurfaceDetail& detail);

  // Returns the number of computed surfaces.
  std::size_t made() const { return made_; }

 private:
  struct Entry {
    PointSet<double> set;
    Vec3d center;
    double level = 0;
    SurfaceDetail detail;
    Mesh mesh;
  };
  std::vector<Entry> entries_;  // the one used last at the end
  std::size_t made_ = 0;
};

// The shape that a stamp presses in, in its pose before it moves, and the path of its origin.
struct StampTool {
  Mesh mesh;
  std::vector<Vec3d> path;
};

// The tool of a stroke along its whole path, or at one moment, which counts in segments of the stroke.
struct DrawnTool {
  Flow stroke;
  std::optional<StampTool> stamp;
  std::optional<double> moment;
};

// The resolution of a tool's picture.
struct ToolDrawing {
  SurfaceDetail detail{};
  SurfaceCache* cache = nullptr;  // keeps surfaces from one picture to the next, if not null
};

// Adds the tool of one stroke to the scene as in the paper: the surface r = inner red, r = outer green, with arrows
// that show the inner motion.
//   without a moment  the tool at its start and, if it moves, its path and, fainter, the tool at its end
//   at a moment       the tool where it is then, and its path
// A grid is drawn as the box of its nodes in use; a stamp as its shape, at a moment also with the
// regions of its contacts. `around` is the bounding box of the deformed shape.
void draw_tool(const DrawnTool& tool, const Box& around, Scene& scene, const ToolDrawing& how = {});

// The shading of the interactive view.
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

  friend bool operator==(const PlacedImage&, const PlacedImage&) = default;
};
// The colours of stretches, from none to the strongest, evenly spaced; they also differ in lightness.
inline constexpr std::array<Color, 5> kStretchColors{{{0.86f, 0.86f, 0.84f, 1},
                                                      {0.99f, 0.80f, 0.35f, 1},
                                                      {0.93f, 0.44f, 0.20f, 1},
                                                      {0.62f, 0.14f, 0.36f, 1},
                                                      {0.22f, 0.05f, 0.32f, 1}}};

inline constexpr std::size_t kMaxSections = 3;

// The camera, the material and everything that is drawn besides the shape. Colours are those on the screen.
struct LiveScene {
  Camera camera;
  Material material = Material::clay;
  Matcap matcap = Matcap::terracotta;  // of Material::matcap
  Relief relief;                       // of the shape; a point cloud has none
  int samples = 0;                     // per pixel; 0: the number given to the view
  int coarseness = 1;                  // of LiveView::draw: a picture of 1/coarseness the size, enlarged; at least 1.
                                       // Above 1, or with `samples` 1, it draws 100,000 splats at most, larger ones;
                                       // a driver on the CPU always does that if there are more than 300,000
  bool wireframe = false;              // the polygons' edges
  bool show_influence = false;         // as set by set_influence
  bool show_stretch = false;           // the values of set_influence along kStretchColors instead
  std::optional<Clip> clip;            // shape only
  std::vector<Clip> sections;          // planes whose lines on the faces of the shape are drawn; at most kMaxSections
  std::vector<PlacedImage> images;
  std::vector<TranslucentSurface> surfaces;
  std::vector<Arrow> arrows;
  std::vector<Line> lines;
  Color background_top{0.86f, 0.87f, 0.89f, 1};
  Color background_bottom{0.66f, 0.68f, 0.71f, 1};

  friend bool operator==(const LiveScene&, const LiveScene&) = default;
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
  // discs; splats (splats.h) as render_splats() draws them, unless there are more than the driver has textures for. The
  // mesh need not outlive the call. Clears the influence. Throws InvalidInput for splats as splat_degree().
  void set_shape(const Mesh& mesh);

  // Changes covariances and colours of splats, from those of set_shape(), by the Jacobians of a deformation (null:
  // none), whose splats are numbers of vertices. Their centres stay where `move` puts them. Returns whether anything
  // may have changed: not for the same object again, nor for other shapes.
  bool set_splats(const std::shared_ptr<const SplatJacobians>& jacobians);

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

  // Draws the scene as a picture of width * height pixels whose lower left corner is at (left, bottom) in the
  // framebuffer; does nothing if one is not positive. Throws InvalidInput for a camera or a clipping plane without
  // direction, a coarseness below 1, or a picture too large for the driver. Returns false if nothing has changed since
  // the last picture, so that it was shown again.
  bool draw(const LiveScene& scene, int width, int height, int left = 0, int bottom = 0);

  // Returns what `draw` would draw as a picture in memory. Throws as draw, and InvalidInput if width or height is not
  // positive.
  Image picture(const LiveScene& scene, int width, int height);

  // Returns what the last call of move() sent to the GPU.
  UploadCounts counts() const;

  // Returns true while a thread sorts splats for a new view or shape: `draw` then uses the last order, and should be
  // called again. `picture` waits.
  bool is_sorting() const;

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
