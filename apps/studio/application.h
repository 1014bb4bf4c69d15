// Studio in a window: runs it until it is closed, step by step, or by a script without a window.
#pragma once

#include <filesystem>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "preferences.h"
#include "studio.h"

namespace knead::studio {

struct ApplicationOptions {
  std::optional<std::filesystem::path> shape;  // none: a sphere
  std::vector<std::filesystem::path> also;     // further shapes
  std::optional<std::filesystem::path> session;
  std::optional<BackendChoice> backend;  // none: that of the preferences
};

// Runs until the user quits. Throws std::runtime_error without a display or OpenGL.
void run_application(const ApplicationOptions& options);

class Application;

// The same for systems that ask for each picture, as browsers do. If no thread can be started, step() does all work.
class SteppedApplication {
 public:
  explicit SteppedApplication(const ApplicationOptions& options);
  ~SteppedApplication();
  SteppedApplication(const SteppedApplication&) = delete;
  SteppedApplication& operator=(const SteppedApplication&) = delete;

  // Handles the events, and draws a picture if something changed. Returns false once the user has quit.
  bool step();

  // Returns the latest message while it is shown; else an empty text.
  std::string message() const;

 private:
  std::unique_ptr<Studio> studio_;
  std::unique_ptr<Application> application_;
};

// --- without a window
// -------------------------------------------------------------------------------------------------

// Runs a script (script.h) to its end and closes the document. Writes Studio's notices to standard error and returns
// true if none of them is an error. Pictures need OpenGL but no display; `backend` moves the shape in them during a
// drag. Throws as run_script, and as GpuPreview if there is no suitable GPU.
bool run_headless(std::istream& script, const std::string& name, const StudioOptions& options, BackendChoice backend);

}  // namespace knead::studio
