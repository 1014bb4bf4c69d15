#include "panels.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "command.h"
#include "knead/io/shape_file.h"
#include "knead/session/session.h"
#include "output.h"
#include "work.h"

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

bool is_wanted(const PanelOptions& options, std::size_t index) {
  return !options.stroke || index + 1 == *options.stroke;
}

std::vector<DrawnTool> all_tools(const PanelOptions& options, const Session& session) {
  std::vector<DrawnTool> tools;
  for (std::size_t i = 0; i < session.strokes.size(); ++i) {
    if (is_wanted(options, i)) tools.push_back({flow_of(session.strokes[i].stroke), {}});
  }
  return tools;
}

// Of the stroke under way; none where the session is over.
std::vector<DrawnTool> tools_at(const PanelOptions& options, const Session& session, double moment) {
  const auto index = static_cast<std::size_t>(moment);
  if (index >= session.strokes.size() || !is_wanted(options, index)) return {};
  Flow stroke = flow_of(session.strokes[index].stroke);
  const double segments = (moment - static_cast<double>(index)) * static_cast<double>(stroke.segments.size());
  return {{std::move(stroke), segments}};
}

ShapeFile read_noted(const std::string& path, bool quiet) {
  ShapeFile file = read_shape(path);
  if (!quiet) {
    for (const std::string& note : file.notes) print_message(fmt::format("note: {}: {}", path, note));
  }
  return file;
}

std::vector<Panel> panels_of_shapes(const PanelOptions& options) {
  std::vector<Panel> panels;
  for (const std::string& path : options.shapes) panels.push_back({read_noted(path, options.quiet).mesh, {}});
  return panels;
}

std::vector<Panel> panels_of_moments(const PanelOptions& options, const Session& session) {
  const Inputs inputs{read_noted(options.shapes.front(), options.quiet), session};
  std::vector<Panel> panels;
  for (const double moment : options.moments) {
    ReplayOptions replay;
    replay.until = moment;
    Panel& panel = panels.emplace_back(Panel{inputs.shape.mesh, {}});
    panel.shape.positions = replay_watched(inputs, replay, options.quiet).positions;
    if (options.tools == ToolPanels::each) panel.tools = tools_at(options, session, moment);
  }
  return panels;
}

}  // namespace

void check_usage(const PanelOptions& options) {
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
  const Session session = read_session(options.session);
  if (!options.quiet) print_notes(session.warnings);
  check_strokes(options, session);
  std::vector<Panel> panels = options.moments.empty() ? panels_of_shapes(options) : panels_of_moments(options, session);
  if (options.tools == ToolPanels::first) panels.front().tools = all_tools(options, session);
  return panels;
}

}  // namespace knead::command
