// Splats on the surface of a mesh, and how far two pictures are apart.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/editor/render.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "math/geometry.h"

namespace knead::render {

inline void add(Mesh& mesh, const std::string& name, std::vector<double> values) {
  mesh.attributes.push_back({name, Domain::vertex, NumberType::float32, 1, std::move(values)});
}

// The mean of the squared differences of pixels.
inline double error_of(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::pow(a.pixels[i] - b.pixels[i], 2);
  return sum / static_cast<double>(a.pixels.size());
}

inline double psnr(double error) { return 10 * std::log10(255.0 * 255 / error); }

// A point of a triangle.
struct Sample {
  std::uint32_t triangle = 0;
  double u = 0;
  double v = 0;
};

inline std::vector<Sample> samples_of(const Mesh& mesh, std::span<const Triangle> triangles, std::size_t count) {
  std::vector<double> areas;
  for (const Triangle& t : triangles) {
    const Vec3d& a = mesh.positions[t[0]];
    areas.push_back(norm(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)));
  }
  std::mt19937 random(1);
  std::discrete_distribution<std::uint32_t> triangle(areas.begin(), areas.end());
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    Sample sample{triangle(random), part(random), part(random)};
    if (sample.u + sample.v > 1) sample = {sample.triangle, 1 - sample.u, 1 - sample.v};
    samples.push_back(sample);
  }
  return samples;
}

// A triangle's edges, and its normal with the length that keeps the volume.
inline std::array<Vec3d, 3> frame_of(const Mesh& mesh, const Triangle& t) {
  const Vec3d a = mesh.positions[t[1]] - mesh.positions[t[0]];
  const Vec3d b = mesh.positions[t[2]] - mesh.positions[t[0]];
  const Vec3d n = cross(a, b);
  return {a, b, n / norm2(n)};
}

inline Vec3d place_of(const Mesh& mesh, const Triangle& t, const Sample& sample) {
  const std::array<Vec3d, 3> frame = frame_of(mesh, t);
  return mesh.positions[t[0]] + frame[0] * sample.u + frame[1] * sample.v;
}

inline Mat3d with_columns(const std::array<Vec3d, 3>& c) {
  return {{c[0].x, c[1].x, c[2].x}, {c[0].y, c[1].y, c[2].y}, {c[0].z, c[1].z, c[2].z}};
}

// Thin discs on the surface, with a texture of stripes and a colour that depends on the direction.
inline Mesh cover(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const Sample> samples) {
  const Box box = shape_box(mesh);
  Mesh splats;
  std::array<std::vector<double>, 4> turns;
  std::array<std::vector<double>, 3> colors;
  for (const Sample& sample : samples) {
    const Triangle& t = triangles[sample.triangle];
    const Vec3d p = place_of(mesh, t, sample);
    const Vec3d n = normalized(frame_of(mesh, t)[2]);
    std::array<double, 4> q{1 + n.z, -n.y, n.x, 0};  // takes z to the normal
    if (q[0] < 1e-6) q = {0, 1, 0, 0};
    const double size = std::hypot(q[0], q[1], q[2]);
    for (std::size_t k = 0; k < 4; ++k) turns[k].push_back(q[k] / size);
    for (std::size_t k = 0; k < 3; ++k) colors[k].push_back(1.5 * std::sin(40 * (p[k] - box.min[k]) / box.diagonal()));
    splats.positions.push_back(p);
  }
  double area = 0;
  for (const Triangle& t : triangles) area += 0.5 / norm(frame_of(mesh, t)[2]);
  const double size = std::sqrt(area / static_cast<double>(samples.size()));
  const std::size_t count = samples.size();
  for (int i = 0; i < 3; ++i) {
    add(splats, fmt::format("scale_{}", i), std::vector<double>(count, std::log(size * (i == 2 ? 0.1 : 1))));
  }
  for (std::size_t i = 0; i < 4; ++i) add(splats, fmt::format("rot_{}", i), turns[i]);
  for (std::size_t i = 0; i < 3; ++i) add(splats, fmt::format("f_dc_{}", i), colors[i]);
  for (int i = 0; i < 9; ++i) add(splats, fmt::format("f_rest_{}", i), std::vector<double>(count, 0.3 - 0.07 * i));
  add(splats, "opacity", std::vector<double>(count, 3));
  return splats;
}

}  // namespace knead::render
