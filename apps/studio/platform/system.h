// The differences between systems for a program with a window.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace knead::studio {

// The folders of settings and of program states, below the home folder.
#if defined(_WIN32)
inline constexpr const char* kConfigUnderHome = "AppData/Roaming";
inline constexpr const char* kStateUnderHome = "AppData/Local";
#else
inline constexpr const char* kConfigUnderHome = ".config";
inline constexpr const char* kStateUnderHome = ".local/state";
#endif

// Returns the user's home folder; empty if the system does not name it.
std::filesystem::path home_folder();

// Returns the drives of Windows, such as C:\; empty on systems with one root for all.
std::vector<std::filesystem::path> drives();

// Makes writing to a closed pipe, or beyond a limit on file sizes, fail instead of ending the program. On Windows,
// writes to the console that started it, if any. Call this first.
void prepare_program() noexcept;

// Writes one line to standard error; on Windows without a console, shows it in a box.
void show_failure(const std::string& line);

// A question for a file.
struct FileQuestion {
  std::string title;
  std::filesystem::path start;          // a folder that ends in '/', or a file to propose
  std::vector<std::string> extensions;  // ".ply"; of what is listed
  bool writes = false;
};

// The file dialog of the desktop, if it has one: zenity, or kdialog on KDE, in a process of its own; or that of
// Windows, in a thread of its own.
class DesktopDialog {
 public:
  // Opens the dialog. Returns nothing if the desktop has none, or it cannot be started.
  static std::optional<DesktopDialog> ask(const FileQuestion& question);

  // Closes the dialog if it is still open.
  ~DesktopDialog();
  DesktopDialog(const DesktopDialog&) = delete;
  DesktopDialog& operator=(const DesktopDialog&) = delete;
  DesktopDialog(DesktopDialog&& other) noexcept;
  DesktopDialog& operator=(DesktopDialog&& other) noexcept;

  // Returns the file that was chosen, empty if none was, or nothing while the dialog is open. Does not wait.
  std::optional<std::filesystem::path> answer();

 private:
  struct State;
  explicit DesktopDialog(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace knead::studio
