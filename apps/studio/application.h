// The window with the Studio in it.
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
  std::optional<std::filesystem::path> shape;  // a sphere where there is none
  std::vector<std::filesystem::path> also;     // further shapes
  std::optional<std::filesystem::path> session;
  std::optional<BackendChoice> backend;  // that of the preferences where there is none
};

// Runs until the person quits. Throws std::runtime_error where there is no display or no OpenGL.
void run_application(const ApplicationOptions& options);

class Application;

// The same, where the system asks for one picture after the other, as a browser does. Where no thread can be started,
// all work is done in step().
class SteppedApplication {
 public:
  explicit SteppedApplication(const ApplicationOptions& options);
  ~SteppedApplication();
  SteppedApplication(const SteppedApplication&) = delete;
  SteppedApplication& operator=(const SteppedApplication&) = delete;

  // Takes the events, and draws a picture if something changes. Returns false once the person has quit.
  bool step();

  // The message that appeared last, while it is shown; empty: none.
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
