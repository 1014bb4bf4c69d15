// The build without knead::render.
#include <stdexcept>

#include "film.h"

namespace knead::command {

void require_renderer() {
  throw std::runtime_error("this build has no renderer; install epoxy, EGL and stb, and build again");
}

std::optional<render::Matcap> read_material(const std::string& /*name*/) { return std::nullopt; }

render::Background read_background(const std::string& /*name*/) { return {}; }

std::string material_names() { return "clay"; }

render::Image draw_image(const PictureRequest& /*request*/, const std::function<void(double)>& /*progress*/) {
  require_renderer();
  return {};
}

std::vector<Vec3d> outermost_points(std::span<const Vec3d> /*positions*/) { return {}; }

void check_film_output(const std::string& /*output*/) {}

void write_film(const FilmRequest& /*film*/, bool /*quiet*/) { require_renderer(); }

std::string draw_picture(const PictureRequest& /*request*/, const std::function<void(double)>& /*progress*/) {
  require_renderer();
  return {};
}

}  // namespace knead::command
