// The computed form v = w u + (dw/dr) grad r x A against the paper's own: v = grad p x grad q, p = (1-b) e, q = (1-b) f
// (Eq. 2 to 7), formed from e, f and b by dual numbers; and the figures that the method's text states.
#include <gtest/gtest.h>

#include <cmath>

#include "knead/field.h"
#include "support/dual.h"
#include "support/random_fields.h"

namespace knead::paper_test {
namespace {

using test::Dual;
using test::Random;

Dual paper_complement(const Dual& r, const Thresholds<double>& t) {
  const Dual s = minimum(maximum((r - Dual(t.inner)) / Dual(t.outer - t.inner), Dual(0)), Dual(1));
  return Dual(1) - (Dual(4) * s * s * s * (Dual(1) - s) + s * s * s * s);
}

Vec3d paper_velocity(const Dual& e, const Dual& f, const Dual& r, const Thresholds<double>& t) {
  const Dual complement = paper_complement(r, t);
  return cross((complement * e).g, (complement * f).g);
}

// Compares for every region; scalars(d) gives e and f.
template <class M, class Scalars>
void expect_paper_field(const M& motion, Random& random, const Scalars& scalars) {
  for (const Region& region : test::random_regions(random)) {
    std::visit(
        [&](const auto& r) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(r)>, CustomRegion>) {
            const Thresholds<double> t = test::random_thresholds(random);
            for (int i = 0; i < 10; ++i) {
              const Vec3d d = random.in_box(1.2);
              const Vec3<Dual> x = test::variables(d);
              const auto [e, f] = scalars(x);
              const Vec3d expected = paper_velocity(e, f, evaluate(r, x, Dual(0.4)).value, t);
              EXPECT_LT(norm(velocity(motion, r, t, d, 0.4) - expected), 1e-12 * (10 + norm(expected)));
            }
          }
        },
        region);
  }
}

TEST(PaperField, Translation) {
  Random random(31);
  for (int i = 0; i < 50; ++i) {
    const Vec3d v0 = random.in_box(2);
    const Vec3d u = any_orthogonal(v0);
    const Vec3d w = cross(v0, u);  // u x w = v0
    expect_paper_field(Translation<double>{v0, {}, 1}, random, [&](const Vec3<Dual>& x) {
      return std::pair{dot(Vec3<Dual>(u), x), dot(Vec3<Dual>(w), x)};
    });
  }
}

TEST(PaperField, RotationOfTwoRadians) {
  Random random(32);
  for (int i = 0; i < 50; ++i) {
    const Vec3d a = random.unit();
    expect_paper_field(Rotation<double>{a, 2, 1}, random, [&](const Vec3<Dual>& x) {
      return std::pair{dot(Vec3<Dual>(a), x), norm2(cross(Vec3<Dual>(a), x))};
    });
  }
}

TEST(PaperField, TwistOfRateFour) {
  Random random(33);
  for (int i = 0; i < 50; ++i) {
    const Vec3d a = random.unit();
    expect_paper_field(Twist<double>{a, 4, 1}, random, [&](const Vec3<Dual>& x) {
      const Dual height = dot(Vec3<Dual>(a), x);
      return std::pair{height * height, norm2(cross(Vec3<Dual>(a), x))};
    });
  }
}

// Method, section 3, "Counter-flow": v / |u| on the equator of a translating ball.
TEST(MethodFigures, CounterFlowBesideATranslatingBall) {
  const auto least = [](double ratio) {
    double result = 0;
    for (int i = 0; i <= 100000; ++i) {
      const Vec3d d{i * 1e-5, 0, 0};
      const Vec3d v = velocity(Translation<double>{{0, 0, 1}}, Ball<double>{}, Thresholds<double>{ratio, 1}, d, 0.0);
      result = std::fmin(result, v.z);
    }
    return result;
  };
  EXPECT_NEAR(least(0.0), -0.32, 0.005);
  EXPECT_NEAR(least(0.25), -0.58, 0.005);
  EXPECT_NEAR(least(0.5), -1.19, 0.005);
  EXPECT_NEAR(least(0.75), -3.2, 0.05);
  EXPECT_NEAR(least(0.9), -9.3, 0.05);
}

// Method, section 2, "The gauge is free": a capsule moving sideways, ri 0.25, ro 0.5, the fastest point's speed.
TEST(MethodFigures, SidewaysCapsuleByGauge) {
  const auto fastest = [](double half_length, double gauge) {
    const Capsule<double> capsule{{half_length, 0, 0}};
    const Translation<double> motion{{0, 0, 1}, {1, 0, 0}, gauge};
    Random random(34);
    double speed = 0;
    for (int i = 0; i < 300000; ++i) {
      const Vec3d d{random.uniform(-half_length - 0.5, half_length + 0.5), random.uniform(-0.5, 0.5),
                    random.uniform(-0.5, 0.5)};
      speed = std::fmax(speed, norm(velocity(motion, capsule, Thresholds<double>{0.25, 0.5}, d, 0.0)));
    }
    return speed;
  };
  EXPECT_NEAR(fastest(1, 1), 5.2, 0.1);
  EXPECT_NEAR(fastest(3, 1), 13.4, 0.2);
  EXPECT_NEAR(fastest(1, 0), 2.7, 0.1);
  EXPECT_NEAR(fastest(3, 0), 2.7, 0.1);
}

// With A_0 nothing flows along the axis of a bend, and a ball's rotation has no counter-rotation.
TEST(MethodFigures, GaugeZeroKeepsToThePlanesItShould) {
  Random random(35);
  for (int i = 0; i < 300; ++i) {
    const Vec3d a = random.unit();
    const Vec3d n = normalized(cross(a, random.unit()));
    const Thresholds<double> t = test::random_thresholds(random);
    const Vec3d d = random.in_box(1);
    const Rotation<double> bend{a, 1.5, 0, RotationGauge::axial};
    EXPECT_NEAR(dot(a, velocity(bend, HalfSpace<double>{n}, t, d, 0.0)), 0, 1e-14);
    const Rotation<double> ball{a, 1.5, 0, RotationGauge::radial};
    const Vec3d expected = cross(a, d) * (1.5 * blend_weight(norm(d), t).value);
    EXPECT_LT(norm(velocity(ball, Ball<double>{}, t, d, 0.0) - expected), 1e-13);
  }
}

}  // namespace
}  // namespace knead::paper_test
