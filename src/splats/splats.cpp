// Gaussian splats under a flow: covariances and spherical harmonics.
#include "knead/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"
#include "math/elementary.h"
#include "math/geometry.h"

namespace knead {

namespace {

constexpr std::size_t kMaxDegree = 3;
constexpr std::size_t kChannels = 3;
constexpr std::size_t kGrain = 4096;

constexpr std::size_t harmonics_of(std::size_t degree) { return kChannels * degree * (degree + 2); }

// The columns of a matrix.
using Columns = std::array<Vec3d, 3>;

Columns columns_of(const Mat3d& m) { return {m.column(0), m.column(1), m.column(2)}; }

using Quaternion = std::array<double, 4>;  // w, x, y, z

// The identity for one without direction.
Quaternion unit_of(Quaternion q) {
  double size2 = 0;
  for (const double number : q) size2 += number * number;
  if (!(size2 > 0) || !std::isfinite(size2)) return {1, 0, 0, 0};
  for (double& number : q) number /= std::sqrt(size2);
  return q;
}

Columns axes_of(const Quaternion& unit) {
  const auto [w, x, y, z] = unit;
  return {Vec3d{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          Vec3d{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          Vec3d{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

// Returns the unit quaternion of the rotation with these columns (Shepperd 1978), of the two the one nearer to `near`.
Quaternion quaternion_of(const Columns& axes, const Quaternion& near) {
  const auto& [a, b, c] = axes;
  const std::array<double, 4> squares{1 + a.x + b.y + c.z, 1 + a.x - b.y - c.z, 1 - a.x + b.y - c.z,
                                      1 - a.x - b.y + c.z};
  const auto largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const std::array<Quaternion, 4> candidates{
      Quaternion{squares[0], b.z - c.y, c.x - a.z, a.y - b.x}, Quaternion{b.z - c.y, squares[1], a.y + b.x, c.x + a.z},
      Quaternion{c.x - a.z, a.y + b.x, squares[2], b.z + c.y}, Quaternion{a.y - b.x, c.x + a.z, b.z + c.y, squares[3]}};
  Quaternion q = candidates[largest];
  double size2 = 0;
  double along = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    size2 += q[i] * q[i];
    along += q[i] * near[i];
  }
  for (double& number : q) number *= (along < 0 ? -1 : 1) / std::sqrt(size2);
  return q;
}

// The harmonics of degrees 1 to 3 at a unit vector.
inline std::array<double, 15> harmonics_at(double x, double y, double z) {
  const double xx = x * x;
  const double yy = y * y;
  const double zz = z * z;
  constexpr double c1 = 0.4886025119029199;  // sqrt(3 / (4 pi))
  constexpr double c2 = 1.0925484305920792;  // sqrt(15 / (4 pi))
  constexpr double c3 = 0.5900435899266435;  // sqrt(35 / (32 pi))
  constexpr double c4 = 0.4570457994644658;  // sqrt(21 / (32 pi))
  constexpr double c5 = 2.890611442640554;   // sqrt(105 / (4 pi))
  return {-c1 * y,
          c1 * z,
          -c1 * x,
          c2 * x * y,
          -c2 * y * z,
          0.31539156525252005 * (2 * zz - xx - yy),  // sqrt(5 / (16 pi))
          -c2 * x * z,
          c2 / 2 * (xx - yy),
          -c3 * y * (3 * xx - yy),
          c5 * x * y * z,
          -c4 * y * (4 * zz - xx - yy),
          0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy),  // sqrt(7 / (16 pi))
          -c4 * x * (4 * zz - xx - yy),
          c5 / 2 * z * (xx - yy),
          -c3 * x * (xx - 3 * yy)};
}

// A number of each of some splats, side by side for vector instructions.
constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;

// The coefficients of the harmonics of degrees 1 to 3, of red, green and blue.
using Channels = std::array<std::array<Lanes, 15>, kChannels>;

// The matrices of some splats, by columns.
using ColumnsOfLanes = std::array<std::array<Lanes, 3>, 3>;

// Turns the harmonics of one degree l: they are read in 2 l + 1 directions, which determine them.
template <std::size_t degree>
class DegreeTurner {
 public:
  DegreeTurner() {
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
    for (std::size_t i = 0; i < kCount; ++i) {  // spread over a half of the sphere: the other half says the same
      const double z = 1 - (static_cast<double>(i) + 0.5) / static_cast<double>(kCount);
      const double r = std::sqrt(1 - z * z);
      const double angle = turn * static_cast<double>(i);
      directions_[i] = {r * elementary::cos(angle), r * elementary::sin(angle), z};
    }
    invert();
  }

  // Sets the coefficients to those of the functions that have in R d the values that they have in d now.
  void turn(const ColumnsOfLanes& rotations, Channels& channels) const {
    std::array<std::array<Lanes, kCount>, kChannels> values{};
    for (std::size_t i = 0; i < kCount; ++i) {
      const std::array<Lanes, kCount> y = harmonics_in(directions_[i], rotations);
      for (std::size_t c = 0; c < kChannels; ++c) {
        for (std::size_t k = 0; k < kCount; ++k) add_product(channels[c][kFirst + k], y[k], values[c][i]);
      }
    }
    for (std::size_t c = 0; c < kChannels; ++c) {
      for (std::size_t k = 0; k < kCount; ++k) {
        Lanes sum{};
        for (std::size_t i = 0; i < kCount; ++i) {
          for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] += inverse_[k][i] * values[c][i][lane];
        }
        channels[c][kFirst + k] = sum;
      }
    }
  }

 private:
  static constexpr std::size_t kFirst = degree * degree - 1;  // of the 15 harmonics
  static constexpr std::size_t kCount = 2 * degree + 1;

  static void add_product(const Lanes& a, const Lanes& b, Lanes& to) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) to[lane] += a[lane] * b[lane];
  }

  // In the directions that the rotations turn to d.
  static std::array<Lanes, kCount> harmonics_in(const Vec3d& d, const ColumnsOfLanes& rotations) {
    std::array<Lanes, kCount> result{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const auto along = [&](std::size_t k) {
        return rotations[k][0][lane] * d.x + rotations[k][1][lane] * d.y + rotations[k][2][lane] * d.z;
      };
      const std::array<double, 15> y = harmonics_at(along(0), along(1), along(2));
      for (std::size_t k = 0; k < kCount; ++k) result[k][lane] = y[kFirst + k];
    }
    return result;
  }

  // Inverts the matrix of the harmonics in the directions, by Gauss and Jordan with pivots.
  void invert() {
    std::array<std::array<double, 2 * kCount>, kCount> rows{};
    for (std::size_t i = 0; i < kCount; ++i) {
      const std::array<double, 15> y = splat_harmonics(directions_[i]);
      std::copy_n(y.begin() + kFirst, kCount, rows[i].begin());
      rows[i][kCount + i] = 1;
    }
    for (std::size_t c = 0; c < kCount; ++c) {
      std::size_t pivot = c;
      for (std::size_t i = c; i < kCount; ++i) {
        if (std::abs(rows[i][c]) > std::abs(rows[pivot][c])) pivot = i;
      }
      std::swap(rows[c], rows[pivot]);
      const double by = 1 / rows[c][c];
      for (double& number : rows[c]) number *= by;
      for (std::size_t i = 0; i < kCount; ++i) {
        const double factor = i == c ? 0 : rows[i][c];
        for (std::size_t k = 0; k < 2 * kCount; ++k) rows[i][k] -= factor * rows[c][k];
      }
    }
    for (std::size_t i = 0; i < kCount; ++i) std::copy_n(rows[i].begin() + kCount, kCount, inverse_[i].begin());
  }

  std::array<Vec3d, kCount> directions_;
  std::array<std::array<double, kCount>, kCount> inverse_;
};

// The attributes of splats of this degree.
class SplatColumns {
 public:
  SplatColumns(std::vector<Attribute>& attributes, std::size_t degree) : degree_(degree) {
    const auto find = [&](const std::string& name) {
      const auto is_it = [&](const Attribute& attribute) { return attribute.name == name; };
      return &std::find_if(attributes.begin(), attributes.end(), is_it)->values;
    };
    for (std::size_t i = 0; i < 3; ++i) scales_[i] = find(fmt::format("scale_{}", i));
    for (std::size_t i = 0; i < 4; ++i) turns_[i] = find(fmt::format("rot_{}", i));
    for (std::size_t i = 0; i < harmonics_of(degree); ++i) harmonics_.push_back(find(fmt::format("f_rest_{}", i)));
  }

  std::array<double, 3> scales(std::size_t splat) const {
    return {(*scales_[0])[splat], (*scales_[1])[splat], (*scales_[2])[splat]};
  }
  void set_scale(std::size_t splat, std::size_t axis, double value) { (*scales_[axis])[splat] = value; }

  Quaternion turn(std::size_t splat) const {
    Quaternion q{};
    for (std::size_t i = 0; i < 4; ++i) q[i] = (*turns_[i])[splat];
    return unit_of(q);
  }
  void set_turn(std::size_t splat, const Quaternion& q) {
    for (std::size_t i = 0; i < 4; ++i) (*turns_[i])[splat] = q[i];
  }

  // Of splats [first, first + count), at most kLanes.
  void turn_harmonics(std::size_t first, std::size_t count, const ColumnsOfLanes& rotations) {
    const std::size_t each = harmonics_.size() / kChannels;
    Channels channels{};
    for (std::size_t i = 0; i < harmonics_.size(); ++i) {
      std::copy_n(harmonics_[i]->data() + first, count, channels[i / each][i % each].begin());
    }
    if (degree_ >= 1) first_.turn(rotations, channels);
    if (degree_ >= 2) second_.turn(rotations, channels);
    if (degree_ >= 3) third_.turn(rotations, channels);
    for (std::size_t i = 0; i < harmonics_.size(); ++i) {
      std::copy_n(channels[i / each][i % each].begin(), count, harmonics_[i]->data() + first);
    }
  }

 private:
  std::size_t degree_;
  std::array<std::vector<double>*, 3> scales_{};
  std::array<std::vector<double>*, 4> turns_{};
  std::vector<std::vector<double>*> harmonics_;
  DegreeTurner<1> first_;
  DegreeTurner<2> second_;
  DegreeTurner<3> third_;
};

// Returns the order in which the axes are nearest to others, and turns each to its side. A flow never mirrors: where
// the sides would, the axis that is across its own changes sides.
Columns in_order(const Columns& axes, const Columns& wanted, std::array<std::size_t, 3>& order) {
  constexpr std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  double most = -1;
  for (const auto& each : orders) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += std::abs(dot(axes[each[k]], wanted[k]));
    if (sum > most) order = each;
    most = std::max(most, sum);
  }
  Columns result;
  std::array<double, 3> along{};
  for (std::size_t k = 0; k < 3; ++k) {
    along[k] = dot(axes[order[k]], wanted[k]);
    result[k] = along[k] < 0 ? -axes[order[k]] : axes[order[k]];
    along[k] = std::abs(along[k]);
  }
  const auto across = static_cast<std::size_t>(std::min_element(along.begin(), along.end()) - along.begin());
  if (dot(result[0], cross(result[1], result[2])) < 0) result[across] = -result[across];
  return result;
}

// Sets sizes and turn to those of J S J^T. rotation: that of J's polar factors. The axes are ordered as those that it
// turns, so that the inverse gives back what was.
void deform(SplatColumns& columns, std::size_t splat, const Mat3d& j, const Mat3d& rotation) {
  const Quaternion before = columns.turn(splat);
  Columns axes = axes_of(before);
  const Columns turned{rotation * axes[0], rotation * axes[1], rotation * axes[2]};
  const std::array<double, 3> scales = columns.scales(splat);
  // Relative to the largest size, so that no square overflows or vanishes.
  const double largest = *std::max_element(scales.begin(), scales.end());
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = j * axes[i] * elementary::exp(std::max(scales[i] - largest, -300.0));
  }
  detail::orthogonalise(axes);
  std::array<double, 3> lengths{};
  for (std::size_t i = 0; i < 3; ++i) {
    lengths[i] = norm(axes[i]);
    axes[i] = axes[i] / lengths[i];
  }
  std::array<std::size_t, 3> order{};
  axes = in_order(axes, turned, order);
  for (std::size_t i = 0; i < 3; ++i) {
    columns.set_scale(splat, i, largest + elementary::log(lengths[order[i]]));
  }
  columns.set_turn(splat, quaternion_of(axes, before));
}

// Adds the direction d to those from which splats are seen: of each cell of a grid across it, the foremost ones are.
// half: the cells from the middle to a side.
void add_seen(std::span<const Vec3d> centers, const Vec3d& middle, const Vec3d& d, double cell, std::ptrdiff_t half,
              std::vector<Vec3d>& seen_from) {
  const Vec3d across = normalized(cross(d, std::abs(d.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
  const Vec3d up = cross(d, across);
  const std::ptrdiff_t side = 2 * half + 1;
  std::vector<double> foremost(static_cast<std::size_t>(side * side), std::numeric_limits<double>::lowest());
  const auto at = [&](const Vec3d& axis, const Vec3d& p) {
    const double place =
        std::clamp(dot(p - middle, axis) / cell, static_cast<double>(-half), static_cast<double>(half));
    return half + static_cast<std::ptrdiff_t>(std::round(place));
  };
  const auto depth = [&](const Vec3d& p) -> double& {
    return foremost[static_cast<std::size_t>(at(up, p) * side + at(across, p))];
  };
  for (const Vec3d& p : centers) depth(p) = std::max(depth(p), dot(p, d));
  for (std::size_t i = 0; i < centers.size(); ++i) {
    if (dot(centers[i], d) > depth(centers[i]) - cell) seen_from[i] += d;
  }
}

bool is_column(const Attribute& attribute) {
  return attribute.domain == Domain::vertex && attribute.components == 1 && attribute.type >= NumberType::float32;
}

bool has(const Mesh& mesh, const std::string& name) {
  const Attribute* const attribute = mesh.find_attribute(name);
  return attribute != nullptr && is_column(*attribute);
}

// Returns what deformed_splats() changes, at the chosen splats.
std::vector<Attribute> changing_attributes(const Mesh& mesh, std::span<const std::uint32_t> splats) {
  std::vector<Attribute> result;
  for (const Attribute& attribute : mesh.attributes) {
    const auto begins = [&](const char* with) { return attribute.name.starts_with(with); };
    if (!is_column(attribute) || !(begins("scale_") || begins("rot_") || begins("f_rest_"))) continue;
    Attribute& chosen = result.emplace_back(Attribute{attribute.name, attribute.domain, attribute.type, 1, {}});
    chosen.values.reserve(splats.size());
    for (const std::uint32_t splat : splats) chosen.values.push_back(attribute.values[splat]);
  }
  return result;
}

}  // namespace

bool are_splats(const Mesh& mesh) { return mesh.face_count() == 0 && have_splats(mesh); }

bool have_splats(const Mesh& mesh) {
  for (int i = 0; i < 3; ++i) {
    if (!has(mesh, fmt::format("scale_{}", i))) return false;
  }
  for (int i = 0; i < 4; ++i) {
    if (!has(mesh, fmt::format("rot_{}", i))) return false;
  }
  return true;
}

std::array<double, 15> splat_harmonics(const Vec3d& direction) {
  return harmonics_at(direction.x, direction.y, direction.z);
}

std::array<Vec3d, 3> splat_axes(std::array<double, 4> turn) { return axes_of(unit_of(turn)); }

std::size_t splat_degree(const Mesh& splats) {
  if (!have_splats(splats)) throw InvalidInput("splats need scale_0 to scale_2 and rot_0 to rot_3");
  std::size_t count = 0;
  while (has(splats, fmt::format("f_rest_{}", count))) ++count;
  for (std::size_t degree = 0; degree <= kMaxDegree; ++degree) {
    if (harmonics_of(degree) == count) return degree;
  }
  throw InvalidInput(fmt::format("splats have 0, 9, 24 or 45 harmonics f_rest_*, not {}", count));
}

std::vector<Vec3d> splat_normals(const Mesh& splats) {
  splat_degree(splats);
  constexpr double kSplatsOfCell = 16;  // so that hardly a cell has only those of the far side
  const Box box = shape_box(splats);
  const double half = std::ceil(std::sqrt(static_cast<double>(splats.vertex_count()) / kSplatsOfCell) / 2);
  const double cell = box.diagonal() / (2 * half);
  std::vector<Vec3d> result(splats.vertex_count());  // first the sums of the directions from which they are seen
  for (int k = 0; k < 27 && cell > 0; ++k) {
    const std::array<int, 3> step{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
    const Vec3d d(step[0], step[1], step[2]);
    if (d == Vec3d{}) continue;
    add_seen(splats.positions, box.center(), normalized(d), cell, static_cast<std::ptrdiff_t>(half), result);
  }
  const auto values_of = [&](const char* name, std::size_t k) {
    return splats.find_attribute(fmt::format("{}_{}", name, k))->values.data();
  };
  const std::array<const double*, 3> scales{values_of("scale", 0), values_of("scale", 1), values_of("scale", 2)};
  const std::array<const double*, 4> turns{values_of("rot", 0), values_of("rot", 1), values_of("rot", 2),
                                           values_of("rot", 3)};
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::size_t least = 0;
    for (std::size_t k = 1; k < 3; ++k) least = scales[k][i] < scales[least][i] ? k : least;
    const Vec3d axis = splat_axes({turns[0][i], turns[1][i], turns[2][i], turns[3][i]})[least];
    result[i] = dot(axis, result[i]) < 0 ? -axis : axis;
  }
  return result;
}

ChangedSplats deformed_splats(const Mesh& splats, const SplatJacobians& jacobians, int threads,
                              const Progress* progress) {
  const std::size_t degree = splat_degree(splats);
  const std::vector<Mat3d>& all = jacobians.jacobians;
  const bool fits =
      all.size() == jacobians.splats.size() && (all.empty() || jacobians.splats.back() < splats.vertex_count());
  if (!fits) throw InvalidInput("give a Jacobian for each splat, and splats that are there");
  ChangedSplats result{jacobians.splats, changing_attributes(splats, jacobians.splats)};
  SplatColumns columns(result.attributes, degree);
  parallel_for(all.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    for (std::size_t first = begin; first < end; first += kLanes) {
      const std::size_t count = std::min(kLanes, end - first);
      ColumnsOfLanes rotations{};
      for (std::size_t lane = 0; lane < count; ++lane) {
        const Mat3d rotation = nearest_rotation(all[first + lane]);
        deform(columns, first + lane, all[first + lane], rotation);
        const Columns of_lane = columns_of(rotation);
        for (std::size_t k = 0; k < 3; ++k) {
          for (std::size_t axis = 0; axis < 3; ++axis) rotations[k][axis][lane] = of_lane[k][axis];
        }
      }
      if (degree > 0) columns.turn_harmonics(first, count, rotations);
    }
  });
  return result;
}

}  // namespace knead
