// The map of a box of control points: its polynomials, its inverse, and its derivatives.
#include "flow/lattice_map.h"

#include <algorithm>
#include <cmath>

#include "math/geometry.h"

namespace knead::detail {
namespace {

constexpr double kEdge = 1e-9;    // of an edge: a point so near to the box is on it
constexpr double kBeyond = 0.05;  // of an edge, by which a search may leave the box
constexpr double kFound = 1e-12;  // of the box's diagonal
constexpr int kSearchSteps = 60;
constexpr int kMaxStationsOfEdge = 12;
constexpr std::size_t kStationsTried = 6;

Vec3d transposed_times(const Mat3d& m, const Vec3d& v) { return m.row0 * v.x + m.row1 * v.y + m.row2 * v.z; }

double greatest_displacement(const LatticeMotion& lattice) {
  double most = 0;
  for (const Vec3d& d : lattice.displacements) most = std::max(most, norm(d));
  return most;
}

}  // namespace

double LatticeAxis::knot(int j) const {
  return static_cast<double>(std::clamp(j - degree_, 0, intervals())) / intervals();
}

double LatticeAxis::place(int i) const {
  double sum = 0;
  for (int j = 1; j <= degree_; ++j) sum += knot(i + j);
  return sum / degree_;
}

// The recursion of Cox and de Boor; the derivative comes from the values of the degree below.
LatticeAxis::Values LatticeAxis::at(double u) const {
  Values result;
  result.first = std::clamp(static_cast<int>(std::floor(u * intervals())), 0, intervals() - 1);
  const int span = result.first + degree_;
  std::array<double, LatticeMotion::kMaxDegree + 1> below{1};
  for (int p = 1; p <= degree_; ++p) {
    std::array<double, LatticeMotion::kMaxDegree + 1> next{};
    for (int i = 0; i < p; ++i) {
      const double low = knot(span + 1 - p + i);
      const double high = knot(span + 1 + i);
      const double part = below[i] / (high - low);
      next[i] += part * (high - u);
      next[i + 1] += part * (u - low);
      if (p < degree_) continue;
      result.rate[i] -= degree_ * part;
      result.rate[i + 1] += degree_ * part;
    }
    below = next;
  }
  result.value = below;
  return result;
}

std::array<LatticeAxis, 3> axes_of(const LatticeMotion& lattice) {
  const auto axis = [&](std::size_t a) { return LatticeAxis(lattice.counts[a], lattice.degrees[a]); };
  return {axis(0), axis(1), axis(2)};
}

std::array<std::array<bool, 2>, 3> closed_faces(const LatticeMotion& lattice) {
  std::array<std::array<bool, 2>, 3> closed{{{true, true}, {true, true}, {true, true}}};
  const auto [nx, ny, nz] = lattice.counts;
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      for (int k = 0; k < nz; ++k) {
        const int number = (i * ny + j) * nz + k;
        if (lattice.displacements[static_cast<std::size_t>(number)] == Vec3d{0, 0, 0}) continue;
        const std::array<int, 3> index{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (index[axis] < 2) closed[axis][0] = false;
          if (index[axis] >= lattice.counts[axis] - 2) closed[axis][1] = false;
        }
      }
    }
  }
  return closed;
}

Box bounding_box(const LatticeMotion& lattice) {
  const double by = greatest_displacement(lattice);
  Box box;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3d p = lattice.origin;
    if ((corner & 1U) != 0) p += lattice.axes.row0 * lattice.lengths.x;
    if ((corner & 2U) != 0) p += lattice.axes.row1 * lattice.lengths.y;
    if ((corner & 4U) != 0) p += lattice.axes.row2 * lattice.lengths.z;
    box.extend(p - Vec3d{by, by, by});
    box.extend(p + Vec3d{by, by, by});
  }
  return box;
}

LatticeSupport::LatticeSupport(const Segment& segment)
    : origin_(segment.lattice.origin), axes_(segment.lattice.axes), lengths_(segment.lattice.lengths) {
  const auto closed = closed_faces(segment.lattice);
  const double by = segment.begin * greatest_displacement(segment.lattice);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side = 0; side < 2; ++side) margins_[axis][side] = closed[axis][side] ? 0 : by;
  }
}

bool LatticeSupport::misses(const Vec3d& center, double radius) const {
  const Vec3d at = axes_ * (center - origin_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edge = radius * (1 + kEdge) + 2 * kEdge * lengths_[axis];
    if (at[axis] < -margins_[axis][0] - edge || at[axis] > lengths_[axis] + margins_[axis][1] + edge) return true;
  }
  return false;
}

LatticeMap::LatticeMap(const Segment& segment)
    : lattice_(segment.lattice),
      begin_(segment.begin),
      end_(segment.end),
      support_(segment),
      axes_(axes_of(segment.lattice)) {
  if (begin_ == 0) return;
  std::array<int, 3> counts{};
  for (std::size_t axis = 0; axis < 3; ++axis) counts[axis] = std::min(2 * lattice_.counts[axis], kMaxStationsOfEdge);
  for (int i = 0; i < counts[0]; ++i) {
    for (int j = 0; j < counts[1]; ++j) {
      for (int k = 0; k < counts[2]; ++k) {
        const Vec3d at{(i + 0.5) / counts[0] * lattice_.lengths.x, (j + 0.5) / counts[1] * lattice_.lengths.y,
                       (k + 0.5) / counts[2] * lattice_.lengths.z};
        stations_.emplace_back(at + lattice_.axes * displacement(at, nullptr) * begin_, at);
      }
    }
  }
}

Vec3d LatticeMap::from_box(const Vec3d& v) const { return transposed_times(lattice_.axes, v); }

LatticeMap::Weights LatticeMap::weights(const Vec3d& at) const {
  return {axes_[0].at(at.x / lattice_.lengths.x), axes_[1].at(at.y / lattice_.lengths.y),
          axes_[2].at(at.z / lattice_.lengths.z)};
}

// Calls body(number of a control point, i, j, k), where these are indices of the values of `weights`.
template <class Body>
void LatticeMap::for_each(const Weights& weights, const Body& body) const {
  const int ny = lattice_.counts[1];
  const int nz = lattice_.counts[2];
  for (int i = 0; i <= axes_[0].degree(); ++i) {
    for (int j = 0; j <= axes_[1].degree(); ++j) {
      int number = ((weights[0].first + i) * ny + weights[1].first + j) * nz + weights[2].first;
      for (int k = 0; k <= axes_[2].degree(); ++k) body(static_cast<std::size_t>(number++), i, j, k);
    }
  }
}

// Returns D at a place of the box; gradient: rows are its derivatives along the box's edges.
Vec3d LatticeMap::displacement(const Vec3d& at, Mat3d* gradient) const {
  const Weights w = weights(at);
  Vec3d sum{0, 0, 0};
  Mat3d rates{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  for_each(w, [&](std::size_t number, int i, int j, int k) {
    const Vec3d& d = lattice_.displacements[number];
    const double jk = w[1].value[j] * w[2].value[k];
    sum += d * (w[0].value[i] * jk);
    if (gradient == nullptr) return;
    rates.row0 += d * (w[0].rate[i] * jk);
    rates.row1 += d * (w[0].value[i] * w[1].rate[j] * w[2].value[k]);
    rates.row2 += d * (w[0].value[i] * w[1].value[j] * w[2].rate[k]);
  });
  if (gradient != nullptr) {
    *gradient = {rates.row0 / lattice_.lengths.x, rates.row1 / lattice_.lengths.y, rates.row2 / lattice_.lengths.z};
  }
  return sum;
}

// The Jacobian of x + time D(x), of what displacement() gives.
Mat3d LatticeMap::jacobian_at(const Mat3d& gradient, double time) const {
  Mat3d result;
  for (const auto& [d, axis] : {std::pair{gradient.row0, lattice_.axes.row0},
                                {gradient.row1, lattice_.axes.row1},
                                {gradient.row2, lattice_.axes.row2}}) {
    result = result + outer_product(d, axis) * time;
  }
  return result;
}

std::optional<Vec3d> LatticeMap::inside(const Vec3d& at) const {
  Vec3d result = at;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = lattice_.lengths[axis];
    if (!(at[axis] >= -kEdge * length && at[axis] <= (1 + kEdge) * length)) return std::nullopt;
    result[axis] = std::clamp(at[axis], 0.0, length);
  }
  return result;
}

// Newton's method for the place from which a point has come, with shorter steps where it does not come nearer.
std::optional<Vec3d> LatticeMap::search(const Vec3d& target, Vec3d at) const {
  const auto near_box = [&](Vec3d p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double by = kBeyond * lattice_.lengths[axis];
      p[axis] = std::clamp(p[axis], -by, lattice_.lengths[axis] + by);
    }
    return p;
  };
  const auto miss = [&](const Vec3d& p, Mat3d* gradient) {
    return p + lattice_.axes * displacement(p, gradient) * begin_ - target;
  };
  at = near_box(at);
  Mat3d gradient;
  Vec3d off = miss(at, &gradient);
  for (int i = 0; i < kSearchSteps; ++i) {
    const Mat3d along{gradient.row0 * begin_ + lattice_.axes.row0, gradient.row1 * begin_ + lattice_.axes.row1,
                      gradient.row2 * begin_ + lattice_.axes.row2};
    // Rows of `along`: the Jacobian's columns. Their coordinates in the box are axes * row.
    const Vec3d step = transposed_times(inverse(along), from_box(off));
    const double least_part = norm(off) <= kFound * norm(lattice_.lengths) ? 1 : 1e-3;
    bool is_nearer = false;
    for (double part = 1; part >= least_part && !is_nearer; part *= 0.5) {
      const Vec3d next = near_box(at - step * part);
      Mat3d next_gradient;
      const Vec3d next_off = miss(next, &next_gradient);
      if (!(norm(next_off) < norm(off))) continue;
      is_nearer = true;
      at = next;
      off = next_off;
      gradient = next_gradient;
    }
    if (!is_nearer) break;
  }
  if (!(norm(off) <= kFound * norm(lattice_.lengths))) return std::nullopt;
  return inside(at);
}

// Returns the place in the box at t = 0 of the point that is at x at the beginning; nothing if it rests.
std::optional<Vec3d> LatticeMap::find(const Vec3d& x) const {
  const Vec3d at = to_box(x);
  if (begin_ == 0) return inside(at);
  if (support_.misses(x, 0)) return std::nullopt;
  Vec3d clamped = at;
  for (std::size_t axis = 0; axis < 3; ++axis) clamped[axis] = std::clamp(at[axis], 0.0, lattice_.lengths[axis]);
  const Vec3d guess = at - lattice_.axes * displacement(clamped, nullptr) * begin_;
  if (std::optional<Vec3d> found = search(at, guess)) return found;
  std::vector<std::pair<double, std::size_t>> nearest;
  for (std::size_t i = 0; i < stations_.size(); ++i) nearest.emplace_back(norm2(stations_[i].first - at), i);
  const std::size_t tried = std::min(kStationsTried, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(tried), nearest.end());
  for (std::size_t i = 0; i < tried; ++i) {
    if (std::optional<Vec3d> found = search(at, stations_[nearest[i].second].second)) return found;
  }
  return std::nullopt;
}

bool LatticeMap::move(Vec3d& x) const {
  const std::optional<Vec3d> at = find(x);
  if (!at) return false;
  x += displacement(*at, nullptr) * (end_ - begin_);
  return true;
}

bool LatticeMap::move(Vec3d& x, Mat3d& jacobian) const {
  jacobian = {};
  const std::optional<Vec3d> at = find(x);
  if (!at) return false;
  Mat3d gradient;
  x += displacement(*at, &gradient) * (end_ - begin_);
  jacobian = jacobian_at(gradient, end_);
  if (begin_ != 0) jacobian = jacobian * inverse(jacobian_at(gradient, begin_));
  return true;
}

Vec3d LatticeMap::velocity(const Vec3d& x) const {
  const std::optional<Vec3d> at = find(x);
  return at ? displacement(*at, nullptr) : Vec3d{0, 0, 0};
}

Vec3d LatticeMap::tangent(const Vec3d& x, const Mat3d& jacobian, std::span<const double> rates) const {
  const std::optional<Vec3d> at = find(x);
  if (!at) return {0, 0, 0};
  const Weights w = weights(*at);
  Vec3d sum{0, 0, 0};
  for_each(w, [&](std::size_t number, int i, int j, int k) {
    const double weight = w[0].value[i] * w[1].value[j] * w[2].value[k];
    sum += Vec3d{rates[3 * number], rates[3 * number + 1], rates[3 * number + 2]} * weight;
  });
  return sum * end_ - jacobian * sum * begin_;
}

void LatticeMap::add_gradient(const Vec3d& x, const Mat3d& jacobian, const Vec3d& gradient,
                              std::span<double> sums) const {
  const std::optional<Vec3d> at = find(x);
  if (!at) return;
  const Weights w = weights(*at);
  const Vec3d by_sum = gradient * end_ - transposed_times(jacobian, gradient) * begin_;
  for_each(w, [&](std::size_t number, int i, int j, int k) {
    const double weight = w[0].value[i] * w[1].value[j] * w[2].value[k];
    for (std::size_t axis = 0; axis < 3; ++axis) sums[3 * number + axis] += weight * by_sum[axis];
  });
}

}  // namespace knead::detail
