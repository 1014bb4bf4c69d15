// The GPU's advect against the CPU's.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "gpu/packed.h"
#include "knead/error.h"
#include "support/gpu_fixture.h"
#include "support/random_grids.h"
#include "support/random_segments.h"

namespace knead::advect_gpu_test {
namespace {

using gpu::bits;
using gpu::default_options;
using gpu::Gpu;
using gpu::GpuOptions;
using test::moved;
using test::NamedSegment;
using test::precisely;
using test::Random;

class GpuTest : public gpu::GpuTest {};

// How much the flow magnifies an error made at the start: the norm of its Jacobian at each point, at least 1.
std::vector<double> stretches(const Flow& flow, const std::vector<Vec3d>& points) {
  const double h = 1e-6;
  std::vector<double> result(points.size(), 1.0);
  const std::vector<Vec3d> from = moved(flow, points, precisely(1e-11));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<Vec3d> beside = points;
    for (Vec3d& p : beside) p[axis] += h;
    beside = moved(flow, beside, precisely(1e-11));
    for (std::size_t i = 0; i < points.size(); ++i) result[i] = std::fmax(result[i], norm(beside[i] - from[i]) / h);
  }
  return result;
}

double diagonal_of(const std::vector<Vec3d>& points) { return bounding_box(points).diagonal(); }

std::vector<NamedSegment> segments_of_every_kind(Random& random) {
  std::vector<NamedSegment> result = test::random_segments(random);
  std::erase_if(result, [](const NamedSegment& each) {
    return std::holds_alternative<Handles<double>>(each.segment.fields.front().region);
  });
  Segment bend = test::resting(Rotation<double>{{0, 0, 1}, 1.2, 1}, HalfSpace<double>{{1, 0, 0}, {0, 0, 1}, 0.6},
                               {0, 0, 0}, {-0.3, 0.3});
  bend.limit_cylinder = LimitCylinder{{0, 0, 0}, {1, 0, 0}, 0.4};
  result.push_back({"bend in a limit cylinder", bend});
  Segment mixed = test::translating(Capsule<double>{{0.1, 0.2, 0}}, {-0.3, 0, 0}, {0.2, 0.1, 0}, {0.1, 0.5});
  mixed.fields.push_back({{0.3, 0.1, 0}, Twist<double>{{0, 1, 0}, 0.4, 0.5}, Ball<double>{}, {0.1, 0.4}});
  mixed.fields.push_back(
      {{0, 0, 0.2}, Translation<double>{{0, 0, 0.3}}, PointSet<double>{{{0, 0, 0}, {0.1, 0, 0}}, {}, 6}, {0, 0.3}});
  result.push_back({"a sum of unlike fields", mixed});
  return result;
}

// The bar: 2e-5 of the box diagonal, of the CPU in double at 1e-10. Whole segments, halves, backwards.
TEST_F(GpuTest, AgreesWithTheReferenceForEveryKindOfSegment) {
  Random random(801);
  for (const NamedSegment& named : segments_of_every_kind(random)) {
    SCOPED_TRACE(named.name);
    const auto points = test::random_points(random, 300);
    const double diagonal = diagonal_of(points);
    for (const auto& [begin, end] : {std::pair{0.0, 1.0}, std::pair{0.8, 0.3}}) {
      Segment segment = named.segment;
      segment.begin = begin;
      segment.end = end;
      const Flow flow{{segment}};
      const auto exact = moved(flow, points, precisely(1e-10));
      const auto found = on_gpu(flow, points, default_options(diagonal));
      EXPECT_LT(test::greatest_distance(found, exact) / diagonal, 2e-5);
      EXPECT_GT(test::greatest_distance(exact, points) / diagonal, 0.005);  // something happened
    }
  }
}

// In double the shaders are held against the C++ far below what float resolves: the formulas are the same. Not all
// kinds of segments, as compiling takes long.
TEST_F(GpuTest, InDoubleItAgreesFarBelowFloat) {
  Random random(802);
  for (const NamedSegment& named : segments_of_every_kind(random)) {
    const auto points = test::random_points(random, 60);
    const bool chosen = named.name == "points" || named.name == "bend" || named.name == "blended capsule" ||
                        named.name == "turning pins";
    if (!chosen) continue;
    SCOPED_TRACE(named.name);
    const Flow flow{{named.segment}};
    const auto exact = moved(flow, points, precisely(1e-11));
    EXPECT_LT(test::greatest_distance(on_gpu(flow, points, precisely(1e-7)), exact), 1e-7);
  }
}

TEST_F(GpuTest, EveryFalloffIsThatOfTheReference) {
  Random random(813);
  for (const int falloff : test::kOtherFalloffs) {
    for (const NamedSegment& named : test::random_segments(random, falloff)) {
      const bool chosen =
          named.name == "ball" || named.name == "painting ball" || named.name == "rotate" || named.name == "points";
      const Thresholds<double>& thresholds = named.segment.fields.front().thresholds;
      const bool has_core = falloff == kWideFalloff && thresholds.inner > 0;  // which the CPU does
      if (!chosen || has_core) continue;
      SCOPED_TRACE(named.name + ", falloff " + std::to_string(falloff));
      const auto points = test::random_points(random, 300);
      const double diagonal = diagonal_of(points);
      const Flow flow{{named.segment}};
      const auto exact = moved(flow, points, precisely(1e-10));
      EXPECT_LT(test::greatest_distance(on_gpu(flow, points, default_options(diagonal)), exact) / diagonal, 2e-5);
      EXPECT_GT(test::greatest_distance(exact, points) / diagonal, 0.005);
    }
  }
}

TEST_F(GpuTest, EveryIntegratorKeepsTheTolerance) {
  Random random(803);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.4, 0.1, 0}, {0.1, 0.6})}};
  const auto points = test::random_points(random, 300);
  const auto exact = moved(flow, points, precisely(1e-11));
  for (const Integrator integrator : {Integrator::rk4, Integrator::tsitouras}) {
    for (const double tolerance : {1e-4, 1e-5}) {
      AdvectOptions options;
      options.integrator = integrator;
      options.tolerance = tolerance;
      EXPECT_LT(test::greatest_distance(on_gpu(flow, points, options), exact), 1.5 * tolerance + 3e-6);
    }
  }
}

TEST_F(GpuTest, PointsThatNoToolTouchesKeepTheirBits) {
  Random random(804);
  for (const NamedSegment& named : segments_of_every_kind(random)) {
    if (std::holds_alternative<HalfSpace<double>>(named.segment.fields[0].region)) continue;
    SCOPED_TRACE(named.name);
    auto points = test::random_points(random, 300, 3.0);
    points.push_back({-0.0, 30.0, -0.0});  // a negative zero is a bit pattern too
    const auto after = on_gpu(Flow{{named.segment}}, points, default_options(1));
    int outside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (moved(Flow{{named.segment}}, {points[i]}, precisely(1e-9))[0] != points[i]) continue;
      ++outside;
      EXPECT_EQ(bits({after[i]}), bits({points[i]}));
    }
    EXPECT_GE(outside, 100);
  }
}

TEST_F(GpuTest, RigidCoresMoveExactly) {
  Random random(805);
  const Vec3d by{0.125, 0.25, -0.5};  // sums with it are exact
  std::vector<Vec3d> points;
  std::vector<Vec3d> expected;
  const Flow core{{test::translating(Ball<double>{}, {5, 0, 1}, by, {0.5, 0.7})}};
  for (int i = 0; i < 100; ++i) {
    const double radius = random.uniform(0, 0.4999);
    points.push_back(Vec3d{5, 0, 1} + random.unit() * radius);
    expected.push_back(points.back() + by);
  }
  EXPECT_EQ(bits(on_gpu(core, points, default_options(1))), bits(expected));
}

// A tool that sweeps past the points, so that most contacts graze.
TEST_F(GpuTest, GrazingToolsAreNotMissed) {
  Random random(806);
  const Vec3d start{-0.5, 0, 0};
  const Vec3d by{1, 0.1, -0.1};
  const Thresholds<double> thresholds{0.1, 0.3};
  std::vector<Vec3d> points;
  for (int i = 0; i < 300; ++i) {
    const double angle = random.uniform(0, 6.3);
    const double radius = random.uniform(0.2, 0.301);
    const double along = random.uniform(-0.1, 1.1);
    points.push_back(start + by * along + Vec3d{0, std::cos(angle), std::sin(angle)} * radius);
  }
  for (const Segment& segment :
       {test::translating(Ball<double>{}, start, by, thresholds),
        test::translating(Capsule<double>{{0.1, 0.2, 0}}, start, by, thresholds),
        test::translating(PointSet<double>{{{0, 0.1, 0}, {0.1, 0, 0}}, {}, 8}, start, by, thresholds)}) {
    const Flow flow{{segment}};
    const auto exact = moved(flow, points, precisely(1e-10));
    const auto found = on_gpu(flow, points, default_options(1));
    const auto stretch = stretches(flow, points);
    const auto on_cpu = moved(flow, points, default_options(1));
    double worst = 0;
    double worst_on_cpu = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      worst = std::fmax(worst, norm(found[i] - exact[i]) / stretch[i]);
      worst_on_cpu = std::fmax(worst_on_cpu, norm(on_cpu[i] - exact[i]) / stretch[i]);
    }
    EXPECT_LT(worst, 1e-5 + 2 * worst_on_cpu);
    EXPECT_LT(worst, 5e-5);
  }
}

TEST_F(GpuTest, ManySegmentsThereAndBack) {
  Random random(807);
  Flow flow;
  for (int i = 0; i < 100; ++i) {
    const Vec3d center = random.in_box(0.5);
    flow.segments.push_back(test::translating(Ball<double>{}, center, random.in_box(0.03), {0, 0.4}));
  }
  for (const NamedSegment& named : test::random_segments(random)) {
    if (named.name == "rotate" || named.name == "capsule") flow.segments.push_back(named.segment);
  }
  const auto points = test::random_points(random, 500);
  const auto there = on_gpu(flow, points, default_options(1));
  EXPECT_GT(test::greatest_distance(there, points), 0.02);
  EXPECT_LT(test::greatest_distance(there, moved(flow, points, precisely(1e-10))), 2e-5);
  EXPECT_LT(test::greatest_distance(on_gpu(inverse(flow), there, default_options(1)), points), 4e-5);
}

// A contact patch of thousands of points; its way is short, as Mesa on the CPU would cut longer loops.
TEST_F(GpuTest, LargePointSets) {
  Random random(808);
  PointSet<double> set;
  set.exponent = 16;
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(-0.3, 0.3);
    const double y = random.uniform(-0.3, 0.3);
    set.points.push_back({x, y, 0.05 * x * y});
  }
  const Flow flow{{test::translating(set, {0, 0, 0}, {0, 0, 0.02}, {0, 0.3})}};
  const auto points = test::random_points(random, 100);
  const auto exact = moved(flow, points, precisely(1e-10));
  EXPECT_LT(test::greatest_distance(on_gpu(flow, points, default_options(1)), exact), 1e-5);
}

// So many that they are gone through by a tree: in a patch, on a sphere, in a cube, near and among them. By the sums'
// allowed error the result errs by less than the tolerance.
TEST_F(GpuTest, PointSetsWithTrees) {
  Random random(815);
  for (const int exponent : {8, 16}) {
    for (int kind = 0; kind < 3; ++kind) {
      SCOPED_TRACE(std::to_string(exponent) + ", " + std::to_string(kind));
      PointSet<double> set;
      set.exponent = exponent;
      for (int i = 0; i < 1500; ++i) {
        const Vec3d p = random.in_box(0.5);
        const Vec3d on_patch{p.x, p.y, 0.2 * p.x * p.y};
        set.points.push_back(kind == 0 ? on_patch : (kind == 1 ? normalized(p) * 0.5 : p));
      }
      const double outer = 0.05;
      const Flow flow{{test::translating(set, {0.1, 0, 0}, Vec3d{0.02, 0, 0.04} * outer, {0, outer})}};
      const Segment& segment = flow.segments[0];
      EXPECT_GT(gpu::pack_tree(segment.fields[0], segment, default_options(1)).nodes, 0);
      std::vector<Vec3d> points;
      for (int i = 0; i < 200; ++i) {
        const Vec3d& p = set.points[static_cast<std::size_t>(random.integer(0, 1499))];
        points.push_back(Vec3d{0.1, 0, 0} + p + random.in_box(outer));
      }
      const auto exact = moved(flow, points, precisely(1e-9));
      EXPECT_LT(test::greatest_distance(on_gpu(flow, points, default_options(1)), exact), 1e-5);
      EXPECT_GT(test::greatest_distance(exact, points), 0.02 * outer);
    }
  }
}

// Far below what float resolves: so the sums are those of all points. On a short way, as Mesa's loops are.
TEST_F(GpuTest, PointSetsWithTreesInDouble) {
  Random random(817);
  PointSet<double> set;
  std::vector<Vec3d> points;
  for (int i = 0; i < 1500; ++i) {
    const Vec3d p = random.in_box(0.5);
    set.points.push_back({p.x, p.y, 0.2 * p.x * p.y});
    if (i < 20) points.push_back(set.points.back() + Vec3d{0, 0, random.uniform(0.02, 0.05)});
  }
  const Flow flow{{test::translating(set, {0, 0, 0}, {0, 0, 1e-4}, {0, 0.05})}};
  const AdvectOptions options = precisely(1e-9);
  EXPECT_GT(gpu::pack_tree(flow.segments[0].fields[0], flow.segments[0], options).nodes, 0);
  const auto exact = moved(flow, points, precisely(1e-12));
  EXPECT_LT(test::greatest_distance(on_gpu(flow, points, options), exact), 1e-9);
  EXPECT_GT(test::greatest_distance(exact, points), 2e-5);
}

// Where nearly all points count everywhere, their sum is taken plainly; so is that of few.
TEST_F(GpuTest, TreesOnlyWhereTheyPay) {
  Random random(816);
  const auto nodes = [&](int points, double outer) {
    PointSet<double> set;
    for (int i = 0; i < points; ++i) set.points.push_back(random.in_box(0.5));
    const Segment segment = test::translating(set, {0, 0, 0}, {0, 0, 0.1}, {0, outer});
    if (!gpu::may_have_tree(segment.fields[0], segment)) return 0;
    return gpu::pack_tree(segment.fields[0], segment, default_options(1)).nodes;
  };
  EXPECT_GT(nodes(5000, 0.05), 0);
  EXPECT_EQ(nodes(5000, 2), 0);
  EXPECT_EQ(nodes(500, 0.05), 0);
}

// The tool, the points and the path far from the origin.
TEST_F(GpuTest, DoesNotMindPositionsFarFromTheOrigin) {
  Random random(809);
  const Vec3d far{1000, -2000, 500};
  Segment segment = test::translating(Ball<double>{}, far, {0.3, 0.1, 0}, {0.2, 0.8});
  std::vector<Vec3d> points;
  for (const Vec3d& p : test::random_points(random, 300)) points.push_back(far + p);
  const auto exact = moved(Flow{{segment}}, points, precisely(1e-10));
  EXPECT_LT(test::greatest_distance(on_gpu(Flow{{segment}}, points, default_options(1)), exact), 1e-5);

  Segment pins = test::pinning(random, 5, 0.8, 0.3);
  for (Field& pin : pins.fields) pin.center += far;
  const auto pinned = moved(Flow{{pins}}, points, precisely(1e-10));
  EXPECT_LT(test::greatest_distance(on_gpu(Flow{{pins}}, points, default_options(1)), pinned), 1e-5);
}

TEST_F(GpuTest, BuffersOfAnySizeGiveTheSameBits) {
  Random random(810);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.5}),
                   test::translating(Ball<double>{}, {0.3, 0.1, 0}, {0, 0.1, 0.2}, {0.2, 0.5})}};
  const auto points = test::random_points(random, 1000);
  AdvectOptions options = default_options(1);
  std::vector<std::uint32_t> steps(points.size(), 3);
  options.steps = steps;
  const auto whole = on_gpu(flow, points, options);
  GpuOptions small;
  small.most_points = 192;
  Gpu in_ranges(small);
  auto parts = points;
  std::vector<std::uint32_t> steps_of_parts(points.size(), 3);
  options.steps = steps_of_parts;
  const AdvectResult result = in_ranges.advect(flow, parts, options);
  EXPECT_EQ(bits(parts), bits(whole));
  EXPECT_EQ(steps, steps_of_parts);
  std::uint64_t sum = 0;
  for (const std::uint32_t count : steps) sum += count - 3;
  EXPECT_EQ(sum, result.accepted_steps);
  EXPECT_GT(sum, 500U);
  EXPECT_GT(result.evaluations, sum);
}

// Points stay on the GPU between flows.
TEST_F(GpuTest, PointsStayOnTheGpu) {
  Random random(811);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.5})}};
  const Flow twice{{flow.segments[0], flow.segments[0]}};
  const auto points = test::random_points(random, 500);
  auto uploaded = gpu().upload(points);
  gpu().advect(flow, uploaded, default_options(1));
  gpu().advect(flow, uploaded, default_options(1));
  std::vector<Vec3d> found(points.size());
  gpu().download(uploaded, found);
  EXPECT_EQ(bits(found), bits(on_gpu(twice, points, default_options(1))));
}

TEST_F(GpuTest, StopsWhenCancelledAndReportsProgress) {
  Random random(812);
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8}),
                   test::translating(Ball<double>{}, {0.5, 0, 0}, {0, 0.5, 0}, {0.1, 0.8})}};
  const auto points = test::random_points(random, 500);
  Progress progress;
  AdvectOptions options = default_options(1);
  options.progress = &progress;
  on_gpu(flow, points, options);
  EXPECT_EQ(progress.done, 1000U);
  progress.cancel = true;
  auto untouched = points;
  EXPECT_EQ(gpu().advect(flow, untouched, options).status, AdvectStatus::cancelled);
  EXPECT_EQ(bits(untouched), bits(points));
}

TEST_F(GpuTest, RefusesWhatItCannotDo) {
  std::vector<Vec3d> points(1);
  AdvectOptions options;
  options.tolerance = 0;
  const Segment good = test::translating(Ball<double>{}, {0, 0, 0}, {0.5, 0, 0}, {0.1, 0.8});
  EXPECT_THROW(gpu().advect(Flow{{good}}, points, options), InvalidInput);
  options = default_options(1);
  Segment own = good;
  own.fields[0].region = custom_region([](const Vec3d& d, double) { return RegionValue<double>{norm(d), d}; });
  try {
    gpu().advect(Flow{{good, own}}, points, options);
    ADD_FAILURE() << "not refused";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("segment 2 of the flow: a field is a function"), std::string::npos);
  }
}

Flow bend_without_end() {
  return {{test::resting(Rotation<double>{{0, 0, 1}, 1.5, 1}, HalfSpace<double>{{1, 0, 0}}, {0, 0, 0}, {-0.3, 0.3})}};
}

// A path line whose velocity no number holds, far out in a bend's slab.
TEST_F(GpuTest, SaysWhereAPathLineDoesNotEnd) {
  const std::vector<Vec3d> at{{0, 1e25, 0}};
  auto points = at;
  ASSERT_EQ(advect(bend_without_end(), points, default_options(1)).status, AdvectStatus::step_limit);
  points = at;
  EXPECT_EQ(gpu().advect(bend_without_end(), points, default_options(1)).status, AdvectStatus::step_limit);
  EXPECT_EQ(bits(points), bits(at));
}

// 100,000 steps: more rounds than some drivers allow (Mesa 22 on the CPU, not Mesa 25), which must not go unnoticed.
TEST_F(GpuTest, LoopsThatTheDriverCutsShortAreNoticedAndTheCpuDoesThem) {
  const std::vector<Vec3d> at{{0, -40, 0}};
  auto found = at;
  std::string failure;
  const Backend backend = gpu::backend_or_cpu([&](const std::string& why) { failure = why; });
  EXPECT_EQ(backend(bend_without_end(), found, default_options(1)).status, AdvectStatus::done);
  const double rounding = 5e-2;  // that of float
  EXPECT_LT(test::greatest_distance(found, moved(bend_without_end(), at, default_options(1))), rounding);
  EXPECT_TRUE(failure.empty() || failure.find("the graphics driver stops loops") == 0) << failure;
}

TEST_F(GpuTest, ABackendIsTheGpuAndDoesWhatItCannotOnTheCpu) {
  Random random(813);
  const auto points = test::random_points(random, 100);
  std::string failure;
  const Backend backend = gpu::backend_or_cpu([&](const std::string& why) { failure = why; });
  const Flow flow{{test::translating(Ball<double>{}, {0, 0, 0}, {0.3, 0.1, 0}, {0.2, 0.5})}};
  auto found = points;
  EXPECT_EQ(backend(flow, found, default_options(1)).status, AdvectStatus::done);
  EXPECT_EQ(bits(found), bits(on_gpu(flow, points, default_options(1))));
  Segment own = flow.segments[0];
  own.fields[0].region = custom_region([](const Vec3d& d, double) {
    return RegionValue<double>{norm(d), d / norm(d)};
  });
  found = points;
  EXPECT_EQ(backend(Flow{{own}}, found, default_options(1)).status, AdvectStatus::done);
  EXPECT_EQ(bits(found), bits(moved(Flow{{own}}, points, default_options(1))));
  const std::vector<Vec3d> masked_points{{0, 0, 0}, {0.05, 0, 0}};
  const Flow held = masked(Flow{{test::pinning(random, 3, 0.8, 0.3)}}, Mask(masked_points, {}, 0.3));
  found = points;
  EXPECT_EQ(backend(held, found, default_options(1)).status, AdvectStatus::done);
  EXPECT_EQ(bits(found), bits(moved(held, points, default_options(1))));
  const Flow grid = masked(Flow{{test::random_grid(random)}}, Mask(masked_points, {}, 0.3));
  found = points;
  EXPECT_EQ(backend(grid, found, default_options(1)).status, AdvectStatus::done);
  EXPECT_EQ(bits(found), bits(moved(grid, points, default_options(1))));
  Handles<double> sets = test::random_handles(random, {0.5, 0, 0});
  sets.sweep = {0.1, 0, 0};
  const Flow handles{{test::translating(sets, {0, 0, 0}, {0.1, 0, 0}, {0, 1})}};
  found = points;
  EXPECT_EQ(backend(handles, found, default_options(1)).status, AdvectStatus::done);
  EXPECT_EQ(bits(found), bits(moved(handles, points, default_options(1))));
  EXPECT_EQ(failure, "");
}

}  // namespace
}  // namespace knead::advect_gpu_test
