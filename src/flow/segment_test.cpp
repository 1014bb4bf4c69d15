// Flows as values: inverses, parts and checks.
#include "knead/flow.h"

#include <gtest/gtest.h>

#include <limits>

#include "knead/error.h"
#include "support/random_segments.h"

namespace knead::segment_test {
namespace {

using test::moved;
using test::precisely;
using test::Random;

Flow random_flow(Random& random) {
  Flow flow;
  for (const auto& [name, segment] : test::random_segments(random)) flow.segments.push_back(segment);
  return flow;
}

TEST(Flow, IsAValueAndItsInverseIsAnInvolution) {
  Random random(101);
  const Flow flow = random_flow(random);
  EXPECT_EQ(inverse(inverse(flow)), flow);
  EXPECT_NE(inverse(flow), flow);
}

TEST(Flow, PrefixThenRestIsTheWhole) {
  Random random(102);
  const Flow flow = random_flow(random);
  const auto points = test::random_points(random, 100);
  const auto whole = moved(flow, points, precisely(1e-12));
  for (const double at : {0.5, 3.0, 7.25, 13.9}) {
    Flow rest;
    const auto first = static_cast<std::size_t>(at);
    rest.segments.assign(flow.segments.begin() + static_cast<std::ptrdiff_t>(first), flow.segments.end());
    rest.segments.front().begin = at - static_cast<double>(first);
    const auto pieces = moved(rest, moved(prefix(flow, at), points, precisely(1e-12)), precisely(1e-12));
    EXPECT_LT(test::greatest_distance(pieces, whole), 1e-8) << at;
  }
  EXPECT_EQ(prefix(flow, 0).segments.size(), 0U);
  EXPECT_EQ(prefix(flow, static_cast<double>(flow.segments.size())), flow);
  EXPECT_EQ(prefix(flow, 99), flow);
}

// Each change makes one number meaningless.
TEST(Validate, NamesTheSegmentAndWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Segment good = test::translating(Ball<double>{}, {0, 0, 0}, {1, 0, 0}, {0.1, 0.5});
  const auto expect_refused = [&](const char* what, const auto& change) {
    Segment bad = good;
    change(bad);
    try {
      validate(Flow{{good, bad}});
      ADD_FAILURE() << what << " was accepted";
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("segment 2"), std::string::npos) << error.what();
    }
  };
  EXPECT_NO_THROW(validate(Flow{{good}}));
  expect_refused("no field", [](Segment& s) { s.fields.clear(); });
  expect_refused("a NaN displacement", [&](Segment& s) { s.displacement.y = nan; });
  expect_refused("a NaN threshold", [&](Segment& s) { s.fields[0].thresholds.outer = nan; });
  expect_refused("inner = outer", [](Segment& s) { s.fields[0].thresholds.inner = 0.5; });
  expect_refused("end > 1", [](Segment& s) { s.end = 1.5; });
  expect_refused("a long axis", [](Segment& s) { s.fields[0].motion = Rotation<double>{{0, 0, 2}, 1, 1}; });
  expect_refused("a trace", [](Segment& s) { s.fields[0].motion = Strain<double>{Mat3d{}}; });
  expect_refused("no points", [](Segment& s) { s.fields[0].region = PointSet<double>{}; });
  expect_refused("an odd exponent", [](Segment& s) { s.fields[0].region = PointSet<double>{{{0, 0, 0}}, {}, 7}; });
  expect_refused("a zero normal", [](Segment& s) { s.fields[0].region = HalfSpace<double>{{0, 0, 0}}; });
  expect_refused("a blended half-space", [](Segment& s) {
    s.fields[0].region = HalfSpace<double>{{0, 0, 1}};
    s.time_law = TimeLaw::blended;
  });
  expect_refused("handles without a zero set", [](Segment& s) {
    s.fields[0].region = Handles<double>{{{{0, 0, 0}}, {}, 8}, {{}, {}, 8}, s.displacement};
  });
  expect_refused("handles that are not swept", [](Segment& s) {
    s.fields[0].region = Handles<double>{{{{0, 0, 0}}, {}, 8}, {{{2, 0, 0}}, {}, 8}};
  });
  expect_refused("a limit cylinder of radius 0", [](Segment& s) {
    s.limit_cylinder = LimitCylinder{{0, 0, 0}, {0, 0, 1}, 0};
  });
}

}  // namespace
}  // namespace knead::segment_test
