// The build without knead::render.
#include <stdexcept>

#include "picture.h"

namespace knead::command {

void require_renderer() {
  throw std::runtime_error("this build has no renderer; install epoxy, EGL and stb, and build again");
}

std::string draw_picture(const PictureRequest& /*request*/) {
  require_renderer();
  return {};
}

}  // namespace knead::command
