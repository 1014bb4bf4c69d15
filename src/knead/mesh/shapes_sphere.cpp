#include <array>
#include <cmath>

#include "knead/mesh/shapes_grids.h"

namespace knead::shapes_detail {
namespace {

constexpr double kGolden = 1.6180339887498948482;
constexpr std::array<Vec3d, 12> kCorners{{{-1, kGolden, 0},
                                          {1, kGolden, 0},
                                          {-1, -kGolden, 0},
                                          {1, -kGolden, 0},
                                          {0, -1, kGolden},
                                          {0, 1, kGolden},
                                          {0, -1, -kGolden},
                                          {0, 1, -kGolden},
                                          {kGolden, 0, -1},
                                          {kGolden, 0, 1},
                                          {-kGolden, 0, -1},
                                          {-kGolden, 0, 1}}};
constexpr std::array<std::array<std::size_t, 3>, 20> kFaces{
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

// The icosahedron with every edge cut into n parts; vertices are made at their first use.
class Geodesic {
 public:
  explicit Geodesic(std::size_t n) : n_(n) {
    for (const Vec3d& p : kCorners) mesh_.positions.push_back(normalized(p));
    edge_start_.fill(0);
  }

  Mesh make() {
    for (const auto& face : kFaces) add_face(face);
    return std::move(mesh_);
  }

 private:
  // Returns the k-th of the n + 1 vertices from corner a to corner b.
  std::size_t on_edge(std::size_t a, std::size_t b, std::size_t k) {
    if (k == 0) return a;
    if (k == n_) return b;
    if (a > b) return on_edge(b, a, n_ - k);
    std::size_t& start = edge_start_[12 * a + b];
    if (start == 0) {
      start = mesh_.vertex_count();
      for (std::size_t i = 1; i < n_; ++i) add_vertex(kCorners[a], kCorners[b], kCorners[b], i, 0);
    }
    return start + k - 1;
  }

  void add_vertex(const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t i, std::size_t j) {
    const double n = static_cast<double>(n_);
    const double u = static_cast<double>(i) / n;
    const double v = static_cast<double>(j) / n;
    mesh_.positions.push_back(normalized(a * (1 - u - v) + b * u + c * v));
  }

  void add_face(const std::array<std::size_t, 3>& face) {
    const auto [a, b, c] = face;
    std::vector<std::size_t> below;
    for (std::size_t i = 0; i <= n_; ++i) below.push_back(on_edge(a, b, i));
    for (std::size_t j = 1; j <= n_; ++j) {
      std::vector<std::size_t> row{on_edge(a, c, j)};
      for (std::size_t i = 1; i + j < n_; ++i) {
        row.push_back(mesh_.vertex_count());
        add_vertex(kCorners[a], kCorners[b], kCorners[c], i, j);
      }
      if (j < n_) row.push_back(on_edge(b, c, j));
      for (std::size_t i = 0; i < row.size(); ++i) {
        add_triangle(mesh_, below[i], below[i + 1], row[i]);
        if (i + 1 < row.size()) add_triangle(mesh_, below[i + 1], row[i + 1], row[i]);
      }
      below = std::move(row);
    }
  }

  std::size_t n_;
  Mesh mesh_;
  std::array<std::size_t, 144> edge_start_{};  // 0: not made yet
};

}  // namespace

Mesh make_sphere(std::size_t vertices) {
  const double frequency = std::sqrt((static_cast<double>(vertices) - 2) / 10);
  std::size_t n = static_cast<std::size_t>(frequency);
  const auto excess = [&](std::size_t k) {
    return std::abs(10.0 * static_cast<double>(k * k) + 2 - static_cast<double>(vertices));
  };
  if (excess(n + 1) < excess(n)) ++n;
  return Geodesic(n).make();
}

}  // namespace knead::shapes_detail
