// Takes a shape to another one, stroke by stroke. Internal to the session room.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "knead/session/deformed_shape.h"
#include "knead/session/fit_matches.h"
#include "knead/session/fit_pins.h"
#include "knead/session/report.h"

namespace knead::session_detail {

// Returns how many strokes a fit has at most.
std::size_t most_strokes(const ShapeFitOptions& options);

// A fit under way. Source, target and options must outlive it.
class ShapeFitter {
 public:
  ShapeFitter(const Mesh& source, const Mesh& target, const ShapeFitOptions& options);

  // Makes the strokes and deforms the shape by them. Throws as fit_shape().
  void run();

  const DeformedShape& shape() const { return shape_; }
  std::vector<SessionStroke> take_strokes() { return std::move(strokes_); }
  double landmark_distance() const;  // the greatest of a landmark from its place
  std::size_t crossings_before() const { return crossings_before_; }
  std::size_t crossings() const { return crossings_; }

 private:
  // The shape, the landmarks and the crossings before a stroke.
  struct Moment {
    ShapeState shape;
    std::vector<Vec3d> landmarks;
    std::size_t crossings = 0;
  };

  void fit_surface();
  void fit_level(double radius, std::size_t last_stroke);
  void look();
  Moment moment() const { return {shape_.state(), landmarks_.at, crossings_}; }
  void go_back(const Moment& moment);
  void apply(const PinsStroke& pins);
  void apply(SessionStroke stroke);
  std::size_t count_crossings() const;

  const ShapeFitOptions& options_;
  std::shared_ptr<const Mesh> source_;
  DeformedShape shape_;
  std::vector<Triangle> target_triangles_;
  const Mesh& target_mesh_;
  FitLandmarks landmarks_;
  std::vector<SessionStroke> strokes_;
  std::size_t crossings_before_ = 0;
  std::size_t crossings_ = 0;
  // Of a surface.
  std::unique_ptr<FitSurface> target_;
  std::size_t sample_count_ = 0;
  std::vector<SurfaceSample> target_samples_;
  std::vector<SurfaceSample> samples_;  // of the shape as it is
  Matches matches_;                     // likewise
};

}  // namespace knead::session_detail
