// Draws pictures and writes films. A build without knead::render has neither, and says so.
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "command.h"
#include "deform.h"
#include "knead/editor/render.h"
#include "knead/io.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "output.h"
#include "program.h"
#include "render.h"

namespace knead::command {

#ifdef KNEAD_HAS_RENDERER

namespace {

using render::Image;
using render::Scene;

std::vector<Scene> scenes_of(const PictureRequest& request) {
  std::vector<Scene> scenes(request.panels.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Panel& panel = request.panels[i];
    render::Shape& shape = scenes[i].shapes.emplace_back();
    shape.mesh = &panel.shape;
    shape.use_mesh_colors = true;
    const Box box = render::shapes_box(scenes[i]);
    for (const render::DrawnTool& tool : panel.tools) render::draw_tool(tool, box, scenes[i]);
    if (request.cut) scenes[i].clip = {.normal = request.cut->normal, .offset = request.cut->offset};
  }
  return scenes;
}

// The camera of fit_camera moved sideways and in or out.
render::Camera close_up_camera(const render::Camera& fitted, const CloseUp& close_up) {
  render::Camera camera = fitted;
  camera.target = close_up.target;
  camera.eye = close_up.target + (fitted.eye - fitted.target) * (close_up.height / fitted.height);
  camera.height = close_up.height;
  return camera;
}

render::Camera fitted(const PictureRequest& request, const std::vector<Vec3d>& points, double aspect) {
  render::FitOptions how;
  if (request.field_of_view_deg == 0) how.projection = render::Projection::orthographic;
  how.field_of_view_deg = request.field_of_view_deg;
  return render::fit_points(points, request.view, request.up, aspect, how);
}

// The points of each scene, each about the middle of its own box, so that one camera is right for all.
void set_cameras_of_one_scale(const PictureRequest& request, double aspect, std::vector<Scene>& scenes) {
  std::vector<Vec3d> points;
  std::vector<Vec3d> middles;
  for (const Scene& scene : scenes) {
    const Box box = render::scene_box(scene);
    middles.push_back(box.empty() ? Vec3d{} : box.center());
    for (const Vec3d& p : render::scene_points(scene)) points.push_back(p - middles.back());
  }
  const render::Camera camera = fitted(request, points, aspect);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].camera = camera;
    scenes[i].camera.eye += middles[i];
    scenes[i].camera.target += middles[i];
  }
}

void set_cameras(const PictureRequest& request, double aspect, std::vector<Scene>& scenes) {
  if (request.same_scale) return set_cameras_of_one_scale(request, aspect, scenes);
  std::vector<Vec3d> points = request.shown;
  for (const Scene& scene : scenes) {
    if (!request.shown.empty()) break;
    std::vector<Vec3d> own = render::scene_points(scene);
    if (points.empty()) std::swap(points, own);
    points.insert(points.end(), own.begin(), own.end());
  }
  render::Camera camera = fitted(request, points, aspect);
  if (request.close_up) camera = close_up_camera(camera, *request.close_up);
  for (Scene& scene : scenes) scene.camera = camera;
}

render::Options options_of(const PictureRequest& request) {
  render::Options options;
  options.height = request.height;
  options.background = request.background.top;
  options.background_bottom = request.background.bottom;
  options.matcap = request.matcap;
  options.relief = request.relief;
  switch (request.quality) {
    case PictureQuality::draft:
      options.supersampling = 1;
      options.light_samples = 32;
      break;
    case PictureQuality::normal:
      break;
    case PictureQuality::fine:
      options.supersampling = 3;
      options.light_samples = 256;
      break;
  }
  options.shading = request.flat ? render::Shading::flat : render::Shading::smooth;
  options.wireframe = request.wireframe;
  options.ground = request.ground;
  return options;
}

std::string kind_of(const std::string& output) {
  constexpr std::string_view kinds[] = {"gif", "mp4", "png", "jpg", "jpeg"};
  std::string kind = require_extension(output, kinds);
  const bool is_film = kind == "gif" || kind == "mp4";
  if (is_film != is_pattern(output)) return kind;
  throw UsageError(fmt::format(
      "--output {}: with --frames or --turntable, name a .gif or .mp4, or give a pattern for numbered pictures, as "
      "F_%04d.png",
      output));
}

// ffmpeg, which makes a film of the pixels that it is given.
class Encoder {
 public:
  Encoder(int width, int height, double fps)
      : program_("ffmpeg", {"-loglevel",
                            "quiet",
                            "-f",
                            "rawvideo",
                            "-pixel_format",
                            "rgba",
                            "-video_size",
                            fmt::format("{}x{}", width, height),
                            "-framerate",
                            fmt::format("{}", fps),
                            "-i",
                            "pipe:0",
                            "-vf",
                            "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                            "-c:v",
                            "libx264",
                            "-crf",
                            "20",
                            "-pix_fmt",
                            "yuv420p",
                            "-movflags",
                            "frag_keyframe+empty_moov",
                            "-f",
                            "mp4",
                            "pipe:1"}) {
    if (!program_.is_running()) {
      throw std::runtime_error("ffmpeg cannot be started; write a .gif, or a pattern as F_%04d.png");
    }
  }

  void add(const render::Image& image) {
    if (!program_.write(image.pixels.data(), image.pixels.size())) {
      throw std::runtime_error("ffmpeg ended early; write a .gif, or a pattern as F_%04d.png");
    }
  }

  // Returns the bytes of the film.
  const std::string& finish() {
    const int status = program_.finish();
    if (status != 0 || program_.output().empty()) {
      throw std::runtime_error(fmt::format(
          "ffmpeg failed (status {}); it may lack libx264: write a .gif, or a pattern as F_%04d.png", status));
    }
    return program_.output();
  }

 private:
  PipedProgram program_;
};

// The files of the pictures.
class Film {
 public:
  explicit Film(const FilmRequest& request) : request_(request), kind_(kind_of(request.output)) {
    if (is_pattern(request.output)) {
      pattern_ = parse_frame_pattern(request.output);
    } else {
      file_.emplace(request.output);
    }
  }

  void add(const render::Image& image) {
    if (pattern_) {
      write_file_atomically(frame_path(*pattern_, next_),
                            kind_ == "png" ? render::encode_png(image) : render::encode_jpeg(image));
    } else if (kind_ == "gif") {
      if (next_ == 0) file_->write(render::gif_header(image.width, image.height));
      const auto time_of = [&](int k) { return std::lround(100 * k / request_.fps); };
      file_->write(render::gif_picture(image, next_ == 0 ? nullptr : &before_,
                                       static_cast<int>(time_of(next_ + 1) - time_of(next_))));
      before_ = image;
    } else {
      if (!encoder_) encoder_.emplace(image.width, image.height, request_.fps);
      encoder_->add(image);
    }
    ++next_;
  }

  void finish() {
    if (pattern_) return;
    file_->write(kind_ == "gif" ? render::gif_end() : encoder_->finish());
    file_->finish();
  }

 private:
  const FilmRequest& request_;
  std::string kind_;
  std::optional<FramePattern> pattern_;
  std::optional<AtomicFile> file_;
  std::optional<Encoder> encoder_;
  render::Image before_;
  int next_ = 0;
};

}  // namespace

void require_renderer() {}

std::string material_names() {
  std::string names = "clay";
  for (const render::Matcap matcap : render::all_matcaps()) names += ", " + std::string(name_of(matcap));
  return names;
}

std::optional<render::Matcap> read_material(const std::string& name) {
  const std::optional<render::Matcap> matcap = render::matcap_named(name);
  if (!matcap && name != "clay") throw UsageError("--material " + name + ": say one of " + material_names());
  return matcap;
}

render::Background read_background(const std::string& name) {
  if (name == "white") return {{1, 1, 1, 1}, {1, 1, 1, 1}};
  if (name == "transparent") return {{1, 1, 1, 0}, {1, 1, 1, 0}};
  if (const auto background = render::background_named(name)) return *background;
  throw UsageError("--background " + name + ": say white, transparent, light, dark, gradient, or a colour as #303540");
}

render::Image draw_image(const PictureRequest& request, const std::function<void(double)>& progress) {
  std::vector<Scene> scenes = scenes_of(request);
  const int count = static_cast<int>(scenes.size());
  const int width = request.width / count;
  set_cameras(request, static_cast<double>(width) / request.height, scenes);
  render::Options options = options_of(request);
  std::vector<Image> images;
  for (int i = 0; i < count; ++i) {
    options.width = width + (i < request.width % count ? 1 : 0);
    options.progress = [&, i](double part) { progress((i + part) / count); };
    const Scene& scene = scenes[static_cast<std::size_t>(i)];
    const bool is_splats = are_splats(*scene.shapes.front().mesh);
    images.push_back(is_splats ? render::render_splats(*scene.shapes.front().mesh, scene.camera, options)
                               : render::render(scene, options));
  }
  return render::side_by_side(images);
}

std::string draw_picture(const PictureRequest& request, const std::function<void(double)>& progress) {
  const Image picture = draw_image(request, progress);
  return request.format == ImageFormat::jpeg ? render::encode_jpeg(picture) : render::encode_png(picture);
}

std::vector<Vec3d> outermost_points(std::span<const Vec3d> positions) { return render::outermost_points(positions); }

std::vector<Vec3d> turntable_points(std::span<const Vec3d> positions, const Vec3d& middle, int count, bool is_z_up) {
  return render::turntable_points(positions, middle, count, is_z_up);
}

void check_film_output(const std::string& output) {
  if (kind_of(output) == "mp4" && find_program("ffmpeg").empty()) {
    throw UsageError(fmt::format(
        "--output {}: needs the program ffmpeg, which is not installed; install it, or write a .gif or F_%04d.png",
        output));
  }
  require_writable(is_pattern(output) ? frame_path(parse_frame_pattern(output), 0) : output);
}

void write_film(const FilmRequest& film, bool quiet) {
  Film output(film);
  constexpr std::uint64_t each = 1000;
  Progress progress;
  ProgressBar bar(progress, each * static_cast<std::uint64_t>(film.pictures), !quiet, film.pictures);
  std::uint64_t done = 0;
  film.play([&](const PictureRequest& picture) {
    output.add(draw_image(picture, [&](double part) {
      progress.done = done + static_cast<std::uint64_t>(part * static_cast<double>(each));
    }));
    done += each;
    bar.count_frame();
  });
  output.finish();
}

#else  // the build without knead::render

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

std::vector<Vec3d> turntable_points(std::span<const Vec3d> /*positions*/, const Vec3d& /*middle*/, int /*count*/,
                                    bool /*is_z_up*/) {
  return {};
}

void check_film_output(const std::string& /*output*/) {}

void write_film(const FilmRequest& /*film*/, bool /*quiet*/) { require_renderer(); }

std::string draw_picture(const PictureRequest& /*request*/, const std::function<void(double)>& /*progress*/) {
  require_renderer();
  return {};
}

#endif

}  // namespace knead::command
