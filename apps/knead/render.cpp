// knead render SHAPE... -o IMAGE.png: draws a picture without a window.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "deform.h"
#include "inputs.h"
#include "json/json.h"
#include "knead/io.h"
#include "output.h"
#include "render.h"

namespace knead::command {
namespace {

struct RenderOptions {
  PanelOptions panels;
  DistanceColors distances;
  std::string until;
  std::string cut;
  std::string close_up;
  std::string output;
  std::string size = "1600x1200";
  std::string view = "iso";
  bool is_z_up = false;
  std::string background = "white";
  std::string material = "clay";
  PictureQuality quality = PictureQuality::normal;
  double perspective = 25;
  bool cavity = false;
  bool occlusion = false;
  bool no_ground = false;
  bool flat = false;
  bool wireframe = false;
  bool same_scale = false;
  FrameFlags frames;
  std::optional<int> turntable;
  CommonOptions common;
};

// Returns the numbers of "1,0.5,2"; none for other texts.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    double number = 0;
    const auto parsed = std::from_chars(at, end, number);
    if (parsed.ec != std::errc{} || !std::isfinite(number)) return {};
    numbers.push_back(number);
    if (parsed.ptr == end) return numbers;
    if (*parsed.ptr != ',') return {};
    at = parsed.ptr + 1;
  }
}

// Returns the two numbers of "1600x1200" or "30,-20"; nothing for other texts.
template <class T>
std::optional<std::pair<T, T>> two_numbers(std::string_view text, char separator) {
  const char* const end = text.data() + text.size();
  std::pair<T, T> numbers;
  const auto first = std::from_chars(text.data(), end, numbers.first);
  if (first.ec != std::errc{} || first.ptr == end || *first.ptr != separator) return {};
  const auto second = std::from_chars(first.ptr + 1, end, numbers.second);
  if (second.ec != std::errc{} || second.ptr != end) return {};
  return numbers;
}

void set_size(const RenderOptions& options, PictureRequest& request) {
  constexpr int least = 16;
  constexpr int most = 8192;
  const auto size = two_numbers<int>(options.size, 'x');
  const auto is_fine = [](int n) { return n >= least && n <= most; };
  const int panels = static_cast<int>(std::max(options.panels.shapes.size(), options.panels.moments.size()));
  if (!size || !is_fine(size->first) || !is_fine(size->second) || size->first / panels < least) {
    throw UsageError(
        fmt::format("--size {}: give WIDTHxHEIGHT in pixels, as 1600x1200, each from {} to {} (and {} for "
                    "each shape)",
                    options.size, least, most, least));
  }
  request.width = size->first;
  request.height = size->second;
}

void set_view(const RenderOptions& options, PictureRequest& request) {
  struct Entry {
    std::string_view name;
    double azimuth;
    double elevation;
  };
  constexpr std::array<Entry, 7> entries{{{"front", 0, 0},
                                          {"back", 180, 0},
                                          {"left", -90, 0},
                                          {"right", 90, 0},
                                          {"top", 0, 90},
                                          {"bottom", 0, -90},
                                          {"iso", 35, 25}}};
  std::optional<std::pair<double, double>> angles = two_numbers<double>(options.view, ',');
  for (const Entry& entry : entries) {
    if (options.view == entry.name) angles = {entry.azimuth, entry.elevation};
  }
  if (!angles || !std::isfinite(angles->first) || !(std::abs(angles->second) <= 90)) {
    throw UsageError(
        fmt::format("--view {}: say front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in "
                    "degrees, as 30,20",
                    options.view));
  }
  const render::ViewDirection view = render::view_direction(angles->first, angles->second, options.is_z_up);
  request.view = view.direction;
  request.up = view.up;
}

void set_cut(const RenderOptions& options, PictureRequest& request) {
  if (options.cut.empty()) return;
  const std::vector<double> n = numbers_of(options.cut);
  if (n.size() != 4 || (n[0] == 0 && n[1] == 0 && n[2] == 0)) {
    throw UsageError(
        fmt::format("--cut {}: give NX,NY,NZ,OFFSET, as 1,0,0,0.2: a normal that is not zero, and where the plane lies",
                    options.cut));
  }
  request.cut = CutPlane{{n[0], n[1], n[2]}, n[3]};
}

void set_close_up(const RenderOptions& options, PictureRequest& request) {
  if (options.close_up.empty()) return;
  const std::vector<double> n = numbers_of(options.close_up);
  if (n.size() != 4 || !(n[3] > 0)) {
    throw UsageError(
        fmt::format("--close-up {}: give X,Y,Z,HEIGHT, as 0,1,0,0.5: a point, and a height above 0", options.close_up));
  }
  if (options.same_scale)
    throw UsageError("--close-up: does not work with --same-scale, which centres each shape; leave one of them out");
  request.close_up = CloseUp{{n[0], n[1], n[2]}, n[3]};
}

void set_format(const RenderOptions& options, PictureRequest& request) {
  constexpr std::string_view extensions[] = {"png", "jpg", "jpeg"};
  request.format = require_extension(options.output, extensions) == "png" ? ImageFormat::png : ImageFormat::jpeg;
  if (request.background.top.alpha == 0 && request.format == ImageFormat::jpeg) {
    throw UsageError("--background transparent: a JPEG has no transparent parts; write a .png file");
  }
}

void set_look(const RenderOptions& options, PictureRequest& request) {
  request.background = read_background(options.background);
  request.matcap = read_material(options.material);
  request.quality = options.quality;
  request.field_of_view_deg = options.perspective;
  request.relief = {options.cavity, options.occlusion};
}

// Returns the job of the options, without the panels and the format.
PictureRequest look_of(const RenderOptions& options) {
  PictureRequest request;
  set_size(options, request);
  set_view(options, request);
  set_cut(options, request);
  set_close_up(options, request);
  set_look(options, request);
  request.ground = !options.no_ground;
  request.flat = options.flat;
  request.wireframe = options.wireframe;
  request.same_scale = options.same_scale;
  return request;
}

PanelOptions panel_options(const RenderOptions& options) {
  PanelOptions panels = options.panels;
  if (!options.until.empty()) {
    panels.moments = numbers_of(options.until);
    if (panels.moments.empty()) {
      throw UsageError(fmt::format("--until {}: give moments in strokes, as 0,0.5,1", options.until));
    }
  }
  panels.quiet = options.common.quiet;
  check_usage(panels);
  return panels;
}

std::string draw_watched(const PictureRequest& request, bool quiet) {
  constexpr std::uint64_t total = 1000;
  Progress progress;
  const ProgressBar bar(progress, total, !quiet);
  return draw_picture(request, [&](double part) { progress.done = static_cast<std::uint64_t>(part * total); });
}

// All pictures are drawn by one camera, which shows every frame.
FilmRequest film_of_session(const RenderOptions& options, PictureRequest& request) {
  const auto inputs = std::make_shared<Inputs>(read_inputs(options.panels.shapes.front(), options.panels.format,
                                                           {options.panels.session}, options.common.quiet));
  ReplayOptions replay;
  if (inputs->shape.mesh.face_count() == 0) replay.normals = vertex_normals_of(inputs->shape);
  replay.may_cross = true;  // a picture shows it
  replay.frames = frame_options(options.frames);
  replay.frames.deliver = [&](const ReplayFrame& frame) {
    const std::vector<Vec3d> points = outermost_points(frame.shape.positions());
    request.shown.insert(request.shown.end(), points.begin(), points.end());
  };
  const ReplayResult played = replay_watched(inputs->shape.mesh, inputs->session, replay, options.common.quiet);
  if (!options.common.quiet) print_notes(played.shortfalls);
  FilmRequest film{options.output, frame_count(replay.frames), options.frames.frames_per_second()};
  film.play = [inputs, replay, &request](const auto& draw) mutable {
    request.panels.resize(1);
    replay.frames.deliver = [&](const ReplayFrame& frame) {
      request.panels.front().shape = frame.shape.to_mesh();
      draw(request);
    };
    replay_watched(inputs->shape.mesh, inputs->session, replay, true);
  };
  return film;
}

// Moves the camera round the middle of the shapes, at a distance from which all sides are completely visible.
FilmRequest film_of_turntable(const RenderOptions& options, PictureRequest& request) {
  request.panels = make_panels(options.panels);
  Box box;
  for (const Panel& panel : request.panels) {
    for (const Vec3d& p : panel.shape.positions) box.extend(p);
  }
  const Vec3d middle = box.center();
  const int count = *options.turntable;
  const bool is_z_up = options.is_z_up;
  for (const Panel& panel : request.panels) {
    const std::vector<Vec3d> points = turntable_points(panel.shape.positions, middle, count, is_z_up);
    request.shown.insert(request.shown.end(), points.begin(), points.end());
  }
  FilmRequest film{options.output, count, options.frames.frames_per_second()};
  film.play = [is_z_up, count, view = request.view, up = request.up, &request](const auto& draw) {
    for (int k = 0; k < count; ++k) {
      const Mat3d turn = render::turntable_turn(k, count, is_z_up);
      request.view = turn * view;
      request.up = turn * up;
      draw(request);
    }
  };
  return film;
}

void check_distances(const DistanceColors& distances) {
  if (!distances.greatest) return;
  if (distances.shape.empty()) throw UsageError("--distance-max: needs --distance-to to know the distances");
}

void check_film(const RenderOptions& options) {
  const FrameFlags& frames = options.frames;
  const char* const name = options.turntable ? "--turntable" : "--frames";
  if (frames.frames && options.turntable) {
    throw UsageError("--frames moves the shape and --turntable the camera; give one of them");
  }
  if (!options.turntable) frame_options(frames);
  if (!options.panels.moments.empty()) throw UsageError(fmt::format("--until: does not work with {}", name));
  if (!options.distances.shape.empty()) throw UsageError(fmt::format("--distance-to: does not work with {}", name));
  if (frames.frames && (options.panels.session.empty() || options.panels.shapes.size() != 1)) {
    throw UsageError("--frames: give one shape, and its --session");
  }
  check_film_output(options.output);
}

void run_film(RenderOptions options) {
  options.panels = panel_options(options);
  check_film(options);
  PictureRequest request = look_of(options);
  check_streams(options.panels.shapes, options.panels.format);
  require_renderer();
  const FilmRequest film =
      options.frames.frames ? film_of_session(options, request) : film_of_turntable(options, request);
  write_film(film, options.common.quiet);
  if (options.common.json) {
    print(to_indented_text(Json{{"width", request.width}, {"height", request.height}, {"pictures", film.pictures}}));
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} of {} x {} pixels\n", options.output,
                      counted(static_cast<std::size_t>(film.pictures), "picture"), request.width, request.height));
  }
}

void run_render(RenderOptions options) {
  if (options.frames.frames || options.turntable) return run_film(std::move(options));
  frame_options(options.frames);
  options.panels = panel_options(options);
  check_distances(options.distances);
  PictureRequest request = look_of(options);
  set_format(options, request);
  check_streams(options.panels.shapes, options.panels.format);
  require_renderer();
  require_writable(options.output);
  request.panels = make_panels(options.panels);
  std::optional<double> greatest;
  if (!options.distances.shape.empty()) {
    greatest = color_by_distance(options.distances, options.common.quiet, request.panels);
  }
  write_file_atomically(options.output, draw_watched(request, options.common.quiet));
  if (options.common.json) {
    Json json{{"width", request.width}, {"height", request.height}};
    if (greatest) json.set("greatest_distance", *greatest);
    print(to_indented_text(json));
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} x {} pixels\n", options.output, request.width, request.height));
    if (greatest) print(fmt::format("dark red: {:.4g} or more from {}\n", *greatest, options.distances.shape));
  }
}

std::vector<Option> describe(RenderOptions& options) {
  std::vector<Option> result{
      {"SHAPE", &options.panels.shapes, "One or more meshes or point clouds, drawn side by side", "",
       OptionKind::required},
      {"-o,--output", &options.output,
       "The .png or .jpg file to write; with --frames or --turntable a .gif, an .mp4 (by ffmpeg), or a pattern with "
       "one "
       "%04d for numbered pictures",
       "FILE", OptionKind::required},
      {"--frames", &options.frames.frames, "Draw N evenly spaced moments of the session", "N", OptionKind::optional,
       from_to(1, kMaxFrames), fmt::format("give 1 to {}", kMaxFrames)},
      {"--turntable", &options.turntable, "Draw N pictures from all around", "N", OptionKind::optional,
       from_to(1, kMaxFrames), fmt::format("give 1 to {}", kMaxFrames)},
      {"--session", &options.panels.session,
       "Draw this session's tools over the first shape: in red where the motion is rigid (of a wide ball: its bump), "
       "in green where it ends",
       "FILE"},
      {"--stroke", &options.panels.stroke, "Draw only the tool of this stroke, counted from 1", "N"},
      {"--until", &options.until,
       "Draw the one shape after S strokes of the session, with a panel for each S; 2.5 is halfway through the "
       "third stroke",
       "S,S,..."},
      {"--tools", word_target(options.panels.tools, {"first", "each", "none"}),
       "first: all tools in the first panel; each: in every panel the tool that is at work then; none: no tools",
       "WHERE", OptionKind::with_default},
      {"--distance-to", &options.distances.shape,
       "Colour the shapes by the distance of their vertices from this one: clay at 0, then orange and dark red",
       "FILE"},
      {"--distance-max", &options.distances.greatest,
       "The distance that is dark red (the greatest in the picture), in the units of the shapes", "D",
       OptionKind::optional, is_above_zero, "give a distance above 0"},
      {"--cut", &options.cut, "Remove everything beyond the plane N.x = OFFSET, and show the cut", "NX,NY,NZ,OFFSET"},
      {"--size", &options.size, "WIDTHxHEIGHT of the whole picture in pixels", "WxH", OptionKind::with_default},
      {"--view", &options.view, "front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees", "NAME",
       OptionKind::with_default},
      {"--up", word_target(options.is_z_up, {"y", "z"}), "The axis that points up, y or z", "AXIS",
       OptionKind::with_default},
      {"--close-up", &options.close_up,
       "Look at this point; the picture is HEIGHT high there, in the units of the shape", "X,Y,Z,HEIGHT"},
      {"--perspective", &options.perspective, "Field of view from bottom to top in degrees; 0: orthographic", "DEG",
       OptionKind::with_default, [](double degrees) { return degrees == 0 || (degrees >= 1 && degrees <= 120); },
       "give an angle from 1 to 120 degrees, or 0 for none"},
      {"--material", &options.material, material_names(), "NAME", OptionKind::with_default},
      {"--cavity", &options.cavity, "Darken grooves and brighten ridges"},
      {"--occlusion", &options.occlusion, "Darken folds and corners"},
      {"--background", &options.background, "white, transparent, light, dark, gradient, or a colour #RRGGBB", "COLOR",
       OptionKind::with_default},
      {"--quality", word_target(options.quality, {"draft", "normal", "fine"}),
       "draft, normal or fine: more samples take longer", "NAME", OptionKind::with_default},
      {"--no-ground", &options.no_ground, "Draw no shadow on the ground"},
      {"--flat", &options.flat, "Shade each face evenly"},
      {"--wireframe", &options.wireframe, "Draw the edges of the faces as lines"},
      {"--same-scale", &options.same_scale,
       "Centre each shape in its own panel, all at one scale; without this, all panels share one camera"},
  };
  add_time_options(result, options.frames);
  add_format_option(result, options.panels.format);
  add_common_options(result, options.common);
  return result;
}

}  // namespace

Subcommand render_command() {
  const auto options = std::make_shared<RenderOptions>();
  return {"render", "Draw a picture of shapes and of the tools of a session", describe(*options),
          "  knead render hand.ply -o hand.png\n"
          "  knead render hand.ply bent.ply --session bend.knead --view front -o before_after.png\n"
          "  knead render hand.ply --session bend.knead --until 0,0.5,1 --tools each --size 2400x1000 -o steps.png\n"
          "  knead render scan.ply fitted.ply --distance-to target.ply -o distances.png\n"
          "  knead render ball.ply pulled.ply --cut 1,0,0,0 --view right -o inside.jpg\n"
          "  knead render hand.ply --session bend.knead --frames 48 --ease smooth --size 480x360 -o bend.gif\n"
          "  knead render scan.ply --turntable 72 --size 960x720 -o scan.mp4\n"
          "  knead render scan.ply --material jade --cavity --background dark -o jade.png\n"
          "  knead render scan.ply --view -30,15 --size 800x600 --background transparent -o scan.png",
          [options] { run_render(*options); }};
}

}  // namespace knead::command
