// The field that strains a body least and meets wanted velocities (spec: poses). Contains no mesh: a body is a set of
// points. Internal to the library.
//
// The field is v = curl A of a grid (knead/field.h). Its coefficients a minimise
//     mean over the body's samples of stiffness |sym grad v|^2 + ridge |a|^2 + sum over rows of weight |row(v) -
//     wanted|^2.
// The coefficients are 0 where everything near rests, so a fine grid costs only what it moves.
// If volumes may change, v = curl A + grad p; |sym grad v|^2 is then that of the traceless part, and
// stiffness growth_weight (div v - growth)^2 is added. An elastic body adds its strain: |sym grad v - strain|^2.
// A rigid motion has no strain, so the flow is as rigid as the rows allow. Adding a gradient to A changes no v, so a
// third of the unknowns is nearly free; the ridge determines them.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/vec.h"

namespace knead::detail {

// Evenly spread points of the body. The other lists have an item for each point, or are empty.
struct BodySamples {
  std::vector<Vec3d> points;
  std::vector<double> stiffness{};  // weights above 0; empty: all 1
  std::vector<bool> held{};         // the points that rest; empty: none
  // Any number of positions that the body also occupies, now or while the field acts. The field is complete there and
  // continues that of the body as rigidly as possible.
  std::vector<Vec3d> around{};
  std::vector<double> growth{};    // the wanted values of div v; empty: volumes stay
  double growth_weight = 1.0 / 3;  // of div v; above 0. With 1/3 and a growth of 0 the whole strain counts
  std::vector<Mat3d> strain{};     // the wanted strains, symmetric; empty: 0
  // If given, only nodes whose support it accepts are unknown, so v is exactly 0 outside of these supports.
  std::function<bool(const Box&)> accepts{};
};

// Points where velocities are wanted.
struct VelocityRows {
  std::vector<Vec3d> points;
  std::vector<Vec3d> wanted;     // a velocity for each point
  double weight = 1;             // of each row, in units of the mean diagonal of the strain times spacing^2; above 0
  bool spins = false;            // the points are a patch that also turns about its centre at an unknown rate
  std::vector<Vec3d> normals{};  // a unit vector for each point: only n.v is wanted; empty: the whole velocity
  bool rests = false;            // the points rest, as held samples do
};

// The lattice that all grids of a motion share: nodes at origin + spacing (i, j, k).
struct Lattice {
  Vec3d origin{0, 0, 0};
  double spacing = 1;
};

// Returns how many unknown coefficients there are.
std::size_t count_unknowns(const Lattice& lattice, const BodySamples& body, std::span<const VelocityRows> rows);

// The factorised equations for one moment. They can be solved again for other wanted velocities.
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
