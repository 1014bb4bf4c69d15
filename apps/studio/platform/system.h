// The differences between systems for a program with a window.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace knead::studio {

// Where a person's settings and what programs keep between two runs are, below the home folder.
#if defined(_WIN32)
inline constexpr const char* kConfigUnderHome = "AppData/Roaming";
inline constexpr const char* kStateUnderHome = "AppData/Local";
#else
inline constexpr const char* kConfigUnderHome = ".config";
inline constexpr const char* kStateUnderHome = ".local/state";
#endif

// Returns the person's own folder; empty if the system does not say where it is.
std::filesystem::path home_folder();

// Returns the drives of Windows, such as C:\; empty on systems with one root for all.
std::vector<std::filesystem::path> drives();

// Writes what cannot be written without ending the program, and on Windows into the console that started it, if any.
// To be called first.
void prepare_program() noexcept;

// Writes one line to standard error; on Windows it is shown in a box if nobody sees that.
void show_failure(const std::string& line);

// What the person is asked.
struct FileQuestion {
  std::string title;
  std::filesystem::path start;          // a folder that ends in '/', or a file to propose
  std::vector<std::string> extensions;  // ".ply"; of what is listed
  bool writes = false;
};

// The file dialog of the desktop, where it has one: zenity, or kdialog on KDE, in a process of its own, or that of
// Windows, in a thread of its own.
class DesktopDialog {
 public:
  // Opens the dialog. Returns nothing where the desktop has none, or it cannot be started.
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
