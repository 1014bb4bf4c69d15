// What a replay does, one after the other. Internal to the session room.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "knead/math/error.h"
#include "knead/session/replay.h"
#include "knead/tool/barrel.h"

namespace knead::session_detail {

// A stroke that is applied, wholly or in part.
struct PlannedStroke {
  const SessionStroke* source = nullptr;
  double part = 1;  // of its segments, from the first on
  Flow flow;        // of one that reads the surface: none until it is resolved
  std::optional<Barrel> barrel;
  std::shared_ptr<const Mesh> tool;   // of a stamp
  std::size_t expected_segments = 0;  // of one that reads the surface: at most

  double segments() const { return part * static_cast<double>(flow.segments.size()); }
};

//   enter:  the stroke meets the shape as it is then: barrels are checked, what reads the surface is resolved;
//   frame:  the moment `at` of the stroke, from 0 to 1, is delivered;
//   leave:  the stroke is completed, as far as it is to be done;
//   still:  a frame of the shape as it is.
enum class TaskKind { enter, frame, leave, still };

struct Task {
  TaskKind kind = TaskKind::still;
  std::size_t stroke = 0;
  double at = 0;
  std::size_t work = 0;  // segments that it moves the points through, at most
};

struct Plan {
  std::vector<PlannedStroke> strokes;
  std::vector<Task> tasks;
};

// Reads the files of stamps. Throws InvalidInput for options out of range, and, naming the session's line, for a stroke
// that cannot be done: one that reads the surface, backwards; a tool that cannot be used.
Plan make_plan(const Session& session, const ReplayOptions& options);

// One stroke, wholly or in part. Reads the file of a stamp. Throws InvalidInput for a stroke that cannot be done.
PlannedStroke plan_stroke(const Session& session, const SessionStroke& source, double part, bool inverse);

Place place_of(const Session& session, const SessionStroke& stroke);

// The flow from one moment to another, in segments; backwards where to < from. The segments are whole ones.
Flow flow_between(const Flow& flow, double from, double to);

}  // namespace knead::session_detail
