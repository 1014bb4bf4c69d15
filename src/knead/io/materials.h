// The material files that an OBJ file names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "knead/io/shape_file.h"

namespace knead {

// Copies the material files of a shape that was read from `source` beside `target`, so that they are found there too,
// and returns the paths written. Only plain file names that end in .mtl are followed, to regular files, no links, of at
// most 64 MB in the source's own folder, whatever the shape's file says. A file that is there already stays as it is;
// so does all when both lie in one folder, or the shape is not from an OBJ file. What cannot be read is passed over, as
// the shape does not need it. Throws IoError(write).
std::vector<std::filesystem::path> copy_material_files(const ShapeFile& shape, const std::filesystem::path& source,
                                                       const std::filesystem::path& target);

}  // namespace knead
