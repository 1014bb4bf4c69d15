// Reading and writing STL.
#include "io/stl/stl.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "io/codec.h"
#include "io/mesh_builder.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_text.h"
#include "support/test_meshes.h"

namespace knead::stl_test {
namespace {

using detail::stl::kFirstTriangle;
using detail::stl::kTriangleBytes;

const std::string kText =
    "solid two parts, #1\r\n"
    "  facet normal 0 0 1.00\n"
    "    outer loop\n"
    "      vertex 0.000 0 0\n"
    "      vertex 1 0 0\n"
    "      vertex 0 1 -0\n"
    "    endloop\n"
    "  endfacet\n"
    "endsolid two parts, #1\n"
    "\n"
    "SOLID Facet\n"
    "  FACET Normal 0 0 0 OUTER LOOP\n"
    "  Vertex 1.0 0 0\tVertex 0 1 0 Vertex 1e0 1 0.5 ENDLOOP ENDFACET\n"
    "EndSolid";

ShapeFile parse(const std::string& bytes) { return parse_shape(bytes, "stl", "shape.stl"); }

std::string error_of(const std::string& bytes) { return refusal(bytes, "stl", "shape.stl"); }

void put_float(std::string& bytes, std::size_t triangle, std::size_t number, float value) {
  std::memcpy(bytes.data() + kFirstTriangle + triangle * kTriangleBytes + 4 * number, &value, sizeof value);
}

float float_in(const std::string& bytes, std::size_t triangle, std::size_t number) {
  float value = 0;
  std::memcpy(&value, bytes.data() + kFirstTriangle + triangle * kTriangleBytes + 4 * number, sizeof value);
  return value;
}

Mesh square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2, 3});
  mesh.attributes.push_back({"attribute", Domain::face, NumberType::uint16, 1, {513}});
  return mesh;
}

TEST(Stl, TextOfSeveralSolidsInAnyLetterCase) {
  const ShapeFile shape = parse(kText);
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.5}}));
  EXPECT_EQ(shape.mesh.corner_vertex, (std::vector<std::uint32_t>{0, 1, 2, 1, 2, 3}));
  EXPECT_EQ(text_of(conversion_losses("a.ply", shape)), "the division into 2 solids is left out\n");
  EXPECT_EQ(text_of(shape.notes), "");
}

TEST(Stl, InTextOnlyWhatChangesIsReplaced) {
  const ShapeFile shape = parse(kText);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0] = {0, 0, -1};  // the first triangle alone; its normal becomes (-1, -1, 1) / sqrt(3)
  const std::string bytes = serialize_shape("stl", shape, positions);
  const std::size_t normal = bytes.find("normal") + 7;
  const std::size_t rest = bytes.find('\n', normal);
  EXPECT_EQ(bytes.substr(0, normal), kText.substr(0, normal));
  const std::size_t source_rest = kText.find('\n', normal);
  EXPECT_EQ(bytes.substr(rest), replaced(kText.substr(source_rest), "0.000 0 0", "0.000 0 -1"));
  detail::TextCursor words(bytes, "test", normal);
  for (const double sign : {-1.0, -1.0, 1.0}) {
    EXPECT_NEAR(words.real(words.next(), "a number"), sign / std::sqrt(3.0), 4e-16);  // two roundings of about 1
  }
  positions = shape.mesh.positions;
  positions[3].z = 0.25;  // the second triangle, whose normal is zero
  EXPECT_EQ(serialize_shape("stl", shape, positions), replaced(kText, "1e0 1 0.5", "1e0 1 0.25"));
}

TEST(Stl, EveryCornerOfAVertexMoves) {
  const ShapeFile shape = parse(kText);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] = {1, -1.0 / 3, 0};
  const std::string bytes = serialize_shape("stl", shape, positions);
  EXPECT_EQ(bytes, replaced(replaced(kText, "vertex 1 0 0", "vertex 1 -0.3333333333333333 0"), "Vertex 1.0 0 0",
                            "Vertex 1.0 -0.3333333333333333 0"));
  EXPECT_EQ(parse(bytes).mesh.positions, positions);
}

TEST(Stl, BinaryHeaderNormalsAndAttributes) {
  std::string bytes = serialize_mesh("stl", square());
  ASSERT_EQ(bytes.size(), kFirstTriangle + 2 * kTriangleBytes);
  EXPECT_EQ(bytes.substr(0, 6), std::string("Knead\0", 6));
  const ShapeFile made = parse(bytes);
  EXPECT_EQ(made.mesh.positions, square().positions);
  EXPECT_EQ(made.mesh.corner_vertex, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  ASSERT_EQ(made.mesh.attributes.size(), 1u);
  EXPECT_EQ(made.mesh.attributes[0], (Attribute{"attribute", Domain::face, NumberType::uint16, 1, {513, 513}}));
  bytes.replace(0, 6, "solid!");
  put_float(bytes, 0, 0, 0.25f);  // a normal that is none, kept where nothing moves
  const ShapeFile shape = parse(bytes + "tail");
  EXPECT_EQ(text_of(shape.notes), "4 bytes follow the last triangle\n");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[3] = {0, 1, 1.0 / 3};  // of the second triangle alone
  std::string expected = bytes + "tail";
  const Vec3d normal = normalized(cross(positions[2] - positions[0], positions[3] - positions[0]));
  for (std::size_t axis = 0; axis < 3; ++axis) put_float(expected, 1, axis, static_cast<float>(normal[axis]));
  put_float(expected, 1, 11, 1.0f / 3);
  const std::string written = serialize_shape("stl", shape, positions, {.double_coordinates = true});
  ASSERT_EQ(written.size(), expected.size());
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_FLOAT_EQ(float_in(written, 1, n), float_in(expected, 1, n));
    put_float(expected, 1, n, float_in(written, 1, n));
  }
  EXPECT_EQ(written, expected);
}

TEST(Stl, NormalsOfTrianglesWithoutAreaAreZero) {
  const std::string bytes = serialize_mesh("stl", square());
  const ShapeFile shape = parse(bytes);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[3] = positions[2] * 0.5;
  const std::string flat = serialize_shape("stl", shape, positions);
  for (std::size_t n = 0; n < 3; ++n) EXPECT_EQ(float_in(flat, 1, n), 0);
  const ShapeFile back = parse(flat);
  EXPECT_EQ(measure(back.mesh).degenerate_triangles, 1u);
  std::string zero = bytes;
  put_float(zero, 1, 2, 0);  // (0, 0, 1) becomes zero and stays it
  const ShapeFile without = parse(zero);
  positions[3] = {0, 2, 1};
  EXPECT_EQ(float_in(serialize_shape("stl", without, positions), 1, 2), 0);
}

TEST(Stl, NormalsStayOnTheirSide) {
  const std::string inward = replaced(kText, "normal 0 0 1.00", "normal 0 0 -1.00");
  for (const std::string& text : {kText, inward}) {
    const ShapeFile shape = parse(text);
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (Vec3d& p : positions) p = {p.z, p.y, -p.x};  // +z turns to +x
    const std::string expected = text == inward ? "normal -1 " : "normal 1 ";
    EXPECT_NE(serialize_shape("stl", shape, positions).find(expected), std::string::npos);
  }
}

TEST(Stl, TrianglesWithEqualCornersStay) {
  const std::string text = replaced(kText, "vertex 0 1 -0", "vertex 1 0 0");
  const ShapeFile shape = parse(text);
  EXPECT_EQ(shape.mesh.face_count(), 2u);
  EXPECT_EQ(text_of(shape.notes), "1 face repeats a vertex\n");
  std::vector<Vec3d> positions = shape.mesh.positions;
  for (Vec3d& p : positions) p.x += 1;
  EXPECT_EQ(parse(serialize_shape("stl", shape, positions)).mesh.positions, positions);
}

TEST(Stl, PositionsThatAFloatCannotHoldAreRefused) {
  Mesh mesh = square();
  const ShapeFile shape = parse(serialize_mesh("stl", mesh));
  mesh.positions[2].x = 1e39;
  EXPECT_THROW(serialize_mesh("stl", mesh), InvalidInput);
  EXPECT_THROW(serialize_shape("stl", shape, mesh.positions), InvalidInput);
  const ShapeFile text = parse(kText);
  EXPECT_EQ(parse(serialize_shape("stl", text, mesh.positions)).mesh.positions, mesh.positions);
  Mesh points;
  points.positions = {{0, 0, 0}};
  EXPECT_THROW(serialize_mesh("stl", points), InvalidInput);
}

TEST(Stl, SaysWhatIsLost) {
  Mesh mesh = square();
  EXPECT_EQ(text_of(detail::stl_codec.losses(mesh)), "1 polygon is cut into triangles\n");
  mesh.positions.push_back({0.1, 0, 0});
  mesh.attributes.push_back({"uv", Domain::vertex, NumberType::float32, 2, std::vector<double>(10, 0.5)});
  EXPECT_EQ(text_of(detail::stl_codec.losses(mesh)),
            "1 polygon is cut into triangles\n1 vertex in no face is left out\ncoordinates are rounded to floats\n"
            "STL cannot hold 'uv'\n");
}

TEST(Stl, ErrorsInTextNameTheLine) {
  EXPECT_EQ(error_of(replaced(kText, "vertex 1 0 0", "vertex 1 O 0")), "shape.stl:5: expected a coordinate, found 'O'");
  EXPECT_NE(error_of(replaced(kText, "1e0 1 0.5", "1e0 nan 0.5")).find("shape.stl:13: a coordinate is 'nan'"),
            std::string::npos);
  EXPECT_EQ(error_of(replaced(kText, "normal 0 0 1.00", "normal 0 0")), "shape.stl:3: expected 'outer', found 'loop'");
  EXPECT_EQ(error_of(replaced(kText, "    endloop\n", "vertex 0 0 9\n")),
            "shape.stl:7: expected 'endloop', found 'vertex'");
  EXPECT_EQ(error_of("solid a\n\n"),
            "shape.stl:3: the file ends where 'facet' or 'endsolid' is expected; it is cut short");
  EXPECT_EQ(error_of(kText.substr(0, kText.find("    endloop"))),
            "shape.stl:7: the file ends where 'endloop' is expected; it is cut short");
  EXPECT_EQ(error_of(kText + "\nmore"), "shape.stl:15: expected 'solid', found 'more'");
  EXPECT_NE(error_of("solid a\nendsolid a\n").find("has no triangles"), std::string::npos);
}

TEST(Stl, ErrorsInBinaryNameTheByte) {
  std::string bytes = serialize_mesh("stl", square());
  EXPECT_EQ(error_of(bytes.substr(0, 183)),
            "shape.stl: byte 80: 2 triangles are declared, which take 184 bytes, but the file has 183; it is cut short "
            "or damaged");
  put_float(bytes, 1, 7, std::numeric_limits<float>::infinity());
  EXPECT_EQ(error_of(bytes), "shape.stl: byte 158: a coordinate of triangle 1 is not finite; repair the file");
  EXPECT_NE(error_of(bytes.substr(0, 83)).find("is not STL"), std::string::npos);
  EXPECT_NE(error_of(std::string(84, '\0')).find("has no triangles"), std::string::npos);
}

TEST(Welder, FindsEveryPositionAgain) {
  std::vector<Vec3d> positions;
  detail::Welder welder(positions);
  std::mt19937_64 random(7);
  std::vector<Vec3d> given;
  for (int i = 0; i < 20000; ++i) {
    const auto coordinate = [&] { return static_cast<double>(random() % 40) / 8 - 2; };  // many are equal
    given.push_back({coordinate(), coordinate(), coordinate()});
  }
  std::vector<std::uint32_t> vertices;
  for (const Vec3d& p : given) vertices.push_back(welder.vertex_at(p));
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_EQ(positions[vertices[i]], given[i]);
    EXPECT_EQ(welder.vertex_at(given[i]), vertices[i]);
  }
  EXPECT_EQ(welder.vertex_at({-0.0, 0, 0}), welder.vertex_at({0, -0.0, 0}));
}

// The numbers that the source's corners have, in the file's order.
std::vector<Vec3d> at_corners(const Mesh& mesh, const std::vector<Vec3d>& positions) {
  std::vector<Vec3d> corners;
  for (const std::uint32_t v : mesh.corner_vertex) corners.push_back(positions[v]);
  return corners;
}

TEST(Stl, RealFilesChangeOnlyInWhatMoves) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const char* name :
       {"icosahedron_ascii", "icosahedron_binary", "spider_ascii", "spider_binary", "featuretype_binary"}) {
    const ShapeFile shape = read_shape(test_mesh(std::string("originals/") + name + ".stl"));
    const bool binary = detail::layout_of<detail::stl::Layout>(shape).binary;
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (std::size_t i = 0; i < positions.size(); i += 5) positions[i] += {0.1, 0, 0};
    const ShapeFile back = parse(serialize_shape("stl", shape, positions));
    for (Vec3d& p : positions) p = binary ? Vec3d(Vec3f(p)) : p;
    EXPECT_EQ(at_corners(back.mesh, back.mesh.positions), at_corners(shape.mesh, positions)) << name;
    // Back again, all but the normals of triangles that moved has the source's bits, if perhaps not its spelling.
    const ShapeFile again = parse(serialize_shape("stl", back, shape.mesh.positions));
    EXPECT_EQ(at_corners(again.mesh, again.mesh.positions), at_corners(shape.mesh, shape.mesh.positions)) << name;
  }
}

TEST(Stl, RecordsOfUnmovedTrianglesKeepTheirBytes) {
  KNEAD_NEEDS_TEST_MESH("originals");
  const ShapeFile shape = read_shape(test_mesh("originals/featuretype_binary.stl"));
  std::vector<Vec3d> positions = shape.mesh.positions;
  for (std::size_t i = 0; i < positions.size(); i += 50) positions[i] += {0, 0.1, 0};
  const std::string bytes = serialize_shape("stl", shape, positions);
  ASSERT_EQ(bytes.size(), shape.bytes.size());
  EXPECT_EQ(bytes.substr(0, kFirstTriangle), shape.bytes.substr(0, kFirstTriangle));
  std::size_t unmoved = 0;
  for (std::size_t t = 0; t < shape.mesh.face_count(); ++t) {
    bool moved = false;
    for (const std::uint32_t v : shape.mesh.face(t)) moved = moved || !(positions[v] == shape.mesh.positions[v]);
    const auto record = [&](const std::string& from) {
      return from.substr(kFirstTriangle + t * kTriangleBytes, kTriangleBytes);
    };
    EXPECT_EQ(record(bytes).substr(48), record(shape.bytes).substr(48));
    if (!moved) {
      EXPECT_EQ(record(bytes), record(shape.bytes));
      ++unmoved;
      continue;
    }
    const Vec3d n{float_in(bytes, t, 0), float_in(bytes, t, 1), float_in(bytes, t, 2)};
    EXPECT_NEAR(norm(n), 1, 1e-6) << t;  // three components rounded to floats
    EXPECT_GT(dot(n, polygon_normal(positions, shape.mesh.face(t))), 0) << t;
  }
  EXPECT_GT(unmoved, 2000u);
}

// A tetrahedron whose corners at 0 carry noise, each another one.
TEST(Stl, CornersThatDifferByRoundingAroundZeroAreOneVertex) {
  const double size[2] = {1, 1e-3};
  for (const double scale : size) {
    const Vec3d corner[4] = {{0, 0, 0}, {scale, 0, 0}, {0, scale, 0}, {0, 0, scale}};
    std::string text = "solid noise\n";
    double noise = 1e-17 * scale;
    for (const auto& t : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{1, 2, 3}, std::array{0, 3, 2}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int k : t) {
        text += "vertex";
        for (std::size_t axis = 0; axis < 3; ++axis) {
          noise *= -1.1;
          text += fmt::format(" {}", corner[k][axis] == 0 ? noise : corner[k][axis]);
        }
        text += "\n";
      }
      text += "endloop\nendfacet\n";
    }
    text += "endsolid noise\n";
    const ShapeFile shape = parse_shape(text, "stl", "noise.stl");
    EXPECT_EQ(shape.mesh.vertex_count(), 4u);
    EXPECT_TRUE(measure(shape.mesh).closed());
    ASSERT_FALSE(shape.notes.empty());
    EXPECT_NE(shape.notes.back().find("by rounding around 0"), std::string::npos);
    EXPECT_EQ(serialize_shape("stl", shape, shape.mesh.positions), text);
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (Vec3d& p : positions) p += Vec3d{scale, scale, scale};
    const ShapeFile moved = parse_shape(serialize_shape("stl", shape, positions), "stl", "moved.stl");
    EXPECT_EQ(moved.mesh.vertex_count(), 4u);
  }
}

}  // namespace
}  // namespace knead::stl_test
