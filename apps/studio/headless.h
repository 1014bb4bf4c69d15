// Studio without a window: a script, and pictures of what a window would show between its panels.
#pragma once

#include <istream>
#include <string>

#include "studio.h"

namespace knead::studio {

// Runs a script (script.h) to its end and puts the work away. What Studio tells goes to standard error; returns whether
// there was no error among it. Pictures need OpenGL, no display; `backend` moves what is in them while a hand does.
// Throws as run_script, and as CardShape where there is no graphics card for it.
bool run_headless(std::istream& script, const std::string& name, const StudioOptions& options, BackendChoice backend);

}  // namespace knead::studio
