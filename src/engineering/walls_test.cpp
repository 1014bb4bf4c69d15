// Walls of a session: held patches keep their bits, and surfaces that slide are never left.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "knead/cells.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/session.h"

namespace knead::walls_test {
namespace {

constexpr const char* kPull =
    R"({"tool": "implicit", "path": [[0.5, 0.5, 0.2], [0.6, 0.4, 0.5]], "inner": 0.1, "outer": 0.9})";
constexpr const char* kTurn =
    R"({"tool": "rotate", "center": [0.9, 0.5, 0.4], "axis": [1, 2, 3], "angle_deg": 40, "inner": 0.1, "outer": 0.8})";

// The points of a unit cube, and its sides by name.
struct Cube {
  std::vector<Vec3d> points;
  std::vector<Patch> patches{{"left", {}}, {"right", {}}, {"bottom", {}}, {"ball", {}}};

  explicit Cube(const Vec3d& shift = {0, 0, 0}) {
    constexpr std::uint32_t n = 9;
    for (std::uint32_t i = 0; i < n * n * n; ++i) {
      const std::uint32_t at[] = {i % n, i / n % n, i / (n * n)};
      points.push_back(Vec3d{at[0] / 8.0, at[1] / 8.0, at[2] / 8.0} + shift);
      if (at[0] == 0) patches[0].points.push_back(i);
      if (at[0] == n - 1) patches[1].points.push_back(i);
      if (at[2] == 0) patches[2].points.push_back(i);
      if (at[0] + at[1] + at[2] == n) patches[3].points.push_back(i);
    }
    patches[3].points.push_back(0);
  }
};

Session session_of(const std::string& walls, std::initializer_list<const char*> strokes = {kPull, kTurn}) {
  std::string text = "{\"knead\": 1, \"walls\": [" + walls + "]}\n";
  for (const char* stroke : strokes) text += std::string(stroke) + "\n";
  return parse_session(text, "a.knead");
}

std::vector<Vec3d> deformed(const Cube& cube, const Session& session) {
  Mesh mesh;
  mesh.positions = cube.points;
  return replay(mesh, session, {}).shape.positions();
}

double greatest_motion(const Cube& cube, const std::vector<Vec3d>& moved) {
  double greatest = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) greatest = std::max(greatest, norm(moved[i] - cube.points[i]));
  return greatest;
}

TEST(Walls, AreReadAndWritten) {
  const std::string line =
      R"({"knead": 1, "walls": [{"patch": "inlet", "hold": true, "width": 0.2}, {"patch": "symmetry", "slide": true}, )"
      R"({"patch": "a", "periodic": "b", "width": 0.1}, {"patch": "rod", "layers": true}]})"
      "\n";
  const Session session = parse_session(line, "a");
  EXPECT_EQ(session.walls,
            (std::vector<Wall>{
                {"inlet", false, 0.2}, {"symmetry", true}, {"a", false, 0.1, "b"}, {"rod", false, {}, {}, true}}));
  EXPECT_EQ(serialize_session(session), line);
}

TEST(Walls, WhatIsHeldKeepsItsBits) {
  const Cube cube;
  const Session session = on_walls(session_of(R"({"patch": "left", "hold": true}, {"patch": "right", "hold": true})"),
                                   cube.patches, cube.points);
  const std::vector<Vec3d> moved = deformed(cube, session);
  for (const std::size_t patch : {0, 1}) {
    for (const std::uint32_t i : cube.patches[patch].points) EXPECT_EQ(moved[i], cube.points[i]) << i;
  }
  EXPECT_GT(greatest_motion(cube, moved), 0.1);
}

TEST(Walls, EveryMaskHoldsThem) {
  const Cube cube;
  const Session session =
      on_walls(session_of(R"({"patch": "left", "hold": true})",
                          {R"({"mask": {"points": [[1, 1, 1]], "width": 0.3}})", kPull, R"({"mask": null})", kTurn}),
               cube.patches, cube.points);
  const std::vector<Vec3d> moved = deformed(cube, session);
  for (const std::uint32_t i : cube.patches[0].points) EXPECT_EQ(moved[i], cube.points[i]) << i;
}

// Without a mask the images' sum has no component across the plane: exactly, also far from the origin.
TEST(Walls, NothingLeavesAPlaneThatSlides) {
  for (const Vec3d shift : {Vec3d{0, 0, 0}, Vec3d{0, 0, 0.3}}) {
    const Cube cube(shift);
    const Session session = on_walls(session_of(R"({"patch": "bottom", "slide": true})"), cube.patches, cube.points);
    Mesh mesh;
    mesh.positions = cube.points;
    const ReplayResult result = replay(mesh, session, {});
    const std::vector<Vec3d>& moved = result.shape.positions();
    double along = 0;
    for (const std::uint32_t i : cube.patches[2].points) {
      EXPECT_EQ(moved[i].z, shift.z) << i;
      along = std::max(along, norm(moved[i] - cube.points[i]));
    }
    EXPECT_GT(along, 0.05);
    EXPECT_LT(result.shape.put_back(), 1e-12);
  }
}

TEST(Walls, OneIsHeldAndOneSlides) {
  const Cube cube;
  const Session session =
      on_walls(session_of(R"({"patch": "left", "hold": true, "width": 0.2}, {"patch": "bottom", "slide": true})"),
               cube.patches, cube.points);
  const std::vector<Vec3d> moved = deformed(cube, session);
  for (const std::uint32_t i : cube.patches[0].points) EXPECT_EQ(moved[i], cube.points[i]) << i;
  for (const std::uint32_t i : cube.patches[2].points) EXPECT_EQ(moved[i].z, 0) << i;
  EXPECT_GT(greatest_motion(cube, moved), 0.1);
}

TEST(Walls, AMeshOfTwoDimensionsStaysFlat) {
  Cube cube;
  for (Vec3d& p : cube.points) p.z = 0.25;
  const Session session = on_walls(session_of(R"({"patch": "left", "hold": true})"), cube.patches, cube.points);
  const std::vector<Vec3d> moved = deformed(cube, session);
  for (const Vec3d& p : moved) EXPECT_EQ(p.z, 0.25);
  for (const std::uint32_t i : cube.patches[0].points) EXPECT_EQ(moved[i], cube.points[i]) << i;
  EXPECT_GT(greatest_motion(cube, moved), 0.05);
}

// A block of cells between six patches, each with faces; `map` takes the unit cube to its shape.
struct Block {
  std::uint32_t n;
  std::vector<Vec3d> points;
  std::vector<Patch> patches{{"left", {}}, {"right", {}}, {"front", {}}, {"back", {}}, {"bottom", {}}, {"top", {}}};
  Cells cells;

  Block(std::uint32_t size, const std::function<Vec3d(const Vec3d&)>& map) : n(size) {
    for (std::uint32_t i = 0; i < n * n * n; ++i) {
      const std::array<std::uint32_t, 3> at{i % n, i / n % n, i / (n * n)};
      points.push_back(map(Vec3d{1.0 * at[0], 1.0 * at[1], 1.0 * at[2]} / (n - 1.0)));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (at[axis] == 0) patches[2 * axis].points.push_back(i);
        if (at[axis] == n - 1) patches[2 * axis + 1].points.push_back(i);
        const std::array<std::uint32_t, 3> steps{1, n, n * n};
        const std::size_t u = (axis + 1) % 3;
        const std::size_t v = (axis + 2) % 3;
        const bool is_side = at[axis] == 0 || at[axis] == n - 1;
        if (!is_side || at[u] == n - 1 || at[v] == n - 1) continue;
        std::vector<Triangle>& faces = patches[2 * axis + (at[axis] == 0 ? 0 : 1)].faces;
        faces.push_back({i, i + steps[u], i + steps[u] + steps[v]});
        faces.push_back({i, i + steps[u] + steps[v], i + steps[v]});
      }
      if (at[0] == n - 1 || at[1] == n - 1 || at[2] == n - 1) continue;
      const std::uint32_t up = i + n * n;
      cells.add(CellKind::hexahedron, std::array{i, i + 1, i + 1 + n, i + n, up, up + 1, up + 1 + n, up + n});
    }
  }

  const std::vector<std::uint32_t>& points_of(const std::string& name) const {
    return std::find_if(patches.begin(), patches.end(), [&](const Patch& p) { return p.name == name; })->points;
  }
};

// A quarter of a pipe: its wall, "right", has the radius 1 about the z axis; "left" has 0.25.
Vec3d in_pipe(const Vec3d& p) {
  const double angle = 1.5707963267948966 * p.y;
  const double radius = 0.25 + 0.75 * p.x;
  return {radius * std::cos(angle), radius * std::sin(angle), 2 * p.z};
}

constexpr const char* kSlideInPipe =
    R"({"tool": "rotate", "center": [0.6, 0.6, 1], "axis": [0.2, 0.1, 1], "angle_deg": 12, "inner": 0.2, "outer": 0.9})";
constexpr const char* kPipeWalls =
    R"({"patch": "right", "slide": true}, {"patch": "front", "slide": true},
       {"patch": "back", "slide": true}, {"patch": "bottom", "slide": true}, {"patch": "top", "slide": true})";

struct Deformed {
  std::vector<Vec3d> points;
  double put_back = 0;
  std::size_t inverted = 0;
};

Deformed deformed(const Block& block, const std::string& walls, std::initializer_list<const char*> strokes,
                  int threads = 0) {
  std::string one_line = walls;
  std::erase(one_line, '\n');
  const Session session = on_walls(session_of(one_line, strokes), block.patches, block.points);
  Mesh mesh;
  mesh.positions = block.points;
  ReplayOptions options;
  options.motion.threads = threads;
  const ReplayResult result = replay(mesh, session, options);
  Deformed all{result.shape.positions(), result.shape.put_back()};
  all.inverted = compare_cells(block.cells, block.points, all.points).inverted;
  return all;
}

double greatest_along(const Block& block, const std::string& patch, const std::vector<Vec3d>& moved) {
  double greatest = 0;
  for (const std::uint32_t i : block.points_of(patch)) greatest = std::max(greatest, norm(moved[i] - block.points[i]));
  return greatest;
}

TEST(CurvedWalls, PointsSlideOnACylinderBetweenPlanes) {
  const Block block(11, in_pipe);
  const Deformed moved = deformed(block, kPipeWalls, {kSlideInPipe});
  for (const std::uint32_t i : block.points_of("right")) {
    EXPECT_NEAR(std::hypot(moved.points[i].x, moved.points[i].y), 1, 1e-12) << i;
  }
  for (const std::uint32_t i : block.points_of("front")) EXPECT_NEAR(moved.points[i].y, 0, 1e-15) << i;
  for (const std::uint32_t i : block.points_of("back")) EXPECT_NEAR(moved.points[i].x, 0, 1e-15) << i;
  for (const std::uint32_t i : block.points_of("bottom")) EXPECT_EQ(moved.points[i].z, 0) << i;
  // The plane that faces the bottom: not by mirroring.
  for (const std::uint32_t i : block.points_of("top")) EXPECT_NEAR(moved.points[i].z, 2, 1e-12) << i;
  EXPECT_GT(greatest_along(block, "right", moved.points), 0.03);
  EXPECT_GT(moved.put_back, 1e-4);
  EXPECT_EQ(moved.inverted, 0U);
}

// Layers of 1e-5 at the wall keep their heights, and stay across the wall, while the wall's points slide.
TEST(CurvedWalls, ThinLayersGoWithTheWall) {
  const double first = 1e-5;
  const Block block(12, [&](const Vec3d& p) {
    const double x = 1 - p.x;  // heights from the wall grow from 1e-5 on, about threefold a layer
    return in_pipe({x == 0 ? 1 : 1 - first / 0.75 * std::pow(3.0, 11 * x - 1) * 0.9, p.y, p.z});
  });
  const Deformed moved = deformed(block, kPipeWalls, {kSlideInPipe});
  EXPECT_EQ(moved.inverted, 0U);
  EXPECT_GT(greatest_along(block, "right", moved.points), 0.03);
  for (const std::uint32_t i : block.points_of("right")) {
    const double before = norm(block.points[i - 1] - block.points[i]);
    const Vec3d arm = moved.points[i - 1] - moved.points[i];
    EXPECT_NEAR(norm(arm), before, 0.02 * before) << i;
    const Vec3d& p = moved.points[i];
    const double cosine = -(arm.x * p.x + arm.y * p.y) / norm(arm);
    EXPECT_GT(cosine, std::cos(2 * 3.14159265 / 180)) << i;
  }
}

// The wall goes where the strokes take it; the layers beside it keep their heights, which shear and stretch
// change without.
TEST(CurvedWalls, LayersGoWithAWallThatMoves) {
  const Block block(12, [](const Vec3d& p) {
    return Vec3d{p.x, p.y, p.z == 0 ? 0 : 1e-5 * std::pow(2.85, 11 * p.z - 1)};
  });
  constexpr const char* push =
      R"({"tool": "implicit", "path": [[0.5, 0.5, 0], [0.58, 0.5, 0.06]], "inner": 0.1, "outer": 0.5})";
  const std::vector<Vec3d> flowed = deformed(block, R"({"patch": "top", "hold": true})", {push}).points;
  const Deformed moved =
      deformed(block, R"({"patch": "top", "hold": true}, {"patch": "bottom", "layers": true, "width": 0.2})", {push});
  double changed = 0;
  for (const std::uint32_t i : block.points_of("bottom")) {
    EXPECT_LT(norm(moved.points[i] - flowed[i]), 1e-6) << i;  // the flow goes in other parts
    const std::uint32_t above = i + block.n * block.n;
    EXPECT_NEAR(norm(moved.points[above] - moved.points[i]), 1e-5, 5e-7) << i;
    changed = std::max(changed, std::abs(norm(flowed[above] - flowed[i]) - 1e-5));
  }
  EXPECT_GT(changed, 1e-6);
  EXPECT_EQ(moved.inverted, 0U);
}

TEST(CurvedWalls, PointsSlideOnASphere) {
  const Block block(9, [](const Vec3d& p) {
    const Vec3d ray{2 * p.y - 1, 2 * p.z - 1, 1.5};
    return ray * ((1 + p.x) / norm(ray)) + Vec3d{3, 0, 0};
  });
  constexpr const char* turn =
      R"({"tool": "rotate", "center": [3, 0, 1], "axis": [0, 0.1, 1], "angle_deg": 15, "inner": 0.1, "outer": 0.7})";
  const Deformed moved = deformed(block, R"({"patch": "left", "slide": true})", {turn});
  for (const std::uint32_t i : block.points_of("left")) {
    EXPECT_NEAR(norm(moved.points[i] - Vec3d{3, 0, 0}), 1, 1e-12) << i;
  }
  EXPECT_GT(greatest_along(block, "left", moved.points), 0.03);
  EXPECT_EQ(moved.inverted, 0U);
}

// A wavy floor is neither plane nor round: its points stay on the faces as they were, those of its edges on these, and
// its corners where they are.
TEST(CurvedWalls, PointsSlideOnThePatchItself) {
  const auto floor = [](double x, double y) { return 0.1 * std::sin(4 * x) * std::cos(3 * y); };
  const Block block(13, [&](const Vec3d& p) { return Vec3d{p.x, p.y, p.z + (1 - p.z) * floor(p.x, p.y)}; });
  constexpr const char* stir =
      R"({"tool": "rotate", "center": [0.5, 0.4, 0.1], "axis": [0, 0.2, 1], "angle_deg": 15, "inner": 0.1, "outer": 0.7})";
  const Deformed moved = deformed(block, R"({"patch": "bottom", "slide": true})", {stir});
  const SurfaceTree surface(block.patches[4].faces, block.points);
  for (const std::uint32_t i : block.points_of("bottom")) {
    EXPECT_LT(surface.closest(moved.points[i])->distance, 1e-12) << i;
    const Vec3d& before = block.points[i];
    if (before.x == 0 || before.x == 1) {
      EXPECT_NEAR(moved.points[i].x, before.x, 1e-12) << i;
    }
    if (before.y == 0 || before.y == 1) {
      EXPECT_NEAR(moved.points[i].y, before.y, 1e-12) << i;
    }
  }
  EXPECT_EQ(moved.points[0], block.points[0]);
  EXPECT_GT(greatest_along(block, "bottom", moved.points), 0.02);
  EXPECT_EQ(moved.inverted, 0U);
}

TEST(CurvedWalls, PeriodicPatchesMoveAlikeToTheBit) {
  const Block block(9, [](const Vec3d& p) { return Vec3d{p.x + 0.1 * p.y, p.y, p.z}; });
  constexpr const char* pull =
      R"({"tool": "implicit", "path": [[0.1, 0.5, 0.5], [0.13, 0.54, 0.52]], "inner": 0.1, "outer": 0.5})";
  const Deformed moved = deformed(block, R"({"patch": "left", "periodic": "right"})", {pull, pull});
  const std::vector<std::uint32_t>& left = block.points_of("left");
  for (const std::uint32_t i : left) {
    EXPECT_EQ(moved.points[i + 8], moved.points[i] + (block.points[i + 8] - block.points[i])) << i;
  }
  EXPECT_GT(greatest_along(block, "left", moved.points), 0.02);
  EXPECT_EQ(moved.inverted, 0U);
}

TEST(CurvedWalls, ThreadsDoNotMatterAndWhatIsNotReachedKeepsItsBits) {
  const Block block(11, in_pipe);
  constexpr const char* local =
      R"({"tool": "implicit", "path": [[0.6, 0.6, 1], [0.65, 0.58, 1.05]], "inner": 0.05, "outer": 0.3})";
  const Deformed moved = deformed(block, kPipeWalls, {local}, 1);
  EXPECT_EQ(deformed(block, kPipeWalls, {local}, 3).points, moved.points);
  for (std::size_t i = 0; i < moved.points.size(); ++i) {
    // Those in planes are put into these exactly.
    if (std::abs(block.points[i].z - 1) > 0.5 && block.points[i].x > 1e-9) {
      EXPECT_EQ(moved.points[i], block.points[i]) << i;
    }
  }
}

TEST(CurvedWalls, FindingThemCountsAndCanBeCancelled) {
  const Block block(11, in_pipe);
  std::string walls = kPipeWalls;
  std::erase(walls, '\n');
  Progress progress;
  WallOptions options{2, &progress};
  on_walls(session_of(walls), block.patches, block.points, options);
  EXPECT_GT(progress.total, block.points.size());
  EXPECT_EQ(progress.done, progress.total);
  progress.cancel = true;
  EXPECT_THROW(on_walls(session_of(walls), block.patches, block.points, options), Cancelled);
}

TEST(CurvedWalls, AreNoFlow) {
  const Block block(5, in_pipe);
  const Session session = on_walls(session_of(R"({"patch": "right", "slide": true})"), block.patches, block.points);
  EXPECT_THROW(flow_of(session), InvalidInput);
  Mesh mesh;
  mesh.positions = block.points;
  ReplayOptions options;
  options.part.direction = Direction::backwards;
  EXPECT_THROW(replay(mesh, session, options), InvalidInput);
}

std::string refusal(const std::string& walls, std::initializer_list<const char*> strokes = {kPull}) {
  try {
    const Cube cube;
    on_walls(session_of(walls, strokes), cube.patches, cube.points);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Walls, WhatIsRefused) {
  EXPECT_NE(refusal(R"({"patch": "top", "hold": true})").find(R"(a.knead:1: no patch "top"; the mesh has "left", )"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "ball", "slide": true})").find(R"(the patch "ball" has no faces to slide on)"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "left", "periodic": "bottom"})").find("has no faces to be periodic by"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "left", "periodic": "left"})").find("another patch"), std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "left"})").find(R"(needs one of "hold": true, "slide": true, )"), std::string::npos);
  const Block bent(5, in_pipe);
  EXPECT_THROW(on_walls(session_of(R"({"patch": "left", "periodic": "right"})"), bent.patches, bent.points),
               InvalidInput);
  EXPECT_NE(refusal(R"({"patch": "left", "hold": true, "width": 0})").find("greater than 0"), std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "left", "hold": true})", {R"({"mask": {"vertices": [1], "width": 0.1}})"})
                .find("must be given by points"),
            std::string::npos);
  Mesh mesh;
  mesh.positions = Cube().points;
  EXPECT_THROW(replay(mesh, session_of(R"({"patch": "left", "hold": true})"), {}), InvalidInput);  // of no mesh
}

}  // namespace
}  // namespace knead::walls_test
