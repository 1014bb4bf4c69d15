// GLSL 3.30 that several programs share.
#pragma once

namespace knead::render {

inline constexpr const char* kVersion = "#version 330 core\n";

// How a sample of the picture becomes a ray, and a depth becomes a point on it (view.h).
inline constexpr const char* kView = R"(
uniform vec3 eye, forward, side, top;
uniform vec2 range;        // near, far
uniform float perspective;
uniform vec2 samples;      // of the picture, wide and high

vec3 screen_offset(vec2 at) {
  vec2 p = 2.0 * at / samples - 1.0;
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

// The light of things that neither cast nor catch shadows: a sky and the key light.
inline constexpr const char* kSimpleLight = R"(
uniform vec3 sky_up, key;
float diffuse(vec3 n) { return 0.52 + 0.18 * dot(n, sky_up) + 0.5 * max(dot(n, key), 0.0); }
float shine(vec3 n, vec3 v, float power) { return pow(max(dot(n, normalize(key + v)), 0.0), power); }
)";

}  // namespace knead::render
