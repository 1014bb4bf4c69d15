// The equations of pins, and flows of pins and turns.
#include "flow/pins.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "field/dual.h"
#include "flow/path_jacobian.h"
#include "knead/error.h"
#include "support/pins_now.h"
#include "support/random_segments.h"

namespace knead::pins_test {
namespace {

using test::in_float;
using test::moved;
using test::pinning;
using test::precisely;
using test::Random;
using test::turning;

Vec3d motion_of(const Field& pin) { return std::get<Translation<double>>(pin.motion).velocity; }

// The velocity of fields that rest, at x.
Vec3d sum_at(const std::vector<Field>& fields, const Vec3d& x) {
  Vec3d sum{};
  for (const Field& field : fields) sum += velocity(field, x - field.center);
  return sum;
}

// The same by variables, for its gradient.
Vec3<Dual> dual_sum_at(const std::vector<Field>& fields, const Vec3d& x) {
  Vec3<Dual> sum{};
  for (const Field& field : fields) {
    std::visit(
        [&](const auto& motion) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(motion)>, CustomMotion>) {
            sum += velocity(motion, Ball<double>{}, field.thresholds, variables(x - field.center), Dual(0));
          }
        },
        field.motion);
  }
  return sum;
}

// Path lines by the method of Runge and Kutta with steps of equal length, in the fields of turning pins at each time.
std::vector<Vec3d> integrated_in_fields(const Segment& segment, std::vector<Vec3d> points, int steps) {
  const auto pieces = detail::solve_pins(segment, 1e-10);
  const double h = 1.0 / steps;
  for (int step = 0; step < steps; ++step) {
    const auto begin = detail::fields_at(segment, pieces, step * h);
    const auto middle = detail::fields_at(segment, pieces, (step + 0.5) * h);
    const auto end = detail::fields_at(segment, pieces, (step + 1) * h);
    for (Vec3d& x : points) {
      const Vec3d k1 = sum_at(begin, x);
      const Vec3d k2 = sum_at(middle, x + k1 * (h / 2));
      const Vec3d k3 = sum_at(middle, x + k2 * (h / 2));
      const Vec3d k4 = sum_at(end, x + k3 * h);
      x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6);
    }
  }
  return points;
}

// The rotation by |v| about v.
Mat3d rotation_by(const Vec3d& v) { return exp(Mat3d{{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}); }

// Path lines by the method of Runge and Kutta with steps of equal length.
std::vector<Vec3d> integrated(const Segment& segment, std::vector<Vec3d> points, int steps) {
  std::vector<Vec3d> from;
  std::vector<Vec3d> by;
  for (const Field& pin : segment.fields) {
    from.push_back(pin.center);
    by.push_back(motion_of(pin));
  }
  const double radius = segment.fields.front().thresholds.outer;
  const double h = 1.0 / steps;
  for (int step = 0; step < steps; ++step) {
    const oracle::PinsNow begin(from, by, radius, step * h);
    const oracle::PinsNow middle(from, by, radius, (step + 0.5) * h);
    const oracle::PinsNow end(from, by, radius, (step + 1) * h);
    for (Vec3d& x : points) {
      const Vec3d k1 = begin.velocity(x);
      const Vec3d k2 = middle.velocity(x + k1 * (h / 2));
      const Vec3d k3 = middle.velocity(x + k2 * (h / 2));
      const Vec3d k4 = end.velocity(x + k3 * h);
      x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6);
    }
  }
  return points;
}

std::vector<Vec3d> places_of(const Segment& segment, double t) {
  std::vector<Vec3d> places;
  for (const Field& pin : segment.fields) places.push_back(pin.center + motion_of(pin) * t);
  return places;
}

TEST(Pins, HaveTheKernelOfTheMethod) {
  Random random(801);
  for (int round = 0; round < 200; ++round) {
    const double radius = random.uniform(0.3, 2);
    const Vec3d a = random.in_box(1);
    const Vec3d d = random.in_box(1.2 * radius);
    const Field pin{{0, 0, 0}, Translation<double>{a}, Ball<double>{}, {0, radius, kPinFalloff}};
    EXPECT_NEAR(norm(velocity(pin, d) - oracle::pin_kernel(d, radius, a)), 0, 1e-13);
    const Vec3<Dual> v = velocity(Translation<double>{a}, Ball<double>{}, pin.thresholds, variables(d), Dual(0.0));
    EXPECT_NEAR(v.x.g.x + v.y.g.y + v.z.g.z, 0, 1e-11 / radius) << "the divergence";
  }
}

TEST(Pins, ArePolynomialsThatSolveTheEquationsAtEveryTime) {
  Random random(802);
  for (const int count : {1, 2, 7, 30}) {
    const Segment segment = pinning(random, count, 0.7, 0.3);
    const double tolerance = 1e-9;
    const auto pieces = detail::solve_pins(segment, tolerance);
    for (int k = 0; k <= 57; ++k) {
      const double t = k / 57.0;
      const std::vector<Field> fields = detail::fields_at(segment, pieces, t);
      for (const Field& at : fields) {
        Vec3d v{};
        for (const Field& pin : fields) v += velocity(pin, at.center - pin.center);
        const std::size_t i = static_cast<std::size_t>(&at - fields.data());
        EXPECT_NEAR(norm(v - motion_of(segment.fields[i])), 0, tolerance) << count << " pins, t = " << t;
      }
    }
  }
}

TEST(Pins, AreMetAtEveryTime) {
  Random random(803);
  for (const int count : {1, 3, 20, 100, 500}) {
    const double radius = count > 50 ? 0.35 : 0.8;
    const Segment segment = pinning(random, count, radius, 0.2, count > 50 ? 1.0 : 0.6);
    for (const double until : {0.31, 0.77, 1.0}) {
      if (count > 50 && until < 1) continue;
      const Flow flow = prefix(Flow{{segment}}, until);
      const std::vector<Vec3d> goal = places_of(segment, until);
      EXPECT_LE(test::greatest_distance(moved(flow, places_of(segment, 0), in_float(2e-5)), goal), 4e-5) << count;
      EXPECT_LE(test::greatest_distance(moved(flow, places_of(segment, 0), precisely(1e-10)), goal), 2e-10) << count;
    }
  }
}

TEST(Pins, AgreeWithPathLinesOfAnotherMethod) {
  Random random(804);
  for (int round = 0; round < 6; ++round) {
    const Segment segment = pinning(random, 2 + 3 * round, random.uniform(0.5, 1.5), 0.3);
    const std::vector<Vec3d> points = test::random_points(random, 300, 1.0);
    const std::vector<Vec3d> expected = integrated(segment, points, 300);
    EXPECT_LE(test::greatest_distance(moved(Flow{{segment}}, points, precisely(1e-9)), expected), 2e-8) << round;
    EXPECT_LE(test::greatest_distance(moved(Flow{{segment}}, points, in_float()), expected), 2e-5) << round;
  }
}

TEST(Pins, LeaveEverythingBeyondTheirRadiusAlone) {
  Random random(805);
  const Segment segment = pinning(random, 8, 0.3, 0.4);
  const std::vector<Vec3d> points = test::random_points(random, 20'000, 1.2);
  const std::vector<Vec3d> after = moved(Flow{{segment}}, points, in_float());
  int beyond = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool is_reached = std::ranges::any_of(segment.fields, [&](const Field& pin) {
      const Vec3d u = motion_of(pin);
      const Vec3d d = points[i] - pin.center;
      const double t = norm2(u) > 0 ? std::clamp(dot(d, u) / norm2(u), 0.0, 1.0) : 0.0;
      return norm(d - u * t) < pin.thresholds.outer;
    });
    if (is_reached) continue;
    ++beyond;
    EXPECT_EQ(after[i], points[i]);
  }
  EXPECT_GT(beyond, 1000);
}

// A great number of pins is chosen from in parts, and points are moved by those near them alone.
TEST(Pins, GiveTheSameBitsWhoeverTheirNeighboursAre) {
  Random random(806);
  const Segment segment = pinning(random, 300, 0.3, 0.1, 1.0);
  const std::vector<Vec3d> points = test::random_points(random, 3000, 1.1);
  for (const AdvectOptions& options : {in_float(), precisely(1e-8)}) {
    const std::vector<Vec3d> together = moved(Flow{{segment}}, points, options);
    AdvectOptions one_thread = options;
    one_thread.threads = 1;
    const std::vector<Vec3d> reversed_points(points.rbegin(), points.rend());
    const std::vector<Vec3d> reversed = moved(Flow{{segment}}, reversed_points, one_thread);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(together[i], reversed[points.size() - 1 - i]);
    for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(moved(Flow{{segment}}, {points[i]}, options)[0], together[i]);
  }
}

// The kernel of a matrix E is -sum E_kl d/dy_l (Psi e_k): the representer of <E, grad v>.
TEST(Turns, HaveDerivativesOfThePinsKernelAsKernels) {
  Random random(820);
  for (int round = 0; round < 100; ++round) {
    const Vec3d y = random.in_box(0.7);
    const std::array<Vec3d, 3> nodes{random.in_box(1), random.in_box(1), Vec3d{random.uniform(-1, 1), 0.5, 0}};
    const detail::TurnKernel turn = detail::turn_kernel(nodes);
    const Vec3d w = turn.rate;
    // Gradients at the pin are 75 times an antisymmetric E, 45 times a symmetric one.
    const Mat3d e = Mat3d{{0, -w.z, w.y}, {w.z, 0, -w.x}, {-w.y, w.x, 0}} * (1.0 / 75) + turn.strain * (1.0 / 45);
    Vec3d expected{};
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3d axis{};
      axis[k] = 1;
      const Thresholds<double> thresholds{0, 1, kPinFalloff};
      const auto psi = velocity(Translation<double>{axis}, Ball<double>{}, thresholds, variables(y), Dual(0));
      const Vec3d row = k == 0 ? e.row0 : k == 1 ? e.row1 : e.row2;
      expected -= Vec3d{dot(psi.x.g, row), dot(psi.y.g, row), dot(psi.z.g, row)};
    }
    Segment segment;
    segment.time_law = TimeLaw::pinned;
    segment.fields = {{{0, 0, 0}, Translation<double>{}, Ball<double>{}, {0, 1, kPinFalloff}}};
    segment.turns = {{0, {}}};
    const detail::PinPiece piece{0, 1, 0, {{}, nodes[0], nodes[1], nodes[2]}};
    const std::vector<Field> fields = detail::fields_at(segment, {piece}, 0.3);
    EXPECT_NEAR(norm(sum_at(fields, y) - expected), 0, 1e-12 * (1 + norm(expected)));
    const Vec3<Dual> v = dual_sum_at(fields, y);
    EXPECT_NEAR(v.x.g.x + v.y.g.y + v.z.g.z, 0, 1e-11) << "the divergence";
  }
}

TEST(Turns, SolveTheEquationsAtEveryTime) {
  Random random(821);
  for (const int count : {1, 2, 7, 30}) {
    const Segment segment = turning(pinning(random, count, 0.7, 0.3));
    const auto pieces = detail::solve_pins(segment, 1e-9);
    for (int k = 0; k <= 23; ++k) {
      const std::vector<Field> fields = detail::fields_at(segment, pieces, k / 23.0);
      for (std::size_t i = 0; i < segment.fields.size(); ++i) {
        EXPECT_NEAR(norm(sum_at(fields, fields[i].center) - motion_of(segment.fields[i])), 0, 1e-9);
      }
      for (const PinTurn& turn : segment.turns) {
        const Vec3<Dual> v = dual_sum_at(fields, fields[turn.pin].center);
        const Vec3d w = turn.rate;
        EXPECT_NEAR(norm(v.x.g - Vec3d{0, -w.z, w.y}), 0, 2e-8) << count << " pins, t = " << k / 23.0;
        EXPECT_NEAR(norm(v.y.g - Vec3d{w.z, 0, -w.x}), 0, 2e-8);
        EXPECT_NEAR(norm(v.z.g - Vec3d{-w.y, w.x, 0}), 0, 2e-8);
      }
    }
  }
}

// The Jacobian of the flow at a pin that turns is the rotation, at every time. Its steps are chosen for the path line,
// which is straight; their error in a rotation by 1 is about 1e-7.
TEST(Turns, TurnTheShapeAboutThePin) {
  Random random(822);
  for (const int count : {1, 5, 20}) {
    const Segment segment = turning(pinning(random, count, 0.8, 0.3));
    for (const double until : {0.4, 1.0}) {
      const Flow flow = prefix(Flow{{segment}}, until);
      const std::vector<Mat3d> found = jacobians(flow, places_of(segment, 0), precisely(1e-10));
      for (const PinTurn& turn : segment.turns) {
        const Mat3d difference = found[turn.pin] + rotation_by(turn.rate * until) * -1.0;
        EXPECT_LE(row_sum_norm(difference), 1e-6) << count << " pins until " << until;
      }
    }
  }
}

TEST(Turns, LeaveThePinsOnTheirWays) {
  Random random(823);
  for (const int count : {1, 3, 20}) {
    const Segment segment = turning(pinning(random, count, 0.6, 0.2));
    const Flow flow = prefix(Flow{{segment}}, 0.8);
    const std::vector<Vec3d> goal = places_of(segment, 0.8);
    EXPECT_LE(test::greatest_distance(moved(flow, places_of(segment, 0), in_float(2e-5)), goal), 4e-5) << count;
    EXPECT_LE(test::greatest_distance(moved(flow, places_of(segment, 0), precisely(1e-10)), goal), 2e-10) << count;
  }
}

TEST(Turns, AgreeWithPathLinesOfAnotherMethod) {
  Random random(824);
  for (int round = 0; round < 5; ++round) {
    const Segment segment = turning(pinning(random, 1 + 4 * round, random.uniform(0.5, 1.2), 0.3));
    const std::vector<Vec3d> points = test::random_points(random, 300, 1.0);
    const std::vector<Vec3d> expected = integrated_in_fields(segment, points, 400);
    EXPECT_LE(test::greatest_distance(moved(Flow{{segment}}, points, precisely(1e-9)), expected), 3e-8) << round;
    EXPECT_LE(test::greatest_distance(moved(Flow{{segment}}, points, in_float()), expected), 2e-5) << round;
    const std::vector<Vec3d> back = moved(inverse(Flow{{segment}}), expected, precisely(1e-9));
    EXPECT_LE(test::greatest_distance(back, points), 1e-7) << round;
  }
}

using Matrix = std::vector<std::vector<double>>;

// The matrix of the equations at t = 0, from the lengths of vectors: error_of() is the norm that it defines.
Matrix matrix_of(const Segment& segment) {
  detail::PinEquations equations(segment, 1e-9);
  equations.set_time(0);
  const detail::Nodes zero(equations.size());
  const auto square = [&](std::size_t i, std::size_t j) {
    detail::Nodes sum = zero;
    sum[i / 3][i % 3] += 1;
    if (j != i) sum[j / 3][j % 3] += 1;
    const double norm = equations.error_of(sum, zero);
    return norm * norm;
  };
  const std::size_t n = 3 * equations.size();
  Matrix m(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i) m[i][i] = square(i, i);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) m[i][j] = m[j][i] = 0.5 * (square(i, j) - m[i][i] - m[j][j]);
  }
  return m;
}

// The lower triangle of L L^T = m, in place.
void factorise(Matrix& m) {
  for (std::size_t i = 0; i < m.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = m[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
      ASSERT_TRUE(i != j || sum > 0) << "not positive definite";
      m[i][j] = i == j ? std::sqrt(sum) : sum / m[j][j];
    }
  }
}

// The greatest eigenvalue by the least: power iterations with the matrix and with its inverse.
double condition_of(const Matrix& m) {
  Matrix lower = m;
  factorise(lower);
  const std::size_t n = m.size();
  const auto multiply = [&](std::vector<double>& x) {
    std::vector<double> y(n);
    for (std::size_t i = 0; i < n; ++i) y[i] = std::inner_product(x.begin(), x.end(), m[i].begin(), 0.0);
    x = y;
  };
  const auto divide = [&](std::vector<double>& x) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < i; ++k) x[i] -= lower[i][k] * x[k];
      x[i] /= lower[i][i];
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) x[i] -= lower[k][i] * x[k];
      x[i] /= lower[i][i];
    }
  };
  const auto growth = [&](const auto& apply) {
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = std::sin(1.0 + static_cast<double>(i));
    double norm = 0;
    for (int round = 0; round < 300; ++round) {
      apply(x);
      norm = std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
      for (double& value : x) value /= norm;
    }
    return norm;
  };
  return growth(multiply) * growth(divide);
}

// Pins spread over a sphere, with a radius of so many of their distances; all of them turn, or none does.
Segment on_sphere(int count, double spacings, bool turns) {
  Segment segment;
  segment.time_law = TimeLaw::pinned;
  const double radius = spacings * std::sqrt(4 * std::numbers::pi / count);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count;
    const double across = std::sqrt(1 - z * z);
    const Vec3d place{across * std::cos(2.399963 * i), across * std::sin(2.399963 * i), z};
    segment.fields.push_back({place, Translation<double>{}, Ball<double>{}, {0, radius, kPinFalloff}});
    if (turns) segment.turns.push_back({static_cast<std::uint32_t>(i), {}});
  }
  return segment;
}

TEST(Turns, AreWellConditioned) {
  for (const int count : {6, 20}) {
    for (const double spacings : {1.0, 2.0, 4.0}) {
      const double with = condition_of(matrix_of(on_sphere(count, spacings, true)));
      const double without = condition_of(matrix_of(on_sphere(count, spacings, false)));
      std::printf("%2d pins, radius of %g distances: condition %.3g with turns, %.3g without\n", count, spacings, with,
                  without);
      EXPECT_LE(with, 5 * without);
    }
  }
}

TEST(Turns, ThatAreNoneOfPinsAreRefused) {
  Random random(825);
  const Segment segment = turning(pinning(random, 4, 0.7, 0.2));
  EXPECT_NO_THROW(validate(Flow{{segment}}));
  const auto refused = [&](auto change) {
    Segment other = segment;
    change(other);
    EXPECT_THROW(validate(Flow{{other}}), InvalidInput);
  };
  refused([](Segment& s) { s.turns.back().pin = 4; });
  refused([](Segment& s) { s.turns.front().pin = s.turns.back().pin; });
  refused([](Segment& s) { s.turns.front().rate.x = std::nan(""); });
  refused([](Segment& s) {
    s.time_law = TimeLaw::swept;
    for (Field& field : s.fields) field.thresholds.falloff = kDefaultFalloff;
  });
}

TEST(Pins, GoBackTheWayTheyCame) {
  Random random(807);
  const Flow flow{{pinning(random, 12, 0.7, 0.3)}};
  const std::vector<Vec3d> points = test::random_points(random, 2000, 1.0);
  EXPECT_LE(
      test::greatest_distance(moved(inverse(flow), moved(flow, points, precisely(1e-10)), precisely(1e-10)), points),
      1e-8);
}

TEST(Pins, KeepVolume) {
  Random random(808);
  const Flow flow{{pinning(random, 6, 0.8, 0.3)}};
  for (Vec3d x : test::random_points(random, 40))
    EXPECT_NEAR(volume_drifts(flow, {&x, 1}, precisely(1e-9)).front(), 0, 1e-6);
}

// The mask of a plane: masked points keep their bits, and a pin beyond the border is met.
TEST(Pins, AreMaskedAsOtherTools) {
  Random random(809);
  Segment segment;
  segment.time_law = TimeLaw::pinned;
  const Thresholds<double> thresholds{0, 0.9, kPinFalloff};
  segment.fields = {{{0.8, 0, 0}, Translation<double>{{0, 0.3, 0.1}}, Ball<double>{}, thresholds},
                    {{0.7, 0.5, 0}, Translation<double>{{0, 0, 0}}, Ball<double>{}, thresholds}};
  std::vector<Vec3d> held;
  for (int y = -12; y <= 12; ++y) {
    for (int z = -12; z <= 12; ++z) held.push_back({0, 0.1 * y, 0.1 * z});
  }
  const Flow flow = masked(Flow{{segment}}, Mask(held, {}, 0.3));
  EXPECT_EQ(moved(flow, held, in_float()), held);
  EXPECT_LE(norm(moved(flow, {segment.fields[0].center}, precisely(1e-9))[0] - Vec3d{0.8, 0.3, 0.1}), 2e-9);
  for (Vec3d x : test::random_points(random, 20))
    EXPECT_NEAR(volume_drifts(flow, {&x, 1}, precisely(1e-9)).front(), 0, 1e-5);
}

TEST(Pins, ThatAreNoPinsAreRefused) {
  const Field pin{{0, 0, 0}, Translation<double>{{1, 0, 0}}, Ball<double>{}, {0, 1, kPinFalloff}};
  Segment segment;
  segment.time_law = TimeLaw::pinned;
  segment.fields = {pin};
  EXPECT_NO_THROW(validate(Flow{{segment}}));
  const auto refused = [&](auto change) {
    Segment other = segment;
    change(other);
    EXPECT_THROW(validate(Flow{{other}}), InvalidInput);
  };
  refused([](Segment& s) { s.fields[0].thresholds.falloff = kDefaultFalloff; });
  refused([](Segment& s) { s.fields[0].thresholds.inner = 0.1; });
  refused([](Segment& s) { s.fields[0].region = Capsule<double>{{1, 0, 0}}; });
  refused([](Segment& s) { s.fields[0].motion = Twist<double>{{1, 0, 0}, 1}; });
  refused([](Segment& s) { s.displacement = {1, 0, 0}; });
  refused([&](Segment& s) { s.fields.push_back({{3, 0, 0}, pin.motion, pin.region, {0, 2, kPinFalloff}}); });
  refused([](Segment& s) { s.time_law = TimeLaw::swept; });
}

TEST(Pins, AreNoLongerSolvedAfterACancel) {
  Random random(810);
  const Segment segment = pinning(random, 20, 0.8, 0.3);
  Progress progress;
  EXPECT_FALSE(detail::solve_pins(segment, 1e-6, &progress).empty());
  progress.cancel = true;
  EXPECT_TRUE(detail::solve_pins(segment, 1e-6, &progress).empty());
  AdvectOptions options = in_float();
  options.progress = &progress;
  std::vector<Vec3d> points = test::random_points(random, 100);
  const std::vector<Vec3d> before = points;
  EXPECT_EQ(advect(Flow{{segment}}, points, options).status, AdvectStatus::cancelled);
  EXPECT_EQ(points, before);
}

TEST(Pins, ThatMeetAreRefused) {
  Segment segment;
  segment.time_law = TimeLaw::pinned;
  const Thresholds<double> thresholds{0, 1, kPinFalloff};
  segment.fields = {{{-0.25, 0, 0}, Translation<double>{{0.5, 0, 0}}, Ball<double>{}, thresholds},
                    {{0.25, 0, 0}, Translation<double>{{-0.5, 0, 0}}, Ball<double>{}, thresholds}};
  std::vector<Vec3d> points{{0, 0, 0}};
  EXPECT_THROW(advect(Flow{{segment}}, points, precisely(1e-9)), InvalidInput);
}

}  // namespace
}  // namespace knead::pins_test
