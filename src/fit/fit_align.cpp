// Checks of landmarks, and rigid maps and growths that bring pairs or surfaces together.
#include "fit/fit_align.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

constexpr std::size_t kMaxLandmarks = 2000;
constexpr int kWeightRounds = 5;  // in which pairs that disagree lose weight
constexpr int kClosestRounds = 15;
constexpr double kClosestShare = 0.8;     // of the closest pairs that count
constexpr double kMaxGrowthRatio = 0.95;  // of the distance after and before: with more, a shape does not grow

struct PointPairs {
  std::vector<Vec3d> from;
  std::vector<Vec3d> to;
};

PointPairs split(std::span<const FitPair> pairs) {
  PointPairs result;
  for (const FitPair& pair : pairs) {
    result.from.push_back(pair.source);
    result.to.push_back(pair.target);
  }
  return result;
}

// Returns the half angle from 0 to pi / 2 of a turn, by + and * only (Newton's method).
double half_angle(double sine, double cosine) {
  double angle = sine * std::numbers::pi / 2;
  for (int i = 0; i < 20; ++i) {
    const SinCos<double> at = sincos(angle);
    angle += sine * at.cos - cosine * at.sin;
  }
  return angle;
}

template <std::size_t n>
using Matrix = std::array<std::array<double, n>, n>;

// Makes the entry (p, q) of a symmetric matrix 0 by a Jacobi rotation, which it also applies to `vectors`.
template <std::size_t n>
void rotate(Matrix<n>& m, Matrix<n>& vectors, std::size_t p, std::size_t q) {
  const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
  const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(1 + theta * theta));
  const double c = 1 / std::sqrt(1 + t * t);
  const double s = t * c;
  const auto turn = [&](double& a, double& b) {
    const double old = a;
    a = c * old - s * b;
    b = s * old + c * b;
  };
  for (std::size_t k = 0; k < n; ++k) turn(m[k][p], m[k][q]);
  for (std::size_t k = 0; k < n; ++k) turn(m[p][k], m[q][k]);
  for (std::size_t k = 0; k < n; ++k) turn(vectors[k][p], vectors[k][q]);
}

struct Axes {
  Vec3d middle;
  std::array<Vec3d, 3> directions;  // right-handed, by descending extent
};

// Returns the principal axes of points, by Jacobi rotations of their covariance.
Axes axes_of(const std::vector<SurfaceSample>& samples) {
  Axes result{{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
  for (const SurfaceSample& s : samples) result.middle += s.point / static_cast<double>(samples.size());
  Matrix<3> m{};
  for (const SurfaceSample& s : samples) {
    const Vec3d d = s.point - result.middle;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) m[i][k] += d[i] * d[k];
    }
  }
  Matrix<3> v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int sweep = 0; sweep < 12; ++sweep) {
    for (std::size_t p = 0; p < 2; ++p) {
      for (std::size_t q = p + 1; q < 3; ++q) {
        if (std::abs(m[p][q]) > 1e-15 * (m[0][0] + m[1][1] + m[2][2])) rotate<3>(m, v, p, q);
      }
    }
  }
  std::array<std::size_t, 3> by_extent{0, 1, 2};
  std::stable_sort(by_extent.begin(), by_extent.end(), [&](std::size_t a, std::size_t b) { return m[a][a] > m[b][b]; });
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t k = by_extent[i];
    result.directions[i] = Vec3d{v[0][k], v[1][k], v[2][k]};
  }
  result.directions[2] = cross(result.directions[0], result.directions[1]);
  return result;
}

std::vector<SurfaceSample> moved(const std::vector<SurfaceSample>& samples, const RigidMap& map) {
  std::vector<SurfaceSample> result = samples;
  for (SurfaceSample& s : result) s = {map(s.point), map.turn * s.normal};
  return result;
}

double mean_distance(const std::vector<SurfaceSample>& a, const SampleTree& of_b, double normal_length) {
  double sum = 0;
  for (const SurfaceSample& s : a) {
    const SurfaceSample& found = of_b[of_b.nearest(s)];
    sum += std::sqrt(norm2(found.point - s.point) + normal_length * normal_length * norm2(found.normal - s.normal));
  }
  return sum / static_cast<double>(a.size());
}

double distance_of(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                   const SampleTree& of_target, double normal_length) {
  const SampleTree of_source(source, normal_length);
  return mean_distance(source, of_target, normal_length) + mean_distance(target, of_source, normal_length);
}

// Returns the points of the source with the points of the target nearest to their present positions, without the
// farthest pairs.
PointPairs closest_pairs(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& now,
                         const SampleTree& target) {
  std::vector<std::pair<double, std::size_t>> order;
  std::vector<Vec3d> places;
  for (std::size_t i = 0; i < source.size(); ++i) {
    places.push_back(target[target.nearest(now[i])].point);
    order.emplace_back(norm2(places.back() - now[i].point), i);
  }
  std::sort(order.begin(), order.end());
  order.resize(static_cast<std::size_t>(kClosestShare * static_cast<double>(order.size())));
  PointPairs result;
  for (const auto& [distance, i] : order) {
    result.from.push_back(source[i].point);
    result.to.push_back(places[i]);
  }
  return result;
}

// Returns the map that iterated closest points reach from a start.
RigidMap closest_points(const std::vector<SurfaceSample>& source, const SampleTree& target, RigidMap map) {
  for (int round = 0; round < kClosestRounds; ++round) {
    const PointPairs pairs = closest_pairs(source, moved(source, map), target);
    map = nearest_rigid(pairs.from, pairs.to);
  }
  return map;
}

std::vector<SurfaceSample> moved(const std::vector<SurfaceSample>& samples, const Growth& growth) {
  std::vector<SurfaceSample> result = samples;
  for (SurfaceSample& s : result) s.point = growth(s.point);
  return result;
}

Vec3d mean_of(const std::vector<Vec3d>& points) {
  Vec3d sum{0, 0, 0};
  for (const Vec3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// Returns the growth with the least sum of squares.
Growth nearest_growth(const PointPairs& pairs) {
  Growth result{1, mean_of(pairs.from), mean_of(pairs.to)};
  double both = 0;
  double own = 0;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    const Vec3d from = pairs.from[i] - result.from;
    both += dot(from, pairs.to[i] - result.to);
    own += norm2(from);
  }
  if (both > 0 && own > 0) result.factor = both / own;
  return result;
}

double rms_of(const Growth& growth, const PointPairs& pairs) {
  double sum = 0;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) sum += norm2(growth(pairs.from[i]) - pairs.to[i]);
  return std::sqrt(sum / static_cast<double>(pairs.from.size()));
}

// Returns an eigenvector of the greatest eigenvalue. If several are equally great, returns the combination of their
// vectors that is nearest to the first axis: points on a line, for instance, leave the turn about it undetermined, and
// rounding must not decide it.
std::array<double, 4> greatest_vector(Matrix<4> m) {
  constexpr int kMaxSweeps = 12;
  constexpr double kMaxRest = 1e-15;        // of off-diagonal entries, relative to the diagonal
  constexpr double kEqualTolerance = 1e-6;  // of eigenvalues
  Matrix<4> vectors{};
  double size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    vectors[i][i] = 1;
    size = std::fmax(size, std::abs(m[i][i]));
  }
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool is_done = true;
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (!(std::abs(m[p][q]) > kMaxRest * size)) continue;
        rotate<4>(m, vectors, p, q);
        is_done = false;
      }
    }
    if (is_done) break;
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) best = m[i][i] > m[best][best] ? i : best;
  std::array<double, 4> sum{};
  int count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (m[i][i] < m[best][best] - kEqualTolerance * size) continue;
    ++count;
    for (std::size_t k = 0; k < 4; ++k) sum[k] += vectors[0][i] * vectors[k][i];
  }
  if (count > 1 && sum[0] > kEqualTolerance) return sum;
  return {vectors[0][best], vectors[1][best], vectors[2][best], vectors[3][best]};
}

Vec3d mean_of(std::span<const Vec3d> points, std::span<const double> weights) {
  Vec3d sum{0, 0, 0};
  double weight = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    sum += (points[i] - points[0]) * w;
    weight += w;
  }
  return points[0] + sum / weight;
}

}  // namespace

Quaternion part_of(const Quaternion& turn, double part) {
  const double sign = turn.w < 0 ? -1 : 1;
  const double w = 1 - part + part * sign * turn.w;
  const Vec3d v = turn.v * (part * sign);
  const double size = std::sqrt(w * w + norm2(v));
  return {w / size, v / size};
}

Quaternion nearest_turn(const Mat3d& sum) {
  const Vec3d& x = sum.row0;
  const Vec3d& y = sum.row1;
  const Vec3d& z = sum.row2;
  // Horn 1987, with the rows of `sum` belonging to the places.
  const Vec3d skew{z.y - y.z, x.z - z.x, y.x - x.y};
  const Matrix<4> m{{{x.x + y.y + z.z, skew.x, skew.y, skew.z},
                     {skew.x, x.x - y.y - z.z, x.y + y.x, x.z + z.x},
                     {skew.y, x.y + y.x, y.y - x.x - z.z, y.z + z.y},
                     {skew.z, x.z + z.x, y.z + z.y, z.z - x.x - y.y}}};
  const std::array<double, 4> q = greatest_vector(m);
  const double sign = q[0] < 0 ? -1 : 1;
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {sign * q[0] / size, Vec3d{q[1], q[2], q[3]} * (sign / size)};
}

RigidMap nearest_rigid(std::span<const Vec3d> from, std::span<const Vec3d> to, std::span<const double> weights) {
  RigidMap map{{}, mean_of(from, weights), mean_of(to, weights)};
  Mat3d sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  for (std::size_t i = 0; i < from.size(); ++i) {
    sum = sum + outer_product(to[i] - map.to, (from[i] - map.from) * (weights.empty() ? 1 : weights[i]));
  }
  map.turn = nearest_turn(sum);
  return map;
}

double rms_of(const RigidMap& map, std::span<const Vec3d> from, std::span<const Vec3d> to) {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += norm2(map(from[i]) - to[i]);
  return std::sqrt(sum / static_cast<double>(from.size()));
}

void require(bool holds, const std::string& what) {
  if (!holds) throw InvalidInput(what);
}

void require_usable(const BodyFitOptions& options) {
  require(options.landmarks.size() <= kMaxLandmarks,
          fmt::format("at most {} landmarks can be met, got {}; give the others as a map", kMaxLandmarks,
                      options.landmarks.size()));
  require(options.max_stretch > 1 && std::isfinite(options.max_stretch),
          fmt::format("the greatest stretch must be a number above 1, got {}", options.max_stretch));
  require(options.threads >= 0, fmt::format("the number of threads must be 0 or more, got {}", options.threads));
  for (const std::vector<FitPair>* pairs : {&options.landmarks, &options.map}) {
    for (std::size_t i = 0; i < pairs->size(); ++i) {
      const FitPair& pair = (*pairs)[i];
      const bool is_finite = knead::is_finite(pair.source) && knead::is_finite(pair.target);
      require(is_finite, fmt::format("pair {} is not finite, counted from 0", i));
      require(pair.tolerance >= 0 && std::isfinite(pair.tolerance),
              fmt::format("the tolerance of pair {} must be a length of 0 or more, got {}", i, pair.tolerance));
    }
  }
}

void require_apart(std::span<const FitPair> landmarks, double diagonal) {
  constexpr double kSame = 1e-9;  // of the diagonal
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (std::size_t k = i + 1; k < landmarks.size(); ++k) {
      const double apart = norm(landmarks[i].source - landmarks[k].source);
      const double places = norm(landmarks[i].target - landmarks[k].target);
      const double slack = kSame * diagonal + landmarks[i].tolerance + landmarks[k].tolerance;
      if ((apart > kSame * diagonal || places <= slack) && (places > kSame * diagonal || apart <= slack)) continue;
      throw InvalidInput(fmt::format(
          "landmarks {} and {}, counted from 0, are {:.3g} apart on the source and {:.3g} on the target; remove one of "
          "them, or give both a tolerance",
          i, k, apart, places));
    }
  }
}

void require_near(const Box& source, const Box& target) {
  const Vec3d shift = target.center() - source.center();
  if (source.empty() || target.empty() || norm(shift) <= source.diagonal() + target.diagonal()) return;
  throw InvalidInput(
      fmt::format("the target lies {:.3g} away from the source; move the source by ({:.6g}, {:.6g}, {:.6g}) first, or "
                  "give landmarks",
                  norm(shift), shift.x, shift.y, shift.z));
}

void require_no_mirror(std::span<const FitPair> pairs, double diagonal) {
  constexpr std::size_t kMinPairs = 4;
  constexpr double kMinProperDistance = 0.05;  // of the diagonal
  constexpr double kMaxMirrorRatio = 0.3;
  if (pairs.size() < kMinPairs) return;
  const PointPairs s = split(pairs);
  const double proper = rms_of(nearest_rigid(s.from, s.to), s.from, s.to);
  std::vector<Vec3d> mirrored = s.from;
  for (Vec3d& p : mirrored) p.x = -p.x;
  const double mirror = rms_of(nearest_rigid(mirrored, s.to), mirrored, s.to);
  if (!(proper > kMinProperDistance * diagonal && mirror < kMaxMirrorRatio * proper)) return;
  throw InvalidInput(fmt::format(
      "the target's landmarks are the mirror image of the source's: they are {:.2g} of the diagonal from it, "
      "and {:.2g} from the shape as it is; mirror one shape and its landmarks, for instance by the sign of x",
      mirror / diagonal, proper / diagonal));
}

std::optional<RigidMap> align_pairs(std::span<const FitPair> pairs) {
  if (pairs.size() < 3) return std::nullopt;
  const PointPairs s = split(pairs);
  RigidMap map = nearest_rigid(s.from, s.to);
  for (int again = 0; again < kWeightRounds; ++again) {
    std::vector<double> distances;
    for (std::size_t i = 0; i < s.from.size(); ++i) distances.push_back(norm(map(s.from[i]) - s.to[i]));
    std::vector<double> sorted = distances;
    std::sort(sorted.begin(), sorted.end());
    const double far = 2 * sorted[sorted.size() / 2];
    if (!(far > 0)) break;
    std::vector<double> weights;
    weights.reserve(distances.size());
    for (const double distance : distances) weights.push_back(1 / (1 + distance * distance / (far * far)));
    map = nearest_rigid(s.from, s.to, weights);
  }
  return map;
}

SurfaceAlignment align_surfaces(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                                double diagonal) {
  const double normal_length = kNormalLength * diagonal;
  const SampleTree of_target(target, normal_length);
  const Axes a = axes_of(source);
  const Axes b = axes_of(target);
  SurfaceAlignment result;
  result.distance_before = distance_of(source, target, of_target, normal_length);
  result.distance = result.distance_before;
  std::vector<RigidMap> starts{RigidMap{}, RigidMap{{}, a.middle, b.middle}};
  for (const double x : {1.0, -1.0}) {
    for (const double y : {1.0, -1.0}) {
      const std::array<double, 3> signs{x, y, x * y};
      Mat3d sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
      for (std::size_t i = 0; i < 3; ++i) {
        sum = sum + outer_product(b.directions[i] * signs[i], a.directions[i]);
      }
      starts.push_back({nearest_turn(sum), a.middle, b.middle});
    }
  }
  for (const RigidMap& start : starts) {
    const RigidMap map = closest_points(source, of_target, start);
    const double distance = distance_of(moved(source, map), target, of_target, normal_length);
    if (!(distance < result.distance)) continue;
    result.distance = distance;
    result.map = map;
  }
  return result;
}

std::optional<Growth> growth_of(const std::vector<SurfaceSample>& source, const std::vector<SurfaceSample>& target,
                                double by_volume, double diagonal) {
  const double normal_length = kNormalLength * diagonal;
  const SampleTree of_target(target, normal_length);
  const Axes a = axes_of(source);
  const Axes b = axes_of(target);
  double size = 0;
  double size_of_target = 0;
  for (const SurfaceSample& s : source) size += norm2(s.point - a.middle);
  for (const SurfaceSample& s : target) size_of_target += norm2(s.point - b.middle);
  const double before = distance_of(source, target, of_target, normal_length);
  double least = kMaxGrowthRatio * before;
  std::optional<Growth> best;
  for (const double factor : {1.0, by_volume, std::sqrt(size_of_target / size)}) {
    Growth growth{factor, a.middle, b.middle};
    for (int round = 0; round < kClosestRounds; ++round) {
      growth = nearest_growth(closest_pairs(source, moved(source, growth), of_target));
    }
    const double distance = distance_of(moved(source, growth), target, of_target, normal_length);
    if (!(distance < least)) continue;
    least = distance;
    best = growth;
  }
  return best;
}

std::optional<Growth> growth_of(std::span<const FitPair> pairs) {
  if (pairs.size() < 3) return std::nullopt;
  const PointPairs s = split(pairs);
  const Growth growth = nearest_growth(s);
  return rms_of(growth, s) < kMaxGrowthRatio * rms_of(Growth{}, s) ? std::optional(growth) : std::nullopt;
}

std::vector<Stroke> strokes_of(const RigidMap& map, const Vec3d& center, double radius) {
  constexpr double kNoMotion = 1e-12;  // relative to the radius
  std::vector<Stroke> strokes;
  const double sine = norm(map.turn.v);
  if (sine > kNoMotion) {
    RotateStroke turn;
    turn.center = center;
    turn.axis = map.turn.v / sine;
    turn.angle_deg = 2 * half_angle(sine, map.turn.w) * 180 / std::numbers::pi;
    turn.inner = 1.05 * radius;
    turn.outer = 2 * radius;
    strokes.emplace_back(turn);
  }
  const Vec3d shift = map(center) - center;
  if (norm(shift) > kNoMotion * radius) {
    ImplicitStroke push;
    push.path = {center, center + shift};
    push.inner = 1.05 * radius;
    push.outer = 2 * radius;
    strokes.emplace_back(push);
  }
  return strokes;
}

}  // namespace knead::detail
