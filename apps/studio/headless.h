// Studio without a window: a script, and pictures of what a window would show between its panels.
#pragma once

#include <istream>
#include <string>

#include "studio.h"

namespace knead::studio {

// Runs a script (script.h) to its end and closes the document. Writes Studio's notices to standard error and returns
// true if none of them is an error. Pictures need OpenGL but no display; `backend` moves the shape in them during a
// drag. Throws as run_script, and as GpuPreview if there is no suitable GPU.
bool run_headless(std::istream& script, const std::string& name, const StudioOptions& options, BackendChoice backend);

}  // namespace knead::studio
