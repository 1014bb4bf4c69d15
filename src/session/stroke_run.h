// One stroke that moves a shape.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "knead/editor/shape_state.h"
#include "knead/editor/tools.h"
#include "strokes/print.h"

namespace knead::detail {

// A stroke that is ready to be applied.
struct PreparedStroke {
  const SessionStroke* source = nullptr;
  std::shared_ptr<const Stroke> beyond;  // stands for the source if its strength is above 1, or it is in a file
  double part = 1;                       // the fraction of the segments that the source's strength applies
  const RelaxStroke* relax = nullptr;    // the stroke if it relaxes; there is no flow then
  bool reads_surface = false;            // the flow and the limit cylinders are unknown until it has read the surface
  Flow flow;
  std::vector<StrokeCylinder> limit_cylinders;  // its own, and those of its images
  std::shared_ptr<const Mesh> tool;             // of a stamp
  std::shared_ptr<const GreyPattern> pattern;   // of a print
  Mask mask;                                    // of a stroke that is applied backwards; forwards the shape has it
  std::size_t expected_segments = 0;            // upper bound, for a stroke that reads the surface
  bool mesh_follows = false;                    // the mesh is remeshed after the stroke
  double detail = 0;                            // set by reading: the least radius that the mesh must show; 0: any
  StrokeOutcome outcome;                        // set by reading

  const Stroke& stroke() const { return beyond ? *beyond : source->stroke; }
};

// Returns the pattern of a valid print. Throws InvalidInput, beginning with the key in quotes, for a file that cannot
// be read, for a font that is not found, and for a letter that it lacks.
std::shared_ptr<const GreyPattern> read_pattern(const PrintStroke& stroke, const std::filesystem::path& folder);

// Returns the lattice of the stroke's file. Throws InvalidInput for a file that cannot be read.
LatticeStroke with_file(const LatticeStroke& stroke, const std::filesystem::path& folder);

// Reads the files that a stroke names, relative to the folder. The source must outlive the result. Throws InvalidInput
// for a stroke that cannot be applied to any shape.
PreparedStroke prepare_stroke(const SessionStroke& source, const std::filesystem::path& folder);

// How far a stroke is applied, and in which direction.
struct RunOptions {
  bool backwards = false;
  double part = 1;          // the fraction of the segments that its strength applies, from the first one on
  bool has_frames = false;  // frame() will be called
};

// Applies a stroke: call begin(), then frame() for any number of moments in order, then finish(). Each does nothing if
// the status is not `done`.
class StrokeRun {
 public:
  // The shape must outlive the run.
  StrokeRun(PreparedStroke stroke, const RunOptions& options, DeformedShape& shape, Progress* progress);

  // Reads the surface, unless read() has, and checks the limit cylinders. Throws InvalidInput for a stroke that cannot
  // be applied to the shape.
  void begin();
  // Reads the surface.
  void read();

  // Returns the shape at a moment of the stroke, from 0 to 1; the next call changes it.
  const DeformedShape& frame(double moment);

  // Completes the stroke, and remeshes.
  void finish();

  AdvectStatus status() const { return stroke_.outcome.status; }
  const PreparedStroke& stroke() const { return stroke_; }  // complete after begin()
  StrokeOutcome take_outcome() { return std::move(stroke_.outcome); }
  std::size_t segments() const;  // segments that have moved the shape; a part of one counts as one
  // Returns the flow by which the stroke moves the shape until a moment from 0 to 1, as far as it is applied.
  Flow flow(double moment = 1) const;
  const std::optional<Remeshed>& remeshed() const { return remeshed_; }

 private:
  // For a stroke with limit cylinders and one segment, and for one set of its parts: the shape that the inverse of
  // these parts makes if it moves every point, and the points that exactly these parts have moved.
  struct InverseImage {
    unsigned parts = 1;  // as bits
    DeformedShape shape{};
    AdvectStatus status = AdvectStatus::done;
    std::vector<bool> members{};
  };

  double length() const;  // of the stroke as far as its strength applies it, in segments or points of a relax
  double end() const { return options_.part * length(); }
  void check_shape();
  void check_limit_cylinder();
  void warn_of_cpu();
  void warn_of_border();
  void warn_of_images();
  void advance(double to);
  void move_between(double from, double to, DeformedShape& shape);
  const std::vector<InverseImage>& inverse_images();
  InverseImage inverse_image_by(unsigned parts) const;
  std::vector<bool> members_of(const StrokeCylinder& limit_cylinder, const InverseImage& image) const;
  std::vector<unsigned> parts_that_moved() const;
  void follow(double to, DeformedShape& shape, std::optional<Remeshed>& remeshed);

  PreparedStroke stroke_;
  RunOptions options_;
  DeformedShape& shape_;
  DeformedShape frame_;
  Progress* progress_;
  std::optional<RemeshSettings> settings_;
  double at_ = 0;             // the moment of the shape within the stroke, in segments or points of a relax
  std::vector<Vec3d> start_;  // the positions at the beginning of a stroke that is remeshed
  std::optional<std::vector<InverseImage>> inverse_images_;
  std::optional<Remeshed> remeshed_;
};

}  // namespace knead::detail
