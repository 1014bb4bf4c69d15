// Damaged files: whatever the bytes, a shape that keeps its promises or an InvalidInput.
#include <gtest/gtest.h>

#include "knead/io/shape_file.h"
#include "knead/io/test_samples.h"
#include "knead/math/error.h"
#include "support/shape_promises.h"

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

void check(const std::string& bytes, const std::string& format) {
  try {
    ASSERT_EQ(broken_promise(parse_shape(bytes, format, "damaged")), "");
  } catch (const InvalidInput& error) {
    ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

std::vector<Sample> samples() {
  std::vector<Sample> samples{{"ply", kTextPly}, {"ply", binary_ply()}, {"obj", kObj}};
  for (const Sample& sample : stl_off_and_xyz_samples()) samples.push_back(sample);
  return samples;
}

TEST(Damage, TheSamplesAreSound) {
  for (const Sample& sample : samples()) {
    EXPECT_EQ(broken_promise(parse_shape(sample.bytes, sample.format, "sample")), "") << sample.bytes;
  }
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
