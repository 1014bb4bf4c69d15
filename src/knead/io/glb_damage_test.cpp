// Damaged GLB files: whatever the bytes, a shape that keeps its promises or an InvalidInput.
#include <gtest/gtest.h>

#include "knead/io/glb_test_files.h"
#include "knead/math/error.h"
#include "support/shape_promises.h"

namespace knead {
namespace {

void check(const std::string& bytes) {
  try {
    ASSERT_EQ(broken_promise(parse_shape(bytes, "glb", "damaged")), "");
  } catch (const InvalidInput& error) {
    ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
}

std::string triangle() {
  GlbFile file;
  file.primitive()["attributes"]["POSITION"] = file.add_vec3({0, 0, 0, 1, 0, 0, 1, 1, 0});
  return file.bytes();
}

// Two nodes, sparse and quantized data.
std::string elaborate() {
  GlbFile file = square_glb();
  const std::size_t indices = file.add_view(raw(std::vector<std::uint8_t>{1}));
  const std::size_t values = file.add_view(raw(std::vector<float>{7, 8, 9}));
  file.accessor(0)["sparse"] = {{"count", 1},
                                {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                {"values", {{"bufferView", values}}}};
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add<std::uint16_t>(5123, "VEC2", 2, {0, 0, 9, 0, 9, 9, 0, 9});
  file.json["accessors"].back()["normalized"] = true;
  file.json["nodes"].push_back(GlbJson::parse(R"({"children":[2],"rotation":[0.6,0,0,0.8]})"));
  file.json["nodes"].push_back(GlbJson::parse(R"({"mesh":0,"scale":[2,3,-4]})"));
  file.json["scenes"][0]["nodes"].push_back(1);
  return file.bytes();
}

TEST(GlbDamage, EveryPrefix) {
  for (const std::string& bytes : {triangle(), elaborate()}) {
    EXPECT_NO_THROW(parse_shape(bytes, "glb", "sound"));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_THROW(parse_shape(bytes.substr(0, size), "glb", "prefix"), InvalidInput) << size;
    }
  }
}

TEST(GlbDamage, EveryValueOfEveryByteOfATriangle) {
  const std::string sound = triangle();
  for (std::size_t i = 0; i < sound.size(); ++i) {
    for (int value = 0; value < 256; ++value) {
      std::string bytes = sound;
      bytes[i] = static_cast<char>(value);
      check(bytes);
    }
  }
}

TEST(GlbDamage, EveryChangeOfOneByte) {
  const std::string sound = elaborate();
  for (std::size_t i = 0; i < sound.size(); ++i) {
    for (const char value : {'\0', '\n', '"', ' ', '-', '9', 'e', '\\', '[', '\x7f', '\xff'}) {
      std::string bytes = sound;
      bytes[i] = value;
      check(bytes);
    }
  }
}

TEST(GlbDamage, EveryByteLeftOutOrDoubled) {
  const std::string sound = elaborate();
  for (std::size_t i = 0; i < sound.size(); ++i) {
    std::string bytes = sound;
    check(bytes.erase(i, 1));
    check(bytes.insert(i, 2, sound[i]));
  }
}

}  // namespace
}  // namespace knead
