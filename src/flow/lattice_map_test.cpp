// Tests of the map of a box of control points: against a plain evaluation, there and back, its border, its derivatives,
// and the proof that it does not fold space.
#include "flow/lattice_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "flow/tangents.h"
#include "knead/error.h"
#include "knead/flow.h"
#include "support/random_fields.h"

namespace knead::lattice_map_test {

namespace {

using test::Random;

// By the recursion in the textbooks, from the knots on.
double spline(const std::vector<double>& knots, std::size_t i, int degree, double u) {
  if (degree == 0) return (u >= knots[i] && u < knots[i + 1]) || (u == 1 && knots[i] < 1 && knots[i + 1] == 1) ? 1 : 0;
  const auto p = static_cast<std::size_t>(degree);
  double sum = 0;
  if (knots[i + p] > knots[i]) sum += (u - knots[i]) / (knots[i + p] - knots[i]) * spline(knots, i, degree - 1, u);
  if (knots[i + p + 1] > knots[i + 1]) {
    sum += (knots[i + p + 1] - u) / (knots[i + p + 1] - knots[i + 1]) * spline(knots, i + 1, degree - 1, u);
  }
  return sum;
}

double polynomial(int count, int degree, int i, double u) {
  if (degree == count - 1)
    return std::tgamma(count) / (std::tgamma(i + 1) * std::tgamma(count - i)) * std::pow(u, i) *
           std::pow(1 - u, degree - i);
  std::vector<double> knots(static_cast<std::size_t>(degree), 0.0);
  for (int k = 0; k <= count - degree; ++k) knots.push_back(static_cast<double>(k) / (count - degree));
  knots.insert(knots.end(), static_cast<std::size_t>(degree), 1.0);
  return spline(knots, static_cast<std::size_t>(i), degree, u);
}

// Turned, with 2 to 7 control points along each edge. `layers` at each face rest.
LatticeMotion random_lattice(Random& random, double size, double amount, int layers, bool is_right = true) {
  LatticeMotion lattice;
  lattice.origin = random.in_box(size);
  const Vec3d x = random.unit();
  const Vec3d y = any_orthogonal(x);
  lattice.axes = {x, y, cross(x, y) * (is_right ? 1.0 : -1.0)};
  lattice.lengths = {size * random.uniform(0.5, 2), size * random.uniform(0.5, 2), size * random.uniform(0.5, 2)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lattice.counts[axis] = random.integer(layers > 0 ? 2 * layers + 1 : 2, 7);
    lattice.degrees[axis] =
        random.integer(1, 2) == 1 ? lattice.counts[axis] - 1 : std::min(lattice.counts[axis] - 1, 3);
  }
  std::vector<Vec3d> displacements;
  for (int i = 0; i < lattice.counts[0]; ++i) {
    for (int j = 0; j < lattice.counts[1]; ++j) {
      for (int k = 0; k < lattice.counts[2]; ++k) {
        const std::array<int, 3> at{i, j, k};
        bool rests = false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          rests = rests || at[axis] < layers || at[axis] >= lattice.counts[axis] - layers;
        }
        displacements.push_back(rests ? Vec3d{} : random.in_box(amount * size));
      }
    }
  }
  lattice.displacements = SharedVectors(displacements);
  return lattice;
}

Vec3d place_in(const LatticeMotion& lattice, const Vec3d& u) {
  return lattice.origin + lattice.axes.row0 * (u.x * lattice.lengths.x) +
         lattice.axes.row1 * (u.y * lattice.lengths.y) + lattice.axes.row2 * (u.z * lattice.lengths.z);
}

Vec3d random_unit_place(Random& random) { return (random.in_box(1) + Vec3d{1, 1, 1}) * 0.5; }

Vec3d plain_displacement(const LatticeMotion& lattice, const Vec3d& u) {
  Vec3d sum{0, 0, 0};
  std::size_t number = 0;
  for (int i = 0; i < lattice.counts[0]; ++i) {
    for (int j = 0; j < lattice.counts[1]; ++j) {
      for (int k = 0; k < lattice.counts[2]; ++k) {
        sum += lattice.displacements[number++] * (polynomial(lattice.counts[0], lattice.degrees[0], i, u.x) *
                                                  polynomial(lattice.counts[1], lattice.degrees[1], j, u.y) *
                                                  polynomial(lattice.counts[2], lattice.degrees[2], k, u.z));
      }
    }
  }
  return sum;
}

Segment segment_of(const LatticeMotion& lattice, double begin = 0, double end = 1) {
  Segment segment;
  segment.lattice = lattice;
  segment.begin = begin;
  segment.end = end;
  return segment;
}

AdvectOptions options_of(double size) {
  AdvectOptions options;
  options.tolerance = 1e-5 * size;
  return options;
}

std::vector<Vec3d> moved(const Flow& flow, std::vector<Vec3d> points, double size) {
  EXPECT_EQ(advect(flow, points, options_of(size)).status, AdvectStatus::done);
  return points;
}

// Sizes from 1e-3 to 1e3.
double size_of(int lattice) { return std::pow(10.0, lattice % 7 - 3); }

double least_determinant(const LatticeMotion& lattice, double until, int samples) {
  double least = 1e300;
  for (int t = 1; t <= samples; ++t) {
    const detail::LatticeMap map(segment_of(lattice, 0, until * t / samples));
    for (int n = 0; n < samples * samples * samples; ++n) {
      const Vec3d u{static_cast<double>(n % samples), static_cast<double>(n / samples % samples),
                    static_cast<double>(n / samples / samples)};
      Vec3d x = place_in(lattice, u / (samples - 1.0));
      Mat3d jacobian;
      map.move(x, jacobian);
      least = std::min(least, determinant(jacobian));
    }
  }
  return least;
}

}  // namespace

TEST(LatticeMap, IsThePlainSumOfItsPolynomials) {
  Random random(1);
  for (int n = 0; n < 40; ++n) {
    const double size = size_of(n);
    const LatticeMotion lattice = random_lattice(random, size, 0.3, 0, n % 2 == 0);
    validate(Flow{{segment_of(lattice)}});
    for (int k = 0; k < 20; ++k) {
      const Vec3d u = random_unit_place(random);
      const Vec3d x = place_in(lattice, u);
      const double part = random.uniform(0, 1);
      const Vec3d to = moved({{segment_of(lattice, 0, part)}}, {x}, size).front();
      EXPECT_LE(norm(to - x - plain_displacement(lattice, u) * part), 1e-12 * size) << n;
    }
  }
}

TEST(LatticeMap, PointsOnOpenFacesMoveAndPointsBeyondRest) {
  Random random(2);
  for (int n = 0; n < 20; ++n) {
    const LatticeMotion lattice = random_lattice(random, 1, 0.3, 0);
    for (int k = 0; k < 20; ++k) {
      Vec3d u = random_unit_place(random);
      const auto axis = static_cast<std::size_t>(random.integer(0, 2));
      u[axis] = random.integer(0, 1);
      const Vec3d on = place_in(lattice, u);
      EXPECT_NE(moved({{segment_of(lattice)}}, {on}, 1).front(), on);
      u[axis] = u[axis] == 0 ? -1e-6 : 1 + 1e-6;
      const Vec3d beyond = place_in(lattice, u);
      EXPECT_EQ(moved({{segment_of(lattice)}}, {beyond}, 1).front(), beyond);
    }
  }
}

// Where two layers rest, D and its derivatives are 0 at the face.
TEST(LatticeMap, IsSmoothAcrossClosedFaces) {
  Random random(3);
  for (int n = 0; n < 20; ++n) {
    const LatticeMotion lattice = random_lattice(random, 1, 0.1, 2);
    const detail::LatticeMap map(segment_of(lattice));
    for (int k = 0; k < 20; ++k) {
      Vec3d u = random_unit_place(random);
      const auto axis = static_cast<std::size_t>(random.integer(0, 2));
      const bool is_high = random.integer(0, 1) == 1;
      for (const double depth : {1e-4, 1e-6}) {
        u[axis] = is_high ? 1 - depth : depth;
        const Vec3d x = place_in(lattice, u);
        Vec3d to = x;
        Mat3d jacobian;
        EXPECT_TRUE(map.move(to, jacobian));
        EXPECT_LE(norm(to - x), 100 * depth * depth);
        const Mat3d rest = jacobian + Mat3d{} * -1.0;
        EXPECT_LE(std::sqrt(norm2(rest.row0) + norm2(rest.row1) + norm2(rest.row2)), 100 * depth);
      }
      u[axis] = is_high ? 1.1 : -0.1;
      const Vec3d outside = place_in(lattice, u);
      EXPECT_EQ(moved({{segment_of(lattice)}}, {outside}, 1).front(), outside);
    }
  }
}

TEST(LatticeMap, ZeroDisplacementsKeepAllBits) {
  Random random(4);
  LatticeMotion lattice = random_lattice(random, 1, 0, 0);
  std::vector<Vec3d> points;
  for (int k = 0; k < 100; ++k) points.push_back(place_in(lattice, random_unit_place(random)));
  EXPECT_EQ(moved({{segment_of(lattice)}}, points, 1), points);
}

// Parts put together are the whole, and the inverse brings everything back; open faces or not.
TEST(LatticeMap, GoesThereAndBackInParts) {
  Random random(5);
  for (int n = 0; n < 40; ++n) {
    const double size = size_of(n);
    LatticeMotion lattice = random_lattice(random, size, n % 2 == 0 ? 0.35 : 0.15, n % 2 == 0 ? 2 : 0);
    if (const auto fold = detail::find_fold(lattice)) {
      const double part = 0.9 * detail::time_without_fold(lattice, *fold);
      std::vector<Vec3d> less(lattice.displacements.begin(), lattice.displacements.end());
      for (Vec3d& d : less) d *= part;
      lattice.displacements = SharedVectors(less);
    }
    const Flow flow{{segment_of(lattice)}};
    std::vector<Vec3d> points;
    for (int k = 0; k < 200; ++k) points.push_back(place_in(lattice, random_unit_place(random)));
    const std::vector<Vec3d> whole = moved(flow, points, size);
    const std::vector<Vec3d> back = moved(inverse(flow), whole, size);
    const std::vector<Vec3d> half = moved(prefix(flow, 0.4), points, size);
    const std::vector<Vec3d> other = moved(flow_between(flow, 0.4, 1), half, size);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LE(norm(back[i] - points[i]), 1e-11 * size) << n;
      EXPECT_LE(norm(other[i] - whole[i]), 1e-11 * size) << n;
    }
    const std::vector<Mat3d> there = jacobians(flow, points, options_of(size));
    const std::vector<Mat3d> again = jacobians(inverse(flow), whole, options_of(size));
    const std::vector<Vec3d> v = velocities(flow, half, 0.4);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Mat3d unit = again[i] * there[i] + Mat3d{} * -1.0;
      EXPECT_LE(norm(unit.row0) + norm(unit.row1) + norm(unit.row2), 1e-7) << n;
      EXPECT_LE(norm(v[i] * 0.4 - (half[i] - points[i])), 1e-11 * size) << "path lines are straight";
    }
  }
}

TEST(LatticeMap, JacobiansAreThoseOfDifferences) {
  Random random(6);
  const LatticeMotion lattice = random_lattice(random, 1, 0.1, 0);
  const Flow flow{{segment_of(lattice)}};
  for (int k = 0; k < 20; ++k) {
    const Vec3d x = place_in(lattice, random_unit_place(random) * 0.9 + Vec3d{0.05, 0.05, 0.05});
    const Mat3d jacobian = jacobians(flow, std::vector{x}, options_of(1)).front();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vec3d by{0, 0, 0};
      by[axis] = 1e-5;
      const std::vector<Vec3d> to = moved(flow, {x + by, x - by}, 1);
      EXPECT_LE(norm((to[0] - to[1]) / 2e-5 - jacobian.column(axis)), 1e-8);
    }
  }
}

// By displacements, forwards, backwards and by differences; also of the inverse, and of points that D leaves in place.
TEST(LatticeMap, HasDerivativesByItsDisplacements) {
  Random random(7);
  for (const bool is_inverse : {false, true}) {
    const LatticeMotion lattice = random_lattice(random, 1, is_inverse ? 0.05 : 0, 0);
    Flow flow{{segment_of(lattice)}};
    std::vector<Vec3d> directions;
    for (std::size_t i = 0; i < lattice.displacements.size(); ++i) directions.push_back(random.in_box(1));
    std::vector<Vec3d> points;
    for (int k = 0; k < 50; ++k)
      points.push_back(place_in(lattice, random_unit_place(random) * 0.8 + Vec3d{0.1, 0.1, 0.1}));
    const auto changed = [&](double by) {
      LatticeMotion other = lattice;
      std::vector<Vec3d> list(lattice.displacements.begin(), lattice.displacements.end());
      for (std::size_t i = 0; i < list.size(); ++i) list[i] += directions[i] * by;
      other.displacements = SharedVectors(list);
      const Flow changed_flow{{segment_of(other)}};
      return moved(is_inverse ? inverse(changed_flow) : changed_flow, points, 1);
    };
    if (is_inverse) flow = inverse(flow);
    std::vector<double> rates{0, 0};
    for (const Vec3d& d : directions) rates.insert(rates.end(), {d.x, d.y, d.z});
    const detail::TangentOptions options{1e-9, 1e-9};
    std::vector<Vec3d> to = points;
    std::vector<Vec3d> tangents(points.size());
    detail::advect_tangents(flow.segments.front(), rates, to, tangents, options);
    const std::vector<Vec3d> more = changed(1e-5);
    const std::vector<Vec3d> less = changed(-1e-5);
    std::vector<Vec3d> gradient;
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LE(norm((more[i] - less[i]) / 2e-5 - tangents[i]), 1e-8);
      gradient.push_back(random.in_box(1));
      sum += dot(gradient.back(), tangents[i]);
    }
    const detail::FlowGradient back =
        detail::carry_back(flow, {{std::span<const double>(rates)}}, points, gradient, options);
    EXPECT_NEAR(back.variables.front().front(), sum, 1e-10);
  }
}

// Of random lattices about as strong as one that folds: what is proven has no fold at samples, and what is refused has
// one, or nearly.
TEST(LatticeMap, FoldsAreFoundAndNothingElse) {
  Random random(8);
  int folded = 0;
  for (int n = 0; n < 40; ++n) {
    const LatticeMotion lattice = random_lattice(random, size_of(n), random.uniform(0.02, 0.25), n % 3);
    const auto fold = detail::find_fold(lattice);
    if (!fold) {
      EXPECT_GT(least_determinant(lattice, 1, 12), 0) << n;
      continue;
    }
    ++folded;
    EXPECT_LT(fold->determinant, 1e-3) << n;
    if (fold->determinant <= 0) {
      const detail::LatticeMap map(segment_of(lattice, 0, fold->time));
      Vec3d x = fold->place;
      Mat3d jacobian;
      map.move(x, jacobian);
      EXPECT_NEAR(determinant(jacobian), fold->determinant, 1e-6);
    }
    const double part = detail::time_without_fold(lattice, *fold);
    EXPECT_FALSE(detail::find_fold(lattice, part));
    EXPECT_LT(part, fold->time);
    EXPECT_GT(part, 0.1);
  }
  EXPECT_GT(folded, 5);
  EXPECT_LT(folded, 35);
}

// Squeezed along one edge: det J = 1 - slope at the middle, exactly.
TEST(LatticeMap, ANearFoldIsProvenSound) {
  for (const int degree : {2, 3, 6}) {
    for (const double left : {0.3, 0.02, 0.002, -0.002, -0.3}) {
      LatticeMotion lattice;
      lattice.counts = {7, 2, 3};
      lattice.degrees = {degree, 1, 2};
      Random random(9);
      lattice.lengths = {2, 1, 3};
      std::vector<Vec3d> displacements(42);
      // Equal steps between all control points give a constant slope in the middle piece.
      const detail::LatticeAxis axis(7, degree);
      for (std::size_t i = 0; i < 42; ++i) {
        displacements[i].x = -(1 - left) * 2 * axis.place(static_cast<int>(i / 6));
      }
      lattice.displacements = SharedVectors(displacements);
      EXPECT_EQ(detail::find_fold(lattice).has_value(), left < 0) << degree << " " << left;
    }
  }
}

// The end is turned by an angle: straight ways pass the axis only at 180 degrees.
TEST(LatticeMap, AHalfTurnFoldsOnItsWay) {
  for (const double degrees : {90.0, 150.0, 180.0}) {
    LatticeMotion lattice;
    lattice.counts = {2, 2, 2};
    lattice.degrees = {1, 1, 1};
    lattice.origin = {-0.5, -0.5, -0.5};
    std::vector<Vec3d> displacements;
    for (int n = 0; n < 8; ++n) {
      const Vec3d p{n / 4 - 0.5, n / 2 % 2 - 0.5, n % 2 - 0.5};
      const SinCos<double> turn = sincos(degrees * 0.017453292519943295);
      displacements.push_back(Vec3d{p.x * turn.cos - p.y * turn.sin, p.x * turn.sin + p.y * turn.cos, p.z} - p);
    }
    lattice.displacements = SharedVectors(displacements);
    const auto fold = detail::find_fold(lattice);
    EXPECT_EQ(fold.has_value(), degrees == 180) << degrees;
    if (fold) {
      EXPECT_NEAR(fold->time, 0.5, 0.01);
    }
  }
}

TEST(LatticeMap, WhatIsNoLatticeIsRefused) {
  const auto refused = [](const std::function<void(Segment&)>& change) {
    Random random(10);
    Segment segment = segment_of(random_lattice(random, 1, 0.1, 0));
    validate(Flow{{segment}});
    change(segment);
    EXPECT_THROW(validate(Flow{{segment}}), InvalidInput);
  };
  refused([](Segment& s) { s.lattice.counts[1] = 1; });
  refused([](Segment& s) { s.lattice.degrees[2] = s.lattice.counts[2]; });
  refused([](Segment& s) { s.lattice.lengths.x = 0; });
  refused([](Segment& s) { s.lattice.axes.row0 = s.lattice.axes.row1; });
  refused([](Segment& s) { s.lattice.displacements = SharedVectors(std::vector<Vec3d>(1)); });
  refused([](Segment& s) { s.displacement = {1, 0, 0}; });
  refused([](Segment& s) { s.grid.coefficients = SharedVectors(std::vector<Vec3d>(1)); });
}

}  // namespace knead::lattice_map_test
