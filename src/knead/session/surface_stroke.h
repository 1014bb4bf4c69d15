// Strokes that read the surface, turned into ones that do not. Internal to the session room.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knead/session/session.h"
#include "knead/tool/live_surface.h"

namespace knead::session_detail {

// The tool of a stamp, read from its file beside the session; null for other strokes. Throws InvalidInput where it
// cannot be read or is not closed.
std::shared_ptr<const Mesh> tool_mesh_of(const Session& session, const Stroke& stroke);

// How many segments a stroke that reads the surface becomes, at most. The tool is a stamp's.
std::size_t expected_segments(const Stroke& stroke, const Mesh* tool);

// Carries out a stroke that reads the surface: hands the strokes that it becomes to surface.apply, in order, until that
// says to stop. What there is to say about it goes to `remarks`. Returns how deep a stamp leaves the surface in its
// tool. Throws InvalidInput for a stroke that this surface cannot take.
std::optional<double> apply_on(const Stroke& stroke, const Mesh* tool, int threads, const LiveSurface& surface,
                               std::vector<std::string>& remarks);

}  // namespace knead::session_detail
