// Gaussian splats under a flow: covariances and spherical harmonics.
#include "knead/splats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"
#include "math/elementary.h"

namespace knead {

namespace {

constexpr std::size_t kMaxDegree = 3;
constexpr std::size_t kChannels = 3;
constexpr std::size_t kGrain = 4096;

// The columns of a matrix.
using Columns = std::array<Vec3d, 3>;

// Rotates the columns, in pairs, until they are orthogonal to each other: M V = U S for M given. Turns by at most 45
// degrees each time, so that columns stay near those that they were. Does the same with the columns of `also`.
void orthogonalise(Columns& m, Columns& also) {
  constexpr int kMaxSweeps = 30;
  constexpr double kOrthogonal = 1e-15;  // of the lengths' product
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool is_done = true;
    for (const auto& [i, k] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      const double a = norm2(m[i]);
      const double b = norm2(m[k]);
      const double c = dot(m[i], m[k]);
      if (std::abs(c) <= kOrthogonal * std::sqrt(a * b)) continue;
      is_done = false;
      const double zeta = (b - a) / (2 * c);
      const double t = (zeta < 0 ? -1 : 1) / (std::abs(zeta) + std::sqrt(1 + zeta * zeta));
      const double cosine = 1 / std::sqrt(1 + t * t);
      for (Columns* columns : {&m, &also}) {
        const Vec3d x = (*columns)[i];
        const Vec3d y = (*columns)[k];
        (*columns)[i] = (x - y * t) * cosine;
        (*columns)[k] = (y + x * t) * cosine;
      }
    }
    if (is_done) return;
  }
}

Columns columns_of(const Mat3d& m) { return {m.column(0), m.column(1), m.column(2)}; }

// Returns the rotation of the matrix's polar factors.
Mat3d rotation_of(const Mat3d& j) {
  Columns m = columns_of(j);
  Columns v = columns_of(Mat3d{});
  orthogonalise(m, v);
  Mat3d rotation{{}, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) rotation = rotation + outer_product(normalized(m[i]), v[i]);
  return rotation;
}

using Quaternion = std::array<double, 4>;  // w, x, y, z

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

// The real spherical harmonics of degrees 1 to 3 at a unit vector, with the signs and factors of those files.
std::array<double, 15> harmonics_at(const Vec3d& d) {
  const auto [x, y, z] = d;
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

// Turns the harmonics of one degree l: they are read in 2 l + 1 directions, which determine them.
class DegreeTurner {
 public:
  explicit DegreeTurner(std::size_t degree) : first_(degree * degree - 1), count_(2 * degree + 1) {
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
    for (std::size_t i = 0; i < count_; ++i) {  // spread over a half of the sphere: the other half says the same
      const double z = 1 - (static_cast<double>(i) + 0.5) / static_cast<double>(count_);
      const double r = std::sqrt(1 - z * z);
      const double angle = turn * static_cast<double>(i);
      directions_.push_back({r * elementary::cos(angle), r * elementary::sin(angle), z});
    }
    invert();
  }

  // Sets the coefficients to those of the function that has in R d the value that it has in d now.
  void turn(const Mat3d& rotation, std::array<double, 15>& coefficients) const {
    std::array<double, 7> values{};
    const Columns columns = columns_of(rotation);
    for (std::size_t i = 0; i < count_; ++i) {
      const Vec3d& d = directions_[i];
      const std::array<double, 15> y = harmonics_at({dot(columns[0], d), dot(columns[1], d), dot(columns[2], d)});
      for (std::size_t k = 0; k < count_; ++k) values[i] += coefficients[first_ + k] * y[first_ + k];
    }
    for (std::size_t k = 0; k < count_; ++k) {
      double sum = 0;
      for (std::size_t i = 0; i < count_; ++i) sum += inverse_[k * count_ + i] * values[i];
      coefficients[first_ + k] = sum;
    }
  }

 private:
  // Inverts the matrix of the harmonics in the directions, by Gauss and Jordan with pivots.
  void invert() {
    const std::size_t n = count_;
    std::vector<double> rows(2 * n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      const std::array<double, 15> y = harmonics_at(directions_[i]);
      for (std::size_t k = 0; k < n; ++k) rows[i * 2 * n + k] = y[first_ + k];
      rows[i * 2 * n + n + i] = 1;
    }
    for (std::size_t c = 0; c < n; ++c) {
      std::size_t pivot = c;
      for (std::size_t i = c; i < n; ++i) {
        if (std::abs(rows[i * 2 * n + c]) > std::abs(rows[pivot * 2 * n + c])) pivot = i;
      }
      for (std::size_t k = 0; k < 2 * n; ++k) std::swap(rows[c * 2 * n + k], rows[pivot * 2 * n + k]);
      const double by = 1 / rows[c * 2 * n + c];
      for (std::size_t k = 0; k < 2 * n; ++k) rows[c * 2 * n + k] *= by;
      for (std::size_t i = 0; i < n; ++i) {
        const double factor = i == c ? 0 : rows[i * 2 * n + c];
        for (std::size_t k = 0; k < 2 * n; ++k) rows[i * 2 * n + k] -= factor * rows[c * 2 * n + k];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      inverse_.insert(inverse_.end(), rows.begin() + static_cast<std::ptrdiff_t>(i * 2 * n + n),
                      rows.begin() + static_cast<std::ptrdiff_t>((i + 1) * 2 * n));
    }
  }

  std::size_t first_;  // of the 15 harmonics
  std::size_t count_;
  std::vector<Vec3d> directions_;
  std::vector<double> inverse_;
};

// The attributes of splats.
class SplatColumns {
 public:
  explicit SplatColumns(std::vector<Attribute>& attributes) {
    std::size_t rest = 0;
    while (find(attributes, fmt::format("f_rest_{}", rest)) != nullptr) ++rest;
    for (degree_ = 0; kChannels * (degree_ * (degree_ + 2)) < rest; ++degree_) {
    }
    if (degree_ > kMaxDegree || kChannels * (degree_ * (degree_ + 2)) != rest) {
      throw InvalidInput(fmt::format("splats have 0, 9, 24 or 45 harmonics f_rest_*, not {}", rest));
    }
    for (std::size_t i = 0; i < 3; ++i) scales_[i] = find(attributes, fmt::format("scale_{}", i));
    for (std::size_t i = 0; i < 4; ++i) turns_[i] = find(attributes, fmt::format("rot_{}", i));
    for (std::size_t i = 0; i < rest; ++i) harmonics_.push_back(find(attributes, fmt::format("f_rest_{}", i)));
  }

  std::size_t degree() const { return degree_; }

  std::array<double, 3> scales(std::size_t splat) const {
    return {(*scales_[0])[splat], (*scales_[1])[splat], (*scales_[2])[splat]};
  }
  void set_scale(std::size_t splat, std::size_t axis, double value) { (*scales_[axis])[splat] = value; }

  // Returns the unit quaternion; the identity for one without direction.
  Quaternion turn(std::size_t splat) const {
    Quaternion q{};
    double size2 = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      q[i] = (*turns_[i])[splat];
      size2 += q[i] * q[i];
    }
    if (!(size2 > 0) || !std::isfinite(size2)) return {1, 0, 0, 0};
    for (double& number : q) number /= std::sqrt(size2);
    return q;
  }
  void set_turn(std::size_t splat, const Quaternion& q) {
    for (std::size_t i = 0; i < 4; ++i) (*turns_[i])[splat] = q[i];
  }

  void turn_harmonics(std::size_t splat, const Mat3d& rotation, std::span<const DegreeTurner> turners) {
    const std::size_t count = harmonics_.size() / kChannels;
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
      std::array<double, 15> coefficients{};
      for (std::size_t k = 0; k < count; ++k) coefficients[k] = (*harmonics_[channel * count + k])[splat];
      for (std::size_t degree = 1; degree <= degree_; ++degree) turners[degree - 1].turn(rotation, coefficients);
      for (std::size_t k = 0; k < count; ++k) (*harmonics_[channel * count + k])[splat] = coefficients[k];
    }
  }

 private:
  static std::vector<double>* find(std::vector<Attribute>& attributes, const std::string& name) {
    for (Attribute& attribute : attributes) {
      const bool is_it = attribute.name == name && attribute.domain == Domain::vertex && attribute.components == 1;
      if (is_it) return &attribute.values;
    }
    return nullptr;
  }

  std::size_t degree_ = 0;
  std::array<std::vector<double>*, 3> scales_{};
  std::array<std::vector<double>*, 4> turns_{};
  std::vector<std::vector<double>*> harmonics_;
};

// Sets sizes and turn to those of J S J^T.
void deform(SplatColumns& columns, std::size_t splat, const Mat3d& j) {
  const Quaternion before = columns.turn(splat);
  Columns axes = axes_of(before);
  const std::array<double, 3> scales = columns.scales(splat);
  // Relative to the largest size, so that no square overflows or vanishes.
  const double largest = *std::max_element(scales.begin(), scales.end());
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = j * axes[i] * elementary::exp(std::max(scales[i] - largest, -300.0));
  }
  Columns unused{};
  orthogonalise(axes, unused);
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = norm(axes[i]);
    columns.set_scale(splat, i, largest + elementary::log(length));
    axes[i] = axes[i] / length;
  }
  if (dot(axes[0], cross(axes[1], axes[2])) < 0) axes[2] = -axes[2];  // a flow never mirrors; rounding may
  columns.set_turn(splat, quaternion_of(axes, before));
}

}  // namespace

bool are_splats(const Mesh& mesh) {
  const auto has = [&](const std::string& name) {
    const Attribute* attribute = mesh.find_attribute(name);
    return attribute != nullptr && attribute->domain == Domain::vertex && attribute->components == 1 &&
           attribute->type >= NumberType::float32;
  };
  if (mesh.face_count() > 0) return false;
  for (int i = 0; i < 3; ++i) {
    if (!has(fmt::format("scale_{}", i))) return false;
  }
  for (int i = 0; i < 4; ++i) {
    if (!has(fmt::format("rot_{}", i))) return false;
  }
  return true;
}

std::vector<Attribute> deformed_splats(const Mesh& splats, std::span<const Mat3d> jacobians, int threads,
                                       const Progress* progress) {
  if (!are_splats(splats)) throw InvalidInput("splats need scale_0 to scale_2 and rot_0 to rot_3, and no faces");
  if (jacobians.size() != splats.vertex_count()) throw InvalidInput("give a Jacobian for each splat");
  std::vector<Attribute> result;
  for (const Attribute& attribute : splats.attributes) {
    const auto begins = [&](const char* with) { return attribute.name.starts_with(with); };
    if (begins("scale_") || begins("rot_") || begins("f_rest_")) result.push_back(attribute);
  }
  SplatColumns columns(result);
  std::vector<DegreeTurner> turners;
  for (std::size_t degree = 1; degree <= columns.degree(); ++degree) turners.emplace_back(degree);
  parallel_for(jacobians.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(progress);
    for (std::size_t i = begin; i < end; ++i) {
      if (jacobians[i] == Mat3d{}) continue;
      deform(columns, i, jacobians[i]);
      if (!turners.empty()) columns.turn_harmonics(i, rotation_of(jacobians[i]), turners);
    }
  });
  return result;
}

}  // namespace knead
