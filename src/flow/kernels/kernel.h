// The inner loops of advect: path lines of one field, side by side, for the instruction set of the machine.  The
// functions that this header declares are written once (kernel_*.h), as templates over the type of a pack of numbers,
// and compiled for every instruction set; a path line's bits depend neither on that nor on its neighbours.
#pragma once

#include <cstddef>
#include <cstdint>

#include "field/grid.h"
#include "field/mask_grid.h"
#include "knead/field.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::detail {

// Points are kept and moved in blocks, and blocks in groups.
inline constexpr std::size_t kBlock = 64;
inline constexpr std::size_t kBlocksPerGroup = 64;
inline constexpr std::size_t kGroup = kBlock * kBlocksPerGroup;
// So many path lines are integrated side by side: their numbers stay in the fastest cache, and there are enough of them
// that one's latency is filled with the others' work.
inline constexpr std::size_t kBundle = 128;

// One coordinate after the other, so that neighbours lie side by side.
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

// Where a path line of a lane kernel begins, and what the field has found out about where it is now.
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

// Path lines side by side. Their state is the displacement since the beginning, so that rounding is relative to how far
// a point has moved; positions are relative to the field's centre at t = 0.
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
  S result_steps[kBundle]{};           // theirs
  std::uint16_t slot[kBundle]{};       // where a path line's result belongs
  std::uint8_t at_contact[kBundle]{};  // v is known to be 0 there, at the moment when the tool arrives
  Piece pieces[kBundle]{};
  int piece_count = 0;
  int count = 0;
  LaneSet asked;  // the lanes whose slopes are of interest
  // Of lane kernels.
  Origin origins[kBundle]{};
  S width[kBundle]{};       // which some fields find where k_0 is
  S last_width[kBundle]{};  // and where the last other slope is
  Bundle* own = nullptr;    // of sums: where each part is evaluated
};

// v at t + c h and base + moved + h sum_j weights_j k_(slopes_j) - t displacement, into k_out. From the start: moved is
// 0 and not looked at.
template <class S>
struct Stage {
  S weights[Tableau::kMaxStages]{};
  std::uint8_t slopes[Tableau::kMaxStages]{};
  int count = 0;
  S c{0};
  int out = 0;
  bool from_start = false;
};

// What a segment asks of a block of points at its beginning.
struct BlockTask {
  Coordinates points;         // kBlock of each
  std::uint64_t members = 0;  // which of them the segment is about
  double* start = nullptr;    // kBlock
  bool moves = true;          // those whose motion is known in closed form; else none is
};

// Points whose path lines are to be integrated: from the segment's beginning, or from the time in BlockTask::start. All
// other members have been moved already, or rest.
struct Classified {
  std::uint64_t inside = 0;
  std::uint64_t later = 0;
  std::uint64_t pending = 0;  // to be asked for one by one
  double moved = 0;           // how far one of those moved has come along an axis, at most
};

// What limits the steps of a bundle's path lines where they are.
template <class S>
struct StepLimits {
  S speed[kBundle];  // at which r may change besides that of the point relative to the tool, by turning for example
  S reach[kBundle];  // how far a step may pass, a length > 0
  S time[kBundle];   // how long a step may be
};

// The functions for one kind of field. Pack kernels evaluate the lanes of a bundle in packs; `field` is a KernelField
// of that kind. Lane kernels (lane_kernel.h) evaluate them one by one.
template <class S>
struct FieldKernel {
  // Evaluates v for the lanes that are asked for, at least.
  void (*stage)(const void* field, Bundle<S>& bundle, const Stage<S>& stage) = nullptr;
  // Raises the numbers that depend on the place above what they are everywhere. Null: none does. From the start: as
  // Stage has it.
  void (*limit)(const void* field, const Bundle<S>& bundle, bool from_start, StepLimits<S>& limits) = nullptr;
  Classified (*classify)(const void* field, const BlockTask& task) = nullptr;
  // After a step: follows the path lines into other cells, and evaluates k_0 anew where that makes a difference.
  // Returns for how many. Null: the field has no cells.
  int (*follow)(const void* field, Bundle<S>& bundle) = nullptr;
  bool by_lanes = false;
  bool limits_place = false;  // `limit` gives lengths and times too, not speeds alone
};

// A segment's field with its numbers in the scalar of the evaluation, and in double for what is known exactly.
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

// The same under a mask.
template <class S, template <class> class M, template <class> class R>
struct MaskedKernelField : KernelField<S, M, R> {
  MaskView<S> mask;  // about the field's centre at t = 0
  Vec3<S> offset;    // of the potential
};

// A pin for what is known exactly: its place relative to the field's centre at t = 0, and its displacement.
struct ExactPin {
  Vec3d place;
  Vec3d by;
  double speed = 0;  // |by|
};

// Of each pin its place at t = 0, its displacement, and the powers of what its kernel is multiplied with.
template <class S>
struct PinNumbers {
  const S* first = nullptr;
  int count = 0;
  int stride = 0;

  [[gnu::always_inline]] inline const S* operator[](int i) const {
    return first + static_cast<std::ptrdiff_t>(i) * stride;
  }
};

// Pins over a part of a segment's time (pins.h), owned by whoever made the field. Lengths are in units of the radius.
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

// A potential grid, owned by whoever made the field. Positions are relative to the grid's middle node.
template <class S>
struct GridKernelField {
  GridView<S> grid;
  GridView<double> exact_grid;  // without its numbers
  MaskView<S> mask;
  Vec3d center;
  S end{1};  // of the segment
};

// A part of a sum, evaluated by the kernel that it has alone. Places are relative to the centre of the sum.
template <class S>
struct SumPart {
  FieldKernel<S> kernel;
  const void* field = nullptr;
  Vec3<S> center;  // what the kernel's positions are relative to
  Vec3<S> tool_velocity;
  S tool_speed{0};
  S reach{0};                 // how far a step may pass
  bool leaves_width = false;  // the stage leaves the width to the limits
  // Beyond it v is exactly 0: a ball that moves along, or a half-space.
  bool in_space = false;
  Vec3<S> middle;  // of the ball; the normal of the half-space
  Vec3<S> by;
  S extent{0};  // the radius; of the half-space how far along its normal it goes
};

// At most so many parts, kMaxParts of a segment.
inline constexpr int kMaxSummed = 8;

template <class S>
struct SumKernelField {
  SumPart<S> parts[kMaxSummed];
  int count = 0;
};

// The points of a set, one coordinate after the other, owned by whoever made the field.
template <class S>
struct SetPoints {
  const S* numbers = nullptr;  // x of all points, y of all, z of all
  int count = 0;
  int exponent = 8;
  S scale{1};  // what distances are measured by
  // The ball around `middle`, relative to the field's centre at the segment's beginning, with the radius `reach` that
  // follows the tool passes over every resting point that the support reaches.
  Vec3d middle;
  double reach = 0;
  Vec3d path;
  double per_path2 = 0;  // 1 / |path|^2, or 0 where the tool rests
};

// How a method steps, in the scalar S.
template <class S>
struct Method {
  Stage<S> stages[Tableau::kMaxStages];
  Stage<S> slope;  // of the step, and of its error: weights only
  Stage<S> error;
  int stage_count = 0;
  int error_order = 0;
  bool extrapolates = false;  // whether the estimate is that of a lower order than the step's
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
  S reach{0};           // how far a step may pass, a length > 0; infinity where that depends on the place
  S tolerance{0};       // of a slope
  S expected_error{0};  // of the third order, by the speed, of a step that passes the reach; in tolerances of a slope
  S begin{0};
  S end{1};
  bool carries = false;  // whether the inner region moves with the tool
  // The earliest time from t on at which the resting point can be inside the support; over 1: never. `cell`: as Origin.
  double (*next_contact)(const void* contact_data, const Vec3d& x, double t, const void*& cell) = nullptr;
  const void* contact_data = nullptr;
};

// Asked after every round of steps: whether the result is no longer wanted after so many evaluations of the group.
struct CancelCheck {
  bool (*ask)(const void* asked, std::uint64_t evaluations) = nullptr;  // null: it is wanted
  const void* asked = nullptr;
  std::uint64_t before = 0;  // evaluations of the group for earlier pieces of the segment

  [[gnu::always_inline]] inline bool is_stopped(std::uint64_t evaluations) const {
    return ask != nullptr && ask(asked, before + evaluations);
  }
};

template <class S>
struct GroupTask {
  Coordinates points;                      // kGroup of each
  const std::uint64_t* members = nullptr;  // by block
  const std::uint16_t* blocks = nullptr;   // the live ones
  int block_count = 0;
  std::uint64_t between = 0;       // by block: whether all points are known to be between the inner and outer region
  std::uint32_t* steps = nullptr;  // kGroup, to which accepted steps are added
  double* moved = nullptr;         // by block: raised to how far a point of it moves along an axis, at most
  Bundle<S>* bundle = nullptr;     // to work in
  CancelCheck stop;                // the path lines under way are given up then, and the counts are not complete
};

// So many path lines are integrated side by side with their Jacobians.
inline constexpr std::size_t kJacobianLanes = 16;

// A vector and a matrix by rows for each of them: x and J, v and grad v, or their rates.
inline constexpr std::size_t kJacobianNumbers = 12;
struct alignas(64) JacobianBundle {
  double of[kJacobianNumbers][kJacobianLanes]{};
};

// Evaluates v and its gradient at the vectors of `places` in the lanes that are asked for, at least.
using FindGradients = void (*)(const void* field, const JacobianBundle& places, const double* times,
                               std::uint32_t asked, JacobianBundle& slopes);

// A path line that begins at a point, at the time t.
struct JacobianStart {
  std::size_t point = 0;
  double t = 0;
};

// The path lines of `starts` with their Jacobians, over the rest of the segment.
struct JacobianTask {
  const SegmentTask<double>* segment = nullptr;  // without its kernel
  FindGradients find_gradients = nullptr;
  const void* field = nullptr;
  double longest_step = 0;
  double turning = 0;  // by how many radians the regions turn about turning_center
  Vec3d turning_center;
  const JacobianStart* starts = nullptr;
  std::size_t count = 0;
  Vec3d* points = nullptr;
  Mat3d* jacobians = nullptr;
  CancelCheck stop;
};

struct GroupCounts {
  std::uint64_t accepted = 0;
  std::uint64_t rejected = 0;
  std::uint64_t evaluations = 0;
  bool complete = true;
};

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
  FieldKernel<S> sum;  // of a SumKernelField; without a function that classifies
  GroupCounts (*move)(const SegmentTask<S>& segment, const GroupTask<S>& group) = nullptr;
};

struct JacobianKernels {
  FindGradients fields[kMotionKinds][kRegionKinds]{};  // of a KernelField in double
  FindGradients grid = nullptr;                        // of a GridKernelField in double
  void (*move)(const JacobianTask& task) = nullptr;
};

// Of one instruction set.
struct KernelTable {
  const char* name = nullptr;
  Kernels<float> in_float;
  Kernels<double> in_double;
  JacobianKernels jacobians;

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

JacobianKernels scalar_jacobian_kernels();
JacobianKernels avx2_jacobian_kernels();
JacobianKernels avx512_jacobian_kernels();
JacobianKernels neon_jacobian_kernels();
JacobianKernels wasm_jacobian_kernels();

// The kernels that this machine runs.

// As simd_name says; asked for anew at every call, so that tests can compare them.
const KernelTable& kernels_in_use();

}  // namespace knead::detail
