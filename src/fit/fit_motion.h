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

// The target of a landmark.
struct FitMark {
  Vec3d place;
  double tolerance = 0;  // a length
};

// The shape in motion. A copy saves its state.
class FitMotion {
 public:
  // Accuracy is relative to the diagonal. The triangles and progress must outlive it.
  FitMotion(std::vector<Vec3d> positions, std::span<const Triangle> triangles, double diagonal, int threads,
            Progress* progress);

  // Sets points of the shape as landmarks. Everything within a small distance of one moves as a rigid patch.
  void set_marks(std::span<const Vec3d> points, std::vector<FitMark> marks);

  // Sets points that are only carried along.
  void set_followers(std::vector<Vec3d> points) { followers_ = std::move(points); }
  const std::vector<Vec3d>& followers() const { return followers_; }

  // Lets volumes change from the next spacing on.
  void let_grow() { grows_ = true; }
  // Lets the whole shape grow by the factor while `from` moves to `to`; needs let_grow(). Changes the spacing.
  void grow(double factor, const Vec3d& from, const Vec3d& to);

  // Sets more such points, for some of the steps.
  void set_guides(std::vector<Vec3d> points) { guides_ = std::move(points); }
  const std::vector<Vec3d>& guides() const { return guides_; }

  // Makes the body stiff around these vertices of the shape from the next spacing on.
  void stiffen(std::vector<std::uint32_t> vertices) { stiff_ = std::move(vertices); }
  // Returns true if a position is near one of them.
  bool is_stiff(const Vec3d& at) const;

  // Samples the body again, for grids of this spacing, a length.
  void set_spacing(double spacing);

  // Returns the present positions of the landmarks.
  std::vector<Vec3d> marks_at() const;
  // Returns the greatest distance of a landmark from its target beyond its tolerance.
  double miss() const;

  // Solves for the grid that moves the landmarks to `to`, one position for each, and meets the rows; then moves
  // everything. Throws InvalidInput if the equations are singular, and Cancelled.
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
  double growth_ = 0;  // the wanted div v everywhere; 0: none is wanted
  Progress* progress_ = nullptr;
  std::vector<std::uint32_t> stiff_;
  detail::Lattice lattice_;
  detail::BodySamples body_;
  std::vector<Vec3d> before_;                // the body's points one step earlier
  std::vector<std::vector<Vec3d>> patches_;  // of the landmarks: themselves first
  std::vector<FitMark> marks_;
  std::vector<Vec3d> followers_;
  std::vector<Vec3d> guides_;
  std::vector<PotentialGrid> grids_;
  std::size_t unknowns_ = 0;  // of the largest grid
};

}  // namespace knead::fit_detail
