// GLB files whose primitives get other triangles.
#include <gtest/gtest.h>

#include "io/test_samples.h"
#include "knead/error.h"
#include "support/remade_files.h"
#include "support/shape_text.h"

namespace knead::remeshed_test {
namespace {

std::string written(const ShapeFile& source, const Remade& remade) {
  return serialize_remeshed("glb", source, remade.mesh, remade.face_source);
}

ShapeFile reread(const std::string& bytes) { return parse_shape(bytes, "glb", "written.glb"); }

Remade split_from(const Mesh& mesh, std::uint32_t first, std::uint32_t end) {
  return split_faces(mesh, [&](std::uint32_t f) { return f >= first && f < end; });
}

// A square of two primitives of one triangle each that share vertices, and have materials; an image in the file; and a
// second mesh with its own square and a second set of texture coordinates.
GlbFile two_materials() {
  GlbFile file = square_glb();
  file.json["materials"] = GlbJson::parse(R"([{"name":"red"},{"name":"blue","extras":{"a":1}}])");
  file.json["images"] =
      GlbJson::array({{{"bufferView", file.add_view("\x89PNG of a kind")}, {"mimeType", "image/png"}}});
  file.primitive()["indices"] = file.add<std::uint16_t>(5123, "SCALAR", 1, {0, 1, 2});
  file.primitive()["material"] = 1;
  GlbJson second = file.primitive();
  second["indices"] = file.add<std::uint16_t>(5123, "SCALAR", 1, {0, 2, 3});
  second["material"] = 0;
  GlbJson other = file.primitive();
  other["attributes"]["POSITION"] = file.add_vec3({5, 0, 0, 6, 0, 0, 6, 1, 0});
  other["indices"] = file.add<std::uint16_t>(5123, "SCALAR", 1, {0, 1, 2});
  other["attributes"].erase("NORMAL");
  other["attributes"].erase("TANGENT");
  other["attributes"]["TEXCOORD_1"] = file.add<float>(5126, "VEC2", 2, {0, 0, 1, 0, 1, 1});
  other["attributes"]["COLOR_0"] = file.add<std::uint8_t>(5121, "VEC3", 4, {9, 8, 7, 0, 9, 8, 7, 0, 9, 8, 1, 0});
  file.json["accessors"].back()["normalized"] = true;
  file.json["accessors"].back()["count"] = 3;
  file.json["bufferViews"].back()["byteStride"] = 4;
  file.json["meshes"][0]["primitives"].push_back(second);
  file.json["meshes"].push_back(GlbJson::object({{"primitives", GlbJson::array({other})}}));
  file.json["nodes"].push_back(GlbJson::object({{"mesh", 1}, {"name", "other"}}));
  file.json["scenes"][0]["nodes"].push_back(1);
  return file;
}

// What glTF asks of the accessors of a primitive: counts, bounds and indices within range.
void expect_valid(const std::string& bytes) {
  const GlbJson json = json_of(bytes);
  const std::string bin = bin_of(bytes);
  for (const GlbJson& mesh : json["meshes"]) {
    ASSERT_FALSE(mesh["primitives"].empty());
    for (const GlbJson& primitive : mesh["primitives"]) {
      const GlbJson& position = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
      for (const GlbJson& attribute : primitive["attributes"]) {
        const GlbJson& accessor = json["accessors"][attribute.get<std::size_t>()];
        const GlbJson& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
        EXPECT_EQ(accessor["count"], position["count"]);
        EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
        EXPECT_EQ(view.value("byteStride", std::size_t{4}) % 4, 0u);
        EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(),
                  json["buffers"][0]["byteLength"].get<std::size_t>());
      }
    }
  }
}

TEST(RemeshedGlb, TrianglesStayInTheirPrimitives) {
  const ShapeFile shape = two_materials().parse();
  ASSERT_EQ(shape.mesh.face_count(), 3u);
  const Remade remade = split_from(shape.mesh, 0, 2);
  const std::string bytes = written(shape, remade);
  expect_valid(bytes);
  const ShapeFile back = reread(bytes);
  expect_remade(shape, remade, back, 1e-6);
  GlbJson before = json_of(shape.bytes);
  GlbJson after = json_of(bytes);
  EXPECT_EQ(after["materials"], before["materials"]);
  EXPECT_EQ(after["images"], before["images"]);
  EXPECT_EQ(after["nodes"], before["nodes"]);
  EXPECT_EQ(after["meshes"][1], before["meshes"][1]);  // nothing of it changed, TEXCOORD_1 included
  // The old accessors have the new numbers, and of the old ones nothing is left but what fills up to four bytes.
  EXPECT_EQ(after["accessors"].size(), before["accessors"].size());
  EXPECT_EQ(after["bufferViews"].size(), before["bufferViews"].size());
  EXPECT_EQ(bin_of(bytes).size(), bin_of(shape.bytes).size() + 2 * (12 + 12 + 16) + 2 * (2 * 6) + 8);
  const GlbJson& first = after["meshes"][0]["primitives"][0];
  const GlbJson& second = after["meshes"][0]["primitives"][1];
  EXPECT_EQ(first["material"], 1);
  EXPECT_EQ(second["material"], 0);
  EXPECT_EQ(first["attributes"], second["attributes"]);
  const GlbJson& position = after["accessors"][first["attributes"]["POSITION"].get<std::size_t>()];
  EXPECT_EQ(position["count"], 6);
  EXPECT_EQ(position["max"], (GlbJson{1.0, 1.0, 0.0}));
}

// The bytes of the file's image.
std::string image_of(const std::string& bytes) {
  const GlbJson json = json_of(bytes);
  const GlbJson& view = json["bufferViews"][json["images"][0]["bufferView"].get<std::size_t>()];
  return bin_of(bytes).substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
}

TEST(RemeshedGlb, BytesThatOthersReadStay) {
  GlbFile plain = two_materials();
  GlbFile shared = two_materials();  // one view for all of the square's numbers
  shared.json["bufferViews"][0]["byteLength"] = 48 + 48 + 64;
  for (const std::size_t accessor : {1, 2}) {
    shared.accessor(accessor)["bufferView"] = 0;
    shared.accessor(accessor)["byteOffset"] = 48 * accessor;
  }
  GlbFile as_times = two_materials();  // the old positions are something else, too
  as_times.json["animations"] = GlbJson::parse(R"([{"samplers":[{"input":0,"output":0}],"channels":[]}])");
  GlbFile as_image = two_materials();
  as_image.json["images"].push_back(GlbJson::parse(R"({"bufferView":0,"mimeType":"image/png"})"));
  GlbFile unknown = two_materials();
  unknown.json["extensionsUsed"] = {"EXT_of_accessors"};
  for (GlbFile file : {plain, shared, as_times, as_image, unknown}) {
    const ShapeFile shape = file.parse();
    const std::string bytes = written(shape, split_all(shape.mesh));
    expect_valid(bytes);
    expect_remade(shape, split_all(shape.mesh), reread(bytes), 1e-6);
    EXPECT_EQ(image_of(bytes), "\x89PNG of a kind");
    const GlbJson before = json_of(shape.bytes);
    const GlbJson after = json_of(bytes);
    const bool has_other_use = before.contains("animations") || before.contains("extensionsUsed");
    EXPECT_EQ(after["accessors"][0] == before["accessors"][0], has_other_use);
    const bool stays = has_other_use || before["images"].size() > 1;
    EXPECT_EQ(after["bufferViews"][0] == before["bufferViews"][0], stays);
    EXPECT_EQ(bin_of(bytes).substr(0, 48) == bin_of(shape.bytes).substr(0, 48), stays);
  }
}

TEST(RemeshedGlb, WhatIsNotReadIsLeftOutWhereTheShapeChanges) {
  const ShapeFile shape = two_materials().parse();
  const Remade remade = split_from(shape.mesh, 2, 3);
  const std::string bytes = written(shape, remade);
  expect_valid(bytes);
  expect_remade(shape, remade, reread(bytes), 1e-6);
  const GlbJson after = json_of(bytes);
  EXPECT_EQ(after["meshes"][0], json_of(shape.bytes)["meshes"][0]);
  const GlbJson& attributes = after["meshes"][1]["primitives"][0]["attributes"];
  EXPECT_FALSE(attributes.contains("TEXCOORD_1"));
  const GlbJson& color = after["accessors"][attributes["COLOR_0"].get<std::size_t>()];
  EXPECT_EQ(color["componentType"], 5121);
  EXPECT_EQ(color["type"], "VEC3");
  EXPECT_EQ(text_of(remesh_losses("a.glb", shape)), "attribute 'TEXCOORD_1' is left out where the shape changes\n");
}

TEST(RemeshedGlb, AMeshOfSeveralNodesIsCopiedWhereItChanged) {
  GlbFile file = square_glb();
  file.json["nodes"].push_back(GlbJson::parse(R"({"mesh":0,"translation":[3,0,0]})"));
  file.json["scenes"][0]["nodes"].push_back(1);
  const ShapeFile shape = file.parse();
  const Remade second = split_from(shape.mesh, 2, 4);
  std::string bytes = written(shape, second);
  expect_valid(bytes);
  expect_remade(shape, second, reread(bytes), 1e-6);
  EXPECT_EQ(json_of(bytes)["meshes"][0], json_of(shape.bytes)["meshes"][0]);
  EXPECT_EQ(json_of(bytes)["nodes"][0]["mesh"], 0);
  EXPECT_EQ(json_of(bytes)["nodes"][1]["mesh"], 1);
  const Remade both = split_all(shape.mesh);
  bytes = written(shape, both);
  expect_remade(shape, both, reread(bytes), 1e-6);
  EXPECT_EQ(json_of(bytes)["meshes"].size(), 2u);                 // the first node has taken the old one
  file.json["nodes"].push_back(GlbJson::parse(R"({"mesh":0})"));  // in no scene
  bytes = written(file.parse(), both);
  EXPECT_EQ(json_of(bytes)["meshes"].size(), 3u);
  EXPECT_EQ(json_of(bytes)["meshes"][0], json_of(shape.bytes)["meshes"][0]);
}

// Far from the origin, of other length than 1, or lost in 1 - v: what a vertex has in the file is not found by going
// back.
TEST(RemeshedGlb, NumbersOfOldVerticesKeepTheirBits) {
  GlbFile file = square_glb();
  const std::vector<float> positions{0.1f, 0, 0, 1.3f, 0, 0, 1.7f, 1, 0, 0.3f, 1, 0};
  const std::vector<float> normals{0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2};
  const std::vector<float> uv{1e-20f, 0, 1, 1e-20f, 1, 1, 0, 1e-20f};
  GlbJson& attributes = file.primitive()["attributes"];
  attributes["POSITION"] = file.add_vec3(positions);
  attributes["NORMAL"] = file.add_vec3(normals);
  attributes["TEXCOORD_0"] = file.add<float>(5126, "VEC2", 2, uv);
  file.json["nodes"][0]["translation"] = {1e9, 0, 0};
  const ShapeFile shape = file.parse();
  const std::string bytes = written(shape, split_all(shape.mesh));
  const GlbJson json = json_of(bytes);
  const auto begins_with = [&](const char* key, const std::vector<float>& numbers) {
    const std::size_t accessor = json["meshes"][0]["primitives"][0]["attributes"][key].get<std::size_t>();
    const GlbJson& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    return bin_of(bytes).compare(view["byteOffset"].get<std::size_t>(), 4 * numbers.size(), raw(numbers)) == 0;
  };
  EXPECT_TRUE(begins_with("POSITION", positions));
  EXPECT_TRUE(begins_with("NORMAL", normals));
  EXPECT_TRUE(begins_with("TEXCOORD_0", uv));
}

TEST(RemeshedGlb, PointsFollowAndLinesAmongFacesGo) {
  GlbFile file = square_glb();
  GlbJson points = GlbJson::parse(R"({"mode":0,"attributes":{}})");
  points["attributes"]["POSITION"] = file.add_vec3({7, 0, 0, 8, 0, 0});
  points["attributes"]["_SIZE"] = file.add<float>(5126, "VEC2", 2, {1, 2, 3, 4});
  GlbJson lines = file.primitive();
  lines["mode"] = 1;
  file.json["meshes"][0]["primitives"].push_back(points);
  file.json["meshes"][0]["primitives"].push_back(lines);
  const ShapeFile shape = file.parse();
  Remade remade = split_all(shape.mesh);
  const GlbJson same = json_of(written(shape, remade))["meshes"][0]["primitives"];
  ASSERT_EQ(same.size(), 2u);
  EXPECT_EQ(same[1], points);
  remade.mesh.positions[5].y = 2;
  const std::string bytes = written(shape, remade);
  const ShapeFile back = reread(bytes);
  EXPECT_EQ(back.mesh.positions.back(), (Vec3d{8, 2, 0}));
  EXPECT_EQ(json_of(bytes)["meshes"][0]["primitives"][1]["attributes"]["_SIZE"], points["attributes"]["_SIZE"]);
  EXPECT_EQ(remesh_losses("a.glb", shape).size(), 2u);  // the lines, and _SIZE where it changes
}

TEST(RemeshedGlb, SkeletonsAndMorphTargetsAreRefused) {
  GlbFile skinned = square_glb();
  skinned.json["skins"] = GlbJson::parse(R"([{"joints":[0]}])");
  skinned.json["nodes"][0]["skin"] = 0;
  GlbFile morphed = square_glb();
  morphed.primitive()["targets"] = GlbJson::parse(R"([{"POSITION":0}])");
  for (GlbFile file : {skinned, morphed}) {
    const ShapeFile shape = file.parse();
    EXPECT_THROW(written(shape, split_all(shape.mesh)), InvalidInput);
    EXPECT_THROW(remesh_losses("a.glb", shape), InvalidInput);
    EXPECT_NO_THROW(remesh_losses("a.ply", shape));
  }
}

TEST(RemeshedGlb, APrimitiveWithoutTrianglesGoes) {
  const ShapeFile shape = two_materials().parse();
  Remade remade = split_from(shape.mesh, 0, 1);
  remade.face_source[3] = 0;  // that of the second primitive
  const ShapeFile back = reread(written(shape, remade));
  const GlbJson json = json_of(back.bytes);
  ASSERT_EQ(json["meshes"][0]["primitives"].size(), 1u);
  EXPECT_EQ(json["meshes"][0]["primitives"][0]["material"], 1);
  EXPECT_EQ(back.mesh.face_count(), 5u);
  remade.face_source.assign(5, 2);
  EXPECT_THROW(written(shape, remade), InvalidInput);
}

TEST(RemeshedGlb, ManyVerticesGetLongIndices) {
  GlbFile file;
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < 30000; ++i) {
    positions.insert(positions.end(), {static_cast<float>(i / 2), static_cast<float>(i % 2), 0});
    if (i >= 2) indices.insert(indices.end(), {i, i - 1 - i % 2, i - 2 + i % 2});
  }
  file.primitive()["attributes"]["POSITION"] = file.add_vec3(positions);
  file.primitive()["indices"] = file.add<std::uint32_t>(5125, "SCALAR", 1, indices);
  const ShapeFile shape = file.parse();
  const auto indices_of = [](const std::string& bytes) {
    const GlbJson json = json_of(bytes);
    return json["accessors"][json["meshes"][0]["primitives"][0]["indices"].get<std::size_t>()];
  };
  const Remade half = split_from(shape.mesh, 0, 14000);
  EXPECT_EQ(indices_of(written(shape, half))["componentType"], 5123);
  Remade all = split_all(shape.mesh);
  all = split_all(all.mesh);
  for (std::uint32_t& f : all.face_source) f /= 3;
  const std::string bytes = written(shape, all);
  EXPECT_EQ(indices_of(bytes)["componentType"], 5125);
  expect_remade(shape, all, reread(bytes), 1e-6);
}

}  // namespace
}  // namespace knead::remeshed_test
