// GLB from other formats and to them.
#include <gtest/gtest.h>

#include "io/gltf/gltf.h"
#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "support/test_meshes.h"

namespace knead::generate_test {
namespace {

Mesh two_triangles() {
  Mesh mesh;
  mesh.positions = {{0.5, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.25}};
  mesh.add_face(std::vector<std::uint32_t>{0, 1, 2});
  mesh.add_face(std::vector<std::uint32_t>{1, 3, 2});
  return mesh;
}

ShapeFile through_glb(const Mesh& mesh) { return parse_shape(serialize_mesh("glb", mesh), "glb", "made.glb"); }

TEST(GenerateGlb, TheSameMeshComesBack) {
  Mesh mesh = two_triangles();
  mesh.attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1}});
  mesh.attributes.push_back({"uv", Domain::vertex, NumberType::float32, 2, {0, 1, 0.5, 0.25, 1, 0, 2, -1}});
  mesh.attributes.push_back({"color", Domain::vertex, NumberType::uint8, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 255}});
  const ShapeFile shape = through_glb(mesh);
  EXPECT_EQ(shape.mesh.positions, mesh.positions);
  EXPECT_EQ(shape.mesh.corner_vertex, mesh.corner_vertex);
  for (const Attribute& attribute : mesh.attributes) {
    EXPECT_EQ(*shape.mesh.find_attribute(attribute.name), attribute) << attribute.name;
  }
  EXPECT_TRUE(detail::gltf::losses(mesh).empty());
  EXPECT_TRUE(shape.notes.empty());
}

// What the specification asks of every file, beyond what the reader needs.
TEST(GenerateGlb, EveryAccessorIsAlignedAndBounded) {
  Mesh mesh = two_triangles();
  for (const NumberType type : {NumberType::uint8, NumberType::uint16, NumberType::int32, NumberType::float64}) {
    for (const int components : {3, 4}) {
      mesh.attributes = {{"color", Domain::vertex, type, components, std::vector<double>(4u * components, 1.0)},
                         {"heat", Domain::vertex, type, 1, {1, 2, 3, 4}}};
      const std::string bytes = serialize_mesh("glb", mesh);
      const GlbJson json = json_of(bytes);
      EXPECT_EQ(bytes.size() % 4, 0u);
      EXPECT_EQ(json["buffers"][0]["byteLength"], bin_of(bytes).size());
      for (const GlbJson& view : json["bufferViews"]) {
        EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
        EXPECT_EQ(view.value("byteStride", 4u) % 4, 0u);
      }
      EXPECT_EQ(json["accessors"][0]["min"], GlbJson::parse("[0.0,0.0,0.0]"));
      EXPECT_EQ(json["accessors"][0]["max"], GlbJson::parse("[1.0,1.0,0.25]"));
      EXPECT_TRUE(json["meshes"][0]["primitives"][0]["attributes"].contains("_HEAT"));
      EXPECT_EQ(through_glb(mesh).mesh.find_attribute("color")->components, components);
    }
  }
}

TEST(GenerateGlb, CornersThatDifferSplitTheirVertices) {
  Mesh mesh = two_triangles();
  mesh.attributes.push_back({"uv", Domain::corner, NumberType::float32, 2, {0, 0, 1, 0, 0, 1, 0.5, 0, 1, 1, 0, 1}});
  const ShapeFile shape = through_glb(mesh);
  ASSERT_EQ(shape.mesh.vertex_count(), 5u);  // vertex 1 has two, vertex 2 has one
  EXPECT_EQ(shape.mesh.positions[4], mesh.positions[1]);
  const Attribute* uv = shape.mesh.find_attribute("uv");
  for (std::size_t c = 0; c < 6; ++c) {
    const std::size_t v = shape.mesh.corner_vertex[c];
    EXPECT_EQ(shape.mesh.positions[v], mesh.positions[mesh.corner_vertex[c]]);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(uv->values[2 * v + i], mesh.attributes[0].values[2 * c + i]);
  }
}

TEST(GenerateGlb, PolygonsPointsAndNothing) {
  Mesh square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.add_face(std::vector<std::uint32_t>{0, 1, 2, 3});
  EXPECT_EQ(measure(through_glb(square).mesh).area, 1);
  EXPECT_EQ(detail::gltf::losses(square).size(), 1u);
  Mesh points;
  points.positions = square.positions;
  EXPECT_EQ(through_glb(points).mesh.positions, points.positions);
  EXPECT_EQ(through_glb(points).mesh.face_count(), 0u);
  EXPECT_EQ(json_of(serialize_mesh("glb", Mesh{})).count("meshes"), 0u);
}

TEST(GenerateGlb, ZeroNormalsBecomeTheSurfaces) {
  Mesh mesh = two_triangles();
  mesh.positions.push_back({9, 9, 9});  // in no face
  mesh.positions[3].z = 0;
  mesh.attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, std::vector<double>(15, 0.0)});
  const std::vector<double> up{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  EXPECT_EQ(through_glb(mesh).mesh.find_attribute("normal")->values, up);
}

TEST(GenerateGlb, SaysWhatIsLost) {
  Mesh mesh = two_triangles();
  mesh.positions[0].x = 0.1;
  mesh.attributes.push_back({"part", Domain::face, NumberType::int32, 1, {1, 2}});
  mesh.attributes.push_back({"weight", Domain::corner, NumberType::float32, 1, {1, 2, 3, 4, 5, 6}});
  const std::vector<std::string> losses = detail::gltf::losses(mesh);
  ASSERT_EQ(losses.size(), 3u);
  EXPECT_EQ(losses[0], "GLB cannot hold 'part' per face");
  EXPECT_EQ(losses[1], "GLB cannot hold 'weight' that differs between the faces at a vertex");
  EXPECT_NE(losses[2].find("rounded"), std::string::npos);
  mesh.positions[0].x = 1e40;
  EXPECT_THROW(serialize_mesh("glb", mesh), InvalidInput);
}

TEST(GenerateGlb, SaysWhatOtherFormatsLack) {
  GlbFile file = square_glb();
  file.json["materials"] = GlbJson::parse(R"([{}])");
  file.json["nodes"].push_back(GlbJson::parse(R"({"camera":0})"));
  file.json["cameras"] = GlbJson::parse(R"([{"extras":{}}])");
  file.primitive()["attributes"]["TEXCOORD_1"] = 2;
  const std::vector<std::string> losses = detail::gltf::source_losses(file.parse());
  EXPECT_EQ(losses, (std::vector<std::string>{"materials are left out", "cameras are left out",
                                              "the tree of nodes is left out; every mesh is placed where it is",
                                              "extras are left out", "attribute 'TEXCOORD_1' is left out"}));
}

TEST(GenerateGlb, MoreVerticesThanShortIndicesReach) {
  Mesh mesh = two_triangles();
  mesh.positions.resize(70000);
  mesh.add_face(std::vector<std::uint32_t>{69999, 65535, 0});
  EXPECT_EQ(through_glb(mesh).mesh.corner_vertex, mesh.corner_vertex);
}

TEST(GenerateGlb, RealShapesKeepTheirMeasures) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const char* file : {"originals/spot_quads_uv.obj", "originals/cow_tristrips.ply", "originals/fuze.obj",
                           "originals/suzanne_ngons_normals_uv_ascii.ply", "originals/reference_vertex_colors.ply"}) {
    const ShapeFile shape = read_shape(test_mesh(file));
    const ShapeFile there = parse_shape(serialize_shape("glb", shape, shape.mesh.positions), "glb", "made.glb");
    const Measures before = measure(shape.mesh);
    const Measures after = measure(there.mesh);
    EXPECT_EQ(after.triangles, before.triangles) << file;
    EXPECT_NEAR(after.area, before.area, 1e-5 * before.area) << file;  // coordinates are rounded to 6e-8
  }
}

}  // namespace
}  // namespace knead::generate_test
