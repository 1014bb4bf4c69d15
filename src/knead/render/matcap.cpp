#include "knead/render/matcap.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace knead::render {
namespace {

// A lamp as wide as `softness`: 0 lights the half of the ball, 1 all of it.
struct Lamp {
  Vec3d direction;
  Vec3d radiance;
  double softness = 0;
};

// x to the right, y up, z to the viewer.
Vec3d light_at(const Vec3d& n) {
  const std::array<Lamp, 4> lamps{{{{-0.45, 0.62, 0.64}, {0.66, 0.63, 0.59}, 0.15},
                                   {{0.85, 0.10, 0.45}, {0.13, 0.15, 0.19}, 0.3},
                                   {{0.10, -0.95, 0.10}, {0.12, 0.09, 0.07}, 0.5},
                                   {{0.0, 0.25, 0.97}, {0.16, 0.165, 0.17}, 0.4}}};
  Vec3d sum{0.035, 0.034, 0.036};
  for (const Lamp& lamp : lamps) {
    const double cosine = (dot(n, normalized(lamp.direction)) + lamp.softness) / (1 + lamp.softness);
    sum += lamp.radiance * std::pow(std::max(0.0, cosine), 1 + lamp.softness);
  }
  return sum;
}

// Two soft shines: the window that the key light is, and the sky at the outline.
Vec3d shine_at(const Vec3d& n) {
  const Vec3d halfway = normalized(normalized(Vec3d{-0.45, 0.62, 0.64}) + Vec3d{0, 0, 1});
  const double gloss = std::pow(std::max(0.0, dot(n, halfway)), 28);
  const double edge = std::pow(1 - std::clamp(n.z, 0.0, 1.0), 3.5);
  return Vec3d{1, 0.98, 0.95} * (0.085 * gloss) + Vec3d{0.55, 0.62, 0.72} * (0.10 * edge * (0.5 + 0.5 * n.y));
}

}  // namespace

std::vector<Bytes4> matcap_picture(int size) {
  std::vector<Bytes4> picture;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      // The shaders look between 0.01 and 0.99 of each side.
      double x = (2 * (column + 0.5) / size - 1) / 0.98;
      double y = (2 * (row + 0.5) / size - 1) / 0.98;
      const double length = std::hypot(x, y);
      if (length > 1) {
        x /= length;
        y /= length;
      }
      const Vec3d n{x, y, std::sqrt(std::max(0.0, 1 - x * x - y * y))};
      const Vec3d c = light_at(n) + shine_at(n);
      const auto shown = [](double value) { return static_cast<float>(std::sqrt(value)); };
      picture.push_back(to_bytes({shown(c.x), shown(c.y), shown(c.z), 1}));
    }
  }
  return picture;
}

}  // namespace knead::render
