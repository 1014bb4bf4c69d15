// Reading and writing PLY.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

#include "io/ply/ply.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_text.h"

namespace knead::ply_test {
namespace {

const std::string kTextShape =
    "ply\n"
    "format ascii 1.0\n"
    "comment made by hand, see ../../elsewhere\n"
    "obj_info end_header is not here\n"
    "element camera 1\n"
    "property float fov\n"
    "element vertex 4\n"
    "property uchar red\n"
    "property uchar green\n"
    "property uchar blue\n"
    "property float x\n"
    "property list uchar short weights\n"
    "property float y\n"
    "property float z\n"
    "property float confidence\n"
    "element face 4\n"
    "property list uchar int vertex_index\n"
    "property int material\n"
    "end_header\n"
    "50.00\n"
    "1 2 3  0.100 2 7 8   0.0  0.00 .5\n"
    "4 5 6 1e0 0 0 0 .5\n"
    "7 8 9 0 1 -3 1.0 0 .5\r\n"
    "\n"
    "9 9 9 0 3 1 2 3 0 1 0.25 \n"
    "3 0 2 1 10\n"
    "3 0 1 3 11\n"
    "3 1 2 3 12\n"
    "3 0 3 2 13";

ShapeFile parse(const std::string& bytes) { return parse_shape(bytes, "ply", "shape.ply"); }

std::string error_of(const std::string& bytes) { return refusal(bytes, "ply", "shape.ply"); }

TEST(Ply, ReadsPropertiesInAnyOrder) {
  const ShapeFile shape = parse(kTextShape);
  EXPECT_EQ(shape.mesh.positions[0], (Vec3d{double{0.1f}, 0, 0}));
  EXPECT_EQ(shape.mesh.positions[2], (Vec3d{0, 1, 0}));
  EXPECT_TRUE(measure(shape.mesh).closed());
  ASSERT_NE(shape.mesh.find_attribute("color"), nullptr);
  EXPECT_EQ(shape.mesh.find_attribute("color")->type, NumberType::uint8);
  EXPECT_EQ(shape.mesh.find_attribute("color")->values[3], 4);
  EXPECT_EQ(shape.mesh.find_attribute("confidence")->values[3], 0.25);
  EXPECT_EQ(shape.mesh.find_attribute("material")->domain, Domain::face);
  EXPECT_EQ(shape.mesh.find_attribute("material")->values[3], 13);
}

TEST(Ply, OnlyTheNumbersThatChangeAreReplaced) {
  const ShapeFile shape = parse(kTextShape);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0].y = 0.2;
  positions[2].z = -1.5;
  positions[0].x += 1e-12;  // less than the float of 0.100 can tell
  const std::string expected =
      replaced(replaced(kTextShape, "   0.0  0.00", "   0.2  0.00"), "1.0 0 .5", "1.0 -1.5 .5");
  EXPECT_EQ(serialize_shape("ply", shape, positions), expected);
}

TEST(Ply, DoublesWhereAskedForAndOnlyIfSomethingMoved) {
  const ShapeFile shape = parse(kTextShape);
  const WriteOptions doubles{.double_coordinates = true};
  EXPECT_EQ(serialize_shape("ply", shape, shape.mesh.positions, doubles), kTextShape);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1].x = 1.0 / 3;
  const std::string bytes = serialize_shape("ply", shape, positions, doubles);
  EXPECT_NE(bytes.find("property double x\nproperty list uchar short weights\nproperty double y"), std::string::npos);
  EXPECT_NE(bytes.find("4 5 6 0.3333333333333333 0 0 0 .5\n7 8 9 0 1 -3 1.0 0 .5\r\n\n"), std::string::npos);
  EXPECT_EQ(parse(bytes).mesh.positions, positions);  // 0.100 as a float is not 0.100 as a double
}

TEST(Ply, IntegerCoordinatesBecomeDoublesWhenTheyMove) {
  std::string text = kTextShape;
  for (const std::string axis : {"x", "y", "z"}) text = replaced(text, "float " + axis, "int32 " + axis);
  text = replaced(text, "0.100", "5");
  text = replaced(text, "1e0", "1");
  const ShapeFile shape = parse(text);
  EXPECT_EQ(serialize_shape("ply", shape, shape.mesh.positions), text);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[3] += Vec3d{0.5, 0.25, 0.125};
  const std::string bytes = serialize_shape("ply", shape, positions);
  EXPECT_NE(bytes.find("property float64 x"), std::string::npos);
  EXPECT_EQ(parse(bytes).mesh.positions, positions);
}

// The text shape with a binary body of the given encoding, each element's numbers in their declared types.
std::string as_binary(detail::ply::Encoding encoding) {
  const bool swapped = detail::ply::is_swapped(encoding);
  const std::string format =
      encoding == detail::ply::Encoding::big_endian ? "binary_big_endian" : "binary_little_endian";
  std::string bytes = replaced(kTextShape.substr(0, kTextShape.find("50.00")), "ascii", format);
  using detail::StoredType;
  const auto put = [&](StoredType type, double value) { detail::append_binary(bytes, type, value, swapped); };
  put(StoredType::float32, 50);
  const std::array<std::array<double, 3>, 4> xyz{{{0.25, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    for (int c = 0; c < 3; ++c) put(StoredType::uint8, 10.0 + static_cast<double>(i));
    put(StoredType::float32, xyz[i][0]);
    put(StoredType::uint8, static_cast<double>(i));
    for (std::size_t k = 0; k < i; ++k) put(StoredType::int16, -5);
    put(StoredType::float32, xyz[i][1]);
    put(StoredType::float32, xyz[i][2]);
    put(StoredType::float32, 0.5);
  }
  const std::array<std::array<double, 3>, 4> faces{{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  for (const auto& face : faces) {
    put(StoredType::uint8, 3);
    for (const double v : face) put(StoredType::int32, v);
    put(StoredType::int32, 77);
  }
  return bytes;
}

TEST(Ply, BinaryOfEitherByteOrderWithListsBetweenTheCoordinates) {
  for (const detail::ply::Encoding encoding :
       {detail::ply::Encoding::little_endian, detail::ply::Encoding::big_endian}) {
    const std::string bytes = as_binary(encoding);
    const ShapeFile shape = parse(bytes);
    EXPECT_EQ(shape.mesh.positions[0], (Vec3d{0.25, 0, 0}));
    EXPECT_TRUE(measure(shape.mesh).closed());
    std::vector<Vec3d> positions = shape.mesh.positions;
    positions[3] = {0.125, 2, 1.0 / 3};
    const std::string narrow = serialize_shape("ply", shape, positions);
    ASSERT_EQ(narrow.size(), bytes.size());
    std::size_t changed = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) changed += bytes[i] != narrow[i] ? 1 : 0;
    EXPECT_LE(changed, 12u);
    EXPECT_EQ(parse(narrow).mesh.positions[3].z, double{1.0f / 3});
    const std::string wide = serialize_shape("ply", shape, positions, {.double_coordinates = true});
    EXPECT_EQ(wide.size(), bytes.size() + 3 + 4 * 3 * 4);  // float to double, three times in the header
    const ShapeFile back = parse(wide);
    EXPECT_EQ(back.mesh.positions, positions);
    EXPECT_EQ(back.mesh.attributes, shape.mesh.attributes);
    EXPECT_EQ(back.mesh.corner_vertex, shape.mesh.corner_vertex);
  }
}

TEST(Ply, LineEndsOfTheHeader) {
  const std::string binary = as_binary(detail::ply::Encoding::little_endian);
  const std::size_t body = binary.find("end_header\n") + 11;
  for (const std::string end : {"\r\n", "\r"}) {
    std::string header;
    for (const char c : binary.substr(0, body)) header += c == '\n' ? end : std::string(1, c);
    const ShapeFile shape = parse(header + binary.substr(body));
    EXPECT_EQ(shape.mesh.positions[0], (Vec3d{0.25, 0, 0}));
    std::vector<Vec3d> positions = shape.mesh.positions;
    positions[1].x = 3;
    EXPECT_EQ(parse(serialize_shape("ply", shape, positions)).mesh.positions, positions);
  }
}

const std::string kStrips =
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n"
    "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    "0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n2 1 0\n";

TEST(Ply, StripsOfTriangles) {
  const ShapeFile shape = parse(kStrips + "6 0 2 1 3 -1 2\n");
  EXPECT_EQ(shape.mesh.corner_vertex, (std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3}));
  // Stitched by repeated vertices: every other triangle stays turned, and those without area make no face.
  const ShapeFile stitched = parse(kStrips + "10 0 2 1 3 3 2 2 4 3 5\n");
  const Measures m = measure(stitched.mesh);
  EXPECT_EQ(m.faces, 4u);
  EXPECT_TRUE(m.oriented());
  EXPECT_EQ(m.area, 2);
}

const std::string kWithNormals =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n"
    "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n";

TEST(Ply, NormalsFollowTheShape) {
  const ShapeFile shape = parse(kWithNormals);
  const std::vector<Vec3d> over{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}};  // turned by a quarter about y
  const ShapeFile back = parse(serialize_shape("ply", shape, over));
  EXPECT_EQ(back.mesh.positions, over);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(back.mesh.find_attribute("normal")->values[3 * i], 1, 1e-6);
}

TEST(Ply, NormalsOfPointsAreGiven) {
  std::string text = kWithNormals.substr(0, kWithNormals.find("3 0 1 2"));
  text = replaced(text, "face 1", "face 0");
  const ShapeFile shape = parse(text);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0].z = 4;
  const std::string moved = replaced(text, "0 0 0 0 0 1", "0 0 4 0 0 1");
  EXPECT_EQ(serialize_shape("ply", shape, positions), moved);
  const std::vector<Vec3d> normals{{1, 0, 0}, {0, 0, 1}, {0, 0, 1}};
  WriteOptions options;
  options.normals = normals;
  EXPECT_EQ(serialize_shape("ply", shape, positions, options), replaced(moved, "0 0 4 0 0 1", "0 0 4 1 0 0"));
  options.normals = options.normals.first(2);
  EXPECT_THROW(serialize_shape("ply", shape, positions, options), InvalidInput);
}

// Two triangles of a roof that share an edge in space only; the normals along it are the same on both sides.
TEST(Ply, NormalsAlongASeamTurnTogether) {
  const ShapeFile shape = parse(
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\n"
      "property double nx\nproperty double ny\nproperty double nz\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 0 0 1\n0 1 0 0 0 1\n-1 0 0 0 0 1\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n3 3 4 5\n");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[2] = {-1, 0, -1};
  const ShapeFile back = parse(serialize_shape("ply", shape, positions));
  const std::vector<double>& normals = back.mesh.find_attribute("normal")->values;
  const auto normal = [&](std::size_t i) { return Vec3d{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]}; };
  EXPECT_EQ(normal(0), normal(3));
  EXPECT_EQ(normal(1), normal(5));
  EXPECT_EQ(normal(4), (Vec3d{0, 0, 1}));
  EXPECT_LT(normal(0).x, -0.1);               // turned, but not as far as
  EXPECT_GT(normal(0).x, normal(2).x + 0.1);  // the normal that belongs to the sloping face alone
}

TEST(Ply, ValuesThatAreNotFiniteAreNotedUnlessTheyAreCoordinates) {
  const ShapeFile shape = parse(replaced(kWithNormals, "0 0 0 0 0 1", "0 0 0 nan nan nan"));
  EXPECT_EQ(shape.mesh.find_attribute("normal")->values[0], 0);
  ASSERT_EQ(shape.notes.size(), 1u);
  EXPECT_EQ(error_of(replaced(kWithNormals, "0 0 0 0 0 1", "0 inf 0 0 0 1")),
            "shape.ply:13: a coordinate of vertex 0 is not finite, and a face uses the vertex; repair the file");
}

TEST(Ply, ErrorsNameTheLine) {
  EXPECT_NE(error_of(replaced(kTextShape, "4 5 6 1e0", "4 5 6 1x0")).find("shape.ply:22: '1x0'"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "4 5 6 1e0", "4 5 6 1e40")).find("shape.ply:22: '1e40'"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "3 0 1 3 11", "3 0 1 4 11")).find("shape.ply:27: vertex index 4"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "3 0 1 3 11", "3 0 1 2.5 11")).find("vertex index 2.5"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "3 0 1 3 11", "2 0 1 3 11 5")).find("shape.ply:27: more numbers"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(kWithNormals, "float z", "float w")).find("no property 'z'"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "float z", "real z")).find("shape.ply:14: number type 'real'"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "float z", "float y")).find("declared twice"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "vertex 4", "vertex -4")).find("not a whole number"), std::string::npos);
  const std::string points = replaced(kWithNormals.substr(0, kWithNormals.find("0 0 0")), "face 1", "face 0");
  EXPECT_NE(error_of(replaced(points, "vertex 3", "vertex 0")).find("no vertices"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "1.0", "2.0")).find("version"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "uchar int", "float int")).find("integer type"), std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "vertex_index", "corners")).find("vertex_indices"), std::string::npos);
}

TEST(Ply, NamesWithoutEndAreRefused) {
  std::string properties;
  std::string elements;
  for (int i = 0; i < 5000; ++i) {
    properties += fmt::format("property int p{}\n", i);
    elements += fmt::format("element e{} 0\n", i);
  }
  EXPECT_NE(error_of(replaced(kTextShape, "property float confidence\n", properties)).find("more than 4096 properties"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(kTextShape, "element face", elements + "element face")).find("more than 4096 elements"),
            std::string::npos);
}

TEST(Ply, BytesAfterTheLastElementAreKeptWithANote) {
  const ShapeFile shape = parse(kTextShape + "\nmore\n");
  EXPECT_EQ(shape.notes, std::vector<std::string>{"5 bytes follow the last element"});
}

TEST(Ply, PositionsThatAFloatCannotHoldAreRefused) {
  const ShapeFile shape = parse(kTextShape);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[2].x = 1e39;
  EXPECT_THROW(serialize_shape("ply", shape, positions), InvalidInput);
  EXPECT_EQ(parse(serialize_shape("ply", shape, positions, {.double_coordinates = true})).mesh.positions, positions);
  positions[2].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(serialize_shape("ply", shape, positions, {.double_coordinates = true}), InvalidInput);
  positions.pop_back();
  EXPECT_THROW(serialize_shape("ply", shape, positions), InvalidInput);
}

TEST(Ply, SplatsGetOtherSizesAndTurnsInPlace) {
  const auto splats = [](const std::string& turn) {
    return "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
           "property float scale_0\nproperty float " +
           turn + "\nend_header\n0 0 0 0.5 0.25\n1 0 0 0.75 1\n";
  };
  const ShapeFile shape = parse_shape(splats("rot_0"), "ply", "s.ply");
  const std::vector<Vec3d> moved{{0, 2, 0}, {1, 2, 0}};
  const ShapeFile written = parse_shape(serialize_shape("ply", shape, moved), "ply", "t.ply");
  EXPECT_EQ(written.mesh.positions, moved);
  for (const char* name : {"scale_0", "rot_0"}) {
    EXPECT_EQ(written.mesh.find_attribute(name)->values, shape.mesh.find_attribute(name)->values) << name;
  }
  const std::vector<Attribute> other{{"rot_0", Domain::vertex, NumberType::float32, 1, {0.125}}};
  const std::vector<std::uint32_t> second{1};
  const std::string bytes = serialize_shape("ply", shape, moved, {.attributes = other, .changed = second});
  std::string expected = splats("rot_0");
  expected.replace(expected.find("0 0 0 0.5 0.25"), std::string::npos, "0 2 0 0.5 0.25\n1 2 0 0.75 0.125\n");
  EXPECT_EQ(bytes, expected);
  const std::vector<Vec3d>& rest = shape.mesh.positions;  // where a splat turns and none moves
  expected.replace(expected.find("0 2 0"), std::string::npos, "0 0 0 0.5 0.25\n1 0 0 0.75 0.125\n");
  EXPECT_EQ(serialize_shape("ply", shape, rest, {.attributes = other, .changed = second}), expected);
  // In binary, where only these numbers change.
  Mesh mesh = shape.mesh;
  const ShapeFile binary = parse_shape(serialize_mesh("ply", mesh), "ply", "b.ply");
  mesh.positions = moved;
  mesh.attributes.back().values[1] = 0.125;
  EXPECT_EQ(serialize_shape("ply", binary, moved, {.attributes = other, .changed = second}),
            serialize_mesh("ply", mesh));
  const std::vector<Attribute> short_one{{"rot_0", Domain::vertex, NumberType::float32, 1, {}}};
  EXPECT_THROW(serialize_shape("ply", shape, moved, {.attributes = short_one, .changed = second}), InvalidInput);
}

}  // namespace
}  // namespace knead::ply_test
