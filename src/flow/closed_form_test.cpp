// Closed forms of path lines against their integration.
#include "flow/closed_form.h"

#include <gtest/gtest.h>

#include <map>

#include "support/random_segments.h"

namespace knead::closed_form_test {
namespace {

using test::Random;

// Wherever a closed form is given it must be what integration finds, for the whole segment, parts of it and backwards.
TEST(ClosedForm, IsWhatIntegrationFinds) {
  Random random(71);
  std::map<std::string, int> given;
  for (int round = 0; round < 15; ++round) {
    for (const auto& [name, whole] : test::random_segments(random)) {
      Segment segment = whole;
      if (round % 3 == 1) std::swap(segment.begin, segment.end);
      if (round % 3 == 2) segment.begin = random.uniform(0, 0.5);
      for (const Vec3d& x : test::random_points(random, 60, 0.7)) {
        const std::optional<Vec3d> displacement = closed_form(segment, x);
        if (!displacement) continue;
        ++given[name];
        const Vec3d integrated =
            test::moved(Flow{{test::without_closed_form(segment)}}, {x}, test::precisely(1e-11))[0];
        EXPECT_LT(norm(x + *displacement - integrated), 1e-9) << name;
        // The kernels have them too, for whole blocks.
        const Vec3d moved = test::moved(Flow{{segment}}, {x}, test::precisely(1e-11))[0];
        EXPECT_LT(norm(x + *displacement - moved), 1e-12) << name;
      }
    }
  }
  for (const char* name : {"ball", "capsule", "rotate", "stretch", "twist", "oblique twist", "bend"}) {
    EXPECT_GT(given[name], 10) << name;
  }
  EXPECT_EQ(given["blended ball"] + given["two parts"], 0);
}

TEST(ClosedForm, AnglesOfManyTurnsAreNotMistaken) {
  // Points far up a twist turn many times; the half-space's normal is oblique, so they leave and enter it.
  Random random(72);
  const Segment twist = test::resting(Twist<double>{{0, 0, 1}, 25, 0}, HalfSpace<double>{normalized(Vec3d{1, 0, 2})},
                                      {0, 0, 0}, {0.1, 0.4});
  for (const Vec3d& x : test::random_points(random, 200, 0.8)) {
    if (const std::optional<Vec3d> displacement = closed_form(twist, x)) {
      const Vec3d integrated = test::moved(Flow{{test::without_closed_form(twist)}}, {x}, test::precisely(1e-11))[0];
      EXPECT_LT(norm(x + *displacement - integrated), 1e-8);
      EXPECT_LT(norm(x + *displacement - test::moved(Flow{{twist}}, {x}, test::precisely(1e-11))[0]), 1e-12);
    }
  }
}

// Sets of which many points have a coordinate in common, asked for their points as they are after a part of the motion,
// for points beside them, and for others.
TEST(ClosedForm, OfSortedHandlesIsTheSame) {
  Random random(73);
  const auto grid = [&](double x) {
    PointSet<double> set;
    for (int i = 0; i < 300; ++i) set.points.push_back({x, 0.1 * (i % 20), random.uniform(-1, 1)});
    return set;
  };
  const Vec3d by{0.3, 0.2, -0.1};
  const Vec3d axis = random.unit();
  Handles<double> carried{grid(0.4), grid(-0.4), by};
  Handles<double> turned{grid(0.4), grid(-0.4)};
  turned.turn_axis = axis;
  turned.turn_angle = 0.7;
  const Vec3d c{0.1, -0.2, 0.05};
  int found = 0;
  for (Segment segment :
       {test::translating(carried, c, by, {0, 1}), test::resting(Rotation<double>{axis, 0.7}, turned, c, {0, 1})}) {
    for (const double begin : {0.0, 0.37}) {
      segment.begin = begin;
      const Segment before = [&] {
        Segment part = segment;
        part.begin = 0;
        part.end = begin;
        return part;
      }();
      const HandlePoints sorted(segment);
      ASSERT_TRUE(sorted.are_all());
      for (const PointSet<double>* set : {&carried.full, &carried.zero, &turned.full, &turned.zero}) {
        for (const Vec3d& p : set->points) {
          const Vec3d x = p + c;
          for (const Vec3d& at : {x, x + closed_form(before, x).value_or(Vec3d{}), x + Vec3d{1e-14, 0, 1e-13}}) {
            const std::optional<Vec3d> expected = closed_form(segment, at);
            EXPECT_EQ(sorted.closed_form(segment, at), expected);
            found += expected ? 1 : 0;
          }
        }
      }
    }
  }
  EXPECT_GT(found, 2000);
  EXPECT_FALSE(HandlePoints(test::translating(Ball<double>{}, c, by, {0.1, 0.2})).are_all());
}

}  // namespace
}  // namespace knead::closed_form_test
