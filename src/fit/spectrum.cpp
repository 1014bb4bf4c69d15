// Assembles the Laplacian of a surface by cotangents, and finds its lowest eigenfunctions.
#include "fit/functional_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "fit/coarse_body.h"
#include "math/sparse_cholesky.h"
#include "mesh/body_points.h"
#include "mesh/edges.h"

#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_MPL2_ONLY
#include <Eigen/OrderingMethods>

namespace knead::detail {

namespace {

constexpr std::size_t kMaxNodes = 6000;
constexpr std::size_t kCoarseNodes = 4000;
constexpr double kMinPieceShare = 0.7;    // of the area
constexpr double kMinSine = 1e-3;         // of a triangle's angles
constexpr double kShift = 1;              // of the eigenvalues, whose k-th is about 4 pi k
constexpr double kMaxResidual = 1e-6;     // of an eigenvalue's inverse
constexpr std::size_t kMoreVectors = 60;  // Lanczos' vectors beyond two for each eigenfunction
constexpr double kNoMoreVectors = 1e-12;

double area_of(std::span<const Vec3d> p, const Triangle& t) {
  return 0.5 * norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
}

// Returns the triangles of the piece with the greatest area, if it has most of it.
std::vector<Triangle> largest_piece(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  DisjointSets pieces(positions.size());
  for (const Triangle& t : triangles) {
    for (std::size_t i = 1; i < 3; ++i) pieces.join(t[0], t[i]);
  }
  std::vector<double> area(positions.size(), 0);
  double total = 0;
  for (const Triangle& t : triangles) {
    area[pieces.find(t[0])] += area_of(positions, t);
    total += area_of(positions, t);
  }
  const auto largest = std::max_element(area.begin(), area.end());
  std::vector<Triangle> piece;
  if (area.empty() || !(*largest > kMinPieceShare * total)) return piece;
  for (const Triangle& t : triangles) {
    if (pieces.find(t[0]) == static_cast<std::uint32_t>(largest - area.begin())) piece.push_back(t);
  }
  return piece;
}

// Returns the triangles of the dual of the regions around chosen vertices.
std::vector<Triangle> coarsened(std::span<const Vec3d> positions, const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> vertices;
  for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  if (vertices.size() <= kMaxNodes) return triangles;
  std::vector<Vec3d> points;
  points.reserve(vertices.size());
  for (const std::uint32_t v : vertices) points.push_back(positions[v]);
  std::vector<std::uint32_t> chosen = spread_points(points, kCoarseNodes);
  for (std::uint32_t& v : chosen) v = vertices[v];
  const std::vector<std::uint32_t> region = nearest_along_edges(positions, triangles, chosen);
  std::vector<Triangle> result;
  for (const Triangle& t : triangles) {
    Triangle corners{chosen[region[t[0]]], chosen[region[t[1]]], chosen[region[t[2]]]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    result.push_back(corners);
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

// Numbers the vertices of the triangles anew, and sets the nodes, their masses and the triangles.
Spectrum nodes_of(std::span<const Vec3d> positions, std::vector<Triangle> triangles) {
  Spectrum s;
  std::vector<std::uint32_t> number(positions.size(), std::numeric_limits<std::uint32_t>::max());
  double area = 0;
  for (Triangle& t : triangles) {
    const double own = area_of(positions, t);
    area += own;
    for (std::uint32_t& v : t) {
      if (number[v] == std::numeric_limits<std::uint32_t>::max()) {
        number[v] = static_cast<std::uint32_t>(s.vertices.size());
        s.vertices.push_back(v);
        s.mass.push_back(0);
      }
      v = number[v];
      s.mass[v] += own / 3;
    }
  }
  // A node whose triangles have no area still counts.
  const double least = 1e-6 * area / static_cast<double>(std::max<std::size_t>(1, s.size()));
  for (double& m : s.mass) m = std::max(m, least) / area;
  s.triangles = std::move(triangles);
  return s;
}

struct Entry {
  std::array<std::uint32_t, 2> nodes;  // the smaller number first
  double value = 0;
};

// Returns the entries of the Laplacian off its diagonal, each pair of nodes once.
std::vector<Entry> couplings_of(const Spectrum& s, std::span<const Vec3d> positions) {
  std::vector<Entry> entries;
  for (const Triangle& t : s.triangles) {
    std::array<Vec3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = positions[s.vertices[t[i]]];
    const double longest = std::max({norm2(p[1] - p[0]), norm2(p[2] - p[1]), norm2(p[0] - p[2])});
    const double twice_area = std::max(norm(cross(p[1] - p[0], p[2] - p[0])), kMinSine * longest);
    if (!(twice_area > 0)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t k = (i + 1) % 3;
      const Vec3d& from = p[(i + 2) % 3];
      const double half_cotangent = 0.5 * dot(p[i] - from, p[k] - from) / twice_area;
      entries.push_back({{std::min(t[i], t[k]), std::max(t[i], t[k])}, -half_cotangent});
    }
  }
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.nodes < b.nodes; });
  std::vector<Entry> merged;
  for (const Entry& e : entries) {
    if (merged.empty() || merged.back().nodes != e.nodes) {
      merged.push_back(e);
    } else {
      merged.back().value += e.value;
    }
  }
  return merged;
}

// The inverse of the shifted Laplacian between vectors that are scaled by the roots of the masses.
class InverseLaplacian {
 public:
  InverseLaplacian(const Spectrum& s, const std::vector<Entry>& couplings, const Progress* progress)
      : place_(s.size()), root_(s.mass) {
    std::vector<Eigen::Triplet<double>> entries;
    std::vector<double> diagonal(s.size());
    for (std::size_t i = 0; i < s.size(); ++i) {
      root_[i] = std::sqrt(s.mass[i]);
      diagonal[i] = kShift * s.mass[i];
      entries.emplace_back(static_cast<int>(i), static_cast<int>(i), 1.0);
    }
    for (const Entry& e : couplings) {
      const auto a = static_cast<int>(e.nodes[0]);
      const auto b = static_cast<int>(e.nodes[1]);
      entries.emplace_back(a, b, 1.0);
      entries.emplace_back(b, a, 1.0);
      for (const std::uint32_t v : e.nodes) diagonal[v] -= e.value;
    }
    const auto size = static_cast<int>(s.size());
    Eigen::SparseMatrix<double> graph(size, size);
    graph.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>{}(graph, order);
    for (int at = 0; at < size; ++at) place_[static_cast<std::size_t>(order.indices()[at])] = at;
    is_definite_ = factor_.factorize(matrix_of(diagonal, couplings), 1, progress);
  }

  bool is_definite() const { return is_definite_; }

  std::vector<double> operator()(const std::vector<double>& x) const {
    std::vector<double> b(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) b[static_cast<std::size_t>(place_[i])] = root_[i] * x[i];
    factor_.solve(b);
    std::vector<double> y(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = root_[i] * b[static_cast<std::size_t>(place_[i])];
    return y;
  }

 private:
  SymmetricMatrix matrix_of(const std::vector<double>& diagonal, const std::vector<Entry>& couplings) const {
    std::vector<std::vector<std::pair<int, double>>> columns(diagonal.size());
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      columns[static_cast<std::size_t>(place_[i])].emplace_back(place_[i], diagonal[i]);
    }
    for (const Entry& e : couplings) {
      const auto [low, high] = std::minmax(place_[e.nodes[0]], place_[e.nodes[1]]);
      columns[static_cast<std::size_t>(low)].emplace_back(high, e.value);
    }
    SymmetricMatrix matrix;
    for (auto& column : columns) {
      std::sort(column.begin(), column.end());
      for (const auto& [row, value] : column) {
        matrix.rows.push_back(row);
        matrix.values.push_back(value);
      }
      matrix.begin.push_back(matrix.rows.size());
    }
    return matrix;
  }

  std::vector<int> place_;    // of a node in the factor
  std::vector<double> root_;  // of the masses
  SparseCholesky factor_;
  bool is_definite_ = false;
};

// Sums in four parts, always in the same order.
double dot_of(const std::vector<double>& a, const std::vector<double>& b) {
  std::array<double, 4> sums{};
  std::size_t i = 0;
  for (; i + 4 <= a.size(); i += 4) {
    for (std::size_t k = 0; k < 4; ++k) sums[k] += a[i + k] * b[i + k];
  }
  for (; i < a.size(); ++i) sums[0] += a[i] * b[i];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void add(std::vector<double>& to, const std::vector<double>& x, double factor) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * x[i];
}

// A tridiagonal matrix.
struct Tridiagonal {
  std::vector<double> diagonal;
  std::vector<double> beside;  // as many, the last one is not part of it
};

// Replaces the diagonal by the eigenvalues, and returns the eigenvectors, by the implicit QL method (Bowdler et al.
// 1968). They are in no order.
std::vector<std::vector<double>> diagonalize(Tridiagonal& matrix) {
  constexpr int kMaxRounds = 60;
  std::vector<double>& d = matrix.diagonal;
  std::vector<double>& e = matrix.beside;
  const std::size_t n = d.size();
  e.back() = 0;
  std::vector<std::vector<double>> vectors(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i) vectors[i][i] = 1;
  for (std::size_t low = 0; low < n; ++low) {
    for (int round = 0; round < kMaxRounds; ++round) {
      std::size_t high = low;
      const auto is_coupled = [&](std::size_t i) {
        return std::abs(e[i]) > std::numeric_limits<double>::epsilon() * (std::abs(d[i]) + std::abs(d[i + 1]));
      };
      while (high + 1 < n && is_coupled(high)) ++high;
      if (high == low) break;
      double g = (d[low + 1] - d[low]) / (2 * e[low]);
      double r = std::sqrt(g * g + 1);
      g = d[high] - d[low] + e[low] / (g + (g < 0 ? -r : r));
      double s = 1;
      double c = 1;
      double p = 0;
      bool is_split = false;
      for (std::size_t i = high; i-- > low && !is_split;) {
        const double f = s * e[i];
        const double b = c * e[i];
        r = std::sqrt(f * f + g * g);
        e[i + 1] = r;
        is_split = !(r > 0);
        if (is_split) {
          d[i + 1] -= p;
          e[high] = 0;
          break;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        r = (d[i] - g) * s + 2 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
        for (std::size_t k = 0; k < n; ++k) {
          const double x = vectors[i][k];
          const double y = vectors[i + 1][k];
          vectors[i][k] = c * x - s * y;
          vectors[i + 1][k] = s * x + c * y;
        }
      }
      if (is_split) continue;
      d[low] -= p;
      e[low] = g;
      e[high] = 0;
    }
  }
  return vectors;
}

// Lanczos' vectors, orthonormal, and the operator between them.
struct Krylov {
  std::vector<std::vector<double>> vectors;
  Tridiagonal matrix;
};

Krylov krylov_of(const InverseLaplacian& inverse, std::vector<double> start, std::size_t count,
                 const Progress* progress) {
  Krylov result;
  double size = std::sqrt(dot_of(start, start));
  while (result.vectors.size() < count && size > kNoMoreVectors) {
    stop_if_cancelled(progress);
    for (double& x : start) x /= size;
    result.vectors.push_back(std::move(start));
    start = inverse(result.vectors.back());
    result.matrix.diagonal.push_back(dot_of(start, result.vectors.back()));
    for (std::size_t i = result.vectors.size(); i-- > 0;) {
      add(start, result.vectors[i], -dot_of(start, result.vectors[i]));
    }
    size = std::sqrt(dot_of(start, start));
    result.matrix.beside.push_back(size);
  }
  return result;
}

// Returns a vector that no symmetry of the surface keeps.
std::vector<double> start_vector(const Spectrum& s, std::span<const Vec3d> positions) {
  Box box;
  for (const std::uint32_t v : s.vertices) box.extend(positions[v]);
  std::vector<double> result;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Vec3d p = (positions[s.vertices[i]] - box.center()) / box.diagonal();
    const double saw = 37.7 * p.x + 91.3 * p.y + 53.9 * p.z;
    result.push_back((0.3 + p.x + p.y + p.z + saw - std::floor(saw)) * std::sqrt(s.mass[i]));
  }
  return result;
}

}  // namespace

std::optional<Spectrum> spectrum_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                    std::size_t count, const Progress* progress) {
  Spectrum s = nodes_of(positions, coarsened(positions, largest_piece(positions, triangles)));
  const std::size_t wanted = 2 * count + kMoreVectors;
  if (s.size() < 2 * wanted) return std::nullopt;
  const InverseLaplacian inverse(s, couplings_of(s, positions), progress);
  if (!inverse.is_definite()) return std::nullopt;
  Krylov krylov = krylov_of(inverse, start_vector(s, positions), wanted, progress);
  const double last = krylov.matrix.beside.back();
  const std::vector<std::vector<double>> vectors = diagonalize(krylov.matrix);
  const std::vector<double>& found = krylov.matrix.diagonal;
  std::vector<std::size_t> order(found.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return found[a] > found[b]; });
  for (std::size_t k = 0; k < std::min(count, order.size()); ++k) {
    const std::vector<double>& coordinates = vectors[order[k]];
    const double inverse_value = found[order[k]];
    if (!(std::abs(last * coordinates.back()) < kMaxResidual * inverse_value)) break;
    s.values.push_back(std::max(0.0, 1 / inverse_value - kShift));
    std::vector<double> function(s.size(), 0);
    for (std::size_t i = 0; i < coordinates.size(); ++i) add(function, krylov.vectors[i], coordinates[i]);
    for (std::size_t i = 0; i < s.size(); ++i) function[i] /= std::sqrt(s.mass[i]);
    s.functions.push_back(std::move(function));
  }
  return s.values.size() == count ? std::optional(std::move(s)) : std::nullopt;
}

}  // namespace knead::detail
