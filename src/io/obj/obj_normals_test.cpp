// Normals of OBJ files that move.
#include "io/obj/obj.h"

#include <gtest/gtest.h>

#include <cmath>

#include "io/mesh_builder.h"
#include "knead/io.h"
#include "support/test_meshes.h"

namespace knead::normals_test {
namespace {

ShapeFile parse(const std::string& text) { return parse_shape(text, "obj", "shape.obj"); }

std::string moved(const ShapeFile& shape, const std::vector<Vec3d>& positions) {
  return serialize_shape("obj", shape, positions);
}

// What the corners of the written file say differs from what they are to say by at most this, relative to the length.
double largest_difference(const ShapeFile& shape, const std::vector<Vec3d>& positions) {
  const std::vector<Vec3d> expected = detail::moved_normals(shape, positions, {});
  const ShapeFile back = parse(moved(shape, positions));
  const std::vector<double>& values = back.mesh.find_attribute("normal")->values;
  EXPECT_EQ(values.size(), 3 * expected.size());
  double largest = 0;
  for (std::size_t c = 0; c < expected.size(); ++c) {
    const Vec3d n{values[3 * c], values[3 * c + 1], values[3 * c + 2]};
    if (norm(expected[c]) > 0) largest = std::max(largest, norm(n - expected[c]) / norm(expected[c]));
  }
  return largest;
}

// A strip of quads along x that all use one line vn, the right half rolled up about y.
TEST(ObjNormals, CornersThatTurnApartGetLinesOfTheirOwn) {
  std::string text;
  for (int i = 0; i <= 20; ++i) text += "v " + std::to_string(i) + " 0 0\nv " + std::to_string(i) + " 1 0\n";
  text += "vn 0 0 1\n";
  for (int i = 0; i < 20; ++i) {
    const int a = 2 * i + 1;
    text += "f " + std::to_string(a) + "//1 " + std::to_string(a + 2) + "//1 " + std::to_string(a + 3) + "//1 " +
            std::to_string(a + 1) + "//1\n";
  }
  const ShapeFile shape = parse(text);
  std::vector<Vec3d> positions = shape.mesh.positions;
  for (Vec3d& p : positions) {
    if (p.x > 10) p = {10 + 5 * std::sin((p.x - 10) / 5), p.y, 5 - 5 * std::cos((p.x - 10) / 5)};
  }
  EXPECT_LT(largest_difference(shape, positions), 2e-4);
  const std::string bytes = moved(shape, positions);
  const std::string still = "f 17//1 19//1 20//1 18//1\n";  // the last face of which no vertex moved
  EXPECT_NE(bytes.find("vn 0 0 1\n"), std::string::npos);
  EXPECT_NE(bytes.find(still), std::string::npos);
  // The two ends of an edge of the cylinder turn alike, so each of its rings takes one new line.
  std::size_t lines = 0;
  for (std::size_t i = bytes.find("vn"); i != std::string::npos; i = bytes.find("vn", i + 1)) ++lines;
  EXPECT_LE(lines, 22u);
  EXPECT_GE(lines, 11u);
}

// Two objects, the second with normals of its own after the faces of the first, and relative numbers.
const std::string kTwoObjects =
    "o one\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 1 1 0\r\nvn 0 0 2 # shared\r\n"
    "f 1//1 2//1 3//1\r\nf 2//-1 4//1 3//-1 # second\r\n"
    "o two\r\nv 5 0 0\r\nv 6 0 0\r\nv 5 1 0\r\nvn 0 0 1\r\nvn 0 1 0\r\n"
    "f -3//2 -2//-2 -1//2\r\nf 5/ 6//3\r\n";

TEST(ObjNormals, LaterLinesAreRenumbered) {
  const ShapeFile shape = parse(kTwoObjects);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[3] = {1, 0, 1};  // the second triangle turns, and the normals of the edge with it
  EXPECT_LT(largest_difference(shape, positions), 1e-9);
  const std::string bytes = moved(shape, positions);
  EXPECT_NE(bytes.find("vn 0 0 2 # shared\r\nvn "), std::string::npos) << bytes;
  EXPECT_NE(bytes.find("\r\nf 1//1 2//2 3//3\r\nvn "), std::string::npos) << bytes;
  EXPECT_NE(bytes.find("# second\r\no two\r\nv 5 0 0\r\nv 6 0 0\r\nv 5 1 0\r\nvn 0 0 1\r\nvn 0 1 0\r\nf -3//"),
            std::string::npos)
      << bytes;
  const std::string::size_type dropped = bytes.find("f 5/ 6//");
  ASSERT_NE(dropped, std::string::npos);
  EXPECT_GT(std::stoi(bytes.substr(dropped + 8)), 3);  // still the last line, which now has a higher number
  EXPECT_EQ(parse(bytes).mesh.positions, positions);
}

TEST(ObjNormals, WhatTurnsTogetherKeepsItsFaces) {
  const ShapeFile shape = parse(kTwoObjects);
  std::vector<Vec3d> positions = shape.mesh.positions;
  for (std::size_t i = 0; i < 4; ++i) positions[i] = {positions[i].x, 0, positions[i].y};  // the whole first object
  std::string expected = kTwoObjects;
  for (const auto& [from, to] : {std::pair{"v 0 1 0", "v 0 0 1"}, {"v 1 1 0", "v 1 0 1"}, {"vn 0 0 2", "vn 0 -2 0"}}) {
    expected.replace(expected.find(from), std::string(from).size(), to);
  }
  EXPECT_EQ(moved(shape, positions), expected);
}

TEST(ObjNormals, FacesBeforeTheirNormalsKeepTheirNumbers) {
  const ShapeFile shape = parse("f 1//1 2//1 3//1\nf 2//1 4//1 3//1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\n");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[3] = {1, 0, 1};
  std::string expected = shape.bytes;
  expected.replace(expected.find("v 1 1 0"), 7, "v 1 0 1");
  EXPECT_EQ(moved(shape, positions), expected);  // the normal is that of the corner that did not turn
}

TEST(ObjNormals, OfRealFiles) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const char* file : {"originals/pirate_quads_normals_uv.obj", "originals/spider/spider.obj", "originals/fuze.obj",
                           "originals/negative_indices.obj"}) {
    const ShapeFile shape = read_shape(test_mesh(file));
    if (shape.mesh.find_attribute("normal") == nullptr) continue;
    std::vector<Vec3d> positions = shape.mesh.positions;
    const double size = norm(positions[0]) + 1;
    for (Vec3d& p : positions) {
      const double angle = p.x > 0 ? p.x / size : 0;
      p = {p.x, p.y * std::cos(angle) - p.z * std::sin(angle), p.y * std::sin(angle) + p.z * std::cos(angle)};
    }
    EXPECT_LT(largest_difference(shape, positions), 3e-4) << file;  // a cell is 1e-4 wide in each coordinate
  }
}

}  // namespace
}  // namespace knead::normals_test
