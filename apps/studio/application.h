// The window with the Studio in it.
#pragma once

#include <filesystem>
#include <optional>

#include "preferences.h"

namespace knead::studio {

struct ApplicationOptions {
  std::optional<std::filesystem::path> shape;  // a sphere where there is none
  std::optional<std::filesystem::path> session;
  std::optional<BackendChoice> backend;  // that of the preferences where there is none
};

// Runs until the person quits. Throws std::runtime_error where there is no display or no OpenGL.
void run_application(const ApplicationOptions& options);

}  // namespace knead::studio
