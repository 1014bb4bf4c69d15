#include "knead/render/shadow_map.h"

#include <algorithm>
#include <cmath>

#include "knead/math/parallel.h"

namespace knead::render {
namespace {

constexpr float kFarthest = 65535;
constexpr float kSlopeShift = 1.5f;

// In texels across, and in steps of depth.
struct MapPoint {
  float x;
  float y;
  float z;
};

struct Map {
  int size;
  std::uint16_t* depths;

  void put(int x, int y, float z) const {
    std::uint16_t& depth = depths[static_cast<std::ptrdiff_t>(y) * size + x];
    depth = std::min(depth, static_cast<std::uint16_t>(std::clamp(z, 0.0f, kFarthest)));
  }

  // The texels whose centres lie in [from, to]: first and one past the last.
  int first(float from) const { return std::max(0, static_cast<int>(std::ceil(std::max(from, -1.0f) - 0.5f))); }
  int end(float to) const {
    return std::min(size, static_cast<int>(std::floor(std::min(to, static_cast<float>(size)) - 0.5f)) + 1);
  }
};

MapPoint place(const LightMatrix& m, const Vec3f& p, float size) {
  const auto row = [&](std::size_t i) { return m[i] * p.x + m[3 + i] * p.y + m[6 + i] * p.z + m[9 + i]; };
  return {row(0) * size, row(1) * size, row(2) * kFarthest};
}

// The part of a row that lies within the triangle.
struct Span {
  float from;
  float to;

  // Keeps what lies on the side of the edge from a to b where the third corner is (sign > 0: left).
  void cut(const MapPoint& a, const MapPoint& b, float y, float sign) {
    const float dx = (b.x - a.x) * sign;
    const float dy = (b.y - a.y) * sign;
    // dx * (y - a.y) - dy * (x - a.x) >= 0
    if (dy == 0) {
      if (dx * (y - a.y) < 0) to = -1;
      return;
    }
    const float x = a.x + dx * (y - a.y) / dy;
    if (dy > 0) {
      to = std::min(to, x);
    } else {
      from = std::max(from, x);
    }
  }
};

void draw_triangle(const Map& map, const MapPoint& a, const MapPoint& b, const MapPoint& c) {
  const int top = map.first(std::min({a.y, b.y, c.y}));
  const int bottom = map.end(std::max({a.y, b.y, c.y}));
  const float left = std::min({a.x, b.x, c.x});
  const float right = std::max({a.x, b.x, c.x});
  if (top >= bottom || map.first(left) >= map.end(right)) return;
  const float twice_area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (twice_area == 0) return;
  const float slope_x = ((b.z - a.z) * (c.y - a.y) - (c.z - a.z) * (b.y - a.y)) / twice_area;
  const float slope_y = ((c.z - a.z) * (b.x - a.x) - (b.z - a.z) * (c.x - a.x)) / twice_area;
  const float shift = kSlopeShift * std::max(std::abs(slope_x), std::abs(slope_y));
  const float nearest = std::min({a.z, b.z, c.z});
  const float sign = twice_area > 0 ? 1.0f : -1.0f;
  for (int row = top; row < bottom; ++row) {
    const float y = static_cast<float>(row) + 0.5f;
    Span span{left, right};
    span.cut(a, b, y, sign);
    span.cut(b, c, y, sign);
    span.cut(c, a, y, sign);
    const int end = map.end(span.to);
    for (int column = map.first(span.from); column < end; ++column) {
      const float z = a.z + slope_x * (static_cast<float>(column) + 0.5f - a.x) + slope_y * (y - a.y);
      map.put(column, row, std::max(z, nearest) + shift);
    }
  }
}

void draw_point(const Map& map, const MapPoint& p, float radius) {
  const int right = std::max(map.end(p.x + radius), std::clamp(static_cast<int>(p.x), 0, map.size - 1) + 1);
  const int bottom = std::max(map.end(p.y + radius), std::clamp(static_cast<int>(p.y), 0, map.size - 1) + 1);
  for (int y = std::min(map.first(p.y - radius), bottom - 1); y < bottom; ++y) {
    for (int x = std::min(map.first(p.x - radius), right - 1); x < right; ++x) map.put(x, y, p.z);
  }
}

void draw_map(const Occluder& occluder, const LightMatrix& light, const Map& map, double point_radius) {
  const auto size = static_cast<float>(map.size);
  std::vector<MapPoint> places(occluder.positions.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = place(light, occluder.positions[i], size);
  for (std::size_t i = 0; i < occluder.indices.size(); i += 3) {
    draw_triangle(map, places[occluder.indices[i]], places[occluder.indices[i + 1]], places[occluder.indices[i + 2]]);
  }
  const auto radius = static_cast<float>(0.5 * point_radius / occluder.radius * map.size);
  for (const Vec3f& p : occluder.points) draw_point(map, place(light, p, size), radius);
}

}  // namespace

std::vector<std::uint16_t> draw_shadow_maps(const Occluder& occluder, std::span<const LightMatrix> lights, int size,
                                            double point_radius) {
  const std::size_t texels = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  std::vector<std::uint16_t> depths(texels * lights.size(), static_cast<std::uint16_t>(kFarthest));
  parallel_for(lights.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      draw_map(occluder, lights[i], {size, depths.data() + i * texels}, point_radius);
    }
  });
  return depths;
}

}  // namespace knead::render
