// What has to be done where the strokes of a gesture under way become others.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "knead/session/session.h"

namespace knead {

// From `before` to `now`. Remesh settings are not looked at.
struct LiveChange {
  bool from_start = false;             // all of `now` is to be done anew, from where the gesture began
  std::size_t first_new = 0;           // strokes before this one are done
  std::optional<Flow> rest;            // of the stroke before that one, first
  std::optional<Stroke> rest_as_line;  // that as a stroke; nothing: the whole stroke takes its place

  bool is_nothing(std::size_t strokes_now) const { return !from_start && !rest && first_new == strokes_now; }
};

LiveChange live_change(std::span<const SessionStroke> before, std::span<const SessionStroke> now);

}  // namespace knead
