// The contents of a picture as plain values. Nothing here needs OpenGL.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knead/math/box.h"
#include "knead/math/vec3.h"
#include "knead/mesh/mesh.h"
#include "knead/render/camera.h"

namespace knead::render {

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

// What is behind a scene: colours from the top of the picture to its bottom.
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
};

// A solid arrow; its length includes the head. It shines faintly through shapes that hide it. Nothing is drawn if its
// length or radius is zero.
struct Arrow {
  Vec3d from;
  Vec3d to;
  double radius = 0.01;  // of the shaft; the head is 2.4 times as wide
  Color color{0.20f, 0.25f, 0.85f, 1};
};

// A round rod along a polyline (an axis, a path, a ring). It shines through shapes like an arrow.
struct Line {
  std::vector<Vec3d> points;
  double radius = 0.005;
  bool closed = false;
  Color color{0.15f, 0.15f, 0.20f, 1};
};

// Removes the side dot(normal, x) > offset. The cut through a closed shape is a plane with its own colour.
struct Clip {
  Vec3d normal{1, 0, 0};
  double offset = 0;
  Color color{0.86f, 0.42f, 0.30f, 1};
};

// What a picture shows.
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

}  // namespace knead::render
