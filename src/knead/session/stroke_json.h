// Strokes and the settings of a remesh event from JSON, and as JSON. Internal to the session room.
#pragma once

#include <optional>
#include <string>

#include "knead/remesh/remesh.h"
#include "knead/session/json_object.h"
#include "knead/tool/stroke.h"

namespace knead::session_detail {

// Returns the stroke of an object with the key "tool". Throws InvalidInput for anything that is not exactly a valid
// stroke of a tool that this version has.
Stroke read_stroke(const JsonValue& line, const Place& place);

// Returns the value at the key "remesh": null or an object. Throws InvalidInput as above.
std::optional<RemeshSettings> read_remesh(const JsonValue& value, const Place& place);

}  // namespace knead::session_detail
