// Samples inside faces that are large compared with a deformation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "knead/error.h"
#include "knead/remesh.h"
#include "remesh/patch.h"

namespace knead::remesh_detail {

// Sample points inside large faces. Edges alone do not show what a small tool does in the middle of a face.
class FaceSamples {
 public:
  // Adding samples throws Cancelled if `progress` says so; null: never.
  FaceSamples(const Deformation& deformation, const Progress* progress);

  // Returns whether add() may add samples of the face.
  bool is_large(const std::array<Vec3d, 3>& before) const;

  // Adds samples of a face, about a quarter of deformation.feature apart, where the face may be moved. A face smaller
  // than half a feature gets none.
  void add(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after);

  // Returns the faces with a sample that the deformation moves to more than `distance` from its point on the flat face
  // after; in the order in which they were added. Returns nothing if that is more work than deformation.points_left()
  // allows, which it asks again and again.
  std::optional<std::vector<std::uint32_t>> deviating_faces(double distance) const;

  // Throws RemeshLimit that says so.
  [[noreturn]] void refuse(std::size_t max_vertices) const;

 private:
  void divide(std::uint32_t face, const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after, int depth);

  double points_left() const;

  const Deformation& deformation_;
  const Progress* progress_;
  double most_;  // samples that are made
  std::vector<std::uint32_t> faces_;
  std::vector<Vec3d> before_;
  std::vector<Vec3d> after_;
};

// Keeps the authored normals of a patch correct.

// Transforms the attribute "normal" (3 components) of vertices or corners by the deformation from `before` to `after`
// of the surface (see transport_normals), also for vertices that splits have made.
void turn_normals(const Mesh& mesh, Surface& surface);

// Scales the normals of the surface to length 1. Lengths that are 1 to the rounding of float keep their bits.
void normalise_normals(const Mesh& mesh, Surface& surface);

}  // namespace knead::remesh_detail
