// The plan of a replay: its strokes, and the moments of its frames.
#include "session/replay_detail.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "session/deformed_shape_detail.h"

namespace knead::detail {

namespace {

double checked_until(const Session& session, const ReplayOptions& options) {
  const auto strokes = static_cast<double>(strokes_in(session, {}).size());
  const double until = options.part.until.value_or(strokes);
  if (!(until >= 0 && until <= strokes)) {
    throw InvalidInput(
        fmt::format("\"until\" must be from 0 to the session's number of strokes ({}), got {}", strokes, until));
  }
  for (const int number : {options.frames.count, options.frames.hold}) {
    if (number >= 0 && number <= kMaxFrames) continue;
    throw InvalidInput(
        fmt::format("the number of frames, and of those to hold, must be from 0 to {}, got {}", kMaxFrames, number));
  }
  return until;
}

PreparedStroke prepare(const Session& session, const SessionStroke& source, bool backwards) {
  return at_line(session, source, [&] {
    if (backwards && is_applied(source) && !is_flow(source.stroke)) {
      throw InvalidInput(
          "a relax is no flow, so it cannot be taken back; remove this line, or keep the shape before it");
    }
    if (backwards && is_applied(source) && reads_surface(source.stroke)) {
      throw InvalidInput(
          "this stroke reads the surface before the stroke, which is not known from the deformed shape; resolve the "
          "session with the undeformed shape (knead resolve) and use that session instead");
    }
    return prepare_stroke(source, std::filesystem::path(session.name).parent_path());
  });
}

// The times at which strokes begin and end, by their durations.
class Timing {
 public:
  // `until`: within the last stroke, or at its end.
  Timing(const std::vector<const SessionStroke*>& strokes, double until) : until_(until) {
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      durations_.push_back(strokes[i]->duration);
      ends_.push_back((ends_.empty() ? 0 : ends_.back()) + durations_.back());
      length_ += durations_.back() * std::min(1.0, until - static_cast<double>(i));
    }
    if (!std::isfinite(length_)) throw InvalidInput("the durations of the strokes have no sum; give smaller ones");
  }

  double length() const { return length_; }

  // Returns how many strokes are done at a time.
  double strokes_at(double time) const {
    if (time >= length_) return until_;
    const auto end = std::upper_bound(ends_.begin(), ends_.end(), time);
    const auto i = static_cast<std::size_t>(end - ends_.begin());
    const double begin = i == 0 ? 0 : ends_[i - 1];
    return std::min(until_, static_cast<double>(i) + (time - begin) / durations_[i]);
  }

 private:
  std::vector<double> durations_;
  std::vector<double> ends_;  // of the strokes, in time
  double until_;
  double length_ = 0;
};

// The moments of the frames in strokes of the session, in the order of their delivery.
std::vector<double> frame_moments(const ReplayOptions& options, const std::vector<const SessionStroke*>& strokes,
                                  double until) {
  const FrameOptions& frames = options.frames;
  const Timing timing(strokes, until);
  std::vector<double> moments;
  for (int k = -frames.hold; k < frames.count + frames.hold && frames.count > 0; ++k) {
    const int moment = std::clamp(k, 0, frames.count - 1);
    double time = timing.length();
    if (moment + 1 < frames.count) time = time * moment / (frames.count - 1);
    if (frames.ease == Ease::smooth && time > 0) {  // 0 also where nothing is done
      const double part = time / timing.length();
      time = timing.length() * (part * part * (3 - 2 * part));
    }
    moments.push_back(timing.strokes_at(is_backwards(options) ? timing.length() - time : time));
  }
  return moments;
}

// Returns whether the strokes that read the surface would read another one than with the default options.
bool differs_from_standard(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  return !options.motion.is_standard() || (!options.remesh.single_precision && remeshes(mesh, session, options));
}

}  // namespace

std::size_t PlannedStroke::work() const {
  const auto most = static_cast<double>(std::max(stroke.expected_segments, stroke.flow.segments.size()));
  return static_cast<std::size_t>(std::ceil(run.part * (stroke.part * most)));
}

std::uint64_t Plan::work() const {
  std::uint64_t segments = 0;
  for (const PlannedStroke& planned : strokes) {
    segments += planned.stroke.expected_segments + planned.frames.size() + planned.work();
  }
  return segments * points;
}

std::vector<const SessionStroke*> strokes_in(const Session& session, const SessionPart& part) {
  std::vector<const SessionStroke*> strokes;
  for (const SessionStroke& stroke : session.strokes) {
    const bool is_within = !part.until || static_cast<double>(strokes.size()) < *part.until;
    if (!stroke.off && is_within) strokes.push_back(&stroke);
  }
  return strokes;
}

bool has_settings(const Session& session, const ReplayOptions& options) {
  const std::vector<const SessionStroke*> strokes = strokes_in(session, options.part);
  return std::any_of(strokes.begin(), strokes.end(), [&](const SessionStroke* stroke) {
    return is_flow(stroke->stroke) && (stroke->remesh || options.remesh.settings);
  });
}

bool remeshes(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  return mesh.face_count() > 0 && !is_backwards(options) && has_settings(session, options);
}

void require_flow_alone(const Session& session) {
  if (!puts_points_back(session)) return;
  throw InvalidInput(Place{session.name, 1},
                     "points are put back onto walls that are curved, periodic or planes at other than right angles, "
                     "which is no flow: it has no inverse, no certificate, and cannot be resolved");
}

std::vector<IndexRange> splats_of(const Mesh& mesh, const ReplayOptions& options) {
  const Mesh* const meshes[] = {&mesh};
  return options.splats.empty() ? splats_among(meshes) : options.splats;
}

Plan make_plan(const Mesh& mesh, const Session& session, const ReplayOptions& options) {
  advect_options(options.motion, 1);
  if (!session.walls.empty() && !session.constraint) {
    throw InvalidInput(Place{session.name, 1},
                       "the session has walls; they need a mesh that names its patches, such as "
                       "those of gmsh, SU2 and OpenFOAM, and knead deform");
  }
  const double until = checked_until(session, options);
  const bool backwards = is_backwards(options);
  if (backwards || options.on_stroke) require_flow_alone(session);
  const std::vector<const SessionStroke*> strokes = strokes_in(session, options.part);
  Plan plan;
  Mask mask;  // backwards; forwards the shape has it
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    const double part = std::min(1.0, until - static_cast<double>(i));
    plan.strokes.push_back({prepare(session, *strokes[i], backwards), {backwards, part, false}, {}});
    if (plan.strokes.back().stroke.reads_surface) plan.strokes_on_reference = plan.strokes.size();
    plan.strokes.back().stroke.mask = mask;
    const auto* masks = std::get_if<MaskStroke>(&strokes[i]->stroke);
    if (backwards && masks != nullptr && is_applied(*strokes[i])) {
      mask = at_line(session, *strokes[i], [&] { return mask_of(*masks, options.motion.threads); });
    }
  }
  if (!differs_from_standard(mesh, session, options)) plan.strokes_on_reference = 0;
  const auto carried = std::count_if(options.normals.begin(), options.normals.end(), has_direction);
  plan.points = mesh.vertex_count() + 4 * static_cast<std::uint64_t>(carried);
  for (const IndexRange& splats : splats_of(mesh, options)) plan.points += splats.end - splats.begin;
  if (plan.strokes_on_reference > 0) plan.points *= 2;
  const std::vector<double> moments = frame_moments(options, strokes, until);
  auto moment = moments.begin();
  const std::size_t count = plan.strokes.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = backwards ? count - 1 - k : k;
    PlannedStroke& stroke = plan.strokes[i];
    const auto begin = static_cast<double>(i);
    for (; moment != moments.end() && (backwards ? *moment > begin : *moment < begin + stroke.run.part); ++moment) {
      stroke.frames.push_back(*moment - begin);
    }
    stroke.run.has_frames = !stroke.frames.empty();
  }
  if (backwards) std::reverse(plan.strokes.begin(), plan.strokes.end());
  plan.last_frames = static_cast<std::size_t>(moments.end() - moment);
  return plan;
}

}  // namespace knead::detail
