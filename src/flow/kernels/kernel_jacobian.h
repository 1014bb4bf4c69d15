// Kernels of path lines with their Jacobians: dx/dt = v and dJ/dt = grad v J. Internal: part of the one source of all
// kernels.
#pragma once

#include "field/dual.h"
#include "flow/kernels/kernel_grid.h"
#include "flow/kernels/kernel_points.h"
#include "flow/kernels/kernel_stage.h"

namespace knead::detail {

// Loads three numbers of each lane of a pack: the vector, or from 3, 6 or 9 on a row of the matrix.
template <class P>
KNEAD_INLINE Vec3<P> load_three(const JacobianBundle& from, std::size_t first, std::size_t i) {
  return {P::load(from.of[first] + i), P::load(from.of[first + 1] + i), P::load(from.of[first + 2] + i)};
}

template <class P>
KNEAD_INLINE void store_three(const Vec3<P>& v, JacobianBundle& to, std::size_t first, std::size_t i) {
  v.x.store(to.of[first] + i);
  v.y.store(to.of[first + 1] + i);
  v.z.store(to.of[first + 2] + i);
}

// F: a KernelField in double.
template <class P, class F>
void find_gradients(const void* data, const JacobianBundle& places, const double* times, std::uint32_t asked,
                    JacobianBundle& slopes) {
  const F& field = *static_cast<const F*>(data);
  for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
    if ((asked >> i & lanes_in_use<P>(i, kJacobianLanes)) == 0) continue;
    const P t = P::load(times + i);
    const Vec3<P> from = load_three<P>(places, 0, i) - Vec3<P>(field.center);
    const Vec3<P> d = neg_mul_add(Vec3<P>(field.displacement), t, from);
    const Vec3<DualOf<P>> v = velocity(field.motion, field.region, field.thresholds, variables(d), DualOf<P>(t));
    store_three(values(v), slopes, 0, i);
    for (std::size_t row = 0; row < 3; ++row) store_three(v[row].g, slopes, 3 + 3 * row, i);
  }
}

template <class P>
void find_grid_gradients(const void* data, const JacobianBundle& places, const double* times, std::uint32_t asked,
                         JacobianBundle& slopes) {
  const auto& field = *static_cast<const GridKernelField<double>*>(data);
  const GridView<double>& grid = field.grid;
  for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
    const std::uint32_t lanes = asked >> i & lanes_in_use<P>(i, kJacobianLanes);
    if (lanes == 0) continue;
    const P t = P::load(times + i);
    const GridPlace<P> place = place_in(grid, load_three<P>(places, 0, i) - Vec3<P>(field.center));
    GridSlope<P> slope;
    for_each_cell(grid, place.cell, lanes, [&](std::ptrdiff_t node, const auto& here) {
      const GridSlope<P> sum = slope_in_cell(grid, node, place.within, t);
      slope.velocity = select(here, sum.velocity, slope.velocity);
      for (std::size_t row = 0; row < 3; ++row) slope.rows[row] = select(here, sum.rows[row], slope.rows[row]);
    });
    store_three(slope.velocity, slopes, 0, i);
    for (std::size_t row = 0; row < 3; ++row) store_three(slope.rows[row], slopes, 3 + 3 * row, i);
  }
}

template <class P>
class JacobianMover {
 public:
  explicit JacobianMover(const JacobianTask& task) : task_(task), segment_(*task.segment), method_(*segment_.method) {
    fill(t_, segment_.end, kJacobianLanes);
  }

  void run() {
    for (;;) {
      settle();
      if (busy_ == 0 || task_.stop.is_stopped(0)) return;
      begin(unknown_);
      for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) choose_step(i);
      for (int k = 1; k < method_.stage_count; ++k) evaluate(method_.stages[k], busy_, k_[k]);
      accepted_ = 0;
      for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) finish_step(i);
      if (!method_.first_same_as_last) begin(accepted_);
    }
  }

 private:
  static constexpr int kMaxSteps = 10'000;

  // Writes finished lanes back, and refills them with path lines that have not begun.
  void settle() {
    unknown_ = 0;
    for (std::size_t lane = 0; lane < kJacobianLanes; ++lane) {
      const std::uint32_t bit = std::uint32_t{1} << lane;
      if ((busy_ & bit) != 0) {
        if ((accepted_ & bit) == 0 || goes_on(lane)) continue;
        write_back(lane);
        busy_ &= ~bit;
        t_[lane] = segment_.end;
      }
      if (next_ < task_.count) start(lane);
    }
  }

  void start(std::size_t lane) {
    const JacobianStart& from = task_.starts[next_++];
    point_[lane] = from.point;
    const Vec3d& x = task_.points[from.point];
    const Mat3d& jacobian = task_.jacobians[from.point];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      state_.of[axis][lane] = x[axis];
      state_.of[3 + axis][lane] = jacobian.row0[axis];
      state_.of[6 + axis][lane] = jacobian.row1[axis];
      state_.of[9 + axis][lane] = jacobian.row2[axis];
    }
    t_[lane] = from.t;
    const double rest = segment_.end - from.t;
    trial_[lane] = rest < 0 ? -rest : rest;
    steps_[lane] = 0;
    busy_ |= std::uint32_t{1} << lane;
    unknown_ |= std::uint32_t{1} << lane;
  }

  void write_back(std::size_t lane) const {
    Vec3d& x = task_.points[point_[lane]];
    Mat3d& jacobian = task_.jacobians[point_[lane]];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      x[axis] = state_.of[axis][lane];
      jacobian.row0[axis] = state_.of[3 + axis][lane];
      jacobian.row1[axis] = state_.of[6 + axis][lane];
      jacobian.row2[axis] = state_.of[9 + axis][lane];
    }
  }

  // Returns whether the path line continues after a step. A resting point waits until the tool meets it again.
  bool goes_on(std::size_t lane) {
    const double rest = segment_.end - t_[lane];
    if (!(segment_.end >= segment_.begin ? rest > 0 : rest < 0) || ++steps_[lane] == kMaxSteps) return false;
    if (k_[0].of[0][lane] != 0 || k_[0].of[1][lane] != 0 || k_[0].of[2][lane] != 0) return true;
    const void* cell = nullptr;
    const Vec3d x{state_.of[0][lane], state_.of[1][lane], state_.of[2][lane]};
    const double contact = segment_.next_contact(segment_.contact_data, x, t_[lane], cell);
    if (contact > 1) return false;
    t_[lane] = contact;
    unknown_ |= std::uint32_t{1} << lane;
    return true;
  }

  // Finds k_0 of these lanes.
  void begin(std::uint32_t lanes) {
    if (lanes == 0) return;
    JacobianBundle found;
    evaluate(Stage<double>{}, lanes, found);
    for (std::size_t lane = 0; lane < kJacobianLanes; ++lane) {
      if ((lanes >> lane & 1) == 0) continue;
      for (std::size_t n = 0; n < kJacobianNumbers; ++n) k_[0].of[n][lane] = found.of[n][lane];
    }
  }

  // sum_j weights_j k_(slopes_j).
  KNEAD_INLINE P combine(const Stage<double>& stage, std::size_t number, std::size_t i) const {
    P sum = P::load(k_[stage.slopes[0]].of[number] + i) * P(stage.weights[0]);
    for (int j = 1; j < stage.count; ++j) {
      sum = mul_add(P::load(k_[stage.slopes[j]].of[number] + i), P(stage.weights[j]), sum);
    }
    return sum;
  }

  // Finds the rates of x and J in a stage.
  void evaluate(const Stage<double>& stage, std::uint32_t lanes, JacobianBundle& rates) {
    for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
      const P h = P::load(h_ + i);
      for (std::size_t n = 0; n < kJacobianNumbers; ++n) {
        const P from = P::load(state_.of[n] + i);
        (stage.count == 0 ? from : mul_add(combine(stage, n, i), h, from)).store(places_.of[n] + i);
      }
      const P t = P::load(t_ + i);
      (stage.count == 0 ? t : mul_add(h, P(stage.c), t)).store(times_ + i);
    }
    task_.find_gradients(task_.field, places_, times_, lanes, slopes_);
    for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
      store_three(load_three<P>(slopes_, 0, i), rates, 0, i);
      const Vec3<P> rows[3] = {load_three<P>(places_, 3, i), load_three<P>(places_, 6, i),
                               load_three<P>(places_, 9, i)};
      for (std::size_t row = 0; row < 3; ++row) {
        const Vec3<P> g = load_three<P>(slopes_, 3 + 3 * row, i);
        store_three(mul_add(rows[2], g.z, mul_add(rows[1], g.y, rows[0] * g.x)), rates, 3 + 3 * row, i);
      }
    }
  }

  KNEAD_INLINE P longest_step(std::size_t i) const {
    const Vec3<P> v = load_three<P>(k_[0], 0, i);
    const Vec3<P> arm = load_three<P>(state_, 0, i) - Vec3<P>(task_.turning_center);
    const P speed = maximum(norm(v - Vec3<P>(segment_.tool_velocity)), P(segment_.tool_speed));
    const P with_turning = mul_add(norm(arm), P(task_.turning), speed);
    return minimum(step_rule::longest_step(with_turning, P(segment_.reach)), P(task_.longest_step));
  }

  KNEAD_INLINE void choose_step(std::size_t i) {
    const P time = P(segment_.end) - P::load(t_ + i);
    const P longest = longest_step(i);
    const P shortest = step_rule::shortest_step(longest, P(kShortestPart<double>));
    const P h = step_rule::chosen_step(P::load(trial_ + i), shortest, longest, maximum(time, -time));
    shortest.store(shortest_ + i);
    (segment_.end >= segment_.begin ? h : -h).store(h_ + i);
  }

  // Returns the square of the error of a step, by the tolerances.
  KNEAD_INLINE P error_of_step(std::size_t i) const {
    const Vec3<P> error{combine(method_.error, 0, i), combine(method_.error, 1, i), combine(method_.error, 2, i)};
    const P of_point = norm2(error * P(1 / segment_.tolerance));
    if (!(task_.jacobian_tolerance > 0)) return of_point;
    P sum(0.0);
    for (std::size_t n = 3; n < kJacobianNumbers; ++n) {
      const P number = combine(method_.error, n, i) * P(1 / task_.jacobian_tolerance);
      sum = mul_add(number, number, sum);
    }
    return maximum(of_point, sum);
  }

  // Accepts the step where its error is small enough.
  KNEAD_INLINE void finish_step(std::size_t i) {
    const P signed_h = P::load(h_ + i);
    const P h = maximum(signed_h, -signed_h);
    const P t = P::load(t_ + i);
    const P end(segment_.end);
    const P remaining = maximum(end - t, t - end);
    const P error2 = error_of_step(i);
    const auto refused = (error2 > P(1)) & (h > P::load(shortest_ + i));
    const auto accept = (!refused) & (remaining > P(0));
    const auto arrived = accept & (h >= remaining);
    for (std::size_t n = 0; n < kJacobianNumbers; ++n) {
      const P from = P::load(state_.of[n] + i);
      select(accept, mul_add(combine(method_.slope, n, i), signed_h, from), from).store(state_.of[n] + i);
      if (!method_.first_same_as_last) continue;
      const P last = P::load(k_[method_.stage_count - 1].of[n] + i);
      select(accept, last, P::load(k_[0].of[n] + i)).store(k_[0].of[n] + i);
    }
    select(arrived, end, select(accept, t + signed_h, t)).store(t_ + i);
    (h * step_rule::step_factor(error2, method_.error_order)).store(trial_ + i);
    accepted_ |= bits(accept) << i;
  }

  const JacobianTask& task_;
  const SegmentTask<double>& segment_;
  const Method<double>& method_;
  std::size_t next_ = 0;
  std::uint32_t busy_ = 0;      // lanes that hold a path line
  std::uint32_t unknown_ = 0;   // lanes whose k_0 is to be evaluated
  std::uint32_t accepted_ = 0;  // lanes whose last step was accepted
  std::size_t point_[kJacobianLanes]{};
  int steps_[kJacobianLanes]{};
  alignas(64) double t_[kJacobianLanes]{};
  alignas(64) double h_[kJacobianLanes]{};
  alignas(64) double trial_[kJacobianLanes]{};
  alignas(64) double shortest_[kJacobianLanes]{};
  alignas(64) double times_[kJacobianLanes]{};
  JacobianBundle state_;
  JacobianBundle places_;  // of a stage
  JacobianBundle slopes_;
  JacobianBundle k_[Tableau::kMaxStages];
};

template <class P>
void move_with_jacobians(const JacobianTask& task) {
  JacobianMover<P>(task).run();
}

template <class P, template <class> class M>
void add_gradients(JacobianKernels& kernels, MotionKind kind) {
  kernels.fields[kind][kBall] = &find_gradients<P, KernelField<double, M, Ball>>;
  kernels.fields[kind][kCapsule] = &find_gradients<P, KernelField<double, M, Capsule>>;
  kernels.fields[kind][kHalfSpace] = &find_gradients<P, KernelField<double, M, HalfSpace>>;
  kernels.fields[kind][kSet] = &find_gradients<P, KernelField<double, M, SetPoints>>;
}

template <class P>
JacobianKernels jacobian_kernels_of() {
  JacobianKernels kernels;
  add_gradients<P, Translation>(kernels, kTranslation);
  add_gradients<P, Rotation>(kernels, kRotation);
  add_gradients<P, Twist>(kernels, kTwist);
  add_gradients<P, Strain>(kernels, kStrain);
  kernels.grid = &find_grid_gradients<P>;
  kernels.move = &move_with_jacobians<P>;
  return kernels;
}

}  // namespace knead::detail
