// What the writers of animations write.
#include "knead/io.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "io/test_samples.h"
#include "io/text.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "math/system.h"
#include "support/test_meshes.h"

namespace knead::animation_test {
namespace {

namespace fs = std::filesystem;

constexpr double kFps = 25;

class Animation : public testing::Test {
 protected:
  Animation() : folder_(fs::temp_directory_path() / fmt::format("knead_animation_{}", ::getpid())) {
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Of a shape: it rests, moves for three frames from one vertex on, and rests again.
  static std::vector<std::vector<Vec3d>> frames_of(const ShapeFile& shape, std::size_t first_moved) {
    std::vector<std::vector<Vec3d>> frames(6, shape.mesh.positions);
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const double t = std::min<double>(static_cast<double>(k), 3);
      for (std::size_t v = first_moved; v < frames[k].size(); ++v) {
        frames[k][v] += Vec3d{0.1 * t, 0.03 * t * frames[k][v].x, 0.07};
      }
    }
    return frames;
  }

  std::string written(const ShapeFile& shape, const std::vector<std::vector<Vec3d>>& frames, const char* name) const {
    AnimationFile file(folder_ / name, shape, {static_cast<int>(frames.size()), kFps});
    for (const std::vector<Vec3d>& frame : frames) {
      EXPECT_FALSE(fs::exists(folder_ / name));
      file.add(frame);
    }
    file.finish();
    return file_bytes(folder_ / name);
  }

  fs::path folder_;
};

ShapeFile ball() { return parse_shape(serialize_mesh("ply", make_shape(ShapeKind::sphere, 162)), "ply", "ball.ply"); }

void expect_floats(detail::ByteCursor& cursor, const std::vector<std::vector<Vec3d>>& frames) {
  for (const std::vector<Vec3d>& frame : frames) {
    for (const Vec3d& p : frame) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(cursor.take<float>("a coordinate"), static_cast<float>(p[axis]));
      }
    }
  }
  EXPECT_EQ(cursor.left(), 0U);
}

TEST_F(Animation, Pc2HoldsEveryFrame) {
  const ShapeFile shape = ball();
  const auto frames = frames_of(shape, 40);
  const std::string bytes = written(shape, frames, "a.pc2");
  const std::string name = "a.pc2";
  detail::ByteCursor cursor(bytes, name, std::endian::little);
  EXPECT_EQ(cursor.take_bytes(12, "the mark"), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(cursor.take<std::int32_t>("the version"), 1);
  EXPECT_EQ(cursor.take<std::int32_t>("the points"), static_cast<int>(shape.mesh.vertex_count()));
  EXPECT_EQ(cursor.take<float>("the start"), 0);
  EXPECT_EQ(cursor.take<float>("the rate"), 1);
  EXPECT_EQ(cursor.take<std::int32_t>("the samples"), 6);
  expect_floats(cursor, frames);
}

TEST_F(Animation, MddHoldsEveryFrameAndItsTime) {
  const ShapeFile shape = ball();
  const auto frames = frames_of(shape, 40);
  const std::string bytes = written(shape, frames, "a.MDD");
  const std::string name = "a.mdd";
  detail::ByteCursor cursor(bytes, name, std::endian::big);
  EXPECT_EQ(cursor.take<std::int32_t>("the frames"), 6);
  EXPECT_EQ(cursor.take<std::int32_t>("the points"), static_cast<int>(shape.mesh.vertex_count()));
  for (int k = 0; k < 6; ++k) EXPECT_EQ(cursor.take<float>("a time"), static_cast<float>(k / kFps));
  expect_floats(cursor, frames);
}

// The numbers of an accessor, as a viewer reads them.
std::vector<float> numbers_of(const GlbJson& json, const std::string& bin, std::size_t index) {
  const GlbJson& accessor = json["accessors"][index];
  const std::size_t components = accessor["type"] == "SCALAR" ? 1 : 3;
  const auto floats = [&](std::size_t view, std::size_t count) {
    std::vector<float> values(count);
    const std::size_t offset = json["bufferViews"][view].value("byteOffset", 0);
    std::memcpy(values.data(), bin.data() + offset, count * sizeof(float));
    return values;
  };
  const std::size_t count = accessor["count"].get<std::size_t>() * components;
  std::vector<float> values(count);
  if (accessor.contains("bufferView")) values = floats(accessor["bufferView"], count);
  if (!accessor.contains("sparse")) return values;
  const GlbJson& sparse = accessor["sparse"];
  const std::size_t changed = sparse["count"];
  const std::vector<float> replaced = floats(sparse["values"]["bufferView"], changed * components);
  const bool is_short = sparse["indices"]["componentType"] == 5123;
  const std::size_t offset = json["bufferViews"][sparse["indices"]["bufferView"].get<std::size_t>()]["byteOffset"];
  for (std::size_t i = 0; i < changed; ++i) {
    std::uint32_t at = 0;
    std::memcpy(&at, bin.data() + offset + i * (is_short ? 2 : 4), is_short ? 2 : 4);
    std::copy_n(&replaced[i * components], components, &values[at * components]);
  }
  return values;
}

// What a viewer shows in a frame of a primitive: the attribute, and the weighted targets.
std::vector<float> shown(const GlbJson& json, const std::string& bin, const GlbJson& primitive, const char* key,
                         std::size_t frame) {
  const GlbJson& sampler = json["animations"].back()["samplers"][0];
  std::vector<float> values = numbers_of(json, bin, primitive["attributes"][key]);
  const std::vector<float> weights = numbers_of(json, bin, sampler["output"]);
  const GlbJson& targets = primitive["targets"];
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const std::vector<float> target = numbers_of(json, bin, targets[t][key]);
    const float weight = weights[frame * targets.size() + t];
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += weight * target[i];
  }
  return values;
}

TEST_F(Animation, GlbShowsEveryFrame) {
  const ShapeFile shape = ball();
  for (const std::size_t first_moved : {20U, 140U}) {  // most of the vertices, and few
    const auto frames = frames_of(shape, first_moved);
    const std::string bytes = written(shape, frames, "a.glb");
    fs::remove(folder_ / "a.glb");
    const GlbJson json = json_of(bytes);
    const std::string bin = bin_of(bytes);
    const GlbJson& primitive = json["meshes"][0]["primitives"][0];
    EXPECT_EQ(primitive["targets"].size(), 3U);  // the last three frames are one
    EXPECT_EQ(json["accessors"][primitive["targets"][0]["POSITION"].get<std::size_t>()].contains("sparse"),
              first_moved == 140);
    const GlbJson& sampler = json["animations"][0]["samplers"][0];
    const std::vector<float> times = numbers_of(json, bin, sampler["input"]);
    ASSERT_EQ(times.size(), 6U);
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_EQ(times[k], static_cast<float>(static_cast<double>(k) / kFps));
      const std::vector<float> now = shown(json, bin, primitive, "POSITION", k);
      for (std::size_t i = 0; i < now.size(); ++i) ASSERT_NEAR(now[i], frames[k][i / 3][i % 3], 2e-7);
      const std::vector<float> normals = shown(json, bin, primitive, "NORMAL", k);
      for (std::size_t i = 0; i < normals.size(); i += 3) {
        ASSERT_NEAR(std::hypot(normals[i], normals[i + 1], normals[i + 2]), 1, 1e-6);
      }
    }
    EXPECT_EQ(parse_shape(bytes, "glb", "a.glb").mesh.positions.size(), shape.mesh.positions.size());
  }
}

// A square that two nodes place, one of them turned and scaled, with a material.
GlbFile two_squares() {
  GlbFile file = square_glb();
  file.json["materials"] = GlbJson::array({{{"name", "clay"}}});
  file.primitive()["material"] = 0;
  file.json["nodes"] = GlbJson::array(
      {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {5, 0, 0}}, {"scale", {2, 2, 2}}, {"rotation", {0, 0, 0.6, 0.8}}}});
  file.json["scenes"][0]["nodes"] = {0, 1};
  return file;
}

TEST_F(Animation, AGlbKeepsItsMaterialsAndNodes) {
  const ShapeFile shape = two_squares().parse();
  ASSERT_EQ(shape.mesh.vertex_count(), 8U);
  const auto frames = frames_of(shape, 2);
  const std::string bytes = written(shape, frames, "a.glb");
  const GlbJson json = json_of(bytes);
  EXPECT_EQ(json["materials"][0]["name"], "clay");
  const std::string bin = bin_of(bytes);
  const GlbJson& channels = json["animations"][0]["channels"];
  ASSERT_EQ(channels.size(), 2U);
  for (std::size_t node = 0; node < 2; ++node) {
    EXPECT_EQ(channels[node]["target"]["node"], node);
    const GlbJson& primitive = json["meshes"][json["nodes"][node]["mesh"].get<std::size_t>()]["primitives"][0];
    EXPECT_EQ(primitive["material"], 0);
    for (std::size_t k = 0; k < 6; ++k) {
      const std::vector<float> local = shown(json, bin, primitive, "POSITION", k);
      for (std::size_t v = 0; v < 4; ++v) {
        Vec3d p{local[3 * v], local[3 * v + 1], local[3 * v + 2]};
        // The rotation about z has the cosine 0.28 and the sine 0.96.
        if (node == 1) p = Vec3d{0.28 * p.x - 0.96 * p.y, 0.96 * p.x + 0.28 * p.y, p.z} * 2 + Vec3d{5, 0, 0};
        ASSERT_NEAR(norm(p - frames[k][4 * node + v]), 0, 2e-6) << node << " " << k << " " << v;
      }
    }
  }
}

TEST_F(Animation, MorphTargetsOfAnotherAnimationAreNotReplaced) {
  GlbFile file = square_glb();
  file.primitive()["targets"] = GlbJson::array({{{"POSITION", 0}}});
  const ShapeFile shape = file.parse();
  try {
    written(shape, frames_of(shape, 2), "a.glb");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("morph targets of its own"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

// The tuples of a time sample of a USD file.
std::vector<float> sample(const std::string& text, const std::string& attribute, int frame) {
  const std::size_t begin = text.find(attribute + ".timeSamples");
  const std::size_t from = text.find(fmt::format("\n        {}: [", frame), begin) + 1;
  std::string line = text.substr(from, text.find('\n', from) - from);
  line = line.substr(line.find('['));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return std::string_view("[](),").find(c) != std::string::npos; }, ' ');
  std::istringstream words(line);
  std::vector<float> values;
  for (float value = 0; words >> value;) values.push_back(value);
  return values;
}

TEST_F(Animation, UsdHoldsEveryFrame) {
  const ShapeFile shape = ball();
  const auto frames = frames_of(shape, 40);
  const std::string text = written(shape, frames, "a.usda");
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  EXPECT_NE(text.find("endTimeCode = 5\n"), std::string::npos);
  EXPECT_NE(text.find("timeCodesPerSecond = 25\n"), std::string::npos);
  EXPECT_EQ(std::count(text.begin(), text.end(), '{'), std::count(text.begin(), text.end(), '}'));
  for (int k = 0; k < 6; ++k) {
    const std::vector<Vec3d>& frame = frames[static_cast<std::size_t>(k)];
    const std::vector<float> points = sample(text, "points", k);
    ASSERT_EQ(points.size(), 3 * frame.size());
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(points[i], static_cast<float>(frame[i / 3][i % 3]));
    EXPECT_EQ(sample(text, "normals", k).size(), points.size());
    EXPECT_EQ(sample(text, "extent", k)[5],
              static_cast<float>(std::max_element(frame.begin(), frame.end(), [](const Vec3d& a, const Vec3d& b) {
                                   return a.z < b.z;
                                 })->z));
  }
}

TEST_F(Animation, ParaViewsSeriesHoldsEveryFrame) {
  const ShapeFile shape = ball();
  const auto frames = frames_of(shape, 40);
  const std::string text = written(shape, frames, "a.pvd");
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NE(
        text.find(fmt::format("timestep=\"{}\" part=\"0\" file=\"a_{:04}.vtp\"", static_cast<double>(k) / kFps, k)),
        std::string::npos);
    const std::string bytes = file_bytes(folder_ / fmt::format("a_{:04}.vtp", k));
    const std::size_t points = bytes.find("Name=\"Points\"");
    const std::size_t offset = std::stoul(bytes.substr(bytes.find("offset=\"", points) + 8));
    const std::size_t data = bytes.find('_', bytes.find("<AppendedData")) + 1 + offset;
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + data, sizeof size);
    ASSERT_EQ(size, frames[k].size() * sizeof(Vec3d));
    EXPECT_EQ(std::memcmp(bytes.data() + data + sizeof size, frames[k].data(), size), 0);
  }
}

TEST_F(Animation, PointCloudsAreWritten) {
  const ShapeFile cloud = parse_shape("0 0 0\n1 0 0\n0 1 0\n0 0 1\n", "xyz", "a.xyz");
  for (const char* name : {"a.pc2", "a.mdd", "a.glb", "a.usda", "a.pvd"}) {
    EXPECT_GT(written(cloud, frames_of(cloud, 1), name).size(), 100U) << name;
  }
}

TEST_F(Animation, WithoutAnEndNothingIsWritten) {
  const ShapeFile shape = ball();
  for (const char* name : {"a.pc2", "a.mdd", "a.glb", "a.usda", "a.pvd"}) {
    AnimationFile file(folder_ / name, shape, {2, kFps});
    file.add(shape.mesh.positions);
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Animation, RefusesWhatItCannotWrite) {
  const ShapeFile shape = ball();
  EXPECT_THROW(AnimationFile(folder_ / "a.pc2", shape, {0, kFps}), InvalidInput);
  EXPECT_THROW(AnimationFile(folder_ / "a.pc2", shape, {2, 0}), InvalidInput);
  EXPECT_THROW(AnimationFile(folder_ / "a.ply", shape, {2, kFps}), InvalidInput);
  EXPECT_THROW(AnimationFile(folder_ / "no" / "a.pc2", shape, {2, kFps}), IoError);
  std::vector<Vec3d> far = shape.mesh.positions;
  far[3].x = 1e300;
  for (const char* name : {"a.pc2", "a.mdd", "a.glb", "a.usda"}) {
    AnimationFile file(folder_ / name, shape, {2, kFps});
    EXPECT_THROW(file.add(far), InvalidInput) << name;
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

// Programs read the objects of an OBJ file as meshes of their own, and leave out vertices without faces; then no cache
// of all positions fits.
TEST(AnimationLosses, NoAdviceIsGivenThatCannotWork) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto loss = [&](const std::string& faces, const char* path) {
    const std::vector<std::string> losses = animation_losses(path, parse_shape(triangle + faces, "obj", "a.obj"));
    return losses.empty() ? std::string() : losses.front();
  };
  for (const char* path : {"a.pc2", "a.mdd"}) {
    EXPECT_NE(loss("o one\nf 1 2 3\n", path).find("import the shape from obj first"), std::string::npos);
    EXPECT_NE(loss("o one\nf 1 2 3\no two\nf 1 3 2\n", path).find("2 objects"), std::string::npos);
    const std::string loose = loss("v 5 5 5\nf 1 2 3\n", path);
    EXPECT_NE(loose.find("no face uses"), std::string::npos) << loose;
    EXPECT_EQ(loose.find("import"), std::string::npos) << loose;
  }
}

}  // namespace
}  // namespace knead::animation_test
