// A shape that near-rigid steps carry along, with its landmarks. Internal to the fit module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "pose/near_rigid.h"

namespace knead::fit_detail {

// A point of the shape and its place.
struct FitMark {
  Vec3d place;
  double tolerance = 0;  // a length
};

// A copy is a moment to go back to.
class FitMotion {
 public:
  // Positions and triangles of the shape, the diagonal that accuracy refers to, and landmarks. The triangles and
  // progress must outlive it.
  FitMotion(std::vector<Vec3d> positions, std::span<const Triangle> triangles, double diagonal, int threads,
            Progress* progress);

  // Adds points of the shape as landmarks: what is within a small distance of one moves as a rigid patch.
  void set_marks(std::span<const Vec3d> points, std::vector<FitMark> marks);

  // Points that are only carried along.
  void set_followers(std::vector<Vec3d> points) { followers_ = std::move(points); }
  const std::vector<Vec3d>& followers() const { return followers_; }

  // Volumes may change from the next spacing on.
  void let_grow() { grows_ = true; }
  // Where volumes may change: the whole shape grows by the factor, and `from` goes to `to`. Changes the spacing.
  void grow(double factor, const Vec3d& from, const Vec3d& to);

  // Others, for a while.
  void set_guides(std::vector<Vec3d> points) { guides_ = std::move(points); }
  const std::vector<Vec3d>& guides() const { return guides_; }

  // The body is stiff about these vertices of the shape from the next spacing on.
  void stiffen(std::vector<std::uint32_t> vertices) { stiff_ = std::move(vertices); }
  // Whether a place is near one of them.
  bool is_stiff(const Vec3d& at) const;

  // The body is sampled anew for grids of this spacing, a length.
  void set_spacing(double spacing);

  // Where the landmarks should be after a step.
  std::vector<Vec3d> marks_at() const;
  // The greatest distance of a landmark from its place beyond its tolerance.
  double miss() const;

  // Solves for the grid that takes the landmarks to `to`, one for each, and meets the rows, and moves everything. The
  // weights of rows are those of VelocityRows. Throws InvalidInput where the equations are singular, and Cancelled.
  void step(std::span<const Vec3d> to, std::vector<detail::VelocityRows> rows);

  // Moves everything by a stroke that turns or shifts the whole shape.
  void carry(const Flow& flow);

  double diagonal() const { return diagonal_; }
  double spacing() const { return lattice_.spacing; }
  std::size_t unknowns() const { return unknowns_; }
  const std::vector<Vec3d>& positions() const { return positions_; }
  const std::vector<PotentialGrid>& grids() const { return grids_; }
  const std::vector<FitMark>& marks() const { return marks_; }

 private:
  void move(const Flow& flow, std::vector<Vec3d>& points, Progress* progress) const;
  double weight_of(std::size_t mark, const Vec3d& at) const;

  std::vector<Vec3d> positions_;
  std::span<const Triangle> triangles_;
  double diagonal_ = 0;
  int threads_ = 0;
  bool grows_ = false;
  double growth_ = 0;  // what div v shall be everywhere; 0: as the rest of the strain asks
  Progress* progress_ = nullptr;
  std::vector<std::uint32_t> stiff_;
  detail::Lattice lattice_;
  detail::BodySamples body_;
  std::vector<Vec3d> before_;                // where the body's points were a step ago
  std::vector<std::vector<Vec3d>> patches_;  // of the landmarks: themselves first
  std::vector<FitMark> marks_;
  std::vector<Vec3d> followers_;
  std::vector<Vec3d> guides_;
  std::vector<PotentialGrid> grids_;
  std::size_t unknowns_ = 0;  // the most
};

}  // namespace knead::fit_detail
