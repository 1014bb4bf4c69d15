// The normals of many drawn vertices at once, in loops that compilers vectorise.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "render/live/live.h"

namespace knead::render {
namespace {

constexpr std::size_t kBatch = 1024;  // entries of rings, which fit into the fastest cache

// Vectors by their components.
struct Vectors {
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> z;

  void resize(std::size_t count) {
    x.resize(count);
    y.resize(count);
    z.resize(count);
  }
  void set(std::size_t i, const Vec3f& v) {
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
  }
};

// Finds the edges from each vertex to those around it; zero between chains, so that missing corners add nothing.
void gather_edges(const Rings& rings, std::span<const Vec3f> points, const VertexRange& drawn,
                  const std::vector<LiveVertex>& vertices, Vectors& edges) {
  const std::size_t first = rings.begin[drawn.begin];
  for (std::size_t d = drawn.begin; d < drawn.end; ++d) {
    const Vec3f p = vertices[d].position;
    for (std::size_t i = rings.begin[d]; i < rings.begin[d + 1]; ++i) {
      edges.set(i - first, rings.list[i] == kNoVertex ? Vec3f{} : points[rings.list[i]] - p);
    }
  }
}

// Scales all vectors to length 1; those of almost zero to zero.
void normalize_all(Vectors& v, std::size_t count) {
  float* const x = v.x.data();
  float* const y = v.y.data();
  float* const z = v.z.data();
  for (std::size_t i = 0; i < count; ++i) {
    const float scale = 1.0f / std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i] + 1e-30f);
    x[i] *= scale;
    y[i] *= scale;
    z[i] *= scale;
  }
}

// Finds the cross product of each edge with the next, scaled from sin(angle) to about the angle by a polynomial in the
// cosine.
void make_corners(const Vectors& edges, std::size_t count, Vectors& corners) {
  const float* const ex = edges.x.data();
  const float* const ey = edges.y.data();
  const float* const ez = edges.z.data();
  float* const cx = corners.x.data();
  float* const cy = corners.y.data();
  float* const cz = corners.z.data();
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const float c = ex[i] * ex[i + 1] + ey[i] * ey[i + 1] + ez[i] * ez[i + 1];
    const float weight = 1.5708f + c * (-1.0f + c * (0.55f - 0.12f * c));
    cx[i] = (ey[i] * ez[i + 1] - ez[i] * ey[i + 1]) * weight;
    cy[i] = (ez[i] * ex[i + 1] - ex[i] * ez[i + 1]) * weight;
    cz[i] = (ex[i] * ey[i + 1] - ey[i] * ex[i + 1]) * weight;
  }
}

void add_up(const Rings& rings, const VertexRange& drawn, const Vectors& corners, Vectors& sums) {
  const std::size_t first = rings.begin[drawn.begin];
  for (std::size_t d = drawn.begin; d < drawn.end; ++d) {
    Vec3f sum;
    for (std::size_t i = rings.begin[d] - first; i + 1 < rings.begin[d + 1] - first; ++i) {
      sum += Vec3f{corners.x[i], corners.y[i], corners.z[i]};
    }
    sums.set(d - drawn.begin, sum);
  }
}

}  // namespace

void set_ring_normals(const Rings& rings, std::span<const Vec3f> points, const VertexRange& drawn,
                      std::vector<LiveVertex>& vertices) {
  Vectors edges;
  Vectors corners;
  Vectors sums;
  for (std::uint32_t begin = drawn.begin; begin < drawn.end;) {
    std::uint32_t end = begin + 1;
    while (end < drawn.end && rings.begin[end + 1] - rings.begin[begin] <= kBatch) ++end;
    const std::size_t count = rings.begin[end] - rings.begin[begin];
    if (edges.x.size() < count) {
      edges.resize(std::max(count, kBatch));
      corners.resize(std::max(count, kBatch));
    }
    sums.resize(end - begin);
    gather_edges(rings, points, {begin, end}, vertices, edges);
    normalize_all(edges, count);
    make_corners(edges, count, corners);
    add_up(rings, {begin, end}, corners, sums);
    normalize_all(sums, end - begin);
    for (std::uint32_t d = begin; d < end; ++d) {
      const Vec3f n{sums.x[d - begin], sums.y[d - begin], sums.z[d - begin]};
      const bool is_unit = n.x * n.x + n.y * n.y + n.z * n.z > 0.5f;
      vertices[d].normal = is_unit ? n : Vec3f{0, 0, 1};
    }
    begin = end;
  }
}

}  // namespace knead::render
