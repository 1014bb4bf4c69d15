// Poses by near-rigid flows: parts and pins arrive, rigid motions stay rigid, the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "knead/error.h"
#include "knead/flow.h"
#include "math/sparse_cholesky.h"
#include "pose/lattice_nodes.h"
#include "pose/near_rigid.h"
#include "pose/pose_motion.h"
#include "pose/sound_steps.h"

namespace knead::detail::pose_test {
namespace {

// Points of a bar along x, from -1 to 1, evenly spread.
std::vector<Vec3d> bar_points(double spacing = 0.05, double half = 0.12) {
  std::vector<Vec3d> points;
  for (double x = -1; x <= 1; x += spacing) {
    for (double y = -half; y <= half; y += spacing) {
      for (double z = -half; z <= half; z += spacing) points.push_back({x, y + 0.003 * x, z - 0.004 * x});
    }
  }
  return points;
}

std::vector<Vec3d> where(const std::vector<Vec3d>& points, bool (*is_wanted)(const Vec3d&)) {
  std::vector<Vec3d> result;
  std::copy_if(points.begin(), points.end(), std::back_inserter(result), is_wanted);
  return result;
}

Flow flow_of(const PotentialGrid& grid) {
  Segment segment;
  segment.grid = grid;
  return {{std::move(segment)}};
}

double strain(const Mat3d& g) {
  const double xy = g.row0.y + g.row1.x;
  const double xz = g.row0.z + g.row2.x;
  const double yz = g.row1.z + g.row2.y;
  return std::sqrt(g.row0.x * g.row0.x + g.row1.y * g.row1.y + g.row2.z * g.row2.z +
                   0.5 * (xy * xy + xz * xz + yz * yz));
}

// The gradient of v by differences.
Mat3d gradient_at(const Flow& flow, const Vec3d& x) {
  constexpr double kStep = 1e-5;
  Mat3d columns;
  Vec3d* const to[3] = {&columns.row0, &columns.row1, &columns.row2};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d step{0, 0, 0};
    step[axis] = kStep;
    const std::vector<Vec3d> v = velocities(flow, std::vector<Vec3d>{x + step, x - step}, 0);
    *to[axis] = (v[0] - v[1]) / (2 * kStep);
  }
  return {columns.column(0), columns.column(1), columns.column(2)};
}

// The matrix of a three-dimensional mesh of springs, so that its columns have many rows in common.
SymmetricMatrix spring_matrix(int n, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  const auto number = [n](int x, int y, int z) { return x + n * (y + n * z); };
  SymmetricMatrix matrix;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        matrix.rows.push_back(number(x, y, z));
        matrix.values.push_back(8 + uniform(random));
        for (const auto& [dx, dy, dz] : {std::tuple(1, 0, 0), std::tuple(0, 1, 0), std::tuple(0, 0, 1)}) {
          if (x + dx >= n || y + dy >= n || z + dz >= n) continue;
          matrix.rows.push_back(number(x + dx, y + dy, z + dz));
          matrix.values.push_back(-uniform(random));
        }
        matrix.begin.push_back(matrix.rows.size());
      }
    }
  }
  return matrix;
}

std::vector<double> product(const SymmetricMatrix& matrix, const std::vector<double>& x) {
  std::vector<double> y(x.size(), 0.0);
  for (std::size_t j = 0; j < matrix.size(); ++j) {
    for (std::size_t i = matrix.begin[j]; i < matrix.begin[j + 1]; ++i) {
      const auto row = static_cast<std::size_t>(matrix.rows[i]);
      y[row] += matrix.values[i] * x[j];
      if (row != j) y[j] += matrix.values[i] * x[row];
    }
  }
  return y;
}

TEST(SparseCholesky, SolvesWhatItFactorised) {
  std::mt19937 random(1);
  for (const int n : {1, 2, 3, 7, 9}) {
    const SymmetricMatrix matrix = spring_matrix(n, random);
    std::vector<double> x(matrix.size());
    for (double& number : x) number = std::uniform_real_distribution<double>(-1, 1)(random);
    std::vector<double> b = product(matrix, x);
    SparseCholesky factor;
    ASSERT_TRUE(factor.factorize(matrix));
    factor.solve(b);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(b[i], x[i], 1e-12) << n;
  }
}

TEST(SparseCholesky, HasTheSameBitsForEveryThreadCount) {
  std::mt19937 random(3);
  const SymmetricMatrix matrix = spring_matrix(13, random);
  const std::vector<double> right(matrix.size(), 1.0);
  std::vector<double> one = right;
  SparseCholesky factor;
  ASSERT_TRUE(factor.factorize(matrix, 1));
  factor.solve(one);
  for (const int threads : {2, 3, 8}) {
    std::vector<double> found = right;
    SparseCholesky other;
    ASSERT_TRUE(other.factorize(matrix, threads));
    other.solve(found);
    EXPECT_EQ(found, one) << threads;
  }
}

TEST(SparseCholesky, SaysThatAMatrixIsNotPositiveDefinite) {
  std::mt19937 random(2);
  for (const std::size_t column : {0UL, 60UL, 124UL}) {  // within a subtree, and above them
    SymmetricMatrix matrix = spring_matrix(5, random);
    matrix.values[matrix.begin[column]] = -1;
    EXPECT_FALSE(SparseCholesky().factorize(matrix)) << column;
  }
}

TEST(LatticeNodes, NeighboursAreThoseThatShareACell) {
  const std::vector<LatticeCell> cells{{0, 0, 0}, {1, 0, 0}, {4, 2, -3}, {9, 9, 9}};
  const LatticeNodes nodes(cells);
  for (const LatticeCell& cell : cells) {
    const auto numbers = nodes.of_cell(cell);
    for (std::size_t a = 0; a < kCellNodes; ++a) {
      for (std::size_t b = 0; b < kCellNodes; ++b) {
        if (numbers[b] < numbers[a]) continue;
        const auto rank = static_cast<std::size_t>(nodes.rank(a, b, numbers[a]));
        ASSERT_EQ(nodes.neighbors_after(numbers[a])[rank], numbers[b]);
      }
    }
  }
  EXPECT_EQ(nodes.size(), 80 + 2 * 64 - 2u);  // the third cell shares two nodes with the second
}

TEST(SplineBasis, RowsAreThoseOfTheField) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  PotentialGrid grid;
  grid.spacing = 0.3;
  grid.counts = {4, 4, 4};
  std::vector<Vec3d> coefficients(64);
  for (Vec3d& a : coefficients) a = {uniform(random), uniform(random), uniform(random)};
  grid.coefficients = SharedVectors(coefficients);
  // The only cell with all nodes begins at the node (1, 1, 1).
  const Vec3d x = Vec3d{1.3, 1.6, 1.1} * grid.spacing;
  const SplineBasis basis(x, grid.spacing);
  ASSERT_EQ(basis.cell(), (LatticeCell{1, 1, 1}));
  const auto apply = [&](const SplineRow& row) {
    double sum = 0;
    for (std::size_t node = 0; node < kCellNodes; ++node) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum += row[axis][node] * coefficients[node][axis];
    }
    return sum;
  };
  const Vec3d v = velocities(flow_of(grid), std::vector<Vec3d>{x}, 0).front();
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(apply(basis.velocity()[axis]), v[axis], 1e-12);
  double square = 0;
  for (const SplineRow& row : basis.strain()) square += apply(row) * apply(row);
  EXPECT_NEAR(std::sqrt(square), strain(gradient_at(flow_of(grid), x)), 1e-6);
}

// A rigid motion has no strain, so the whole body does what a few of its points do.
TEST(NearRigidSystem, ABodyMovesRigidlyWithAFewPoints) {
  const std::vector<Vec3d> bar = bar_points();
  const Vec3d rate{0.1, -0.3, 0.5};
  const Vec3d by{0.02, 0.1, -0.05};
  const auto motion = [&](const Vec3d& x) { return cross(rate, x) + by; };
  VelocityRows rows;
  rows.points = {{-0.9, 0, 0}, {-0.7, 0.1, 0}, {-0.8, 0, 0.1}, {-0.9, -0.1, -0.1}};
  rows.weight = 100;
  for (const Vec3d& p : rows.points) rows.wanted.push_back(motion(p));
  const NearRigidSystem system({{0, 0, 0}, 0.15}, {bar, {}}, std::span(&rows, 1));
  const Flow flow = flow_of(system.solve(std::span(&rows, 1)));
  const std::vector<Vec3d> v = velocities(flow, bar, 0);
  double greatest = 0;
  for (std::size_t i = 0; i < bar.size(); ++i) greatest = std::max(greatest, norm(v[i] - motion(bar[i])));
  EXPECT_LT(greatest, 0.01);  // of a speed of 0.6: what the ridge takes
}

// A strain that is wanted, here one that a field without divergence can have everywhere, is made.
TEST(NearRigidSystem, MakesTheStrainThatIsWanted) {
  const std::vector<Vec3d> bar = bar_points();
  const Mat3d wanted{{0.1, 0.03, -0.02}, {0.03, -0.06, 0.05}, {-0.02, 0.05, -0.04}};
  BodySamples body{bar, {}};
  body.strain.assign(bar.size(), wanted);
  VelocityRows hold{{{0, 0, 0}}, {Vec3d{0, 0, 0}}, 1};
  const NearRigidSystem system({{0, 0, 0}, 0.15}, body, std::span(&hold, 1));
  const Flow flow = flow_of(system.solve(std::span(&hold, 1)));
  for (const Vec3d& p : {Vec3d{0.3, 0.02, 0.01}, Vec3d{-0.5, 0, 0.05}}) {
    const Mat3d g = gradient_at(flow, p);
    const Mat3d symmetric{{g.row0.x, 0.5 * (g.row0.y + g.row1.x), 0.5 * (g.row0.z + g.row2.x)},
                          {0.5 * (g.row0.y + g.row1.x), g.row1.y, 0.5 * (g.row1.z + g.row2.y)},
                          {0.5 * (g.row0.z + g.row2.x), 0.5 * (g.row1.z + g.row2.y), g.row2.z}};
    EXPECT_LT(strain(symmetric + wanted * -1.0), 0.02 * strain(wanted));
  }
}

TEST(NearRigidSystem, APatchThatSpinsTurnsWithTheBody) {
  const std::vector<Vec3d> bar = bar_points();
  VelocityRows hold{where(bar, [](const Vec3d& p) { return p.x < -0.8; }), {}, 20};
  hold.wanted.assign(hold.points.size(), Vec3d{});
  VelocityRows pin{{{0.95, 0, 0}, {0.95, 0.05, 0}, {0.95, -0.05, 0}, {1, 0, 0}, {0.9, 0, 0}}, {}, 100, true};
  pin.wanted.assign(pin.points.size(), Vec3d{0, 0.1, 0});
  const auto turning = [&](bool spins) {
    pin.spins = spins;
    const std::vector<VelocityRows> rows{hold, pin};
    const NearRigidSystem system({{0, 0, 0}, 0.15}, {bar, {}}, rows);
    const Flow flow = flow_of(system.solve(rows));
    const Mat3d g = gradient_at(flow, {0.95, 0, 0});
    return 0.5 * (g.row1.x - g.row0.y);
  };
  EXPECT_GT(turning(true), 0.08);  // as the end of a bent beam does
  EXPECT_LT(std::abs(turning(false)), 0.03);
}

// The left half of a bar rests. Far from the middle nothing is unknown there, and the rest moves as before.
TEST(NearRigidSystem, WhatRestsHasNoUnknowns) {
  const std::vector<Vec3d> bar = bar_points();
  VelocityRows hold{where(bar, [](const Vec3d& p) { return p.x < 0; }), {}, 500};
  hold.wanted.assign(hold.points.size(), Vec3d{});
  VelocityRows pull{where(bar, [](const Vec3d& p) { return p.x > 0.7; }), {}, 100};
  pull.wanted.assign(pull.points.size(), Vec3d{0, 0.1, 0});
  BodySamples body{bar, {}};
  const std::vector<VelocityRows> all{hold, pull};
  const NearRigidSystem whole({{0, 0, 0}, 0.1}, body, all);
  for (const Vec3d& p : bar) body.held.push_back(p.x < 0);
  hold.rests = true;
  const std::vector<VelocityRows> rows{hold, pull};
  const NearRigidSystem part({{0, 0, 0}, 0.1}, body, rows);
  EXPECT_LT(part.unknowns(), 0.8 * static_cast<double>(whole.unknowns()));
  EXPECT_EQ(part.unknowns(), count_unknowns({{0, 0, 0}, 0.1}, body, rows));
  const std::vector<Vec3d> v = velocities(flow_of(whole.solve(all)), bar, 0);
  const std::vector<Vec3d> u = velocities(flow_of(part.solve(rows)), bar, 0);
  for (std::size_t i = 0; i < bar.size(); ++i) {
    EXPECT_LT(norm(u[i] - v[i]), 0.005) << bar[i].x;
    if (bar[i].x < -0.5) {
      EXPECT_EQ(u[i], Vec3d{});
    }
  }
}

TEST(NearRigidSystem, RowsWithNormalsLetPointsSlide) {
  const std::vector<Vec3d> bar = bar_points();
  VelocityRows pull{{{0.9, 0, 0}}, {{0.1, 0, 0}}, 100};
  VelocityRows wall{where(bar, [](const Vec3d& p) { return p.z < -0.1; }), {}, 100};
  wall.wanted.assign(wall.points.size(), Vec3d{});
  wall.normals.assign(wall.points.size(), Vec3d{0, 0, 1});
  const std::vector<VelocityRows> rows{pull, wall};
  const NearRigidSystem system({{0, 0, 0}, 0.15}, {bar, {}}, rows);
  const std::vector<Vec3d> v = velocities(flow_of(system.solve(rows)), wall.points, 0);
  for (const Vec3d& u : v) {
    EXPECT_NEAR(u.z, 0, 1e-3);
    EXPECT_NEAR(u.x, 0.1, 0.02);  // the body slides as a whole
  }
}

TEST(NearRigidSystem, RefusesMoreUnknownsThanItSolves) {
  std::vector<Vec3d> far;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) far.push_back({4.0 * i, 4.0 * j, 0});
  }
  EXPECT_THROW(NearRigidSystem({{0, 0, 0}, 1}, {far, {}}, {}), InvalidInput);
}

PoseProblem bent_bar() {
  const std::vector<Vec3d> bar = bar_points();
  PoseProblem problem;
  problem.body.points = bar;
  problem.spacing = 0.15;
  problem.diagonal = 2;
  PosedPart hold;
  hold.points = where(bar, [](const Vec3d& p) { return p.x < -0.6; });
  PosedPart part;
  part.points = where(bar, [](const Vec3d& p) { return p.x > 0.6; });
  part.axis = {0, 0, 1};
  part.angle = 1;
  problem.parts = {hold, part};
  return problem;
}

std::vector<PotentialGrid> grids_of(const PoseProblem& problem) {
  std::vector<PotentialGrid> grids;
  PoseRun(problem).go([&](const PotentialGrid& grid) {
    grids.push_back(grid);
    return true;
  });
  return grids;
}

TEST(Pose, PartsArriveAndTheBodyHardlyStretches) {
  const PoseProblem problem = bent_bar();
  std::vector<Vec3d> points = problem.body.points;
  Flow flow;
  const PoseOutcome outcome = PoseRun(problem).go([&](const PotentialGrid& grid) {
    flow.segments.push_back(flow_of(grid).segments.front());
    return true;
  });
  EXPECT_EQ(outcome.segments, flow.segments.size());
  EXPECT_LT(outcome.part_distance, 1.5e-3 * problem.diagonal);
  AdvectOptions options;
  options.tolerance = 1e-8;
  options.precision = Precision::float64;
  double least = 1;
  double greatest = 1;
  for (const Mat3d& j : jacobians(flow, points, options)) {
    EXPECT_NEAR(determinant(j), 1, 1e-5);
    least = std::min(least, norm(j.column(0)));
    greatest = std::max(greatest, norm(j.column(0)));
  }
  // A beam of half-thickness 0.12 that bends by 1 over 1.2 stretches by 1 +- 0.1 at least.
  EXPECT_LT(greatest, 1.3);
  EXPECT_GT(least, 0.75);
}

TEST(Pose, TheBitsDoNotDependOnThreads) {
  PoseProblem problem = bent_bar();
  problem.threads = 1;
  const std::vector<PotentialGrid> one = grids_of(problem);
  problem.threads = 2;
  EXPECT_TRUE(one == grids_of(problem));
}

// A drag that goes on repeats nothing.
TEST(Pose, APathThatGoesOnOnlyAddsGrids) {
  PoseProblem problem = bent_bar();
  problem.parts.pop_back();
  problem.pins = {{{{0.95, 0, 0}, {0.94, 0.1, 0}, {0.93, 0.21, 0}}, 0.05, {}}};
  const std::vector<PotentialGrid> first = grids_of(problem);
  problem.pins.front().path.push_back({0.9, 0.3, 0.05});
  const std::vector<PotentialGrid> all = grids_of(problem);
  ASSERT_GT(all.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(first[i] == all[i]) << i;
}

TEST(Pose, PinsArriveAndTurnAsTheyAreTold) {
  PoseProblem problem = bent_bar();
  problem.parts.pop_back();
  const Vec3d start{0.95, 0, 0};
  const Vec3d end{0.85, 0.4, 0.1};
  for (const bool keeps : {false, true}) {
    problem.pins = {{{start, end}, 0.05, {}}};
    if (keeps) problem.pins.front().turn = Vec3d{0, 0, 0};
    std::vector<Vec3d> followed{start, start + Vec3d{0, 0.02, 0}};
    const PoseOutcome outcome = PoseRun(problem).go([&](const PotentialGrid& grid) {
      AdvectOptions options;
      options.tolerance = 1e-8;
      advect(flow_of(grid), followed, options);
      return true;
    });
    EXPECT_LT(norm(followed[0] - end), 2e-3);
    EXPECT_LT(outcome.part_distance, 2e-3);
    const Vec3d across = (followed[1] - followed[0]) / 0.02;
    EXPECT_NEAR(norm(across), 1, 0.15);
    if (keeps) {
      EXPECT_GT(across.y, 0.95);
    } else {
      EXPECT_LT(across.y, 0.945);
    }
  }
}

// A motion on a line on which nothing beyond an end is sound, and no long step before it.
struct LineMotion {
  double end = 1;
  double longest = 1;
  double place = 0;
  double wanted = 0;
  std::vector<double> spacings{};

  SoundReach go(const std::vector<double>& times) {
    SteppedMotion motion;
    motion.solve = [&](double from, double to) {
      EXPECT_EQ(from, place);
      wanted = to;
      return PotentialGrid{};
    };
    motion.take = [&](const PotentialGrid&) -> std::string {
      if (wanted > end || wanted - place > longest) return "there is a wall";
      place = wanted;
      return {};
    };
    motion.set_spacing = [&](double factor) { spacings.push_back(factor); };
    return step_soundly(times, motion);
  }
};

TEST(SoundSteps, AreHalvedUntilTheyAreSound) {
  LineMotion motion{.longest = 0.2};
  const SoundReach reach = motion.go({0, 0.5, 1, 1});
  EXPECT_EQ(reach.time, 1);
  EXPECT_TRUE(reach.problem.empty()) << reach.problem;
  EXPECT_TRUE(motion.spacings.empty());
}

// Halved steps are parts of one grid, until a step is taken or the spacing changes.
TEST(SoundSteps, InPartsNeedNoNewEquations) {
  int solved = 0;
  int tried = 0;
  int taken = 0;
  double place = 0;
  SteppedMotion motion;
  motion.solve = [&](double from, double to) {
    EXPECT_EQ(from, place);
    ++solved;
    PotentialGrid grid;
    grid.counts = {1, 1, 1};
    grid.coefficients = SharedVectors({{to - from, 0, 0}});
    return grid;
  };
  motion.take = [&](const PotentialGrid& grid) -> std::string {
    const double by = grid.coefficients[0].x;
    ++tried;
    if (by > 0.2 || place + by > 0.9) return "there is a wall";
    place += by;
    ++taken;
    return {};
  };
  motion.set_spacing = [](double) {};
  const SoundReach reach = step_soundly(std::vector<double>{0, 0.5, 1}, in_parts(motion));
  EXPECT_EQ(reach.time, place);
  EXPECT_GT(place, 0.87);
  EXPECT_LE(solved, taken + 3);  // one for each spacing is taken in no part
  EXPECT_GT(tried, 2 * solved);
}

TEST(SoundSteps, EndAtTheLastSoundState) {
  LineMotion motion{.end = 0.7};
  const SoundReach reach = motion.go({0, 0.25, 0.5, 0.75, 1});
  EXPECT_EQ(reach.time, motion.place);
  EXPECT_LE(reach.time, 0.7);
  EXPECT_GT(reach.time, 0.7 - 0.25 / 32);
  EXPECT_EQ(reach.problem, "there is a wall");
  EXPECT_EQ(motion.spacings, (std::vector<double>{1.5, 0.7}));
}

// Two tetrahedra in a flow that presses them by a third.
TEST(SoundSteps, ASurfaceStaysWhereAGridWouldSpoilIt) {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
  for (std::uint32_t k = 0; k < 2; ++k) {
    for (const Vec3d& p : {Vec3d{0, 0, 0}, Vec3d{0.2, 0, 0}, Vec3d{0, 0.2, 0}, Vec3d{0, 0, 0.2}}) {
      positions.push_back(p + Vec3d{0.25 * k, 0, 0});
    }
    const std::uint32_t i = 4 * k;
    for (const Triangle& t : {Triangle{i, i + 2, i + 1}, Triangle{i, i + 1, i + 3}, Triangle{i, i + 3, i + 2},
                              Triangle{i + 1, i + 2, i + 3}}) {
      triangles.push_back(t);
    }
  }
  AdvectOptions options;
  options.tolerance = 1e-6;
  BodySamples body;
  body.points = bar_points();
  std::vector<VelocityRows> rows(1);
  for (const Vec3d& p : body.points) {
    rows[0].points.push_back(p);
    rows[0].wanted.push_back({0.1 - 0.4 * p.x, 0.2 * p.y, 0.2 * p.z});
  }
  rows[0].weight = 100;
  const PotentialGrid grid = NearRigidSystem({{0, 0, 0}, 0.3}, body, rows).solve(rows);
  SoundSurface loose(positions, triangles, 10, options);
  EXPECT_EQ(loose.take(grid), "");
  EXPECT_NE(loose.positions(), positions);
  SoundSurface tight(positions, triangles, 1.2, options);
  EXPECT_NE(tight.take(grid).find("a triangle would be stretched or pressed"), std::string::npos);
  EXPECT_EQ(tight.positions(), positions);
  Progress progress;
  progress.cancel = true;
  options.progress = &progress;
  SoundSurface stopped(positions, triangles, 10, options);
  EXPECT_THROW(stopped.take(grid), Cancelled);
  EXPECT_EQ(stopped.positions(), positions);
}

// A grid that is too much is taken in part.
TEST(SoundSteps, TakeTheGreatestSoundPart) {
  PotentialGrid grid;
  grid.counts = {1, 1, 1};
  grid.coefficients = SharedVectors({{1, 0, 0}});
  const auto part_below = [&](double limit) {
    return take_soundly(grid, [&](const PotentialGrid& part) {
      return part.coefficients[0].x < limit ? std::string() : std::string("too much");
    });
  };
  EXPECT_EQ(part_below(2), 1);
  EXPECT_EQ(part_below(0.3), 0.25);
  EXPECT_EQ(part_below(0.001), 0);
}

TEST(Pose, StopsWhereItIsCancelled) {
  Progress progress;
  PoseProblem problem = bent_bar();
  problem.progress = &progress;
  std::size_t calls = 0;
  EXPECT_THROW(PoseRun(problem).go([&](const PotentialGrid&) {
    ++calls;
    progress.cancel = true;
    return true;
  }),
               Cancelled);
  EXPECT_EQ(calls, 1u);
}

}  // namespace
}  // namespace knead::detail::pose_test
