// The parts that both renderers share: GLSL (3.30, and its common subset with GLSL ES 3.00 of pages), the view, and the
// triangles of meshes, rods and matcaps. Internal to render.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "knead/editor/render.h"
#include "knead/mesh.h"

namespace knead::render {

// The first lines of every shader, and clipping: clip_by(d) in a vertex shader and clip_away() in its fragment shader
// remove everything with d < 0.
#if defined(__EMSCRIPTEN__)
inline constexpr const char* kVersion =
    "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n";
inline constexpr const char* kClipVertex = "out float kept;\nvoid clip_by(float d) { kept = d; }\n";
inline constexpr const char* kClipFragment = "in float kept;\nvoid clip_away() { if (kept < 0.0) discard; }\n";
#else
inline constexpr const char* kVersion = "#version 330 core\n";
inline constexpr const char* kClipVertex = "void clip_by(float d) { gl_ClipDistance[0] = d; }\n";
inline constexpr const char* kClipFragment = "void clip_away() {}\n";
#endif

// Converts samples of the picture to rays, and depths to points on them (View).
inline constexpr const char* kView = R"(
uniform vec3 eye, forward, side, top;
uniform vec2 shift;        // of the lens
uniform vec2 range;        // near, far
uniform float perspective;
uniform vec2 samples;      // of the picture, wide and high

vec3 screen_offset(vec2 at) {
  vec2 p = 2.0 * at / samples - 1.0 - shift;
  return p.x * side + p.y * top;
}
vec3 ray_origin(vec2 at) { return eye + (1.0 - perspective) * screen_offset(at); }
vec3 ray_direction(vec2 at) { return forward + perspective * screen_offset(at); }
float distance_at(float depth) {
  float extent = range.y - range.x;
  return perspective > 0.5 ? range.x * range.y / (range.y - depth * extent) : range.x + depth * extent;
}
float depth_at(float t) {
  float extent = range.y - range.x;
  return perspective > 0.5 ? range.y * (t - range.x) / (t * extent) : (t - range.x) / extent;
}
float gradient_noise(vec2 at) { return fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715)))); }
vec3 linear(vec3 srgb) {
  return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), srgb));
}
)";

inline constexpr const char* kFullScreenVertex = R"(
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

// The relief of a sample of a shape, from its neighbourhood in the picture. depth_map and normal_map are of all
// samples; normals have w = 1 where a shape is. Both functions use the plane through the sample p with the unit normal
// n; size: of a sample there.
//
// cavity: the divergence of the normals, from groove (< 0) to ridge (> 0), at two distances; a neighbour off the plane,
// far away in it or on an outline may be another surface, and the one opposite counts twice. occlusion: the part of the
// light that arrives, 1 for a plane; McGuire, Mara and Luebke, "Scalable ambient obscurance" (2012).
inline constexpr const char* kRelief = R"(
uniform sampler2D depth_map, normal_map;
uniform float sample_size;      // at distance 1 in perspective (surface.h)
uniform float cavity_step;      // in samples
uniform float occlusion_reach;  // in renderer units

vec3 place_of(vec2 at, float depth) { return ray_origin(at) + distance_at(depth) * ray_direction(at); }
float size_at(float depth) { return sample_size * mix(1.0, distance_at(depth), perspective); }

// On the outline every surface turns away.
float is_inside(vec3 n, vec3 v) { return smoothstep(0.1, 0.6, dot(n, v)); }
// The mean of the normals of two surfaces in one pixel is short.
float is_one(vec4 mean_normal) { return smoothstep(0.96, 0.99, length(mean_normal.xyz)); }
// The component of a neighbour's normal along an axis, within limits, so that sharp folds make no dots; and from 0 to 1
// how surely it belongs to the same surface.
vec2 lean(ivec2 texel, ivec2 away, vec3 axis, vec3 p, vec3 n, vec3 v, float size) {
  ivec2 at = clamp(texel + away, ivec2(0), ivec2(samples) - 1);
  vec4 other = texelFetch(normal_map, at, 0);
  float depth = texelFetch(depth_map, at, 0).x;
  if (other.w < 0.99 || depth == 1.0) return vec2(0.0);
  vec3 d = place_of(vec2(at) + 0.5, depth) - p;
  float off = max(abs(dot(n, d)), 0.3 * length(d) * dot(n, v)) / (length(vec2(away)) * size);
  vec3 m = normalize(other.xyz);
  float weight = is_one(other) * is_inside(m, v);
  return vec2(clamp(dot(m - n, axis), -0.25, 0.25), (1.0 - smoothstep(0.3, 0.8, off)) * weight);
}
float across(vec2 a, vec2 b) { return 2.0 * (a.y * a.x - b.y * b.x) / max(a.y + b.y, 1.0); }
float spread(ivec2 texel, int away, vec3 p, vec3 n, vec3 v, float size) {
  vec3 x = normalize(side), y = normalize(top);
  vec2 right = lean(texel, ivec2(away, 0), x, p, n, v, size), left = lean(texel, ivec2(-away, 0), x, p, n, v, size);
  vec2 above = lean(texel, ivec2(0, away), y, p, n, v, size), below = lean(texel, ivec2(0, -away), y, p, n, v, size);
  return across(right, left) + across(above, below);
}
// As a factor of brightness.
float cavity(ivec2 texel, vec3 p, vec3 n, vec3 v, float size) {
  int away = max(1, int(cavity_step + 0.5));
  float c = 0.8 * spread(texel, away, p, n, v, size) + 0.5 * spread(texel, 3 * away, p, n, v, size);
  c *= is_inside(n, v) * is_one(texelFetch(normal_map, texel, 0));
  return c < 0.0 ? 1.0 / (1.0 - 1.1 * c) : 1.0 + 0.55 * c / (0.6 + c);
}

float occlusion(vec2 at, vec3 p, vec3 n, float size, int taps, float turn) {
  float reach = min(occlusion_reach, 0.12 * samples.y * size);
  float sum = 0.0;
  for (int i = 0; i < taps; ++i) {
    float angle = 2.3999632 * float(i) + turn;
    float r = (float(i) + 0.5) / float(taps) * reach / size;
    vec2 to = clamp(at + r * vec2(cos(angle), sin(angle)), vec2(0.5), samples - 0.5);
    float depth = texelFetch(depth_map, ivec2(to), 0).x;
    if (depth == 1.0) continue;
    vec3 d = place_of(floor(to) + 0.5, depth) - p;
    float dd = dot(d, d);
    float f = max(1.0 - dd / (reach * reach), 0.0);
    // Triangles lie a little beside the surface that the normals tell of.
    float above = max(dot(d, n) - 0.07 * sqrt(dd) - size, 0.0);
    sum += f * f * f * above / (dd + 0.0004 * reach * reach);
  }
  return max(1.0 - 2.2 * reach * sum / float(taps), 0.0);
}
)";

// The light of things that neither cast nor catch shadows: a sky and the key light.
inline constexpr const char* kSimpleLight = R"(
uniform vec3 sky_up, key;
float diffuse(vec3 n) { return 0.52 + 0.18 * dot(n, sky_up) + 0.5 * max(dot(n, key), 0.0); }
float shine(vec3 n, vec3 v, float power) { return pow(max(dot(n, normalize(key + v)), 0.0), power); }
)";

// The map from scene coordinates to renderer units: the scene's middle at the origin, everything within the unit ball.
// Differences are computed in double, so that tiny shapes and shapes far from the origin keep their digits in float.
struct Placement {
  Vec3d center;
  double scale = 1;  // renderer units per scene unit

  Vec3d apply(const Vec3d& p) const { return (p - center) * scale; }
};

// The middle of the box at the origin, its corners on the unit sphere; a box without extent keeps its size.
Placement make_placement(const Box& box);

using Mat4f = std::array<float, 16>;  // by columns, as in OpenGL

// The camera in renderer units. A point of the picture (x, y in -1..1, less the shift) at distance t in front of the
// eye is origin + direction * t, where origin = eye + (x * side + y * top) * (1 - perspective) and direction = forward
// + (x * side + y * top) * perspective.
struct View {
  Placement placement;
  CameraFrame frame;
  Vec3d ground_up;  // unit
  Vec3d eye;
  Vec3d side;
  Vec3d top;
  double near = 0;
  double far = 1;
  bool perspective = false;
  double shift_x = 0;  // Camera's
  double shift_y = 0;
  double pixel = 0;  // the size of a sample, at distance 1 in perspective
  Mat4f matrix{};    // to clip space
};

// A ball in renderer units.
struct BoundingBall {
  Vec3d center;
  double radius = 1;
};

// Returns the view that shows everything in the ball. samples_high: the rows of samples in the picture. Throws
// InvalidInput for a camera outside its range.
View make_view(const Camera& camera, const Placement& placement, const BoundingBall& shown, double aspect,
               int samples_high);

// The same for a scene and its placement.
View make_view(const Scene& scene, double aspect, int samples_high);

using Bytes4 = std::array<std::uint8_t, 4>;

struct DrawVertex {
  Vec3f position;  // renderer units
  Vec3f normal;    // unit; zero in a point cloud
  Bytes4 color{255, 255, 255, 255};
  Bytes4 edge{255, 255, 255, 255};  // barycentric; held at 255 across an edge not to be drawn
};

// A mesh for the GPU, with one normal per smooth group of faces around a vertex. Three indices per triangle; without
// indices the vertices are points.
struct DrawSurface {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> indices;
  bool is_solid = false;  // closed, and every part turned outwards: the backs of its faces need not cast shadows
};

struct SurfaceOptions {
  double crease_angle = 0.7;  // radians; faces meet smoothly where they bend by at most this; negative: nowhere
  bool wireframe = false;     // fill in DrawVertex::edge, at the price of three vertices per triangle
};

// Normals are weighted by the corners' angles. Faces without area, or with a corner that is not finite, are left out,
// and so are points that are not finite. vertex_colors has one colour per vertex, or none (white).
DrawSurface make_surface(const Mesh& mesh, const std::vector<Bytes4>& vertex_colors, const Placement& placement,
                         const SurfaceOptions& options);

// Returns the colour of every vertex of a shape: its vertex_colors, the mesh's attribute or shape.color, in this order.
std::vector<Bytes4> colors_of(const Shape& shape);

Bytes4 to_bytes(const Color& color);

inline constexpr std::uint32_t kNoVertex = 0xffffffff;

// The faces of a mesh in renderer units.
struct PlacedFaces {
  std::vector<Vec3d> positions;            // per vertex, renderer units
  std::vector<Vec3f> normals;              // per face, unit; zero: the face is left out
  std::vector<std::uint32_t> corner_face;  // per corner
};

// Faces without area, or with a corner that is not finite, are left out.
PlacedFaces place_faces(const Mesh& mesh, const Placement& placement);

// The triangles of the faces that are not left out, as corners, face after face.
std::vector<Triangle> corner_triangles(const Mesh& mesh, const PlacedFaces& faces);

// The vertices before and after a corner in its face.
std::pair<std::uint32_t, std::uint32_t> around(const Mesh& mesh, const PlacedFaces& faces, std::uint32_t corner);

// One drawn vertex per vertex and group of faces that meet smoothly there.
struct SmoothGroups {
  std::vector<std::uint32_t> corner_vertex;  // the drawn vertex of each corner; kNoVertex: its face is left out
  std::vector<std::uint32_t> begin;          // the drawn vertices of vertex v are begin[v] to begin[v + 1]
  std::vector<std::uint32_t> corner;         // per drawn vertex, one of its corners
};

// crease_angle: in radians; faces meet smoothly where they bend by at most this; negative: nowhere.
SmoothGroups smooth_groups(const Mesh& mesh, const PlacedFaces& faces, double crease_angle);

// Appends the arrow or line to the surface as triangles. Omits parts without length or radius, or that are not finite.
// sides: of the prisms for round parts, at least 3.
void add_arrow(const Arrow& arrow, const Placement& placement, DrawSurface& surface, int sides = 48);
void add_line(const Line& line, const Placement& placement, DrawSurface& surface, int sides = 48);

// Returns the picture of a matcap's ball that fills size * size pixels, seen from the front, rows from the bottom up.
// The outline's colours continue beyond it. Valid: size >= 2.
std::vector<Bytes4> matcap_picture(Matcap matcap, int size);

}  // namespace knead::render
