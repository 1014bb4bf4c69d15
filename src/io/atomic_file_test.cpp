// Files that are written as a whole.
#include "knead/io.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <string>

#include "knead/error.h"
#include "support/test_meshes.h"

namespace knead::atomic_file_test {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("knead_atomic_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

TEST_F(AtomicFile, CreatesAndReplaces) {
  const fs::path path = folder_ / "a b,é.ply";
  write_file_atomically(path, "one");
  EXPECT_EQ(file_bytes(path), "one");
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  write_file_atomically(path, std::string(3'000'000, 'x'));
  EXPECT_EQ(fs::file_size(path), 3'000'000u);
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(files(), 1u);
}

TEST_F(AtomicFile, FollowsLinks) {
  write_file_atomically(folder_ / "real", "old");
  fs::create_symlink("real", folder_ / "link");
  write_file_atomically(folder_ / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(file_bytes(folder_ / "real"), "new");
}

TEST_F(AtomicFile, RefusesWhatCannotBeWritten) {
  EXPECT_THROW(write_file_atomically(folder_, "x"), IoError);
  EXPECT_THROW(write_file_atomically(folder_ / "absent" / "file", "x"), IoError);
  try {
    write_file_atomically(folder_ / std::string(300, 'n'), "x");
    FAIL();
  } catch (const IoError& error) {
    EXPECT_EQ(error.operation(), IoError::Operation::write);
  }
  EXPECT_EQ(files(), 0u);
  write_file_atomically("/dev/null", "gone");
}

TEST_F(AtomicFile, AFullDiskLeavesTheOldFile) {
  const fs::path path = folder_ / "kept";
  write_file_atomically(path, "old");
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 1000;
  ::setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(write_file_atomically(path, std::string(100'000, 'x')), IoError);
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(file_bytes(path), "old");
  EXPECT_EQ(files(), 1u);
}

// A child writes without end and is interrupted at many moments; its handler does what the command's does.
TEST_F(AtomicFile, WhatAKilledProgramLeftIsRemovedAndWhatARunningOneWritesStays) {
  const auto write_series = [&] {
    knead::AtomicFile whole(folder_ / "a.pvd");
    knead::AtomicFile part(folder_ / "a_0000.vtp", whole);
    part.write("x");
    part.close();
    discard_abandoned_files(folder_);  // its own stay
    ASSERT_EQ(files(), 2U);
    part.finish();
    whole.finish();
  };
  write_series();
  EXPECT_EQ(file_bytes(folder_ / "a_0000.vtp"), "x");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const knead::AtomicFile whole(folder_ / "b.pvd");
    knead::AtomicFile part(folder_ / "b_0000.vtp", whole);
    part.close();
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(files(), 4U) << "two of the first series, two temporary ones";
  const knead::AtomicFile running(folder_ / "c.ply");
  discard_abandoned_files(folder_);
  EXPECT_EQ(files(), 3U);
  discard_abandoned_files(folder_ / "nothing");
}

TEST_F(AtomicFile, FilesTogetherTakeTheirPlacesAtOnceOrNotAtAll) {
  write_file_atomically(folder_ / "a", "old");
  {
    const FilesTogether together;
    write_file_atomically(folder_ / "a", "new");
    write_file_atomically(folder_ / "b", "new");
    EXPECT_EQ(together.count(), 2U);
    EXPECT_EQ(file_bytes(folder_ / "a"), "old");
    discard_abandoned_files(folder_);  // what waits stays
    EXPECT_EQ(files(), 3U);
  }
  EXPECT_EQ(files(), 1U) << "given up";
  {
    FilesTogether together;
    const fs::path names[] = {folder_ / "a", folder_ / "b"};
    for (const fs::path& name : names) write_file_atomically(name, "new");
    EXPECT_THROW(write_file_atomically(folder_ / "absent" / "file", "x"), IoError);
    together.finish();
    for (const fs::path& name : names) EXPECT_EQ(file_bytes(name), "new");
    write_file_atomically(folder_ / "c", "at once");
    EXPECT_EQ(file_bytes(folder_ / "c"), "at once");
  }
  EXPECT_EQ(files(), 3U);
}

TEST_F(AtomicFile, AnInterruptLeavesNothingUnfinished) {
  const fs::path path = folder_ / "target";
  write_file_atomically(path, "old");
  const std::string bytes(200'000, 'x');
  // Set before the child begins, which may be late: a program in the background ignores the signal until then.
  const auto before = ::signal(SIGINT, [](int) {
    discard_unfinished_files();
    ::_exit(130);
  });
  for (useconds_t delay = 300; delay < 20'000; delay += 700) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (;;) write_file_atomically(path, bytes);
    }
    ::usleep(delay);
    ::kill(child, SIGINT);
    ::waitpid(child, nullptr, 0);
    EXPECT_EQ(files(), 1u);
    const std::string now = file_bytes(path);
    EXPECT_TRUE(now == "old" || now == bytes);
  }
  ::signal(SIGINT, before);
}

}  // namespace
}  // namespace knead::atomic_file_test
