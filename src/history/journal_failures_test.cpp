// The journal while the disk fails or the program is killed. The calls are replaced in this program: the linker prefers
// its own functions to those of the C library.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <thread>

#include "knead/error.h"
#include "knead/workbench.h"
#include "support/journal_work.h"
#include "support/test_meshes.h"

namespace {

// The disk takes `room` bytes more; with it full, cutting files fails as well if asked for.
struct Disk {
  bool limited = false;
  std::size_t room = 0;
  bool cuts = true;
  int calls = 0;
  std::atomic<int> sync_error = 0;
};
Disk disk;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): the calls have no other argument

template <class Function>
Function* system_call(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t write(int file, const void* bytes, size_t count) {
  const auto original = system_call<ssize_t(int, const void*, size_t)>("write");
  if (!disk.limited) return original(file, bytes, count);
  ++disk.calls;
  if (disk.room == 0) return errno = ENOSPC, -1;
  const std::size_t taken = std::min(count, disk.room);
  disk.room -= taken;
  return original(file, bytes, taken);
}

int ftruncate(int file, off_t length) noexcept {
  if (disk.limited && !disk.cuts) return errno = EIO, -1;
  return system_call<int(int, off_t)>("ftruncate")(file, length);
}

int fdatasync(int file) {
  if (disk.sync_error != 0) return errno = disk.sync_error, -1;
  return system_call<int(int)>("fdatasync")(file);
}

}  // extern "C"

namespace knead::journal_failures_test {
namespace {

namespace fs = std::filesystem;
using test::RandomWork;
using test::Scratch;
using test::short_stroke;
using test::without_lines;

class JournalFailures : public testing::Test {
 protected:
  void TearDown() override {
    disk.limited = false;
    disk.sync_error = 0;
  }
  static void fill_disk(std::size_t room, bool cuts = true) {
    disk.room = room;
    disk.cuts = cuts;
    disk.calls = 0;
    disk.limited = true;
  }
  static std::vector<SessionStroke> recovered(const fs::path& folder) {
    return without_lines(recover_journal(folder).session.strokes);
  }

  Scratch scratch_{"journal_failures"};
};

TEST_F(JournalFailures, AFullDiskKeepsWhatWasThereAndTakesTheRestLater) {
  Journal journal = Journal::create(scratch_.path(), test::sphere(), "full");
  RandomWork work(11);
  for (int i = 0; i < 5; ++i) work.step(&journal);
  const std::vector<SessionStroke> before = work.strokes();
  const std::string text = file_bytes(journal.folder() / "session.knead");
  fill_disk(30);
  for (int i = 0; i < 20; ++i) work.step(&journal);
  EXPECT_EQ(disk.calls, 2);  // the first attempt in two parts, and none more within the second
  disk.limited = false;
  EXPECT_EQ(file_bytes(journal.folder() / "session.knead"), text);
  EXPECT_EQ(recovered(journal.folder()), before);
  ASSERT_TRUE(journal.trouble());
  EXPECT_NE(journal.trouble()->find("No space left"), std::string::npos) << *journal.trouble();
  EXPECT_EQ(journal.trouble()->find('\n'), std::string::npos);
  std::this_thread::sleep_for(std::chrono::milliseconds(1050));
  work.step(&journal);
  EXPECT_EQ(journal.trouble(), std::nullopt);
  EXPECT_EQ(recovered(journal.folder()), work.strokes());
}

TEST_F(JournalFailures, WhatCannotBeCutOffYetIsCutOffLater) {
  Journal journal = Journal::create(scratch_.path(), test::sphere(), "torn");
  RandomWork work(12);
  for (int i = 0; i < 5; ++i) work.step(&journal);
  const std::vector<SessionStroke> before = work.strokes();
  fill_disk(30, false);
  work.step(&journal);
  disk.limited = false;
  EXPECT_FALSE(file_bytes(journal.folder() / "session.knead").ends_with('\n'));
  EXPECT_EQ(recovered(journal.folder()), before);
  std::this_thread::sleep_for(std::chrono::milliseconds(1050));
  work.step(&journal);
  EXPECT_EQ(recovered(journal.folder()), work.strokes());
}

TEST_F(JournalFailures, WhatWaitsIsWrittenAtTheEnd) {
  RandomWork work(13);
  fs::path folder;
  {
    Journal journal = Journal::create(scratch_.path(), test::sphere(), "end");
    folder = journal.folder();
    fill_disk(0);
    for (int i = 0; i < 5; ++i) work.step(&journal);
    disk.limited = false;
    EXPECT_TRUE(recovered(folder).empty());
  }
  EXPECT_EQ(recovered(folder), work.strokes());
}

TEST_F(JournalFailures, ALimitOfTheSystemIsLikeAFullDisk) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    Journal journal = Journal::create(scratch_.path(), test::sphere(), "limit");
    const rlimit limit{20'000, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    RandomWork work(14);
    std::vector<SessionStroke> kept;
    while (!journal.trouble()) {
      kept = work.strokes();
      work.step(&journal);
    }
    const bool good = recovered(journal.folder()) == kept && fs::file_size(journal.folder() / "session.knead") > 19'000;
    ::_exit(good ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(JournalFailures, NoRoomForANewJournalLeavesNothingBehind) {
  fill_disk(3000);
  EXPECT_THROW(Journal::create(scratch_.path(), test::sphere(), "none"), IoError);
  disk.limited = false;
  EXPECT_TRUE(fs::is_empty(scratch_.path()));
}

TEST_F(JournalFailures, ADiskThatCannotSyncIsAnnounced) {
  Journal journal = Journal::create(scratch_.path(), test::sphere(), "sync");
  journal.append(std::vector<SessionStroke>{short_stroke(1)});
  disk.sync_error = EIO;
  journal.sync();
  for (int i = 0; i < 500 && !journal.trouble(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(journal.trouble());
  disk.sync_error = 0;
  journal.sync();
  for (int i = 0; i < 500 && journal.trouble(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(journal.trouble());
}

// What the child has done when it is killed: batches begun and finished.
struct Progress {
  std::atomic<int> begun = 0;
  std::atomic<int> finished = 0;
};

TEST_F(JournalFailures, AKilledProgramLosesNothingButTheBatchUnderWay) {
  void* const memory = ::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  std::mt19937 random(15);
  int most = 0;
  for (std::uint32_t kill = 0; kill < 40; ++kill) {
    auto* const progress = new (memory) Progress;
    const fs::path root = scratch_.path() / std::to_string(kill);
    const pid_t child = ::fork();
    if (child == 0) {
      Journal journal = Journal::create(root, test::sphere(), "killed");
      RandomWork work(kill);
      for (;;) {
        ++progress->begun;
        work.step(&journal);
        ++progress->finished;
      }
    }
    while (progress->begun == 0) std::this_thread::sleep_for(std::chrono::microseconds(50));
    std::this_thread::sleep_for(std::chrono::microseconds(std::uniform_int_distribution<int>(0, 3000)(random)));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const std::vector<AbandonedJournal> journals = abandoned_journals(root);
    ASSERT_EQ(journals.size(), 1U);
    const std::vector<SessionStroke> back = recovered(journals[0].folder);
    RandomWork work(kill);
    for (int i = 0; i < progress->finished; ++i) work.step(nullptr);
    const bool last_was_lost = back == work.strokes();
    work.step(nullptr);
    EXPECT_TRUE(last_was_lost || back == work.strokes()) << kill << ": " << progress->finished << " batches";
    most = std::max<int>(most, progress->finished);
  }
  ::munmap(memory, sizeof(Progress));
  EXPECT_GT(most, 20);
}

}  // namespace
}  // namespace knead::journal_failures_test
