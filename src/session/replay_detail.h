// The plan of a replay, and the exact image with which it compares the faces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/replay.h"
#include "session/stroke_run.h"

namespace knead::detail {

// A stroke that is applied, wholly or in part.
struct PlannedStroke {
  PreparedStroke stroke;
  RunOptions run;
  std::vector<double> frames;  // moments of the stroke, from 0 to 1, in order of delivery

  std::size_t work() const;  // upper bound of the segments by which it moves the points
};

struct Plan {
  std::vector<PlannedStroke> strokes;  // in order of application
  std::size_t last_frames = 0;         // delivered after all strokes
  // The number of first strokes that are also applied to a second shape, because one of them reads the surface and the
  // options are not the default ones.
  std::size_t strokes_on_reference = 0;
  std::uint64_t points = 0;  // points of all shapes that a segment moves

  // Returns what the replay adds to Progress::done.
  std::uint64_t work() const;
};

// Returns the vertices that a replay treats as splats.
std::vector<IndexRange> splats_of(const Mesh& mesh, const ReplayOptions& options);

// Reads the files of stamps. Throws InvalidInput for options out of range, and with the session's line for a stroke
// that cannot be applied: one that reads the surface, backwards; a stamp whose tool cannot be used.
Plan make_plan(const Mesh& mesh, const Session& session, const ReplayOptions& options);

inline bool is_backwards(const ReplayOptions& options) { return options.part.direction == Direction::backwards; }

// Throws InvalidInput if the session is no flow, because it puts points back onto walls.
void require_flow_alone(const Session& session);

// Returns the strokes that are not off, up to the one that the part ends in.
std::vector<const SessionStroke*> strokes_in(const Session& session, const SessionPart& part);

// Returns whether a stroke that is applied has remesh settings.
bool has_settings(const Session& session, const ReplayOptions& options);

// Returns Replay::remeshes().
bool remeshes(const Mesh& mesh, const Session& session, const ReplayOptions& options);

// The exact image of a surface under strokes.
class ExactImage {
 public:
  // `provenance`: that of the shape whose surface this is; null for one that was not remeshed.
  explicit ExactImage(std::shared_ptr<const Mesh> surface, const Provenance* provenance = nullptr)
      : surface_(std::move(surface)), provenance_(provenance) {}

  // Adds a stroke that has moved the shape. A relax is no flow: after it the image is that of the relaxed shape.
  void add(const StrokeRun& run, const DeformedShape& shape);

  // Compares the shape with the image; call this once for each stroke. Returns a sentence if the shape is far from it;
  // nothing if it is near, or if a path line runs to infinity. Throws QualityLimit if options.must_follow is not met.
  // Time: that of moving 1024 points and 1.6% of the vertices, and of a tree over the faces if the shape is remeshed or
  // far.
  std::optional<std::string> compare(const DeformedShape& shape, const ReplayOptions& options);

  // Returns Workbench::missed_motion(), in the time of compare().
  double missed_motion(const DeformedShape& shape, Progress* progress) const;

 private:
  std::shared_ptr<const Mesh> surface_;
  const Provenance* provenance_;  // of the surface
  Flow flow_;                     // that has moved it since
  std::size_t remeshes_ = 0;      // each of which adds an error of its own
};

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

}  // namespace knead::detail
