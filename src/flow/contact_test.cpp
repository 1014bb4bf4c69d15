// The time at which a tool reaches a resting point.
#include "flow/closed_form.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random_segments.h"

namespace knead::contact_test {
namespace {

using test::Random;

bool inside(const Segment& segment, const Vec3d& x, double t, double margin) {
  for (const Field& field : segment.fields) {
    const double outer = field.thresholds.outer - margin;
    const Vec3d d = x - field.center;
    if (segment.time_law == TimeLaw::blended) {
      if (region_value(field, d).value < outer || region_value(field, d - segment.displacement).value < outer)
        return true;
    } else if (region_value(field, d - displacement_of(segment, field) * t, t).value < outer) {
      return true;
    }
  }
  return false;
}

// Against dense sampling in time: never later than the first sample inside, never much earlier, and none only if no
// sample is inside. Forwards and backwards.
TEST(Contact, IsTheFirstTimeThatARestingPointIsInside) {
  Random random(81);
  int contacts = 0;
  for (int round = 0; round < 12; ++round) {
    for (auto [name, segment] : test::random_segments(random)) {
      segment.displacement *= 3;
      if (round % 2 == 1) std::swap(segment.begin, segment.end);
      for (const Vec3d& x : test::random_points(random, 30, 2.0)) {
        const std::optional<double> contact = next_contact(segment, x, segment.begin);
        std::optional<double> sampled;
        for (int k = 0; k < 2000 && !sampled; ++k) {
          const double t = segment.begin + (segment.end - segment.begin) * k / 2000.0;
          if (inside(segment, x, t, 0)) sampled = t;
        }
        if (sampled) {
          ASSERT_TRUE(contact) << name;
          EXPECT_LE(std::abs(*contact - segment.begin), std::abs(*sampled - segment.begin) + 1e-12) << name;
        }
        if (contact) {
          ++contacts;
          // At the contact the point is at the rim: inside of a slightly larger region.
          EXPECT_TRUE(inside(segment, x, *contact, -2e-4)) << name;
        }
      }
    }
  }
  EXPECT_GT(contacts, 500);
}

TEST(Contact, OfAPointInsideIsNow) {
  const Segment segment = test::translating(Ball<double>{}, {0, 0, 0}, {1, 0, 0}, {0.2, 0.5});
  EXPECT_EQ(next_contact(segment, {0.5, 0.1, 0}, 0.3), 0.3);
}

TEST(Contact, OfABallIsTheRootOfTheQuadratic) {
  const Segment segment = test::translating(Ball<double>{}, {0, 0, 0}, {2, 0, 0}, {0.2, 0.5});
  EXPECT_NEAR(*next_contact(segment, {1, 0.3, 0}, 0), (1 - 0.4) / 2, 1e-15);
  EXPECT_FALSE(next_contact(segment, {1, 0.5000001, 0}, 0));
  EXPECT_FALSE(next_contact(segment, {-0.6, 0, 0}, 0));
}

}  // namespace
}  // namespace knead::contact_test
