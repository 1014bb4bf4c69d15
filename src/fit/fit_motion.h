// A shape that near-rigid steps carry along, with its landmarks. Internal to the fit module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/flow.h"
#include "knead/mesh.h"
#include "knead/vec.h"
#include "pose/near_rigid.h"
#include "pose/sound_steps.h"

namespace knead::detail {

// The target of a landmark.
struct FitMark {
  Vec3d place;
  double tolerance = 0;  // a length
};

// The shape in motion. A copy saves its state.
class FitMotion {
 public:
  // Accuracy is relative to the diagonal. The triangles, the judge of its steps and progress must outlive it.
  FitMotion(std::vector<Vec3d> positions, std::span<const Triangle> triangles, double diagonal, const SoundJudge& judge,
            int threads, Progress* progress);

  // Sets points of the shape as landmarks. Everything within a small distance of one moves as a rigid patch.
  void set_marks(std::span<const Vec3d> points, std::vector<FitMark> marks);

  // Sets points that are only carried along.
  void set_followers(std::vector<Vec3d> points) { followers_ = std::move(points); }
  const std::vector<Vec3d>& followers() const { return followers_; }

  // Lets volumes change from the next spacing on.
  void let_grow() { grows_ = true; }
  // Lets the whole shape grow by the factor while `from` moves to `to`; needs let_grow(). Changes the spacing. Returns
  // false at the first step that is not sound.
  bool grow(double factor, const Vec3d& from, const Vec3d& to);

  // Sets more such points, for some of the steps.
  void set_guides(std::vector<Vec3d> points) { guides_ = std::move(points); }
  const std::vector<Vec3d>& guides() const { return guides_; }

  // Sets the greatest stretch or compression of a triangle since the start.
  void set_max_stretch(double stretch) { max_stretch_ = stretch; }

  // From the next spacing on, makes the body stiff where refused steps were not sound; or soft again everywhere.
  void stiffen() { stiff_ = unsound_; }
  void soften();
  // Returns true if a position is near one of them.
  bool is_stiff(const Vec3d& at) const;

  // Samples the body again, for grids of this spacing, a length.
  void set_spacing(double spacing);

  // Returns the present positions of the landmarks.
  std::vector<Vec3d> marks_at() const;
  // Returns the greatest distance of a landmark from its target beyond its tolerance.
  double miss() const;

  // Returns the grid that moves the landmarks to `to`, one position for each, and meets the rows. Moves nothing. Throws
  // InvalidInput if the equations are singular, and Cancelled.
  PotentialGrid solve(std::span<const Vec3d> to, std::vector<VelocityRows> rows);

  // Moves everything by a grid and returns an empty text, or says why the surface would not be sound, and stays. Throws
  // Cancelled.
  std::string take(PotentialGrid grid);

  // Moves everything by a stroke.
  void carry(const Flow& flow);

  double diagonal() const { return diagonal_; }
  double spacing() const { return lattice_.spacing; }
  std::size_t unknowns() const { return unknowns_; }
  const std::vector<Vec3d>& positions() const { return positions_; }
  const std::vector<PotentialGrid>& grids() const { return grids_; }
  const std::vector<FitMark>& marks() const { return marks_; }

 private:
  void move(const Flow& flow, std::vector<Vec3d>& points, Progress* progress) const;
  void move_others(const Flow& flow);
  double weight_of(std::size_t mark, const Vec3d& at) const;

  std::vector<Vec3d> positions_;
  std::span<const Triangle> triangles_;
  double diagonal_ = 0;
  int threads_ = 0;
  bool grows_ = false;
  double growth_ = 0;  // the wanted div v everywhere; 0: none is wanted
  Progress* progress_ = nullptr;
  const SoundJudge* judge_;
  double max_stretch_ = kInfinity;
  std::vector<std::uint32_t> stiff_;    // vertices
  std::vector<std::uint32_t> unsound_;  // in steps that were not taken
  Lattice lattice_;
  BodySamples body_;
  std::vector<Vec3d> before_;                // the body's points one step earlier
  std::vector<std::vector<Vec3d>> patches_;  // of the landmarks: themselves first
  std::vector<FitMark> marks_;
  std::vector<Vec3d> followers_;
  std::vector<Vec3d> guides_;
  std::vector<PotentialGrid> grids_;
  std::size_t unknowns_ = 0;  // of the largest grid
};

}  // namespace knead::detail
