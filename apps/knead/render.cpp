// knead render SHAPE... -o IMAGE.png: an off-screen picture.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "knead/io/atomic_file.h"
#include "knead/io/shape_file.h"
#include "knead/session/session.h"
#include "output.h"
#include "picture.h"

namespace knead::command {
namespace {

struct RenderOptions {
  std::vector<std::string> shapes;
  std::string output;
  std::string session;
  std::optional<std::size_t> stroke;
  std::string size = "1600x1200";
  std::string view = "iso";
  std::string background = "white";
  bool no_ground = false;
  bool flat = false;
  bool wireframe = false;
  bool same_scale = false;
  CommonOptions common;
};

// The two numbers of "1600x1200" or "30,-20"; nothing where the text is anything else.
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
  const int panels = static_cast<int>(options.shapes.size());
  if (!size || !is_fine(size->first) || !is_fine(size->second) || size->first / panels < least) {
    throw UsageError(
        fmt::format("--size {}: give WIDTHxHEIGHT in pixels, as 1600x1200, each from {} to {} (and {} for "
                    "each shape)",
                    options.size, least, most, least));
  }
  request.width = size->first;
  request.height = size->second;
}

// The direction in which a camera looks that stands at the azimuth (from the front towards +x) and elevation.
Vec3d direction_of(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180;
  const double elevation = elevation_deg * std::numbers::pi / 180;
  return -Vec3d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation)};
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
  request.view = direction_of(angles->first, angles->second);
  if (std::abs(angles->second) > 89.9) request.up = {0, 0, angles->second > 0 ? -1.0 : 1.0};
}

PictureRequest picture_request(const RenderOptions& options) {
  PictureRequest request;
  set_size(options, request);
  set_view(options, request);
  if (options.background != "white" && options.background != "transparent") {
    throw UsageError(fmt::format("--background {}: say white or transparent", options.background));
  }
  if (options.stroke && options.session.empty()) throw UsageError("--stroke: needs --session to know the strokes");
  request.transparent = options.background == "transparent";
  request.ground = !options.no_ground;
  request.flat = options.flat;
  request.wireframe = options.wireframe;
  request.same_scale = options.same_scale;
  return request;
}

std::vector<Flow> read_tools(const RenderOptions& options) {
  if (options.session.empty()) return {};
  const Session session = read_session(options.session);
  if (!options.common.quiet) print_notes(session.warnings);
  const std::size_t count = session.strokes.size();
  if (options.stroke && (*options.stroke < 1 || *options.stroke > count)) {
    throw UsageError(
        fmt::format("--stroke {}: {} has {}, counted from 1", *options.stroke, session.name, counted(count, "stroke")));
  }
  std::vector<Flow> tools;
  for (std::size_t i = 0; i < count; ++i) {
    if (!options.stroke || i + 1 == *options.stroke) tools.push_back(flow_of(session.strokes[i].stroke));
  }
  return tools;
}

void run_render(const RenderOptions& options) {
  PictureRequest request = picture_request(options);
  constexpr std::string_view extensions[] = {"png"};
  require_extension(options.output, extensions);
  require_renderer();
  require_writable(options.output);
  request.tools = read_tools(options);
  for (const std::string& path : options.shapes) {
    ShapeFile file = read_shape(path);
    if (!options.common.quiet) {
      for (const std::string& note : file.notes) print_message(fmt::format("note: {}: {}", path, note));
    }
    request.shapes.push_back(std::move(file.mesh));
  }
  write_file_atomically(options.output, draw_picture(request));
  if (options.common.json) {
    const nlohmann::ordered_json json{{"width", request.width}, {"height", request.height}};
    print(json.dump(2) + "\n");
  } else if (!options.common.quiet) {
    print(fmt::format("{}: {} x {} pixels\n", options.output, request.width, request.height));
  }
}

void add_options(CLI::App& app, RenderOptions& options) {
  app.add_option("SHAPE", options.shapes, "One or more meshes or point clouds, drawn side by side")
      ->required()
      ->type_name("");
  app.add_option("-o,--output", options.output, "The .png file to write")->required()->type_name("FILE");
  app.add_option("--session", options.session,
                 "Draw this session's tools over the first shape: r = inner red, r = outer green")
      ->type_name("FILE");
  app.add_option("--stroke", options.stroke, "Only the tool of this stroke, counted from 1")->type_name("N");
  app.add_option("--size", options.size, "WIDTHxHEIGHT of the whole picture in pixels")
      ->capture_default_str()
      ->type_name("WxH");
  app.add_option("--view", options.view,
                 "front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees; y is up")
      ->capture_default_str()
      ->type_name("NAME");
  app.add_option("--background", options.background, "white or transparent")->capture_default_str()->type_name("COLOR");
  app.add_flag("--no-ground", options.no_ground, "No shadow on the ground");
  app.add_flag("--flat", options.flat, "One shade for each face");
  app.add_flag("--wireframe", options.wireframe, "The faces' edges as lines");
  app.add_flag("--same-scale", options.same_scale,
               "Each shape in the middle of its part of the picture, all at one scale; else one camera shows all");
  add_common_options(app, options.common);
}

}  // namespace

Subcommand add_render(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("render", "Draw shapes, and the tools of a session, into a picture");
  const auto options = std::make_shared<RenderOptions>();
  add_options(*app, *options);
  add_examples(*app,
               "  knead render hand.ply -o hand.png\n"
               "  knead render hand.ply bent.ply --session bend.knead --view front -o before_after.png\n"
               "  knead render scan.ply --view -30,15 --size 800x600 --background transparent -o scan.png");
  return {app, [options] { run_render(*options); }};
}

}  // namespace knead::command
