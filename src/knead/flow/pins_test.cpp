#include "knead/flow/pins.h"

#include <gtest/gtest.h>

#include "knead/field/dual.h"
#include "knead/flow/path_jacobian.h"
#include "knead/math/error.h"
#include "support/pins_now.h"
#include "support/random_segments.h"

namespace knead {
namespace {

using test::in_float;
using test::moved;
using test::pinning;
using test::precisely;
using test::Random;

Vec3d motion_of(const Field& pin) { return std::get<Translation<double>>(pin.motion).velocity; }

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
}  // namespace knead
