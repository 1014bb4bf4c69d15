// Everything that depends on the system or processor: POSIX names for Windows, files, large pages, instruction sets.
// Include it instead of <fcntl.h>, <unistd.h>, <sys/file.h> and <sys/stat.h>. Internal.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#if !defined(_WIN32)

#include <sys/file.h>
#include <unistd.h>

#else

// Windows: paths are wchar_t, files are binary, and a file may be renamed or removed while it is open.
#define WIN32_LEAN_AND_MEAN
#include <io.h>
#include <process.h>
#include <windows.h>

#include <cerrno>

inline constexpr int O_CLOEXEC = 0;    // every file below is
inline constexpr int O_DIRECTORY = 0;  // folders cannot be opened, nor synced
inline constexpr int LOCK_EX = 2;
inline constexpr int LOCK_NB = 4;
#ifndef EWOULDBLOCK
#define EWOULDBLOCK EAGAIN
#endif
#undef near
#undef far
#undef small

namespace knead::windows {
inline int fail() {
  const DWORD error = ::GetLastError();
  errno = error == ERROR_FILE_NOT_FOUND || error == ERROR_PATH_NOT_FOUND || error == ERROR_INVALID_NAME ? ENOENT
          : error == ERROR_FILE_EXISTS || error == ERROR_ALREADY_EXISTS                                 ? EEXIST
          : error == ERROR_ACCESS_DENIED || error == ERROR_SHARING_VIOLATION                            ? EACCES
          : error == ERROR_LOCK_VIOLATION || error == ERROR_IO_PENDING                                  ? EWOULDBLOCK
          : error == ERROR_DISK_FULL || error == ERROR_HANDLE_DISK_FULL                                 ? ENOSPC
          : error == ERROR_DIRECTORY                                                                    ? ENOTDIR
                                                                                                        : EIO;
  return -1;
}
// Replaces `to` as POSIX does, even while a program has the old file open.
int rename(const wchar_t* from, const wchar_t* to);
inline HANDLE handle(int file) { return reinterpret_cast<HANDLE>(::_get_osfhandle(file)); }
}  // namespace knead::windows

inline int open(const wchar_t* path, int flags, int /*mode*/ = 0) {
  const DWORD access = (flags & O_RDWR) != 0     ? GENERIC_READ | GENERIC_WRITE
                       : (flags & O_WRONLY) != 0 ? GENERIC_WRITE
                                                 : GENERIC_READ;
  const DWORD how = (flags & O_EXCL) != 0 ? CREATE_NEW : (flags & O_CREAT) != 0 ? OPEN_ALWAYS : OPEN_EXISTING;
  const HANDLE file = ::CreateFileW(path, access, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, nullptr, how,
                                    FILE_ATTRIBUTE_NORMAL, nullptr);
  if (file == INVALID_HANDLE_VALUE) return knead::windows::fail();
  return ::_open_osfhandle(reinterpret_cast<std::intptr_t>(file), (flags & O_APPEND) | _O_BINARY | _O_NOINHERIT);
}
// Windows keeps other programs from reading locked bytes, so the lock is on a byte far beyond the end.
inline int flock(int file, int /*how*/) {
  OVERLAPPED at{};
  at.OffsetHigh = 0x40000000;
  return ::LockFileEx(knead::windows::handle(file), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0, &at)
             ? 0
             : knead::windows::fail();
}
inline int fsync(int file) { return ::_commit(file); }
inline int ftruncate(int file, std::int64_t length) { return ::_chsize_s(file, length) == 0 ? 0 : -1; }
inline int fchmod(int /*file*/, int /*mode*/) { return 0; }
inline ssize_t pread(int file, void* to, std::size_t count, std::int64_t begin) {
  OVERLAPPED at{};
  at.Offset = static_cast<DWORD>(begin);
  at.OffsetHigh = static_cast<DWORD>(begin >> 32);
  DWORD done = 0;
  const DWORD most = count > (1U << 30) ? 1U << 30 : static_cast<DWORD>(count);
  if (!::ReadFile(knead::windows::handle(file), to, most, &done, &at)) {
    if (::GetLastError() == ERROR_HANDLE_EOF) return 0;
    return knead::windows::fail();
  }
  return static_cast<ssize_t>(done);
}
inline ssize_t write(int file, const void* from, std::size_t count) {  // that of Windows takes 32 bits
  return ::_write(file, from, count > (1U << 30) ? 1U << 30 : static_cast<unsigned>(count));
}
inline int mkdir(const wchar_t* path, int /*mode*/) {
  return ::CreateDirectoryW(path, nullptr) ? 0 : knead::windows::fail();
}
inline int unlink(const wchar_t* path) { return ::DeleteFileW(path) ? 0 : knead::windows::fail(); }
inline int access(const wchar_t* path, int mode) { return ::_waccess(path, mode & 6); }
inline int stat(const wchar_t* path, struct stat* state) {
  struct _stat64 found {};
  if (::_wstat64(path, &found) != 0) return -1;
  state->st_mode = found.st_mode;
  state->st_size = found.st_size;
  return 0;
}
inline int rename(const wchar_t* from, const wchar_t* to) { return knead::windows::rename(from, to); }

#endif

namespace knead {

inline std::FILE* open_to_read(const std::filesystem::path& path) {
#if defined(_WIN32)
  return ::_wfopen(path.c_str(), L"rb");
#else
  return std::fopen(path.c_str(), "rb");
#endif
}

inline int sync_data(int file) {
#if defined(__linux__)
  return ::fdatasync(file);
#else
  return ::fsync(file);  // on macOS, F_FULLFSYNC would be safer
#endif
}

// The time of a file's last change, in nanoseconds of the system's clock.
inline std::int64_t changed_ns([[maybe_unused]] int file, const struct stat& state) {
#if defined(_WIN32)
  FILETIME time{};
  if (!::GetFileTime(windows::handle(file), nullptr, nullptr, &time)) return 0;
  (void)state;
  return ((static_cast<std::int64_t>(time.dwHighDateTime) << 32 | time.dwLowDateTime) - 116444736000000000) * 100;
#elif defined(__APPLE__)
  return std::int64_t{state.st_mtimespec.tv_sec} * 1'000'000'000 + state.st_mtimespec.tv_nsec;
#else
  return std::int64_t{state.st_mtim.tv_sec} * 1'000'000'000 + state.st_mtim.tv_nsec;
#endif
}

// Asks the system for large pages for memory that is allocated but not filled yet. Without them, reading a large file
// spends most of its time on page faults. A hint: nothing happens if the memory is small or the system has none.
void prefer_large_pages(void* begin, std::size_t bytes) noexcept;

template <class T>
void reserve_large(std::vector<T>& items, std::size_t count) {
  if (count <= items.capacity()) return;
  items.reserve(count);
  prefer_large_pages(items.data(), items.capacity() * sizeof(T));
}

inline void reserve_large(std::string& bytes, std::size_t count) {
  if (count <= bytes.capacity()) return;
  bytes.reserve(count);
  prefer_large_pages(bytes.data(), bytes.capacity());
}

// Whether the processor has these instructions and the system saves their registers; false elsewhere than on x86-64.
// Asks the processor itself: zig's runtime library answers no to every __builtin_cpu_supports.
bool has_avx2_and_fma() noexcept;
bool has_avx512() noexcept;  // F, CD, DQ, BW and VL

// Marks a function whose loops are vectorised by the compiler: one copy for each instruction set, chosen when the
// program starts. Nothing is contracted or reassociated, so all copies return the same bits. Not under sanitizers,
// which are not ready when the choice is made, and only where the linker knows such functions.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && \
    defined(__GNUC__) && !defined(__clang__)
#define KNEAD_CLONES [[gnu::target_clones("default", "avx2", "avx512f")]]
#else
#define KNEAD_CLONES
#endif

// Whether a folder can be renamed, or removed with all in it, while a file in it is open.
#if defined(_WIN32)
inline constexpr bool kMovesOpenFolders = false;
#else
inline constexpr bool kMovesOpenFolders = true;
#endif

}  // namespace knead
