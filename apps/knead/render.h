// What `knead render` draws, as plain values that need no renderer.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "inputs.h"
#include "knead/editor/render.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::command {

struct Panel {
  Mesh shape;
  std::vector<render::DrawnTool> tools;
};

// Removes the side dot(normal, x) > offset of every shape.
struct CutPlane {
  Vec3d normal;
  double offset = 0;
};

// The point that the camera looks at, and the height of the picture there.
struct CloseUp {
  Vec3d target;
  double height = 0;
};

enum class ImageFormat { png, jpeg };

// How many samples a pixel has, and from how many directions light comes.
enum class PictureQuality { draft, normal, fine };

struct PictureRequest {
  std::vector<Panel> panels;  // side by side, at least one
  std::optional<CutPlane> cut;
  std::optional<CloseUp> close_up;  // empty: shows everything
  std::vector<Vec3d> shown;         // the points that the camera shows; empty: those of the panels
  Vec3d view{0, 0, -1};             // into the scene
  Vec3d up{0, 1, 0};
  int width = 1600;  // of the whole picture
  int height = 1200;
  double field_of_view_deg = 25;                              // from bottom to top; 0: orthographic
  render::Background background{{1, 1, 1, 1}, {1, 1, 1, 1}};  // alpha 0: transparent
  std::optional<render::Matcap> matcap;                       // empty: clay under the studio's light
  render::Relief relief;
  PictureQuality quality = PictureQuality::normal;
  bool ground = true;  // the shadow on the ground
  bool flat = false;   // one normal per face
  bool wireframe = false;
  bool same_scale = false;  // each shape is centred in its panel, all at one scale
  ImageFormat format = ImageFormat::png;
};

// Return what the names of a material and a background mean. Throw UsageError for unknown names. A build without a
// renderer knows none and lets all pass.
std::optional<render::Matcap> read_material(const std::string& name);
render::Background read_background(const std::string& name);

// Returns the names of all materials, separated by commas.
std::string material_names();

// Throws std::runtime_error in a build without a renderer.
void require_renderer();

// Returns the picture. progress: called with the part that is done, from 0 to 1. Throws as
// require_renderer, and if the machine has no OpenGL 3.3.
render::Image draw_image(const PictureRequest& request, const std::function<void(double)>& progress);

// Returns the bytes of an image file.
std::string draw_picture(const PictureRequest& request, const std::function<void(double)>& progress);

// Returns points of a shape that are the farthest in many directions, for PictureRequest::shown.
std::vector<Vec3d> outermost_points(std::span<const Vec3d> positions);
// The same in all pictures of a turntable.
std::vector<Vec3d> turntable_points(std::span<const Vec3d> positions, const Vec3d& middle, int count, bool is_z_up);

// --- panels: shapes as they are, or one shape at several moments of a session

// In which panels tools are drawn.
//   first: in the first one, the tools of all strokes with their whole paths;
//   each:  in every panel, the tool of the current stroke, at its place at the panel's moment.
enum class ToolPanels { first, each, none };

struct PanelOptions {
  std::vector<std::string> shapes;    // files or `-`, at least one
  StreamFormat format;                // of the one that is `-`
  std::string session;                // file; empty: no tools
  std::optional<std::size_t> stroke;  // only this one's tool, counted from 1
  std::vector<double> moments;        // of the session, in strokes; empty: the shapes as they are
  ToolPanels tools = ToolPanels::first;
  bool quiet = false;
};

// Throws UsageError if options do not go together: moments need a session and one shape, ToolPanels::each needs
// moments, a stroke needs a session.
void check_usage(const PanelOptions& options);

// The colours that show the distance of each vertex from another shape's surface: clay at 0, dark red from `greatest`
// on.
struct DistanceColors {
  std::string shape;               // file; empty: shapes keep their colours
  std::optional<double> greatest;  // in the units of the shapes; empty: the greatest distance of all panels
};

// Gives the vertices of all panels their colours. Returns the distance that has the last colour. Throws what reading
// and vertex_distances() throw.
double color_by_distance(const DistanceColors& colors, bool quiet, std::vector<Panel>& panels);

// Returns a panel for each moment, or for each shape if there are no moments. Throws UsageError for a stroke or a
// moment that the session does not have, and what reading and replaying throw.
std::vector<Panel> make_panels(const PanelOptions& options);

// --- films (--frames, --turntable): numbered pictures, an animated GIF, a film by ffmpeg

struct FilmRequest {
  std::string output;  // a pattern as F_%04d.png, or a name that ends in .gif or .mp4
  int pictures = 1;
  double fps = 24;
  // Calls draw for one picture after the other; all have the same size.
  std::function<void(const std::function<void(const PictureRequest&)>& draw)> play{};
};

// Throws UsageError for another kind of file, and where ffmpeg is missing for an .mp4.
void check_film_output(const std::string& output);

// Draws and writes the film. A GIF or film appears whole or not at all; numbered pictures appear one by one. Throws as
// draw_picture, IoError(write), and std::runtime_error where ffmpeg fails.
void write_film(const FilmRequest& film, bool quiet);

}  // namespace knead::command
