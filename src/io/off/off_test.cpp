// Reading and writing OFF.
#include <gtest/gtest.h>

#include <array>

#include "io/codec.h"
#include "io/numbers.h"
#include "io/off/off.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/shape_text.h"
#include "support/test_meshes.h"

namespace knead::off_test {
namespace {

const std::string kTetrahedron =
    "\xef\xbb\xbf# made by hand\r\n"
    "OFF # four faces\n"
    "4 4 6 # and six edges\n"
    "\n"
    "  0.000 0 0\r\n"
    "1 0.0 0 # x\r"
    "\t0 1e0 -0\n"
    "0 0 1.0\n"
    "# faces\n"
    "3 0 2 1\n"
    "3  0 1 3\n"
    "3 0 3 2 \n"
    "3 1 2 3\n";

ShapeFile parse(const std::string& bytes) { return parse_shape(bytes, "off", "shape.off"); }

std::string error_of(const std::string& bytes) { return refusal(bytes, "off", "shape.off"); }

TEST(Off, ReadsCommentsBlanksAndEveryLineEnd) {
  const ShapeFile shape = parse(kTetrahedron);
  const Measures m = measure(shape.mesh);
  EXPECT_TRUE(m.closed() && m.oriented());
  EXPECT_DOUBLE_EQ(m.volume, 1.0 / 6);
  EXPECT_TRUE(shape.mesh.attributes.empty());
  EXPECT_EQ(text_of(shape.notes), "");
}

TEST(Off, TheKeywordAndTheCountsInEveryPlace) {
  const std::string rest = kTetrahedron.substr(kTetrahedron.find("\n\n") + 1);
  const Mesh mesh = parse(kTetrahedron).mesh;
  for (const char* begin : {"OFF 4 4 6\n", "OFF\n4 4\n", "OFF4 4 6\n", "4 4 -1\n", "#\n\nOFF\n#\n4 4 0 # n\n",
                            "nOFF\n3\n4 4 6\n", "nOFF 3\n4 4 6", "nOFF 3 4 4\n"}) {
    const std::string bytes = begin + rest;
    const ShapeFile shape = parse(bytes);
    EXPECT_EQ(shape.mesh.positions, mesh.positions) << begin;
    EXPECT_EQ(shape.mesh.corner_vertex, mesh.corner_vertex) << begin;
    std::vector<Vec3d> positions = mesh.positions;
    positions[2].y = 7;
    EXPECT_EQ(serialize_shape("off", shape, positions), replaced(bytes, "1e0", "7")) << begin;
  }
}

TEST(Off, OnlyTheNumbersThatChangeAreReplaced) {
  const ShapeFile shape = parse(kTetrahedron + "more of it");
  EXPECT_EQ(text_of(shape.notes), "10 bytes follow the last face\n");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0].y = 1.0 / 3;
  positions[2] = {0, 2, 1e-9};
  std::string expected = replaced(kTetrahedron, "0.000 0 0", "0.000 0.3333333333333333 0");
  expected = replaced(expected, "1e0 -0", "2 1e-09");
  EXPECT_EQ(serialize_shape("off", shape, positions), expected + "more of it");
  EXPECT_EQ(parse(expected).mesh.positions, positions);
}

const std::string kEveryField =
    "STCNOFF\n3 2 0\n"
    "0 0 0  0 0 1.00  255 0 0 255  0 0.5\n"
    "1 0 0  0 0 1  0 255 0 255  1 nan\n"
    "0 1 0  0.0 0 1  0 0 255 128  0 1\n"
    "3 0 1 2  0.5 0 0\n"
    "3 2 1 0  1 0 0\n";

TEST(Off, NormalsColorsAndTextureCoordinates) {
  const ShapeFile shape = parse(kEveryField);
  ASSERT_EQ(shape.mesh.attributes.size(), 4u);
  const std::vector<Attribute>& attributes = shape.mesh.attributes;
  EXPECT_EQ(attributes[0], (Attribute{"normal", Domain::vertex, NumberType::float32, 3, {0, 0, 1, 0, 0, 1, 0, 0, 1}}));
  EXPECT_EQ(attributes[1], (Attribute{"uv", Domain::vertex, NumberType::float32, 2, {0, 0.5, 1, 0, 0, 1}}));
  EXPECT_EQ(
      attributes[2],
      (Attribute{"color", Domain::vertex, NumberType::uint8, 4, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 128}}));
  EXPECT_EQ(attributes[3], (Attribute{"color", Domain::face, NumberType::float32, 3, {0.5, 0, 0, 1, 0, 0}}));
  EXPECT_EQ(text_of(shape.notes), "1 attribute value is not finite and is read as 0\n");
}

TEST(Off, NormalsFollowTheShape) {
  const std::string text = replaced(kEveryField, "3 2 1 0  1 0 0\n", "");
  const ShapeFile shape = parse(replaced(text, "3 2 0", "3 1 0"));
  const std::vector<Vec3d> over{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}};  // turned by a quarter about y
  const std::string bytes = serialize_shape("off", shape, over);
  std::string expected = replaced(shape.bytes, "0 0 0  0 0 1.00", "0 0 0  1 0 0");
  expected = replaced(expected, "1 0 0  0 0 1 ", "0 0 -1  1 0 0 ");
  expected = replaced(expected, "0 1 0  0.0 0 1", "0 1 0  1 0 0");
  EXPECT_EQ(bytes, expected);
}

// MeshLab writes the color before the normal, whatever the keyword's letters.
TEST(Off, ColorsMayStandBeforeNormals) {
  const auto file = [](const std::string& keyword, std::array<std::string, 3> colors, bool first) {
    const std::array<std::string, 3> normals{"0 0 1", "0.6 0 0.8", "0 -1 0"};
    std::string text = keyword + "\n3 1 0\n";
    for (std::size_t i = 0; i < 3; ++i) {
      text += std::array{"0 0 0 ", "1 0 0 ", "0 1 0 "}[i];
      text += first ? colors[i] + " " + normals[i] : normals[i] + " " + colors[i];
      text += keyword.starts_with("ST") ? " 0.5 1\n" : "\n";
    }
    return text + "3 0 1 2\n";
  };
  const std::vector<Vec3d> over{{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}};  // turned by a quarter about z
  for (const std::array<std::string, 3>& colors :
       std::vector<std::array<std::string, 3>>{{"255 0 0 255", "0 255 0 255", "9 8 7 255"},
                                               {"1.0 0.0 0.0 1.0", "0 1 0 1", "0.25 0.5 0.75 1"},
                                               {"200 0 0", "0 1 0", "3 4 5"},
                                               {"1 0 0 1", "0 1 0 1", "0 0 1 1"}}) {
    for (const std::string keyword : {"NCOFF", "CNOFF", "STNCOFF"}) {
      for (const bool first : {true, false}) {
        const ShapeFile shape = parse(file(keyword, colors, first));
        EXPECT_EQ(shape.mesh.find_attribute("normal")->values, (std::vector<double>{0, 0, 1, 0.6, 0, 0.8, 0, -1, 0}))
            << shape.bytes;
        const bool are_reals = colors[2] == "0.25 0.5 0.75 1" || colors[2] == "0 0 1 1";
        EXPECT_EQ(shape.mesh.find_attribute("color")->type, are_reals ? NumberType::float32 : NumberType::uint8);
        std::string turned = replaced(file(keyword, colors, first), "1 0 0 " + (first ? colors[1] + " " : "") + "0.6 0",
                                      "0 1 0 " + (first ? colors[1] + " " : "") + "0 0.6");
        turned = replaced(turned, "0 1 0 " + (first ? colors[2] + " " : "") + "0 -1",
                          "-1 0 0 " + (first ? colors[2] + " " : "") + "1 0");
        const ShapeFile moved = parse(serialize_shape("off", shape, over));
        EXPECT_EQ(moved.mesh.find_attribute("color")->values, shape.mesh.find_attribute("color")->values);
        for (std::size_t i = 0; i < 9; ++i) {
          EXPECT_NEAR(moved.mesh.find_attribute("normal")->values[i],
                      parse(turned).mesh.find_attribute("normal")->values[i], 1e-12);
        }
        const ShapeFile anew = parse(serialize_remeshed("off", shape, moved.mesh, std::vector<std::uint32_t>{0}));
        EXPECT_EQ(anew.mesh.attributes, moved.mesh.attributes);
      }
    }
  }
}

TEST(Off, ColorsWithoutAKeyword) {
  const ShapeFile floats = parse("OFF\n3 1 0\n0 0 0 1 0 0.5\n1 0 0 1 0 1\n0 1 0 0 0 0\n3 0 1 2 7\n");
  EXPECT_EQ(floats.mesh.attributes[0],
            (Attribute{"color", Domain::vertex, NumberType::float32, 3, {1, 0, 0.5, 1, 0, 1, 0, 0, 0}}));
  EXPECT_EQ(floats.mesh.attributes[1], (Attribute{"color_index", Domain::face, NumberType::int32, 1, {7}}));
  const ShapeFile others = parse("OFF\n3 2 0\n0 0 0 1\n1 0 0 1\n0 1 0 0\n3 0 1 2 7\n3 0 1 2 7 8 9\n");
  EXPECT_TRUE(others.mesh.attributes.empty());
  EXPECT_EQ(others.notes.size(), 2u);
  EXPECT_EQ(text_of(conversion_losses("a.ply", others)), "numbers that are not colors of one kind are left out\n");
  const ShapeFile beyond = parse("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 256 0 0\n");
  EXPECT_TRUE(beyond.mesh.attributes.empty());
}

TEST(Off, FacesOfFewerThanThreeVerticesAreLeftOutButKept) {
  const std::string text = "OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1 9 9 9\n3 0 1 2 1 2 3\n0\n1 1 5\n";
  const ShapeFile shape = parse(text);
  EXPECT_EQ(shape.mesh.face_count(), 1u);
  EXPECT_EQ(shape.mesh.find_attribute("color")->values, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(text_of(shape.notes), "3 faces have fewer than three vertices and are left out\n");
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1].x = 3;
  EXPECT_EQ(serialize_shape("off", shape, positions), replaced(text, "1 0 0", "3 0 0"));
}

TEST(Off, ErrorsNameTheLine) {
  EXPECT_EQ(error_of("solid a\n"),
            "shape.off:1: expected the keyword OFF, or the counts of vertices and faces, found 'solid'");
  EXPECT_NE(error_of("").find("found the end of the file"), std::string::npos);
  EXPECT_NE(error_of("4OFF\n1 0 0\n0 0 0 0\n").find("shape.off:1: 4OFF has four coordinates"), std::string::npos);
  EXPECT_NE(error_of("XOFF\n1 0 0\n").find("shape.off:1: expected a keyword"), std::string::npos);
  EXPECT_NE(error_of("nOFF\n5\n1 0 0\n").find("shape.off:2: 5 dimensions"), std::string::npos);
  EXPECT_EQ(error_of("OFF\n4\n4 0\n"), "shape.off:2: expected the count of faces, found the end of the line or file");
  EXPECT_NE(error_of("OFF\n0 0 0\n").find("shape.off:2: 0 vertices"), std::string::npos);
  EXPECT_NE(error_of("OFF\n-1 0 0\n").find("shape.off:2: expected the count of vertices, found '-1'"),
            std::string::npos);
  EXPECT_EQ(error_of(replaced(kTetrahedron, "1e0 -0", "1e0 -O")), "shape.off:7: expected a coordinate, found '-O'");
  EXPECT_NE(error_of(replaced(kTetrahedron, "1e0 -0", "inf -0")).find("shape.off:7: a coordinate is 'inf'"),
            std::string::npos);
  EXPECT_EQ(error_of(replaced(kTetrahedron, "1e0 -0", "1e0")),
            "shape.off:7: expected 3 numbers as for the first vertex, found 2");
  EXPECT_EQ(error_of(replaced(kTetrahedron, "3  0 1 3", "3  0 1 4")),
            "shape.off:11: a vertex index is '4', more than 3");
  EXPECT_EQ(error_of(replaced(kTetrahedron, "3 0 3 2 ", "3 0 3")),
            "shape.off:12: expected a vertex index, found the end of the line or file");
  EXPECT_NE(error_of(replaced(kTetrahedron, "3 1 2 3\n", "")).find("the file ends after 3 of 4 faces"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(kEveryField, "0 0 1.00", "")).find("shape.off:3: expected 11 or 12 numbers"),
            std::string::npos);
  EXPECT_NE(error_of("COFF\n1 0 0\n0 0 0\n").find("expected 6 or 7 numbers"), std::string::npos);
  EXPECT_NE(error_of("OFF\n99999999999999999999 0 0\n0 0 0\n").find("the count of vertices is '9999"),
            std::string::npos);
  EXPECT_NE(error_of("OFF\n1000 0 0\n0 0 0\n").find("1000 vertices are declared, but only"), std::string::npos);
  EXPECT_NE(error_of("OFF\n1 1000 0\n0 0 0\n").find("1000 faces are declared, but only"), std::string::npos);
}

// Appends 32 bits in the byte order.
template <class T>
void put(std::string& bytes, T value, std::endian order) {
  static_assert(sizeof(T) == 4);
  const T stored = order == std::endian::native ? value : detail::swap_bytes(value);
  bytes.append(reinterpret_cast<const char*>(&stored), sizeof stored);
}

struct BinaryForm {
  std::endian order;
  bool color_counts;

  std::string name() const {
    return std::string(order == std::endian::big ? "big" : "little") + (color_counts ? "_with_colour_counts" : "");
  }
  friend std::ostream& operator<<(std::ostream& out, const BinaryForm& form) { return out << form.name(); }
};

// A tetrahedron with a normal at each vertex.
std::string binary(const BinaryForm& form) {
  std::string bytes = "NOFF BINARY\n";
  for (const std::int32_t count : {4, 4, 0}) put(bytes, count, form.order);
  for (const std::array<float, 3>& p : {std::array{0.0f, 0.0f, 0.0f}, std::array{1.0f, 0.0f, 0.0f},
                                        std::array{0.0f, 1.0f, 0.0f}, std::array{0.0f, 0.0f, 1.0f}}) {
    for (const float number : {p[0], p[1], p[2], 0.0f, 0.0f, 1.0f}) put(bytes, number, form.order);
  }
  const std::int32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (const auto& face : faces) {
    put(bytes, 3, form.order);
    for (const std::int32_t v : face) put(bytes, v, form.order);
    if (!form.color_counts) continue;
    put(bytes, 3, form.order);
    for (const float number : {0.5f, 0.25f, 1.0f}) put(bytes, number, form.order);
  }
  return bytes;
}

class OffBinary : public testing::TestWithParam<BinaryForm> {};

TEST_P(OffBinary, IsReadAndWrittenInItsOwnForm) {
  const std::string bytes = binary(GetParam());
  const ShapeFile shape = parse(bytes);
  EXPECT_DOUBLE_EQ(measure(shape.mesh).volume, 1.0 / 6);
  EXPECT_TRUE(measure(shape.mesh).closed());
  EXPECT_EQ(text_of(shape.notes), "");
  const Attribute* color = shape.mesh.find_attribute("color");
  ASSERT_EQ(color != nullptr, GetParam().color_counts);
  if (color != nullptr) {
    EXPECT_EQ(color->values[1], 0.25);
  }
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1] = {1.0 / 3, 0, -2};
  const std::string moved = serialize_shape("off", shape, positions, {.double_coordinates = true});
  ASSERT_EQ(moved.size(), bytes.size());
  const ShapeFile back = parse(moved);
  EXPECT_EQ(back.mesh.positions[1], (Vec3d{double{1.0f / 3}, 0, -2}));
  EXPECT_EQ(back.mesh.positions[3], positions[3]);
  EXPECT_EQ(back.mesh.corner_vertex, shape.mesh.corner_vertex);
  const std::size_t faces = 12 + 3 * 4 + 4 * 6 * 4;
  EXPECT_EQ(moved.substr(faces), bytes.substr(faces));
  EXPECT_EQ(moved.substr(0, 24), bytes.substr(0, 24));
  EXPECT_NE(back.mesh.find_attribute("normal")->values, shape.mesh.find_attribute("normal")->values);
  EXPECT_EQ(parse(bytes + "12345").notes, std::vector<std::string>{"5 bytes follow the last face"});
}

INSTANTIATE_TEST_SUITE_P(Off, OffBinary,
                         testing::Values(BinaryForm{std::endian::big, true}, BinaryForm{std::endian::big, false},
                                         BinaryForm{std::endian::little, true}, BinaryForm{std::endian::little, false}),
                         [](const auto& test) { return test.param.name(); });

TEST(Off, ErrorsInBinaryNameTheByte) {
  const std::string bytes = binary({std::endian::big, true});
  EXPECT_EQ(error_of(bytes.substr(0, 60)),
            "shape.off: byte 24: 4 vertices are declared, but only 36 bytes follow; the file is cut short or damaged");
  std::string bad = bytes;
  detail::put_float(bad, 24 + 24, kInfinity, std::endian::big);
  EXPECT_EQ(error_of(bad), "shape.off: byte 48: a coordinate of vertex 1 is not finite; repair the file");
  bad = bytes;
  bad[24 + 4 * 24 + 7] = 9;
  EXPECT_EQ(error_of(bad), "shape.off: byte 128: a vertex index is 9, more than 3; repair the file");
  EXPECT_NE(error_of("OFF BINARY\n123").find("byte 11: expected the count of vertices"), std::string::npos);
  EXPECT_NE(error_of("nOFF BINARY\n123").find("binary nOFF"), std::string::npos);
  const ShapeFile shape = parse(bytes);
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[0].x = 1e39;
  EXPECT_THROW(serialize_shape("off", shape, positions), InvalidInput);
}

TEST(Off, NewFilesHoldEveryAttributeOfVerticesAndColorsOfFaces) {
  Mesh mesh;
  mesh.positions = {{0.1, 0, 0}, {1, 0, 0}, {1, 1.0 / 3, 0}, {0, 1, 0}, {5, 5, 5}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2, 3});
  mesh.attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, std::vector<double>(15, 0.5)});
  mesh.attributes.push_back({"uv", Domain::vertex, NumberType::float32, 2, std::vector<double>(10, 0.25)});
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 4, std::vector<double>(20, 200)});
  mesh.attributes.push_back({"color", Domain::face, NumberType::float32, 3, {1, 0, 1}});
  const std::string bytes = serialize_mesh("off", mesh);
  EXPECT_EQ(bytes.substr(0, bytes.find("\n1 0 0")), "STCNOFF\n5 1 0\n0.1 0 0 0.5 0.5 0.5 200 200 200 200 0.25 0.25");
  const ShapeFile shape = parse(bytes);
  EXPECT_EQ(shape.mesh.positions, mesh.positions);
  EXPECT_EQ(shape.mesh.corner_vertex, mesh.corner_vertex);
  EXPECT_EQ(shape.mesh.face_begin, mesh.face_begin);
  EXPECT_EQ(shape.mesh.attributes, mesh.attributes);
  EXPECT_TRUE(detail::off_codec.losses(mesh).empty());
  mesh.attributes.push_back({"part", Domain::face, NumberType::int32, 1, {-3}});
  mesh.attributes.push_back({"quality", Domain::vertex, NumberType::float32, 1, std::vector<double>(5, 0)});
  EXPECT_EQ(text_of(detail::off_codec.losses(mesh)), "OFF cannot hold 'part' per face\nOFF cannot hold 'quality'\n");
}

// With three numbers after COFF other programs read past the end of the line.
TEST(Off, NewFilesHaveAnAlphaWithEveryColorOfAVertex) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}};
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::float32, 3, {0.5, 0, 1, 0, 0.25, 0}});
  EXPECT_EQ(serialize_mesh("off", mesh), "COFF\n2 0 0\n0 0 0 0.5 0.0 1.0 1.0\n1 0 0 0.0 0.25 0.0 1.0\n");
  mesh.attributes[0] = {"color", Domain::vertex, NumberType::uint8, 3, {9, 8, 7, 6, 5, 4}};
  EXPECT_EQ(serialize_mesh("off", mesh), "COFF\n2 0 0\n0 0 0 9 8 7 255\n1 0 0 6 5 4 255\n");
}

TEST(Off, AColorIndexIsWrittenBack) {
  const std::string text = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 7\n";
  EXPECT_EQ(serialize_mesh("off", parse(text).mesh), text);
}

TEST(Off, TheLayoutOfPmpsBinary) {
  KNEAD_NEEDS_TEST_MESH("originals");
  const ShapeFile shape = read_shape(test_mesh("originals/fairing_cross_binary.off"));
  const detail::off::Layout& layout = detail::layout_of<detail::off::Layout>(shape);
  EXPECT_TRUE(layout.binary);
  EXPECT_EQ(layout.order, std::endian::little);
  EXPECT_EQ(text_of(shape.notes), "");
}

}  // namespace
}  // namespace knead::off_test
