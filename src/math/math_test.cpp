// Sine, cosine, matrices, the ray test, Morton order and parallel loops.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"
#include "support/random_fields.h"

namespace knead::math_test {
namespace {

// The bound that the header states, over all quadrants, near their borders and for large arguments.
TEST(SinCos, StaysWithinItsBoundInDoubleAndFloat) {
  test::Random random(1);
  double worst_double = 0;
  double worst_float = 0;
  const auto try_angle = [&](double x) {
    const SinCos<double> d = sincos(x);
    worst_double =
        std::fmax(worst_double, std::fabs(static_cast<double>(std::sin(static_cast<long double>(x)) - d.sin)));
    worst_double =
        std::fmax(worst_double, std::fabs(static_cast<double>(std::cos(static_cast<long double>(x)) - d.cos)));
    const auto xf = static_cast<float>(x);
    const SinCos<float> f = sincos(xf);
    worst_float = std::fmax(worst_float, std::fabs(std::sin(static_cast<double>(xf)) - static_cast<double>(f.sin)));
    worst_float = std::fmax(worst_float, std::fabs(std::cos(static_cast<double>(xf)) - static_cast<double>(f.cos)));
  };
  for (int i = 0; i < 200000; ++i) try_angle(random.uniform(-10, 10));
  for (int i = 0; i < 200000; ++i) try_angle(random.uniform(-1e4, 1e4));
  for (int i = -40; i <= 40; ++i) {
    for (const double offset : {0.0, 1e-12, -1e-12, 1e-7, -1e-7}) try_angle(i * std::numbers::pi / 4 + offset);
  }
  EXPECT_LT(worst_double, 1.7e-16);
  EXPECT_LT(worst_float, 9e-8);
}

TEST(SinCos, ZeroIsExact) {
  EXPECT_EQ(sincos(0.0).sin, 0.0);
  EXPECT_EQ(sincos(0.0).cos, 1.0);
}

TEST(MatrixExponential, OfARotationGeneratorIsTheRotation) {
  test::Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Vec3d a = random.unit();
    const double angle = random.uniform(-9, 9);
    const Mat3d generator{
        {0, -a.z * angle, a.y * angle}, {a.z * angle, 0, -a.x * angle}, {-a.y * angle, a.x * angle, 0}};
    const Vec3d v = random.in_box(1);
    const Vec3d expected = rotate(v, a, sincos(angle));
    EXPECT_LT(norm(exp(generator) * v - expected), 1e-13);
  }
}

TEST(MatrixExponential, OfATracelessMatrixHasDeterminantOne) {
  test::Random random(3);
  for (int i = 0; i < 100; ++i) EXPECT_NEAR(determinant(exp(test::random_traceless(random))), 1.0, 1e-13);
}

TEST(ParallelFor, CoversEveryIndexOnceInChunksThatDoNotDependOnTheThreads) {
  for (const int threads : {1, 2, 3, 0}) {
    std::vector<std::atomic<int>> visits(10007);
    parallel_for(visits.size(), 64, threads, [&](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin % 64, 0U);
      EXPECT_LE(end - begin, 64U);
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    for (const auto& count : visits) ASSERT_EQ(count, 1);
  }
}

TEST(ParallelFor, NestsAndIsCalledFromSeveralThreads) {
  std::atomic<int> visits{0};
  const auto count_all = [&] {
    parallel_for(50, 1, 0, [&](std::size_t, std::size_t) {
      parallel_for(200, 7, 0, [&](std::size_t begin, std::size_t end) { visits += static_cast<int>(end - begin); });
    });
  };
  std::thread other(count_all);
  count_all();
  other.join();
  EXPECT_EQ(visits, 2 * 50 * 200);
}

// oneTBB would end it in silence: its caller would go on with half of the work.
TEST(ParallelFor, TheFailureOfAnOuterLoopLeavesInnerOnesComplete) {
  std::atomic<int> incomplete{0};
  for (int round = 0; round < 5; ++round) {
    std::atomic<bool> has_failed{false};
    const auto body = [&](std::size_t i, std::size_t) {
      if (i == 3) {
        has_failed = true;
        throw std::runtime_error("from a body");
      }
      for (int after = 0, k = 0; after < 20 && k < 10'000; ++k) {
        after += has_failed ? 1 : 0;
        std::atomic<int> done{0};
        parallel_for(100, 1, 0, [&](std::size_t, std::size_t) { ++done; });
        incomplete += done == 100 ? 0 : 1;
      }
    };
    EXPECT_THROW(parallel_for(8, 1, 0, body), std::runtime_error);
  }
  EXPECT_EQ(incomplete, 0);
}

// Its stack would grow with each, and a lock that it holds would be met again.
TEST(ParallelFor, WhoWaitsForAnInnerLoopTakesNothingOfTheOuterOne) {
  thread_local int depth = 0;
  std::atomic<int> deepest{0};
  parallel_for(200, 1, 0, [&](std::size_t, std::size_t) {
    ++depth;
    if (depth > deepest) deepest = depth;
    std::atomic<double> sum{0};
    parallel_for(20, 1, 0, [&](std::size_t i, std::size_t) {
      double part = 0;
      for (int k = 0; k < 2000; ++k) part += std::sin(static_cast<double>(i) + k);
      sum = part;
    });
    --depth;
  });
  EXPECT_EQ(deepest, 1);
}

TEST(ParallelFor, RethrowsAndDoesNothingForNoWork) {
  EXPECT_NO_THROW(parallel_for(0, 8, 2, [](std::size_t, std::size_t) { FAIL(); }));
  EXPECT_THROW(parallel_for(100, 8, 2, [](std::size_t, std::size_t) { throw std::runtime_error("from a body"); }),
               std::runtime_error);
}

}  // namespace
}  // namespace knead::math_test
