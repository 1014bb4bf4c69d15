// Walls of a session: held patches keep their bits, and planes that slide are never left.
#include <gtest/gtest.h>

#include <algorithm>

#include "knead/error.h"
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
  std::vector<Vec3d> points = replay(mesh, session, {}).shape.positions();
  put_on_walls(session, points);
  return points;
}

double greatest_motion(const Cube& cube, const std::vector<Vec3d>& moved) {
  double greatest = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) greatest = std::max(greatest, norm(moved[i] - cube.points[i]));
  return greatest;
}

TEST(Walls, AreReadAndWritten) {
  const std::string line =
      R"({"knead": 1, "walls": [{"patch": "inlet", "hold": true, "width": 0.2}, {"patch": "symmetry", "slide": true}]})"
      "\n";
  const Session session = parse_session(line, "a");
  EXPECT_EQ(session.walls, (std::vector<Wall>{{"inlet", false, 0.2}, {"symmetry", true}}));
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
    std::vector<Vec3d> moved = replay(mesh, session, {}).shape.positions();
    double along = 0;
    for (const std::uint32_t i : cube.patches[2].points) {
      EXPECT_NEAR(moved[i].z, shift.z, 1e-12) << i;
      along = std::max(along, norm(moved[i] - cube.points[i]));
    }
    EXPECT_GT(along, 0.05);
    EXPECT_LT(put_on_walls(session, moved), 1e-12);
    for (const std::uint32_t i : cube.patches[2].points) EXPECT_EQ(moved[i].z, shift.z) << i;
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
  EXPECT_NE(refusal(R"({"patch": "ball", "slide": true})").find(R"(the patch "ball" is not plane: a point is )"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "left", "slide": true}, {"patch": "right", "slide": true})").find("walls that slide"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"patch": "left"})").find(R"("hold": true or "slide": true)"), std::string::npos);
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
