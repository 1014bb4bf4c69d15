// Files that KHR_draco_mesh_compression and EXT_meshopt_compression compress. The tests compress them.
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <memory>

#ifdef KNEAD_HAS_DRACO
#include <draco/compression/encode.h>
#endif
#ifdef KNEAD_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include "io/gltf/gltf.h"
#include "io/test_samples.h"
#include "knead/mesh.h"

namespace knead::compressed_test {
namespace {

// A sphere with a picture, whose view lies between those that are compressed.
GlbFile sphere_glb() {
  const Mesh sphere = make_shape(ShapeKind::sphere, 500);
  std::vector<float> places;
  for (const Vec3d& p : sphere.positions) {
    for (const double x : {p.x, p.y, p.z}) places.push_back(static_cast<float>(x));
  }
  std::vector<std::uint16_t> corners(sphere.corner_vertex.begin(), sphere.corner_vertex.end());
  GlbFile file;
  file.primitive()["attributes"]["POSITION"] = file.add_vec3(places);
  const std::size_t picture = file.add_view("a picture of 25 bytes ...");
  file.json["images"] = {{{"bufferView", picture}, {"mimeType", "image/png"}}};
  file.primitive()["indices"] = file.add<std::uint16_t>(5123, "SCALAR", 1, corners);
  return file;
}

std::string view_bytes(const GlbFile& file, std::size_t v) {
  const GlbJson& view = file.json["bufferViews"][v];
  return file.bin.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
}

// What a reader of any kind of compression owes: the same mesh, the same bytes while nothing moves, and else a file
// without compression that has all the rest.
void expect_read(const std::string& bytes, const std::string& codec, const ShapeFile& plain, double tolerance) {
  const ShapeFile shape = parse_shape(bytes, "glb", "compressed.glb");
  ASSERT_FALSE(shape.notes.empty());
  EXPECT_EQ(shape.notes[0],
            "it is compressed with " + codec + "; if a vertex moves, it is written without compression");
  ASSERT_EQ(shape.mesh.vertex_count(), plain.mesh.vertex_count());
  ASSERT_EQ(shape.mesh.face_count(), plain.mesh.face_count());
  EXPECT_NEAR(measure(shape.mesh).volume, measure(plain.mesh).volume, 10 * tolerance);
  EXPECT_EQ(serialize_shape("glb", shape, shape.mesh.positions), bytes);
  std::vector<Vec3d> moved = shape.mesh.positions;
  for (Vec3d& p : moved) p.x += 0.25;
  const std::string written = serialize_shape("glb", shape, moved);
  const GlbJson json = json_of(written);
  EXPECT_EQ(json.dump().find("compression"), std::string::npos);
  EXPECT_EQ(json["buffers"].size(), 1u);
  const GlbJson& picture = json["bufferViews"][json["images"][0]["bufferView"].get<std::size_t>()];
  EXPECT_EQ(bin_of(written).substr(picture["byteOffset"].get<std::size_t>(), picture["byteLength"].get<std::size_t>()),
            "a picture of 25 bytes ...");
  const ShapeFile again = parse_shape(written, "glb", "written.glb");
  EXPECT_TRUE(again.notes.empty());
  ASSERT_EQ(again.mesh.vertex_count(), moved.size());
  for (std::size_t i = 0; i < moved.size(); ++i) EXPECT_LT(norm(again.mesh.positions[i] - moved[i]), 1e-6);
  EXPECT_EQ(again.mesh.corner_vertex, shape.mesh.corner_vertex);
}

void expect_refused(const std::string& bytes, const std::string& what) {
  try {
    parse_shape(bytes, "glb", "bad.glb");
    ADD_FAILURE() << "read, where this was expected: " << what;
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  }
}

#ifdef KNEAD_HAS_MESHOPTIMIZER

// The square or sphere with its positions and indices compressed; as gltfpack does, the views name a buffer without
// bytes.
GlbFile meshopt_sphere() {
  GlbFile plain = sphere_glb();
  const std::size_t vertices = plain.accessor(0)["count"].get<std::size_t>();
  const std::size_t corners = plain.accessor(1)["count"].get<std::size_t>();
  std::vector<unsigned char> places(meshopt_encodeVertexBufferBound(vertices, 12));
  places.resize(meshopt_encodeVertexBuffer(places.data(), places.size(), view_bytes(plain, 0).data(), vertices, 12));
  std::vector<unsigned int> indices;
  const std::string raw_indices = view_bytes(plain, 2);
  for (std::size_t i = 0; i < corners; ++i) {
    std::uint16_t v = 0;
    std::memcpy(&v, raw_indices.data() + 2 * i, 2);
    indices.push_back(v);
  }
  std::vector<unsigned char> triangles(meshopt_encodeIndexBufferBound(corners, vertices));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), corners));
  GlbFile file = plain;
  file.bin.clear();
  file.json["bufferViews"] = GlbJson::array();
  const auto add = [&](const std::vector<unsigned char>& bytes, std::size_t stride, std::size_t count,
                       const char* mode) {
    const std::size_t v = file.add_view({bytes.begin(), bytes.end()});
    GlbJson& view = file.json["bufferViews"][v];
    GlbJson packed = {{"buffer", 0},
                      {"byteOffset", view["byteOffset"]},
                      {"byteLength", view["byteLength"]},
                      {"byteStride", stride},
                      {"count", count},
                      {"mode", mode}};
    view = {{"buffer", 1}, {"byteOffset", v * 65536}, {"byteLength", stride * count}};
    view["extensions"]["EXT_meshopt_compression"] = packed;
  };
  add(places, 12, vertices, "ATTRIBUTES");
  file.json["bufferViews"][file.add_view("a picture of 25 bytes ...")]["name"] = "picture";
  add(triangles, 2, corners, "TRIANGLES");
  file.json["buffers"].push_back({{"byteLength", 1u << 30}});
  file.json["buffers"][1]["extensions"]["EXT_meshopt_compression"] = {{"fallback", true}};
  file.json["extensionsUsed"] = {"EXT_meshopt_compression"};
  file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  return file;
}

TEST(CompressedGltf, MeshoptIsReadAndWrittenPlain) {
  expect_read(meshopt_sphere().bytes(), "meshopt", sphere_glb().parse(), 0);
}

TEST(CompressedGltf, SplatsInMeshoptAreReadAsOthers) {
  Mesh splats;
  for (int i = 0; i < 50; ++i) splats.positions.push_back({0.25 * i, 1, -0.5 * i});
  for (const char* name : {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"}) {
    splats.attributes.push_back({name, Domain::vertex, NumberType::float32, 1, std::vector<double>(50, -1)});
  }
  const std::string bytes = serialize_mesh("glb", splats);
  const GlbFile plain{json_of(bytes), bin_of(bytes)};
  GlbFile file = plain;
  file.bin.clear();
  file.json["bufferViews"] = GlbJson::array();
  for (std::size_t v = 0; v < plain.json["bufferViews"].size(); ++v) {
    const std::string elements = view_bytes(plain, v);
    const std::size_t stride = elements.size() / 50;
    std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(50, stride));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), elements.data(), 50, stride));
    GlbJson& view = file.json["bufferViews"][file.add_view({packed.begin(), packed.end()})];
    GlbJson extension = view;
    extension.update({{"byteStride", stride}, {"count", 50}, {"mode", "ATTRIBUTES"}});
    view["extensions"]["EXT_meshopt_compression"] = extension;
    view["byteLength"] = elements.size();
  }
  file.json["extensionsUsed"].push_back("EXT_meshopt_compression");
  const ShapeFile expected = parse_shape(bytes, "glb", "plain.glb");
  const ShapeFile found = file.parse();
  EXPECT_EQ(found.mesh.positions, expected.mesh.positions);
  EXPECT_EQ(found.mesh.attributes, expected.mesh.attributes);
}

TEST(CompressedGltf, DamagedMeshoptIsRefusedWithItsView) {
  const auto changed = [](const char* key, const GlbJson& value) {
    GlbFile file = meshopt_sphere();
    file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value;
    return file.bytes();
  };
  const std::string place = "bufferViews[0].extensions.EXT_meshopt_compression";
  for (const auto& [key, value] : {std::pair<const char*, GlbJson>{"mode", "INDICES"},
                                   {"mode", "CUBES"},
                                   {"filter", "OCTAHEDRAL"},
                                   {"byteStride", 0},
                                   {"byteStride", 1 << 20},
                                   {"count", 1ull << 50},
                                   {"count", 1 << 16}}) {
    expect_refused(changed(key, value), place + ": cannot be decompressed");
  }
  expect_refused(changed("byteLength", 1 << 30), place + ": ends after its buffer");
  expect_refused(changed("buffer", 7), "is in buffer 7, which there is not");
  GlbFile cut = meshopt_sphere();
  for (std::size_t i = 0; i < 40; ++i) cut.bin[i] = static_cast<char>(i);
  expect_refused(cut.bytes(), place + ": cannot be decompressed");
}

#endif

#ifdef KNEAD_HAS_DRACO

// Sequential: the triangles in their order, after a note. Otherwise by edgebreaker, without one.
GlbFile draco_sphere(int bits, bool is_sequential = false) {
  GlbFile plain = sphere_glb();
  const ShapeFile shape = plain.parse();
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(shape.mesh.vertex_count()));
  mesh.SetNumFaces(shape.mesh.face_count());
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = mesh.AddAttribute(position, true, mesh.num_points());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const Vec3d& p = shape.mesh.positions[i];
    const std::array<float, 3> place{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), place.data());
  }
  for (std::uint32_t f = 0; f < shape.mesh.face_count(); ++f) {
    const auto corners = shape.mesh.face(f);
    mesh.SetFace(draco::FaceIndex(f),
                 {draco::PointIndex(corners[0]), draco::PointIndex(corners[1]), draco::PointIndex(corners[2])});
  }
  if (is_sequential) {
    auto note = std::make_unique<draco::GeometryMetadata>();
    note->AddEntryString("made by", "a test");
    mesh.AddMetadata(std::move(note));
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(is_sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  GlbFile file = plain;
  file.bin.clear();
  file.json["bufferViews"] = GlbJson::array();
  const std::size_t picture = file.add_view("a picture of 25 bytes ...");
  const std::size_t view = file.add_view({buffer.data(), buffer.size()});
  file.json["images"][0]["bufferView"] = picture;
  for (std::size_t a : {0, 1}) file.accessor(a).erase("bufferView");
  file.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", mesh.attribute(id)->unique_id()}}}};
  file.json["extensionsUsed"] = {"KHR_draco_mesh_compression", "KHR_materials_unlit"};
  file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return file;
}

TEST(CompressedGltf, DracoIsReadAndWrittenPlain) {
  expect_read(draco_sphere(16).bytes(), "Draco", sphere_glb().parse(), 2e-4);
  expect_read(draco_sphere(16, true).bytes(), "Draco", sphere_glb().parse(), 2e-4);
  const std::string written =
      serialize_shape("glb", draco_sphere(16).parse(), std::vector<Vec3d>(sphere_glb().parse().mesh.vertex_count()));
  EXPECT_EQ(json_of(written)["extensionsUsed"], GlbJson({"KHR_materials_unlit"}));
}

// Quantized places have other bounds than those before the compression, which the file declares.
TEST(CompressedGltf, DracoHasTheBoundsOfWhatIsDecompressed) {
  GlbFile file = draco_sphere(5);
  file.accessor(0)["min"] = {-1.5, -1.5, -1.5};
  file.accessor(0)["max"] = {1.5, 1.5, 1.5};
  std::vector<std::string> notes;
  const std::string plain = detail::gltf::decompressed(file.bytes(), "a.glb", notes);
  const GlbJson accessor = json_of(plain)["accessors"][0];
  Box box;
  for (const Vec3d& p : parse_shape(plain, "glb", "a.glb").mesh.positions) box.extend(p);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(accessor["min"][axis].get<double>(), box.min[axis]);
    EXPECT_EQ(accessor["max"][axis].get<double>(), box.max[axis]);
  }
}

// The decoder would make room for as many faces as the header says.
TEST(CompressedGltf, DracoThatSaysItHasMoreFacesThanItCanIsRefusedAtOnce) {
  GlbFile file = draco_sphere(12);
  const std::size_t begin = file.bin.find("DRACO");
  ASSERT_EQ(file.bin.substr(begin + 7, 2), std::string("\1\1"));  // a mesh, by edgebreaker
  // Vertices and faces, two bytes each here; one byte later, two of symbols.
  const std::size_t counts = begin + 5 + 2 + 2 + 2 + 1;
  const std::string many = "\xff\xff\xff\xff\x02";  // 805,306,367 as a number of variable length
  ASSERT_EQ(file.bin[counts + 1] & 0x80, 0);
  file.bin.replace(counts, 7, many + many + file.bin[counts + 4] + many);
  rusage before{};
  getrusage(RUSAGE_SELF, &before);
  expect_refused(file.bytes(), "KHR_draco_mesh_compression: cannot be decompressed");
  rusage after{};
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 1 << 20);  // KiB
}

// Points of 1920 bytes each, all zero, so that few bytes hold many of them.
std::string draco_of_wide_points(std::uint32_t points) {
  draco::Mesh mesh;
  mesh.set_num_points(points);
  for (std::uint32_t p = 0; p + 2 < points; p += 2) {
    mesh.AddFace({draco::PointIndex(p), draco::PointIndex(p + 1), draco::PointIndex(p + 2)});
  }
  for (int a = 0; a < 4; ++a) {
    draco::GeometryAttribute wide;
    wide.Init(draco::GeometryAttribute::GENERIC, nullptr, 120, draco::DT_UINT32, false, 480, 0);
    draco::PointAttribute& values = *mesh.attribute(mesh.AddAttribute(wide, true, points));
    std::fill_n(values.GetAddress(draco::AttributeValueIndex(0)), 480 * std::size_t{points}, std::uint8_t{0});
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(10, 10);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
}

TEST(CompressedGltf, DracoAttributesTakeAtMost64BytesForEachVertexThatMayBe) {
  const std::string bytes = draco_of_wide_points(1000);
  EXPECT_TRUE(detail::gltf::decode_draco(bytes, {}, 30'000).has_value());
  EXPECT_FALSE(detail::gltf::decode_draco(bytes, {}, 29'999).has_value());
}

TEST(CompressedGltf, DamagedDracoIsRefusedWithItsPrimitive) {
  const std::string place = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
  GlbFile file = draco_sphere(12);
  for (std::size_t i = 40; i < 60; ++i) file.bin[i] = '\x55';
  expect_refused(file.bytes(), place + ": cannot be decompressed");
  file = draco_sphere(12);
  file.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 9;
  expect_refused(file.bytes(), place + ": cannot be decompressed");
  file = draco_sphere(12);
  file.accessor(0)["count"] = 3;
  expect_refused(file.bytes(), "accessors[0].count: should be");
  file = draco_sphere(12);
  file.accessor(1)["componentType"] = 5121;
  expect_refused(file.bytes(), "accessors[1].componentType: is too small for the indices");
}

#endif

}  // namespace
}  // namespace knead::compressed_test
