// One stroke that moves a shape.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knead/editor/shape_state.h"
#include "knead/editor/tools.h"
#include "strokes/print.h"

namespace knead::session_detail {

// A stroke that is ready to be applied.
struct PreparedStroke {
  const SessionStroke* source = nullptr;
  std::shared_ptr<const Stroke> beyond;  // takes the source's place if its strength is above 1, or it is in a file
  double part = 1;                       // of the segments, by the source's strength
  const RelaxStroke* relax = nullptr;    // the stroke, if it is one: without a flow
  bool reads_surface = false;            // the flow and the limit cylinders are unknown until it is read
  Flow flow;
  std::vector<StrokeCylinder> limit_cylinders;  // its own, and those of its images
  std::shared_ptr<const Mesh> tool;             // of a stamp
  std::shared_ptr<const GreyPattern> pattern;   // of a print
  Mask mask;                                    // of a stroke that is applied backwards; forwards the shape has it
  std::size_t expected_segments = 0;            // of one that reads the surface: at most
  bool mesh_follows = false;                    // it is remeshed after the stroke
  double detail = 0;                            // of reading it: the least radius that the mesh must show; 0: any
  StrokeOutcome outcome;                        // of reading it

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
  double part = 1;          // of what its strength applies, from the first segment on
  bool has_frames = false;  // moments within the stroke will be asked for
};

// Call begin, then frame for any number of moments in order, then finish. Each does nothing once the status is not
// done.
class StrokeRun {
 public:
  // The shape must outlive the run.
  StrokeRun(PreparedStroke stroke, const RunOptions& options, DeformedShape& shape, Progress* progress);

  // Reads the surface if the stroke has not been read, and checks its limit cylinders. Throws InvalidInput for a stroke
  // that the shape cannot take.
  void begin();
  // Does the same without the check.
  void read();

  // Returns the shape at a moment of the stroke, from 0 to 1; the next call changes it.
  const DeformedShape& frame(double moment);

  // Completes the stroke, and remeshes.
  void finish();

  AdvectStatus status() const { return stroke_.outcome.status; }
  const PreparedStroke& stroke() const { return stroke_; }  // after begin: as it was read
  StrokeOutcome take_outcome() { return std::move(stroke_.outcome); }
  std::size_t segments() const;  // of the flow that have moved the shape, a part of one counted as one
  // Returns the flow that the stroke moves the shape by until a moment from 0 to 1, as far as it is applied.
  Flow flow(double moment = 1) const;
  const std::optional<Remeshed>& remeshed() const { return remeshed_; }

 private:
  // For a stroke with limit cylinders, of one segment: the points that the same parts of its flow moved, one part or
  // the sum of several, and the shape that the inverse of these parts makes if it moves every point.
  struct InverseImage {
    unsigned parts = 1;  // as bits
    DeformedShape shape{};
    AdvectStatus status = AdvectStatus::done;
    std::vector<bool> members{};
  };

  double length() const;  // as far as its strength applies the stroke, in segments or points to relax at
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
  double at_ = 0;             // where the shape is within the stroke, in segments or points to relax at
  std::vector<Vec3d> start_;  // the positions at the beginning of a stroke that is remeshed
  std::optional<std::vector<InverseImage>> inverse_images_;
  std::optional<Remeshed> remeshed_;
};

}  // namespace knead::session_detail
