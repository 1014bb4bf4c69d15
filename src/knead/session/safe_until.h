// How far a session can be applied to a volume mesh before it spoils a cell, and what would let it go farther.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "knead/math/progress.h"
#include "knead/math/vec3.h"
#include "knead/mesh/measures.h"
#include "knead/session/replay.h"

namespace knead {

// How far something holds, in strokes.
struct SafeUntil {
  double until = 0;
  double beyond = 0;  // equal to `until` if it holds to the end
};

// Returns the range in which something first fails between 0 and `most` strokes. It samples every 16th of a stroke
// (from 16 strokes on, every 256th of the whole) in order, and bisects the range before the first sample that fails ten
// times.
//
// Guaranteed: holds(until) was true, or `until` is 0, which is taken to hold; holds(beyond) was false; it was true at
// every sample below. Not seen: a failure that begins and ends between two samples, or between two of the bisection.
SafeUntil safe_until(double most, const std::function<bool(double until)>& holds);

// Returns how many strokes come before the one that fails at `beyond`.
std::size_t strokes_before(const SafeUntil& range);

// What a search for spoiled cells needs to know.
struct SafeCellsOptions {
  // 0: a cell is spoiled if it is inverted, exactly. Below 1: also if its scaled Jacobian falls below this. Cells that
  // were below it before, or flat, do not count.
  double least_scaled_jacobian = 0;
  SessionPart part{};
  MotionOptions motion{};
  Progress* progress = nullptr;  // cancels the search, which then throws Cancelled
};

// How far a session can be applied to a volume mesh, and what ends it.
struct SafeCells {
  AdvectStatus status = AdvectStatus::done;  // step_limit: nothing else is known; see kStepLimitAdvice
  SafeUntil range;                           // within it no cell is spoiled
  std::optional<std::size_t> cell;           // the worst spoiled cell at range.beyond; empty: the whole session is safe
  double scaled_jacobian = 1;                // of that cell, there; as in CellChanges
  std::optional<double> outer;               // of the stroke that spoils it: widest_outer()
};

// Returns how far a session can be applied before it spoils a cell; safe_until() says what is guaranteed. Points that
// advect() moves by flow_of(session, part) with part.until = range.until are those that were judged. Time: up to 26
// times that of the flow for one stroke, and of judging the cells that it moves. Throws InvalidInput for a bound out of
// range, and as flow_of(session, part), compare_cells() and advect(); Cancelled.
SafeCells safe_until(const Session& session, const Cells& cells, std::span<const Vec3d> points,
                     const SafeCellsOptions& options = {});

}  // namespace knead
