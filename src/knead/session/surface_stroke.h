// Resolves strokes that read the surface into strokes that do not. Internal to the session room.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knead/session/session.h"
#include "knead/tool/live_surface.h"

namespace knead::session_detail {

// Returns the tool of a stamp, read from its file relative to the folder; null for other strokes. Throws InvalidInput
// where it cannot be read or is not closed.
std::shared_ptr<const Mesh> tool_mesh_of(const Stroke& stroke, const std::filesystem::path& folder);

// Returns the largest number of segments that a stroke which reads the surface becomes. `tool`: of a stamp.
std::size_t expected_segments(const Stroke& stroke, const Mesh* tool);

// Returns about as many segments as a stroke becomes, without reading any file.
std::size_t segments_about(const Stroke& stroke);

// Applies a stroke that reads the surface: passes the strokes that it becomes to surface.apply, in order, until that
// returns false. Appends remarks for the user. Returns how deep a stamp leaves the surface in its tool. Throws
// InvalidInput for a stroke that this surface cannot take.
std::optional<double> apply_on(const Stroke& stroke, const Mesh* tool, int threads, const LiveSurface& surface,
                               std::vector<std::string>& remarks);

}  // namespace knead::session_detail
