// Strokes and the settings of a remesh event from JSON, and as JSON. Internal to the session room.
#pragma once

#include <optional>
#include <string>

#include "knead/remesh/remesh.h"
#include "knead/session/json_object.h"
#include "knead/session/session.h"
#include "knead/tool/stroke.h"

namespace knead::session_detail {

// Returns the stroke of an object with the key "tool", and what the keys of all tools say. Throws InvalidInput for
// anything that is not exactly a valid stroke of a tool that this version has.
SessionStroke read_stroke(const JsonValue& line, const Place& place);

// Returns the name of the tool whose strokes have a line of their own that this object is, such as {"relax": {...}};
// empty if there is none.
std::string_view own_event(const JsonObject& event);

// Returns the stroke of the object at the key `name`, which own_event returned. Throws InvalidInput as above.
SessionStroke read_own_event(const JsonObject& event, std::string_view name, const Place& place);

// Returns the value at the key "remesh": null or an object. Throws InvalidInput as above.
std::optional<RemeshSettings> read_remesh(const JsonValue& value, const Place& place);

}  // namespace knead::session_detail
