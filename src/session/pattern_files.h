// What a print presses in: text, and the files that it names.
#pragma once

#include <filesystem>
#include <memory>

#include "knead/stroke.h"
#include "math/grey_tile.h"

namespace knead::session_detail {

// Returns the pattern of a valid print. Throws InvalidInput, beginning with the key in quotes, for a file that cannot
// be read, for a font that is not found, and for a letter that it lacks.
std::shared_ptr<const GreyPattern> read_pattern(const PrintStroke& stroke, const std::filesystem::path& folder);

}  // namespace knead::session_detail
