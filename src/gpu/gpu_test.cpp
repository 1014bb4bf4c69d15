// What is done with points that stay on the GPU.
#include "knead/editor/gpu.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "knead/editor/gl.h"
#include "knead/error.h"
#include "support/gpu_fixture.h"
#include "support/random_segments.h"

namespace knead::gpu::gpu_test {
namespace {

using test::Random;

class GpuPointsTest : public GpuTest {};

// Segments of unlike kinds, so that there are several shaders.
Flow unlike_segments(Random& random) {
  Flow flow;
  for (const test::NamedSegment& named : test::random_segments(random)) {
    if (named.name == "ball" || named.name == "rotate" || named.name == "points")
      flow.segments.push_back(named.segment);
  }
  EXPECT_EQ(flow.segments.size(), 3U);
  return flow;
}

void expect_same_counts(const AdvectResult& a, const AdvectResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.accepted_steps, b.accepted_steps);
  EXPECT_EQ(a.rejected_steps, b.rejected_steps);
  EXPECT_EQ(a.evaluations, b.evaluations);
}

TEST_F(GpuPointsTest, EnqueueIsAdvectToTheBit) {
  Random random(831);
  const Flow flow = unlike_segments(random);
  const auto points = test::random_points(random, 700);
  GpuPoints waiting = gpu().upload(points);
  GpuPoints queued = gpu().upload(points);
  AdvectResult sum;
  for (int i = 0; i < 3; ++i) {
    const AdvectResult one = gpu().advect(flow, waiting, default_options(1));
    gpu().enqueue(flow, queued, default_options(1));
    sum.accepted_steps += one.accepted_steps;
    sum.rejected_steps += one.rejected_steps;
    sum.evaluations += one.evaluations;
  }
  expect_same_counts(gpu().collect(queued), sum);
  EXPECT_EQ(bits(downloaded(gpu(), queued)), bits(downloaded(gpu(), waiting)));
  expect_same_counts(gpu().collect(queued), AdvectResult{});  // only what is new
}

TEST_F(GpuPointsTest, CollectSaysWhereAPathLineDoesNotEnd) {
  const Flow flow{
      {test::resting(Rotation<double>{{0, 0, 1}, 1.5, 1}, HalfSpace<double>{{1, 0, 0}}, {0, 0, 0}, {-0.3, 0.3})}};
  GpuPoints points = gpu().upload(std::vector<Vec3d>{{0, 1e25, 0}});
  gpu().enqueue(flow, points, default_options(1));
  EXPECT_EQ(gpu().collect(points).status, AdvectStatus::step_limit);
  EXPECT_EQ(gpu().collect(points).status, AdvectStatus::done);
}

// Written points are as uploaded ones: where they are, and the balls about their groups, which say what a tool reaches.
void expect_written_as_uploaded(Gpu& gpu, Random& random) {
  const Flow flow = unlike_segments(random);
  auto points = test::random_points(random, 1000);
  GpuPoints written = gpu.upload(points);
  gpu.advect(flow, written, default_options(1));
  points = downloaded(gpu, written);
  for (const auto& [first, count] : {std::pair{128, 320}, std::pair{960, 40}, std::pair{0, 64}}) {
    const auto others = test::random_points(random, count, 0.8);
    std::copy(others.begin(), others.end(), points.begin() + first);
    gpu.write(written, static_cast<std::size_t>(first), others);
    EXPECT_EQ(bits(downloaded(gpu, written)), bits(points));
  }
  GpuPoints fresh = gpu.upload(points);
  gpu.advect(flow, written, default_options(1));
  gpu.advect(flow, fresh, default_options(1));
  EXPECT_EQ(bits(downloaded(gpu, written)), bits(downloaded(gpu, fresh)));
  EXPECT_NE(bits(downloaded(gpu, written)), bits(points));
}

TEST_F(GpuPointsTest, WrittenPointsAreAsUploadedOnes) {
  Random random(832);
  expect_written_as_uploaded(gpu(), random);
  GpuOptions options;
  options.most_points = 192;  // what is written goes over the ends of buffers
  Gpu in_ranges(options);
  expect_written_as_uploaded(in_ranges, random);
}

TEST_F(GpuPointsTest, OnlyWholeGroupsAreWritten) {
  GpuPoints points = gpu().upload(std::vector<Vec3d>(200));
  const auto write = [&](std::size_t first, std::size_t count) {
    gpu().write(points, first, std::vector<Vec3d>(count, Vec3d{1, 2, 3}));
  };
  EXPECT_THROW(write(1, 64), InvalidInput);
  EXPECT_THROW(write(0, 63), InvalidInput);
  EXPECT_THROW(write(192, 9), InvalidInput);
  EXPECT_THROW(write(256, 64), InvalidInput);
  EXPECT_EQ(bits(downloaded(gpu(), points)), bits(std::vector<Vec3d>(200)));
  EXPECT_NO_THROW(write(192, 8));
  EXPECT_NO_THROW(write(64, 0));
}

TEST_F(GpuPointsTest, AnAssignedCopyGoesItsOwnWay) {
  Random random(833);
  const Flow flow = unlike_segments(random);
  GpuOptions options;
  options.most_points = 192;
  Gpu in_ranges(options);
  for (Gpu* own : {&gpu(), &in_ranges}) {
    const auto points = test::random_points(random, 500);
    GpuPoints first = own->upload(points);
    GpuPoints copy = own->upload(test::random_points(random, 500, 3.0));
    own->advect(flow, first, default_options(1));
    own->assign(copy, first);
    const auto once = downloaded(*own, first);
    EXPECT_EQ(bits(downloaded(*own, copy)), bits(once));
    own->advect(flow, copy, default_options(1));
    EXPECT_EQ(bits(downloaded(*own, first)), bits(once));
    own->advect(flow, first, default_options(1));
    EXPECT_EQ(bits(downloaded(*own, copy)), bits(downloaded(*own, first)));
    GpuPoints fewer = own->upload(test::random_points(random, 499));
    EXPECT_THROW(own->assign(fewer, first), InvalidInput);
  }
}

TEST_F(GpuPointsTest, TransfersAreCounted) {
  Random random(834);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.5})}};
  Transfers before = gpu().transfers();
  const auto expect = [&](std::uint64_t sent, std::uint64_t bytes_sent, std::uint64_t read, std::uint64_t bytes_read) {
    const Transfers after = gpu().transfers();
    EXPECT_EQ(after.sent - before.sent, sent);
    EXPECT_EQ(after.bytes_sent - before.bytes_sent, bytes_sent);
    EXPECT_EQ(after.read - before.read, read);
    EXPECT_EQ(after.bytes_read - before.bytes_read, bytes_read);
    before = after;
  };
  GpuPoints points = gpu().upload(test::random_points(random, 640));
  expect(1, 640 * sizeof(Vec3d), 0, 0);
  GpuPoints copy = gpu().upload(std::vector<Vec3d>(640));
  before = gpu().transfers();
  gpu().assign(copy, points);
  expect(0, 0, 0, 0);
  gpu().write(points, 64, std::vector<Vec3d>(128));
  expect(1, 128 * sizeof(Vec3d), 0, 0);
  downloaded(gpu(), points);
  expect(0, 0, 1, 640 * sizeof(Vec3d));
  gpu().enqueue(flow, points, default_options(1));
  const Transfers after = gpu().transfers();
  EXPECT_EQ(after.read, before.read);
  EXPECT_LT(after.bytes_sent - before.bytes_sent, 1024U);  // a segment, whatever the number of points
  before = after;
  gpu().collect(points);
  EXPECT_EQ(gpu().transfers().read - before.read, 1U);
  EXPECT_LE(gpu().transfers().bytes_read - before.bytes_read, 2048U);
}

TEST_F(GpuPointsTest, BuffersAreThePoints) {
  GpuOptions options;
  options.most_points = 128;
  Gpu in_ranges(options);
  const GpuPoints points = in_ranges.upload(std::vector<Vec3d>(300));
  const std::vector<GpuBuffer> buffers = Gpu::buffers(points);
  ASSERT_EQ(buffers.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NE(buffers[i].name, 0U);
    EXPECT_EQ(buffers[i].begin, 128 * i);
    EXPECT_EQ(buffers[i].count, i < 2 ? 128U : 44U);
  }
}

// In a context of the caller's, which stays current.
TEST_F(GpuPointsTest, InTheContextThatIsCurrent) {
  Random random(835);
  const Flow flow = unlike_segments(random);
  const auto points = test::random_points(random, 500);
  const auto expected = on_gpu(flow, points, default_options(1));
  GpuOptions options;
  options.in_current_context = true;
  EXPECT_THROW(Gpu{options}, GpuError);  // there is none
  const gl::OffscreenContext context(43);
  Gpu adopting(options);
  EXPECT_EQ(adopting.description(), gpu().description());
  GpuPoints uploaded = adopting.upload(points);
  adopting.enqueue(flow, uploaded, default_options(1));
  EXPECT_EQ(adopting.collect(uploaded).status, AdvectStatus::done);
  EXPECT_EQ(bits(downloaded(adopting, uploaded)), bits(expected));
  EXPECT_EQ(on_gpu(flow, points, default_options(1)), expected);  // another's call in between
  adopting.advect(inverse(flow), uploaded, default_options(1));
  EXPECT_LT(test::greatest_distance(downloaded(adopting, uploaded), points), 1e-4);
}

}  // namespace
}  // namespace knead::gpu::gpu_test
