// Where Studio reads and writes the files of the computer itself.
#include "platform/brought_files.h"

namespace knead::studio {

bool must_bring_files() { return false; }

void choose_files_to_bring() {}

}  // namespace knead::studio
