// Pictures; without the renderer, `render` raises Unavailable.
#include "module.h"

#include "work.h"

#ifdef KNEAD_HAS_RENDER
#include <pybind11/stl.h>

#include <cmath>
#include <numbers>

#include "arrays.h"
#include "knead/editor/gl.h"
#include "knead/editor/render.h"
#include "knead/error.h"
#endif

namespace knead::python {

#ifdef KNEAD_HAS_RENDER

namespace {

// The keywords of render(), as Python has checked them.
struct Look {
  int width = 800;
  int height = 600;
  double azimuth_deg = 30;
  double elevation_deg = 20;
  bool z_up = false;
  double perspective = 25;
  std::string background = "white";
  std::string material = "clay";
  bool ground = true;
  bool wireframe = false;
  bool flat = false;
  bool cavity = false;
  bool occlusion = false;
};

// The direction in which a camera looks that stands at the azimuth (from the front towards +x) and elevation.
Vec3d direction_of(const Look& look) {
  const double azimuth = look.azimuth_deg * std::numbers::pi / 180;
  const double elevation = look.elevation_deg * std::numbers::pi / 180;
  const Vec3d v =
      -Vec3d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation)};
  return look.z_up ? Vec3d{v.x, -v.z, v.y} : v;
}

render::Options options_of(const Look& look) {
  render::Options options;
  options.width = look.width;
  options.height = look.height;
  if (look.background == "transparent") {
    options.background.alpha = 0;
  } else if (look.background != "white") {
    const auto background = render::background_named(look.background);
    if (!background) {
      throw InvalidInput(
          "background must be \"white\", \"transparent\", \"light\", \"dark\", \"gradient\" or a colour as "
          "\"#303540\", got \"" +
          look.background + "\"");
    }
    options.background = background->top;
    options.background_bottom = background->bottom;
  }
  options.matcap = render::matcap_named(look.material);
  if (!options.matcap && look.material != "clay") {
    std::string names = "\"clay\"";
    for (const render::Matcap matcap : render::all_matcaps()) names += ", \"" + std::string(name_of(matcap)) + "\"";
    throw InvalidInput("material must be one of " + names + ", got \"" + look.material + "\"");
  }
  options.relief = {look.cavity, look.occlusion};
  options.ground = look.ground;
  options.wireframe = look.wireframe;
  options.shading = look.flat ? render::Shading::flat : render::Shading::smooth;
  return options;
}

py::array_t<std::uint8_t> pixels_of(const render::Image& image, bool has_alpha) {
  const py::ssize_t channels = has_alpha ? 4 : 3;
  py::array_t<std::uint8_t> array({py::ssize_t{image.height}, py::ssize_t{image.width}, channels});
  std::uint8_t* out = array.mutable_data();
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (has_alpha || i % 4 != 3) *out++ = image.pixels[i];
  }
  return array;
}

// `flows`: the tools to draw, as flows that read no surface.
py::array_t<std::uint8_t> draw(const py::object& vertices, const py::object& faces, const std::vector<Flow>& flows,
                               const Look& look) {
  const Mesh mesh = mesh_from(points_from(vertices, "vertices"), faces);
  const render::Options options = options_of(look);
  render::Image image;
  Progress progress;
  try {
    run_watched(py::none(), progress, [&] {
      render::Scene scene;
      scene.shapes.emplace_back().mesh = &mesh;
      const Box box = render::shapes_box(scene);
      for (const Flow& flow : flows) render::draw_tool({flow, {}, {}}, box, scene);
      render::FitOptions fit;
      if (look.perspective == 0) fit.projection = render::Projection::orthographic;
      fit.field_of_view_deg = look.perspective;
      const Vec3d up = look.z_up ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0};
      const double aspect = static_cast<double>(look.width) / look.height;
      scene.camera = render::fit_points(render::scene_points(scene), direction_of(look), up, aspect, fit);
      image = render::render(scene, options);
    });
  } catch (const GpuError& error) {
    throw UnavailableError(error.what());
  }
  return pixels_of(image, look.background == "transparent");
}

}  // namespace

void add_render(py::module_& module) {
  py::class_<Look>(module, "Look")
      .def(py::init<>())
      .def_readwrite("width", &Look::width)
      .def_readwrite("height", &Look::height)
      .def_readwrite("azimuth_deg", &Look::azimuth_deg)
      .def_readwrite("elevation_deg", &Look::elevation_deg)
      .def_readwrite("z_up", &Look::z_up)
      .def_readwrite("perspective", &Look::perspective)
      .def_readwrite("background", &Look::background)
      .def_readwrite("material", &Look::material)
      .def_readwrite("ground", &Look::ground)
      .def_readwrite("wireframe", &Look::wireframe)
      .def_readwrite("flat", &Look::flat)
      .def_readwrite("cavity", &Look::cavity)
      .def_readwrite("occlusion", &Look::occlusion);
  module.def("render", &draw);
}

#else

void add_render(py::module_& module) { module.attr("render") = py::none(); }

#endif

}  // namespace knead::python
