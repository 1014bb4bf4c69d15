// The map of a box of control points, in closed form, and a proof that it does not fold space (docs/mathematics.md,
// "Lattices"). Internal to the library.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// The polynomials N along one edge of a lattice.
class LatticeAxis {
 public:
  // Those that are not 0 at a place, and their derivatives.
  struct Values {
    int first = 0;
    std::array<double, LatticeMotion::kMaxDegree + 1> value{};
    std::array<double, LatticeMotion::kMaxDegree + 1> rate{};
  };

  LatticeAxis(int count, int degree) : count_(count), degree_(degree) {}

  int degree() const { return degree_; }
  int intervals() const { return count_ - degree_; }

  // Returns the degree() + 1 values at u; beyond 0 and 1 the end polynomials go on.
  Values at(double u) const;

  // Returns where control point i lies, from 0 to 1: with such places the sum of place times N_i is u.
  double place(int i) const;

  // Returns knot j, from 0 to count + degree.
  double knot(int j) const;

 private:
  int count_;
  int degree_;
};

std::array<LatticeAxis, 3> axes_of(const LatticeMotion& lattice);

// Returns whether the two outer layers of control points at each face rest: [axis][0: at u = 0, 1: at u = 1]. A layer
// of two control points is outer at both faces.
std::array<std::array<bool, 2>, 3> closed_faces(const LatticeMotion& lattice);

// Returns the box, moved or not, by corners.
Box bounding_box(const LatticeMotion& lattice);

// What a segment with a lattice may move: the box; at a later beginning also what it then reaches out to.
class LatticeSupport {
 public:
  explicit LatticeSupport(const Segment& segment);

  // Returns true only if no point of the ball moves.
  bool misses(const Vec3d& center, double radius) const;

 private:
  Vec3d origin_;
  Mat3d axes_;
  Vec3d lengths_;
  std::array<std::array<double, 2>, 3> margins_{};  // by which the box may reach out at the beginning
};

// The motion of points by a lattice from one time to another.
class LatticeMap {
 public:
  // The segment must have a lattice.
  explicit LatticeMap(const Segment& segment);

  // Moves a point; returns false if it rests. Adds 0 where nothing moves, so bits stay.
  bool move(Vec3d& x) const;
  // The same, with the Jacobian there.
  bool move(Vec3d& x, Mat3d& jacobian) const;

  // Returns D at the place at t = 0 of the point that is at x at the beginning: its velocity.
  Vec3d velocity(const Vec3d& x) const;

  // Derivatives with respect to the displacements' coordinates, three of each control point in turn. `jacobian` is that
  // of move() at x. Returns how the end of x moves at these rates.
  Vec3d tangent(const Vec3d& x, const Mat3d& jacobian, std::span<const double> rates) const;
  // Adds the gradient of a function to `sums`; `gradient` is that with respect to the end of x.
  void add_gradient(const Vec3d& x, const Mat3d& jacobian, const Vec3d& gradient, std::span<double> sums) const;

 private:
  // The polynomials at a place.
  using Weights = std::array<LatticeAxis::Values, 3>;

  Vec3d to_box(const Vec3d& x) const { return lattice_.axes * (x - lattice_.origin); }
  Vec3d from_box(const Vec3d& v) const;  // of a direction
  Weights weights(const Vec3d& at) const;
  template <class Body>
  void for_each(const Weights& weights, const Body& body) const;
  Vec3d displacement(const Vec3d& at, Mat3d* gradient) const;
  std::optional<Vec3d> find(const Vec3d& x) const;
  std::optional<Vec3d> inside(const Vec3d& at) const;
  std::optional<Vec3d> search(const Vec3d& target, Vec3d at) const;
  Mat3d jacobian_at(const Mat3d& gradient, double time) const;

  LatticeMotion lattice_;
  double begin_;
  double end_;
  LatticeSupport support_;
  std::array<LatticeAxis, 3> axes_;
  std::vector<std::pair<Vec3d, Vec3d>> stations_;  // at the beginning and at t = 0, where a search may start
};

// A place where a lattice folds space, or where the proof ended.
struct LatticeFold {
  Vec3d place;  // at t = 0
  double time = 1;
  double determinant = 0;  // of the Jacobian of x + time D(x) there
};

// Returns nothing if det J > 0 is proven in the whole box, at every time from 0 to `until`. The proof divides the box
// and the time into pieces, in each of which J differs from one matrix K with det K > 0 so little that |K^-1 J - I| < 1
// for all coefficients of J in Bernstein's basis, and so everywhere. A fold has a determinant of at most 0; a place
// with a greater one is so near to a fold that the proof would take too long.
std::optional<LatticeFold> find_fold(const LatticeMotion& lattice, double until = 1);

// Returns a time up to which there is no fold, as near to the first fold as a few trials tell.
double time_without_fold(const LatticeMotion& lattice, const LatticeFold& fold);

}  // namespace knead::detail
