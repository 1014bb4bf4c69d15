// Points in text.
#include <gtest/gtest.h>

#include "io/cloud/cloud.h"
#include "knead/error.h"
#include "knead/io.h"
#include "support/shape_text.h"

namespace knead::xyz_test {
namespace {

const std::string kPoints =
    "\xef\xbb\xbf# scanned\r\n"
    "3\n"
    "\n"
    "  0.100 0 0   0 0 1.00 # origin\n"
    "1,0.0,\t0,0,0.6,-0.8\r"
    "// between\n"
    "0;1e0;-2.50;1;0;0;";

ShapeFile parse(const std::string& bytes) { return parse_shape(bytes, "xyz", "points.xyz"); }

std::string error_of(const std::string& bytes) { return refusal(bytes, "xyz", "points.xyz"); }

TEST(Xyz, ReadsPointsBetweenBlanksCommasAndSemicolons) {
  const ShapeFile shape = parse(kPoints);
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0.1, 0, 0}, {1, 0, 0}, {0, 1, -2.5}}));
  EXPECT_EQ(shape.mesh.face_count(), 0u);
  ASSERT_EQ(shape.mesh.attributes.size(), 1u);
  EXPECT_EQ(shape.mesh.attributes[0].name, "normal");
  EXPECT_EQ(shape.mesh.attributes[0].values, (std::vector<double>{0, 0, 1, 0, 0.6, -0.8, 1, 0, 0}));
  EXPECT_EQ(text_of(shape.notes), "has no faces and is read as a point cloud\n");
}

TEST(Xyz, OnlyTheNumbersThatChangeAreReplaced) {
  const ShapeFile shape = parse(kPoints);
  EXPECT_EQ(serialize_shape("xyz", shape, shape.mesh.positions), kPoints);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0].y = 1.0 / 3;
  positions[1].z = -7;
  positions[2] = {5, 1, 1e-9};
  std::string expected = replaced(kPoints, "0.100 0 0 ", "0.100 0.3333333333333333 0 ");
  expected = replaced(expected, "0.0,\t0,0,0.6", "0.0,\t-7,0,0.6");
  expected = replaced(expected, "0;1e0;-2.50;1", "5;1e0;1e-09;1");
  EXPECT_EQ(serialize_shape("xyz", shape, positions), expected);
  EXPECT_EQ(parse(expected).mesh.positions, positions);
}

TEST(Xyz, NormalsAreReplacedWhereTheyDiffer) {
  const ShapeFile shape = parse(kPoints);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[2].x = 4;
  const std::vector<Vec3d> normals{{0, 0, -1}, {0, 0.6, -0.8}, {0, 0, 1}};
  std::string expected = replaced(kPoints, "0 0 1.00 #", "0 0 -1 #");
  expected = replaced(expected, "0;1e0;-2.50;1;0;0", "4;1e0;-2.50;0;0;1");
  EXPECT_EQ(serialize_shape("xyz", shape, positions, {.normals = normals}), expected);
}

TEST(Xyz, ColorsAndOtherColumns) {
  const ShapeFile colored = parse("0 0 0 255 0 7\n1 1 1 0 0 0");
  EXPECT_EQ(colored.mesh.attributes[0].name, "color");
  EXPECT_EQ(colored.mesh.attributes[0].type, NumberType::uint8);
  EXPECT_EQ(colored.mesh.attributes[0].values, (std::vector<double>{255, 0, 7, 0, 0, 0}));
  const ShapeFile columns = parse("0 0 0 256 0.5 7\n1 1 1 0 nan 0");
  ASSERT_EQ(columns.mesh.attributes.size(), 3u);
  EXPECT_EQ(columns.mesh.attributes[1].name, "column5");
  EXPECT_EQ(columns.mesh.attributes[1].values, (std::vector<double>{0.5, 0}));
  EXPECT_EQ(columns.notes[1], "1 attribute value is not finite and is read as 0");
  EXPECT_EQ(parse("0 0 0 9\n1 1 1 8").mesh.attributes[0].name, "column4");
}

TEST(Xyz, LinesWithDifferentlyManyNumbersHaveNoAttributes) {
  const ShapeFile shape = parse("0 0 0 1\n1 1 1\n2 2 2 3 4 5");
  EXPECT_TRUE(shape.mesh.attributes.empty());
  EXPECT_EQ(shape.mesh.vertex_count(), 3u);
  EXPECT_NE(text_of(shape.notes).find("kept but not read"), std::string::npos);
  EXPECT_EQ(text_of(conversion_losses("a.ply", shape)), "the numbers after x y z are left out\n");
  std::string wide = "0 0 0";
  for (int i = 0; i < 65; ++i) wide += " 1";
  EXPECT_TRUE(parse(wide).mesh.attributes.empty());
}

TEST(Xyz, ErrorsNameTheLine) {
  EXPECT_EQ(error_of("0 0 0\n1 2\n"), "points.xyz:2: expected a coordinate, found the end of the line or file");
  EXPECT_EQ(error_of("0 0 0\r1 x 2\n"), "points.xyz:2: expected a coordinate, found 'x'");
  EXPECT_NE(error_of("0 nan 0\n1 1 inf\n").find("no point has finite coordinates"), std::string::npos);
  EXPECT_EQ(error_of("x y 3\n1 1 1\n"), "points.xyz:1: expected a coordinate, found 'x'");
  EXPECT_EQ(error_of("x y z\nu v w\n1 1 1\n"), "points.xyz:2: expected a coordinate, found 'u'");
  EXPECT_EQ(error_of("#\n4\n0 0 0\n"),
            "points.xyz:2: 4 points are declared, but 1 follow; the file is cut short or damaged");
  EXPECT_EQ(
      error_of("1\n0 0 0\n1 0 0\n"),
      "points.xyz:1: 1 points are declared, but 2 follow; correct the number, or remove the lines that are too many");
  EXPECT_EQ(error_of("1\n0 0 0 5 1 2 3\n2\n0 0 0 5 1 2 3\n"),
            "points.xyz:3: a second scan begins here; put each scan into a file of its own");
  EXPECT_NE(text_of(parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").notes).find("let its name end in .obj"),
            std::string::npos);
  EXPECT_EQ(text_of(parse("V 0 0 0\nV 1 0 0\n").notes).find("OBJ"), std::string::npos);  // vanadium
  EXPECT_NE(error_of("2\n0 0 0\n4\n").find("points.xyz:3:"), std::string::npos);
  EXPECT_NE(error_of("0 0 0\n1,,2,3\n").find("points.xyz:2: expected a number between"), std::string::npos);
  EXPECT_NE(error_of(",1,2,3\n").find("points.xyz:1: expected a number between"), std::string::npos);
  EXPECT_NE(error_of("1,5;2,5;3,5\n").find("points.xyz:1: commas and semicolons"), std::string::npos);
  EXPECT_NE(error_of("# nothing\n").find("has no points"), std::string::npos);
  EXPECT_NE(error_of("0\n").find("has no points"), std::string::npos);
  EXPECT_NE(error_of("\xff\xfe\x31").find("UTF-16"), std::string::npos);
}

Mesh square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1, 0, 0}, {1, 1.0 / 3, 0}, {0, 1, 0}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2, 3});
  return mesh;
}

TEST(Xyz, NewFilesHoldPointsWithNormalsOrColors) {
  Mesh mesh = square();
  EXPECT_EQ(serialize_mesh("xyz", mesh), "0 0 0\n0.1 0 0\n1 0.3333333333333333 0\n0 1 0\n");
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::float32, 4, std::vector<double>(16, 0.5)});
  const ShapeFile colored = parse(serialize_mesh("xyz", mesh));
  EXPECT_EQ(colored.mesh.positions, mesh.positions);
  EXPECT_EQ(colored.mesh.find_attribute("color")->values, std::vector<double>(12, 128));
  EXPECT_EQ(text_of(detail::xyz_codec.losses(mesh)),
            "XYZ cannot hold faces\nXYZ cannot hold the alpha of colors\n"
            "XYZ holds colors as whole numbers from 0 to 255\n");
  mesh.attributes.push_back({"normal", Domain::corner, NumberType::float32, 3, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 0}});
  const ShapeFile with_normals = parse(serialize_mesh("xyz", mesh));
  EXPECT_EQ(with_normals.mesh.find_attribute("normal")->values, mesh.attributes[1].values);
  EXPECT_EQ(text_of(detail::xyz_codec.losses(mesh)), "XYZ cannot hold faces\nXYZ cannot hold 'color'\n");
}

}  // namespace
}  // namespace knead::xyz_test
