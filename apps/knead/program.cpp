// The command's calls of the system: signals, the terminal, other programs.
#include "program.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <system_error>
#include <thread>

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <io.h>
#include <process.h>
#include <windows.h>
#else
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#endif
#if defined(__APPLE__)
#include <mach-o/dyld.h>

extern char** environ;  // declared nowhere
#endif

namespace knead::command {

namespace {

constexpr std::uint64_t kUnknown = std::numeric_limits<std::uint64_t>::max();

bool is_able_terminal() noexcept {
  const char* term = std::getenv("TERM");
  return term != nullptr && *term != '\0' && std::string_view(term) != "dumb";
}

#if defined(_WIN32)
constexpr char kBetweenFolders = ';';
constexpr const char* kProgramEnding = ".exe";
#else
constexpr char kBetweenFolders = ':';
constexpr const char* kProgramEnding = "";
#endif

}  // namespace

std::filesystem::path find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, kBetweenFolders);) {
    std::filesystem::path file = std::filesystem::path(folder) / (name + kProgramEnding);
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) continue;
#if !defined(_WIN32)
    if (::access(file.c_str(), X_OK) != 0) continue;
#endif
    return file;
  }
  return {};
}

#if defined(_WIN32)

namespace {

void (*interruption)(int) = nullptr;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): for the handler

BOOL WINAPI on_control(DWORD event) {
  interruption(SIGINT);
  const bool is_ctrl = event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT;
  if (!is_ctrl) ::Sleep(INFINITE);  // the process ends when this returns, and the first thread has still to put right
  return TRUE;
}

// Quotes one word of a command line in the way that programs parse it.
std::wstring quoted(const std::wstring& word) {
  std::wstring text = L"\"";
  std::size_t slashes = 0;  // before a quote they are doubled
  for (const wchar_t c : word) {
    if (c == L'"') text.append(slashes + 1, L'\\');
    slashes = c == L'\\' ? slashes + 1 : 0;
    text += c;
  }
  return text.append(slashes, L'\\') + L"\"";
}

}  // namespace

int error_of_making_files_in(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::file_type type = std::filesystem::status(folder, error).type();
  if (type == std::filesystem::file_type::not_found) return ENOENT;
  if (type != std::filesystem::file_type::directory) return ENOTDIR;
  const std::filesystem::path probe = folder / (L".knead-" + std::to_wstring(::GetCurrentProcessId()) + L".probe");
  const HANDLE file = ::CreateFileW(probe.c_str(), GENERIC_WRITE | DELETE, 0, nullptr, CREATE_ALWAYS,
                                    FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
  if (file == INVALID_HANDLE_VALUE) return EACCES;
  ::CloseHandle(file);
  return 0;
}

int error_of_overwriting(const std::filesystem::path& file) { return ::_waccess(file.c_str(), 2) == 0 ? 0 : errno; }

std::uint64_t memory_bytes() noexcept {
  MEMORYSTATUSEX state{};
  state.dwLength = sizeof state;
  return ::GlobalMemoryStatusEx(&state) ? state.ullTotalPhys : kUnknown;
}

std::uint64_t stack_bytes() noexcept { return kUnknown; }  // the linker has set it

void prepare_process() noexcept {
  for (const int file : {0, 1, 2}) ::_setmode(file, _O_BINARY);
  ::SetConsoleOutputCP(CP_UTF8);
}

void when_interrupted(void (*handle)(int signal)) {
  interruption = handle;
  ::SetConsoleCtrlHandler(on_control, TRUE);
}

bool shows_progress() noexcept {
  DWORD mode = 0;
  return ::GetConsoleMode(::GetStdHandle(STD_ERROR_HANDLE), &mode) != 0 || (::_isatty(2) != 0 && is_able_terminal());
}

void write_error_output(std::string_view text) noexcept {
  DWORD written = 0;
  ::WriteFile(::GetStdHandle(STD_ERROR_HANDLE), text.data(), static_cast<DWORD>(text.size()), &written, nullptr);
}

void end_process(int code) noexcept {
  ::TerminateProcess(::GetCurrentProcess(), static_cast<UINT>(code));
  std::abort();
}

std::filesystem::path own_program() {
  std::wstring name(32768, L'\0');
  name.resize(::GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size())));
  return name;
}

// Windows replaces no process: this one waits for the other, and ends as it ends.
void become(const std::filesystem::path& program, std::vector<std::string> words) {
  std::vector<std::wstring> wide;
  for (const std::string& word : words) wide.push_back(quoted(std::filesystem::path(word).native()));
  std::vector<const wchar_t*> arguments;
  for (const std::wstring& word : wide) arguments.push_back(word.c_str());
  arguments.push_back(nullptr);
  const std::intptr_t code = ::_wspawnvp(_P_WAIT, program.c_str(), arguments.data());
  if (code >= 0) std::exit(static_cast<int>(code));
}

struct PipedProgram::State {
  bool start(const std::filesystem::path& program, const std::string& name, const std::vector<std::string>& words);
  void read();

  HANDLE process = nullptr;
  HANDLE input = nullptr;   // of the other program, to write
  HANDLE output = nullptr;  // of the other program, to read
  std::string written;
  std::thread reader;
};

bool PipedProgram::State::start(const std::filesystem::path& program, const std::string& name,
                                const std::vector<std::string>& words) {
  SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
  HANDLE its_input = nullptr;
  HANDLE its_output = nullptr;
  if (::CreatePipe(&its_input, &input, &inherited, 0) == FALSE) return false;
  if (::CreatePipe(&output, &its_output, &inherited, 0) == FALSE) return false;
  ::SetHandleInformation(input, HANDLE_FLAG_INHERIT, 0);
  ::SetHandleInformation(output, HANDLE_FLAG_INHERIT, 0);
  std::wstring line = quoted(std::filesystem::path(name).native());
  for (const std::string& word : words) line += L' ' + quoted(std::filesystem::path(word).native());
  STARTUPINFOW start{};
  start.cb = sizeof start;
  start.dwFlags = STARTF_USESTDHANDLES;
  start.hStdInput = its_input;
  start.hStdOutput = its_output;
  start.hStdError = ::GetStdHandle(STD_ERROR_HANDLE);
  PROCESS_INFORMATION made{};
  const BOOL started = ::CreateProcessW(program.c_str(), line.data(), nullptr, nullptr, TRUE, CREATE_NO_WINDOW, nullptr,
                                        nullptr, &start, &made);
  ::CloseHandle(its_input);
  ::CloseHandle(its_output);
  if (started == FALSE) {
    ::CloseHandle(input);
    ::CloseHandle(output);
    return false;
  }
  ::CloseHandle(made.hThread);
  process = made.hProcess;
  return true;
}

void PipedProgram::State::read() {
  std::string block(65536, '\0');
  DWORD count = 0;
  while (::ReadFile(output, block.data(), static_cast<DWORD>(block.size()), &count, nullptr) != FALSE && count > 0) {
    written.append(block.data(), count);
  }
}

bool PipedProgram::write(const void* bytes, std::size_t count) {
  const auto* at = static_cast<const char*>(bytes);
  while (count > 0) {
    DWORD done = 0;
    const DWORD most = count > (1U << 20) ? 1U << 20 : static_cast<DWORD>(count);
    if (::WriteFile(state_->input, at, most, &done, nullptr) == FALSE) return false;
    at += done;
    count -= done;
  }
  return true;
}

int PipedProgram::finish() {
  if (!is_running()) return 0;
  ::CloseHandle(state_->input);
  state_->reader.join();
  ::CloseHandle(state_->output);
  ::WaitForSingleObject(state_->process, INFINITE);
  DWORD status = 0;
  ::GetExitCodeProcess(state_->process, &status);
  ::CloseHandle(state_->process);
  return static_cast<int>(status);
}

#else

int error_of_making_files_in(const std::filesystem::path& folder) {
#if defined(O_TMPFILE)
  const int file = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (file >= 0) {
    ::close(file);
    return 0;
  }
  if (errno == EACCES || errno == EROFS || errno == EPERM) return errno;
#endif
  struct stat state {};  // the file system may have no files without names
  if (::stat(folder.c_str(), &state) != 0) return errno;
  if (!S_ISDIR(state.st_mode)) return ENOTDIR;
  return ::access(folder.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
}

int error_of_overwriting(const std::filesystem::path& file) { return ::access(file.c_str(), W_OK) == 0 ? 0 : errno; }

std::uint64_t memory_bytes() noexcept {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page = ::sysconf(_SC_PAGESIZE);
  return pages < 0 || page < 0 ? kUnknown : static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page);
}

std::uint64_t stack_bytes() noexcept {
  rlimit limit{};
  return ::getrlimit(RLIMIT_STACK, &limit) == 0 ? std::uint64_t{limit.rlim_cur} : kUnknown;
}

void prepare_process() noexcept {
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an output that cannot be written
  std::signal(SIGXFSZ, SIG_IGN);  // and so is a file beyond the limit on its size
}

void when_interrupted(void (*handle)(int signal)) {
  struct sigaction action {};
  action.sa_handler = handle;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  struct sigaction old {};
  if (::sigaction(SIGHUP, nullptr, &old) == 0 && old.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
}

bool shows_progress() noexcept { return ::isatty(STDERR_FILENO) == 1 && is_able_terminal(); }

void write_error_output(std::string_view text) noexcept {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
}

void end_process(int code) noexcept { ::_exit(code); }

std::filesystem::path own_program() {
  std::error_code error;
#if defined(__APPLE__)
  std::string name(4096, '\0');
  auto size = static_cast<std::uint32_t>(name.size());
  if (::_NSGetExecutablePath(name.data(), &size) != 0) return {};
  return std::filesystem::canonical(name.c_str(), error);
#else
  return std::filesystem::read_symlink("/proc/self/exe", error);
#endif
}

void become(const std::filesystem::path& program, std::vector<std::string> words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(program.c_str(), arguments.data());
}

struct PipedProgram::State {
  bool start(const std::filesystem::path& program, const std::string& name, std::vector<std::string> words);
  void read();

  pid_t process = 0;
  int input = -1;   // of the other program, to write
  int output = -1;  // of the other program, to read
  std::string written;
  std::thread reader;
};

namespace {

// A pipe that no other program inherits.
bool make_pipe(int (&ends)[2]) {
  if (::pipe(ends) != 0) return false;
  for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  return true;
}

}  // namespace

bool PipedProgram::State::start(const std::filesystem::path& program, const std::string& name,
                                std::vector<std::string> words) {
  int in[2] = {-1, -1};
  int out[2] = {-1, -1};
  if (!make_pipe(in) || !make_pipe(out)) return false;
  input = in[1];
  output = out[0];
  words.insert(words.begin(), name);
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in[0], 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], 1);
  const int error = ::posix_spawn(&process, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(in[0]);
  ::close(out[1]);
  if (error != 0) {
    ::close(input);
    ::close(output);
  }
  return error == 0;
}

void PipedProgram::State::read() {
  std::string block(65536, '\0');
  for (ssize_t count = 0; (count = ::read(output, block.data(), block.size())) > 0;) {
    written.append(block.data(), static_cast<std::size_t>(count));
  }
}

bool PipedProgram::write(const void* bytes, std::size_t count) {
  const auto* at = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t done = ::write(state_->input, at, count);
    if (done < 0) return false;
    at += done;
    count -= static_cast<std::size_t>(done);
  }
  return true;
}

int PipedProgram::finish() {
  if (!is_running()) return 0;
  ::close(state_->input);
  state_->reader.join();
  ::close(state_->output);
  int status = 0;
  ::waitpid(state_->process, &status, 0);
  return status;
}

#endif

PipedProgram::PipedProgram(const std::string& name, const std::vector<std::string>& words) {
  const std::filesystem::path program = find_program(name);
  auto state = std::make_unique<State>();
  if (program.empty() || !state->start(program, name, words)) return;
#if !defined(_WIN32)
  std::signal(SIGPIPE, SIG_IGN);  // that it has ended is seen where it is written to
#endif
  state_ = std::move(state);
  state_->reader = std::thread(&State::read, state_.get());
}

PipedProgram::~PipedProgram() { finish(); }

bool PipedProgram::is_running() const { return state_ != nullptr && state_->reader.joinable(); }

const std::string& PipedProgram::output() const { return state_->written; }

}  // namespace knead::command
