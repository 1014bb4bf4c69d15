// Which points of two surfaces belong together (knead fit --surface).
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "knead/certify.h"
#include "knead/error.h"
#include "knead/mesh.h"
#include "knead/replay.h"
#include "knead/stroke.h"

namespace knead::session_detail {

// A point of a surface with its unit normal.
struct SurfaceSample {
  Vec3d point;
  Vec3d normal;
};

// A surface that nearest points are looked for on.
class FitSurface {
 public:
  // There is at least one triangle.
  FitSurface(std::vector<Triangle> triangles, std::vector<Vec3d> positions);

  double area() const { return area_; }
  double mean_edge() const { return mean_edge_; }

  // Returns `count` points, evenly by area; always the same ones.
  std::vector<SurfaceSample> samples(std::size_t count) const;

  // Returns the nearest point.
  SurfaceSample closest(const Vec3d& p) const;

 private:
  Vec3d normal_at(std::uint32_t triangle, const std::array<double, 3>& barycentric) const;

  std::vector<Triangle> triangles_;
  std::vector<Vec3d> positions_;
  std::vector<Vec3d> normals_;     // of the vertices
  std::vector<double> area_upto_;  // of the triangles up to each, it included
  double area_ = 0;
  double mean_edge_ = 0;
  SurfaceTree tree_;
};

// A point of the source's surface that shall move by `by` along `direction`; how it moves across that is free.
struct Match {
  Vec3d at;
  Vec3d direction;  // a unit vector
  double by = 0;
  double weight = 1;  // 0 to 1: how sure the match is
};

struct Matches {
  std::vector<Match> all;
  double mean_distance = 0;  // of the samples of both surfaces from the other one
};

// Matches samples of the source to the target's surface, and samples of the target to the source's. A match counts less
// where the normals disagree, and where it is much farther than most.
Matches match(const FitSurface& source, std::span<const SurfaceSample> of_source, const FitSurface& target,
              std::span<const SurfaceSample> of_target, int threads, const Progress* progress);

// Pins that take a surface to its matches (knead fit --surface).

// Landmarks, where they are and where they belong.
struct FitLandmarks {
  std::vector<Vec3d> at;
  std::vector<Vec3d> to;
};

// How the field of the pins is made.
struct PinFieldOptions {
  double radius = 0;                   // of the pins
  double smoothness = 0;               // what the field's norm counts beside the matches
  const Progress* progress = nullptr;  // cancels
};

// Returns pins that are evenly spaced on the samples, the landmarks among them first. Landmarks go to their places. All
// other pins move as the smoothest divergence-free field of this radius does that brings the matches together: by least
// squares, so that pins slip along the surface where nothing tells them how to move along it. Motions are so small that
// no two pins come near each other. Throws Cancelled.
PinsStroke fit_pins(std::span<const Match> matches, std::span<const SurfaceSample> samples,
                    const FitLandmarks& landmarks, const PinFieldOptions& options);

// The distance of neighbouring pins, in radii. With 0.4 the fields are too rough: fits end three to six times as far
// away.
inline constexpr double kPinSpacing = 0.25;

// Takes a shape to another one, stroke by stroke.

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
