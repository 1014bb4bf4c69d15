// What a replay does, in order.
#pragma once

#include <cstddef>
#include <vector>

#include "knead/error.h"
#include "knead/replay.h"
#include "session/stroke_run.h"

namespace knead::session_detail {

// A stroke that is applied, wholly or in part.
struct PlannedStroke {
  PreparedStroke stroke;
  RunOptions run;
  std::vector<double> frames;  // moments of the stroke, from 0 to 1, in order of delivery

  std::size_t work() const;  // segments that it moves the points through, at most
};

struct Plan {
  std::vector<PlannedStroke> strokes;  // in order of application
  std::size_t last_frames = 0;         // delivered after all strokes
  // Where strokes read a surface that is not the result's own: how many strokes there are up to the last of these.
  std::size_t strokes_on_reference = 0;
};

// Reads the files of stamps. Throws InvalidInput for options out of range, and with the session's line for a stroke
// that cannot be applied: one that reads the surface, backwards; a stamp whose tool cannot be used.
Plan make_plan(const Mesh& mesh, const Session& session, const ReplayOptions& options);

// Throws InvalidInput if walls of the session are kept by more than its flow.
void require_flow_alone(const Session& session);

// Returns the strokes that are not off.
std::vector<const SessionStroke*> strokes_on(const Session& session);

// Returns whether a stroke that is applied has remesh settings.
bool has_settings(const Session& session, const ReplayOptions& options);

// Calls a function, and names the stroke's line in the message of an InvalidInput or RemeshLimit that it throws.
template <class Function>
auto at_line(const Session& session, const SessionStroke& stroke, const Function& function) {
  try {
    return function();
  } catch (const RemeshLimit& error) {
    throw RemeshLimit(Place{session.name, stroke.line}, error.what());
  } catch (const InvalidInput& error) {
    throw InvalidInput(Place{session.name, stroke.line}, error.what());
  }
}

}  // namespace knead::session_detail
