// Reading GLB.
#include "io/gltf/gltf.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "support/shape_promises.h"
#include "support/test_meshes.h"

namespace knead::glb_test {
namespace {

using Corners = std::vector<std::uint32_t>;

std::string error_of(const std::string& bytes) {
  try {
    parse_shape(bytes, "glb", "made.glb");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "was read";
}

void expect_error(const std::string& bytes, const std::string& part) {
  const std::string error = error_of(bytes);
  EXPECT_NE(error.find(part), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

TEST(ReadGlb, ASquareWithItsAttributes) {
  const ShapeFile shape = square_glb().parse();
  EXPECT_EQ(shape.mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(shape.mesh.corner_vertex, (Corners{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(shape.mesh.find_attribute("normal")->values, (std::vector<double>{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}));
  EXPECT_EQ(shape.mesh.find_attribute("tangent")->values[11], -1);
  EXPECT_TRUE(shape.notes.empty());
}

TEST(ReadGlb, EveryModeAndIndexType) {
  const auto read = [](int mode, int type, const auto& indices) {
    GlbFile file = square_glb();
    file.primitive()["mode"] = mode;
    file.primitive()["indices"] = file.add(type, "SCALAR", 1, indices);
    return file.parse().mesh.corner_vertex;
  };
  EXPECT_EQ(read(4, 5121, std::vector<std::uint8_t>{2, 1, 0}), (Corners{2, 1, 0}));
  EXPECT_EQ(read(5, 5123, std::vector<std::uint16_t>{0, 1, 3, 2}), (Corners{0, 1, 3, 1, 2, 3}));
  EXPECT_EQ(read(5, 5123, std::vector<std::uint16_t>{0, 1, 3, 3, 2}), (Corners{0, 1, 3}));  // the rest are stitches
  EXPECT_EQ(read(6, 5125, std::vector<std::uint32_t>{0, 1, 2, 3}), (Corners{1, 2, 0, 2, 3, 0}));
  EXPECT_TRUE(read(0, 5121, std::vector<std::uint8_t>{0}).empty());
  EXPECT_TRUE(read(1, 5121, std::vector<std::uint8_t>{0, 1}).empty());
  GlbFile plain = square_glb();
  plain.primitive().erase("indices");
  EXPECT_EQ(plain.parse().mesh.corner_vertex, (Corners{0, 1, 2}));
  EXPECT_NE(plain.parse().notes.at(0).find("ends within a triangle"), std::string::npos);
}

TEST(ReadGlb, NodesAreMultiplied) {
  GlbFile file = square_glb();
  file.json["nodes"] = GlbJson::parse(R"([{"children":[1],"translation":[10,0,0]},
    {"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,3,4]}])");
  const ShapeFile shape = file.parse();
  // Scaled, turned a quarter about z, moved; the quaternion's components have half a unit in the last place of error.
  EXPECT_NEAR(norm(shape.mesh.positions[1] - Vec3d{10, 2, 0}), 0, 1e-15 * 10);
  EXPECT_NEAR(norm(shape.mesh.positions[3] - Vec3d{7, 0, 0}), 0, 1e-15 * 10);
  file.json["nodes"][1] = GlbJson::parse(R"({"mesh":0,"matrix":[0,2,0,0,-3,0,0,0,0,0,4,0,0,0,0,1]})");
  EXPECT_EQ(file.parse().mesh.positions[1], (Vec3d{10, 2, 0}));
  EXPECT_EQ(file.parse().mesh.positions[3], (Vec3d{7, 0, 0}));
}

TEST(ReadGlb, AMirrorKeepsTheOutsideOutside) {
  GlbFile file = square_glb();
  file.json["nodes"][0]["scale"] = {-1, 1, 1};
  const ShapeFile shape = file.parse();
  EXPECT_EQ(shape.mesh.corner_vertex, (Corners{0, 2, 1, 0, 3, 2}));
  EXPECT_EQ(shape.mesh.find_attribute("normal")->values[2], 1);
  EXPECT_EQ(shape.mesh.find_attribute("tangent")->values[0], -1);
  EXPECT_EQ(shape.mesh.find_attribute("tangent")->values[3], -1);  // normal x tangent points the other way now
}

TEST(ReadGlb, OnlyTheScenesNodesCount) {
  GlbFile file = square_glb();
  file.json["nodes"] = GlbJson::parse(R"([{"mesh":0},{"mesh":0,"translation":[5,0,0]},{"mesh":0}])");
  file.json["scenes"] = GlbJson::parse(R"([{"nodes":[0,1]},{"nodes":[2]}])");
  EXPECT_EQ(file.parse().mesh.vertex_count(), 8u);
  EXPECT_EQ(file.parse().mesh.positions[4], (Vec3d{5, 0, 0}));
  file.json["scene"] = 1;
  EXPECT_EQ(file.parse().mesh.vertex_count(), 4u);
  file.json.erase("scenes");
  file.json.erase("scene");
  EXPECT_EQ(file.parse().mesh.vertex_count(), 12u);
}

TEST(ReadGlb, QuantizedSparseAndStrided) {
  GlbFile bytes = square_glb();
  const std::vector<std::int8_t> numbers{0, 0, 0, 0, 127, 0, 0, 0, 127, -127, 0, 0, -128, 64, 0, 0};
  bytes.primitive()["attributes"]["POSITION"] = bytes.add(5120, "VEC3", 4, numbers);
  bytes.json["bufferViews"].back()["byteStride"] = 4;
  EXPECT_EQ(bytes.parse().mesh.positions[2], (Vec3d{127, -127, 0}));
  bytes.accessor(4)["normalized"] = true;
  EXPECT_EQ(bytes.parse().mesh.positions[2], (Vec3d{1, -1, 0}));
  EXPECT_EQ(bytes.parse().mesh.positions[3], (Vec3d{-1, double{static_cast<float>(64 / 127.0)}, 0}));
  GlbFile sparse = square_glb();
  const std::size_t indices = sparse.add_view(raw(std::vector<std::uint8_t>{1, 3}));
  const std::size_t values = sparse.add_view(raw(std::vector<float>{7, 8, 9, 4, 5, 6}));
  sparse.accessor(0)["sparse"] = {{"count", 2},
                                  {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                  {"values", {{"bufferView", values}}}};
  EXPECT_EQ(sparse.parse().mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {7, 8, 9}, {1, 1, 0}, {4, 5, 6}}));
  sparse.accessor(0).erase("bufferView");
  EXPECT_EQ(sparse.parse().mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {7, 8, 9}, {0, 0, 0}, {4, 5, 6}}));
  sparse.bin[static_cast<std::size_t>(sparse.json["bufferViews"][indices]["byteOffset"])] = 3;
  expect_error(sparse.bytes(), "sparse index 3 is out of order");
}

TEST(ReadGlb, ColorsAndTextureCoordinates) {
  GlbFile file = square_glb();
  GlbJson& attributes = file.primitive()["attributes"];
  attributes["COLOR_0"] =
      file.add<std::uint8_t>(5121, "VEC4", 4, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 1, 2, 3, 4});
  file.json["accessors"].back()["normalized"] = true;
  attributes["TEXCOORD_0"] = file.add<std::uint16_t>(5123, "VEC2", 2, {0, 0, 65535, 0, 65535, 65535, 0, 65535});
  file.json["accessors"].back()["normalized"] = true;
  const ShapeFile shape = file.parse();
  EXPECT_EQ(shape.mesh.find_attribute("color")->type, NumberType::uint8);
  EXPECT_EQ(shape.mesh.find_attribute("color")->values[15], 4);
  EXPECT_EQ(shape.mesh.find_attribute("uv")->values, (std::vector<double>{0, 1, 1, 1, 1, 0, 0, 0}));
}

TEST(ReadGlb, PrimitivesThatShareVertices) {
  GlbFile file = square_glb();
  const GlbJson first = file.primitive();
  file.json["meshes"][0]["primitives"].push_back(first);
  EXPECT_EQ(file.parse().mesh.vertex_count(), 4u);
  EXPECT_EQ(file.parse().mesh.face_count(), 4u);
  file.primitive(1)["attributes"].erase("NORMAL");
  EXPECT_EQ(file.parse().mesh.vertex_count(), 4u);
  EXPECT_TRUE(file.parse().notes.empty());
  const std::size_t other = file.add_vec3({1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0});
  file.primitive(1)["attributes"]["NORMAL"] = other;  // contradicts: vertices of its own
  EXPECT_EQ(file.parse().mesh.vertex_count(), 8u);
  file.primitive(1)["attributes"] = {{"POSITION", other}};
  EXPECT_NE(file.parse().notes.at(0).find("4 vertices have no normal"), std::string::npos);
}

TEST(ReadGlb, SaysWhatIsOdd) {
  GlbFile file = square_glb();
  file.json["nodes"] = GlbJson::parse(R"([{"mesh":0,"skin":0,"translation":[9,9,9]},{"mesh":0,"scale":[1,1,0]}])");
  file.json["scenes"][0]["nodes"] = {0, 1};
  file.json["extensionsRequired"] = {"X_unknown", "KHR_materials_unlit"};
  file.primitive()["targets"] = GlbJson::parse(R"([{"POSITION":0}])");
  const ShapeFile shape = file.parse();
  EXPECT_EQ(shape.mesh.vertex_count(), 4u);
  EXPECT_EQ(shape.mesh.positions[0], (Vec3d{}));  // a skinned mesh is not placed
  ASSERT_EQ(shape.notes.size(), 4u);
  EXPECT_NE(shape.notes[0].find("X_unknown"), std::string::npos);
  EXPECT_NE(shape.notes[1].find("skeleton"), std::string::npos);
  EXPECT_NE(shape.notes[2].find("flat"), std::string::npos);
  EXPECT_NE(shape.notes[3].find("morph targets"), std::string::npos);
}

TEST(ReadGlb, NodesThatAreNoTrees) {
  const auto with_nodes = [](const char* nodes) {
    GlbFile file = square_glb();
    file.json["nodes"] = GlbJson::parse(nodes);
    return file.bytes();
  };
  expect_error(with_nodes(R"([{"mesh":0},{"children":[2]},{"children":[1]}])"), "own ancestors");
  expect_error(with_nodes(R"([{"mesh":0,"children":[0]}])"), "own ancestors");
  expect_error(with_nodes(R"([{"children":[2]},{"children":[2]},{"mesh":0}])"), "nodes[2]: has two parents");
  expect_error(with_nodes(R"([{"children":[7]}])"), "nodes: there is no item 7");
  expect_error(with_nodes(R"([{"mesh":1}])"), "meshes: there is no item 1");
  expect_error(with_nodes(R"([{"mesh":0,"rotation":[0,0,0,0]}])"), "nodes[0].rotation: is no rotation");
  expect_error(with_nodes(R"([{"mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}])"), "last row");
  std::string chain = R"([{"mesh":0})";
  for (int i = 1; i < 20000; ++i) chain += fmt::format(R"(,{{"children":[{}]}})", i - 1);
  GlbFile deep = square_glb();
  deep.json["nodes"] = GlbJson::parse(chain + "]");
  deep.json["scenes"][0]["nodes"] = {19999};
  EXPECT_EQ(deep.parse().mesh.vertex_count(), 4u);
}

TEST(ReadGlb, WhatCannotBeReadHonestly) {
  GlbFile external = square_glb();
  external.json["buffers"][0]["uri"] = "../../etc/passwd";
  expect_error(external.bytes(), "is no plain name of a file in the same folder");
  external.json["buffers"][0]["uri"] = "square.bin";
  expect_error(external.bytes(), "in the file 'square.bin', which is not opened here");
  GlbFile second = square_glb();
  second.json["bufferViews"][0]["buffer"] = 1;
  expect_error(second.bytes(), "lies in buffer 1");
  GlbFile empty = square_glb();
  empty.accessor(0).erase("bufferView");
  expect_error(empty.bytes(), "accessors[0]: holds no data");
  std::string old = square_glb().bytes();
  old[4] = 1;
  expect_error(old, "byte 4: glTF 1 is not supported");
  GlbFile version = square_glb();
  version.json["asset"]["version"] = "1.0";
  expect_error(version.bytes(), "asset.version: only glTF 2");
}

TEST(ReadGlb, AbsurdNumbers) {
  const auto with = [](const char* array, const char* key, const GlbJson& value) {
    GlbFile file = square_glb();
    file.json[array][0][key] = value;
    return file.bytes();
  };
  for (const GlbJson& value : {GlbJson(-1), GlbJson(1.5), GlbJson(1e300), GlbJson("1"), GlbJson()}) {
    expect_error(with("accessors", "count", value), "accessors[0].count: must be a whole number");
  }
  expect_error(with("accessors", "count", 9007199254740992.0), "end after their buffer view");
  expect_error(with("accessors", "byteOffset", 4), "end after their buffer view");
  expect_error(with("accessors", "byteOffset", 9007199254740992.0), "end after their buffer view");
  expect_error(with("accessors", "componentType", 5124), "no component type");
  expect_error(with("accessors", "componentType", 5125), "component type 5125 (UNSIGNED_INT)");
  expect_error(with("accessors", "type", "VEC2"), "not of type VEC3");
  expect_error(with("bufferViews", "byteLength", 1000), "ends after its buffer");
  expect_error(with("bufferViews", "byteStride", 4), "stride of 4");
  GlbFile count = square_glb();
  count.accessor(1)["count"] = 3;
  expect_error(count.bytes(), "does not fit NORMAL of 4 vertices");
  GlbFile index = square_glb();
  index.primitive()["indices"] = index.add<std::uint16_t>(5123, "SCALAR", 1, {0, 1, 4});
  expect_error(index.bytes(), "vertex index 4 is out of range");
  index.primitive()["indices"] = index.add<std::uint8_t>(5121, "SCALAR", 1, {0, 1, 255});
  expect_error(index.bytes(), "vertex index 255 is out of range");
  GlbFile nan = square_glb();
  nan.primitive()["attributes"]["POSITION"] = nan.add_vec3({0, 0, 0, 1, NAN, 0, 0, 0, 0, 0, 0, 0});
  expect_error(nan.bytes(), "position 1 is not finite");
}

TEST(ReadGlb, JsonThatAttacks) {
  const std::string deep =
      R"({"asset":{"version":"2.0"},"extras":)" + std::string(200000, '[') + std::string(200000, ']') + "}";
  expect_error(glb_file(deep, ""), "nested deeper than 128");
  expect_error(glb_file(R"({"asset":{"version":"2.0","version":"2.0"}})", ""), "the key 'version' twice");
  expect_error(glb_file("[]", ""), "not an object");
  expect_error(glb_file("{\"asset\":1e999}", ""), "too large");
  expect_error(glb_file("{\"asset\":", ""), "not JSON");
  expect_error(glb_file("{}", ""), "'asset' is missing");
}

// A thousand nodes that each place 2 million vertices that a sparse accessor of a few bytes declares.
TEST(ReadGlb, ASmallFileDoesNotUnfoldWithoutEnd) {
  GlbFile file = square_glb();
  const std::size_t indices = file.add_view(raw(std::vector<std::uint8_t>{1}));
  const std::size_t values = file.add_view(raw(std::vector<float>{7, 8, 9}));
  file.accessor(0) = {{"componentType", 5126}, {"count", 2000000}, {"type", "VEC3"}};
  file.accessor(0)["sparse"] = {{"count", 1},
                                {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                {"values", {{"bufferView", values}}}};
  file.primitive()["attributes"] = {{"POSITION", 0}};
  file.primitive().erase("indices");
  for (int i = 1; i < 1000; ++i) {
    file.json["nodes"].push_back({{"mesh", 0}});
    file.json["scenes"][0]["nodes"].push_back(i);
  }
  expect_error(file.bytes(), "unfold into more than");
}

struct RealGlb {
  const char* file;
  std::size_t vertices, triangles;
};

TEST(ReadGlb, RealFiles) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const RealGlb& real : {RealGlb{"originals/duck.glb", 2399, 4212},
                              {"originals/box_textured.glb", 24, 12},
                              {"originals/cube_vertex_colors.glb", 54, 48}}) {
    const ShapeFile shape = read_shape(test_mesh(real.file));
    const Measures m = measure(shape.mesh);
    EXPECT_EQ(m.vertices, real.vertices) << real.file;
    EXPECT_EQ(m.triangles, real.triangles) << real.file;
    EXPECT_NE(shape.mesh.find_attribute("normal"), nullptr);
    EXPECT_NE(shape.mesh.find_attribute("uv"), nullptr);
    EXPECT_TRUE(shape.notes.empty()) << shape.notes[0];
    EXPECT_EQ(serialize_shape("glb", shape, shape.mesh.positions), file_bytes(test_mesh(real.file)));
    EXPECT_EQ(broken_promise(shape), "") << real.file;
  }
}

TEST(ReadGlb, BrokenFiles) {
  KNEAD_NEEDS_TEST_MESH("bad");
  const std::string bytes = file_bytes(test_mesh("bad/glb_accessor_past_buffer.glb"));
  const std::size_t accessor = bytes.find("[", bytes.find("\"accessors\"")) + 1;
  expect_error(bytes, fmt::format("byte {}: accessors[0]: 300000 elements end after", accessor));
  expect_error(file_bytes(test_mesh("bad/glb_length_4gb.glb")), "byte 8: the file should have 4294967295 bytes");
}

}  // namespace
}  // namespace knead::glb_test
