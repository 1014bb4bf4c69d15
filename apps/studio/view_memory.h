// The camera, the tool, its settings and the pins as lines of a script (script.h), which the journal keeps: after a
// crash Studio looks as it did before.
#pragma once

#include <string>

#include "studio.h"

namespace knead::studio {

// Returns the lines that give another Studio this view and these settings.
std::string script_of_view(Studio& studio);

// Carries the lines out. Reports and ignores what this version does not know.
void restore_view(Studio& studio, const std::string& script);

}  // namespace knead::studio
