// The build without knead::gpu.
#include "backend.h"

namespace knead::command {

ChosenBackend choose_backend(const std::string& /*name*/, bool /*quiet*/) { return {}; }

}  // namespace knead::command
