// Writing GLB back.
#include <gtest/gtest.h>

#include <set>

#include "io/codec.h"
#include "io/gltf/gltf.h"
#include "io/test_samples.h"
#include "knead/error.h"
#include "support/test_meshes.h"

namespace knead::rewrite_test {
namespace {

Vec3d rounded(const Vec3d& p) { return Vec3d(Vec3f(p)); }

std::string moved(const ShapeFile& shape, const std::vector<Vec3d>& positions) {
  return serialize_shape("glb", shape, positions);
}

ShapeFile reread(const std::string& bytes) { return parse_shape(bytes, "glb", "written.glb"); }

// The square's vertices with the third one lifted out of the plane.
std::vector<Vec3d> lifted(const ShapeFile& shape, std::size_t vertex = 2) {
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[vertex] += Vec3d{0, 0, 0.1};
  return positions;
}

TEST(RewriteGlb, NothingMovedIsTheSource) {
  const ShapeFile shape = square_glb().parse();
  EXPECT_EQ(moved(shape, shape.mesh.positions), shape.bytes);
}

TEST(RewriteGlb, OnlyTheMovedFloatsAndTheirBoundsChange) {
  GlbFile file = square_glb();
  file.primitive()["attributes"].erase("NORMAL");
  const ShapeFile shape = file.parse();
  const std::string written = moved(shape, lifted(shape));
  GlbJson expected = json_of(shape.bytes);
  expected["accessors"][0]["max"] = {1.0, 1.0, double{0.1f}};
  expected["accessors"][0]["min"] = {0.0, 0.0, 0.0};
  EXPECT_EQ(json_of(written), expected);
  std::string bin = bin_of(shape.bytes);
  bin.replace(32, 4, raw(std::vector<float>{0.1f}));
  EXPECT_EQ(bin_of(written), bin);
  EXPECT_EQ(reread(written).mesh.positions[2], (Vec3d{1, 1, double{0.1f}}));
}

TEST(RewriteGlb, NormalsAndTangentsFollow) {
  const ShapeFile shape = square_glb().parse();
  std::vector<Vec3d> turned;  // a quarter about y
  for (const Vec3d& p : shape.mesh.positions) turned.push_back({p.z, p.y, -p.x});
  const ShapeFile back = reread(moved(shape, turned));
  for (std::size_t i = 0; i < 4; ++i) {
    const double* n = back.mesh.find_attribute("normal")->values.data() + 3 * i;
    const double* t = back.mesh.find_attribute("tangent")->values.data() + 4 * i;
    // Rounded to float once.
    EXPECT_NEAR(norm(Vec3d{n[0], n[1], n[2]} - Vec3d{1, 0, 0}), 0, 1e-7);
    EXPECT_NEAR(norm(Vec3d{t[0], t[1], t[2]} - Vec3d{0, 0, -1}), 0, 1e-7);
    EXPECT_EQ(t[3], i == 2 ? -1 : 1);
  }
}

// Spelling, order, unknown keys, unknown chunks and what follows the file survive.
TEST(RewriteGlb, TheTextStays) {
  const std::string json =
      R"({ "asset" : {"version":"2.0", "extras":{"a":1e-1,"big":123456789012345678901234567890,"\u0061\"]}":[{}]}},)"
      "\n\t"
      R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITI\u004fN":0}}]}],)"
      R"("accessors":[{"max":[ 1.0,1.00,0 ],"min":[0,0,0],"componentType":5126,"count":3,"type":"VEC3","bufferView":0}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})";
  const std::string bin = raw(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
  const std::string unknown = glb_chunk(0x58585858, "keep me!", '\0');
  const std::string bytes =
      glb_with_header(glb_chunk(0x4E4F534A, json, ' ') + glb_chunk(0x004E4942, bin, '\0') + unknown) + "trailing";
  const ShapeFile shape = reread(bytes);
  EXPECT_NE(shape.notes.at(0).find("8 bytes follow"), std::string::npos);
  const std::string written = moved(shape, lifted(shape, 1));
  std::string text = json;
  const double tenth = double{0.1f};
  EXPECT_EQ(tenth, 0.10000000149011612);
  text.replace(text.find("[ 1.0,1.00,0 ]"), 14, "[1,1,0.10000000149011612]");
  std::string floats = bin;
  floats.replace(20, 4, raw(std::vector<float>{0.1f}));
  EXPECT_EQ(written, glb_with_header(glb_chunk(0x4E4F534A, text, ' ') + glb_chunk(0x004E4942, floats, '\0') + unknown) +
                         "trailing");
}

TEST(RewriteGlb, ThroughTheNodesTransform) {
  GlbFile file = square_glb();
  file.json["nodes"][0] = GlbJson::parse(R"({"mesh":0,"translation":[100,0,0],"scale":[4,-2,0.5]})");
  const ShapeFile shape = file.parse();
  const ShapeFile back = reread(moved(shape, lifted(shape)));
  EXPECT_NEAR(norm(back.mesh.positions[2] - Vec3d{104, -2, 0.1}), 0, 1e-8);  // half an ulp of the local float 0.2
  for (const std::size_t i : {0u, 1u, 3u}) EXPECT_EQ(back.mesh.positions[i], shape.mesh.positions[i]);
  EXPECT_EQ(json_of(back.bytes)["nodes"], json_of(shape.bytes)["nodes"]);
}

// Integers and sparse data become floats of their own; the old data stay where they are.
TEST(RewriteGlb, IntegersAndSparseDataAreReplaced) {
  GlbFile quantized = square_glb();
  quantized.primitive()["attributes"]["POSITION"] =
      quantized.add<std::int16_t>(5122, "VEC3", 4, {0, 0, 0, 0, 32767, 0, 0, 0, 12345, 777, 0, 0, 0, 32767, 0, 0});
  quantized.json["bufferViews"].back()["byteStride"] = 8;
  quantized.json["accessors"].back()["normalized"] = true;
  GlbFile sparse = square_glb();
  const std::size_t indices = sparse.add_view(raw(std::vector<std::uint8_t>{1}));
  const std::size_t values = sparse.add_view(raw(std::vector<float>{7, 8, 9}));
  sparse.accessor(0)["sparse"] = {{"count", 1},
                                  {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                  {"values", {{"bufferView", values}}}};
  for (GlbFile file : {quantized, sparse}) {
    const ShapeFile shape = file.parse();
    const std::vector<Vec3d> positions = lifted(shape);
    const ShapeFile back = reread(moved(shape, positions));
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(back.mesh.positions[i], rounded(positions[i]));
    const std::string bin = bin_of(shape.bytes);
    const GlbJson json = json_of(back.bytes);
    EXPECT_EQ(bin_of(back.bytes).substr(0, 48), bin.substr(0, 48));      // the first positions
    EXPECT_EQ(bin_of(back.bytes).substr(160, 12), bin.substr(160, 12));  // the indices
    EXPECT_EQ(json["accessors"].size(), json_of(shape.bytes)["accessors"].size() + 1);
    EXPECT_EQ(json["meshes"][0]["primitives"][0]["attributes"]["POSITION"], json["accessors"].size() - 1);
    EXPECT_EQ(json["buffers"][0]["byteLength"], bin_of(back.bytes).size());
  }
}

// The same bytes read as something else too: that must not change.
TEST(RewriteGlb, SharedBytesStay) {
  GlbFile as_color = square_glb();  // the same accessor
  as_color.primitive()["attributes"]["COLOR_0"] = 0;
  GlbFile as_view = square_glb();  // another accessor on the same view
  as_view.json["accessors"].push_back(as_view.accessor(0));
  as_view.primitive()["attributes"]["COLOR_0"] = as_view.json["accessors"].size() - 1;
  GlbFile shifted = square_glb();  // another one that overlaps in part
  shifted.json["bufferViews"][0]["byteLength"] = 96;
  shifted.json["accessors"].push_back(shifted.accessor(0));
  shifted.json["accessors"].back()["byteOffset"] = 4;
  shifted.primitive()["attributes"]["COLOR_0"] = shifted.json["accessors"].size() - 1;
  GlbFile by_mesh = square_glb();  // a mesh that the scene does not show
  by_mesh.json["meshes"].push_back(by_mesh.json["meshes"][0]);
  GlbFile by_node = square_glb();  // a node that the scene does not show
  by_node.json["nodes"].push_back({{"mesh", 0}});
  GlbFile by_image = square_glb();
  by_image.json["images"] = GlbJson::parse(R"([{"bufferView":0,"mimeType":"image/png"}])");
  GlbFile by_skin = square_glb();
  by_skin.json["skins"] = GlbJson::parse(R"([{"joints":[0],"inverseBindMatrices":0}])");
  for (GlbFile file : {as_color, as_view, shifted, by_mesh, by_node, by_image, by_skin}) {
    const ShapeFile shape = file.parse();
    const std::vector<Vec3d> positions = lifted(shape);
    const std::string written = moved(shape, positions);
    const ShapeFile back = reread(written);
    EXPECT_EQ(back.mesh.positions[2], rounded(positions[2]));
    EXPECT_EQ(bin_of(written).substr(0, 48), bin_of(shape.bytes).substr(0, 48));
    EXPECT_EQ(json_of(written)["accessors"][0], json_of(shape.bytes)["accessors"][0]);
    const Attribute* color = shape.mesh.find_attribute("color");
    if (color != nullptr) {
      EXPECT_EQ(*back.mesh.find_attribute("color"), *color);
    }
  }
}

TEST(RewriteGlb, InterleavedDataIsWrittenInPlace) {
  GlbFile file = square_glb();
  std::vector<float> numbers;
  for (int i = 0; i < 4; ++i) {
    const float x = i == 1 || i == 2 ? 1.0f : 0.0f;
    const float y = i >= 2 ? 1.0f : 0.0f;
    numbers.insert(numbers.end(), {x, y, 0, 0, 0, 1});
  }
  const std::size_t view = file.add_view(raw(numbers));
  file.json["bufferViews"][view]["byteStride"] = 24;
  for (const std::size_t i : {0u, 1u}) {
    file.accessor(i)["bufferView"] = view;
    file.accessor(i)["byteOffset"] = 12 * i;
  }
  const ShapeFile shape = file.parse();
  const std::string written = moved(shape, lifted(shape));
  EXPECT_EQ(bin_of(written).size(), bin_of(shape.bytes).size());
  EXPECT_EQ(reread(written).mesh.positions[2], rounded(lifted(shape)[2]));
}

struct Instances {
  GlbFile file = square_glb();
  Instances() {
    for (int i = 1; i < 3; ++i) {
      file.json["nodes"].push_back({{"mesh", 0}, {"translation", {8 * i, 0, 0}}});
      file.json["scenes"][0]["nodes"].push_back(i);
    }
  }
};

TEST(RewriteGlb, InstancesThatMoveAlikeStayInstances) {
  const ShapeFile shape = Instances().file.parse();
  std::vector<Vec3d> positions = shape.mesh.positions;
  for (const std::size_t i : {2u, 6u, 10u}) positions[i].z = 0.125;
  const ShapeFile back = reread(moved(shape, positions));
  EXPECT_EQ(back.mesh.positions, positions);
  EXPECT_EQ(json_of(back.bytes)["meshes"].size(), 1u);
  EXPECT_EQ(bin_of(back.bytes).size(), bin_of(shape.bytes).size());
}

TEST(RewriteGlb, InstancesThatMoveDifferentlyGetCopies) {
  const ShapeFile shape = Instances().file.parse();
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[6].z = 0.125;  // the second only: the others keep the mesh
  ShapeFile back = reread(moved(shape, positions));
  EXPECT_EQ(back.mesh.positions, positions);
  EXPECT_EQ(json_of(back.bytes)["meshes"].size(), 2u);
  EXPECT_EQ(json_of(back.bytes)["nodes"][1]["mesh"], 1);
  EXPECT_EQ(json_of(back.bytes)["nodes"][2]["mesh"], 0);
  EXPECT_EQ(bin_of(back.bytes).substr(0, bin_of(shape.bytes).size()), bin_of(shape.bytes));
  for (std::size_t i = 0; i < 3; ++i) positions[4 * i + 2].z = 0.125 * static_cast<double>(i + 1);  // all three
  back = reread(moved(shape, positions));
  EXPECT_EQ(back.mesh.positions, positions);
  EXPECT_EQ(json_of(back.bytes)["meshes"].size(), 3u);
  // And once more: now nothing is shared, and no further copies are made.
  positions[2].z = positions[6].z = 0.75;
  const ShapeFile again = reread(moved(back, positions));
  EXPECT_EQ(again.mesh.positions, positions);
  EXPECT_EQ(json_of(again.bytes)["meshes"].size(), 3u);
}

TEST(RewriteGlb, TooFarForAFloat) {
  const ShapeFile shape = square_glb().parse();
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[1].x = 1e39;
  EXPECT_THROW(moved(shape, positions), InvalidInput);
}

// Byte ranges of the binary chunk that the first accessor of a real file's POSITION, NORMAL and TANGENT may change.
std::set<std::size_t> changeable_bytes(const GlbJson& json) {
  std::set<std::size_t> bytes;
  for (const char* key : {"POSITION", "NORMAL", "TANGENT"}) {
    const GlbJson& attributes = json["meshes"][0]["primitives"][0]["attributes"];
    if (!attributes.contains(key)) continue;
    const GlbJson& accessor = json["accessors"][attributes[key].get<std::size_t>()];
    const GlbJson& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::size_t begin = view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
    const std::size_t size = accessor["count"].get<std::size_t>() * (accessor["type"] == "VEC4" ? 16 : 12);
    for (std::size_t i = 0; i < size; ++i) bytes.insert(begin + i);
  }
  return bytes;
}

TEST(RewriteGlb, RealFilesKeepEverythingElse) {
  KNEAD_NEEDS_TEST_MESH("originals");
  for (const char* file : {"originals/duck.glb", "originals/box_textured.glb", "originals/cube_vertex_colors.glb"}) {
    const ShapeFile shape = read_shape(test_mesh(file));
    std::vector<Vec3d> positions = shape.mesh.positions;
    for (std::size_t i = 0; i < positions.size() / 3; ++i) positions[i] += Vec3d{0.25, -0.5, positions[i].x};
    const std::string written = moved(shape, positions);
    const ShapeFile back = reread(written);
    const detail::gltf::Placement& placement = detail::layout_of<detail::gltf::Layout>(shape).blocks.at(0).placement;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const bool is_moved = !(positions[i] == shape.mesh.positions[i]);
      const Vec3d local = rounded(placement.inverse * (positions[i] - placement.offset));
      EXPECT_EQ(back.mesh.positions[i], is_moved ? placement.linear * local + placement.offset : positions[i]) << i;
    }
    GlbJson before = json_of(shape.bytes);
    GlbJson after = json_of(written);
    const std::string bin_before = bin_of(shape.bytes);
    const std::string bin_after = bin_of(written);
    ASSERT_EQ(bin_before.size(), bin_after.size());
    const std::set<std::size_t> changeable = changeable_bytes(before);
    for (std::size_t i = 0; i < bin_before.size(); ++i) {
      EXPECT_TRUE(bin_before[i] == bin_after[i] || changeable.count(i) > 0) << i;
    }
    const std::size_t accessor = before["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
    Vec3d least{1e9, 1e9, 1e9};
    Vec3d greatest = -least;
    for (const Vec3d& p : back.mesh.positions) {
      const Vec3d local = rounded(placement.inverse * (p - placement.offset));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        least[axis] = std::min(least[axis], local[axis]);
        greatest[axis] = std::max(greatest[axis], local[axis]);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(after["accessors"][accessor]["min"][axis].get<double>(), least[axis]);
      EXPECT_EQ(after["accessors"][accessor]["max"][axis].get<double>(), greatest[axis]);
    }
    for (GlbJson* json : {&before, &after}) {
      for (GlbJson& entry : (*json)["accessors"]) {
        entry.erase("min");
        entry.erase("max");
      }
    }
    EXPECT_EQ(before, after) << file;
  }
}

}  // namespace
}  // namespace knead::rewrite_test
