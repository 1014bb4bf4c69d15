// The instruction sets of the processor, large pages, and Windows' renaming of files.
#include "math/system.h"

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif
#if defined(__x86_64__)
#include <cpuid.h>
#endif
#if defined(_WIN32)
#include <new>
#include <string>
#include <system_error>
#include <vector>
#endif

namespace knead {

namespace {

#if defined(__x86_64__)
// The bits of two leaves of cpuid, and which registers the system saves (XCR0).
struct Processor {
  unsigned leaf1_c = 0;
  unsigned leaf7_b = 0;
  unsigned saved = 0;
};

Processor read_processor() noexcept {
  Processor result;
  unsigned a = 0;
  unsigned b = 0;
  unsigned c = 0;
  unsigned d = 0;
  constexpr unsigned osxsave = 1U << 27;
  if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & osxsave) == 0) return result;
  result.leaf1_c = c;
  if (__get_cpuid_count(7, 0, &a, &b, &c, &d) != 0) result.leaf7_b = b;
  unsigned high = 0;
  asm volatile("xgetbv" : "=a"(result.saved), "=d"(high) : "c"(0));
  return result;
}

bool has_all(unsigned bits, unsigned wanted) noexcept { return (bits & wanted) == wanted; }

const Processor& processor() noexcept {
  static const Processor result = read_processor();
  return result;
}
#endif

#if defined(_WIN32)
// FILE_RENAME_INFO of Windows 10, which replaces a file that another program has open.
struct Renaming {
  DWORD flags = 0x1 | 0x2;  // FILE_RENAME_FLAG_REPLACE_IF_EXISTS, FILE_RENAME_FLAG_POSIX_SEMANTICS
  HANDLE folder = nullptr;
  DWORD bytes = 0;
  wchar_t name[1] = {};
};

bool rename_as_posix(const wchar_t* from, const std::wstring& to) {
  constexpr int rename_info_ex = 22;
  const HANDLE file = ::CreateFileW(from, DELETE | SYNCHRONIZE, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                                    nullptr, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, nullptr);
  if (file == INVALID_HANDLE_VALUE) return false;
  std::vector<char> buffer(sizeof(Renaming) + to.size() * sizeof(wchar_t));
  auto* renaming = new (buffer.data()) Renaming;
  renaming->bytes = static_cast<DWORD>(to.size() * sizeof(wchar_t));
  to.copy(renaming->name, to.size());
  const bool done = ::SetFileInformationByHandle(file, static_cast<FILE_INFO_BY_HANDLE_CLASS>(rename_info_ex), renaming,
                                                 static_cast<DWORD>(buffer.size())) != 0;
  ::CloseHandle(file);
  return done;
}

// For drives whose format (FAT) cannot do that: the old file gets another name first, and is removed when no program
// has it open.
bool rename_past_old(const wchar_t* from, const wchar_t* to) {
  const std::wstring aside = std::wstring(to) + L".knead-old";
  if (::MoveFileExW(to, aside.c_str(), MOVEFILE_REPLACE_EXISTING) == 0) return false;
  if (::MoveFileExW(from, to, MOVEFILE_WRITE_THROUGH) == 0) {
    const DWORD error = ::GetLastError();
    ::MoveFileExW(aside.c_str(), to, MOVEFILE_REPLACE_EXISTING);
    ::SetLastError(error);
    return false;
  }
  ::DeleteFileW(aside.c_str());
  return true;
}
#endif

}  // namespace

#if defined(__x86_64__)

bool has_avx2_and_fma() noexcept {
  constexpr unsigned fma_and_avx = 1U << 12 | 1U << 28;
  constexpr unsigned avx2 = 1U << 5;
  constexpr unsigned xmm_and_ymm = 0x06;
  const Processor& its = processor();
  return has_all(its.leaf1_c, fma_and_avx) && has_all(its.leaf7_b, avx2) && has_all(its.saved, xmm_and_ymm);
}

bool has_avx512() noexcept {
  constexpr unsigned f_dq_cd_bw_vl = 1U << 16 | 1U << 17 | 1U << 28 | 1U << 30 | 1U << 31;
  constexpr unsigned all_registers = 0xe6;
  return has_avx2_and_fma() && has_all(processor().leaf7_b, f_dq_cd_bw_vl) && has_all(processor().saved, all_registers);
}

#else

bool has_avx2_and_fma() noexcept { return false; }
bool has_avx512() noexcept { return false; }

#endif

void prefer_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t page = std::uintptr_t{1} << 21;  // of x86-64 and most of arm64
  const std::uintptr_t skipped = (page - reinterpret_cast<std::uintptr_t>(begin) % page) % page;
  if (bytes < skipped + page) return;
  ::madvise(static_cast<char*>(begin) + skipped, (bytes - skipped) / page * page, MADV_HUGEPAGE);
#endif
}

#if defined(_WIN32)
int windows::rename(const wchar_t* from, const wchar_t* to) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(to, error);
  if (!error && rename_as_posix(from, whole.native())) return 0;
  if (::MoveFileExW(from, to, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) != 0) return 0;
  const bool is_open = ::GetLastError() == ERROR_ACCESS_DENIED || ::GetLastError() == ERROR_SHARING_VIOLATION;
  const DWORD attributes = ::GetFileAttributesW(to);
  const bool may_go = (attributes & (FILE_ATTRIBUTE_DIRECTORY | FILE_ATTRIBUTE_READONLY)) == 0;  // nor is it missing
  return is_open && may_go && rename_past_old(from, to) ? 0 : fail();
}
#endif

}  // namespace knead
