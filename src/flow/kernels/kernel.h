// The inner loops of advect: path lines of one field, side by side, for the instruction set of the machine. The kernels
// are written once (kernel_*.h), as templates over the type of a pack of numbers, and compiled for every instruction
// set. A path line's bits depend neither on that nor on its neighbours.
#pragma once

#include <cstddef>
#include <cstdint>

#include "field/grid.h"
#include "field/mask_grid.h"
#include "flow/varying.h"
#include "knead/field.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// Points are kept and moved in blocks, and blocks in groups.
inline constexpr std::size_t kBlock = 64;
inline constexpr std::size_t kBlocksPerGroup = 64;
inline constexpr std::size_t kGroup = kBlock * kBlocksPerGroup;
// The number of path lines that are integrated side by side: their numbers fit into the fastest cache, and there are
// enough of them to hide latencies.
inline constexpr std::size_t kBundle = 128;

// The coordinates of points, as three arrays.
struct Coordinates {
  double* x = nullptr;
  double* y = nullptr;
  double* z = nullptr;
};

template <class S>
using Lanes3 = S[3][kBundle];

// Some of the lanes of a bundle. Inlined everywhere: kernels are compiled for several instruction sets.
class LaneSet {
 public:
  [[gnu::always_inline]] inline void clear() { words_[0] = words_[1] = 0; }

  // Adds lanes from `first` on, one for each bit; bits of lanes in one pack.
  [[gnu::always_inline]] inline void add(std::size_t first, std::uint64_t bits) {
    words_[first / 64] |= bits << first % 64;
  }
  [[gnu::always_inline]] inline void fill(std::size_t count) {
    words_[0] = count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    words_[1] = count >= 128 ? ~std::uint64_t{0} : count <= 64 ? 0 : (std::uint64_t{1} << (count - 64)) - 1;
  }
  [[gnu::always_inline]] inline bool has(std::size_t lane) const { return (words_[lane / 64] >> lane % 64 & 1) != 0; }
  // Returns the bits of lanes in one pack, the first lane's lowest.
  [[gnu::always_inline]] inline std::uint32_t bits(std::size_t first, std::size_t count) const {
    return static_cast<std::uint32_t>(words_[first / 64] >> first % 64 & ((std::uint64_t{1} << count) - 1));
  }
  [[gnu::always_inline]] inline int count() const {
    return __builtin_popcountll(words_[0]) + __builtin_popcountll(words_[1]);
  }
  // Writes the set's lanes in order, or those below `count` that are not in it; returns how many.
  [[gnu::always_inline]] inline std::size_t list(std::uint16_t* lanes) const {
    return list(words_[0], words_[1], lanes);
  }
  [[gnu::always_inline]] inline std::size_t list_others(std::size_t count, std::uint16_t* lanes) const {
    LaneSet all;
    all.fill(count);
    return list(all.words_[0] & ~words_[0], all.words_[1] & ~words_[1], lanes);
  }

 private:
  [[gnu::always_inline]] inline static std::size_t list(std::uint64_t low, std::uint64_t high, std::uint16_t* lanes) {
    std::size_t count = 0;
    for (; low != 0; low &= low - 1) lanes[count++] = static_cast<std::uint16_t>(__builtin_ctzll(low));
    for (; high != 0; high &= high - 1) lanes[count++] = static_cast<std::uint16_t>(64 + __builtin_ctzll(high));
    return count;
  }

  static_assert(kBundle == 128);
  std::uint64_t words_[2] = {0, 0};
};

// The beginning of a lane kernel's path line, and the cell in which it is now.
struct Origin {
  Vec3d x0;
  const void* cell = nullptr;
};

// Consecutive path lines of a bundle that are consecutive points of a group's block.
struct Piece {
  std::uint16_t lane = 0;
  std::uint16_t point = 0;
  std::uint16_t count = 0;
};

// Path lines side by side. Their state is the displacement since the beginning, so that rounding is relative to a
// point's displacement. Positions are relative to the field's centre at t = 0.
template <class S>
struct alignas(64) Bundle {
  Lanes3<S> base{};   // x0 - c
  Lanes3<S> moved{};  // since t = begin
  Lanes3<S> k[Tableau::kMaxStages]{};
  S t[kBundle]{};
  S h[kBundle]{};  // the step, negative backwards in time
  S trial[kBundle]{};
  S shortest[kBundle]{};
  S steps[kBundle]{};                  // accepted
  Lanes3<S> result{};                  // of all path lines that the bundle began with
  S result_steps[kBundle]{};           // of the same
  std::uint16_t slot[kBundle]{};       // the place of a path line's result
  std::uint8_t at_contact[kBundle]{};  // the tool is just arriving, so v is 0
  Piece pieces[kBundle]{};
  int piece_count = 0;
  int count = 0;
  LaneSet asked;  // the lanes whose slopes are needed
  // Of lane kernels.
  Origin origins[kBundle]{};
  S width[kBundle]{};       // that some fields find at k_0
  S last_width[kBundle]{};  // and at the last other slope
  Bundle* own = nullptr;    // of sums: for the evaluation of each part
};

// A stage of a step: v at t + c h and base + moved + h sum_j weights_j k_(slopes_j) - t displacement, into k_out.
// from_start: moved is 0 and is not read.
template <class S>
struct Stage {
  S weights[Tableau::kMaxStages]{};
  std::uint8_t slopes[Tableau::kMaxStages]{};
  int count = 0;
  S c{0};
  int out = 0;
  bool from_start = false;
};

// A block of points at the beginning of a segment, to be classified.
struct BlockTask {
  Coordinates points;         // kBlock of each
  std::uint64_t members = 0;  // the points to classify
  double* start = nullptr;    // kBlock
  bool moves = true;          // whether classify moves points whose motion is known in closed form
};

// Points whose path lines are to be integrated: from the segment's beginning, or from the time in BlockTask::start. All
// other members have been moved already, or rest.
struct Classified {
  std::uint64_t inside = 0;
  std::uint64_t later = 0;
  std::uint64_t pending = 0;  // to be decided one by one
  double moved = 0;           // the greatest motion of a moved point along an axis
};

// The limits of the steps of a bundle's path lines at their places.
template <class S>
struct StepLimits {
  S speed[kBundle];  // at which r may change apart from the point's motion relative to the tool, such as by turning
  S reach[kBundle];  // the length > 0 that a step may pass
  S time[kBundle];   // the longest step
};

// The functions for one kind of field. Pack kernels evaluate the lanes of a bundle in packs; `field` is a KernelField
// of that kind. Lane kernels (lane_kernel.cpp) evaluate them one by one.
template <class S>
struct FieldKernel {
  // Evaluates v at least for the asked lanes.
  void (*stage)(const void* field, Bundle<S>& bundle, const Stage<S>& stage) = nullptr;
  // Finds the limits that depend on the place. Null: none does. from_start: as in Stage.
  void (*limit)(const void* field, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) = nullptr;
  Classified (*classify)(const void* field, const BlockTask& task) = nullptr;
  // After a step: follows the path lines into other cells, and evaluates k_0 of those that have changed their cell.
  // Returns their number. Null: the field has no cells.
  int (*follow)(const void* field, Bundle<S>& bundle) = nullptr;
  bool by_lanes = false;
  bool limits_place = false;  // `limit` finds lengths and times too, not only speeds
};

// A segment's field with its numbers in the scalar of the evaluation, and in double for closed forms.
template <class S, template <class> class M, template <class> class R>
struct KernelField {
  using Plain = KernelField;

  M<S> motion;
  R<S> region;
  Thresholds<S> thresholds;
  Vec3<S> displacement;
  M<double> exact_motion;
  R<double> exact_region;
  Thresholds<double> exact_thresholds;
  Vec3d exact_displacement;
  Vec3d center;
  double begin = 0;
  double end = 1;
  Mat3d whole_strain;  // exp((end - begin) M) of a strain
};

// A field whose numbers depend on variables.
template <template <class> class M, template <class> class R>
struct RatedField {
  M<Varying> motion;
  R<Varying> region;
  Thresholds<Varying> thresholds;
  Vec3<Varying> displacement;
  Vec3<Varying> center;
  bool is_blended = false;
};

// The same under a mask.
template <class S, template <class> class M, template <class> class R>
struct MaskedKernelField : KernelField<S, M, R> {
  MaskView<S> mask;  // about the field's centre at t = 0
  Vec3<S> offset;    // of the potential
};

// A pin in double: its place relative to the field's centre at t = 0, and its displacement.
struct ExactPin {
  Vec3d place;
  Vec3d by;
  double speed = 0;  // |by|
};

// For each pin its place at t = 0, its displacement, and the coefficients of its kernel's strengths.
template <class S>
struct PinNumbers {
  const S* first = nullptr;
  int count = 0;
  int stride = 0;

  [[gnu::always_inline]] inline const S* operator[](int i) const {
    return first + static_cast<std::ptrdiff_t>(i) * stride;
  }
};

// Pins over a part of a segment's time; OwnedPins (pins.h) owns the numbers. Lengths are in units of the radius.
template <class S>
struct PinKernelField {
  PinNumbers<S> pins;   // powers of three numbers: the velocity
  PinNumbers<S> turns;  // of pins that also turn; of nine: the rate, and the strain's xx, yy, zz, xy, xz, yz
  const ExactPin* exact = nullptr;  // as many as pins
  int degree = 0;
  S per_radius{1};
  S middle{0.5};  // of the part of the time
  S per_half{2};  // 1 / half of its length
  MaskView<S> mask;
  Vec3d center;
  double radius = 1;
  double begin = 0;
  double end = 1;
};

// A potential grid, whose numbers are not owned. Positions are relative to the grid's middle node.
template <class S>
struct GridKernelField {
  GridView<S> grid;
  GridView<double> exact_grid;  // without its numbers
  MaskView<S> mask;
  Vec3d center;
  S end{1};  // of the segment
};

// A part of a sum, evaluated by its own kernel. Places are relative to the centre of the sum.
template <class S>
struct SumPart {
  FieldKernel<S> kernel;
  const void* field = nullptr;
  Vec3<S> center;  // the origin of the kernel's positions
  Vec3<S> tool_velocity;
  S tool_speed{0};
  S reach{0};                // the length that a step may pass
  bool finds_width = false;  // the stage finds the width, which `limit` reads
  // A bound of the support: a ball that moves along, or a half-space.
  bool in_space = false;
  Vec3<S> middle;  // of the ball; the normal of the half-space
  Vec3<S> by;
  S extent{0};  // the radius of the ball; the position of the half-space along its normal
};

inline constexpr int kMaxSummed = 8;  // kMaxParts of a segment

template <class S>
struct SumKernelField {
  SumPart<S> parts[kMaxSummed];
  int count = 0;
};

// The points of a set, whose numbers are not owned.
template <class S>
struct SetPoints {
  const S* numbers = nullptr;  // x of all points, y of all, z of all
  int count = 0;
  int exponent = 8;
  S scale{1};  // the unit of distances
  // A ball that contains the support and moves along `path` with the tool; `middle` is relative to the field's centre
  // at the segment's beginning.
  Vec3d middle;
  double radius = 0;
  Vec3d path;
  double per_path2 = 0;  // 1 / |path|^2, or 0 if the tool rests
};

// A Runge-Kutta method in the scalar S.
template <class S>
struct Method {
  Stage<S> stages[Tableau::kMaxStages];
  Stage<S> slope;  // of the step, and of its error: weights only
  Stage<S> error;
  int stage_count = 0;
  int error_order = 0;
  bool extrapolates = false;  // the estimate has a lower order than the step
  bool first_same_as_last = false;
};

template <class S>
struct SegmentTask {
  FieldKernel<S> kernel;
  const void* field = nullptr;
  const Method<S>* method = nullptr;
  Vec3d center;
  Vec3d displacement;     // of the tool over the unit of time
  Vec3<S> tool_velocity;  // the same
  S tool_speed{0};
  S reach{0};           // the length > 0 that a step may pass; infinity if that depends on the place
  S tolerance{0};       // of a slope
  S expected_error{0};  // of a third-order step that passes `reach`, by the speed; in tolerances of a slope
  S begin{0};
  S end{1};
  bool carries = false;  // the inner region moves with the tool
  // Returns the earliest time from t on at which the resting point can be inside the support; over 1: never. `cell`:
  // that of Origin.
  double (*next_contact)(const void* contact_data, const Vec3d& x, double t, const void*& cell) = nullptr;
  const void* contact_data = nullptr;
};

// Called after every round of steps with the group's evaluations so far; tells whether to stop.
struct CancelCheck {
  bool (*ask)(const void* asked, std::uint64_t evaluations) = nullptr;  // null: never stops
  const void* asked = nullptr;
  std::uint64_t before = 0;  // evaluations of the group for earlier pieces of the segment

  [[gnu::always_inline]] inline bool is_stopped(std::uint64_t evaluations) const {
    return ask != nullptr && ask(asked, before + evaluations);
  }
};

// The live blocks of a group.
struct LiveGroup {
  Coordinates points;                      // kGroup of each
  const std::uint64_t* members = nullptr;  // by block: the lanes that hold points
  const std::uint16_t* blocks = nullptr;
  int block_count = 0;
  std::uint64_t between = 0;       // by block: all points are known to be in the intermediate region
  std::uint32_t* steps = nullptr;  // kGroup, to which accepted steps are added
  double* moved = nullptr;         // by block: raised to the greatest motion of a point along an axis
  CancelCheck stop;                // ends the integration, and leaves the counts incomplete
};

template <class S>
struct GroupTask : LiveGroup {
  Bundle<S>* bundle = nullptr;  // to work in
};

inline constexpr std::size_t kJacobianLanes = 16;  // path lines that are integrated side by side with their Jacobians

// For each lane x and J by rows, or v and grad v, or their rates; and as many vectors as variables: the derivatives of
// x, or of v at a resting place, with respect to these.
template <std::size_t variables>
inline constexpr std::size_t kJacobianNumbers = 12 + 3 * variables;
template <std::size_t variables>
struct alignas(64) JacobianBundle {
  double of[kJacobianNumbers<variables>][kJacobianLanes]{};
};

// Evaluates v and its derivatives at the vectors of `places`, at least in the asked lanes.
template <std::size_t variables>
using FindGradients = void (*)(const void* field, const JacobianBundle<variables>& places, const double* times,
                               std::uint32_t asked, JacobianBundle<variables>& slopes);

// A path line that begins at a point, at the time t.
struct JacobianStart {
  std::size_t point = 0;
  double t = 0;
};

// The sums of gradients with respect to a grid's coefficients: three planes in the order of GridView; if the
// coefficients change, three more of those at t = 1.
struct CoefficientSums {
  GridView<double> grid;
  MaskView<double> mask;
  Vec3d center;  // that positions in both are relative to
  double* planes = nullptr;
  std::ptrdiff_t plane = 0;
};

// The path lines of `starts` with their Jacobians, over the rest of the segment.
template <std::size_t variables>
struct JacobianTask {
  const SegmentTask<double>* segment = nullptr;  // without its kernel
  FindGradients<variables> find_gradients = nullptr;
  const void* field = nullptr;
  double longest_step = 0;
  double turning = 0;  // the radians by which the regions turn about turning_center
  Vec3d turning_center;
  const JacobianStart* starts = nullptr;
  std::size_t count = 0;
  Vec3d* points = nullptr;
  Mat3d* jacobians = nullptr;
  Vec3d* gradients = nullptr;  // in the place of Jacobians: of a function of each point
  CoefficientSums sums;        // to which the gradient of its functions is added
  Vec3d* tangents = nullptr;   // tangents_of_point for each point, of which at most `variables` are used
  std::size_t tangents_of_point = 0;
  double jacobian_tolerance = 0;             // of the error of a Jacobian; 0: the error of the point alone counts
  double tangent_rounding[variables + 1]{};  // of each variable: the error of its tangent that does not count
  // Returns the part of a step, of its beginning, middle and end, before the first place beyond which the second
  // derivatives of v jump; 1 if there is none. Null: steps pass over them.
  double (*part_before_kink)(const void* kinks, const Vec3d (&places)[3], double t, double end) = nullptr;
  const void* kinks = nullptr;
  CancelCheck stop;
};

struct GroupCounts {
  std::uint64_t accepted = 0;
  std::uint64_t rejected = 0;
  std::uint64_t evaluations = 0;
  bool complete = true;

  GroupCounts& operator+=(const GroupCounts& other) {
    accepted += other.accepted;
    rejected += other.rejected;
    evaluations += other.evaluations;
    complete = complete && other.complete;
    return *this;
  }
};

// In the order of the variants Motion and Region.
enum MotionKind { kTranslation, kRotation, kTwist, kStrain, kMotionKinds };
enum RegionKind { kBall, kCapsule, kHalfSpace, kSet, kRegionKinds };

template <class S>
struct Kernels {
  FieldKernel<S> fields[kMotionKinds][kRegionKinds];
  FieldKernel<S> masked[kMotionKinds][kRegionKinds];  // of a MaskedKernelField
  FieldKernel<S> pins;                                // of a PinKernelField
  FieldKernel<S> masked_pins;
  FieldKernel<S> grid;  // of a GridKernelField
  FieldKernel<S> masked_grid;
  FieldKernel<S> sum;  // of a SumKernelField; without `classify`
  GroupCounts (*move)(const SegmentTask<S>& segment, const GroupTask<S>& group) = nullptr;
};

// `fields`: of a KernelField in double without variables, of a RatedField with them, which no set has.
template <std::size_t variables>
struct JacobianKernels {
  FindGradients<variables> fields[kMotionKinds][kRegionKinds]{};
  FindGradients<variables> grid = nullptr;                      // of a GridKernelField in double; without variables
  bool (*move)(const JacobianTask<variables>& task) = nullptr;  // returns false if a path line needs too many steps
  // The same with gradients, dg/dt = -g grad v; without variables. The integral of g dv/dcoefficient is taken from the
  // sums: the segment leads from the end, where the gradients are given, to the beginning.
  bool (*carry_back)(const JacobianTask<variables>& task) = nullptr;
};

// The kernels of one instruction set.
struct KernelTable {
  const char* name = nullptr;
  Kernels<float> in_float;
  Kernels<double> in_double;
  JacobianKernels<0> jacobians;
  JacobianKernels<1> tangents;
  JacobianKernels<kTangents> several_tangents;

  template <class S>
  const Kernels<S>& in() const {
    if constexpr (sizeof(S) == sizeof(float)) {
      return in_float;
    } else {
      return in_double;
    }
  }
};

KernelTable scalar_kernels();
KernelTable avx2_kernels();
KernelTable avx512_kernels();
KernelTable neon_kernels();
KernelTable wasm_kernels();

// Returns the kernels that simd_name() names. Reads the environment at every call, so that tests can compare kernels.
const KernelTable& kernels_in_use();

}  // namespace knead::detail
