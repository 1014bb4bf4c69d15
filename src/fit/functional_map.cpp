// Finds functional maps: descriptors, a first matrix, its refinement, and how good the map is.
#include "fit/functional_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "math/elementary.h"
#include "math/sparse_cholesky.h"
#include "mesh/body_points.h"

namespace knead::detail {

namespace {

constexpr std::size_t kFirstFunctions = 30;
constexpr std::array<std::size_t, 5> kFunctions{kFirstFunctions, 45, 65, 90, kMapFunctions};
constexpr std::size_t kSketchSteps = 2;  // of these
constexpr std::size_t kSamples = 1500;   // of the source, by which a map is refined
constexpr std::size_t kSketchSamples = 400;
constexpr std::size_t kEnergies = 40;  // of the signatures of all points
constexpr std::size_t kSeedEnergies = 8;
constexpr double kWidth = 4.7;  // of an energy's band, in steps between energies
constexpr double kSeedWidth = 1.5;
constexpr double kCommuting = 1;           // weight of the rule that a map commutes with the Laplacians
constexpr double kMinDiagonal = 1e-9;      // added to equations, relative to their mean diagonal
constexpr double kMaxDisagreement = 0.08;  // of the root of the area: of a point and what its image is the image of
constexpr std::size_t kTriples = 300;

// A dense matrix, row by row.
struct Dense {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> numbers = std::vector<double>(rows * columns, 0.0);

  double& operator()(std::size_t i, std::size_t k) { return numbers[i * columns + k]; }
  double operator()(std::size_t i, std::size_t k) const { return numbers[i * columns + k]; }
};

// Solves A x = b for the columns b of a matrix, where A is symmetric and positive; adds a little to its diagonal.
Dense solved(const Dense& a, const Dense& right, const Progress* progress) {
  double trace = 0;
  for (std::size_t i = 0; i < a.rows; ++i) trace += a(i, i);
  SymmetricMatrix matrix;
  for (std::size_t k = 0; k < a.columns; ++k) {
    for (std::size_t i = k; i < a.rows; ++i) {
      matrix.rows.push_back(static_cast<int>(i));
      matrix.values.push_back(a(i, k) + (i == k ? kMinDiagonal * trace / static_cast<double>(a.rows) : 0));
    }
    matrix.begin.push_back(matrix.rows.size());
  }
  SparseCholesky factor;
  Dense result{right.rows, right.columns};
  if (!factor.factorize(matrix, 1, progress)) return result;
  std::vector<double> b(a.rows);
  for (std::size_t k = 0; k < right.columns; ++k) {
    for (std::size_t i = 0; i < b.size(); ++i) b[i] = right(i, k);
    factor.solve(b);
    for (std::size_t i = 0; i < b.size(); ++i) result(i, k) = b[i];
  }
  return result;
}

// A bell from 1 to 0, as exp(-x^2), from + and * only.
double bell(double x) {
  const double inside = std::max(0.0, 1 - 0.25 * x * x);
  return inside * inside * inside * inside;
}

// Returns the weight of each eigenfunction at `count` energies, by rows.
Dense energies_of(const Spectrum& s, std::size_t count, double width) {
  const double low = elementary::log(s.values[1]);
  const double high = elementary::log(s.values[kFirstFunctions - 1]);
  const double step = (high - low) / static_cast<double>(count - 1);
  Dense weights{count, kFirstFunctions};
  for (std::size_t e = 0; e < count; ++e) {
    const double at = low + step * static_cast<double>(e);
    for (std::size_t k = 1; k < kFirstFunctions; ++k) {
      weights(e, k) = bell((elementary::log(s.values[k]) - at) / (width * step));
    }
  }
  return weights;
}

std::uint32_t nearest_node(const SpectralSurface& surface, const Vec3d& p) {
  const auto nearer = [&](const Vec3d& a, const Vec3d& b) { return norm2(a - p) < norm2(b - p); };
  return static_cast<std::uint32_t>(std::min_element(surface.positions.begin(), surface.positions.end(), nearer) -
                                    surface.positions.begin());
}

// Returns the coordinates of descriptors in the first eigenfunctions: a column for each.
Dense descriptors(const SpectralSurface& surface, const std::vector<std::uint32_t>& seeds) {
  const Spectrum& s = surface.spectrum;
  const Dense all = energies_of(s, kEnergies, kWidth);
  const Dense own = energies_of(s, kSeedEnergies, kSeedWidth);
  Dense result{kFirstFunctions, kEnergies + kSeedEnergies * seeds.size()};
  for (std::size_t e = 0; e < kEnergies; ++e) {
    std::vector<double> signature(s.size(), 0);
    double size = 0;
    for (std::size_t v = 0; v < s.size(); ++v) {
      for (std::size_t k = 1; k < kFirstFunctions; ++k)
        signature[v] += all(e, k) * s.functions[k][v] * s.functions[k][v];
      size += s.mass[v] * signature[v] * signature[v];
    }
    const double scale = size > 0 ? 1 / std::sqrt(size * kEnergies) : 0;
    for (std::size_t k = 0; k < kFirstFunctions; ++k) {
      for (std::size_t v = 0; v < s.size(); ++v) result(k, e) += s.mass[v] * signature[v] * s.functions[k][v] * scale;
    }
  }
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    for (std::size_t e = 0; e < kSeedEnergies; ++e) {
      const std::size_t column = kEnergies + i * kSeedEnergies + e;
      double size = 0;
      for (std::size_t k = 0; k < kFirstFunctions; ++k) {
        result(k, column) = own(e, k) * s.functions[k][seeds[i]];
        size += result(k, column) * result(k, column);
      }
      const double scale = size > 0 ? 1 / std::sqrt(size * static_cast<double>(kSeedEnergies * seeds.size())) : 0;
      for (std::size_t k = 0; k < kFirstFunctions; ++k) result(k, column) *= scale;
    }
  }
  return result;
}

// Returns the matrix that takes the coordinates of the target's descriptors to those of the source's, and
// eigenfunctions to ones with nearly their eigenvalues.
Dense first_matrix(const SpectralSurface& source, const SpectralSurface& target, const Dense& of_source,
                   const Dense& of_target, const Progress* progress) {
  constexpr std::size_t n = kFirstFunctions;
  Dense gram{n, n};
  double trace = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t d = 0; d < of_target.columns; ++d) gram(i, k) += of_target(i, d) * of_target(k, d);
    }
    trace += gram(i, i);
  }
  const std::vector<double>& from = target.spectrum.values;
  const std::vector<double>& to = source.spectrum.values;
  const double greatest = std::max(from[n - 1], to[n - 1]);
  Dense result{n, n};
  for (std::size_t row = 0; row < n; ++row) {
    Dense equations = gram;
    Dense right{n, 1};
    for (std::size_t k = 0; k < n; ++k) {
      const double apart = (from[k] - to[row]) / greatest;
      equations(k, k) += kCommuting * trace / n * apart * apart;
      for (std::size_t d = 0; d < of_target.columns; ++d) right(k, 0) += of_source(row, d) * of_target(k, d);
    }
    const Dense x = solved(equations, right, progress);
    for (std::size_t k = 0; k < n; ++k) result(row, k) = x(k, 0);
  }
  return result;
}

// Returns for each query, a row, the number of the nearest column of the functions.
std::vector<std::uint32_t> nearest_columns(const Dense& queries, const std::vector<std::vector<double>>& functions,
                                           int threads) {
  constexpr std::size_t kGrain = 16;
  const std::size_t count = functions.front().size();
  std::vector<double> squares(count, 0);
  for (std::size_t k = 0; k < queries.columns; ++k) {
    for (std::size_t c = 0; c < count; ++c) squares[c] += functions[k][c] * functions[k][c];
  }
  std::vector<std::uint32_t> result(queries.rows);
  parallel_for(queries.rows, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> distance;
    for (std::size_t q = begin; q < end; ++q) {
      distance = squares;
      for (std::size_t k = 0; k < queries.columns; ++k) {
        const double factor = -2 * queries(q, k);
        const double* function = functions[k].data();
        for (std::size_t c = 0; c < count; ++c) distance[c] += factor * function[c];
      }
      result[q] = static_cast<std::uint32_t>(std::min_element(distance.begin(), distance.end()) - distance.begin());
    }
  });
  return result;
}

// Returns the values of the first functions at nodes: a row for each node.
Dense values_at(const Spectrum& s, const std::vector<std::uint32_t>& nodes, std::size_t count) {
  Dense result{nodes.size(), count};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t k = 0; k < count; ++k) result(i, k) = s.functions[k][nodes[i]];
  }
  return result;
}

Dense product(const Dense& a, const Dense& b) {
  Dense result{a.rows, b.columns};
  for (std::size_t i = 0; i < a.rows; ++i) {
    for (std::size_t j = 0; j < a.columns; ++j) {
      for (std::size_t k = 0; k < b.columns; ++k) result(i, k) += a(i, j) * b(j, k);
    }
  }
  return result;
}

Dense transposed(const Dense& a) {
  Dense result{a.columns, a.rows};
  for (std::size_t i = 0; i < a.rows; ++i) {
    for (std::size_t k = 0; k < a.columns; ++k) result(k, i) = a(i, k);
  }
  return result;
}

// A functional map from the target to the source.
class Mapper {
 public:
  Mapper(const SpectralSurface& source, const SpectralSurface& target, Dense matrix, int threads,
         const Progress* progress)
      : source_(source), target_(target), matrix_(std::move(matrix)), threads_(threads), progress_(progress) {}

  // Returns the target's node for each of these nodes of the source.
  std::vector<std::uint32_t> images(const std::vector<std::uint32_t>& nodes) const {
    const Dense values = values_at(source_.spectrum, nodes, matrix_.rows);
    return nearest_columns(product(values, matrix_), target_.spectrum.functions, threads_);
  }

  // Returns the same by the transposed map, which errs less.
  std::vector<std::uint32_t> transposed_images(const std::vector<std::uint32_t>& nodes) const {
    std::vector<std::vector<double>> functions(matrix_.rows, std::vector<double>(target_.spectrum.size(), 0));
    for (std::size_t i = 0; i < matrix_.rows; ++i) {
      for (std::size_t k = 0; k < matrix_.columns; ++k) {
        for (std::size_t v = 0; v < functions[i].size(); ++v) {
          functions[i][v] += matrix_(i, k) * target_.spectrum.functions[k][v];
        }
      }
    }
    return nearest_columns(values_at(source_.spectrum, nodes, matrix_.rows), functions, threads_);
  }

  // Finds the matrix of more functions from the images of these nodes.
  void refine(const std::vector<std::uint32_t>& nodes, std::size_t functions) {
    stop_if_cancelled(progress_);
    const Dense from = values_at(target_.spectrum, images(nodes), functions);
    const Dense to = values_at(source_.spectrum, nodes, functions);
    const Dense turned = transposed(to);
    matrix_ = solved(product(turned, to), product(turned, from), progress_);
  }

 private:
  const SpectralSurface& source_;
  const SpectralSurface& target_;
  Dense matrix_;
  int threads_;
  const Progress* progress_;
};

// Returns triples of nodes that span a triangle of the surface's size at the samples, with its orientation.
std::vector<std::uint32_t> triples_of(const SpectralSurface& s, const std::vector<std::uint32_t>& samples) {
  constexpr double kMinCosine = 0.5;  // of the normals
  constexpr double kMinSine = 0.4;
  std::vector<std::uint32_t> result;
  for (const std::uint32_t a : samples) {
    std::vector<std::pair<double, std::uint32_t>> others;
    for (const std::uint32_t b : samples) {
      if (b != a && dot(s.normals[a], s.normals[b]) > kMinCosine) {
        others.emplace_back(norm2(s.positions[b] - s.positions[a]), b);
      }
    }
    if (others.size() < 2) continue;
    std::partial_sort(others.begin(),
                      others.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(6, others.size())),
                      others.end());
    others.resize(std::min<std::size_t>(6, others.size()));
    const std::uint32_t b = others[0].second;
    const Vec3d side = normalized(s.positions[b] - s.positions[a]);
    for (std::size_t i = 1; i < others.size(); ++i) {
      const std::uint32_t c = others[i].second;
      const double sine = dot(cross(side, normalized(s.positions[c] - s.positions[a])), s.normals[a]);
      if (std::abs(sine) < kMinSine) continue;
      const std::array<std::uint32_t, 3> triple = sine > 0 ? std::array{a, b, c} : std::array{a, c, b};
      result.insert(result.end(), triple.begin(), triple.end());
      break;
    }
  }
  return result;
}

// Returns how well a map keeps lengths and orientation: the part of triples that it does not mirror, less the mean
// distortion of their sides.
double quality_of(const SpectralSurface& source, const SpectralSurface& target, const Mapper& mapper, double ratio) {
  std::vector<std::uint32_t> samples = spread_points(source.positions, kTriples);
  const std::vector<std::uint32_t> from = triples_of(source, samples);
  if (from.empty()) return 0;
  const std::vector<std::uint32_t> to = mapper.images(from);
  double kept = 0;
  double distortion = 0;
  for (std::size_t i = 0; i < to.size(); i += 3) {
    const Vec3d& a = target.positions[to[i]];
    const Vec3d b = target.positions[to[i + 1]] - a;
    const Vec3d c = target.positions[to[i + 2]] - a;
    if (dot(cross(b, c), target.normals[to[i]]) > 0) kept += 1;
    for (std::size_t k = 1; k < 3; ++k) {
      const double before = norm(source.positions[from[i + k]] - source.positions[from[i]]) * ratio;
      const double after = norm(target.positions[to[i + k]] - a);
      distortion += 0.5 * (1 - std::min(before, after) / std::max(before, after));
    }
  }
  return (kept - distortion) / (static_cast<double>(to.size()) / 3);
}

double root_of_area(const SpectralSurface& s) {
  double area = 0;
  for (const Triangle& t : s.spectrum.triangles) {
    area += 0.5 * norm(cross(s.positions[t[1]] - s.positions[t[0]], s.positions[t[2]] - s.positions[t[0]]));
  }
  return std::sqrt(area);
}

}  // namespace

std::optional<SpectralSurface> spectral_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                                const Progress* progress) {
  std::optional<Spectrum> spectrum = spectrum_of(positions, triangles, kMapFunctions, progress);
  if (!spectrum || !(spectrum->values[1] > 0)) return std::nullopt;
  SpectralSurface result;
  const std::vector<Vec3d> normals = area_weighted_normals(positions, triangles);
  for (const std::uint32_t v : spectrum->vertices) {
    result.positions.push_back(positions[v]);
    result.normals.push_back(norm(normals[v]) > 0 ? normalized(normals[v]) : Vec3d{0, 0, 0});
  }
  result.spectrum = std::move(*spectrum);
  return result;
}

SurfaceMap functional_map(const SpectralSurface& source, const SpectralSurface& target, std::span<const FitPair> seeds,
                          bool sketches, int threads, const Progress* progress) {
  std::vector<std::uint32_t> from;
  std::vector<std::uint32_t> to;
  for (const FitPair& pair : seeds) {
    from.push_back(nearest_node(source, pair.source));
    to.push_back(nearest_node(target, pair.target));
  }
  Mapper mapper(source, target,
                first_matrix(source, target, descriptors(source, from), descriptors(target, to), progress), threads,
                progress);
  const std::vector<std::uint32_t> nodes = spread_points(source.positions, sketches ? kSketchSamples : kSamples);
  const std::size_t steps = sketches ? kSketchSteps : kFunctions.size();
  for (std::size_t i = 1; i < steps; ++i) mapper.refine(nodes, kFunctions[i]);
  SurfaceMap result;
  const double size = root_of_area(target);
  result.quality = quality_of(source, target, mapper, size / root_of_area(source));
  if (sketches || result.quality < kMinMapQuality) return result;
  const std::vector<std::uint32_t> forth = mapper.images(nodes);
  const std::vector<std::uint32_t> back = mapper.transposed_images(nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Vec3d& place = target.positions[back[i]];
    if (norm(place - target.positions[forth[i]]) > kMaxDisagreement * size) continue;
    result.pairs.push_back({source.positions[nodes[i]], place});
  }
  return result;
}

}  // namespace knead::detail
