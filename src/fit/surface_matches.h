// Matches points of two surfaces. Internal to the fit module.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

// A point of a surface with its unit normal.
struct SurfaceSample {
  Vec3d point;
  Vec3d normal;
};

// Points of a surface that stay in their triangles.
class SurfaceSamples {
 public:
  // Chooses `count` evenly spread points, always the same ones. There is at least one triangle with an area.
  SurfaceSamples(std::span<const Triangle> triangles, std::span<const Vec3d> positions, std::size_t count);

  // Returns the points for these positions of the vertices.
  std::vector<SurfaceSample> at(std::span<const Triangle> triangles, std::span<const Vec3d> positions) const;

  // Returns which points are on the border of an open surface: nearer to it than two candidates are to each other.
  std::vector<bool> on_border(std::span<const Triangle> triangles, std::span<const Vec3d> positions) const;

  std::size_t size() const { return places_.size(); }

 private:
  struct TrianglePoint {
    std::uint32_t triangle = 0;
    std::array<double, 3> barycentric{};
  };
  std::vector<TrianglePoint> places_;
};

// The length of unit normals in distances between samples, as a fraction of the diagonal.
inline constexpr double kNormalLength = 0.15;

// Finds the nearest sample by positions and normals.
class SampleTree {
 public:
  // normal_length: the length of unit normals in distances.
  SampleTree(std::vector<SurfaceSample> samples, double normal_length);

  // Returns the number of the nearest sample.
  std::uint32_t nearest(const SurfaceSample& to) const;

  const SurfaceSample& operator[](std::uint32_t i) const { return samples_[i]; }

 private:
  using Point = std::array<double, 6>;
  struct Node {
    double split = 0;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t axis = 0;
    std::uint32_t upper = 0;  // the node of the upper half; 0: a leaf
  };
  Point point_of(const SurfaceSample& sample) const;
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  void search(std::uint32_t number, const Point& p, double& best, std::uint32_t& found) const;

  std::vector<SurfaceSample> samples_;
  double normal_length_;
  std::vector<Point> points_;           // in the order of the tree
  std::vector<std::uint32_t> numbers_;  // in the same order
  std::vector<Node> nodes_;
};

// A wanted displacement of a point of the source.
struct Match {
  Vec3d at;
  Vec3d by;
  Vec3d normal;       // of the target there
  double weight = 0;  // 0 to 1
};

// All matches, and their medians.
struct Matches {
  std::vector<Match> all;
  double median = 0;        // distance
  double median_along = 0;  // distance along the target's normals
  double matched = 0;       // the part of the source's samples that have a match
};

// How match() works.
struct MatchOptions {
  double normal_length = 0;  // as for SampleTree
  double far = 0;            // a length: the match of a match must come back within it
  // For each candidate: matches that end there are dropped, because the other surface continues beyond it. Empty: none.
  std::vector<bool> source_border{};
  std::vector<bool> target_border{};
  int threads = 0;
};

// Matches samples of the source to candidates of the target, and samples of the target to candidates of the source. A
// distant match, or one with different normals, has less weight. Throws nothing. Time: about 20 us a sample.
Matches match(const SampleTree& source, std::span<const SurfaceSample> of_source, const SampleTree& target,
              std::span<const SurfaceSample> of_target, const MatchOptions& options);

// Matches each sample to that of the same number. The displacement counts as one along the normal. There is at least
// one.
Matches match_in_order(std::span<const SurfaceSample> from, std::span<const SurfaceSample> to);

}  // namespace knead::detail
