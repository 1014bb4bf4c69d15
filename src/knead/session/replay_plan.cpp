#include "knead/session/replay_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "knead/math/error.h"
#include "knead/session/surface_stroke.h"

namespace knead::session_detail {

namespace {

void require(bool good, const std::string& message) {
  if (!good) throw InvalidInput(message);
}

double checked_until(const Session& session, const ReplayOptions& options) {
  const auto strokes = static_cast<double>(session.strokes.size());
  const double until = options.until.value_or(strokes);
  require(std::isfinite(options.tolerance) && options.tolerance > 0,
          fmt::format("the tolerance must be a number greater than 0, got {}", options.tolerance));
  require(until >= 0 && until <= strokes,
          fmt::format("\"until\" must be from 0 to the session's number of strokes ({}), got {}", strokes, until));
  require(options.frames >= 0, fmt::format("the number of frames must be 0 or more, got {}", options.frames));
  require(options.threads >= 0, fmt::format("the number of threads must be 0 (all) or more, got {}", options.threads));
  return until;
}

std::vector<PlannedStroke> plan_strokes(const Session& session, double until, bool inverse) {
  std::vector<PlannedStroke> strokes;
  for (std::size_t i = 0; static_cast<double>(i) < until; ++i) {
    const SessionStroke& source = session.strokes[i];
    try {
      strokes.push_back(plan_stroke(session, source, std::min(1.0, until - static_cast<double>(i)), inverse));
    } catch (const InvalidInput& error) {
      throw InvalidInput(place_of(session, source), error.what());
    }
  }
  return strokes;
}

// The moments of the frames in strokes of the session, in the order of their delivery.
std::vector<double> frame_moments(const ReplayOptions& options, double until) {
  std::vector<double> moments;
  for (int k = 0; k < options.frames; ++k) {
    const double done = options.frames == 1 || k + 1 == options.frames ? until : until * k / (options.frames - 1);
    moments.push_back(options.inverse ? until - done : done);
  }
  return moments;
}

}  // namespace

PlannedStroke plan_stroke(const Session& session, const SessionStroke& source, double part, bool inverse) {
  PlannedStroke planned;
  planned.source = &source;
  planned.part = part;
  if (!reads_surface(source.stroke)) {
    planned.flow = flow_of(source.stroke);
    validate(planned.flow);
    planned.barrel = barrel_of(source.stroke);
    return planned;
  }
  require(!inverse,
          "this stroke reads the surface as it was before it, which the deformed shape does not tell; resolve the "
          "session with the undeformed shape (knead resolve) and take that session back");
  validate(source.stroke);
  planned.tool = tool_mesh_of(session, source.stroke);
  planned.expected_segments = expected_segments(source.stroke, planned.tool.get());
  return planned;
}

Plan make_plan(const Session& session, const ReplayOptions& options) {
  const double until = checked_until(session, options);
  Plan plan{plan_strokes(session, until, options.inverse), {}};
  const std::vector<double> moments = frame_moments(options, until);
  auto moment = moments.begin();
  const std::size_t count = plan.strokes.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = options.inverse ? count - 1 - k : k;
    const PlannedStroke& stroke = plan.strokes[i];
    const auto begin = static_cast<double>(i);
    plan.tasks.push_back({TaskKind::enter, i, 0, stroke.expected_segments});
    for (; moment != moments.end() && (options.inverse ? *moment > begin : *moment < begin + stroke.part); ++moment) {
      plan.tasks.push_back({TaskKind::frame, i, *moment - begin, 1});
    }
    const double segments = stroke.part * static_cast<double>(stroke.expected_segments);
    plan.tasks.push_back({TaskKind::leave, i, options.inverse ? 0 : stroke.part,
                          static_cast<std::size_t>(std::ceil(std::max(segments, stroke.segments())))});
  }
  for (; moment != moments.end(); ++moment) plan.tasks.push_back({TaskKind::still});
  return plan;
}

Place place_of(const Session& session, const SessionStroke& stroke) { return {session.name, stroke.line}; }

Flow flow_between(const Flow& flow, double from, double to) {
  if (from == to) return {};
  if (to < from) return inverse(flow_between(flow, to, from));
  Flow part = prefix(flow, to);
  const double whole = std::floor(from);
  part.segments.erase(part.segments.begin(), part.segments.begin() + static_cast<std::ptrdiff_t>(whole));
  part.segments.front().begin = from - whole;
  return part;
}

}  // namespace knead::session_detail
