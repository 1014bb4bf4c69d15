// Proves that a lattice does not fold space, by Bernstein coefficients and subdivision.
#include "flow/lattice_map.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace knead::detail {
namespace {

constexpr std::size_t kMaxPieces = 40'000;
constexpr double kBound = 0.98;  // than 1: the bound of a piece, with room for rounding
constexpr int kTrials = 8;

// The numbers of coefficients along the three axes.
using BernsteinSizes = std::array<int, 3>;

std::size_t number_of(const BernsteinSizes& sizes, int i, int j, int k) {
  const int number = (i * sizes[1] + j) * sizes[2] + k;
  return static_cast<std::size_t>(number);
}

// A part of the box and of the time: D there in Bernstein's basis, in the coordinates of the box.
struct BoxPiece {
  std::vector<Vec3d> coefficients;
  Vec3d from;
  Vec3d size;
  double begin = 0;
  double end = 1;
};

// Calls body(derivative along the axis) for all its coefficients.
template <class Body>
void for_each_rate(const BoxPiece& piece, const BernsteinSizes& sizes, std::size_t axis, const Body& body) {
  BernsteinSizes counts = sizes;
  --counts[axis];
  const double by = counts[axis] / piece.size[axis];
  const std::array<int, 3> next{axis == 0 ? 1 : 0, axis == 1 ? 1 : 0, axis == 2 ? 1 : 0};
  for (int i = 0; i < counts[0]; ++i) {
    for (int j = 0; j < counts[1]; ++j) {
      for (int k = 0; k < counts[2]; ++k) {
        const Vec3d& low = piece.coefficients[number_of(sizes, i, j, k)];
        const Vec3d& high = piece.coefficients[number_of(sizes, i + next[0], j + next[1], k + next[2])];
        body((high - low) * by, std::array<int, 3>{i, j, k});
      }
    }
  }
}

Vec3d unit_vector(std::size_t axis) {
  Vec3d v{0, 0, 0};
  v[axis] = 1;
  return v;
}

// Returns the first corner where the determinant is at most 0. Corner coefficients are values.
std::optional<LatticeFold> fold_at_corners(const BoxPiece& piece, const BernsteinSizes& sizes) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::array<Vec3d, 3> rates;
    Vec3d place = piece.from;
    BernsteinSizes at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_high = (corner >> axis & 1U) != 0;
      at[axis] = is_high ? sizes[axis] - 1 : 0;
      if (is_high) place[axis] += piece.size[axis];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int step = at[axis] == 0 ? 1 : -1;
      BernsteinSizes other = at;
      other[axis] += step;
      const Vec3d difference = piece.coefficients[number_of(sizes, other[0], other[1], other[2])] -
                               piece.coefficients[number_of(sizes, at[0], at[1], at[2])];
      rates[axis] = difference * (step * (sizes[axis] - 1) / piece.size[axis]);
    }
    const Mat3d j{rates[0] * piece.end + Vec3d{1, 0, 0}, rates[1] * piece.end + Vec3d{0, 1, 0},
                  rates[2] * piece.end + Vec3d{0, 0, 1}};
    if (!(determinant(j) > 0)) return LatticeFold{place, piece.end, determinant(j)};
  }
  return std::nullopt;
}

// Divides a piece in halves_of along an axis, by de Casteljau's algorithm; axis 3 is the time.
std::array<BoxPiece, 2> halves_of(BoxPiece piece, const BernsteinSizes& sizes, std::size_t axis) {
  std::array<BoxPiece, 2> result{piece, std::move(piece)};
  auto& [low, high] = result;
  if (axis == 3) {
    low.end = high.begin = 0.5 * (low.begin + low.end);
    return result;
  }
  low.size[axis] *= 0.5;
  high.size[axis] *= 0.5;
  high.from[axis] += high.size[axis];
  const int count = sizes[axis];
  BernsteinSizes lines = sizes;
  lines[axis] = 1;
  const std::size_t stride = axis == 2   ? 1
                             : axis == 1 ? static_cast<std::size_t>(sizes[2])
                                         : static_cast<std::size_t>(sizes[1] * sizes[2]);
  for (int i = 0; i < lines[0]; ++i) {
    for (int j = 0; j < lines[1]; ++j) {
      for (int k = 0; k < lines[2]; ++k) {
        Vec3d* const to_low = low.coefficients.data() + number_of(sizes, i, j, k);
        Vec3d* const to_high = high.coefficients.data() + number_of(sizes, i, j, k);
        for (int step = 1; step < count; ++step) {  // `high` holds what is left of the triangle
          for (int m = 0; m < count - step; ++m) {
            Vec3d& at = to_high[static_cast<std::size_t>(m) * stride];
            at = (at + to_high[static_cast<std::size_t>(m + 1) * stride]) * 0.5;
          }
          to_low[static_cast<std::size_t>(step) * stride] = to_high[0];
        }
      }
    }
  }
  return result;
}

// What is known of a piece.
struct PieceVerdict {
  bool is_sound = false;
  std::size_t split = 0;   // else: the axis along which it should be divided
  double determinant = 0;  // in its middle, about
};

PieceVerdict judge_piece(const BoxPiece& piece, const BernsteinSizes& sizes) {
  const double middle = 0.5 * (piece.begin + piece.end);
  std::array<Vec3d, 3> mean;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d sum{0, 0, 0};
    double count = 0;
    for_each_rate(piece, sizes, axis, [&](const Vec3d& rate, const std::array<int, 3>& /*at*/) {
      sum += rate;
      ++count;
    });
    mean[axis] = unit_vector(axis) + sum * (middle / count);
  }
  const Vec3d c0 = cross(mean[1], mean[2]);
  const Vec3d c1 = cross(mean[2], mean[0]);
  const Vec3d c2 = cross(mean[0], mean[1]);
  PieceVerdict verdict;
  verdict.determinant = dot(mean[0], c0);
  const double least = 1e-12;
  const bool is_regular = verdict.determinant > least;  // else the piece is only divided
  const Mat3d inverse = is_regular ? Mat3d{c0, c1, c2} * (1 / verdict.determinant) : Mat3d{};
  double bound = 0;
  std::array<double, 4> varies{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double most = 0;
    std::vector<Vec3d> seen(piece.coefficients.size());
    for_each_rate(piece, sizes, axis, [&](const Vec3d& rate, const std::array<int, 3>& at) {
      const Vec3d by_time = inverse * rate;
      const Vec3d rest = inverse * unit_vector(axis) - unit_vector(axis);
      most = std::max({most, norm2(rest + by_time * piece.begin), norm2(rest + by_time * piece.end)});
      varies[3] = std::max(varies[3], norm(by_time) * (piece.end - piece.begin));
      seen[number_of(sizes, at[0], at[1], at[2])] = by_time;
      for (std::size_t along = 0; along < 3; ++along) {
        if (at[along] == 0) continue;
        std::array<int, 3> before = at;
        --before[along];
        const Vec3d change = by_time - seen[number_of(sizes, before[0], before[1], before[2])];
        const int steps = sizes[along] - 1 - (along == axis ? 1 : 0);
        varies[along] = std::max(varies[along], norm(change) * steps * piece.end);
      }
    });
    bound += most;
  }
  verdict.is_sound = is_regular && bound < kBound * kBound;
  verdict.split = static_cast<std::size_t>(std::max_element(varies.begin(), varies.end()) - varies.begin());
  return verdict;
}

// The rows of the change from the control points of an interval of an axis to Bernstein's coefficients in it: polar
// forms (blossoms) of the polynomials.
std::vector<std::vector<double>> bernstein_rows(const LatticeAxis& axis, int interval) {
  const int p = axis.degree();
  std::vector<std::vector<double>> rows;
  const double low = axis.knot(interval + p);
  const double high = axis.knot(interval + p + 1);
  for (int b = 0; b <= p; ++b) {
    std::vector<double> row;
    for (int own = 0; own <= p; ++own) {
      std::vector<double> d(static_cast<std::size_t>(p) + 1, 0.0);
      d[static_cast<std::size_t>(own)] = 1;
      for (int r = 1; r <= p; ++r) {
        const double u = r <= b ? high : low;
        for (int i = p; i >= r; --i) {
          const double from = axis.knot(interval + i);
          const double to = axis.knot(interval + i + p + 1 - r);
          const auto at = static_cast<std::size_t>(i);
          d[at] = ((to - u) * d[at - 1] + (u - from) * d[at]) / (to - from);
        }
      }
      row.push_back(d[static_cast<std::size_t>(p)]);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// Returns the piece of a cell between knots, for all times; without coefficients if nothing moves there.
BoxPiece piece_of(const LatticeMotion& lattice, const std::array<LatticeAxis, 3>& axes, const std::array<int, 3>& cell,
                  const BernsteinSizes& sizes) {
  BoxPiece piece;
  for (int i = 0; i < sizes[0]; ++i) {
    for (int j = 0; j < sizes[1]; ++j) {
      for (int k = 0; k < sizes[2]; ++k) {
        const int number = ((cell[0] + i) * lattice.counts[1] + cell[1] + j) * lattice.counts[2] + cell[2] + k;
        piece.coefficients.push_back(lattice.axes * lattice.displacements[static_cast<std::size_t>(number)]);
      }
    }
  }
  if (std::all_of(piece.coefficients.begin(), piece.coefficients.end(), [](const Vec3d& d) { return d == Vec3d{}; })) {
    return {};
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = lattice.lengths[axis];
    piece.from[axis] = axes[axis].knot(cell[axis] + axes[axis].degree()) * length;
    piece.size[axis] = length / axes[axis].intervals();
    const auto rows = bernstein_rows(axes[axis], cell[axis]);
    std::vector<Vec3d> changed(piece.coefficients.size());
    for (int i = 0; i < sizes[0]; ++i) {
      for (int j = 0; j < sizes[1]; ++j) {
        for (int k = 0; k < sizes[2]; ++k) {
          std::array<int, 3> at{i, j, k};
          const std::vector<double>& row = rows[static_cast<std::size_t>(at[axis])];
          Vec3d sum{0, 0, 0};
          for (int m = 0; m < sizes[axis]; ++m) {
            at[axis] = m;
            sum += piece.coefficients[number_of(sizes, at[0], at[1], at[2])] * row[static_cast<std::size_t>(m)];
          }
          changed[number_of(sizes, i, j, k)] = sum;
        }
      }
    }
    piece.coefficients = std::move(changed);
  }
  return piece;
}

}  // namespace

std::optional<LatticeFold> find_fold(const LatticeMotion& lattice, double until) {
  const std::array<LatticeAxis, 3> axes = axes_of(lattice);
  BernsteinSizes sizes{};
  for (std::size_t axis = 0; axis < 3; ++axis) sizes[axis] = axes[axis].degree() + 1;
  const auto in_space = [&](LatticeFold fold) {
    const Vec3d& p = fold.place;
    fold.place = lattice.origin + lattice.axes.row0 * p.x + lattice.axes.row1 * p.y + lattice.axes.row2 * p.z;
    return fold;
  };
  std::size_t judged = 0;
  std::vector<BoxPiece> pieces;
  for (int i = 0; i < axes[0].intervals(); ++i) {
    for (int j = 0; j < axes[1].intervals(); ++j) {
      for (int k = 0; k < axes[2].intervals(); ++k) {
        BoxPiece whole = piece_of(lattice, axes, {i, j, k}, sizes);
        if (whole.coefficients.empty()) continue;
        whole.end = until;
        pieces.clear();
        pieces.push_back(std::move(whole));
        while (!pieces.empty()) {
          const BoxPiece piece = std::move(pieces.back());
          pieces.pop_back();
          const PieceVerdict verdict = judge_piece(piece, sizes);
          if (verdict.is_sound) continue;
          if (const auto fold = fold_at_corners(piece, sizes)) return in_space(*fold);
          if (++judged > kMaxPieces) {
            return in_space({piece.from + piece.size * 0.5, piece.end, verdict.determinant});
          }
          auto [first, second] = halves_of(piece, sizes, verdict.split);
          pieces.push_back(std::move(second));
          pieces.push_back(std::move(first));  // is next, so that the earliest fold is found
        }
      }
    }
  }
  return std::nullopt;
}

double time_without_fold(const LatticeMotion& lattice, const LatticeFold& fold) {
  double sound = 0;
  double folded = fold.time;
  for (int i = 0; i < kTrials; ++i) {
    const double middle = 0.5 * (sound + folded);
    (find_fold(lattice, middle) ? folded : sound) = middle;
  }
  return sound;
}

}  // namespace knead::detail
