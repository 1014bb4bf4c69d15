// The surfaces that points of walls are kept on. Internal to the library.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "knead/mesh.h"
#include "knead/stroke.h"
#include "knead/vec.h"

namespace knead::detail {

// A cylinder, or a sphere if the axis is zero.
struct RoundForm {
  Vec3d center;
  Vec3d axis;
};

// Returns the cylinder or sphere that all points lie on, to 1e-5 of its radius; nothing if they lie on none. `faces`
// names the points. The result does not depend on the order of either.
std::optional<RoundForm> round_form_of(std::span<const Triangle> faces, std::span<const Vec3d> points);

// Returns the normal of a face times twice its area; of an edge, whose end is named twice, across it in the plane z =
// 0.
Vec3d wall_normal(const Vec3d& a, const Vec3d& b, const Vec3d& c);

// A patch at the start, and the places that each of its points may take.
class WallSurface {
 public:
  enum class Form {
    fixed,    // its points stay
    open,     // no surface keeps its points
    plane,    // each keeps its distance from the plane through the middle of the form
    round,    // each keeps its distance from the centre or the axis
    polygons  // each stays on the faces; on an edge of the patch, or a crease, it stays on that line; at a corner it
              // stays
  };

  // `points`: of the mesh. `numbers`: those of the patch, ascending; faces name the mesh's points.
  WallSurface(Form form, std::span<const std::uint32_t> numbers, std::span<const Triangle> faces,
              std::span<const Vec3d> points);

  void set_plane(const Vec3d& normal) { form_of_.axis = normal; }
  void set_round(const RoundForm& form) { form_of_ = form; }

  Form form() const { return form_; }
  const std::vector<std::uint32_t>& numbers() const { return numbers_; }  // of the mesh's points
  const std::vector<Triangle>& faces() const { return faces_; }           // which name places in numbers()
  const SurfaceTree& tree() const { return *tree_; }

  // Returns the allowed place nearest to `p` of the i-th point of numbers(). `before`: an earlier allowed place; the
  // nearer it is, the less this costs.
  Vec3d put_back(std::size_t i, const Vec3d& p, const Vec3d& before) const;

  // Returns unit normals at the patch's points, from the faces around each. The side is that of the first face.
  std::vector<Vec3d> normals(std::span<const Vec3d> places) const;

 private:
  void find_lines();

  enum class Place : std::uint8_t { face, line, corner };

  Form form_;
  RoundForm form_of_{};
  std::vector<std::uint32_t> numbers_;
  std::vector<Vec3d> start_;  // of the patch's points
  std::vector<Triangle> faces_;
  std::vector<std::size_t> first_around_;  // of each point, in around_
  std::vector<std::uint32_t> around_;      // its faces
  std::vector<double> sides_;              // 1 or -1 for each of these
  std::optional<SurfaceTree> tree_;
  std::optional<SurfaceTree> lines_;
  std::vector<Place> places_;
};

}  // namespace knead::detail
