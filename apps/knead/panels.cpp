// Makes the panels of a picture: shapes, moments of a session, tools, colours of distances.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "command.h"
#include "inputs.h"
#include "knead/certify.h"
#include "knead/io.h"
#include "knead/session.h"
#include "output.h"
#include "render.h"

namespace knead::command {

namespace {

void check_strokes(const PanelOptions& options, const Session& session) {
  const std::size_t count = session.strokes.size();
  if (options.stroke && (*options.stroke < 1 || *options.stroke > count)) {
    throw UsageError(
        fmt::format("--stroke {}: {} has {}, counted from 1", *options.stroke, session.name, counted(count, "stroke")));
  }
  for (const double moment : options.moments) {
    if (!(moment >= 0 && moment <= static_cast<double>(count))) {
      throw UsageError(fmt::format("--until {}: {} has {}", moment, session.name, counted(count, "stroke")));
    }
  }
}

// A resolved stroke: its parts, which read no surface, their segments, and the shape of a stamp.
struct PlayedStroke {
  std::vector<SessionStroke> parts;
  Flow flow;
  double segments = 0;  // as far as the strength applies them
  std::optional<render::StampTool> stamp;
};

double length_of(const Flow& flow) {
  double length = 0;
  for (const Segment& segment : flow.segments) length += segment.end;
  return length;
}

render::StampTool stamp_tool(const StampStroke& stamp, const Session& session) {
  render::StampTool tool{read_shape(std::filesystem::path(session.name).parent_path() / stamp.mesh).mesh, stamp.path};
  for (Vec3d& p : tool.mesh.positions) p = stamp.pose * p;
  return tool;
}

// Replays the session only if a stroke reads the surface, and then once for all moments.
std::vector<PlayedStroke> play(const Inputs& inputs, bool quiet) {
  const Session& session = inputs.session;
  const bool reads = std::any_of(session.strokes.begin(), session.strokes.end(),
                                 [](const SessionStroke& stroke) { return reads_surface(stroke.stroke); });
  ReplayOptions options;
  if (inputs.shape.mesh.face_count() == 0) options.normals = vertex_normals_of(inputs.shape);
  const std::vector<SessionStroke> resolved =
      reads ? replay_watched(inputs.shape.mesh, without_cells(session), options, quiet).resolved : session.strokes;
  std::vector<PlayedStroke> played;
  for (const SessionStroke& stroke : session.strokes) {
    PlayedStroke& result = played.emplace_back();
    for (const SessionStroke& part : resolved) {
      if (part.line != stroke.line) continue;
      const Flow flow = flow_of(part);
      result.flow.segments.insert(result.flow.segments.end(), flow.segments.begin(), flow.segments.end());
      result.parts.push_back(part);
      result.segments += length_of(flow);
    }
    if (!is_applied(stroke) || !std::holds_alternative<StampStroke>(stroke.stroke)) continue;
    const Stroke whole = stroke.strength > 1 ? prolonged(stroke.stroke, stroke.strength) : stroke.stroke;
    result.stamp = stamp_tool(std::get<StampStroke>(whole), session);
  }
  return played;
}

// Returns the moment within the current stroke, counted in its segments.
double segments_at(const PlayedStroke& stroke, double moment) {
  return (moment - std::floor(moment)) * stroke.segments;
}

// Returns the tools that are drawn with their whole paths.
std::vector<render::DrawnTool> all_tools(const PanelOptions& options, const std::vector<PlayedStroke>& played) {
  std::vector<render::DrawnTool> tools;
  for (std::size_t i = 0; i < played.size(); ++i) {
    if (!options.stroke || i + 1 == *options.stroke) tools.push_back({played[i].flow, played[i].stamp, {}});
  }
  return tools;
}

// Returns the tool of the current stroke; none at the end of the session.
std::vector<render::DrawnTool> tools_at(const PanelOptions& options, const std::vector<PlayedStroke>& played,
                                        double moment) {
  const auto index = static_cast<std::size_t>(moment);
  if (index >= played.size() || (options.stroke && index + 1 != *options.stroke)) return {};
  const PlayedStroke& stroke = played[index];
  return {{stroke.flow, stroke.stamp, segments_at(stroke, moment)}};
}

ShapeFile read_noted(const PanelOptions& options, const std::string& path) {
  ShapeFile file = read_shape_or_stream(path, options.format);
  if (!options.quiet) {
    for (const std::string& note : file.notes) print_message(fmt::format("note: {}: {}", path, note));
  }
  return file;
}

std::vector<Panel> panels_of_shapes(const PanelOptions& options) {
  std::vector<Panel> panels;
  for (const std::string& path : options.shapes) panels.push_back({read_noted(options, path).mesh, {}});
  return panels;
}

std::vector<Panel> panels_of_session(const PanelOptions& options, const Session& session) {
  Inputs inputs{read_noted(options, options.shapes.front()), session};
  const std::vector<PlayedStroke> played = play(inputs, options.quiet);
  // A stroke is remeshed once, not after each of the parts that it resolves to; a relax resolves to nothing.
  const bool remeshed = std::any_of(session.strokes.begin(), session.strokes.end(), [](const SessionStroke& stroke) {
    return stroke.remesh.has_value() || !is_flow(stroke.stroke);
  });
  if (!remeshed) {
    inputs.session.strokes.clear();
    for (const PlayedStroke& stroke : played) {
      for (const SessionStroke& part : stroke.parts) inputs.session.strokes.push_back(part);
    }
  }
  std::vector<Panel> panels;
  for (const double moment : options.moments) {
    ReplayOptions replay;
    replay.may_cross = true;  // a picture shows it
    replay.part.until = remeshed ? moment : moment_among_resolved(session.strokes, inputs.session.strokes, moment);
    const ReplayResult result = replay_watched(inputs.shape.mesh, inputs.session, replay, options.quiet);
    if (!options.quiet) print_notes(result.shortfalls);
    Panel& panel = panels.emplace_back(Panel{result.shape.to_mesh(), {}});
    if (options.tools == ToolPanels::each) panel.tools = tools_at(options, played, moment);
  }
  if (panels.empty()) panels.push_back({inputs.shape.mesh, {}});
  for (std::size_t i = 1; i < options.shapes.size(); ++i) {
    panels.push_back({read_noted(options, options.shapes[i]).mesh, {}});
  }
  if (options.tools == ToolPanels::first) panels.front().tools = all_tools(options, played);
  return panels;
}

// From the renderer's clay to dark red, ever darker.
constexpr std::array<Vec3d, 5> kColors{
    {{0.80, 0.755, 0.70}, {0.97, 0.80, 0.42}, {0.93, 0.52, 0.20}, {0.76, 0.22, 0.14}, {0.42, 0.04, 0.10}}};

Vec3d color_at(double part) {
  const double at = std::clamp(part, 0.0, 1.0) * (kColors.size() - 1);
  const std::size_t first = std::min(static_cast<std::size_t>(at), kColors.size() - 2);
  return kColors[first] + (kColors[first + 1] - kColors[first]) * (at - static_cast<double>(first));
}

Attribute colors_of(const std::vector<double>& distances, double greatest) {
  Attribute colors{"color", Domain::vertex, NumberType::float32, 3, {}};
  for (const double distance : distances) {
    const Vec3d color = color_at(greatest > 0 ? distance / greatest : 0);
    colors.values.insert(colors.values.end(), {color.x, color.y, color.z});
  }
  return colors;
}

std::vector<std::vector<double>> distances_of(const std::vector<Panel>& panels, const Mesh& target, bool quiet) {
  Progress progress;
  const CancelOnInterruption cancel(progress);
  for (const Panel& panel : panels) progress.total += panel.shape.vertex_count();
  const ProgressBar bar(progress, progress.total, !quiet);
  std::vector<std::vector<double>> distances;
  try {
    for (const Panel& panel : panels) distances.push_back(vertex_distances(panel.shape, target, 0, &progress));
  } catch (const Cancelled&) {
    throw Interrupted{};
  }
  return distances;
}

}  // namespace

void check_usage(const PanelOptions& options) {
  if (std::ranges::count_if(options.shapes, is_stream) > 1) {
    throw UsageError("only one shape can be -: standard input is read once");
  }
  if (options.session.empty()) {
    if (options.stroke) throw UsageError("--stroke: needs --session to know the strokes");
    if (!options.moments.empty()) throw UsageError("--until: needs --session to know the strokes");
  }
  if (options.tools == ToolPanels::each && options.moments.empty()) {
    throw UsageError("--tools each: needs --until to know the moments");
  }
  if (!options.moments.empty() && options.shapes.size() != 1) {
    throw UsageError(fmt::format("--until: give one shape, not {}; it is drawn at each moment", options.shapes.size()));
  }
}

std::vector<Panel> make_panels(const PanelOptions& options) {
  if (options.session.empty()) return panels_of_shapes(options);
  const Session session = without_off(read_session(options.session));
  if (!options.quiet) print_notes(session.warnings);
  check_strokes(options, session);
  return panels_of_session(options, session);
}

double color_by_distance(const DistanceColors& colors, bool quiet, std::vector<Panel>& panels) {
  const std::vector<std::vector<double>> distances = distances_of(panels, read_shape(colors.shape).mesh, quiet);
  double greatest = 0;
  for (const std::vector<double>& own : distances) {
    for (const double distance : own) greatest = std::max(greatest, distance);
  }
  greatest = colors.greatest.value_or(greatest);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    std::vector<Attribute>& attributes = panels[i].shape.attributes;
    std::erase_if(attributes, [](const Attribute& attribute) { return attribute.name == "color"; });
    attributes.push_back(colors_of(distances[i], greatest));
  }
  return greatest;
}

}  // namespace knead::command
