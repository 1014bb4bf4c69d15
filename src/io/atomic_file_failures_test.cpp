// Writing while the system fails: each call that write_file_atomically makes fails once, and a process is killed.
// The calls are replaced in this program: the linker prefers its own functions to those of the C library.
#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <string_view>

#include "knead/error.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "support/test_meshes.h"

namespace {

// Which call fails, counted from 1 while armed; 0: none.
struct Failure {
  bool armed = false;
  int at = 0;
  int calls = 0;
  const char* last = "";  // the call that failed
  int random = -1;        // the file of /dev/urandom, which some C++ libraries read: its calls do not count

  bool strikes(const char* name) {
    if (!armed || ++calls != at) return false;
    last = name;
    return true;
  }
};
Failure failure;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): the calls have no other argument

template <class Function>
Function* system_call(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

// The C library names their parameters with underscores.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  const bool is_random = std::string_view(path) == "/dev/urandom";
  if (!is_random && failure.strikes("open")) return errno = EACCES, -1;
  const int file = system_call<int(const char*, int, ...)>("open")(path, flags, mode);
  if (is_random) failure.random = file;
  return file;
}

// While armed it writes a little at a time, so that a file takes many calls, as on a slow or nearly full disk.
ssize_t write(int file, const void* bytes, size_t count) {
  constexpr size_t little = 4096;
  if (failure.strikes("write")) return errno = ENOSPC, -1;
  return system_call<ssize_t(int, const void*, size_t)>("write")(file, bytes,
                                                                 failure.armed ? std::min(count, little) : count);
}

int fsync(int file) {
  if (failure.strikes("fsync")) return errno = EIO, -1;
  return system_call<int(int)>("fsync")(file);
}

int close(int file) {
  const int result = system_call<int(int)>("close")(file);
  if (file == failure.random) {
    failure.random = -1;
    return result;
  }
  if (failure.strikes("close")) return errno = EIO, -1;
  return result;
}

int rename(const char* from, const char* to) noexcept {
  if (failure.strikes("rename")) return errno = EIO, -1;
  return system_call<int(const char*, const char*)>("rename")(from, to);
}

}  // extern "C"
// NOLINTEND(readability-inconsistent-declaration-parameter-name)

namespace knead::atomic_file_failures_test {
namespace {

namespace fs = std::filesystem;

class AtomicFileFailures : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("knead_failures_{}", ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override {
    failure = {};
    fs::remove_all(folder_);
  }
  std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(folder_), fs::directory_iterator()); }

  fs::path folder_;
};

TEST_F(AtomicFileFailures, EveryCallThatFailsLeavesTheOldFileOrTheNewOne) {
  const fs::path path = folder_ / "target";
  const std::string old_bytes(50'000, 'o');
  const std::string new_bytes(100'000, 'n');
  int refused = 0;
  std::vector<std::string> failed;
  for (int at = 1;; ++at) {
    write_file_atomically(path, old_bytes);
    failure = {true, at};
    bool written = true;
    try {
      write_file_atomically(path, new_bytes);
    } catch (const IoError& error) {
      written = false;
      EXPECT_EQ(error.operation(), IoError::Operation::write);
      EXPECT_NE(std::string(error.what()).find("target"), std::string::npos) << error.what();
    }
    failure.armed = false;
    if (failure.calls < at) {
      EXPECT_TRUE(written);
      break;
    }
    failed.emplace_back(failure.last);
    refused += written ? 0 : 1;
    EXPECT_EQ(file_bytes(path), written ? new_bytes : old_bytes) << failure.last << " failed";
    EXPECT_EQ(files(), 1) << failure.last << " failed";
  }
  for (const char* call : {"open", "write", "fsync", "close", "rename"}) {
    EXPECT_NE(std::find(failed.begin(), failed.end(), call), failed.end()) << call << " was never called";
  }
  EXPECT_GT(refused, 25);  // a hundred thousand bytes take 25 writes
}

TEST_F(AtomicFileFailures, AnAnimationIsWholeOrNotThere) {
  const ShapeFile shape = parse_shape(serialize_mesh("ply", make_shape(ShapeKind::sphere, 642)), "ply", "ball.ply");
  for (const char* name : {"a.pc2", "a.mdd", "a.glb", "a.usda"}) {
    const fs::path path = folder_ / name;
    write_file_atomically(path, "old");
    int refused = 0;
    for (int at = 1; at < 1000; ++at) {
      failure = {true, at};
      bool written = true;
      try {
        AnimationFile file(path, shape, {4, 24});
        std::vector<Vec3d> positions = shape.mesh.positions;
        for (int k = 0; k < 4; ++k) {
          file.add(positions);
          positions[7].x += 0.1;
        }
        file.finish();
      } catch (const IoError&) {
        written = false;
        ++refused;
      }
      failure.armed = false;
      EXPECT_EQ(file_bytes(path) == "old", !written) << name << ": " << failure.last << " failed";
      EXPECT_EQ(files(), 1) << name << ": " << failure.last << " failed";
      if (written) break;  // a folder that cannot be synced is no failure
    }
    EXPECT_GT(refused, 4) << name;
    fs::remove(path);
  }
}

TEST_F(AtomicFileFailures, AKilledProcessLeavesTheOldFileOrTheNewOne) {
  const fs::path path = folder_ / "target";
  const std::string old_bytes(300'000, 'o');
  const std::string new_bytes(200'000, 'n');
  write_file_atomically(path, old_bytes);
  for (useconds_t delay = 300; delay < 20'000; delay += 900) {
    const pid_t child = ::fork();
    if (child == 0) {
      failure = {true, 0};
      for (;;) write_file_atomically(path, new_bytes);
    }
    ::usleep(delay);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const std::string now = file_bytes(path);
    EXPECT_TRUE(now == old_bytes || now == new_bytes);
  }
}

}  // namespace
}  // namespace knead::atomic_file_failures_test
