// Strokes and the settings of a remesh event from JSON, and as JSON. Internal to the session room.
#pragma once

#include <optional>
#include <string>

#include "knead/remesh/remesh.h"
#include "knead/session/json_object.h"
#include "knead/session/session.h"
#include "knead/tool/tool.h"

namespace knead::session_detail {

// Returns the stroke of an object with the key "tool", and what the keys of all tools say. Throws InvalidInput for
// anything that is not exactly a valid stroke of a tool that this version has.
SessionStroke read_stroke(const JsonValue& line, const Place& place);

// Returns the tool whose event (Tool::is_event) the line is, or a null pointer.
const Tool* event_tool(const JsonObject& line);

// Returns the stroke of such an event from what is at its key: null, or an object. Throws InvalidInput as above.
SessionStroke read_event_stroke(const Tool& tool, const JsonValue& value, const Place& place);

// Returns the value at the key "remesh": null or an object. Throws InvalidInput as above.
std::optional<RemeshSettings> read_remesh(const JsonValue& value, const Place& place);

}  // namespace knead::session_detail
