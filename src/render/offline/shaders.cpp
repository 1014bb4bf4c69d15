// The GLSL 3.30 sources of the offline renderer's programs.
#include "render/offline/passes.h"
#include "render/surface.h"

namespace knead::render {
namespace {

const char* const kSurfaceVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
layout(location = 3) in vec4 edge;
uniform mat4 matrix;
uniform vec4 clip;         // dot(clip.xyz, p) > clip.w is taken away
uniform float point_size;  // in samples, at distance 1 in perspective
out vec3 point;
out vec3 surface_normal;
out vec3 srgb;
out vec3 edge_distance;
invariant gl_Position;
void main() {
  point = position;
  surface_normal = normal;
  srgb = color.rgb;
  edge_distance = edge.xyz;
  gl_Position = matrix * vec4(position, 1.0);
  gl_PointSize = max(point_size / gl_Position.w, 1.5);
  gl_ClipDistance[0] = clip.w - dot(clip.xyz, position);
}
)";

// The G-buffer: reflectance in sRGB, for which eight bits suffice; normal from 0 to 1, and 1 for "shape".
const char* const kSurfaceInputs = R"(
in vec3 point;
in vec3 surface_normal;
in vec3 srgb;
in vec3 edge_distance;
uniform vec3 back_srgb;
uniform float wire_width;  // in samples
layout(location = 0) out vec4 reflectance;
layout(location = 1) out vec4 normal_out;
void write(vec3 color, vec3 n) {
  reflectance = vec4(color, 1.0);
  normal_out = vec4(0.5 + 0.5 * n, 1.0);
}
vec3 unit_normal() {
  vec3 n = normalize(surface_normal);
  return gl_FrontFacing ? n : -n;
}
vec3 in_srgb(vec3 c) {
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), c));
}
// Faint on triangles that are hardly higher than a wire is wide: else nothing would be seen but wires.
float wire() {
  vec3 height = 1.0 / max(fwidth(edge_distance), vec3(1e-8));
  vec3 d = edge_distance * height;
  float nearest = min(d.x, min(d.y, d.z));
  float lowest = min(height.x, min(height.y, height.z));
  return min(1.0, lowest / (4.0 * wire_width)) *
         (1.0 - smoothstep(0.5 * wire_width - 0.5, 0.5 * wire_width + 0.5, nearest));
}
)";

const char* const kClayFragment = R"(
void main() {
  vec3 color = gl_FrontFacing ? srgb : back_srgb;
#ifdef WIRES
  color = in_srgb(linear(color) * (1.0 - 0.92 * wire()));
#endif
  write(color, unit_normal());
}
)";

// Where the nearest surface is a back face seen from the side that was cut away, the ray went in through the cut: show
// that point instead. `nearest_map` is the depth of the shapes without the cut.
const char* const kCapFragment = R"(
uniform sampler2D nearest_map;
uniform vec4 clip;
uniform vec3 cut_srgb;
void main() {
  float nearest = texelFetch(nearest_map, ivec2(gl_FragCoord.xy), 0).x;
  vec3 origin = ray_origin(gl_FragCoord.xy);
  vec3 direction = ray_direction(gl_FragCoord.xy);
  float toward = dot(clip.xyz, direction);
  if (gl_FrontFacing || gl_FragCoord.z > nearest + 1e-6 || toward >= 0.0) discard;
  float t = (clip.w - dot(clip.xyz, origin)) / toward;
  if (t <= range.x) discard;
  gl_FragDepth = clamp(depth_at(t), 0.0, 1.0);
  write(cut_srgb, clip.xyz);
}
)";

const char* const kDiscFragment = R"(
void main() {
  vec2 p = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float r2 = dot(p, p);
  if (r2 > 1.0) discard;
  vec3 n = normalize(side) * p.x + normalize(top) * p.y - forward * sqrt(1.0 - r2);
  write(srgb, normalize(n));
}
)";

const char* const kRodFragment = R"(
in vec3 point;
in vec3 surface_normal;
in vec3 srgb;
uniform float opacity;
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 normal_out;
void main() {
  vec3 n = normalize(surface_normal);
  vec3 v = -normalize(ray_direction(gl_FragCoord.xy));
  color = vec4(linear(srgb) * diffuse(n) + 0.25 * opacity * shine(n, v, 60.0), 1.0) * opacity;
  normal_out = vec4(0.0);  // no line where glass meets a rod
}
)";

// The nearest layer behind those already drawn. Denser where it is seen edge on, as a thin shell is; the line in which
// it meets a shape is found from the two depths and normals at this sample; steep slopes foretell it too early and are
// cut.
const char* const kGlassFragment = R"(
in vec3 point;
in vec3 surface_normal;
uniform sampler2D depth_map, normal_map, layer_map;
uniform vec4 glass;        // sRGB, opacity
uniform float pixel;       // size of a sample (surface.h)
uniform float line_width;  // in samples
out vec4 color;

float contact(vec3 n, vec3 ray, float t_glass, float t_shape) {
  vec4 shape = texelFetch(normal_map, ivec2(gl_FragCoord.xy), 0);
  if (shape.w < 0.5) return 0.0;
  vec3 d = normalize(ray);
  vec3 m = normalize(2.0 * shape.xyz - 1.0);
  float nd = dot(n, d), md = dot(m, d);
  if (abs(nd) < 1e-3 || abs(md) < 1e-3) return 0.0;
  vec3 slope = (m - md * d) / md - (n - nd * d) / nd;
  float away = (t_shape - t_glass) * length(ray) / clamp(length(slope), 0.02, 3.0);
  float samples_away = away / (pixel * mix(1.0, t_shape, perspective));
  return 1.0 - smoothstep(line_width - 0.7, line_width + 0.7, samples_away);
}

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  float opaque = texelFetch(depth_map, texel, 0).x;
  float before = texelFetch(layer_map, texel, 0).x;
  if (gl_FragCoord.z >= opaque || gl_FragCoord.z <= before) discard;
  vec3 ray = ray_direction(gl_FragCoord.xy);
  vec3 v = -normalize(ray);
  vec3 n = normalize(surface_normal);
  bool inside = dot(n, v) < 0.0;
  if (inside) n = -n;
  float rim = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 3.0);
  float alpha = mix(glass.a, max(glass.a, 0.85), rim) * (inside ? 0.75 : 1.0);
  vec3 tint = linear(glass.rgb);
  vec3 body = tint * mix(0.75 + 0.45 * diffuse(n), 0.75, rim);
  float spark = inside ? 0.0 : 0.55 * shine(n, v, 90.0);
  color = vec4(body * alpha + spark, clamp(alpha + spark, 0.0, 1.0));
  float line = contact(n, ray, distance_at(gl_FragCoord.z), distance_at(opaque));
  color = mix(color, vec4(tint * 0.6, 1.0), 0.9 * line);
}
)";

const char* const kCopyFragment = R"(
uniform sampler2D layer;
out vec4 color;
void main() { color = texelFetch(layer, ivec2(gl_FragCoord.xy), 0); }
)";

ShaderSource surface_program(const std::string& fragment) {
  return {std::string(kVersion) + kSurfaceVertex, std::string(kVersion) + kView + kSurfaceInputs + fragment};
}

ShaderSource simple_program(const char* fragment) {
  return {std::string(kVersion) + kSurfaceVertex, std::string(kVersion) + kView + kSimpleLight + fragment};
}

}  // namespace

ShaderSource full_screen_program(const std::string& fragment) {
  return {std::string(kVersion) + kFullScreenVertex, std::string(kVersion) + kView + fragment};
}

ShaderSource clay_source() { return surface_program(kClayFragment); }
ShaderSource wired_source() { return surface_program(std::string("#define WIRES\n") + kClayFragment); }
ShaderSource cap_source() { return surface_program(kCapFragment); }
ShaderSource disc_source() { return surface_program(kDiscFragment); }
ShaderSource rod_source() { return simple_program(kRodFragment); }
ShaderSource glass_source() { return simple_program(kGlassFragment); }
ShaderSource copy_source() { return full_screen_program(kCopyFragment); }

}  // namespace knead::render
