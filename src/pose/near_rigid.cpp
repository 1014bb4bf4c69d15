// Assembles and solves the equations of the field that strains a body least.
#include "pose/near_rigid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>

#include "knead/error.h"
#include "math/sparse_cholesky.h"
#include "math/system.h"
#include "pose/lattice_nodes.h"

namespace knead::detail {

namespace {

// Adding a gradient to A changes no v, so that one component of A is not needed: the last one is 0. With all three the
// rms of log stretch is 3% to 5% less, and a factor takes three times as long.
constexpr std::size_t kComponents = 2;  // and one more where volumes may change: p
constexpr std::size_t kMaxUnknowns = 15'000;
// The centre of each cell is a weak sample, too. It continues the field beyond the body, which may move there, and
// determines nodes whose support holds hardly a sample.
constexpr double kStiffnessAround = 1e-3;
constexpr double kGrowthAround = 1.0 / 3;  // weight of div v there: that of any other strain
constexpr std::uint32_t kCellMiddle = 1;   // marks such a sample in CellPoint::list
constexpr std::size_t kRowsAtOnce = 6;     // those of a sample's strain
constexpr std::size_t kAlignment = 64;     // bytes, of the widest registers

// A row over a cell's 64 nodes, each with its components.
template <std::size_t components>
struct alignas(kAlignment) DenseRow : std::array<double, components * kCellNodes> {};

// The six rows of the strain, as SplineBasis has them, and that of div v times sqrt(weight).
template <std::size_t components>
constexpr std::size_t kStrainRows = components == kComponents ? 6 : 7;

// The rows of curl A, and of grad p in the last column, times a number.
template <std::size_t components, std::size_t count>
std::array<DenseRow<components>, count> dense(const std::array<SplineRow, count>& rows,
                                              const std::array<NodeWeights, count>& growth, double by) {
  std::array<DenseRow<components>, count> result;  // NOLINT(cppcoreguidelines-pro-type-member-init): written below
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t node = 0; node < kCellNodes; ++node) {
      double* const to = result[i].data() + components * node;
      for (std::size_t axis = 0; axis < kComponents; ++axis) to[axis] = rows[i][axis][node] * by;
      if constexpr (components > kComponents) to[kComponents] = growth[i][node] * by;
    }
  }
  return result;
}

template <std::size_t components>
std::array<DenseRow<components>, 3> velocity_rows(const SplineBasis& basis, double by) {
  std::array<NodeWeights, 3> growth{};
  if constexpr (components > kComponents) growth = basis.growth_velocity();
  return dense<components>(basis.velocity(), growth, by);
}

// The row of div v.
NodeWeights divergence_row(const SplineBasis& basis) {
  const std::array<NodeWeights, 6> strain = basis.growth_strain();
  NodeWeights row;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
  for (std::size_t node = 0; node < kCellNodes; ++node) row[node] = strain[0][node] + strain[1][node] + strain[2][node];
  return row;
}

template <std::size_t components>
std::array<DenseRow<components>, kStrainRows<components>> strain_rows(const SplineBasis& basis, double weight,
                                                                      double by) {
  if constexpr (components == kComponents) {
    return dense<components>(basis.strain(), {}, by);
  } else {
    const NodeWeights divergence = divergence_row(basis);
    std::array<NodeWeights, 6> traceless = basis.growth_strain();
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t node = 0; node < kCellNodes; ++node) traceless[i][node] -= divergence[node] / 3;
    }
    const auto strain = dense<components>(basis.strain(), traceless, by);
    std::array<DenseRow<components>, 7> result{};
    std::copy(strain.begin(), strain.end(), result.begin());
    for (std::size_t node = 0; node < kCellNodes; ++node) {
      result[6][components * node + kComponents] = divergence[node] * by * std::sqrt(weight);
    }
    return result;
  }
}

// Adds the products of each row's numbers to the upper triangle of a matrix, or sets it to them. Also writes some
// unused entries of the lower triangle, to keep loads and stores aligned.
template <std::size_t kRowNumbers, bool is_first>
[[gnu::always_inline]] inline void sum_products(const double* __restrict unaligned_rows,
                                                double* __restrict unaligned_products) {
  constexpr std::size_t kAligned = kAlignment / sizeof(double);
  const auto* __restrict const rows = static_cast<const double*>(__builtin_assume_aligned(unaligned_rows, kAlignment));
  auto* __restrict const products = static_cast<double*>(__builtin_assume_aligned(unaligned_products, kAlignment));
  for (std::size_t a = 0; a < kRowNumbers; ++a) {
    double by[kRowsAtOnce];
    for (std::size_t r = 0; r < kRowsAtOnce; ++r) by[r] = rows[r * kRowNumbers + a];
    double* const to = products + a * kRowNumbers;
    for (std::size_t b = a / kAligned * kAligned; b < kRowNumbers; b += kAligned) {
      for (std::size_t i = b; i < b + kAligned; ++i) {
        double sum = is_first ? 0 : to[i];
        for (std::size_t r = 0; r < kRowsAtOnce; ++r) sum += by[r] * rows[r * kRowNumbers + i];
        to[i] = sum;
      }
    }
  }
}

KNEAD_CLONES void set_products(const double* __restrict rows, double* __restrict products) {
  sum_products<kComponents * kCellNodes, true>(rows, products);
}

KNEAD_CLONES void add_products(const double* __restrict rows, double* __restrict products) {
  sum_products<kComponents * kCellNodes, false>(rows, products);
}

KNEAD_CLONES void set_growing_products(const double* __restrict rows, double* __restrict products) {
  sum_products<(kComponents + 1) * kCellNodes, true>(rows, products);
}

KNEAD_CLONES void add_growing_products(const double* __restrict rows, double* __restrict products) {
  sum_products<(kComponents + 1) * kCellNodes, false>(rows, products);
}

// The upper triangle of a cell's sum of products.
template <std::size_t components>
struct CellSum {
  static constexpr std::size_t kRowNumbers = components * kCellNodes;

  alignas(kAlignment) std::array<double, kRowNumbers * kRowNumbers> products;

  // Sums the products of rows, in their order. Their number is a multiple of kRowsAtOnce.
  void set(std::span<const DenseRow<components>> rows) {
    constexpr auto kSet = components == kComponents ? &set_products : &set_growing_products;
    constexpr auto kAdd = components == kComponents ? &add_products : &add_growing_products;
    for (std::size_t r = 0; r < rows.size(); r += kRowsAtOnce) (r == 0 ? kSet : kAdd)(rows[r].data(), products.data());
  }
};

Vec3d mean_of(const std::vector<Vec3d>& points) {
  Vec3d sum{0, 0, 0};
  for (const Vec3d& p : points) sum += p - points.front();
  return points.front() + sum / static_cast<double>(points.size());
}

// Returns for each list the number of the first of its spin's unknowns, which come before the nodes'.
std::vector<int> spin_numbers(std::span<const VelocityRows> rows) {
  std::vector<int> numbers;
  int next = 0;
  for (const VelocityRows& list : rows) {
    numbers.push_back(next);
    next += list.spins ? 3 : 0;
  }
  numbers.push_back(next);
  return numbers;
}

// Fills the matrix of NearRigidSystem::Equations.
template <std::size_t components>
class Assembly {
 public:
  using Row = DenseRow<components>;
  static constexpr int kOfNode = static_cast<int>(components);
  static constexpr std::size_t kRowNumbers = components * kCellNodes;

  Assembly(const Lattice& lattice, const BodySamples& body, std::span<const VelocityRows> rows, int threads,
           const Progress* progress)
      : lattice_(lattice), body_(body), rows_(rows), threads_(threads), progress_(progress) {
    std::vector<CellPoint> samples;
    std::vector<LatticeCell> resting;
    for (std::size_t i = 0; i < body.points.size(); ++i) {
      samples.push_back(point_at(body.points[i], 0, i));
      (!body.held.empty() && body.held[i] ? resting : cells_).push_back(samples.back().cell);
    }
    std::vector<CellPoint> wanted;
    for (std::size_t list = 0; list < rows.size(); ++list) {
      for (std::size_t i = 0; i < rows[list].points.size(); ++i) {
        wanted.push_back(point_at(rows[list].points[i], list, i));
        (rows[list].rests ? resting : cells_).push_back(wanted.back().cell);
      }
    }
    for (const Vec3d& p : body.around) {
      const LatticeCell cell = cell_of(p - lattice.origin, lattice.spacing);
      if (cells_.empty() || cells_.back() != cell) cells_.push_back(cell);
    }
    sort_cells(cells_);
    divide(std::move(resting));
    std::vector<LatticeCell> all = cells_;
    all.insert(all.end(), touched_.begin(), touched_.end());
    std::sort(all.begin(), all.end());
    drop_far(all, samples);
    drop_far(all, wanted);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      samples.push_back({cells_[i], kCellMiddle, static_cast<std::uint32_t>(i)});
    }
    samples_ = sorted_by_cells(std::move(samples));
    wanted_ = sorted_by_cells(std::move(wanted));
  }

  LatticeNodes find_nodes() const { return LatticeNodes(cells_, touched_, kept_nodes(), threads_); }
  std::size_t count_nodes() const { return LatticeNodes::count(cells_, kept_nodes()); }

  // Returns the matrix. Sets the mean diagonal of the strain, and the right side for wanted strain and growth: empty if
  // none are wanted.
  SymmetricMatrix fill(const LatticeNodes& nodes, double& mean_diagonal, std::vector<double>& wanted) {
    nodes_ = &nodes;
    spins_ = spin_numbers(rows_);
    make_pattern();
    const bool grows = std::any_of(body_.growth.begin(), body_.growth.end(), [](double g) { return g != 0; });
    wanted.assign(body_.strain.empty() && !grows ? 0 : components * nodes.size(), 0.0);
    add_runs(samples_, [&](std::span<const CellPoint> run, std::vector<Row>& rows) {
      for (const CellPoint& point : run) append_strain(point, rows);
      if (!wanted.empty()) add_wanted_strain(run, rows, wanted);
    });
    mean_diagonal = mean_of_diagonal();
    unit_ = mean_diagonal * lattice_.spacing * lattice_.spacing;
    add_runs(wanted_, [this](std::span<const CellPoint> run, std::vector<Row>& rows) {
      for (const CellPoint& point : run) append_velocity(point, rows);
    });
    for (std::size_t list = 0; list < rows_.size(); ++list) {
      if (rows_[list].spins) add_spin(list);
    }
    const double ridge = NearRigidSystem::kRidge * mean_diagonal;
    for (std::size_t column = first_; column < matrix_.size(); ++column) matrix_.values[matrix_.begin[column]] += ridge;
    return std::move(matrix_);
  }

 private:
  std::function<bool(const LatticeCell&)> kept_nodes() const {
    if (!body_.accepts) return {};
    return [this](const LatticeCell& node) {
      const Vec3d place = lattice_.origin + Vec3d(node[0], node[1], node[2]) * lattice_.spacing;
      const Vec3d support = Vec3d{2, 2, 2} * lattice_.spacing;
      return body_.accepts(Box{place - support, place + support});
    };
  }

  CellPoint point_at(const Vec3d& p, std::size_t list, std::size_t number) const {
    return {cell_of(p - lattice_.origin, lattice_.spacing), static_cast<std::uint32_t>(list),
            static_cast<std::uint32_t>(number)};
  }

  static void sort_cells(std::vector<LatticeCell>& cells) {
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  }

  // Resting cells next to others get nodes and may deform; those a little farther are touched by nodes.
  void divide(std::vector<LatticeCell> resting) {
    constexpr int kGiving = 1;   // the distance in cells up to which they get nodes
    constexpr int kTouched = 3;  // and up to which nodes touch them
    sort_cells(resting);
    const auto is_near = [](const LatticeCell& cell, const std::vector<LatticeCell>& others, int distance) {
      for (int x = -distance; x <= distance; ++x) {
        for (int y = -distance; y <= distance; ++y) {
          for (int z = -distance; z <= distance; ++z) {
            const LatticeCell near{cell[0] + x, cell[1] + y, cell[2] + z};
            if (std::binary_search(others.begin(), others.end(), near)) return true;
          }
        }
      }
      return false;
    };
    std::vector<LatticeCell> giving;
    for (const LatticeCell& cell : resting) {
      if (is_near(cell, cells_, kGiving)) giving.push_back(cell);
    }
    cells_.insert(cells_.end(), giving.begin(), giving.end());
    sort_cells(cells_);
    for (const LatticeCell& cell : resting) {
      const bool has_nodes = std::binary_search(cells_.begin(), cells_.end(), cell);
      if (!has_nodes && is_near(cell, cells_, kTouched)) touched_.push_back(cell);
    }
  }

  // Drops points in cells without unknown nodes.
  static void drop_far(const std::vector<LatticeCell>& cells, std::vector<CellPoint>& points) {
    std::erase_if(points, [&](const CellPoint& p) { return !std::binary_search(cells.begin(), cells.end(), p.cell); });
  }

  // The columns of a spin hold its own 3 x 3 block and the nodes around its patch; those of a node hold its neighbours
  // with greater numbers.
  void make_pattern() {
    first_ = static_cast<std::size_t>(spins_.back());
    std::vector<int>& rows = matrix_.rows;
    for (std::size_t list = 0; list < rows_.size(); ++list) {
      if (!rows_[list].spins) continue;
      const std::vector<int> near = nodes_about(rows_[list].points);
      for (int q = 0; q < 3; ++q) {
        for (int p = q; p < 3; ++p) rows.push_back(spins_[list] + p);
        for (const int node : near) {
          for (int p = 0; p < kOfNode; ++p) rows.push_back(static_cast<int>(first_) + kOfNode * node + p);
        }
        matrix_.begin.push_back(rows.size());
      }
    }
    for (int node = 0; node < static_cast<int>(nodes_->size()); ++node) {
      for (int q = 0; q < kOfNode; ++q) {
        for (const int neighbor : nodes_->neighbors_after(node)) {
          for (int p = neighbor == node ? q : 0; p < kOfNode; ++p)
            rows.push_back(static_cast<int>(first_) + kOfNode * neighbor + p);
        }
        matrix_.begin.push_back(rows.size());
      }
    }
    matrix_.values.assign(rows.size(), 0.0);
  }

  // Returns the sorted numbers of all nodes whose support holds one of the points.
  std::vector<int> nodes_about(const std::vector<Vec3d>& points) const {
    std::vector<int> near;
    for (const Vec3d& p : points) {
      const auto of_cell = nodes_->of_cell(cell_of(p - lattice_.origin, lattice_.spacing));
      std::copy_if(of_cell.begin(), of_cell.end(), std::back_inserter(near), [](int node) { return node >= 0; });
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    return near;
  }

  // Returns the stiffness of a sample divided by the number of samples.
  double stiffness_of(const CellPoint& point) const {
    const double stiffness = point.list == kCellMiddle ? kStiffnessAround
                             : body_.stiffness.empty() ? 1.0
                                                       : body_.stiffness[point.number];
    return stiffness / static_cast<double>(body_.points.size());
  }

  void append_strain(const CellPoint& point, std::vector<Row>& rows) const {
    const bool is_middle = point.list == kCellMiddle;
    const SplineBasis basis(is_middle ? middle_of(point.cell) : body_.points[point.number] - lattice_.origin,
                            lattice_.spacing);
    const double weight = is_middle ? kGrowthAround : body_.growth_weight;
    const auto strain = strain_rows<components>(basis, weight, std::sqrt(stiffness_of(point)));
    rows.insert(rows.end(), strain.begin(), strain.end());
  }

  // Adds the wanted strain and growth at a cell's samples to the right side.
  void add_wanted_strain(std::span<const CellPoint> run, std::span<const Row> rows, std::vector<double>& side) const {
    constexpr double kRoot = std::numbers::sqrt2;
    Row sum{};
    const auto add = [&](const Row& row, double by) {
      for (std::size_t i = 0; i < kRowNumbers; ++i) sum[i] += row[i] * by;
    };
    for (std::size_t i = 0; i < run.size(); ++i) {
      if (run[i].list == kCellMiddle) continue;
      const std::span<const Row> own = rows.subspan(kStrainRows<components> * i, kStrainRows<components>);
      const double by = std::sqrt(stiffness_of(run[i]));
      if (!body_.strain.empty()) {
        const Mat3d& strain = body_.strain[run[i].number];
        const std::array<double, 6> of_row{strain.row0.x,         strain.row1.y,         strain.row2.z,
                                           kRoot * strain.row0.y, kRoot * strain.row0.z, kRoot * strain.row1.z};
        for (std::size_t r = 0; r < of_row.size(); ++r) add(own[r], of_row[r] * by);
      }
      if (!body_.growth.empty()) add(own.back(), std::sqrt(body_.growth_weight) * body_.growth[run[i].number] * by);
    }
    const std::array<int, kCellNodes> numbers = nodes_->of_cell(run.front().cell);
    for (std::size_t node = 0; node < kCellNodes; ++node) {
      for (std::size_t axis = 0; axis < components && numbers[node] >= 0; ++axis) {
        side[components * static_cast<std::size_t>(numbers[node]) + axis] += sum[components * node + axis];
      }
    }
  }

  Vec3d middle_of(const LatticeCell& cell) const {
    return Vec3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5) * lattice_.spacing;
  }

  void append_velocity(const CellPoint& point, std::vector<Row>& rows) const {
    const VelocityRows& list = rows_[point.list];
    const double by = std::sqrt(list.weight * unit_);
    const SplineBasis basis(list.points[point.number] - lattice_.origin, lattice_.spacing);
    const std::array<Row, 3> v = velocity_rows<components>(basis, list.normals.empty() ? by : 1);
    if (list.normals.empty()) {
      rows.insert(rows.end(), v.begin(), v.end());
      return;
    }
    const Vec3d& n = list.normals[point.number];
    Row along;  // NOLINT(cppcoreguidelines-pro-type-member-init): all are written below
    for (std::size_t i = 0; i < kRowNumbers; ++i) along[i] = (n.x * v[0][i] + n.y * v[1][i] + n.z * v[2][i]) * by;
    rows.push_back(along);
  }

  // Adds the products of the rows at each cell's points to the matrix. Blocks that share no node run in parallel.
  template <class Append>
  void add_runs(const std::vector<CellPoint>& points, const Append& append) {
    for (const std::vector<CellBlock>& blocks : blocks_of(points)) {
      parallel_for(blocks.size(), 1, threads_, [&](std::size_t from, std::size_t to) {
        const std::unique_ptr<CellSum<components>> sum(new CellSum<components>);  // not cleared
        std::vector<Row> rows;
        for (std::size_t i = from; i < to; ++i) {
          stop_if_cancelled(progress_);
          for (const std::span<const CellPoint>& run : blocks[i]) {
            rows.clear();
            append(run, rows);
            while (rows.size() % kRowsAtOnce != 0) rows.push_back(Row{});
            sum->set(rows);
            add(run.front().cell, *sum);
          }
        }
      });
    }
  }

  void add(const LatticeCell& cell, const CellSum<components>& sum) {
    const std::array<int, kCellNodes> numbers = nodes_->of_cell(cell);
    for (std::size_t a = 0; a < kCellNodes; ++a) {
      for (std::size_t b = a; b < kCellNodes; ++b) {
        if (numbers[a] < 0 || numbers[b] < 0) continue;
        const bool in_order = numbers[a] <= numbers[b];
        const int column = in_order ? numbers[a] : numbers[b];
        const std::size_t rank =
            components * static_cast<std::size_t>(nodes_->rank(in_order ? a : b, in_order ? b : a, column));
        for (std::size_t p = 0; p < components; ++p) {
          for (std::size_t q = a == b ? p : 0; q < components; ++q) {
            // p and q are components of a and b.
            const std::size_t of_column = in_order ? p : q;
            const std::size_t of_row = in_order ? q : p;
            const std::size_t start = matrix_.begin[first_ + components * static_cast<std::size_t>(column) + of_column];
            matrix_.values[start + rank + of_row - of_column] +=
                sum.products[(components * a + p) * kRowNumbers + components * b + q];
          }
        }
      }
    }
  }

  double mean_of_diagonal() const {
    double sum = 0;
    for (std::size_t column = first_; column < matrix_.size(); ++column) sum += matrix_.values[matrix_.begin[column]];
    return sum / static_cast<double>(matrix_.size() - first_);
  }

  double& at(int row, std::size_t column) {
    const auto begin = matrix_.rows.begin() + static_cast<std::ptrdiff_t>(matrix_.begin[column]);
    const auto end = matrix_.rows.begin() + static_cast<std::ptrdiff_t>(matrix_.begin[column + 1]);
    return matrix_.values[static_cast<std::size_t>(std::lower_bound(begin, end, row) - matrix_.rows.begin())];
  }

  // Adds the rows of a patch's spin w: a point at d from the centre has the velocity w x d besides that of the centre,
  // so its rows get -(w x d).
  void add_spin(std::size_t list) {
    const VelocityRows& patch = rows_[list];
    const Vec3d middle = mean_of(patch.points);
    for (const Vec3d& p : patch.points) {
      const Vec3d d = p - middle;
      const double weight = patch.weight * unit_;
      // Row i of -(w x d) over w.
      const std::array<Vec3d, 3> spin{Vec3d{0, -d.z, d.y}, Vec3d{d.z, 0, -d.x}, Vec3d{-d.y, d.x, 0}};
      const SplineBasis basis(p - lattice_.origin, lattice_.spacing);
      const std::array<Row, 3> v = velocity_rows<components>(basis, 1);
      const std::array<int, kCellNodes> numbers = nodes_->of_cell(basis.cell());
      for (std::size_t q = 0; q < 3; ++q) {
        const std::size_t column = static_cast<std::size_t>(spins_[list]) + q;
        for (std::size_t r = q; r < 3; ++r) {
          for (const Vec3d& row : spin) at(spins_[list] + static_cast<int>(r), column) += weight * row[q] * row[r];
        }
        for (std::size_t node = 0; node < kCellNodes; ++node) {
          for (std::size_t axis = 0; axis < components && numbers[node] >= 0; ++axis) {
            double sum = 0;
            for (std::size_t i = 0; i < 3; ++i) sum += spin[i][q] * v[i][components * node + axis];
            at(static_cast<int>(first_) + kOfNode * numbers[node] + static_cast<int>(axis), column) += weight * sum;
          }
        }
      }
    }
  }

  const Lattice& lattice_;
  const BodySamples& body_;
  std::span<const VelocityRows> rows_;
  int threads_;
  const Progress* progress_;
  std::vector<LatticeCell> cells_;    // with unknown nodes, ascending
  std::vector<LatticeCell> touched_;  // other cells of the body inside the support of such nodes, ascending
  std::vector<CellPoint> samples_;
  std::vector<CellPoint> wanted_;
  const LatticeNodes* nodes_ = nullptr;
  std::vector<int> spins_;
  std::size_t first_ = 0;  // the first unknown of the nodes
  double unit_ = 0;        // of the rows' weights
  SymmetricMatrix matrix_;
};

// Calls body.template operator()<components>() for the number of components that the body needs.
template <class Body>
auto with_components(std::size_t components, const Body& body) {
  if (components == kComponents) return body.template operator()<kComponents>();
  return body.template operator()<kComponents + 1>();
}

std::size_t components_of(const BodySamples& body) { return kComponents + (body.growth.empty() ? 0 : 1); }

// Adds the wanted velocities to the right sides of the spin, if the rows have one, and of the nodes.
template <std::size_t components>
void add_wanted(const VelocityRows& list, const Lattice& lattice, const LatticeNodes& nodes, double weight,
                std::span<double> spin, std::span<double> side) {
  const Vec3d middle = list.spins ? mean_of(list.points) : Vec3d{};
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const SplineBasis basis(list.points[i] - lattice.origin, lattice.spacing);
    const std::array<DenseRow<components>, 3> v = velocity_rows<components>(basis, 1);
    const std::array<int, kCellNodes> numbers = nodes.of_cell(basis.cell());
    Vec3d wanted = list.wanted[i];
    if (!list.normals.empty()) wanted = list.normals[i] * dot(list.normals[i], wanted);
    wanted *= weight;
    for (std::size_t node = 0; node < kCellNodes; ++node) {
      for (std::size_t axis = 0; axis < components && numbers[node] >= 0; ++axis) {
        const std::size_t at = components * node + axis;
        side[components * static_cast<std::size_t>(numbers[node]) + axis] +=
            v[0][at] * wanted.x + v[1][at] * wanted.y + v[2][at] * wanted.z;
      }
    }
    if (!list.spins) continue;
    const Vec3d torque = cross(list.points[i] - middle, wanted);
    for (std::size_t axis = 0; axis < 3; ++axis) spin[axis] -= torque[axis];
  }
}

}  // namespace

struct NearRigidSystem::Equations {
  Lattice lattice;
  LatticeNodes nodes;
  std::size_t components = kComponents;
  double mean_diagonal = 0;  // of the strain
  SparseCholesky factor;
  std::vector<double> wanted{};  // the right side of the nodes for wanted strain and growth; or empty
};

std::size_t count_unknowns(const Lattice& lattice, const BodySamples& body, std::span<const VelocityRows> rows) {
  return with_components(components_of(body), [&]<std::size_t components>() {
    return components * Assembly<components>(lattice, body, rows, 1, nullptr).count_nodes();
  });
}

NearRigidSystem::NearRigidSystem(const Lattice& lattice, const BodySamples& body, std::span<const VelocityRows> rows,
                                 int threads, const Progress* progress) {
  auto equations = std::make_unique<Equations>();
  equations->lattice = lattice;
  equations->components = components_of(body);
  const SymmetricMatrix matrix = with_components(equations->components, [&]<std::size_t components>() {
    Assembly<components> assembly(lattice, body, rows, threads, progress);
    equations->nodes = assembly.find_nodes();
    const std::size_t unknowns = components * equations->nodes.size();
    if (unknowns > kMaxUnknowns) {
      throw InvalidInput(
          fmt::format("\"detail\" is too fine: the field has {} unknowns, and {} at most can be solved; "
                      "make it larger, or move the parts less",
                      unknowns, kMaxUnknowns));
    }
    return assembly.fill(equations->nodes, equations->mean_diagonal, equations->wanted);
  });
  if (!equations->factor.factorize(matrix, threads, progress)) {
    throw InvalidInput("the pose cannot be solved: its equations are singular; make \"detail\" larger");
  }
  equations_ = std::move(equations);
}

NearRigidSystem::NearRigidSystem(NearRigidSystem&&) noexcept = default;
NearRigidSystem& NearRigidSystem::operator=(NearRigidSystem&&) noexcept = default;
NearRigidSystem::~NearRigidSystem() = default;

std::size_t NearRigidSystem::unknowns() const { return equations_->components * equations_->nodes.size(); }

PotentialGrid NearRigidSystem::solve(std::span<const VelocityRows> rows) const {
  const Equations& e = *equations_;
  const std::vector<int> spins = spin_numbers(rows);
  const auto first = static_cast<std::size_t>(spins.back());
  const double unit = e.mean_diagonal * e.lattice.spacing * e.lattice.spacing;
  std::vector<double> right(first + e.components * e.nodes.size());
  std::copy(e.wanted.begin(), e.wanted.end(), right.begin() + static_cast<std::ptrdiff_t>(first));
  with_components(e.components, [&]<std::size_t components>() {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const std::span<double> all(right);
      const std::span<double> spin = rows[k].spins ? all.subspan(static_cast<std::size_t>(spins[k]), 3) : all.first(0);
      add_wanted<components>(rows[k], e.lattice, e.nodes, rows[k].weight * unit, spin, all.subspan(first));
    }
  });
  e.factor.solve(right);
  const auto number = [&](int node) { return first + e.components * static_cast<std::size_t>(node); };
  PotentialGrid grid = e.nodes.grid(e.lattice.origin, e.lattice.spacing, [&](int node) {
    return Vec3d{right[number(node)], right[number(node) + 1], 0};
  });
  if (e.components > kComponents) {
    grid.growth = e.nodes.of_grid<double>([&](int node) { return right[number(node) + kComponents]; });
  }
  return grid;
}

}  // namespace knead::detail
