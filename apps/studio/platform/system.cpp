#include "platform/system.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#endif

namespace knead::studio {

namespace {

std::filesystem::path absolute_of(const char* variable) {
  const char* const value = std::getenv(variable);
  if (value == nullptr) return {};
  std::filesystem::path path(value);
  return path.is_absolute() ? path : std::filesystem::path();
}

}  // namespace

#if defined(_WIN32)

namespace {

bool is_open(DWORD which) { return ::GetFileType(::GetStdHandle(which)) != FILE_TYPE_UNKNOWN; }

}  // namespace

std::filesystem::path home_folder() { return absolute_of("USERPROFILE"); }

std::vector<std::filesystem::path> drives() {
  std::vector<std::filesystem::path> found;
  const DWORD present = ::GetLogicalDrives();
  for (int i = 0; i < 26; ++i) {
    if ((present >> i & 1) != 0) found.emplace_back(std::wstring{static_cast<wchar_t>(L'A' + i), L':', L'\\'});
  }
  return found;
}

// A program with windows gets no console. Output that goes to a file or a pipe stays there.
void prepare_program() noexcept {
  const bool has_output = is_open(STD_OUTPUT_HANDLE);
  const bool has_errors = is_open(STD_ERROR_HANDLE);
  if ((has_output && has_errors) || ::AttachConsole(ATTACH_PARENT_PROCESS) == FALSE) return;
  ::SetConsoleOutputCP(CP_UTF8);
  if (!has_output) std::freopen("CONOUT$", "w", stdout);
  if (!has_errors) std::freopen("CONOUT$", "w", stderr);
}

void show_failure(const std::string& line) {
  if (is_open(STD_ERROR_HANDLE)) {
    std::fprintf(stderr, "%s\n", line.c_str());
  } else {
    ::MessageBoxW(nullptr, std::filesystem::path(line).c_str(), L"Knead Studio", MB_OK | MB_ICONERROR);
  }
}

#else

std::filesystem::path home_folder() { return absolute_of("HOME"); }

std::vector<std::filesystem::path> drives() { return {}; }

void prepare_program() noexcept {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond the limit on its size is an output that cannot be written
}

void show_failure(const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); }

#endif

}  // namespace knead::studio
