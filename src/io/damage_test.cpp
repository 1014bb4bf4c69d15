// Damaged files: whatever the bytes, a shape that keeps its promises or an InvalidInput of one line.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "io/test_samples.h"
#include "knead/error.h"
#include "knead/io.h"
#include "support/shape_promises.h"

namespace knead::damage_test {
namespace {

void check(const Sample& sample) {
  bool is_read = false;
  try {
    const ShapeFile shape = parse_shape(sample.bytes, sample.format, "damaged");
    is_read = true;
    ASSERT_EQ(broken_promise(shape), "");
  } catch (const InvalidInput& error) {
    ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    if (is_read) return;  // what a format cannot hold
    ASSERT_THROW(parse_summary(sample.bytes, sample.format, "damaged"), InvalidInput) << error.what();
  }
}

class DamagedFile : public testing::TestWithParam<const char*> {
 protected:
  // The samples of the format, shortest first.
  std::vector<Sample> samples() const {
    std::vector<Sample> samples = samples_of(GetParam());
    std::sort(samples.begin(), samples.end(),
              [](const Sample& a, const Sample& b) { return a.bytes.size() < b.bytes.size(); });
    return samples;
  }
};

TEST_P(DamagedFile, FiveSamplesAreSound) {
  EXPECT_GE(samples().size(), 5u);
  for (const Sample& sample : samples()) {
    EXPECT_EQ(broken_promise(parse_shape(sample.bytes, sample.format, "sample")), "") << sample.bytes;
  }
}

// What fuzzers begin with, and what they found.
TEST_P(DamagedFile, FuzzedFiles) {
  const std::filesystem::path folder = std::filesystem::path(KNEAD_FUZZ_CORPUS) / (std::string("fuzz_") + GetParam());
  std::size_t count = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(file.path().filename());
    std::ifstream stream(file.path(), std::ios::binary);
    check({GetParam(), {std::istreambuf_iterator<char>(stream), {}}});
    ++count;
  }
  EXPECT_GE(count, 3u);
}

TEST_P(DamagedFile, EveryPrefix) {
  for (const Sample& sample : samples()) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) check({sample.format, sample.bytes.substr(0, size)});
  }
}

TEST_P(DamagedFile, EveryValueOfEveryByteOfTheShortestTwo) {
  const std::vector<Sample> all = samples();
  for (Sample sample : {all[0], all[1]}) {
    for (char& byte : sample.bytes) {
      const char sound = byte;
      for (int value = 0; value < 256; ++value) {
        byte = static_cast<char>(value);
        check(sample);
      }
      byte = sound;
    }
  }
}

TEST_P(DamagedFile, TellingValuesOfEveryByte) {
  for (Sample sample : samples()) {
    for (char& byte : sample.bytes) {
      const char sound = byte;
      for (const char value : {'\0', '\n', '\r', ' ', '-', '9', 'e', '\\', '#', '"', '[', '\x7f', '\xff'}) {
        byte = value;
        check(sample);
      }
      byte = sound;
    }
  }
}

TEST_P(DamagedFile, EveryByteLeftOutOrDoubled) {
  for (const Sample& sample : samples()) {
    for (std::size_t i = 0; i < sample.bytes.size(); ++i) {
      Sample damaged = sample;
      damaged.bytes.erase(i, 1);
      check(damaged);
      damaged.bytes.insert(i, 2, sample.bytes[i]);
      check(damaged);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, DamagedFile, testing::ValuesIn(kEveryFormat),
                         [](const auto& parameter) { return std::string(parameter.param); });

TEST(Damage, ListsOfAbsurdLength) {
  const std::string sound = samples_of("ply")[0].bytes;
  for (const char* length : {"8.88e65", "-1", "nan", "inf", "2.5", "1e18"}) {
    std::string bytes = sound;
    bytes.replace(bytes.find("3 0 1 2 6"), 1, length);
    EXPECT_THROW(parse_shape(bytes, "ply", "damaged"), InvalidInput) << length;
  }
}

// In GLB every length is declared, so that nothing may be missing at all.
TEST(Damage, NoPrefixOfAGlbFileIsRead) {
  for (const Sample& sample : samples_of("glb")) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      EXPECT_THROW(parse_shape(sample.bytes.substr(0, size), "glb", "prefix"), InvalidInput) << size;
    }
  }
}

}  // namespace
}  // namespace knead::damage_test
