// Strokes of pins on the GPU, compared with the CPU.
#include <gtest/gtest.h>

#include <algorithm>

#include "flow/pins.h"
#include "knead/error.h"
#include "support/gpu_fixture.h"
#include "support/random_segments.h"

namespace knead::pins_gpu_test {
namespace {

using gpu::bits;
using gpu::default_options;
using gpu::Gpu;
using gpu::GpuOptions;
using test::moved;
using test::precisely;
using test::Random;

class GpuPinsTest : public gpu::GpuTest {};

// Of one pin to more than one call of a shader takes, and one piece of time to many.
TEST_F(GpuPinsTest, PinsOfAnyNumberAreMetThereAndBack) {
  Random random(818);
  std::size_t pieces = 0;
  for (const int count : {1, 2, 6, 60, 500}) {
    SCOPED_TRACE(count);
    const bool many = count > 6;
    Segment segment = test::pinning(random, count, many ? 0.35 : 0.8, many ? 0.15 : 0.4, many ? 1.0 : 0.6);
    if (count == 6) segment = test::turning(segment);
    const Flow flow{{segment}};
    const AdvectOptions options = default_options(1);
    pieces = std::max(pieces, detail::solve_pins(segment, options.tolerance).size());
    const auto points = test::random_points(random, many ? 64 : 200, many ? 1.0 : 0.6);
    const auto exact = moved(flow, points, precisely(1e-8));
    const auto found = on_gpu(flow, points, options);
    EXPECT_LT(test::greatest_distance(found, exact), 2e-5);
    EXPECT_GT(test::greatest_distance(exact, points), 0.02);
    EXPECT_LT(test::greatest_distance(on_gpu(inverse(flow), found, options), points), 4e-5);
    std::vector<Vec3d> pins;
    std::vector<Vec3d> goals;
    for (const Field& pin : segment.fields) {
      pins.push_back(pin.center);
      goals.push_back(pin.center + displacement_of(segment, pin));
      if (pins.size() == 64) break;
    }
    EXPECT_LT(test::greatest_distance(on_gpu(flow, pins, options), goals), 2e-5);
  }
  EXPECT_GT(pieces, 1U);
}

// A part of the time, among other segments, in several buffers, started without waiting: the same bits.
TEST_F(GpuPinsTest, PinsAreSegmentsLikeOthers) {
  Random random(819);
  Flow flow{{test::turning(test::pinning(random, 5, 0.8, 0.3)),
             test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.5}),
             test::pinning(random, 2, 0.7, 0.2)}};
  flow = flow_between(flow, 0.3, 2.6);
  const auto points = test::random_points(random, 300);
  const auto found = on_gpu(flow, points, default_options(1));
  EXPECT_LT(test::greatest_distance(found, moved(flow, points, precisely(1e-10))), 2e-5);
  GpuOptions small;
  small.most_points = 128;
  Gpu in_ranges(small);
  auto uploaded = in_ranges.upload(points);
  in_ranges.enqueue(flow, uploaded, default_options(1));
  EXPECT_EQ(in_ranges.collect(uploaded).status, AdvectStatus::done);
  EXPECT_EQ(bits(gpu::downloaded(in_ranges, uploaded)), bits(found));
}

TEST_F(GpuPinsTest, PinsThatMeetAreRefusedAndACancelIsHeard) {
  Random random(820);
  const Thresholds<double> thresholds{0, 1, kPinFalloff};
  Segment meeting;
  meeting.time_law = TimeLaw::pinned;
  meeting.fields = {{{-0.25, 0, 0}, Translation<double>{{0.5, 0, 0}}, Ball<double>{}, thresholds},
                    {{0.25, 0, 0}, Translation<double>{{-0.5, 0, 0}}, Ball<double>{}, thresholds}};
  const auto points = test::random_points(random, 100);
  auto own = points;
  EXPECT_THROW(gpu().advect(Flow{{test::pinning(random, 3, 0.8, 0.3), meeting}}, own, default_options(1)),
               InvalidInput);
  EXPECT_EQ(bits(own), bits(points));
  Progress progress;
  progress.cancel = true;
  AdvectOptions options = default_options(1);
  options.progress = &progress;
  EXPECT_EQ(gpu().advect(Flow{{test::pinning(random, 3, 0.8, 0.3)}}, own, options).status, AdvectStatus::cancelled);
  EXPECT_EQ(progress.done, 0U);
  EXPECT_EQ(bits(own), bits(points));
}

}  // namespace
}  // namespace knead::pins_gpu_test
