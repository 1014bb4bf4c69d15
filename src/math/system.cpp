#include "math/system.h"

#if defined(_WIN32)

#include <new>
#include <string>
#include <system_error>
#include <vector>

namespace knead::windows {

namespace {

// FILE_RENAME_INFO of Windows 10, which replaces a file though somebody has it open.
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

}  // namespace

int rename(const wchar_t* from, const wchar_t* to) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(to, error);
  if (!error && rename_as_posix(from, whole.native())) return 0;
  return ::MoveFileExW(from, to, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) ? 0 : fail();
}

}  // namespace knead::windows

#endif
