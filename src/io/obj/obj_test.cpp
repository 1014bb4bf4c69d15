// Reading and writing OBJ.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "io/codec.h"
#include "io/obj/obj.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_promises.h"
#include "support/shape_text.h"

namespace knead::obj_test {
namespace {

const std::string kTetrahedron =
    "\xef\xbb\xbf# made by hand \\\r\n"
    "mtllib ../x.mtl\n"
    "v  0.000 0 0 0.5 0.25 1 # origin\n"
    "v\t1 0.0 0 1 1 1\r\n"
    "v 0 \\\n"
    "   1. 0 0 0 0\n"
    "v 0 0 1 0 0 0\n"
    "vt 0 0\nvt 1 0 0\nvt 0 1\n"
    "vn 0 0 -1\n"
    "vn 0 -1.0 0\n"
    "o thing\ng a b\nusemtl red\ns 1\n"
    "f 1/1/1 3/2/1 2/3/1\n"
    "usemtl blue\n"
    "f -4/-3/-1 -3/-2/-1 \\\r\n"
    " -1/-1/-1\n"
    "f 2//1 3//1 4//2 # slanted\n"
    "f 1 4 3\n"
    "l 1 2\n"
    "cstype bezier";

ShapeFile parse(const std::string& bytes) { return parse_shape(bytes, "obj", "shape.obj"); }

std::string error_of(const std::string& bytes) { return refusal(bytes, "obj", "shape.obj"); }

TEST(Obj, ReadsEveryFormOfCorner) {
  const ShapeFile shape = parse(kTetrahedron);
  const Measures m = measure(shape.mesh);
  EXPECT_EQ(m.vertices, 4u);
  EXPECT_TRUE(m.closed() && m.oriented());
  EXPECT_DOUBLE_EQ(m.volume, 1.0 / 6);
  const Attribute* uv = shape.mesh.find_attribute("uv");
  ASSERT_NE(uv, nullptr);
  EXPECT_EQ(std::vector<double>(uv->values.begin(), uv->values.begin() + 12),
            (std::vector<double>{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}));
  const Attribute* normal = shape.mesh.find_attribute("normal");
  ASSERT_NE(normal, nullptr);
  EXPECT_EQ(normal->values[8 * 3 + 1], -1);
  EXPECT_EQ(shape.mesh.find_attribute("color")->values[1], 0.25);
  EXPECT_EQ(shape.notes,
            (std::vector<std::string>{"3 corners of faces have no normal", "6 corners of faces have no uv"}));
}

// Without lines vn and without the third numbers of corners, which change too.
std::string without_normals(const std::string& text) {
  return std::regex_replace(std::regex_replace(text, std::regex("vn [^\n]*\n"), ""),
                            std::regex("([0-9]/-?[0-9]*)/-?[0-9]+"), "$1");
}

TEST(Obj, OnlyTheNumbersThatChangeAreReplaced) {
  const ShapeFile shape = parse(kTetrahedron);
  EXPECT_EQ(serialize_shape("obj", shape, shape.mesh.positions), kTetrahedron);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0].z = -0.1;
  positions[2].y = 2.5;
  positions[2].z = 1e-9;
  const std::string bytes = serialize_shape("obj", shape, positions);
  std::string expected = replaced(kTetrahedron, "v  0.000 0 0 0.5", "v  0.000 0 -0.1 0.5");
  expected = replaced(expected, "   1. 0 0 0 0\n", "   2.5 1e-09 0 0 0\n");
  EXPECT_EQ(without_normals(bytes), without_normals(expected));
  EXPECT_EQ(parse(bytes).mesh.positions, positions);
}

TEST(Obj, NormalsFollowTheFacesThatUseThem) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\n"
      "vn 0 0 1.00\nvn 0.0 0 1\nvn 1 0 0\n"
      "f 1//1 2//1 3//1\nf 4//2 5//2 6//2\n";
  const ShapeFile shape = parse(text);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] = {0, 0, -1};  // the first triangle by a quarter about y
  const std::string bytes = serialize_shape("obj", shape, positions);
  EXPECT_EQ(bytes, replaced(replaced(text, "v 1 0 0", "v 0 0 -1"), "vn 0 0 1.00", "vn 1 0 0"));
}

TEST(Obj, WeightsAndColors) {
  EXPECT_EQ(parse("v 1 2 3 0.5\n").notes[0], "1 vertex has a weight, which is kept but not applied");
  const ShapeFile mixed = parse("v 0 0 0\nv 1 0 0 0 0 0\nv 2 0 0");
  EXPECT_EQ(mixed.mesh.find_attribute("color")->values, (std::vector<double>{1, 1, 1, 0, 0, 0, 1, 1, 1}));
  EXPECT_EQ(parse("v 0 0 0 0.1 0.2 0.3 1").mesh.find_attribute("color")->values.size(), 3u);
}

TEST(Obj, SevenNumbersAreAWeightAndAColorOrAColorAndItsAlpha) {
  const auto color = [](const std::string& text) { return parse(text).mesh.find_attribute("color")->values; };
  EXPECT_EQ(color("v 0 0 0 1 1 0 0\nv 1 0 0 1 0 1 0.5\n"), (std::vector<double>{1, 0, 0, 0, 1, 0.5}));
  EXPECT_EQ(color("v 0 0 0 1 1 0 1\nv 1 0 0 1 0 1 1\n"), (std::vector<double>{1, 1, 0, 1, 0, 1}));
  EXPECT_EQ(color("v 0 0 0 0.5 1 0 0\nv 1 0 0 1 0 1 0\n"), (std::vector<double>{0.5, 1, 0, 1, 0, 1}));
  EXPECT_EQ(parse("v 0 0 0 1 1 0 0\n").notes[0], "vertices have seven numbers, which are read as x y z w r g b");
  EXPECT_EQ(parse("v 0 0 0 5 6\n").notes[0], "1 vertex has two numbers after x y z, which are kept but not read");
}

TEST(Obj, ErrorsNameTheLine) {
  EXPECT_EQ(error_of("v 0 0 0\ncall other.obj\n"),
            "shape.obj:2: the lines of another file belong here (call); put them in its place");
  EXPECT_EQ(error_of("v 0 0 0\nv 1 nan 0\nf 1 2 1\n"),
            "shape.obj:2: a coordinate is not finite, and a face uses the vertex; repair the file");
  EXPECT_EQ(error_of("v 0 0 0\nv 1 0\n"), "shape.obj:2: a number is missing; expected 'v x y z'");
  EXPECT_EQ(error_of("v 0 0 0\r\rv 1 0 a\n"), "shape.obj:3: 'a' is not a number");
  EXPECT_NE(error_of("v 0 0 0\nf 1 1 2\n").find("shape.obj:2: index 2"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 0\nf 1 1 -2\n").find("shape.obj:2: index -2"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 0\nvt 0 0\nf 1/1 1/1 1/2\n").find("shape.obj:3: index 2 of a texture"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 0\nf 1 1 1/1/1/1\n").find("is no corner"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 0\nf 1 1 x\n").find("is no corner"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 0\nf 1 1 99999999999999999999\n").find("out of range"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 0\nf 1 1 4294967296\n").find("out of range"), std::string::npos);
  EXPECT_NE(error_of(std::string("v 0 0 0\n\0\n", 10)).find("shape.obj:2: a zero byte"), std::string::npos);
}

TEST(Obj, FacesMayStandBeforeTheirVertices) {
  EXPECT_EQ(measure(parse("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0").mesh).area, 0.5);
}

// The statements that are written are those that were read, whatever lines are joined to whatever others.
TEST(Obj, LinesJoinedToOthers) {
  const std::string rest = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nf 1 2 3\nf 2/1/1 4/1/1 3/1/1\n";
  const std::vector<std::string> lines = {"v 9 9 9",  "vt 0 1",  "vn 1 0 0",     "f 1 2 3", "f 1",
                                          "l 1 2",    "g left",  "mtllib a.mtl", "more",    "0.5",
                                          "# remark", "f 1 2 #", "v 9 9 9 1"};
  std::size_t read = 0;
  for (std::size_t i = 0; i < lines.size() * lines.size() * lines.size(); ++i) {
    const std::string& first = lines[i % lines.size()];
    const std::string& second = lines[i / lines.size() % lines.size()];
    const std::string& third = lines[i / lines.size() / lines.size()];
    for (const char* end : {"\\\n", " \\\r\n"}) {
      const std::string text = first + end + second + end + third + '\n' + rest;
      SCOPED_TRACE(text);
      try {
        const ShapeFile shape = parse_shape(text, "obj", "a.obj");
        ++read;
        EXPECT_EQ(broken_promise(shape), "");
      } catch (const InvalidInput&) {
        continue;  // most lines that are joined to numbers are none
      }
    }
  }
  EXPECT_GT(read, 1000u);
}

TEST(Obj, MaterialFilesOnJoinedLines) {
  const std::string rest = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const ShapeFile shape = parse_shape("mtllib a.mtl \\\n b.mtl\n" + rest, "obj", "a.obj");
  const std::vector<std::string>& files = detail::layout_of<detail::obj::Layout>(shape).material_files;
  EXPECT_NE(std::find(files.begin(), files.end(), "b.mtl"), files.end());
}

}  // namespace
}  // namespace knead::obj_test
