// Flows, and the functions that move points along their path lines. A flow is a plain value that contains no mesh
// (method, section 3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "knead/error.h"
#include "knead/field.h"
#include "knead/vec.h"

namespace knead {

// The dependence of a segment's fields on its time t in [0, 1]:
//   swept:   they move with the tool's frame, c(t) = c + t displacement (and a half-space may turn);
//   blended: v(x, t) = (1 - t) v_c(x) + t v_{c + displacement}(x), two fixed fields (paper, Eq. 9);
//   pinned:  each field is a pin, which moves by a displacement u of its own, the velocity of its motion: it is at
//            q(t) = c + t u, and v(q(t), t) = u for every pin (method, section 9). v is the sum of the fields with
//            velocities a(t) in place of u that satisfy these equations.
enum class TimeLaw { swept, blended, pinned };

// A limit cylinder: the segment moves only points that are within `radius` of the line {center + s axis} at t = 0.
struct LimitCylinder {
  Vec3d center;
  Vec3d axis;  // a unit vector
  double radius = 0;

  friend bool operator==(const LimitCylinder&, const LimitCylinder&) = default;
};

// A pin at which the shape turns like a rigid body: the Jacobian of the flow at the pin is the rotation by t |rate|
// about the direction of `rate`; the identity for a rate of 0.
struct PinTurn {
  std::uint32_t pin = 0;  // the number of its field
  Vec3d rate{0, 0, 0};    // radians per unit time

  friend bool operator==(const PinTurn&, const PinTurn&) = default;
};

// A node of the splines of a curve, by the length along the curve at t = 0.
struct CurveNode {
  std::array<double, 2> rest{};  // curvature vector at t = 0, in the curve's frame
  std::array<double, 2> bent{};  // curvature vector at t = 1; per unit of length at t = 0, as all values here
  double twist = 0;              // radians per length by which the surroundings turn about the curve
  double stretch = 0;            // growth of a unit of length; above -1

  friend bool operator==(const CurveNode&, const CurveNode&) = default;
};

// A curve that becomes another curve. Its surroundings follow, and keep their volume exactly, or their thickness: a map
// in closed form (docs/mathematics.md, "Curves"). The values of the nodes are the coefficients of uniform cubic
// B-splines that are 0 at both ends: node i lies at (i + 2) spacing(). They change linearly from t = 0 to t = 1. The
// frame of the curve never turns about its tangent (rotation minimising); beyond both ends the curve is straight.
// A stretch e = 1 + `stretch` takes lengths along the curve to e times them, and both coordinates across to
// e^(-1/2) times them, or the second one alone to 1 / e times it.
struct CurveMotion {
  double length = 0;            // of the curve at t = 0, above 0
  SharedList<CurveNode> nodes;  // at least 1
  int anchor = 0;               // the next four values belong to the place at this multiple of spacing() on the curve
  Vec3d place;                  // position at t = 0
  Vec3d shift{0, 0, 0};         // displacement until t = 1
  Mat3d frame{};                // rows: tangent and two unit vectors across, right-handed, at t = 0
  Vec3d turn{0, 0, 0};          // the frame turns about this axis, by its length in radians, until t = 1
  std::optional<double> radius{};  // only points nearer to the curve move; else all
  // The interval of arc length, from the curve's start, around which the shape lies. The inverse map starts from the
  // nearest place in it. The interval may extend onto the straight lines beyond the ends.
  std::array<double, 2> part{-kInfinity, kInfinity};
  bool keeps_thickness = false;  // keeps distances across the curve, and changes the volume
  bool keeps_length = false;     // keeps lengths along the curve, and changes the volume
  bool one_across = false;       // only the second coordinate across the curve changes with the stretch
  double end_stretch = 0;        // the stretch at the last end and beyond it, where it is 0 for most curves

  // Returns whether there are no nodes, so that nothing moves.
  bool is_empty() const { return nodes.empty(); }
  // Returns the number of the splines' intervals.
  int intervals() const { return static_cast<int>(nodes.size()) + 3; }
  // Returns the length of an interval.
  double spacing() const { return length / intervals(); }

  friend bool operator==(const CurveMotion&, const CurveMotion&) = default;
};

// A box of control points: x -> x + t D(x) in the box, where D(x) is the sum over the control points of their
// displacements times N_i(u) N_j(v) N_k(w), and u, v, w from 0 to 1 are the coordinates of x along the box's edges. N
// are B-splines on equal intervals with all knots at the ends, so that the outermost control points lie on the box;
// with the greatest degree they are Bernstein's polynomials. Outside the box nothing moves. The map is C1 across a face
// whose two outer layers of control points rest; through any other face no shape should reach.
struct LatticeMotion {
  static constexpr int kMaxDegree = 15;
  static constexpr int kMaxCount = 64;

  Vec3d origin{0, 0, 0};         // the corner with control point (0, 0, 0)
  Mat3d axes{};                  // rows: unit vectors along the edges, at right angles
  Vec3d lengths{1, 1, 1};        // of the edges, above 0
  std::array<int, 3> counts{};   // of control points along the edges, 2 to kMaxCount
  std::array<int, 3> degrees{};  // of N along them: at least 1, at most kMaxDegree and the count less 1
  SharedVectors displacements;   // of control point (i, j, k): number k + counts[2] (j + counts[1] i)

  // Returns whether there are no displacements, so that nothing moves.
  bool is_empty() const { return displacements.empty(); }

  friend bool operator==(const LatticeMotion&, const LatticeMotion&) = default;
};

inline constexpr std::size_t kMaxParts = 8;  // of a sum

// The sum of one or more fields over one unit of time, or v of a grid instead. Path lines run from t = begin to t =
// end, both in [0, 1]: from 0 to 1 is the whole segment, from 1 to 0 its inverse, from 0 to 0.5 its first half.
struct Segment {
  std::vector<Field> fields;
  Vec3d displacement{0, 0, 0};
  TimeLaw time_law = TimeLaw::swept;
  std::optional<LimitCylinder> limit_cylinder;
  Mask mask;  // of all fields
  double begin = 0;
  double end = 1;
  PotentialGrid grid{};          // not empty: there are no fields, no displacement, no limit cylinder and no turns
  CurveMotion curve{};           // not empty: the same, and no grid; the mask must hold no point that it moves
  LatticeMotion lattice{};       // not empty: the same, and no curve
  std::vector<PinTurn> turns{};  // of a pinned segment, by ascending pin; other pins prescribe no rotation
  // Not empty: v is the sum of the velocities of these 2 to kMaxParts segments, which act at the same time, such as a
  // stroke and its mirror images. The sum itself has only the mask, `begin` and `end`, which all parts share. A limit
  // cylinder limits its part alone. A part is neither pinned nor a sum.
  std::vector<Segment> parts{};
  // Set if the parts of a sum, or the pins, are each other's mirror images in the plane {x[axis] = *mirrored_at[axis]}:
  // points of the plane stay in it exactly.
  std::array<std::optional<double>, 3> mirrored_at{};

  friend bool operator==(const Segment&, const Segment&) = default;
};

// Returns whether a segment changes volumes on purpose: its grid, or that of a part, has `growth`.
bool changes_volume(const Segment& segment);

// Returns the displacement of a field of the segment in one unit of time.
Vec3d displacement_of(const Segment& segment, const Field& field);

// Segments, applied one after the other.
struct Flow {
  std::vector<Segment> segments;

  friend bool operator==(const Flow&, const Flow&) = default;
};

// Returns the flow with the mask on all of its segments. Where the mask meets the support of a field, a constant is
// subtracted from the field's vector potential, so that little flows along the mask's border (docs/mathematics.md). The
// constant does not depend on `begin` and `end`.
Flow masked(Flow flow, const Mask& mask);

// Returns the flow that moves every point back.
Flow inverse(const Flow& flow);

// Returns the first `segments` segments of the flow, 0 <= segments <= flow.segments.size(). A fraction ends within a
// segment.
Flow prefix(const Flow& flow, double segments);

// Returns the flow from one moment to another, both in segments from the beginning and within the flow; backwards if
// to < from. Throws InvalidInput for a moment outside the flow.
Flow flow_between(const Flow& flow, double from, double to);

// Throws InvalidInput, naming the segment, if
//   - a number is not finite, or inner >= outer,
//   - an axis is not of unit length, or a strain not traceless,
//   - a point set is empty, or its exponent not an even number of at least 2,
//   - a blended segment is anything but the translation of a ball or capsule,
//   - a pinned segment is anything but translations of balls with inner = 0, falloff kPinFalloff and the same outer,
//     or has a displacement or limit cylinder,
//   - a grid's spacing is not above 0, its counts are not those of its coefficients, or there are fields, a
//     displacement, a limit cylinder or turns besides,
//   - a curve's length is not above 0, its stretch not above -1, its frame not of unit vectors at right angles, its
//     anchor beyond its ends, or there is a field, a grid, a displacement, a limit cylinder or turns besides,
//   - a lattice's edges are not above 0 and at right angles, its counts or degrees out of range or not those of its
//     displacements, or there is anything of these besides,
//   - a turn names no pin, or the turns are not in ascending order of their pins,
//   - a sum has 1 part, or more than kMaxParts, or a field of its own, or a part that is pinned, a curve, a lattice, a
//     sum, masked or cut,
//   - begin or end lies outside [0, 1].
void validate(const Flow& flow);

// Explicit Runge-Kutta methods with an error estimate.
enum class Integrator {
  rk4,       // the paper's: classical RK4 with step doubling, local extrapolation off
  tsitouras  // 5(4), Tsitouras 2011
};

// Returns the method with this name: rk4 or runge-kutta, tsit5 or tsitouras. Nothing for another name.
std::optional<Integrator> integrator_named(std::string_view name);

// The coefficients of a method: k_i = f(t + c_i h, x + h sum_j a_ij k_j); the step is h sum_i b_i k_i and the estimate
// of its error h sum_i e_i k_i.
struct Tableau {
  static constexpr int kMaxStages = 11;

  int stages = 0;
  int order = 0;        // of the solution with which the integration continues
  int error_order = 0;  // the estimate is O(h^(error_order + 1))
  bool first_same_as_last = false;
  std::array<double, kMaxStages> c{};
  std::array<std::array<double, kMaxStages>, kMaxStages> a{};
  std::array<double, kMaxStages> b{};
  std::array<double, kMaxStages> e{};
};

// Returns the coefficients of a method.
const Tableau& tableau(Integrator integrator);

namespace detail {
class BlockMover;
}

// Throws InvalidInput with the number of the first point that has a coordinate that is not finite.
void require_finite(std::span<const Vec3d> points);

// Points in blocks of 64 neighbours, and groups of 64 blocks, for points that are moved many times: a group or block
// that a tool does not reach costs one test of its box. Points keep their numbers. Stores the boxes, and copies of the
// points of groups that have been moved.
class PointBlocks {
 public:
  // The order of points in blocks:
  //   sorted: along a space-filling curve, which takes about 30 ns a point;
  //   given:  in the given order, for points whose neighbours follow each other.
  enum class Order { sorted, given };

  // Throws InvalidInput, with the number of the point, for a coordinate that is not finite.
  explicit PointBlocks(std::span<const Vec3d> points, Order order = Order::sorted);

  // Returns the number of points.
  std::size_t size() const { return size_; }

  // Copies the points that have moved since the last call to their places in the array of the constructor.
  void update(std::span<Vec3d> points);

  // Returns the accepted steps of each point's path line since construction.
  std::vector<std::uint32_t> steps() const;

 private:
  friend class detail::BlockMover;

  // A box of points when it was last computed.
  struct Bounds {
    Vec3d center{};
    Vec3d half{};              // extents
    double slack = 0;          // a bound of the motion of its points along an axis since then
    bool has_changed = false;  // since the last call of update
  };

  // The points of a group in its order; empty before it is moved for the first time.
  struct Copies {
    std::vector<double> numbers;  // x of all points, y of all, z of all
    std::vector<std::uint32_t> steps;
  };

  std::size_t original(std::size_t i) const { return order_.empty() ? i : order_[i]; }
  void sort(std::span<const Vec3d> points);
  void copy_group(std::size_t group, std::span<const Vec3d> points);
  void fit_block(std::size_t block);
  void fit_group(std::size_t group);

  std::size_t size_ = 0;
  std::vector<std::uint32_t> order_;  // the points' numbers in the order of the blocks; empty: 0, 1, 2...
  std::vector<Copies> copies_;        // by group
  std::vector<Bounds> blocks_;
  std::vector<Bounds> groups_;
};

// Finds out whether a flow may move a ball of space. Keeps a copy of the flow. A call costs a distance for each field
// of each segment.
class FlowSupport {
 public:
  explicit FlowSupport(const Flow& flow);
  FlowSupport(const FlowSupport&) = delete;
  FlowSupport& operator=(const FlowSupport&) = delete;
  ~FlowSupport();
  FlowSupport(FlowSupport&&) noexcept;
  FlowSupport& operator=(FlowSupport&&) noexcept;

  // Returns false only if every point of the ball keeps its bits; radius >= 0. May return true for a ball that a tool
  // passes closely.
  bool may_move(const Vec3d& center, double radius) const;

  // Returns the size of the smallest part of a surface that the flow may move or bend: the least `outer` of balls,
  // capsules and point sets, the least bump of wide balls, and the least width of the intermediate regions of
  // half-spaces. Infinity without these.
  double smallest_feature() const;

  // Returns the same for the parts of the flow that may move a point of the ball.
  double smallest_feature(const Vec3d& center, double radius) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

// The scalar in which fields are evaluated. Positions are double in both cases: fields are evaluated relative to the
// tool's centre, and the displacement is added.
enum class Precision { float32, float64 };

// The default of all tolerances relative to the shape's size.
inline constexpr double kDefaultRelativeTolerance = 1e-5;

// Returns relative_tolerance * diagonal, a length for AdvectOptions::tolerance. `diagonal` is that of the shape's
// bounding box. Throws InvalidInput unless relative_tolerance is a finite number above 0 and the product a finite
// length above 0.
double absolute_tolerance(double relative_tolerance, double diagonal);

// Options of advect().
struct AdvectOptions {
  // Position error of one path line over one segment: a length above 0, which depends on the shape's size and so has no
  // default. absolute_tolerance() gives one.
  double tolerance = 0;
  Integrator integrator = Integrator::tsitouras;
  Precision precision = Precision::float32;
  int threads = 0;  // 0: as many as the machine has
  Progress* progress = nullptr;
  std::span<std::uint32_t> steps{};  // empty, or one number for each point; advect() adds the accepted steps
};

// Throws InvalidInput unless `tolerance` is a finite length above 0, and `steps` empty or of one number for each point.
void validate(const AdvectOptions& options, std::size_t points);

// How advect() ended.
enum class AdvectStatus { done, cancelled, step_limit };

// How advect() ended, and its work over all path lines.
struct AdvectResult {
  AdvectStatus status = AdvectStatus::done;
  std::uint64_t accepted_steps = 0;
  std::uint64_t rejected_steps = 0;
  std::uint64_t evaluations = 0;  // of v

  AdvectResult& operator+=(const AdvectResult& other);
};

// Moves every point along its path line from the flow's beginning to its end, in place. The bits of a result depend on
// its point alone: not on the other points, the number of threads or the instruction set. A point that no tool reaches
// keeps its bits. Cost: a few ns for each evaluation of a field; a point that no tool reaches costs a distance. Throws
// InvalidInput where validate(flow) or validate(options) does, and with its number for a point that is not finite.
// Leaves the points as they were if the status is `cancelled`, or `step_limit`: a path line needed over a million
// steps, for example because it runs to infinity far out in the slab of a bend, or a point is farther from a curve than
// half the curve's radius of curvature, where its map is not defined.
AdvectResult advect(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options);

// Does the same for points that are moved many times: a group of 4096 points that a tool does not reach costs one test.
// `points`: the array of the blocks' constructor, changed only by update(); it is read when the flow first reaches a
// group. The blocks' points are part-way unless the status is `done`. Throws InvalidInput if the number of points
// differs from that of the blocks.
AdvectResult advect(const Flow& flow, PointBlocks& blocks, std::span<const Vec3d> points, const AdvectOptions& options);

// Returns v at each of the points at a time of the flow, in segments from its beginning: 1.25 is a quarter into the
// second segment. Partial and inverse segments also take one unit of time. Ignores limit cylinders, because these
// depend on the beginning of path lines. Throws InvalidInput where validate(flow) does, for a time that is not from 0
// to the number of segments, and for a custom motion or region.
std::vector<Vec3d> velocities(const Flow& flow, std::span<const Vec3d> points, double time);

// Returns the Jacobian at each of the points of the map that advect() applies: row i holds the derivatives of
// coordinate i. Integrates dJ/dt = grad v J along the path lines in double, in the steps that the tolerance of
// `options` asks for, several points at a time where advect() does so. The bits of a result depend on its point alone.
// Throws as velocities() and advect(), and Cancelled.
std::vector<Mat3d> jacobians(const Flow& flow, std::span<const Vec3d> points, const AdvectOptions& options);

// Moves points as advect(flow, points, options) does, for example on a GPU (knead/editor/gpu.h). Points that no tool
// reaches keep their bits; the others agree with advect up to the tolerance, not bit for bit. An empty function stands
// for advect.
using Backend = std::function<AdvectResult(const Flow& flow, std::span<Vec3d> points, const AdvectOptions& options)>;

// Returns the instruction set that advect() uses, "scalar", "avx2", "avx512", "neon" or "wasm": the one that the
// environment variable KNEAD_SIMD names, otherwise the widest of this machine. All give the same bits.
// Throws InvalidInput if KNEAD_SIMD names an instruction set that is unknown or that the machine does not have.
const char* simd_name();

}  // namespace knead
