// Damaged files: whatever the bytes, a shape that keeps its promises or an InvalidInput.
#include <gtest/gtest.h>

#include "knead/io/shape_file.h"
#include "knead/math/error.h"
#include "knead/mesh/measures.h"

namespace knead {
namespace {

const std::string kHeader =
    "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty double y\nproperty short z\n"
    "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
    "property uchar blue\nproperty list uchar short extra\nelement face 2\nproperty list uchar int vertex_indices\n"
    "property list uchar float texcoord\nproperty uchar flag\nelement tristrips 1\n"
    "property list int int vertex_indices\nend_header\n";

const std::string kTextPly = kHeader +
                             "0 0 0 0 0 1 1 2 3 2 7 8\n1 0 0 0 0 1 1 2 3 0\n0 1 0 0 0 1 1 2 3 1 5\n"
                             "1 1e-3 1 0 0 1 1 2 3 0\n3 0 1 2 6 0 0 1 0 0 1 9\n3 1 3 2 6 0 0 1 0 0 1 9\n"
                             "5 0 1 2 -1 3\n";

const std::string kObj =
    "# c\nv 0 0 0 1 1 1\nv 1.5 0 0\nv 0 1e1 0\nv 0 0 -1 \\\n\nvt 0 0\nvn 0 0 1\ng a\n"
    "f 1/1/1 2/1/1 3/1/1\nf -1//-1 -2//1 1//1 2\nf 1 4 2\n";

std::string binary_ply() {
  ShapeFile shape = parse_shape(kTextPly, "ply", "text.ply");
  return serialize_mesh("ply", shape.mesh, {.double_coordinates = false});
}

// Reads the bytes and, if they are a shape, moves it and writes it in both formats.
void check(const std::string& bytes, const std::string& format) {
  try {
    const ShapeFile shape = parse_shape(bytes, format, "damaged");
    const Mesh& mesh = shape.mesh;
    ASSERT_EQ(mesh.face_begin.back(), mesh.corner_vertex.size());
    for (const std::uint32_t v : mesh.corner_vertex) ASSERT_LT(v, mesh.vertex_count());
    for (const Vec3d& p : mesh.positions) ASSERT_TRUE(is_finite(p));
    const Measures m = measure(mesh);
    ASSERT_LE(m.components, m.faces);
    ASSERT_EQ(serialize_shape(format, shape, mesh.positions), bytes);
    std::vector<Vec3d> positions = mesh.positions;
    for (Vec3d& p : positions) p = {p.y * 0.5, p.x + 1, p.z};
    const std::string moved = serialize_shape(format, shape, positions, {.double_coordinates = true});
    ASSERT_EQ(parse_shape(moved, format, "moved").mesh.positions, positions);
    serialize_shape(format == "ply" ? "obj" : "ply", shape, positions);
  } catch (const InvalidInput& error) {
    ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

struct Sample {
  std::string format;
  std::string bytes;
};

std::vector<Sample> samples() { return {{"ply", kTextPly}, {"ply", binary_ply()}, {"obj", kObj}}; }

TEST(Damage, TheSamplesAreSound) {
  for (const Sample& sample : samples()) EXPECT_NO_THROW(parse_shape(sample.bytes, sample.format, "sample"));
}

TEST(Damage, ListsOfAbsurdLength) {
  for (const char* length : {"8.88e65", "-1", "nan", "inf", "2.5", "1e18"}) {
    std::string bytes = kTextPly;
    bytes.replace(bytes.find("3 0 1 2 6"), 1, length);
    EXPECT_THROW(parse_shape(bytes, "ply", "damaged"), InvalidInput) << length;
  }
}

TEST(Damage, EveryPrefix) {
  for (const Sample& sample : samples()) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) check(sample.bytes.substr(0, size), sample.format);
  }
}

TEST(Damage, EveryChangeOfOneByte) {
  for (const Sample& sample : samples()) {
    for (std::size_t i = 0; i < sample.bytes.size(); ++i) {
      for (const char value : {'\0', '\n', '\r', ' ', '-', '9', 'e', '\\', '#', '\x7f', '\xff'}) {
        std::string bytes = sample.bytes;
        bytes[i] = value;
        check(bytes, sample.format);
      }
    }
  }
}

TEST(Damage, EveryByteLeftOutOrDoubled) {
  for (const Sample& sample : samples()) {
    for (std::size_t i = 0; i < sample.bytes.size(); ++i) {
      std::string bytes = sample.bytes;
      check(bytes.erase(i, 1), sample.format);
      check(bytes.insert(i, 2, sample.bytes[i]), sample.format);
    }
  }
}

}  // namespace
}  // namespace knead
