// For tests of pictures: whether OpenGL is there, shapes, and pixels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/mesh.h"

namespace knead::render {

// Returns the reason why there is no OpenGL here, or an empty string. Tries once: contexts are slow to make.
inline const std::string& no_context() {
  static const std::string reason = [] {
    try {
      std::printf("OpenGL: %s\n", gl::OffscreenContext().description().c_str());
      return std::string();
    } catch (const GpuError& error) {
      return std::string(error.what());
    }
  }();
  return reason;
}

struct Pixel {
  int red;
  int green;
  int blue;
  int alpha;
};

inline Pixel at(const Image& image, int x, int y) {
  const std::uint8_t* p = image.pixels.data() + 4 * (static_cast<std::size_t>(y) * image.width + x);
  return {p[0], p[1], p[2], p[3]};
}

inline Mesh sphere(const Vec3d& center, double radius, std::size_t vertices = 2562) {
  Mesh mesh = make_shape(ShapeKind::sphere, vertices);
  for (Vec3d& p : mesh.positions) p = center + p * radius;
  return mesh;
}

inline Mesh cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.push_back({(i & 1) * 2.0 - 1, (i & 2) - 1.0, (i & 4) / 2.0 - 1});
  for (const auto& face : {std::array{0u, 2u, 3u, 1u},
                           {4u, 5u, 7u, 6u},
                           {0u, 1u, 5u, 4u},
                           {2u, 6u, 7u, 3u},
                           {0u, 4u, 6u, 2u},
                           {1u, 3u, 7u, 5u}}) {
    mesh.add_face(face);
  }
  return mesh;
}

inline VertexRange all_of(const Mesh& mesh) { return {0, static_cast<std::uint32_t>(mesh.vertex_count())}; }

// The mesh with a dent whose centre is at its first vertex, and the ranges of vertices that it moves.
inline std::vector<VertexRange> dent(Mesh& mesh, double radius) {
  const Vec3d center = mesh.positions.front();
  std::vector<VertexRange> ranges;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const double r = norm(mesh.positions[v] - center) / radius;
    if (r >= 1) continue;
    mesh.positions[v] = mesh.positions[v] - normalized(center) * (0.3 * radius * (1 - r * r) * (1 - r * r));
    if (!ranges.empty() && ranges.back().end == v) {
      ranges.back().end = v + 1;
    } else {
      ranges.push_back({v, v + 1});
    }
  }
  return ranges;
}

}  // namespace knead::render
