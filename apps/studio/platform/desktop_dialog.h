// The file dialog of the desktop, where it has one: zenity, or kdialog on KDE. It runs in a process of its own.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace knead::studio {

// What the person is asked.
struct FileQuestion {
  std::string title;
  std::filesystem::path start;          // a folder that ends in '/', or a file to propose
  std::vector<std::string> extensions;  // ".ply"; of what is listed
  bool writes = false;
};

class DesktopDialog {
 public:
  // Opens the dialog. Returns nothing where the desktop has none, or it cannot be started.
  static std::optional<DesktopDialog> ask(const FileQuestion& question);

  // Closes the dialog if it is still open.
  ~DesktopDialog();
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
