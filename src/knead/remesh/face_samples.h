// Samples inside faces that are large compared with a deformation. Internal to the remesh room.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "knead/remesh/remesh.h"

namespace knead::remesh_detail {

// Sample points inside large faces. Edges alone do not show what a small tool does in the middle of a face.
class FaceSamples {
 public:
  explicit FaceSamples(const Deformation& deformation) : deformation_(deformation) {}

  // Adds samples of a face, about a quarter of deformation.feature apart, where the face may be moved. A face smaller
  // than half a feature gets none.
  void add(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after);

  // Returns the faces with a sample that the deformation moves to more than `distance` from its point on the flat face
  // after; in the order in which they were added.
  std::vector<std::uint32_t> deviating_faces(double distance) const;

 private:
  void divide(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after, int depth);

  const Deformation& deformation_;
  std::vector<std::uint32_t> faces_;
  std::vector<Vec3d> before_;
  std::vector<Vec3d> after_;
};

}  // namespace knead::remesh_detail
