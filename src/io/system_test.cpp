// What systems do differently with files, and must not show. Runs on all of them.
#include "math/system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <string>

#include "io/append_file.h"
#include "io/codec.h"
#include "knead/io.h"
#include "support/test_meshes.h"

namespace knead::system_test {
namespace {

namespace fs = std::filesystem;

class System : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("knead_system_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

// Where files have a text mode, it turns \n into \r\n and ends a file at \x1a.
TEST_F(System, BytesStayAsTheyAre) {
  const std::string bytes("a\r\nb\nc\x1a\0d\n", 10);
  write_file_atomically(folder_ / "bytes", bytes);
  EXPECT_EQ(file_bytes(folder_ / "bytes"), bytes);
  std::string read(bytes.size(), ' ');
  detail::SourceFile(folder_ / "bytes").read(0, read);
  EXPECT_EQ(read, bytes);
  { detail::AppendFile(folder_ / "bytes").append("\nmore\x1a\n"); }
  EXPECT_EQ(file_bytes(folder_ / "bytes"), bytes + "\nmore\x1a\n");
}

TEST_F(System, AFileThatIsBeingReadIsReplaced) {
  const fs::path path = folder_ / "shape";
  write_file_atomically(path, "old");
  {
    const detail::SourceFile open(path);
    write_file_atomically(path, "newer");
    EXPECT_EQ(file_bytes(path), "newer");
    std::string read(3, ' ');
    open.read(0, read);
    EXPECT_EQ(read, "old");
  }
  EXPECT_EQ(files(), 1U);
}

TEST_F(System, WhatIsLockedCanBeReadAndNotLockedAgain) {
  const fs::path path = folder_ / "journal";
  detail::AppendFile file(path);
  file.append("line\n");
  EXPECT_EQ(file_bytes(path), "line\n");
  EXPECT_THROW(detail::AppendFile{path}, std::exception);
  EXPECT_EQ(file_bytes(path), "line\n");
}

TEST_F(System, AnAppendedFileCanBeCut) {
  const fs::path path = folder_ / "journal";
  write_file_atomically(path, "whole\ntorn");
  detail::AppendFile file(path);
  file.cut(6);
  file.append("next\n");
  file.sync();
  EXPECT_EQ(file.trouble(), std::nullopt);
  EXPECT_EQ(file_bytes(path), "whole\nnext\n");
}

TEST_F(System, AbandonedFilesAreKnownFromThoseInUse) {
  const std::string key = "0123456789abcdef";
  std::ofstream(folder_ / (".knead-" + key + ".tmp")) << "left";
  AtomicFile running(folder_ / "shape");
  running.write("whole");
  EXPECT_EQ(files(), 2U);
  discard_abandoned_files(folder_);
  EXPECT_EQ(files(), 1U);
  running.finish();
  EXPECT_EQ(file_bytes(folder_ / "shape"), "whole");
}

TEST_F(System, PlacesBeyondFourGigabytesAreRead) {
  const fs::path path = folder_ / "large";
  const std::uint64_t begin = (std::uint64_t{1} << 32) + 5;
  {
    std::ofstream file(path, std::ios::binary);
    file.seekp(static_cast<std::streamoff>(begin));  // a hole, where the file system has holes
    file << "end";
    if (!file.flush()) GTEST_SKIP() << "no space for 4 GB";
  }
  const detail::SourceFile file(path);
  EXPECT_EQ(file.size(), begin + 3);
  std::string read(3, ' ');
  file.read(begin, read);
  EXPECT_EQ(read, "end");
}

TEST_F(System, AFolderWithAnOpenFileMovesWhereItSaysSo) {
  const fs::path from = folder_ / "from";
  fs::create_directory(from);
  const detail::AppendFile open(from / "file");
  const bool moved = ::rename(from.c_str(), (folder_ / "to").c_str()) == 0;
  EXPECT_TRUE(moved || !kMovesOpenFolders);  // Wine moves what Windows does not
}

#if defined(__linux__) && defined(__x86_64__)
// What the kernel lists of the first processor; to a program for another processor QEMU shows the host's list.
bool kernel_lists(std::initializer_list<const char*> instructions) {
  std::ifstream text("/proc/cpuinfo");
  std::string line;
  while (std::getline(text, line) && line.rfind("flags", 0) != 0) {
  }
  return std::all_of(instructions.begin(), instructions.end(), [&](const char* each) {
    return (line + ' ').find(std::string(" ") + each + ' ') != std::string::npos;
  });
}

TEST(Processor, HasWhatTheKernelLists) {
  EXPECT_EQ(has_avx2_and_fma(), kernel_lists({"avx2", "fma"}));
  EXPECT_EQ(has_avx512(), kernel_lists({"avx512f", "avx512cd", "avx512dq", "avx512bw", "avx512vl"}));
}
#endif

}  // namespace
}  // namespace knead::system_test
