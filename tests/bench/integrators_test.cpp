#include <gtest/gtest.h>

#include "comparisons.h"

namespace knead::command::integrators_test {
namespace {

IntegratorRun run_of(const char* tool, Integrator integrator, double max_error, double seconds) {
  return {"shape", tool, integrator, Precision::float32, 0, max_error, seconds};
}

const TimesToAccuracy& to_1e5(const std::vector<TimesToAccuracy>& all) { return all.at(2); }

TEST(TimesToAccuracy, LieBetweenTwoSettingsOnALineInLogarithms) {
  const auto all =
      times_to_accuracy({run_of("ball", Integrator::rk4, 1e-4, 1), run_of("ball", Integrator::rk4, 1e-6, 4),
                         run_of("ball", Integrator::tsitouras, 1e-4, 0.1)});
  EXPECT_EQ(to_1e5(all).error, 1e-5);
  EXPECT_NEAR(to_1e5(all).seconds.at(0).value(), 2, 1e-12);
  EXPECT_FALSE(to_1e5(all).seconds.at(1).has_value());  // never as accurate
  EXPECT_EQ(soonest_by_default(all), Integrator::rk4);
  EXPECT_EQ(all.at(0).soonest(), Integrator::tsitouras);
  EXPECT_EQ(all.back().soonest(), std::nullopt);  // double
}

TEST(TimesToAccuracy, AreGeometricMeansOfAllScenes) {
  const auto all = times_to_accuracy(
      {run_of("ball", Integrator::rk4, 1e-6, 1), run_of("bend", Integrator::rk4, 1e-6, 4),
       run_of("ball", Integrator::tsitouras, 1e-6, 0.1), run_of("bend", Integrator::tsitouras, 1e-4, 0.1)});
  EXPECT_NEAR(to_1e5(all).seconds.at(0).value(), 2, 1e-12);
  EXPECT_FALSE(to_1e5(all).seconds.at(1).has_value());  // not in every scene
}

}  // namespace
}  // namespace knead::command::integrators_test
