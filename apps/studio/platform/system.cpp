// Folders, processes and dialogs of Linux, macOS and Windows.
#include "platform/system.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <utility>

#if defined(__unix__) && !defined(__EMSCRIPTEN__)
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#endif
#if defined(__APPLE__)
extern char** environ;  // declared nowhere
#endif

#if defined(_WIN32)
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
// after it
#include <commdlg.h>

#include <chrono>
#include <future>
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

// --- the file dialog of the desktop ----------------------------------------------------------------------------------

#if defined(__unix__) && !defined(__EMSCRIPTEN__)

namespace {

namespace fs = std::filesystem;

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool is_program(const std::string& name) {
  const std::string path = variable("PATH");
  for (std::size_t begin = 0; begin < path.size();) {
    const std::size_t end = std::min(path.find(':', begin), path.size());
    if (end > begin && ::access((path.substr(begin, end - begin) + "/" + name).c_str(), X_OK) == 0) return true;
    begin = end + 1;
  }
  return false;
}

// The dialog's command; empty: there is none.
std::vector<std::string> command_of(const FileQuestion& question) {
  if (variable("DISPLAY").empty() && variable("WAYLAND_DISPLAY").empty()) return {};
  std::string patterns;
  for (const std::string& extension : question.extensions) patterns += (patterns.empty() ? "*" : " *") + extension;
  const bool is_kde = variable("XDG_CURRENT_DESKTOP").find("KDE") != std::string::npos;
  if (is_program("kdialog") && (is_kde || !is_program("zenity"))) {
    const char* const use = question.writes ? "--getsavefilename" : "--getopenfilename";
    return {"kdialog", "--title", question.title, use, question.start.string(), patterns};
  }
  if (!is_program("zenity")) return {};
  std::vector<std::string> command{"zenity",
                                   "--file-selection",
                                   "--title=" + question.title,
                                   "--filename=" + question.start.string(),
                                   "--file-filter=" + patterns,
                                   "--file-filter=*"};
  if (question.writes) command.insert(command.begin() + 2, {"--save", "--confirm-overwrite"});
  return command;
}

}  // namespace

struct DesktopDialog::State {
  pid_t process = 0;   // 0: it has ended
  int output = -1;     // what it writes
  std::string text{};  // read so far

  State(pid_t of_process, int of_output) : process(of_process), output(of_output) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    ::close(output);
    if (process == 0) return;
    ::kill(process, SIGTERM);
    ::waitpid(process, nullptr, 0);
  }

  void read_on() {
    std::array<char, 4096> bytes{};
    for (ssize_t count = 0; (count = ::read(output, bytes.data(), bytes.size())) > 0;) {
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
  }
};

std::optional<DesktopDialog> DesktopDialog::ask(const FileQuestion& question) {
  std::vector<std::string> command = command_of(question);
  std::array<int, 2> pipe{};
  if (command.empty() || ::pipe2(pipe.data(), O_CLOEXEC) != 0) return std::nullopt;
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions{};
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, pipe[1], 1);
  pid_t process = 0;
  const int error = ::posix_spawnp(&process, arguments.front(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(pipe[1]);
  if (error != 0) {
    ::close(pipe[0]);
    return std::nullopt;
  }
  ::fcntl(pipe[0], F_SETFL, O_NONBLOCK);
  return DesktopDialog(std::make_unique<State>(process, pipe[0]));
}

std::optional<fs::path> DesktopDialog::answer() {
  state_->read_on();
  int status = 0;
  if (state_->process == 0 || ::waitpid(state_->process, &status, WNOHANG) == 0) return std::nullopt;
  state_->process = 0;
  state_->read_on();  // what came since
  std::string& text = state_->text;
  while (text.ends_with('\n')) text.pop_back();
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? fs::path(text) : fs::path();
}

#elif defined(_WIN32)

namespace {

namespace fs = std::filesystem;

// Asks in the thread that calls; empty: the person chose nothing.
fs::path ask_windows(const FileQuestion& question, HWND owner) {
  std::wstring patterns;
  for (const std::string& extension : question.extensions) {
    if (!patterns.empty()) patterns += L';';
    patterns += L"*" + fs::path(extension).wstring();
  }
  // Pairs of a name and its patterns, each with a zero at its end, and a zero after the last pair.
  const std::wstring zero(1, L'\0');
  const std::wstring filter = patterns + zero + patterns + zero + L"All files" + zero + L"*.*" + zero + zero;
  const std::wstring title = fs::path(question.title).wstring();
  const std::wstring folder = question.start.parent_path().make_preferred().wstring();
  constexpr std::size_t longest = 32'768;  // of Windows' names
  std::wstring file = question.start.filename().wstring();
  file.resize(longest);
  OPENFILENAMEW dialog{};
  dialog.lStructSize = sizeof(dialog);
  dialog.hwndOwner = owner;
  dialog.lpstrFilter = filter.c_str();
  dialog.lpstrFile = file.data();
  dialog.nMaxFile = longest;
  dialog.lpstrInitialDir = folder.c_str();
  dialog.lpstrTitle = title.c_str();
  dialog.Flags = OFN_EXPLORER | OFN_NOCHANGEDIR | OFN_HIDEREADONLY | OFN_PATHMUSTEXIST |
                 (question.writes ? OFN_OVERWRITEPROMPT : OFN_FILEMUSTEXIST);
  const BOOL chosen = question.writes ? ::GetSaveFileNameW(&dialog) : ::GetOpenFileNameW(&dialog);
  return chosen != FALSE ? fs::path(file.c_str()) : fs::path();
}

// Cancels a dialog of the thread whose number is `thread`.
BOOL CALLBACK cancel_dialog(HWND window, LPARAM /*unused*/) {
  ::PostMessageW(window, WM_COMMAND, IDCANCEL, 0);
  return TRUE;
}

}  // namespace

struct DesktopDialog::State {
  std::promise<DWORD> started{};
  std::future<fs::path> chosen{};

  explicit State(const FileQuestion& question) {
    chosen = std::async(std::launch::async, [this, question, owner = ::GetActiveWindow()] {
      started.set_value(::GetCurrentThreadId());
      return ask_windows(question, owner);
    });
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    const DWORD thread = started.get_future().get();
    while (chosen.valid() && chosen.wait_for(std::chrono::milliseconds(10)) != std::future_status::ready) {
      ::EnumThreadWindows(thread, cancel_dialog, 0);
      MSG ignored{};
      ::PeekMessageW(&ignored, nullptr, 0, 0,
                     PM_NOREMOVE);  // the dialog tells its owner that it ends, and waits for that
    }
  }
};

std::optional<DesktopDialog> DesktopDialog::ask(const FileQuestion& question) {
  return DesktopDialog(std::make_unique<State>(question));
}

std::optional<fs::path> DesktopDialog::answer() {
  if (state_->chosen.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
  return state_->chosen.get();
}

#else

struct DesktopDialog::State {};

std::optional<DesktopDialog> DesktopDialog::ask(const FileQuestion& /*question*/) { return std::nullopt; }

std::optional<std::filesystem::path> DesktopDialog::answer() { return std::filesystem::path(); }

#endif

DesktopDialog::DesktopDialog(std::unique_ptr<State> state) : state_(std::move(state)) {}
DesktopDialog::~DesktopDialog() = default;
DesktopDialog::DesktopDialog(DesktopDialog&& other) noexcept = default;
DesktopDialog& DesktopDialog::operator=(DesktopDialog&& other) noexcept = default;

}  // namespace knead::studio
