// The data of the lighting on the CPU: rays, shadow maps, and the shadow on the ground. Internal to render.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "knead/vec.h"
#include "render/offline/passes.h"

namespace knead::render {

inline constexpr float kTurn = 6.2831853F;
inline constexpr float kGoldenAngle = 2.3999632F;

inline float fraction(float x) { return x - std::floor(x); }
inline float unit_clamp(float x) { return std::clamp(x, 0.0F, 1.0F); }
inline float smooth_step(float from, float to, float x) {
  const float t = unit_clamp((x - from) / (to - from));
  return t * t * (3 - 2 * t);
}
inline float center(int i) { return static_cast<float>(i) + 0.5F; }  // of a sample or texel
inline float square(float x) { return x * x; }
inline float gradient_noise(float x, float y) {
  return fraction(52.9829189F * fraction(0.06711056F * x + 0.00583715F * y));
}

// Places of the picture as rays, and points on them (kView of surface.h).
struct Rays {
  explicit Rays(const Pass& pass)
      : eye(pass.view.eye),
        forward(pass.view.frame.forward),
        side(pass.view.side),
        top(pass.view.top),
        shift_x(static_cast<float>(pass.view.shift_x)),
        shift_y(static_cast<float>(pass.view.shift_y)),
        near(static_cast<float>(pass.view.near)),
        far(static_cast<float>(pass.view.far)),
        sample(static_cast<float>(pass.view.pixel)),
        width(static_cast<float>(pass.width)),
        height(static_cast<float>(pass.height)),
        perspective(pass.view.perspective) {}

  Vec3f offset(float x, float y) const {
    return side * (2 * x / width - 1 - shift_x) + top * (2 * y / height - 1 - shift_y);
  }
  Vec3f origin(float x, float y) const { return perspective ? eye : eye + offset(x, y); }
  Vec3f direction(float x, float y) const { return perspective ? forward + offset(x, y) : forward; }
  float distance(float depth) const {
    return perspective ? near * far / (far - depth * (far - near)) : near + depth * (far - near);
  }
  Vec3f place(float x, float y, float depth) const { return origin(x, y) + direction(x, y) * distance(depth); }
  float size(float depth) const { return perspective ? sample * distance(depth) : sample; }

  Vec3f eye, forward, side, top;
  float shift_x, shift_y, near, far, sample, width, height;
  bool perspective;
};

// The samples that the GPU has drawn, and the lights' maps. Rows are counted from the bottom up, as in OpenGL.
struct Drawn {
  Drawn(const Pass& of, const Samples& samples_of, const Lighting& lights);

  // The index of a sample in the part that is drawn. Outside of it the depth is 1, as without a shape.
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - pass.part.bottom) * pass.part.width + (x - pass.part.left);
  }
  float depth_at(int x, int y) const { return pass.part.contains(x, y) ? samples.depth[index(x, y)] : 1; }
  Vec3f normal_at(int x, int y) const;
  Vec3f place_at(int x, int y) const { return rays.place(center(x), center(y), depth_at(x, y)); }
  const std::uint16_t* map(std::size_t light) const { return maps.get() + light * kShadowMapSize * kShadowMapSize; }

  const Pass& pass;
  const Samples& samples;
  const Lighting& lighting;
  Rays rays;
  int factor;                             // samples per pixel along each side
  float lift;                             // off the surface, before a point is looked up
  std::vector<LightMatrix> matrices;      // by light
  std::unique_ptr<std::uint16_t[]> maps;  // one light after the other; null: no shadows
};

// Places that are looked up in a light's map together.
inline constexpr std::size_t kLanes = 64;
using Lane = std::array<float, kLanes>;
struct MapPlaces {
  std::array<Lane, 3> q;
  Lane depth;                       // from 0 to 65535
  std::array<int, kLanes> nearest;  // the map's depth there
};

// Sets the depths. A place beside the map gets a texel of its border, which is empty.
void look_up(const LightMatrix& light, const std::uint16_t* map, MapPlaces& places);

// The shadow on the ground, with one texel for 2 x 2 pixels or more: it is smooth.
class Ground {
 public:
  explicit Ground(const Drawn& drawn);

  // Returns the darkness between the texels that see the ground, from 0 to 1, at a place in samples.
  float darkness_at(float x, float y) const;

 private:
  static constexpr float kUnseen = -1;  // where shapes hide the ground, and around the picture

  // Of a texel; x and y may lie one beyond the picture.
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y + 1) * (width_ + 2) + (x + 1); }
  bool is_seen(std::size_t texel) const { return missing_[texel] != kUnseen; }
  bool sees_ground(int x, int y) const;
  std::optional<Vec3f> ground_at(int x, int y) const;
  struct Batch;
  static void add_missing(float weight, Batch& batch);
  void shade(Batch& batch);
  void shade_rows(int first, int last);
  void darken_row(int y);
  float smoothed(int x, int y, const Vec3f& p) const;

  const Drawn& drawn_;
  Vec3f up_;
  int step_;  // samples from texel to texel
  int width_;
  int height_;
  std::vector<float> weights_;   // by light
  float light_ = 0;              // without shadow
  std::vector<float> missing_;   // the light that a texel lacks
  std::vector<float> distance_;  // and that light times the distance of what blocks it
  std::vector<float> darkness_;
};

}  // namespace knead::render
