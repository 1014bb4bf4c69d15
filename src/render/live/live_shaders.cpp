// The GLSL 3.30 sources of the live view's programs. They write colours in sRGB.
#include <string>

#include "render/live/live.h"
#include "render/surface.h"

namespace knead::render {
namespace {

const char* const kVertexInputs = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 color;
uniform mat4 matrix;
uniform vec4 clip;  // dot(clip.xyz, p) > clip.w is clipped
invariant gl_Position;
void place() {
  gl_Position = matrix * vec4(position, 1.0);
  clip_by(clip.w - dot(clip.xyz, position));
}
)";

const char* const kShapeVertex = R"(
uniform float point_size;  // in samples, at distance 1 in perspective
out vec3 point;
out vec3 surface_normal;
out vec4 tint;
void main() {
  place();
  point = position;
  surface_normal = normal;
  tint = color;
  gl_PointSize = max(point_size / gl_Position.w, 1.5);
}
)";

const char* const kInfluence = R"(
uniform float influence;  // 1: shown; 2: as a stretch
uniform vec3 stretch[5];
vec3 with_influence(vec4 c) {
  if (influence > 1.5) {
    vec3 shade = stretch[0];
    for (int i = 0; i < 4; ++i) shade = mix(shade, stretch[i + 1], clamp(4.0 * c.a - float(i), 0.0, 1.0));
    return shade;
  }
  vec3 hue = mix(vec3(0.16, 0.66, 0.26), vec3(0.90, 0.13, 0.09), smoothstep(0.55, 0.98, c.a));
  float strength = influence * mix(0.55, 0.72, c.a) * smoothstep(0.0, 0.3, c.a);
  return mix(c.rgb, hue, strength);
}
)";

// Colours are multiplied by light as squares, a cheap approximation of the screen's transfer function.
const char* const kClayLight = R"(
vec3 clay(vec3 base, vec3 n, vec3 v) {
  float up = 0.5 + 0.5 * dot(n, sky_up);
  float lit = max(dot(n, key), 0.0);
  vec3 light = mix(vec3(0.25, 0.225, 0.21), vec3(0.47, 0.50, 0.54), up) + lit * vec3(0.98, 0.94, 0.875);
  light += max(dot(n, fill), 0.0) * vec3(0.10, 0.12, 0.15);
  float facing = clamp(dot(n, v), 0.0, 1.0);
  float edge = 1.0 - facing;
  edge *= edge;
  light *= mix(0.62, 1.0, smoothstep(0.0, 0.55, facing));
  float gloss = max(dot(n, normalize(key + v)), 0.0);
  gloss *= gloss;
  gloss *= gloss;
  gloss *= gloss;
  gloss *= gloss;
  return sqrt(base * base * light + 0.055 * gloss * lit + 0.10 * edge * edge * up);
}
)";

// The normal is kept where there is a target for it.
const char* const kShapeInputs = R"(
in vec3 point;
in vec3 surface_normal;
in vec4 tint;
uniform vec3 back_srgb;
layout(location = 0) out vec4 pixel;
layout(location = 1) out vec4 normal_out;
vec3 base_color() { return gl_FrontFacing ? with_influence(tint) : back_srgb; }
// Interpolated normals may lean away from the viewer.
vec3 unit_normal(vec3 v) {
  vec3 n = gl_FrontFacing ? normalize(surface_normal) : -normalize(surface_normal);
  float facing = dot(n, v);
  return facing < 0.0 ? normalize(n - facing * v) : n;
}
const int SECTIONS = 3;         // kMaxSections
uniform vec4 section[SECTIONS];  // dot(section.xyz, p) = section.w
uniform vec3 section_srgb[SECTIONS];
uniform int sections;
// Two samples wide.
vec3 with_sections(vec3 color) {
  for (int i = 0; i < SECTIONS; ++i) {
    float s = dot(section[i].xyz, point) - section[i].w;
    float off = abs(s) / max(fwidth(s), 1e-6);
    if (i < sections) color = mix(section_srgb[i], color, smoothstep(0.7, 1.7, off));
  }
  return color;
}
)";

const char* const kClayFragment = R"(
void main() {
  clip_away();
  vec3 v = -normalize(ray_direction(gl_FragCoord.xy));
  vec3 n = unit_normal(v);
  pixel = vec4(with_sections(clay(base_color(), n, v)), 1.0);
  normal_out = vec4(n, 1.0);
}
)";

// Hard lamps of different colours: the slopes of neighbouring faces differ in hue, and nothing else lights the shape.
const char* const kFlatFragment = R"(
void main() {
  clip_away();
  vec3 n = normalize(cross(dFdx(point), dFdy(point)));
  vec3 light = vec3(0.05, 0.05, 0.07) + max(dot(n, key), 0.0) * vec3(0.92, 0.80, 0.62) +
               max(dot(n, fill), 0.0) * vec3(0.05, 0.26, 0.62) + max(-dot(n, sky_up), 0.0) * vec3(0.30, 0.14, 0.10);
  vec3 base = base_color();
  pixel = vec4(with_sections(sqrt(base * base * light)), 1.0);
  normal_out = vec4(n, 1.0);
}
)";

// The normal seen along this sample's ray, so that perspective does not turn the ball's picture.
const char* const kMatcapFragment = R"(
uniform sampler2D ball;
uniform vec3 plain_srgb;  // the colour that leaves the material as it is
void main() {
  clip_away();
  vec3 d = normalize(ray_direction(gl_FragCoord.xy));
  vec3 x = normalize(cross(d, top));
  vec3 y = cross(x, d);
  vec3 n = unit_normal(-d);
  vec2 at = vec2(dot(n, x), dot(n, y));
  vec3 material = texture(ball, 0.5 + 0.49 * at).rgb;
  pixel = vec4(with_sections(min(material * base_color() / plain_srgb, 1.0)), 1.0);
  normal_out = vec4(n, 1.0);
}
)";

const char* const kCloudFragment = R"(
void main() {
  clip_away();
  vec2 p = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float r2 = dot(p, p);
  if (r2 > 1.0) discard;
  vec3 n = normalize(0.6 * (normalize(side) * p.x + normalize(top) * p.y) - forward);
  vec3 v = -normalize(ray_direction(gl_FragCoord.xy));
  pixel = vec4(clay(with_influence(tint), n, v), 1.0);
}
)";

// A quad about what is seen of each splat, in their order; the quads of a row are one instance. The projection is that
// of render_splats().
const char* const kSplatVertex = R"(
uniform mat4 matrix;
uniform vec4 clip;
uniform highp usampler2D order_map;
uniform sampler2D place_map, shape_map, color_map, tint_map;
const int ROW = 1024;  // kSplatRow
uniform int count;
uniform float enlargement;  // of the variance
uniform float nearest;      // distance
uniform float faintest;     // alpha that is seen
uniform float blur, brightest;
flat out vec4 color;
out vec2 deviations;  // from the middle
void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // is not seen
  color = vec4(0.0);
  deviations = vec2(0.0);
  clip_by(1.0);
  int quad = gl_VertexID >> 2;
  if (gl_InstanceID * ROW + quad >= count) return;
  int splat = int(texelFetch(order_map, ivec2(quad, gl_InstanceID), 0).x);
  ivec2 cell = ivec2(splat % ROW, splat / ROW);
  ivec2 pair = ivec2(2 * cell.x, cell.y);
  vec3 from_eye = texelFetch(place_map, pair, 0).xyz - eye;
  vec3 a = texelFetch(shape_map, pair, 0).xyz, b = texelFetch(shape_map, pair + ivec2(1, 0), 0).xyz;
  mat3 covariance = enlargement * mat3(a, vec3(a.y, b.xy), vec3(a.z, b.yz));
  float depth = mix(1.0, dot(from_eye, forward), perspective);
  if (!(depth > nearest * perspective)) return;
  vec3 right = normalize(side), up = normalize(top), lean = forward * (perspective / depth);
  float scale = samples.y / (2.0 * length(top) * depth);
  vec3 across = (right - lean * dot(from_eye, right)) * scale, along = (up - lean * dot(from_eye, up)) * scale;
  float xx = dot(across, covariance * across) + blur, yy = dot(along, covariance * along) + blur;
  float xy = dot(across, covariance * along);
  float mean = 0.5 * (xx + yy), apart = length(vec2(0.5 * (xx - yy), xy));
  vec4 own = texelFetch(color_map, cell, 0), tint = texelFetch(tint_map, cell, 0);
  if (!(own.a > faintest) || !(mean < 1e12)) return;
  vec2 axis = xx >= yy ? vec2(0.5 * (xx - yy) + apart, xy) : vec2(xy, 0.5 * (yy - xx) + apart);
  axis = apart > 1e-6 * mean ? normalize(axis) : vec2(1.0, 0.0);
  float reach = sqrt(2.0 * log(own.a / faintest));
  deviations = reach * (vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0);
  vec2 long_axis = sqrt(mean + apart) * axis, short_axis = sqrt(max(mean - apart, blur)) * vec2(-axis.y, axis.x);
  vec4 middle = matrix * vec4(from_eye + eye, 1.0);
  vec2 offset = (long_axis * deviations.x + short_axis * deviations.y) * 2.0 / samples;
  gl_Position = vec4(middle.xy / middle.w + offset, middle.z / middle.w, 1.0);
  color = vec4(with_influence(vec4(own.rgb * brightest * tint.rgb, tint.a)), own.a);
  clip_by(clip.w - dot(clip.xyz, from_eye + eye));
}
)";
const char* const kSplatFragment = R"(
flat in vec4 color;
in vec2 deviations;
uniform float least, greatest;
layout(location = 0) out vec4 pixel;
void main() {
  clip_away();
  float alpha = min(color.a * exp(-0.5 * dot(deviations, deviations)), greatest);
  if (alpha <= least) discard;
  pixel = vec4(color.rgb, 1.0) * alpha;
}
)";

// Edges fade where they come so close together that they would hide the shape.
const char* const kWireVertex = R"(
uniform float edge_samples;  // the length of the mean edge at distance 1, in samples
out float opacity;
void main() {
  place();
  opacity = clamp(edge_samples / gl_Position.w / 16.0, 0.07, 0.75);
}
)";
const char* const kWireFragment = R"(
in float opacity;
layout(location = 0) out vec4 pixel;
void main() {
  clip_away();
  pixel = vec4(vec3(0.05, 0.05, 0.06) * opacity, opacity);
}
)";

const char* const kDepthVertex = "void main() { place(); }\n";

const char* const kCutVertex = R"(
uniform mat4 matrix;
uniform vec3 middle, across, along;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  gl_Position = matrix * vec4(middle + corner.x * across + corner.y * along, 1.0);
}
)";
const char* const kCutFragment = R"(
uniform vec3 cut_srgb, cut_normal;
layout(location = 0) out vec4 pixel;
layout(location = 1) out vec4 normal_out;
void main() {
  pixel = vec4(clay(cut_srgb, cut_normal, -normalize(ray_direction(gl_FragCoord.xy))), 1.0);
  normal_out = vec4(cut_normal, 1.0);
}
)";

// Noise of one step hides that eight bits have steps.
const char* const kBackgroundVertex = R"(
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 1.0, 1.0);
}
)";
const char* const kBackgroundFragment = R"(
uniform vec3 top_srgb, bottom_srgb;
layout(location = 0) out vec4 pixel;
void main() {
  float noise = (gradient_noise(gl_FragCoord.xy) - 0.5) / 255.0;
  pixel = vec4(mix(bottom_srgb, top_srgb, gl_FragCoord.y / samples.y) + noise, 1.0);
}
)";

const char* const kImageVertex = R"(
uniform mat4 matrix;
uniform vec3 center, right_half, up_half;
out vec2 place;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  place = vec2(0.5, -0.5) * corner + 0.5;
  vec4 p = matrix * vec4(center + corner.x * right_half + corner.y * up_half, 1.0);
  gl_Position = vec4(p.xy, p.w, p.w);
}
)";
const char* const kImageFragment = R"(
in vec2 place;
uniform sampler2D image;
uniform float opacity;
layout(location = 0) out vec4 pixel;
void main() {
  vec4 c = texture(image, place);
  pixel = vec4(c.rgb, 1.0) * (c.a * opacity);
}
)";

const char* const kRodFragment = R"(
in vec3 point;
in vec3 surface_normal;
in vec4 tint;
uniform float opacity;
layout(location = 0) out vec4 pixel;
void main() {
  vec3 n = normalize(surface_normal);
  vec3 v = -normalize(ray_direction(gl_FragCoord.xy));
  vec3 c = sqrt(tint.rgb * tint.rgb * diffuse(n) + 0.22 * shine(n, v, 48.0));
  pixel = vec4(c, 1.0) * opacity;
}
)";

// Denser where it is seen edge on, as a thin shell is; and with a line where it meets what lies behind: there the
// difference of the two depths vanishes, and its slope on the screen says in how many samples.
const char* const kGlassFragment = R"(
in vec3 point;
in vec3 surface_normal;
in vec4 tint;
uniform sampler2D depth_map;  // of shape and cut; without multisampling
uniform vec4 glass;           // sRGB, opacity
uniform float pixel_size;     // surface.h
uniform float line_width;     // in samples
layout(location = 0) out vec4 color;
float contact(vec3 ray) {
  float behind = texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).x;
  float t = distance_at(behind);
  float gap = (t - distance_at(gl_FragCoord.z)) * length(ray);
  float sample_size = pixel_size * mix(1.0, t, perspective);
  float slope = clamp(length(vec2(dFdx(gap), dFdy(gap))) / sample_size, 0.02, 3.0);
  float away = abs(gap) / (sample_size * slope);
  return behind == 1.0 ? 0.0 : 1.0 - smoothstep(line_width - 0.7, line_width + 0.7, away);
}
void main() {
  vec3 ray = ray_direction(gl_FragCoord.xy);
  vec3 v = -normalize(ray);
  vec3 n = normalize(surface_normal);
  float line = contact(ray);
  float spark = 0.0;
  float alpha = 1.0;
  if (dot(n, v) < 0.0) {
    n = -n;
    alpha = 0.75;
  } else {
    spark = 0.45 * shine(n, v, 80.0);
  }
  float rim = 1.0 - clamp(dot(n, v), 0.0, 1.0);
  rim *= rim * rim;
  alpha *= mix(glass.a, max(glass.a, 0.8), rim);
  vec3 body = glass.rgb * mix(sqrt(0.7 + 0.5 * diffuse(n)), 0.85, rim);
  color = vec4(body * alpha + spark, min(alpha + spark, 1.0));
  color = mix(color, vec4(glass.rgb * 0.72, 1.0), 0.85 * line);
}
)";

// One target texel for 2 x 2 samples, by one of them. Neighbours turn their taps differently.
const char* const kOcclusionFragment = R"(
layout(location = 0) out vec4 lit;
void main() {
  ivec2 cell = ivec2(gl_FragCoord.xy);
  ivec2 texel = min(2 * cell, ivec2(samples) - 1);
  vec2 at = vec2(texel) + 0.5;
  float depth = texelFetch(depth_map, texel, 0).x;
  vec4 normal = texelFetch(normal_map, texel, 0);
  lit = vec4(1.0);
  if (depth == 1.0 || normal.w < 0.5) return;
  float turn = 6.2831853 / 16.0 * float((4 * (cell.x & 3) + 7 * (cell.y & 3)) & 15);
  lit = vec4(occlusion(at, place_of(at, depth), normalize(normal.xyz), size_at(depth), 12, turn));
}
)";

// Of the 4 x 4 texels around, those that lie on the same surface.
const char* const kSmoothFragment = R"(
uniform sampler2D occlusion_map;
layout(location = 0) out vec4 lit;
void main() {
  ivec2 cell = ivec2(gl_FragCoord.xy);
  ivec2 texel = min(2 * cell, ivec2(samples) - 1);
  float depth = texelFetch(depth_map, texel, 0).x;
  vec4 normal = texelFetch(normal_map, texel, 0);
  lit = vec4(1.0);
  if (depth == 1.0 || normal.w < 0.5) return;
  vec3 n = normalize(normal.xyz);
  vec3 p = place_of(vec2(texel) + 0.5, depth);
  float limit = 8.0 * size_at(depth);
  ivec2 last = textureSize(occlusion_map, 0) - 1;
  float sum = 0.0, weight = 0.0;
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      ivec2 other = clamp(cell + ivec2(x, y), ivec2(0), last);
      ivec2 there = min(2 * other, ivec2(samples) - 1);
      float far = texelFetch(depth_map, there, 0).x;
      if (far == 1.0 || abs(dot(n, place_of(vec2(there) + 0.5, far) - p)) > limit) continue;
      sum += texelFetch(occlusion_map, other, 0).x;
      weight += 1.0;
    }
  }
  lit = vec4(weight > 0.0 ? sum / weight : 1.0);
}
)";

// Blended as 2 * this * what is there, in the samples that a shape covers.
const char* const kReliefFragment = R"(
uniform sampler2D occlusion_map;
uniform float with_cavity, with_occlusion;
layout(location = 0) out vec4 factor;
float occlusion_here(ivec2 texel, vec3 p, vec3 n, float size) {
  ivec2 last = textureSize(occlusion_map, 0) - 1;
  float sum = 0.0, weight = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 cell = clamp((texel + ivec2(i & 1, i >> 1)) / 2, ivec2(0), last);
    ivec2 there = min(2 * cell, ivec2(samples) - 1);
    float depth = texelFetch(depth_map, there, 0).x;
    if (depth == 1.0 || abs(dot(n, place_of(vec2(there) + 0.5, depth) - p)) > 4.0 * size) continue;
    sum += texelFetch(occlusion_map, cell, 0).x;
    weight += 1.0;
  }
  return weight > 0.0 ? sum / weight : texelFetch(occlusion_map, clamp(texel / 2, ivec2(0), last), 0).x;
}
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(depth_map, texel, 0).x;
  vec4 normal = texelFetch(normal_map, texel, 0);
  if (depth == 1.0 || normal.w < 0.5) discard;
  vec3 n = normalize(normal.xyz);
  vec3 p = place_of(gl_FragCoord.xy, depth);
  float size = size_at(depth);
  float brightness = 1.0;
  if (with_cavity > 0.5) brightness *= cavity(texel, p, n, -normalize(ray_direction(gl_FragCoord.xy)), size);
  if (with_occlusion > 0.5) brightness *= occlusion_here(texel, p, n, size);
  factor = vec4(vec3(0.5 * brightness), 0.5);
}
)";

std::string vertex_program(const char* body) { return std::string(kVersion) + kClipVertex + kVertexInputs + body; }

ShaderSource relief_program(const char* vertex, const char* fragment) {
  return {std::string(kVersion) + vertex, std::string(kVersion) + kView + kRelief + fragment};
}

const char* const kFillLight = "uniform vec3 fill;\n";

std::string lit_program(const std::string& body) {
  return std::string(kVersion) + kView + kSimpleLight + kFillLight + kInfluence + kClayLight + body;
}

}  // namespace

ShaderSource live_shape_source(Material material) {
  const char* const body = material == Material::clay     ? kClayFragment
                           : material == Material::matcap ? kMatcapFragment
                                                          : kFlatFragment;
  return {vertex_program(kShapeVertex), lit_program(std::string(kClipFragment) + kShapeInputs + body)};
}
ShaderSource live_cloud_source() {
  return {vertex_program(kShapeVertex), lit_program(std::string(kClipFragment) + kShapeInputs + kCloudFragment)};
}
ShaderSource live_splat_source() {
  return {std::string(kVersion) + kView + kClipVertex + kInfluence + kSplatVertex,
          std::string(kVersion) + kClipFragment + kSplatFragment};
}
ShaderSource live_wire_source() {
  return {vertex_program(kWireVertex), std::string(kVersion) + kClipFragment + kWireFragment};
}
ShaderSource live_depth_source() {
  return {vertex_program(kDepthVertex), std::string(kVersion) + kClipFragment + "void main() { clip_away(); }\n"};
}
ShaderSource live_cut_source() { return {std::string(kVersion) + kCutVertex, lit_program(kCutFragment)}; }
ShaderSource live_background_source() {
  return {std::string(kVersion) + kBackgroundVertex, std::string(kVersion) + kView + kBackgroundFragment};
}
ShaderSource live_image_source() {
  return {std::string(kVersion) + kImageVertex, std::string(kVersion) + kImageFragment};
}
ShaderSource live_rod_source() {
  return {vertex_program(kShapeVertex), std::string(kVersion) + kView + kSimpleLight + kRodFragment};
}
ShaderSource live_glass_source() {
  return {vertex_program(kShapeVertex), std::string(kVersion) + kView + kSimpleLight + kGlassFragment};
}
ShaderSource live_occlusion_source() { return relief_program(kFullScreenVertex, kOcclusionFragment); }
ShaderSource live_smooth_source() { return relief_program(kFullScreenVertex, kSmoothFragment); }
ShaderSource live_relief_source() { return relief_program(kBackgroundVertex, kReliefFragment); }

}  // namespace knead::render
