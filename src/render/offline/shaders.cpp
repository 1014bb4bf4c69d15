#include "render/offline/passes.h"
#include "render/surface.h"

namespace knead::render {
namespace {

// The light that the ground lacks is smoothed the more the farther away the things are that block it: that hides the
// single lights, and contacts stay sharp. Taps lie on a spiral in the ground plane, turned differently in every texel.
// Towards the picture's sides the shadow fades, so that none is cut off.
const char* const kGroundFragment = R"(
uniform sampler2D ground_map;
uniform vec4 ground;           // up, height
uniform float ground_light;    // what the ground gets without shadow
uniform int taps;
uniform float reach;           // radius of what casts shadows
uniform mat4 matrix;
out vec4 darkness;  // alpha: 1 where the ground is seen

vec2 on_screen(vec3 p, vec2 size) {
  vec4 q = matrix * vec4(p, 1.0);
  return (0.5 + 0.5 * q.xy / q.w) * size;
}

float smoothed(vec3 p, vec4 lit, vec2 size) {
  float blocker = (lit.r + 0.002 * ground_light * reach) / (lit.g + 0.002 * ground_light);
  float radius = clamp(0.3 * blocker, 0.0, 0.4 * reach);
  vec3 a = normalize(cross(ground.xyz, abs(ground.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
  vec2 u = on_screen(p + radius * a, size) - gl_FragCoord.xy;
  vec2 v = on_screen(p + radius * cross(ground.xyz, a), size) - gl_FragCoord.xy;
  float turn = 6.2831853 * gradient_noise(gl_FragCoord.xy);
  float sum = lit.g, weight = 1.0;
  for (int i = 0; i < taps; ++i) {
    float angle = 2.3999632 * float(i) + turn;
    float r = sqrt((float(i) + 0.5) / float(taps));
    vec2 at = gl_FragCoord.xy + r * (cos(angle) * u + sin(angle) * v);
    if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, size))) continue;
    vec4 there = texelFetch(ground_map, ivec2(at), 0);
    if (there.a < 0.5) continue;
    float w = 1.0 - 0.7 * r * r;
    sum += w * there.g;
    weight += w;
  }
  return sum / weight;
}

void main() {
  darkness = vec4(0.0);
  vec4 lit = texelFetch(ground_map, ivec2(gl_FragCoord.xy), 0);
  if (lit.a < 0.5) return;
  darkness.a = 1.0;
  vec2 size = vec2(textureSize(ground_map, 0));
  vec2 at = gl_FragCoord.xy * samples / size;
  vec3 origin = ray_origin(at);
  vec3 ray = ray_direction(at);
  float down = dot(ground.xyz, ray);
  float t = (ground.w - dot(ground.xyz, origin)) / down;
  if (down > -1e-4 || t <= 0.0) return;
  vec2 from_side = min(gl_FragCoord.xy, size - gl_FragCoord.xy) / (0.12 * size.y);
  float fade = smoothstep(0.0, 1.0, from_side.x) * smoothstep(0.0, 1.0, from_side.y);
  darkness.r = fade * clamp(0.85 * smoothed(origin + t * ray, lit, size) / ground_light, 0.0, 1.0);
}
)";

const char* const kBackdropFragment = R"(
uniform sampler2D depth_map, pixel_map, sample_map, darkness_map;
uniform vec4 background_top, background_bottom;  // sRGB
uniform float with_ground;
uniform int factor;
out vec4 color;  // linear, multiplied by alpha
// Between the texels that see the ground.
float darkness_at(vec2 at) {
  vec2 p = at / (2.0 * float(factor)) - 0.5;
  ivec2 first = ivec2(floor(p));
  ivec2 last = textureSize(darkness_map, 0) - 1;
  vec2 part = p - vec2(first);
  float sum = 0.0, weight = 1e-6;
  for (int i = 0; i < 4; ++i) {
    ivec2 step = ivec2(i & 1, i >> 1);
    vec4 there = texelFetch(darkness_map, clamp(first + step, ivec2(0), last), 0);
    vec2 w = mix(1.0 - part, part, vec2(step));
    sum += w.x * w.y * there.a * there.r;
    weight += w.x * w.y * there.a;
  }
  return sum / weight;
}
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  if (texelFetch(depth_map, texel, 0).x < 1.0) {
    vec4 lit = texelFetch(pixel_map, texel / factor, 0);
    color = vec4(lit.a > 0.5 ? lit.rgb : texelFetch(sample_map, texel, 0).rgb, 1.0);
  } else {
    float dark = with_ground > 0.5 ? darkness_at(gl_FragCoord.xy) : 0.0;
    vec4 background = mix(background_bottom, background_top, gl_FragCoord.y / samples.y);
    vec3 behind = linear(background.rgb) * background.a;
    color = vec4(behind * (1.0 - dark) + vec3(0.018, 0.015, 0.012) * dark, background.a + (1.0 - background.a) * dark);
  }
}
)";

}  // namespace

ShaderSource ground_source() { return full_screen_program(kGroundFragment); }
ShaderSource backdrop_source() { return full_screen_program(kBackdropFragment); }

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

// The G-buffer: reflectance under a square root, so that eight bits suffice; normal and 1 for "shape".
const char* const kSurfaceInputs = R"(
in vec3 point;
in vec3 surface_normal;
in vec3 srgb;
in vec3 edge_distance;
uniform vec3 back_srgb;
uniform float wire_width;  // in samples; 0: no wires
layout(location = 0) out vec4 reflectance;
layout(location = 1) out vec4 normal_out;
void write(vec3 color, vec3 n) {
  reflectance = vec4(sqrt(color), 1.0);
  normal_out = vec4(n, 1.0);
}
vec3 unit_normal() {
  vec3 n = normalize(surface_normal);
  return gl_FrontFacing ? n : -n;
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
  vec3 color = linear(gl_FrontFacing ? srgb : back_srgb);
  if (wire_width > 0.0) color = mix(color, color * 0.08, wire());
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
  write(linear(cut_srgb), clip.xyz);
}
)";

const char* const kDiscFragment = R"(
void main() {
  vec2 p = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float r2 = dot(p, p);
  if (r2 > 1.0) discard;
  vec3 n = normalize(side) * p.x + normalize(top) * p.y - forward * sqrt(1.0 - r2);
  write(linear(srgb), normalize(n));
}
)";

// Light on the shapes, and what the ground lacks.
const char* const kLightInputs = R"(
uniform sampler2D reflectance_map, ball;
uniform sampler2DArray shadow_maps;
uniform float shadow_size;   // texels of a map along each side
uniform float shadow_range;  // from depth 0 to 1, in renderer units
uniform mat4x3 light[LIGHTS];
uniform vec3 direction[LIGHTS];
uniform vec3 radiance[LIGHTS];
uniform int light_count;
uniform int ground_lights;   // the first of them, which light the ground
uniform float shadows;       // 1, or 0 for none
uniform float offset;        // how far a point is lifted off its surface before it is looked up
uniform vec4 ground;         // up, height
uniform vec3 plain_srgb;     // the colour that leaves the ball's as they are
uniform int factor;          // samples per pixel along each side

float depth_from_light(int i, vec3 q) {
  ivec2 texel = clamp(ivec2(q.xy * shadow_size), ivec2(0), ivec2(int(shadow_size) - 1));
  return texelFetch(shadow_maps, ivec3(texel, i), 0).x;
}

// Lambert's clay with a dull sheen (GGX of roughness 0.45, Schlick's Fresnel with 0.04), by the cosines between normal, light and viewer: the half vector has the length 1 / s before it is a unit vector.
vec3 reflected(vec3 color, float nl, float nv, float lv) {
  float s = inversesqrt(max(2.0 + 2.0 * lv, 1e-4));
  float nh = clamp((nl + nv) * s, 0.0, 1.0);
  float lh = clamp((1.0 + lv) * s, 0.05, 1.0);
  const float a2 = 0.041;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float away = (1.0 - lh) * (1.0 - lh);
  float f = 0.04 + 0.96 * away * away * (1.0 - lh);
  return (color + vec3(f * a2 / (4.0 * d * d * max(lh * lh, 0.1)))) * nl;
}

// Moves every point a little along the surface, so that the edges of single shadows become soft. Interleaved gradient
// noise: Jimenez, "Next generation post processing in Call of Duty" (2014).
vec3 shifted(vec3 p, vec3 n, vec2 at) {
  float turn = 6.2831853 * gradient_noise(at);
  float r = 1.5 * offset * sqrt(gradient_noise(at.yx + 17.0));
  vec3 t = normalize(cross(n, abs(n.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
  return p + r * (cos(turn) * t + sin(turn) * cross(n, t));
}

vec3 lit_by_lamps(vec3 p, vec3 n, vec3 v, vec3 color, vec2 at) {
  vec3 q = shifted(p + offset * n, n, at);
  float nv = dot(n, v);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < light_count; ++i) {
    float nl = dot(n, direction[i]);
    if (nl <= 0.0) continue;
    if (shadows > 0.5) {
      vec3 s = light[i] * vec4(q, 1.0);
      if (depth_from_light(i, s) < s.z) continue;
    }
    sum += radiance[i] * reflected(color, nl, nv, dot(direction[i], v));
  }
  return sum;
}

vec3 colour_of_ball(vec3 n, vec3 ray, vec3 color) {
  vec3 x = normalize(cross(ray, top));
  vec3 y = cross(x, ray);
  return linear(texture(ball, 0.5 + 0.49 * vec2(dot(n, x), dot(n, y))).rgb) * color / linear(plain_srgb);
}

// The light that comes from the shape in this sample.
vec3 shape_light(ivec2 texel) {
  vec2 at = vec2(texel) + 0.5;
  float depth = texelFetch(depth_map, texel, 0).x;
  vec3 p = place_of(at, depth);
  vec3 ray = normalize(ray_direction(at));
  vec3 n = normalize(texelFetch(normal_map, texel, 0).xyz);
  vec3 facing = n;
  if (dot(n, ray) > 0.0) n = normalize(n - 1.02 * dot(n, ray) * ray);  // interpolated normals may lean away
  vec3 color = texelFetch(reflectance_map, texel, 0).rgb;
  color *= color;
#ifdef MATCAP
  vec3 seen = colour_of_ball(n, ray, color);
#else
  vec3 seen = lit_by_lamps(p, n, -ray, color, at);
#endif
#ifdef CAVITY
  seen *= cavity(texel, p, facing, -ray, size_at(depth));
#endif
#ifdef OCCLUSION
  seen *= occlusion(at, p, facing, size_at(depth), 32, 6.2831853 * gradient_noise(at));
#endif
  return seen;
}

// Grazing light counts for less than it should: its shadows are long and tell little.
float ground_weight(int i) {
  float nl = max(dot(ground.xyz, direction[i]) - GRAZING, 0.0);
  return nl * nl * dot(radiance[i], vec3(0.3, 0.6, 0.1));
}

// The light that the ground lacks here, so that ground without shadow is exactly the background; and before it that
// light times the distance of what blocks it.
vec2 missing_light(vec2 at) {
  vec3 origin = ray_origin(at);
  vec3 ray = ray_direction(at);
  float down = dot(ground.xyz, ray);
  float t = (ground.w - dot(ground.xyz, origin)) / down;
  vec2 sum = vec2(0.0);
  if (down > -1e-4 || t <= 0.0) return sum;
  vec3 p = origin + t * ray + offset * ground.xyz;
  for (int i = 0; i < ground_lights; ++i) {
    float weight = ground_weight(i);
    vec3 q = light[i] * vec4(p, 1.0);
    if (any(greaterThan(abs(q.xy - 0.5), vec2(0.5)))) continue;
    float gap = q.z - depth_from_light(i, q);
    if (gap > 0.0) sum += weight * vec2(gap * shadow_range, 1.0);
  }
  return sum;
}
)";

// One texel for each pixel, or each sample.
const char* const kShapeLightFragment = R"(
uniform int spacing;  // samples from texel to texel
out vec4 lit;
void main() { lit = vec4(shape_light(ivec2(gl_FragCoord.xy) * spacing + spacing / 2), 1.0); }
)";

// One texel for 2 x 2 pixels: what becomes of it is smooth.
const char* const kGroundLightFragment = R"(
out vec4 missing;  // as missing_light; alpha: 1
void main() { missing = vec4(missing_light(vec2(ivec2(gl_FragCoord.xy) * 2 * factor) + float(factor)), 0.0, 1.0); }
)";

// What is left of these is marked in the stencil, so that the slow programs run nowhere else: a software driver runs
// both sides of every branch.
//
// Pixels that lie within one surface that hardly bends: their samples share one look at the lights.
const char* const kEvenFragment = R"(
uniform sampler2D reflectance_map;
uniform int factor;
void main() {
  ivec2 corner = ivec2(gl_FragCoord.xy) * factor;
  ivec2 middle = corner + factor / 2;
  float depth = texelFetch(depth_map, middle, 0).x;
  vec3 n = texelFetch(normal_map, middle, 0).xyz;
  vec3 p = place_of(vec2(middle) + 0.5, depth);
  vec3 color = texelFetch(reflectance_map, middle, 0).rgb;
  float limit = 1.5 * float(factor) * size_at(depth);
  bool even = depth < 1.0;
  for (int y = 0; y < factor; ++y) {
    for (int x = 0; x < factor; ++x) {
      ivec2 texel = corner + ivec2(x, y);
      float other = texelFetch(depth_map, texel, 0).x;
      vec3 difference = abs(texelFetch(reflectance_map, texel, 0).rgb - color);
      even = even && other < 1.0 && dot(texelFetch(normal_map, texel, 0).xyz, n) > 0.93 &&
             abs(dot(place_of(vec2(texel) + 0.5, other) - p, n)) < limit &&
             max(difference.r, max(difference.g, difference.b)) < 0.03;
    }
  }
  if (!even) discard;
}
)";

// The samples of shapes in other pixels.
const char* const kUnevenFragment = R"(
uniform sampler2D depth_map, pixel_map;
uniform int factor;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  if (texelFetch(pixel_map, texel / factor, 0).a > 0.5 || texelFetch(depth_map, texel, 0).x == 1.0) discard;
}
)";

// Squares of 2 x 2 pixels in which a sample sees the ground.
const char* const kSeesGroundFragment = R"(
uniform sampler2D depth_map;
uniform int factor;
void main() {
  ivec2 corner = ivec2(gl_FragCoord.xy) * 2 * factor;
  bool sees_ground = false;
  for (int y = 0; y < 2 * factor; ++y) {
    for (int x = 0; x < 2 * factor; ++x) {
      ivec2 texel = min(corner + ivec2(x, y), ivec2(samples) - 1);
      sees_ground = sees_ground || texelFetch(depth_map, texel, 0).x == 1.0;
    }
  }
  if (!sees_ground) discard;
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
  vec3 m = normalize(shape.xyz);
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

// The samples are multiplied by alpha. Rows are turned over: pictures begin at the top. The filter is a tent of one
// pixel to either side.
const char* const kResolveFragment = R"(
uniform sampler2D samples_map;
uniform int factor;
uniform int height;
out vec4 pixel;
vec3 srgb_of(vec3 c) {
  return mix(12.92 * c, 1.055 * pow(max(c, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), c));
}
void main() {
  ivec2 corner = ivec2(int(gl_FragCoord.x), height - 1 - int(gl_FragCoord.y)) * factor;
  ivec2 last = textureSize(samples_map, 0) - 1;
  vec4 sum = vec4(0.0);
  float weight = 0.0;
  for (int y = 1 - factor; y < 2 * factor - 1; ++y) {
    for (int x = 1 - factor; x < 2 * factor - 1; ++x) {
      ivec2 at = clamp(corner + ivec2(x, y), ivec2(0), last);
      vec2 w = 1.0 - abs((vec2(x, y) + 0.5) / float(factor) - 0.5);
      sum += w.x * w.y * texelFetch(samples_map, at, 0);
      weight += w.x * w.y;
    }
  }
  sum /= weight;
  vec3 c = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
  pixel = vec4(srgb_of(clamp(c, 0.0, 1.0)), sum.a);
}
)";

void replace_all(std::string& text, const std::string& name, const std::string& value) {
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) {
    text.replace(at, name.size(), value);
  }
}

std::string with_constants(std::string source) {
  replace_all(source, "LIGHTS", std::to_string(kLightsPerPass));
  replace_all(source, "GRAZING", std::to_string(kGrazingCosine));
  return source;
}

ShaderSource surface_program(const char* fragment) {
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
ShaderSource cap_source() { return surface_program(kCapFragment); }
ShaderSource disc_source() { return surface_program(kDiscFragment); }
ShaderSource shape_light_source(const ShapeLook& look) {
  const std::string defines = std::string(look.matcap ? "#define MATCAP\n" : "") +
                              (look.cavity ? "#define CAVITY\n" : "") + (look.occlusion ? "#define OCCLUSION\n" : "");
  return full_screen_program(defines + with_constants(std::string(kRelief) + kLightInputs + kShapeLightFragment));
}
ShaderSource ground_light_source() {
  return full_screen_program(with_constants(std::string(kRelief) + kLightInputs + kGroundLightFragment));
}
ShaderSource even_source() { return full_screen_program(std::string(kRelief) + kEvenFragment); }
ShaderSource uneven_source() { return full_screen_program(kUnevenFragment); }
ShaderSource sees_ground_source() { return full_screen_program(kSeesGroundFragment); }
ShaderSource rod_source() { return simple_program(kRodFragment); }
ShaderSource glass_source() { return simple_program(kGlassFragment); }
ShaderSource copy_source() { return full_screen_program(kCopyFragment); }
ShaderSource resolve_source() { return full_screen_program(kResolveFragment); }

}  // namespace knead::render
