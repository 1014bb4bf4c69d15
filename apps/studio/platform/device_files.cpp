// Where Studio reads and writes the files of the device itself.
#include "platform/device_files.h"

namespace knead::studio {

bool has_device_files() { return false; }

void choose_device_files() {}

}  // namespace knead::studio
