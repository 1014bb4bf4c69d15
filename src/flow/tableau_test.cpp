// The coefficients of the Runge-Kutta methods.
#include "knead/flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "knead/field.h"

namespace knead::tableau_test {
namespace {

const std::vector<std::pair<Integrator, std::string>> kIntegrators = {{Integrator::rk4, "rk4"},
                                                                      {Integrator::tsitouras, "tsit5"}};

using Weights = std::vector<double>;

// sum_j a_ij w_j for every i.
Weights tree_apply(const Tableau& t, const Weights& w) {
  Weights result(static_cast<std::size_t>(t.stages), 0.0);
  for (std::size_t i = 0; i < result.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) result[i] += t.a[i][j] * w[j];
  }
  return result;
}

Weights times(Weights a, const Weights& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] *= b[i];
  return a;
}

// The elementary weights of all rooted trees of up to five vertices, in order of their number of vertices, with what
// sum_i b_i w_i must be (Butcher; Hairer, Norsett, Wanner I, Table II.2.2).
struct Condition {
  int order;
  Weights weights;
  double value;
};

std::vector<Condition> order_conditions(const Tableau& t) {
  const Weights one(static_cast<std::size_t>(t.stages), 1.0);
  const Weights c = tree_apply(t, one);
  const Weights ac = tree_apply(t, c);
  const Weights c2 = times(c, c);
  const Weights ac2 = tree_apply(t, c2);
  const Weights aac = tree_apply(t, ac);
  return {{1, one, 1.0},
          {2, c, 1.0 / 2},
          {3, c2, 1.0 / 3},
          {3, ac, 1.0 / 6},
          {4, times(c2, c), 1.0 / 4},
          {4, times(c, ac), 1.0 / 8},
          {4, ac2, 1.0 / 12},
          {4, aac, 1.0 / 24},
          {5, times(c2, c2), 1.0 / 5},
          {5, times(c2, ac), 1.0 / 10},
          {5, times(ac, ac), 1.0 / 20},
          {5, times(c, ac2), 1.0 / 15},
          {5, times(c, aac), 1.0 / 30},
          {5, tree_apply(t, times(c2, c)), 1.0 / 20},
          {5, tree_apply(t, times(c, ac)), 1.0 / 40},
          {5, tree_apply(t, ac2), 1.0 / 60},
          {5, tree_apply(t, aac), 1.0 / 120}};
}

TEST(Tableau, MeetsTheOrderConditionsOfItsStatedOrder) {
  for (const auto& [integrator, name] : kIntegrators) {
    SCOPED_TRACE(name);
    const Tableau& t = tableau(integrator);
    for (const Condition& condition : order_conditions(t)) {
      double with_b = 0;
      double with_e = 0;
      for (std::size_t i = 0; i < condition.weights.size(); ++i) {
        with_b += t.b[i] * condition.weights[i];
        with_e += t.e[i] * condition.weights[i];
      }
      if (condition.order <= t.order) {
        EXPECT_NEAR(with_b, condition.value, 3e-14);
      }
      if (condition.order <= t.error_order) {
        EXPECT_NEAR(with_e, 0, 3e-14);
      }
    }
  }
}

// With a fixed step, on a path line that stays in the smooth part of a ball's field: the error falls with the order.
TEST(Tableau, ConvergesWithItsOrder) {
  const Translation<double> motion{{0.1, 0, 0}, {}, 1};
  const Thresholds<double> thresholds{0.1, 1.0};
  const auto integrate = [&](const Tableau& t, int steps) {
    Vec3d y{-0.3, 0.4, 0.1};
    const double h = 1.0 / steps;
    for (int n = 0; n < steps; ++n) {
      std::vector<Vec3d> k;
      for (int i = 0; i < t.stages; ++i) {
        Vec3d at = y;
        for (int j = 0; j < i; ++j) at += k[j] * (h * t.a[i][j]);
        k.push_back(velocity(motion, Ball<double>{}, thresholds, at, 0.0) * 8.0);
      }
      for (int i = 0; i < t.stages; ++i) y += k[i] * (h * t.b[i]);
    }
    return y;
  };
  const Vec3d exact = integrate(tableau(Integrator::tsitouras), 4000);
  for (const auto& [integrator, name] : kIntegrators) {
    const Tableau& t = tableau(integrator);
    const double coarse = norm(integrate(t, 16) - exact);
    const double fine = norm(integrate(t, 32) - exact);
    EXPECT_NEAR(std::log2(coarse / fine), t.order, 0.8) << name;
  }
}

TEST(Tableau, FirstSameAsLastMeansThatTheLastStageIsAtTheStepsEnd) {
  for (const auto& [integrator, name] : kIntegrators) {
    const Tableau& t = tableau(integrator);
    if (!t.first_same_as_last) continue;
    for (int j = 0; j < t.stages; ++j) EXPECT_EQ(t.a[t.stages - 1][j], t.b[j]) << name;
    EXPECT_NEAR(t.c[t.stages - 1], 1.0, 1e-15) << name;
  }
}

}  // namespace
}  // namespace knead::tableau_test
