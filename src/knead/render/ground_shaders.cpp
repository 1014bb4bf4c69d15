#include "knead/render/shader_pieces.h"
#include "knead/render/shaders.h"

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

}  // namespace knead::render
