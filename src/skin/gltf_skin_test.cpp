// Skeletons, weights and animations of glTF files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "knead/error.h"
#include "knead/fit.h"
#include "knead/io.h"

namespace knead::gltf_skin_test {
namespace {

void put(std::string& bytes, float value) {
  char raw[4];
  std::memcpy(raw, &value, 4);
  bytes.append(raw, 4);
}

void put(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xffu);
}

// A triangle on two joints, the second one unit along x from the first and turned by a quarter about z within a second.
// `units`: of the skeleton, in those of the mesh.
std::string triangle(float units, const std::string& joints = "[1,2]") {
  std::string bin;
  for (const float x : {0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f, 1.f, 0.f}) put(bin, x);  // positions, 36 bytes
  for (int v = 0; v < 3; ++v) put(bin, std::uint32_t{0x0100});                      // joints 0, 1, 0, 0
  for (const auto& [a, b] : {std::pair{1.f, 0.f}, {0.f, 1.f}, {0.5f, 0.5f}}) {
    for (const float w : {a, b, 0.f, 0.f}) put(bin, w);
  }
  for (const float at : {0.f, -1.f}) {  // inverse bind matrices by columns
    for (const float m : {1.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, at, 0.f, 0.f, 1.f}) put(bin, m);
  }
  for (const float t : {0.f, 1.f}) put(bin, t);
  const float half = std::sqrt(0.5f);
  for (const float q : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, half, half}) put(bin, q);
  const auto view = [](int begin, int size) {
    return R"({"buffer":0,"byteOffset":)" + std::to_string(begin) + R"(,"byteLength":)" + std::to_string(size) + "}";
  };
  const std::string unit = std::to_string(units);
  std::string json = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"skin":0},)"
                     R"({"name":"a","children":[2],"scale":[)" +
                     unit + "," + unit + "," + unit + R"(]},)" +
                     R"({"name":"b","translation":[1,0,0]}],)"
                     R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],)"
                     R"("skins":[{"joints":)" +
                     joints +
                     R"(,"inverseBindMatrices":3}],)"
                     R"("animations":[{"samplers":[{"input":4,"output":5}],)"
                     R"("channels":[{"sampler":0,"target":{"node":2,"path":"rotation"}}]}],)"
                     R"("accessors":[)"
                     R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[2,1,0]},)"
                     R"({"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},)"
                     R"({"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"},)"
                     R"({"bufferView":3,"componentType":5126,"count":2,"type":"MAT4"},)"
                     R"({"bufferView":4,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},)"
                     R"({"bufferView":5,"componentType":5126,"count":2,"type":"VEC4"}],)"
                     R"("bufferViews":[)" +
                     view(0, 36) + "," + view(36, 12) + "," + view(48, 48) + "," + view(96, 128) + "," + view(224, 8) +
                     "," + view(232, 32) + R"(],"buffers":[{"byteLength":264}]})";
  while (json.size() % 4 != 0) json += ' ';
  std::string file = "glTF";
  put(file, std::uint32_t{2});
  put(file, static_cast<std::uint32_t>(28 + json.size() + bin.size()));
  put(file, static_cast<std::uint32_t>(json.size()));
  file += "JSON" + json;
  put(file, static_cast<std::uint32_t>(bin.size()));
  return file + std::string("BIN\0", 4) + bin;
}

ShapeFile shape_of(const std::string& bytes) { return parse_shape(bytes, "glb", "t.glb"); }

void expect_near(const Vec3d& a, const Vec3d& b) { EXPECT_LT(norm(a - b), 1e-6) << a.x << " " << a.y << " " << a.z; }

TEST(GltfSkin, ReadsBonesWeightsAndAnimation) {
  const ShapeFile shape = shape_of(triangle(1));
  const SkinFile file = read_skin(shape);
  EXPECT_EQ(file.skin.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(file.skin.parents, (std::vector<std::int32_t>{-1, 0}));
  EXPECT_EQ(file.duration, 1);
  EXPECT_EQ(file.animations.size(), 1u);
  expect_near(file.skin.rest[1].offset, {1, 0, 0});
  for (std::size_t v = 0; v < 3; ++v) {
    expect_near(linear_blend(shape.mesh.positions, file.skin, file.pose)[v], shape.mesh.positions[v]);
  }
  // At half the time the second bone has turned by 45 degrees about its origin, at the end and later by 90.
  const double half = std::sqrt(0.5);
  expect_near(linear_blend(shape.mesh.positions, file.skin, file.at(0.5))[1], {1 + half, half, 0});
  expect_near(linear_blend(shape.mesh.positions, file.skin, file.at(1))[1], {1, 1, 0});
  expect_near(linear_blend(shape.mesh.positions, file.skin, file.at(9))[1], {1, 1, 0});
}

// A skeleton in centimetres over a mesh in metres does not scale the mesh.
TEST(GltfSkin, ACommonScaleOfTheSkeletonIsTakenOut) {
  const ShapeFile shape = shape_of(triangle(100));
  const SkinFile file = read_skin(shape);
  expect_near(linear_blend(shape.mesh.positions, file.skin, file.at(1))[1], {1, 1, 0});
}

TEST(GltfSkin, SaysWhatIsMissing) {
  EXPECT_THROW(read_skin(shape_of(triangle(1)), 3), InvalidInput);
  EXPECT_THROW(read_skin(shape_of(triangle(1, "[1]"))), InvalidInput);  // the weights name a second joint
  ShapeFile plain;
  plain.format = "ply";
  EXPECT_THROW(read_skin(plain), InvalidInput);
}

TEST(GltfSkin, SaysWhatIsWrongWithWeights) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string bytes = triangle(1);
    return bytes.replace(bytes.find(from), from.size(), to);
  };
  const auto complaint = [](const std::string& bytes) -> std::string {
    try {
      read_skin(shape_of(bytes));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(complaint(changed("WEIGHTS_0", "_EIGHTS_0")).find("JOINTS_0 without WEIGHTS_0"), std::string::npos);
  EXPECT_NE(complaint(changed("JOINTS_0", "_OINTS_0")).find("WEIGHTS_0 without JOINTS_0"), std::string::npos);
  EXPECT_NE(complaint(changed(R"("JOINTS_0":1,"WEIGHTS_0":2)", R"("_OINTS_0":1,"_EIGHTS_0":2)")).find("no JOINTS_0"),
            std::string::npos);
  const std::string file = triangle(1);
  const std::size_t weights = file.size() - 264 + 48;
  const auto with_weights = [&](const std::vector<float>& of_all) {
    std::string bytes;
    for (const float w : of_all) put(bytes, w);
    return std::string(file).replace(weights, bytes.size(), bytes);
  };
  EXPECT_NE(complaint(with_weights({NAN})).find("has the weight nan"), std::string::npos);
  EXPECT_NE(complaint(with_weights({INFINITY})).find("has the weight inf"), std::string::npos);
  EXPECT_NE(complaint(with_weights({-1})).find("has the weight -1"), std::string::npos);
  EXPECT_NE(complaint(with_weights(std::vector<float>(12, 0.f))).find("all 0"), std::string::npos);
  const SkinFile one = read_skin(shape_of(with_weights({0})));
  ASSERT_EQ(one.notes.size(), 1u);
  EXPECT_NE(one.notes[0].find("1 of 3 vertices of a mesh have no weight"), std::string::npos);
}

TEST(GltfSkin, MorphTargetsAsTextAreTheSame) {
  const ShapeFile shape = shape_of(triangle(1));
  MorphTargets targets;
  targets.shapes = {shape.mesh.positions};
  targets.shapes[0][2] += Vec3d{0, 0, 0.25};
  targets.weights = {0};
  const ShapeFile text = parse_shape(serialize_morphed(shape, targets, "gltf"), "gltf", "t.gltf");
  EXPECT_EQ(text.mesh.positions, shape.mesh.positions);
  EXPECT_EQ(read_skin(text).skin.names, read_skin(shape).skin.names);
  EXPECT_NE(text.bytes.find("\"targets\""), std::string::npos);
  EXPECT_EQ(serialize_morphed(shape, {}), shape.bytes);  // without any the file stays as it is
}

TEST(GltfSkin, MorphTargetsKeepTheSkeletonAndJoinItsAnimation) {
  const ShapeFile shape = shape_of(triangle(1));
  MorphTargets targets;
  targets.shapes = {shape.mesh.positions};
  targets.shapes[0][2] += Vec3d{0, 0, 0.25};
  targets.names = {"corrective"};
  targets.weights = {0};
  targets.times = {0, 1};
  targets.keys = {0, 1};
  const std::string bytes = serialize_morphed(shape, targets);
  const ShapeFile again = shape_of(bytes);
  EXPECT_EQ(again.mesh.positions, shape.mesh.positions);
  EXPECT_EQ(read_skin(again).skin.names.size(), 2u);
  EXPECT_EQ(read_skin(again).animations.size(), 1u);
  EXPECT_NE(bytes.find(R"("path":"weights")"), std::string::npos);
  EXPECT_NE(bytes.find(R"("targetNames":["corrective"])"), std::string::npos);
  targets.keys.pop_back();
  EXPECT_THROW(serialize_morphed(shape, targets), InvalidInput);
  targets.keys.push_back(1);
  EXPECT_THROW(serialize_morphed(again, targets), InvalidInput);  // it has targets of its own
}

}  // namespace
}  // namespace knead::gltf_skin_test
