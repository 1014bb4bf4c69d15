// How far the faces of a deformed shape are from the exact image of the surface before.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "session/stroke_run.h"

namespace knead::session_detail {

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

}  // namespace knead::session_detail
