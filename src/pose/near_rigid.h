// The field that strains a body least and meets wanted velocities (spec: poses). Contains no mesh: a body is a set of
// points. Internal to the library.
//
// The field is v = curl A of a grid (knead/field.h). Its coefficients a minimise
//     mean over the body's samples of stiffness |sym grad v|^2 + ridge |a|^2 + sum over rows of weight |row(v) -
//     wanted|^2.
// Where all that is near rests the coefficients are 0: a fine grid costs only what it moves.
// Where volumes may change v = curl A + grad p, |sym grad v|^2 is that of its traceless part, and
// stiffness growth_weight (div v - growth)^2 is added.
// A body that is elastic wants its strain back: |sym grad v - strain|^2.
// A rigid motion has no strain, so the flow moves rigidly wherever it can. A third of the unknowns is nearly free
// (adding a gradient to A changes no v): the ridge takes care of that.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// Points of the body, evenly spread.
struct BodySamples {
  std::vector<Vec3d> points;
  std::vector<double> stiffness{};  // as many weights above 0; empty: all 1
  std::vector<bool> held{};         // as many: what rests; empty: nothing does
  // Where the body also is, or comes to while the field acts: the field is whole there, and goes on from the body as
  // nearly rigidly as it can.
  std::vector<Vec3d> around{};
  // Not empty: volumes may change; as many rates, what div v is wanted to be.
  std::vector<double> growth{};
  double growth_weight = 1.0 / 3;  // of div v; above 0. With 1/3 and a growth of 0 all of the strain counts
  // Not empty: as many symmetric matrices, the strains that the field is wanted to make there in place of none.
  std::vector<Mat3d> strain{};
  // If given, v is exactly 0 outside of boxes that it accepts: only nodes with such a support are unknown.
  std::function<bool(const Box&)> reach{};
};

// Points where velocities are wanted.
struct VelocityRows {
  std::vector<Vec3d> points;
  std::vector<Vec3d> wanted;     // as many velocities
  double weight = 1;             // of each row, in units of the mean diagonal of the strain times spacing^2; above 0
  bool spins = false;            // the points are a patch that also turns about its middle, by a rate that is not given
  std::vector<Vec3d> normals{};  // as many unit vectors: only n.v is wanted; or empty: all of v
  bool rests = false;            // the points hold, as held samples do
};

// The lattice that all grids of a motion share: nodes at origin + spacing (i, j, k).
struct Lattice {
  Vec3d origin{0, 0, 0};
  double spacing = 1;
};

// Returns how many unknown coefficients there are.
std::size_t count_unknowns(const Lattice& lattice, const BodySamples& body, std::span<const VelocityRows> rows);

// The equations of one moment, factorised: wanted velocities can be changed and solved for again.
class NearRigidSystem {
 public:
  static constexpr double kRidge = 1e-6;  // of the mean diagonal of the strain

  // Assembles and factorises. Time: about 0.1 s for 3000 samples and 2000 unknowns. threads as for parallel_for. The
  // bits depend on the arguments alone. Throws InvalidInput if the equations are singular or too many, and Cancelled.
  NearRigidSystem(const Lattice& lattice, const BodySamples& body, std::span<const VelocityRows> rows, int threads = 0,
                  const Progress* progress = nullptr);
  NearRigidSystem(NearRigidSystem&&) noexcept;
  NearRigidSystem& operator=(NearRigidSystem&&) noexcept;
  NearRigidSystem(const NearRigidSystem&) = delete;
  NearRigidSystem& operator=(const NearRigidSystem&) = delete;
  ~NearRigidSystem();

  // Returns the number of unknown coefficients.
  std::size_t unknowns() const;

  // Returns the grid for these wanted velocities. The rows must be those of the constructor except for `wanted`. Time:
  // about 2 ms for 2000 unknowns.
  PotentialGrid solve(std::span<const VelocityRows> rows) const;

 private:
  struct Equations;
  std::unique_ptr<const Equations> equations_;
};

}  // namespace knead::detail
