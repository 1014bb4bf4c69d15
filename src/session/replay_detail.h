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
  std::uint64_t points = 0;  // that a segment moves, of all shapes

  // Returns what the replay adds to Progress::done.
  std::uint64_t work() const;
};

// Returns the vertices that a replay treats as splats.
std::vector<IndexRange> splats_of(const Mesh& mesh, const ReplayOptions& options);

// Reads the files of stamps. Throws InvalidInput for options out of range, and with the session's line for a stroke
// that cannot be applied: one that reads the surface, backwards; a stamp whose tool cannot be used.
Plan make_plan(const Mesh& mesh, const Session& session, const ReplayOptions& options);

inline bool is_backwards(const ReplayOptions& options) { return options.part.direction == Direction::backwards; }

// Throws InvalidInput if walls of the session are kept by more than its flow.
void require_flow_alone(const Session& session);

// Returns the strokes that are not off, up to the one that the part ends in.
std::vector<const SessionStroke*> strokes_in(const Session& session, const SessionPart& part);

// Returns whether a stroke that is applied has remesh settings.
bool has_settings(const Session& session, const ReplayOptions& options);

// Returns Replay::remeshes().
bool remeshes(const Mesh& mesh, const Session& session, const ReplayOptions& options);

// The exact image of a surface, which strokes move.
class ExactImage {
 public:
  explicit ExactImage(std::shared_ptr<const Mesh> surface) : surface_(std::move(surface)) {}

  // Follows a stroke that has moved the shape. After a relax, which is no flow, it is the image of that shape.
  void add(const StrokeRun& run, const DeformedShape& shape);

  // Compares the shape with the image, once for each stroke. Returns a sentence if it is far from it, nothing if not,
  // or where a path line runs away. Throws QualityLimit if options.must_follow is not met. Takes the time of moving
  // 1024 points and 1.6% of the vertices; where the shape is remeshed or far, also that of a tree over its faces.
  std::optional<std::string> compare(const DeformedShape& shape, const ReplayOptions& options);

 private:
  std::shared_ptr<const Mesh> surface_;
  const Provenance* provenance_ = nullptr;  // of the surface
  Flow flow_;                               // that has moved it since
  std::size_t remeshes_ = 0;                // each of which adds an error of its own
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

}  // namespace knead::session_detail
