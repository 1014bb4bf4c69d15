// The panels of `knead render`: shapes as they are, or one shape at several moments of a session, with tools.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "picture.h"
#include "streams.h"

namespace knead::command {

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

}  // namespace knead::command
