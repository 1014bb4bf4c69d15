// Samples inside faces that are large compared with the details of a deformation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "knead/remesh.h"
#include "knead/vec.h"

namespace knead::detail {

// Sample points inside large faces. Edges alone do not show what a small tool does in the middle of a face.
class FaceSamples {
 public:
  // Adding samples throws Cancelled if `progress` is cancelled; null: never.
  FaceSamples(const Deformation& deformation, const Progress* progress);

  // Returns true if add() may add samples of the face.
  bool is_large(const std::array<Vec3d, 3>& before) const;

  // Adds samples of a face, about a quarter of the smallest detail there apart, where the face may be moved. A face
  // smaller than half a feature gets none.
  void add(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after);

  // Returns the faces, in the order in which they were added, with a sample that the deformation moves farther than
  // `distance` from its point on the flat face after: distance_of(face, deviation) says how far. Returns nothing if
  // this is more work than deformation.points_left() allows, which it asks repeatedly.
  using DistanceOf = std::function<double(std::uint32_t, const Vec3d&)>;
  std::optional<std::vector<std::uint32_t>> deviating_faces(double distance, const DistanceOf& distance_of) const;

  // Throws RemeshLimit: sampling is more work than `max_vertices` allows.
  [[noreturn]] void refuse(std::size_t max_vertices) const;

 private:
  void divide(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after, int depth);

  double points_left() const;

  const Deformation& deformation_;
  const Progress* progress_;
  double max_samples_;
  std::vector<std::uint32_t> faces_;
  std::vector<Vec3d> before_;
  std::vector<Vec3d> after_;
};

}  // namespace knead::detail
