#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "fit/fit_parts.h"
#include "flow/pins.h"

namespace knead::session_detail {

namespace {

// A landmark counts as much as so many matches that are sure.
constexpr double kLandmarkWeight = 1e3;
constexpr int kMaxRounds = 200;   // of conjugate gradients
constexpr double kEnough = 1e-4;  // of the residual
// Of their distance, two pins move by at most so much more than each other; of the radius, a pin by at most so much.
constexpr double kMaxStrain = 0.5;
constexpr double kMaxMotion = 0.3;

using Vectors = std::vector<Vec3d>;

double dot_of(const Vectors& a, const Vectors& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

// Farthest points: each the sample that is farthest from all before it, until none is farther than the spacing.
Vectors spaced(std::span<const SurfaceSample> samples, const Vectors& first, double spacing) {
  Vectors chosen = first;
  std::vector<double> square(samples.size(), std::numeric_limits<double>::infinity());
  const auto keep_off = [&](const Vec3d& place) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      square[i] = std::min(square[i], norm2(samples[i].point - place));
    }
  };
  for (const Vec3d& place : first) keep_off(place);
  while (true) {
    const auto farthest = std::max_element(square.begin(), square.end());
    if (!(*farthest > spacing * spacing)) return chosen;
    chosen.push_back(samples[static_cast<std::size_t>(farthest - square.begin())].point);
    keep_off(chosen.back());
  }
}

// The pins within a radius of a place, found in cells of that size.
class PinCells {
 public:
  PinCells(const Vectors& pins, double radius) : pins_(pins), radius_(radius) {
    for (std::uint32_t i = 0; i < pins.size(); ++i) order_.push_back({cell_of(pins[i]), i});
    std::sort(order_.begin(), order_.end());
  }

  // Calls visit(pin, offset in radii) for each.
  template <class Visit>
  void for_near(const Vec3d& place, const Visit& visit) const {
    const Cell middle = cell_of(place);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        // Cells that differ in z alone stand one after the other.
        const Cell from{middle[0] + dx, middle[1] + dy, middle[2] - 1};
        const Cell to{middle[0] + dx, middle[1] + dy, middle[2] + 1};
        auto entry = std::lower_bound(order_.begin(), order_.end(), Entry{from, 0});
        for (; entry != order_.end() && entry->cell <= to; ++entry) {
          const Vec3d x = (place - pins_[entry->pin]) / radius_;
          if (norm2(x) < 1) visit(entry->pin, x);
        }
      }
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Entry {
    Cell cell;
    std::uint32_t pin = 0;
    friend bool operator<(const Entry& a, const Entry& b) { return std::tie(a.cell, a.pin) < std::tie(b.cell, b.pin); }
  };

  Cell cell_of(const Vec3d& p) const {
    const Vec3d x = p / radius_;
    return {static_cast<std::int64_t>(std::floor(x.x)), static_cast<std::int64_t>(std::floor(x.y)),
            static_cast<std::int64_t>(std::floor(x.z))};
  }

  const Vectors& pins_;
  double radius_;
  std::vector<Entry> order_;
};

// min over a of sum over k of weight_k (direction_k . v(at_k) - by_k)^2 + smoothness (a . K a), with the field v = sum
// of Psi a_i at the pins, and K a its values there.
class FieldFit {
 public:
  FieldFit(const Vectors& pins, double radius, double smoothness)
      : pins_(pins), cells_(pins, radius), smoothness_(smoothness), diagonal_(pins.size(), smoothness) {
    for (const Vec3d& pin : pins) {
      cells_.for_near(pin, [&](std::uint32_t other, const Vec3d& x) {
        neighbors_.push_back({other, detail::pin_kernel(x)});
      });
      neighbors_end_.push_back(neighbors_.size());
    }
  }

  void add(const Match& match) {
    cells_.for_near(match.at, [&](std::uint32_t pin, const Vec3d& x) {
      const Vec3d entry = detail::pin_kernel(x) * match.direction;
      entries_.push_back({pin, entry});
      diagonal_[pin] += match.weight * norm2(entry) / 3;
    });
    rows_.push_back({entries_.size(), match.weight, match.by});
  }

  // Returns v at the pins, by conjugate gradients.
  Vectors solve(const Progress* progress) const {
    Vectors a(pins_.size());
    Vectors rest = right_side();
    Vectors direction = better(rest);
    double now = dot_of(rest, direction);
    const double enough = kEnough * kEnough * now;
    for (int round = 0; round < kMaxRounds && now > enough; ++round) {
      stop_if_cancelled(progress);
      const Vectors image = product(direction);
      const double step = now / dot_of(direction, image);
      for (std::size_t i = 0; i < a.size(); ++i) {
        a[i] += direction[i] * step;
        rest[i] -= image[i] * step;
      }
      const Vectors next = better(rest);
      const double then = dot_of(rest, next);
      for (std::size_t i = 0; i < a.size(); ++i) direction[i] = next[i] + direction[i] * (then / now);
      now = then;
    }
    return values(a);
  }

 private:
  struct Entry {
    std::uint32_t pin = 0;
    Vec3d vector;
  };
  struct Neighbor {
    std::uint32_t pin = 0;
    Mat3d kernel;  // Psi from one to the other
  };
  struct Row {
    std::size_t end = 0;  // of its entries
    double weight = 0;
    double by = 0;
  };

  // K a.
  Vectors values(const Vectors& a) const {
    Vectors result(a.size());
    std::size_t at = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (; at < neighbors_end_[i]; ++at) result[i] += neighbors_[at].kernel * a[neighbors_[at].pin];
    }
    return result;
  }

  // Calls body(row, begin of its entries).
  template <class Body>
  void for_rows(const Body& body) const {
    std::size_t begin = 0;
    for (const Row& row : rows_) {
      body(row, begin);
      begin = row.end;
    }
  }

  void spread(const Row& row, std::size_t begin, double value, Vectors& to) const {
    for (std::size_t e = begin; e < row.end; ++e) to[entries_[e].pin] += entries_[e].vector * value;
  }

  Vectors right_side() const {
    Vectors result(pins_.size());
    for_rows([&](const Row& row, std::size_t begin) { spread(row, begin, row.weight * row.by, result); });
    return result;
  }

  Vectors product(const Vectors& a) const {
    Vectors result = values(a);
    for (Vec3d& value : result) value *= smoothness_;
    for_rows([&](const Row& row, std::size_t begin) {
      double there = 0;
      for (std::size_t e = begin; e < row.end; ++e) there += dot(entries_[e].vector, a[entries_[e].pin]);
      spread(row, begin, row.weight * there, result);
    });
    return result;
  }

  Vectors better(const Vectors& rest) const {
    Vectors result = rest;
    for (std::size_t i = 0; i < rest.size(); ++i) result[i] *= 1 / diagonal_[i];
    return result;
  }

  const Vectors& pins_;
  PinCells cells_;
  double smoothness_;
  std::vector<double> diagonal_;
  std::vector<Neighbor> neighbors_;  // of each pin in turn
  std::vector<std::size_t> neighbors_end_;
  std::vector<Entry> entries_;
  std::vector<Row> rows_;
};

// By how much motions must be scaled.
double allowed(const Vectors& pins, const Vectors& motions, std::size_t free, double radius) {
  double most = 1;
  for (std::size_t i = free; i < pins.size(); ++i) {
    most = std::max(most, norm(motions[i]) / (kMaxMotion * radius));
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = norm(motions[i] - motions[j]);
      most = std::max(most, apart / (kMaxStrain * norm(pins[i] - pins[j])));
    }
  }
  return 1 / most;
}

}  // namespace

PinsStroke fit_pins(std::span<const Match> matches, std::span<const SurfaceSample> samples,
                    const FitLandmarks& landmarks, const PinFieldOptions& options) {
  PinsStroke stroke;
  const double radius = options.radius;
  stroke.radius = radius;
  stroke.points = spaced(samples, landmarks.at, kPinSpacing * radius);
  const std::size_t held = landmarks.at.size();
  const double share =
      static_cast<double>(stroke.points.size()) / static_cast<double>(std::max<std::size_t>(1, matches.size()));
  FieldFit field(stroke.points, radius, options.smoothness);
  for (const Match& match : matches) field.add({match.at, match.direction, match.by, match.weight * share});
  for (std::size_t i = 0; i < held; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d direction{0, 0, 0};
      direction[axis] = 1;
      field.add({landmarks.at[i], direction, (landmarks.to[i] - landmarks.at[i])[axis], kLandmarkWeight});
    }
  }
  const Vectors motions = field.solve(options.progress);
  const double scale = allowed(stroke.points, motions, held, radius);
  stroke.to = landmarks.to;
  for (std::size_t i = held; i < stroke.points.size(); ++i) {
    stroke.to.push_back(stroke.points[i] + motions[i] * scale);
  }
  return stroke;
}

}  // namespace knead::session_detail
