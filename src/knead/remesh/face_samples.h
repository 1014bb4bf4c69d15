// Samples within faces that are large beside a deformation. Internal to the remesh room.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "knead/remesh/remesh.h"

namespace knead::remesh_detail {

// Edges do not tell what a small tool does in the middle of a large face.
class FaceSamples {
 public:
  explicit FaceSamples(const Deformation& deformation) : deformation_(deformation) {}

  // Adds samples a quarter of the deformation's feature apart, where the face may be moved at all: none in one that is
  // smaller than half a feature.
  void add(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after);

  // The faces, as they were added, of which some sample is carried to farther than `distance` from its place on the
  // flat face after.
  std::vector<std::uint32_t> faces_off(double distance) const;

 private:
  void divide(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after, int depth);

  const Deformation& deformation_;
  std::vector<std::uint32_t> faces_;
  std::vector<Vec3d> before_;
  std::vector<Vec3d> after_;
};

}  // namespace knead::remesh_detail
