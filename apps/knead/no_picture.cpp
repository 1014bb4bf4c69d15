// The build without knead::render.
#include <stdexcept>

#include "picture.h"

namespace knead::command {

void require_renderer() {
  throw std::runtime_error("this build has no renderer; install epoxy, EGL and stb, and build again");
}

std::optional<render::Matcap> read_material(const std::string& /*name*/) { return std::nullopt; }

render::Background read_background(const std::string& /*name*/) { return {}; }

std::string material_names() { return "clay"; }

std::string draw_picture(const PictureRequest& /*request*/, const std::function<void(double)>& /*progress*/) {
  require_renderer();
  return {};
}

}  // namespace knead::command
