// .gltf files, and buffers outside of the binary chunk.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "math/system.h"
#include "support/shape_text.h"
#include "support/split_faces.h"

namespace knead::gltf_test {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class GltfFiles : public testing::Test {
 protected:
  GltfFiles() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("knead_gltf_" + std::string(test->name()) + std::to_string(::getpid()));
    fs::create_directories(folder_ / "other");
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  // A square whose buffer is in a file of that name.
  fs::path write_square(const std::string& uri, const std::string& file) const {
    GlbFile square = square_glb();
    square.json["buffers"][0] = {{"uri", uri}, {"byteLength", square.bin.size()}};
    write(file, square.bin);
    return write("square.gltf", square.json.dump(2) + "\n");
  }

  fs::path folder_;
};

std::vector<Vec3d> lifted(const ShapeFile& shape) {
  std::vector<Vec3d> positions = shape.mesh.positions;
  positions[2].z += 0.5;
  return positions;
}

TEST(Gltf, EmbeddedBuffersAreReadAndWrittenEmbedded) {
  const std::string text = embedded(square_glb());
  const ShapeFile shape = parse_shape(text, "gltf", "a.gltf");
  const ShapeFile same = square_glb().parse();
  EXPECT_EQ(shape.mesh.positions, same.mesh.positions);
  EXPECT_EQ(shape.mesh.attributes, same.mesh.attributes);
  const std::string moved = serialize_shape("gltf", shape, lifted(shape));
  EXPECT_EQ(parse_shape(moved, "gltf", "b").mesh.positions, lifted(shape));
  // Besides the numbers only the bounds differ.
  GlbJson before = GlbJson::parse(text);
  GlbJson after = GlbJson::parse(moved);
  for (GlbJson* json : {&before, &after}) {
    (*json)["buffers"][0].erase("uri");
    (*json)["accessors"][0].erase("max");
  }
  EXPECT_EQ(before, after);
}

// The fuzzed seed that ended in an exception of the standard library.
TEST(Gltf, IndicesThatAreWrittenAsReals) {
  for (const char* zero : {"-0", "0.0", "0e1"}) {
    const std::string text = replaced(embedded(square_glb()), "\"POSITION\": 0", std::string("\"POSITION\": ") + zero);
    const ShapeFile shape = parse_shape(text, "gltf", "a.gltf");
    EXPECT_EQ(parse_shape(serialize_shape("gltf", shape, lifted(shape)), "gltf", "b").mesh.positions, lifted(shape));
  }
}

TEST(Gltf, GlbWithADataUri) {
  GlbFile file = square_glb();
  file.json["buffers"][0] = {{"uri", "data:application/gltf-buffer;base64," + detail::to_base64(file.bin)},
                             {"byteLength", file.bin.size()}};
  const std::string bytes = glb_with_header(glb_chunk(0x4E4F534A, file.json.dump(), ' '));
  const ShapeFile shape = parse_shape(bytes, "glb", "a.glb");
  EXPECT_EQ(shape.format, "glb");
  EXPECT_EQ(shape.mesh.positions, square_glb().parse().mesh.positions);
  EXPECT_EQ(serialize_shape("glb", shape, shape.mesh.positions), bytes);
  const std::string moved = serialize_shape("glb", shape, lifted(shape));
  EXPECT_NE(moved.find("data:application/gltf-buffer;base64,"), std::string::npos);
  EXPECT_EQ(parse_shape(moved, "glb", "b").mesh.positions, lifted(shape));
}

// Tests with damaged files found that the words before the bytes were written without their escapes.
TEST(Gltf, EscapesInADataUriStay) {
  for (const char* escaped : {"\\t", "\\n", "\\\"", "\\\\", "\\u0000", "\\u00e9"}) {
    const std::string head = std::string("\"data:applica") + escaped + ";base64,";
    for (const std::string& sound : {embedded(square_glb()), gltf_samples()[2].bytes}) {
      const std::string from =
          sound.find("data:;base64,") == std::string::npos ? "data:application/octet-stream;base64," : "data:;base64,";
      const std::string text = replaced(sound, '"' + from, head);
      const ShapeFile shape = parse_shape(text, "gltf", "a.gltf");
      const std::string moved = serialize_shape("gltf", shape, lifted(shape));
      EXPECT_EQ(parse_shape(moved, "gltf", "b").mesh.positions, lifted(shape)) << escaped;
      const std::string uri = GlbJson::parse(moved)["buffers"][0]["uri"];
      EXPECT_TRUE(uri.starts_with(GlbJson::parse(head + '"').get<std::string>())) << escaped;
    }
  }
}

// All zeros: none of the bytes is there, but a moved vertex needs some.
TEST(Gltf, AnEmptyBufferWithoutAUri) {
  const std::string text = R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":0}],
    "bufferViews":[{"buffer":0,"byteLength":0}],"accessors":[{"count":3,"type":"VEC3","componentType":5126,
    "sparse":{"count":0,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}}}]})";
  const ShapeFile shape = parse_shape(text, "gltf", "a.gltf");
  EXPECT_EQ(serialize_shape("gltf", shape, shape.mesh.positions), text);
  EXPECT_EQ(parse_shape(serialize_shape("gltf", shape, lifted(shape)), "gltf", "b").mesh.positions, lifted(shape));
}

TEST(Gltf, SeveralBuffersAreNoted) {
  const ShapeFile shape = parse_shape(gltf_samples()[2].bytes, "gltf", "a.gltf");
  EXPECT_NE(text_of(shape.notes).find("2 buffers are written as one"), std::string::npos);
  const ShapeFile back = parse_shape(serialize_shape("gltf", shape, lifted(shape)), "gltf", "b");
  EXPECT_EQ(back.mesh.positions, lifted(shape));
  EXPECT_EQ(back.mesh.corner_vertex, shape.mesh.corner_vertex);
}

TEST(Gltf, WhatIsRefused) {
  const std::string text = embedded(square_glb());
  const auto with_uri = [&](const std::string& uri) {
    GlbJson json = GlbJson::parse(text);
    json["buffers"][0]["uri"] = uri;
    return refusal(json.dump(), "gltf", "a.gltf");
  };
  EXPECT_NE(with_uri("data:;base64,ab!=").find("is no base64"), std::string::npos);
  EXPECT_NE(with_uri("data:text/plain,abc").find("without ';base64,'"), std::string::npos);
  EXPECT_NE(with_uri("data:;base64,AAAA").find("3 are there; the file is cut short"), std::string::npos);
  EXPECT_NE(with_uri("a.bin").find("not opened here"), std::string::npos);
  for (const char* uri :
       {"../a.bin", "/etc/passwd", "%2e%2e/a", "a%2fb.bin", "http://a.b/c.bin", "..", "", "c:\\a.bin"}) {
    EXPECT_NE(with_uri(uri).find("no plain name"), std::string::npos) << uri;
  }
  EXPECT_NE(refusal("{", "gltf", "a.gltf"), "none");
}

TEST(Gltf, Base64OfEveryLength) {
  std::string bytes;
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(detail::from_base64(detail::to_base64(bytes)), bytes);
    bytes += static_cast<char>(i * 37);
  }
  EXPECT_EQ(detail::to_base64("Man!"), "TWFuIQ==");
}

TEST_F(GltfFiles, BuffersBesideAreReadAndWrittenBeside) {
  const fs::path path = write_square("my%20square.bin", "my square.bin");
  const ShapeFile shape = read_shape(path);
  EXPECT_EQ(shape.mesh.positions, square_glb().parse().mesh.positions);
  const fs::path moved = folder_ / "other" / "moved.gltf";
  write_shape(moved, shape, lifted(shape));
  EXPECT_EQ(read_shape(moved).mesh.positions, lifted(shape));
  EXPECT_EQ(GlbJson::parse(read(moved))["buffers"][0]["uri"], "my%20square.bin");
  EXPECT_EQ(read(folder_ / "my square.bin"), square_glb().bin);  // the source's own stays
  const fs::path copy = folder_ / "other" / "copy.gltf";
  write_shape(copy, shape, shape.mesh.positions);  // another file has the buffer's name there
  EXPECT_EQ(read_shape(copy).mesh.positions, shape.mesh.positions);
  EXPECT_EQ(read_shape(moved).mesh.positions, lifted(shape));
}

TEST_F(GltfFiles, InTheSameFolderTheSourceStaysUnlessItIsReplaced) {
  const fs::path path = write_square("square.bin", "square.bin");
  const ShapeFile shape = read_shape(path);
  write_shape(folder_ / "moved.gltf", shape, lifted(shape));
  EXPECT_EQ(read_shape(folder_ / "moved.gltf").mesh.positions, lifted(shape));
  EXPECT_TRUE(fs::exists(folder_ / "moved.bin"));
  EXPECT_EQ(read_shape(path).mesh.positions, shape.mesh.positions);
  const std::string text = read(path);
  write_shape(folder_ / "copy.gltf", shape, shape.mesh.positions);
  EXPECT_EQ(read(folder_ / "copy.gltf"), text);
  write_shape(path, shape, lifted(shape));
  EXPECT_EQ(read_shape(path).mesh.positions, lifted(shape));
  EXPECT_EQ(GlbJson::parse(read(path))["buffers"][0]["uri"], "square.bin");
}

TEST_F(GltfFiles, RemeshedBeside) {
  const ShapeFile shape = read_shape(write_square("square.bin", "square.bin"));
  const Remade remade = split_faces(shape.mesh, [](std::uint32_t f) { return f == 0; });
  write_remeshed(folder_ / "fine.gltf", shape, remade.mesh, remade.face_source);
  EXPECT_EQ(read_shape(folder_ / "fine.gltf").mesh.face_count(), remade.mesh.face_count());
  EXPECT_TRUE(fs::exists(folder_ / "fine.bin"));
}

TEST_F(GltfFiles, MissingFilesAndLinksAreRefused) {
  const fs::path path = write_square("square.bin", "elsewhere.bin");
  const auto refused = [&] {
    try {
      read_shape(path);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_NE(refused().find("is not there; put it beside this one"), std::string::npos);
  std::error_code error;
  fs::create_symlink("elsewhere.bin", folder_ / "square.bin", error);
  if (error || !fs::is_symlink(folder_ / "square.bin")) GTEST_SKIP() << "this system makes no symbolic links";
  EXPECT_NE(refused().find("is no regular file"), std::string::npos);
}

TEST_F(GltfFiles, OtherFormatsBecomeOneFile) {
  const ShapeFile shape = square_glb().parse();
  write_shape(folder_ / "whole.gltf", shape, lifted(shape));
  EXPECT_EQ(read_shape(folder_ / "whole.gltf").mesh.positions, lifted(shape));
  EXPECT_FALSE(fs::exists(folder_ / "whole.bin"));
}

}  // namespace
}  // namespace knead::gltf_test
