// Replays in which the mesh follows the strokes. Internal to the session room.
#pragma once

#include <optional>
#include <string>

#include "knead/session/replay.h"

namespace knead::session_detail {

// The settings that hold for a stroke.
const std::optional<RemeshSettings>& settings_of(const SessionStroke& stroke, const ReplayOptions& options);

// Whether a stroke that is applied is to be remeshed, and can be: forwards, on a shape with faces.
bool remeshes(const Mesh& mesh, const Session& session, const ReplayOptions& options);

// What there is to say where settings are ignored.
std::optional<std::string> ignored_remesh(const Mesh& mesh, const Session& session, const ReplayOptions& options);

// Whether a remeshed replay is done twice: first as usual, for strokes that read the surface.
bool reads_first(const Session& session, const ReplayOptions& options);

// Refuses marked regions given by vertices where a remesh has changed the vertices' numbers: throws InvalidInput that
// names the session's line.
void require_no_numbers(const Session& session, const SessionStroke& source);

// replay() where remeshes().
ReplayResult replay_remeshed(const Mesh& mesh, const Session& session, const ReplayOptions& options);

}  // namespace knead::session_detail
