// Gaussian splats in glTF files.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>

#include "io/codec.h"
#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "math/geometry.h"
#include "support/scratch.h"

namespace knead::gltf_splats_test {
namespace {

constexpr const char* kBend =
    R"({"knead": 1}
{"tool": "bend", "center": [0,0,0], "axis": [0,1,0], "normal": [0,0,1], "width": 1, "angle_deg": 40}
)";
const std::string kKey = "KHR_gaussian_splatting:";

double value(const Mesh& mesh, const std::string& name, std::size_t i) { return mesh.find_attribute(name)->values[i]; }

// As a file of the usual tools has them: no unit quaternions, room for normals, an attribute of its own.
Mesh random_splats(std::size_t count, std::size_t degree) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  Mesh mesh;
  for (std::size_t i = 0; i < count; ++i) mesh.positions.push_back({number(random), number(random), number(random)});
  for (Vec3d& p : mesh.positions) p = Vec3d(Vec3f(p));
  const auto add = [&](const std::string& name, double middle, double width = 1) {
    Attribute& attribute = mesh.attributes.emplace_back(Attribute{name, Domain::vertex, NumberType::float32, 1, {}});
    for (std::size_t i = 0; i < count; ++i) {
      attribute.values.push_back(double{static_cast<float>(middle + width * number(random))});
    }
  };
  mesh.attributes.push_back({"normal", Domain::vertex, NumberType::float32, 3, std::vector<double>(3 * count)});
  for (int k = 0; k < 3; ++k) add(fmt::format("f_dc_{}", k), 0);
  for (std::size_t k = 0; k < 3 * degree * (degree + 2); ++k) add(fmt::format("f_rest_{}", k), 0, 0.3);
  add("opacity", 0.5, 3);
  for (int k = 0; k < 3; ++k) add(fmt::format("scale_{}", k), -4, 2);
  for (int k = 0; k < 4; ++k) add(fmt::format("rot_{}", k), 0);
  add("label", 5);
  return mesh;
}

ShapeFile as_ply(const Mesh& mesh) { return parse_shape(serialize_mesh("ply", mesh), "ply", "capture.ply"); }
ShapeFile as_glb(const Mesh& mesh) { return parse_shape(serialize_mesh("glb", mesh), "glb", "capture.glb"); }

// A file whose JSON and binary chunk may be changed.
GlbFile opened(const ShapeFile& shape) {
  GlbFile file;
  file.json = json_of(shape.bytes);
  file.bin = bin_of(shape.bytes);
  return file;
}

Mat3d covariance(const Mesh& mesh, std::size_t i) {
  std::array<double, 4> turn{};
  for (std::size_t k = 0; k < 4; ++k) turn[k] = value(mesh, fmt::format("rot_{}", k), i);
  const std::array<Vec3d, 3> axes = splat_axes(turn);
  Mat3d sum{{}, {}, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    sum = sum + outer_product(axes[k], axes[k]) * std::exp(2 * value(mesh, fmt::format("scale_{}", k), i));
  }
  return sum;
}

// Red, green and blue without their part of degree 0.
Vec3d color(const Mesh& mesh, std::size_t i, const Vec3d& direction) {
  const std::array<double, 15> y = splat_harmonics(direction);
  const std::size_t count = splat_degree(mesh) * (splat_degree(mesh) + 2);
  Vec3d sum;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < count; ++k) sum[c] += y[k] * value(mesh, fmt::format("f_rest_{}", c * count + k), i);
  }
  return sum;
}

double difference(const Mat3d& a, const Mat3d& b) {
  const Mat3d d = a + b * -1.0;
  const auto size2 = [](const Mat3d& m) { return norm2(m.row0) + norm2(m.row1) + norm2(m.row2); };
  return std::sqrt(size2(d) / size2(b));
}

// Relative errors, of floats.
void expect_same_splats(const Mesh& found, const Mesh& expected, double tolerance = 3e-6) {
  ASSERT_EQ(found.vertex_count(), expected.vertex_count());
  ASSERT_EQ(splat_degree(found), splat_degree(expected));
  for (std::size_t i = 0; i < expected.vertex_count(); ++i) {
    EXPECT_LT(norm(found.positions[i] - expected.positions[i]), tolerance) << i;
    EXPECT_LT(difference(covariance(found, i), covariance(expected, i)), tolerance) << i;
    EXPECT_NEAR(value(found, "opacity", i), value(expected, "opacity", i), 1e-4 + tolerance) << i;
    EXPECT_NEAR(value(found, "f_dc_1", i), value(expected, "f_dc_1", i), 1e-6) << i;
    const Vec3d direction = normalized(Vec3d{0.3, -0.5, 0.7});
    EXPECT_LT(norm(color(found, i, direction) - color(expected, i, direction)), 2e-6) << i;
  }
}

ShapeFile bent(ShapeFile shape, std::size_t max_splats = 0) {
  const Session session = parse_session(kBend, "bend.knead");
  split_splats(shape, session, {}, max_splats);
  const ReplayResult result = replay(borrow(shape.mesh), session);
  EXPECT_EQ(result.status, AdvectStatus::done);
  return parse_shape(serialize_deformed(shape.format, shape, result.shape), shape.format, "bent." + shape.format);
}

TEST(GltfSplats, AreWrittenAndReadAsInPly) {
  for (const std::size_t degree : {0, 1, 2, 3}) {
    const Mesh mesh = random_splats(20, degree);
    const ShapeFile shape = as_glb(mesh);
    EXPECT_TRUE(are_splats(shape.mesh));
    EXPECT_EQ(shape.notes.back(), fmt::format("Gaussian splats with spherical harmonics of degree {}", degree));
    expect_same_splats(shape.mesh, mesh);
    EXPECT_NE(animation_losses("a.glb", shape).back().find("only the centres"), std::string::npos);
    const GlbJson json = json_of(shape.bytes);
    const GlbJson& primitive = json["meshes"][0]["primitives"][0];
    EXPECT_EQ(json["extensionsUsed"], GlbJson::parse(R"(["KHR_gaussian_splatting"])"));
    EXPECT_EQ(primitive["extensions"]["KHR_gaussian_splatting"]["kernel"], "ellipse");
    EXPECT_EQ(primitive["mode"], 0);
    EXPECT_EQ(primitive["attributes"].size(), 5 + (degree + 1) * (degree + 1));  // POSITION and _LABEL, no NORMAL
    const auto floats = [&](const std::string& key) {
      const GlbJson& view = json["bufferViews"][primitive["attributes"][kKey + key].get<std::size_t>()];
      std::vector<float> numbers(view["byteLength"].get<std::size_t>() / sizeof(float));
      std::memcpy(numbers.data(), bin_of(shape.bytes).data() + view["byteOffset"].get<std::size_t>(),
                  view["byteLength"].get<std::size_t>());
      return numbers;
    };
    const double w = value(mesh, "rot_0", 1);
    double size2 = w * w;
    for (int k = 1; k < 4; ++k) size2 += std::pow(value(mesh, fmt::format("rot_{}", k), 1), 2);
    EXPECT_NEAR(floats("ROTATION")[7], w / std::sqrt(size2), 1e-6);
    EXPECT_NEAR(floats("SCALE")[5], std::exp(value(mesh, "scale_2", 1)), 1e-7);
    EXPECT_NEAR(floats("OPACITY")[1], 1 / (1 + std::exp(-value(mesh, "opacity", 1))), 1e-6);
    if (degree == 3) {  // degree 2: 1, -1, 1, -1, 1 ... green of the last of degree 2
      EXPECT_EQ(double{floats("SH_DEGREE_2_COEF_4")[4]}, value(mesh, "f_rest_22", 1));
    }
  }
}

TEST(GltfSplats, BendAsThoseOfPly) {
  for (const std::size_t degree : {0, 3}) {
    const Mesh mesh = random_splats(300, degree);
    const Mesh whole = bent(as_ply(mesh)).mesh;
    expect_same_splats(bent(as_glb(mesh)).mesh, whole);
    EXPECT_GT(difference(covariance(whole, 0), covariance(mesh, 0)), 1e-3);
    const ShapeFile split = bent(as_glb(mesh), 10'000);
    EXPECT_GT(split.mesh.vertex_count(), mesh.vertex_count());
    const Mesh expected = bent(as_ply(mesh), 10'000).mesh;
    ASSERT_EQ(split.mesh.vertex_count(), expected.vertex_count());
    const auto mean = [](const Mesh& of) {  // pieces may come in another order
      Vec3d sum;
      for (std::size_t i = 0; i < of.vertex_count(); ++i) {
        sum += of.positions[i] + Vec3d{value(of, "opacity", i), value(of, "scale_1", i), value(of, "f_dc_2", i)};
      }
      return sum / static_cast<double>(of.vertex_count());
    };
    EXPECT_LT(norm(mean(split.mesh) - mean(expected)), 1e-4);
    const GlbJson json = json_of(split.bytes);
    const std::size_t label = json["meshes"][0]["primitives"][0]["attributes"]["_LABEL"];
    EXPECT_EQ(json["accessors"][label]["count"], split.mesh.vertex_count());
  }
}

// Nodes over nodes, one of them a mirror: covariances by M S M^T, colours as seen along turned directions.
TEST(GltfSplats, FollowTheirNodes) {
  const Mesh mesh = random_splats(40, 3);
  for (const double x : {2.0, -2.0}) {
    GlbFile file = opened(as_glb(mesh));
    file.json["nodes"] = GlbJson::parse(R"([{"children": [1], "scale": [1, 1, 1], "translation": [1, 2, 3]},
        {"mesh": 0, "rotation": [0.5, 0.1, -0.7, 0.5], "scale": [3, 0.5, 0.25]}])");
    file.json["nodes"][0]["scale"][0] = x;
    const ShapeFile shape = file.parse();
    const Mat3d& linear = detail::layout_of<detail::gltf::Layout>(shape).blocks[0].placement.linear;
    const double side = x < 0 ? -1 : 1;
    const Mat3d rotation = nearest_rotation(linear * side);
    for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
      const Mat3d expected = linear * covariance(mesh, i) * transposed(linear);
      EXPECT_LT(difference(covariance(shape.mesh, i), expected), 3e-6);
      const Vec3d direction = normalized(Vec3d{0.2, 0.9, -0.3});
      EXPECT_LT(norm(color(shape.mesh, i, rotation * direction * side) - color(mesh, i, direction)), 1e-6);
    }
    // The same bend, seen from the world.
    const Mesh expected = bent(as_ply(shape.mesh)).mesh;
    expect_same_splats(bent(shape).mesh, expected, 2e-5);
  }
}

// Quantized and sparse numbers, one splat that moves: the others keep what they had.
TEST(GltfSplats, OthersKeepTheirNumbers) {
  GlbFile file = opened(as_glb(random_splats(3, 1)));
  GlbJson& attributes = file.primitive()["attributes"];
  attributes[kKey + "ROTATION"] =
      file.add<std::int16_t>(5122, "VEC4", 4, {32767, 0, 0, 0, 0, 23170, 23170, 0, -32767, 0, 0, 0});
  file.json["accessors"].back()["normalized"] = true;
  attributes[kKey + "SCALE"] = file.add<std::uint16_t>(5123, "VEC3", 4, {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0});
  file.json["bufferViews"].back()["byteStride"] = 8;
  attributes[kKey + "OPACITY"] = file.add<std::uint8_t>(5121, "SCALAR", 1, {0, 51, 255});
  file.json["accessors"].back()["normalized"] = true;
  const std::size_t dense = attributes[kKey + "SH_DEGREE_1_COEF_1"];
  const std::size_t indices = file.add_view(raw(std::vector<std::uint8_t>{1}));
  const std::size_t values = file.add_view(raw(std::vector<float>{7, 8, 9}));
  file.accessor(dense)["sparse"] = {{"count", 1},
                                    {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                    {"values", {{"bufferView", values}}}};
  file.json["extras"] = {{"kept", true}};
  const ShapeFile shape = file.parse();
  EXPECT_NEAR(value(shape.mesh, "rot_3", 1), 0.7071, 1e-4);
  EXPECT_NEAR(value(shape.mesh, "scale_2", 2), std::log(9), 1e-12);
  EXPECT_NEAR(value(shape.mesh, "opacity", 1), std::log(0.25), 1e-6);
  EXPECT_EQ(value(shape.mesh, "f_rest_4", 1), 8);
  EXPECT_EQ(serialize_shape("glb", shape, shape.mesh.positions), shape.bytes);
  const ChangedSplats changed = deformed_splats(shape.mesh, {{1}, {Mat3d{{1, 0.5, 0}, {0, 1, 0}, {0, 0, 1}}}});
  const ShapeFile back = parse_shape(serialize_shape("glb", shape, shape.mesh.positions,
                                                     {.attributes = changed.attributes, .changed = changed.splats}),
                                     "glb", "written.glb");
  GlbJson json = json_of(back.bytes);
  const GlbJson& now = json["meshes"][0]["primitives"][0]["attributes"];
  for (const char* key : {"POSITION", "_LABEL"}) EXPECT_EQ(now[key], attributes[key]);
  for (const char* key : {"OPACITY", "SH_DEGREE_0_COEF_0"}) EXPECT_EQ(now[kKey + key], attributes[kKey + key]);
  for (const char* key : {"ROTATION", "SCALE", "SH_DEGREE_1_COEF_1"}) {
    EXPECT_EQ(json["accessors"][now[kKey + key].get<std::size_t>()]["componentType"], 5126) << key;
  }
  EXPECT_EQ(json["extras"], file.json["extras"]);
  EXPECT_EQ(bin_of(back.bytes).substr(file.bin.size() - 12, 12), file.bin.substr(file.bin.size() - 12));
  for (const Attribute& attribute : changed.attributes) {
    EXPECT_NEAR(value(back.mesh, attribute.name, 1), attribute.values[0], 2e-6 * std::abs(attribute.values[0]) + 1e-7)
        << attribute.name;
    for (const std::size_t i : {0, 2}) {
      EXPECT_EQ(value(back.mesh, attribute.name, i), value(shape.mesh, attribute.name, i)) << attribute.name;
    }
  }
}

// One mesh at two nodes and a mesh with faces: all follow the flow, also remeshed.
TEST(GltfSplats, BesideAMeshAndTwice) {
  const Mesh mesh = random_splats(30, 2);
  GlbFile file = opened(as_glb(mesh));
  GlbJson& json = file.json;
  json["nodes"].push_back(GlbJson::parse(R"({"mesh": 0, "translation": [0.25, 0, 0], "scale": [1, 2, 1]})"));
  const ShapeFile twice = [&] {
    GlbFile copy = file;
    copy.json["scenes"][0]["nodes"] = {0, 1};
    return copy.parse();
  }();
  expect_same_splats(bent(twice).mesh, bent(as_ply(twice.mesh)).mesh, 2e-5);
  ShapeFile whole = twice;
  std::vector<std::string> notes;
  EXPECT_FALSE(split_splats(whole, parse_session(kBend, "bend.knead"), {}, 10'000, &notes));
  EXPECT_NE(notes.at(0).find("are not split"), std::string::npos);

  const std::size_t positions = file.add_vec3({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0});
  const std::size_t indices = file.add<std::uint16_t>(5123, "SCALAR", 1, {0, 1, 2, 0, 2, 3});
  json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}});
  json["nodes"].push_back({{"mesh", 1}});
  json["scenes"][0]["nodes"] = {2, 1};
  const ShapeFile mixed = file.parse();
  EXPECT_FALSE(are_splats(mixed.mesh));
  EXPECT_TRUE(have_splats(mixed.mesh));
  ASSERT_EQ(mixed.mesh.vertex_count(), 34U);
  json["scenes"][0]["nodes"] = {1};
  const Mesh expected = bent(as_ply(file.parse().mesh)).mesh;
  const auto splats_of = [](const ShapeFile& shape) {
    Mesh found;
    const std::size_t first = shape.mesh.vertex_count() - 30;
    found.positions.assign(shape.mesh.positions.end() - 30, shape.mesh.positions.end());
    for (const Attribute& attribute : shape.mesh.attributes) {
      if (attribute.components > 1) continue;
      found.attributes.push_back({attribute.name, Domain::vertex, attribute.type, 1, {}});
      found.attributes.back().values.assign(attribute.values.begin() + static_cast<std::ptrdiff_t>(first),
                                            attribute.values.end());
    }
    return found;
  };
  const ShapeFile moved = bent(mixed);
  EXPECT_EQ(moved.mesh.face_count(), 2U);
  EXPECT_NE(moved.mesh.positions[0], mixed.mesh.positions[0]);
  expect_same_splats(splats_of(moved), expected, 2e-5);
  ReplayOptions options;
  options.remesh.settings.emplace().max_edge = 0.3;
  const ReplayResult result = replay(borrow(mixed.mesh), parse_session(kBend, "bend.knead"), options);
  ASSERT_TRUE(result.shape.is_remeshed());
  const ShapeFile remeshed = parse_shape(serialize_deformed("glb", mixed, result.shape), "glb", "remeshed.glb");
  EXPECT_GT(remeshed.mesh.face_count(), 10U);
  const std::size_t more = remeshed.mesh.vertex_count() - 34;
  EXPECT_GT(more, 0U);
  expect_same_splats(splats_of(remeshed), expected, 2e-5);

  const Mesh sphere = make_shape(ShapeKind::sphere, 600);
  const Mesh* const meshes[] = {&sphere, &mixed.mesh};
  const JoinedMeshes joined(meshes);
  options.splats = splats_among(meshes);
  const ReplayResult both = replay(borrow(joined.mesh()), parse_session(kBend, "bend.knead"), options);
  ASSERT_TRUE(both.shape.is_remeshed());
  const test::Scratch folder("gltf_splats");
  write_part(folder.path() / "part.glb", {mixed, joined, 1}, both.shape.state());
  expect_same_splats(splats_of(read_shape(folder.path() / "part.glb")), expected, 2e-5);
}

std::string refusal(const GlbFile& file) {
  try {
    GlbFile copy = file;
    copy.parse();
    return {};
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

TEST(GltfSplats, WhatIsDamagedOrUnknownIsRefused) {
  const GlbFile sound = opened(as_glb(random_splats(4, 1)));
  EXPECT_EQ(refusal(sound), "");
  const auto expect_refused = [&](const char* what, const auto& damage) {
    GlbFile file = sound;
    damage(file);
    EXPECT_NE(refusal(file).find(what), std::string::npos) << what << ": " << refusal(file);
    EXPECT_EQ(refusal(file).find('\n'), std::string::npos);
  };
  const auto accessor = [](GlbFile& file, const char* key) -> GlbJson& {
    return file.accessor(file.primitive()["attributes"][kKey + key].get<std::size_t>());
  };
  const auto float_at = [&](GlbFile& file, const char* key, float number) {
    const std::size_t view = accessor(file, key)["bufferView"];
    file.bin.replace(file.json["bufferViews"][view]["byteOffset"].get<std::size_t>(), 4, raw(std::vector{number}));
  };
  expect_refused("lacks KHR_gaussian_splatting:SCALE", [](GlbFile& f) {
    f.primitive()["attributes"].erase(kKey + "SCALE");
    f.primitive()["attributes"]["_SCALE"] = 0;
  });
  expect_refused("lacks KHR_gaussian_splatting:SH_DEGREE_1_COEF_2",
                 [](GlbFile& f) { f.primitive()["attributes"].erase(kKey + "SH_DEGREE_1_COEF_2"); });
  expect_refused("has another mode", [](GlbFile& f) { f.primitive().erase("mode"); });
  expect_refused("no kernel",
                 [](GlbFile& f) { f.primitive()["extensions"]["KHR_gaussian_splatting"]["kernel"] = "box"; });
  expect_refused("above degree 3", [](GlbFile& f) {
    for (int l = 2; l < 5; ++l) {
      for (int k = 0; k <= 2 * l; ++k)
        f.primitive()["attributes"][fmt::format("{}SH_DEGREE_{}_COEF_{}", kKey, l, k)] = 0;
    }
  });
  expect_refused("another extension compresses", [](GlbFile& f) {
    GlbJson& extension = f.primitive()["extensions"]["KHR_gaussian_splatting"];
    extension["extensions"]["KHR_gaussian_splatting_compression_spz_2"] = {{"bufferView", 0}};
  });
  expect_refused("holds no data", [](GlbFile& f) {
    f.primitive()["extensions"] = {{"KHR_spz_gaussian_splats_compression", {{"bufferView", 0}}}};
    f.accessor(f.primitive()["attributes"]["POSITION"].get<std::size_t>()).erase("bufferView");
  });
  expect_refused("does not fit", [&](GlbFile& f) { accessor(f, "OPACITY")["count"] = 3; });
  expect_refused("does not fit", [&](GlbFile& f) { accessor(f, "ROTATION")["type"] = "VEC3"; });
  expect_refused("does not fit", [&](GlbFile& f) { accessor(f, "OPACITY")["componentType"] = 5123; });
  expect_refused("had logarithms", [&](GlbFile& f) { float_at(f, "SCALE", -3); });
  expect_refused("not finite", [&](GlbFile& f) { float_at(f, "ROTATION", NAN); });
  expect_refused("no item 99", [&](GlbFile& f) { f.primitive()["attributes"][kKey + "SCALE"] = 99; });
}

// A large capture is not kept in memory: all that is written is as of one that is.
TEST(GltfSplats, AreReadAndWrittenInPieces) {
  const test::Scratch folder("gltf_splats");
  const std::filesystem::path path = folder.path() / "capture.glb";
  const std::filesystem::path out = folder.path() / "out.glb";
  const auto bytes_in_pieces = [&](const ShapeFile& shape, const auto&... more) {
    write_shape(out, shape, more...);
    return read_shape(out).bytes;
  };
  constexpr ReadOptions in_pieces{.most_kept_bytes = 0};
  const Session session = parse_session(kBend, "bend.knead");
  for (const bool is_long : {false, true}) {
    Mesh mesh = random_splats(70'000, 0);  // more than are read at a time
    for (Attribute& attribute : mesh.attributes) {
      if (attribute.name.starts_with("scale_") && !is_long) attribute.values.assign(mesh.vertex_count(), -8);
    }
    write_mesh(path, mesh);
    ShapeFile whole = read_shape(path);
    ShapeFile pieces = read_shape(path, in_pieces);
    EXPECT_FALSE(whole.bytes.empty());
    EXPECT_TRUE(pieces.bytes.empty());
    EXPECT_EQ(pieces.mesh.positions, whole.mesh.positions);
    EXPECT_EQ(pieces.mesh.attributes, whole.mesh.attributes);
    EXPECT_EQ(pieces.notes, whole.notes);
    EXPECT_EQ(bytes_in_pieces(pieces, pieces.mesh.positions), whole.bytes);
    EXPECT_EQ(split_splats(whole, session, {}, std::nullopt), is_long);
    split_splats(pieces, session, {}, std::nullopt);
    const DeformedShape shape = replay(borrow(whole.mesh), session).shape;
    write_deformed(out, pieces, shape);
    const std::string expected = serialize_deformed("glb", whole, shape);
    EXPECT_TRUE(read_shape(out).bytes == expected);
    expect_same_splats(read_shape(out).mesh, bent(as_ply(whole.mesh)).mesh);
    const auto animated = [&](const ShapeFile& source) {
      AnimationFile file(out, source, {2, 24});
      for (const std::vector<Vec3d>& frame : {source.mesh.positions, shape.positions()}) file.add(frame);
      file.finish();
      return read_shape(out);
    };
    const ShapeFile frames = animated(pieces);
    EXPECT_EQ(frames.mesh.vertex_count(), whole.mesh.vertex_count());
    EXPECT_TRUE(frames.bytes == animated(whole).bytes);
  }
  const auto write_bytes = [&](const std::string& bytes) { write_file_atomically(path, bytes); };
  GlbFile file = opened(as_glb(random_splats(20, 1)));
  write_bytes(file.bytes() + "rest");
  EXPECT_FALSE(read_shape(path, in_pieces).bytes.empty());
  write_mesh(path, make_shape(ShapeKind::sphere, 100));
  EXPECT_FALSE(read_shape(path, in_pieces).bytes.empty());
}

// Sizes of 0, opacities of 0 and 1: they stay as they are.
TEST(GltfSplats, ExtremesStay) {
  GlbFile file = opened(as_glb(random_splats(2, 0)));
  GlbJson& attributes = file.primitive()["attributes"];
  attributes[kKey + "SCALE"] = file.add_vec3({0, 1, 1000, 0, 0, 0});
  attributes[kKey + "OPACITY"] = file.add<float>(5126, "SCALAR", 1, {0, 1});
  const ShapeFile shape = file.parse();
  const ShapeFile moved = bent(shape);
  const ShapeFile ply = parse_shape(serialize_shape("ply", shape, shape.mesh.positions), "ply", "a.ply");
  for (const Mesh& mesh : {moved.mesh, ply.mesh}) {
    EXPECT_LT(value(mesh, "opacity", 0), -100);
    EXPECT_GT(value(mesh, "opacity", 1), 36);
    EXPECT_NEAR(value(mesh, "scale_2", 0), std::log(1000), 0.7);
  }
  const std::size_t opacity = attributes[kKey + "OPACITY"];
  const std::size_t size = json_of(moved.bytes)["meshes"][0]["primitives"][0]["attributes"][kKey + "SCALE"];
  EXPECT_EQ(size, attributes[kKey + "SCALE"].get<std::size_t>());
  EXPECT_EQ(json_of(moved.bytes)["meshes"][0]["primitives"][0]["attributes"][kKey + "OPACITY"], opacity);
}

}  // namespace
}  // namespace knead::gltf_splats_test
