// What systems do differently for a program with a window.
#pragma once

#include <filesystem>
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

}  // namespace knead::studio
