// Kernels of path lines with their Jacobians, dx/dt = v and dJ/dt = grad v J, and with their derivatives with respect
// to variables on which the field's numbers depend, dT/dt = grad v T + dv/dvariable. Internal: part of the one source
// of all kernels.
#pragma once

#include "field/dual.h"
#include "flow/kernels/kernel_grid.h"
#include "flow/kernels/kernel_points.h"
#include "flow/kernels/kernel_stage.h"

namespace knead::detail {

// F: a KernelField in double.
template <class P, class F>
void find_gradients(const void* data, const JacobianBundle<0>& places, const double* times, std::uint32_t asked,
                    JacobianBundle<0>& slopes) {
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

// The derivatives of a number with respect to the place, and to n variables.
template <class P, std::size_t n>
struct RatedGradient {
  Vec3<P> place;
  P rates[n];

  KNEAD_INLINE RatedGradient() : place(P(0), P(0), P(0)) {
    for (P& rate : rates) rate = P(0);
  }
  KNEAD_INLINE explicit RatedGradient(const VaryingOf<n, P>& number) : RatedGradient() {
    for (std::size_t k = 0; k < n; ++k) rates[k] = P(number.g[k]);
  }
  // f(a, b) for each derivative.
  template <class Function>
  KNEAD_INLINE static RatedGradient each(const RatedGradient& a, const RatedGradient& b, const Function& f) {
    RatedGradient result;
    result.place = {f(a.place.x, b.place.x), f(a.place.y, b.place.y), f(a.place.z, b.place.z)};
    for (std::size_t k = 0; k < n; ++k) result.rates[k] = f(a.rates[k], b.rates[k]);
    return result;
  }

  KNEAD_INLINE friend RatedGradient operator+(const RatedGradient& a, const RatedGradient& b) {
    return each(a, b, [](const P& x, const P& y) { return x + y; });
  }
  KNEAD_INLINE friend RatedGradient operator-(const RatedGradient& a, const RatedGradient& b) {
    return each(a, b, [](const P& x, const P& y) { return x - y; });
  }
  KNEAD_INLINE friend RatedGradient operator-(const RatedGradient& a) {
    return each(a, a, [](const P& x, const P& /*y*/) { return -x; });
  }
  KNEAD_INLINE friend RatedGradient operator*(const RatedGradient& a, const P& s) {
    return each(a, a, [&](const P& x, const P& /*y*/) { return x * s; });
  }
  KNEAD_INLINE friend RatedGradient mul_add(const RatedGradient& a, const P& s, const RatedGradient& b) {
    return each(a, b, [&](const P& x, const P& y) { return mul_add(x, s, y); });
  }
  KNEAD_INLINE friend RatedGradient neg_mul_add(const RatedGradient& a, const P& s, const RatedGradient& b) {
    return each(a, b, [&](const P& x, const P& y) { return neg_mul_add(x, s, y); });
  }
  template <class Mask>
  KNEAD_INLINE friend RatedGradient select(const Mask& mask, const RatedGradient& a, const RatedGradient& b) {
    return each(a, b, [&](const P& x, const P& y) { return select(mask, x, y); });
  }
};

template <class P, std::size_t n, template <class> class M, template <class> class R>
void find_rated_gradients(const void* data, const JacobianBundle<n>& places, const double* times, std::uint32_t asked,
                          JacobianBundle<n>& slopes) {
  using S = VaryingOf<n, P>;
  using T = DualOf<P, RatedGradient<P, n>>;
  const auto& field = *static_cast<const RatedField<M, R>*>(data);
  const M<S> motion(field.motion);
  const R<S> region(field.region);
  const Thresholds<S> thresholds(field.thresholds);
  const Vec3<T> displacement{Vec3<S>(field.displacement)};
  const Vec3<T> center{Vec3<S>(field.center)};
  for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
    if ((asked >> i & lanes_in_use<P>(i, kJacobianLanes)) == 0) continue;
    const Vec3<P> place = load_three<P>(places, 0, i);
    Vec3<T> d{T(place.x), T(place.y), T(place.z)};
    for (std::size_t axis = 0; axis < 3; ++axis) d[axis].g.place[axis] = P(1);
    d = d - center;
    const T t(P::load(times + i));
    const Vec3<T> moving = d - displacement * (field.is_blended ? T(1) : t);
    Vec3<T> v = velocity(motion, region, thresholds, moving, t);
    if (field.is_blended) v = v * t + velocity(motion, region, thresholds, d, t) * (T(1) - t);
    store_three(Vec3<P>(v.x.v, v.y.v, v.z.v), slopes, 0, i);
    for (std::size_t row = 0; row < 3; ++row) store_three(v[row].g.place, slopes, 3 + 3 * row, i);
    for (std::size_t k = 0; k < n; ++k) {
      store_three(Vec3<P>(v.x.g.rates[k], v.y.g.rates[k], v.z.g.rates[k]), slopes, 12 + 3 * k, i);
    }
  }
}

// `backwards`: with gradients in the place of Jacobians. A step of a path line through a grid without a mask then lies
// in one cell: v is a polynomial there, also a little beyond, and no error of a step comes from the jumps of its second
// derivatives.
template <class P, std::size_t n, bool backwards = false>
class JacobianMover {
 public:
  explicit JacobianMover(const JacobianTask<n>& task)
      : task_(task), segment_(*task.segment), method_(*segment_.method), reach_(segment_.reach) {
    fill(t_, segment_.end, kJacobianLanes);
    fill(most_, kNoLimit, kJacobianLanes);
    if constexpr (!backwards) return;
    by_cells_ = task.sums.mask.is_empty();
    if (by_cells_) reach_ = task.sums.grid.spacing;
    // The error of a step beyond its cell is of second order in the part of the cell.
    beyond_ = minimum(maximum(0.1 * std::sqrt(task.jacobian_tolerance), 1e-6), 0.05);
  }

  // Returns false if a path line needs too many steps.
  bool run() {
    for (;;) {
      settle();
      if (busy_ == 0 || is_incomplete_ || task_.stop.is_stopped(0)) return !is_incomplete_;
      begin(unknown_);
      for (std::size_t i = 0; by_cells_ && i < kJacobianLanes; i += P::kSize) choose_cell(i);
      for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) choose_step(i);
      for (int k = 1; k < method_.stage_count; ++k) evaluate(method_.stages[k], busy_, k_[k]);
      accepted_ = 0;
      for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) finish_step(i);
      if (!method_.first_same_as_last) begin(accepted_);
    }
  }

 private:
  using Bundle = JacobianBundle<n>;
  static constexpr std::size_t kNumbers = backwards ? 6 : kJacobianNumbers<n>;
  static constexpr std::size_t kFirstTangent = backwards ? 3 : 12;  // or the gradient

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
    put(task_.points[from.point], 0, lane);
    most_[lane] = kNoLimit;
    if constexpr (backwards) {
      const Vec3d cell = place_in(task_.sums.grid, task_.points[from.point] - task_.sums.center).cell;
      for (std::size_t axis = 0; axis < 3; ++axis) cell_[axis][lane] = cell[axis];
      put(task_.gradients[from.point], 3, lane);
    } else {
      const Mat3d& jacobian = task_.jacobians[from.point];
      put(jacobian.row0, 3, lane);
      put(jacobian.row1, 6, lane);
      put(jacobian.row2, 9, lane);
      for (std::size_t k = kFirstTangent; k < kNumbers; ++k) state_.of[k][lane] = 0;
    }
    t_[lane] = from.t;
    const double rest = segment_.end - from.t;
    trial_[lane] = rest < 0 ? -rest : rest;
    steps_[lane] = 0;
    busy_ |= std::uint32_t{1} << lane;
    unknown_ |= std::uint32_t{1} << lane;
  }

  void write_back(std::size_t lane) const {
    take(task_.points[point_[lane]], 0, lane);
    if constexpr (backwards) return take(task_.gradients[point_[lane]], 3, lane);
    Mat3d& jacobian = task_.jacobians[point_[lane]];
    take(jacobian.row0, 3, lane);
    take(jacobian.row1, 6, lane);
    take(jacobian.row2, 9, lane);
    for (std::size_t k = 0; k < n && k < task_.tangents_of_point; ++k) {
      take(task_.tangents[point_[lane] * task_.tangents_of_point + k], kFirstTangent + 3 * k, lane);
    }
  }

  void put(const Vec3d& v, std::size_t first, std::size_t lane) {
    for (std::size_t axis = 0; axis < 3; ++axis) state_.of[first + axis][lane] = v[axis];
  }
  void take(Vec3d& v, std::size_t first, std::size_t lane) const {
    for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = state_.of[first + axis][lane];
  }

  // Returns whether the path line continues after a step. A resting point waits until the tool meets it again;
  // backwards it goes on, because its velocity may depend on coefficients.
  bool goes_on(std::size_t lane) {
    const double rest = segment_.end - t_[lane];
    if (!(segment_.end >= segment_.begin ? rest > 0 : rest < 0)) return false;
    if (++steps_[lane] == kStepLimit) is_incomplete_ = true;
    if (backwards || k_[0].of[0][lane] != 0 || k_[0].of[1][lane] != 0 || k_[0].of[2][lane] != 0) return true;
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
    Bundle found;
    evaluate(Stage<double>{}, lanes, found);
    for (std::size_t lane = 0; lane < kJacobianLanes; ++lane) {
      if ((lanes >> lane & 1) == 0) continue;
      for (std::size_t k = 0; k < kNumbers; ++k) k_[0].of[k][lane] = found.of[k][lane];
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

  // Writes the state in a stage to places_.
  KNEAD_INLINE void place(const Stage<double>& stage, std::size_t i) {
    const P h = P::load(h_ + i);
    for (std::size_t k = 0; k < kNumbers; ++k) {
      const P from = P::load(state_.of[k] + i);
      (stage.count == 0 ? from : mul_add(combine(stage, k, i), h, from)).store(places_.of[k] + i);
    }
  }

  // Finds the rates of x and J, or of x and its gradient, in a stage.
  void evaluate(const Stage<double>& stage, std::uint32_t lanes, Bundle& rates) {
    for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
      const P h = P::load(h_ + i);
      place(stage, i);
      const P t = P::load(t_ + i);
      (stage.count == 0 ? t : mul_add(h, P(stage.c), t)).store(times_ + i);
    }
    find_gradients(lanes);
    for (std::size_t i = 0; i < kJacobianLanes; i += P::kSize) {
      store_three(load_three<P>(slopes_, 0, i), rates, 0, i);
      if constexpr (backwards) {
        const Vec3<P> g = load_three<P>(places_, 3, i);
        const Vec3<P> by_z = load_three<P>(slopes_, 9, i) * g.z;
        store_three(-mul_add(load_three<P>(slopes_, 3, i), g.x, mul_add(load_three<P>(slopes_, 6, i), g.y, by_z)),
                    rates, 3, i);
        continue;
      }
      const Vec3<P> rows[3] = {load_three<P>(places_, 3, i), load_three<P>(places_, 6, i),
                               load_three<P>(places_, 9, i)};
      for (std::size_t row = 0; row < 3; ++row) {
        const Vec3<P> g = load_three<P>(slopes_, 3 + 3 * row, i);
        store_three(mul_add(rows[2], g.z, mul_add(rows[1], g.y, rows[0] * g.x)), rates, 3 + 3 * row, i);
        for (std::size_t k = kFirstTangent; k < kNumbers; k += 3) {
          const P along = mul_add(g.z, tangent(k + 2, i), mul_add(g.y, tangent(k + 1, i), g.x * tangent(k, i)));
          (along + P::load(slopes_.of[k + row] + i)).store(rates.of[k + row] + i);
        }
      }
    }
  }

  void find_gradients(std::uint32_t lanes) {
    if constexpr (backwards) {
      if (by_cells_) {
        return find_grid_gradients<P>(*static_cast<const GridKernelField<double>*>(task_.field), places_, times_, lanes,
                                      slopes_, [&](const Vec3<P>& y, std::size_t i) { return in_cell(y, i); });
      }
    }
    task_.find_gradients(task_.field, places_, times_, lanes, slopes_);
  }

  KNEAD_INLINE GridPlace<P> in_cell(const Vec3<P>& y, std::size_t i) const {
    GridPlace<P> place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place.cell[axis] = P::load(cell_[axis] + i);
      place.within[axis] = mul_sub(y[axis], P(task_.sums.grid.per_spacing), place.cell[axis]);
    }
    return place;
  }

  // Goes on to the next cell where a path line has come to the end of one, and finds the time to the end of the new one
  // at the present velocity.
  KNEAD_INLINE void choose_cell(std::size_t i) {
    const GridView<double>& grid = task_.sums.grid;
    const Vec3<P> within = in_cell(load_three<P>(state_, 0, i) - Vec3<P>(task_.sums.center), i).within;
    const double direction = segment_.end >= segment_.begin ? 1 : -1;
    P time(kNoLimit);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const P v = P::load(k_[0].of[axis] + i) * P(direction * grid.per_spacing);
      const P& u = within[axis];
      const P up = select((u > P(1 - beyond_)) & (v > P(0)), P(1), P(0));
      const P down = select((u < P(beyond_)) & (v < P(0)), P(1), P(0));
      const P cell = P::load(cell_[axis] + i);
      const P next = minimum(P(grid.last_cell[axis]), maximum(P(grid.first_cell[axis]), cell + up - down));
      next.store(cell_[axis] + i);
      const P at = u - (next - cell);
      const P rest = maximum(select(v > P(0), P(1) - at, at), P(0)) + P(0.5 * beyond_);
      time = minimum(time, rest / maximum(maximum(v, -v), P(kMinSpeed)));
    }
    minimum(P::load(most_ + i), time).store(most_ + i);
  }

  // Returns the part of the step before the end of its cell; 1 if it ends before that, or only a little beyond.
  KNEAD_INLINE P part_in_cell(std::size_t i, const P& h) const {
    const Vec3<P> from = load_three<P>(state_, 0, i) - Vec3<P>(task_.sums.center);
    Vec3<P> to;
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] = mul_add(combine(method_.slope, axis, i), h, from[axis]);
    const Vec3<P> begin = in_cell(from, i).within;
    const Vec3<P> end = in_cell(to, i).within;
    P part(1.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const P& a = begin[axis];
      const P& b = end[axis];
      const P above = (P(1 + 0.5 * beyond_) - a) / maximum(b - a, P(kMinSpeed));
      const P below = (a + P(0.5 * beyond_)) / maximum(a - b, P(kMinSpeed));
      part = minimum(part, select(b > P(1 + beyond_), above, select(b < P(-beyond_), below, P(1.0))));
    }
    return maximum(part, P(kMinStepFactor));
  }

  KNEAD_INLINE P tangent(std::size_t number, std::size_t i) const { return P::load(places_.of[number] + i); }

  KNEAD_INLINE P longest_step(std::size_t i) const {
    const Vec3<P> v = load_three<P>(k_[0], 0, i);
    const Vec3<P> arm = load_three<P>(state_, 0, i) - Vec3<P>(task_.turning_center);
    const P speed = maximum(norm(v - Vec3<P>(segment_.tool_velocity)), P(segment_.tool_speed));
    const P with_turning = mul_add(norm(arm), P(task_.turning), speed);
    return minimum(step_rule::longest_step(with_turning, P(reach_)), P(task_.longest_step));
  }

  KNEAD_INLINE void choose_step(std::size_t i) {
    const P time = P(segment_.end) - P::load(t_ + i);
    const P longest = longest_step(i);
    const P shortest = step_rule::shortest_step(longest, P(kShortestPart<double>));
    const P wanted = minimum(P::load(trial_ + i), P::load(most_ + i));
    const P h = step_rule::chosen_step(wanted, shortest, longest, maximum(time, -time));
    shortest.store(shortest_ + i);
    (segment_.end >= segment_.begin ? h : -h).store(h_ + i);
  }

  // Returns the square of the error of a step, by the tolerances. Rounding does not count.
  KNEAD_INLINE P error_of_step(std::size_t i) const {
    constexpr double kRounding = kRoundingOfSlope * std::numeric_limits<double>::epsilon();
    const double by_point = 1 / segment_.tolerance;
    const P rate2 = backwards ? P(0.0) : squared(method_.slope, 3, 9, i, kRounding);
    const P noise2 = mul_add(rate2, norm2(load_three<P>(state_, 0, i)), squared(method_.slope, 0, 3, i, kRounding));
    P most = squared(method_.error, 0, 3, i, by_point) / maximum(noise2 * P(by_point * by_point), P(1));
    if (!(task_.jacobian_tolerance > 0)) return most;
    const double by_jacobian = 1 / task_.jacobian_tolerance;
    if constexpr (!backwards) {
      most = maximum(
          most, squared(method_.error, 3, 9, i, by_jacobian) / maximum(rate2 * P(by_jacobian * by_jacobian), P(1)));
    }
    for (std::size_t k = kFirstTangent; k < kNumbers; k += 3) {
      const double rounding = task_.tangent_rounding[(k - kFirstTangent) / 3] * by_jacobian;
      P size2(rounding * rounding + std::numeric_limits<double>::min());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const P now = P::load(state_.of[k + axis] + i);
        const P rate = P::load(k_[0].of[k + axis] + i);
        size2 = size2 + maximum(now * now, rate * rate);
      }
      most = maximum(most, squared(method_.error, k, 3, i, by_jacobian) / size2);
    }
    return most;
  }

  // Returns the squared norm of a combination of `count` numbers, times a factor.
  KNEAD_INLINE P squared(const Stage<double>& stage, std::size_t first, std::size_t count, std::size_t i,
                         double factor) const {
    P sum(0.0);
    for (std::size_t k = first; k < first + count; ++k) {
      const P number = combine(stage, k, i) * P(factor);
      sum = mul_add(number, number, sum);
    }
    return sum;
  }

  // Finds the parts of accepted steps before their first kinks.
  void find_kinks(std::uint32_t accepted, std::size_t i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const P h = P::load(h_ + i);
      const P from = P::load(state_.of[axis] + i);
      const P to = mul_add(combine(method_.slope, axis, i), h, from);
      const P bend = P::load(k_[0].of[axis] + i) - P::load(k_[method_.stage_count - 1].of[axis] + i);
      to.store(places_.of[axis] + i);
      mul_add(bend * P(0.125), h, (from + to) * P(0.5)).store(places_.of[3 + axis] + i);  // Hermite's cubic
    }
    for (std::size_t lane = i; lane < i + P::kSize; ++lane) {
      const double h = h_[lane] < 0 ? -h_[lane] : h_[lane];
      if ((accepted >> (lane - i) & 1) == 0 || !(h > kMaxStepOverKink)) continue;
      const Vec3d places[3] = {{state_.of[0][lane], state_.of[1][lane], state_.of[2][lane]},
                               {places_.of[3][lane], places_.of[4][lane], places_.of[5][lane]},
                               {places_.of[0][lane], places_.of[1][lane], places_.of[2][lane]}};
      part_[lane] = task_.part_before_kink(task_.kinks, places, t_[lane], t_[lane] + h_[lane]);
    }
  }

  // Adds the accepted steps' parts of the gradient with respect to the coefficients, lane after lane: the order does
  // not depend on the size of a pack.
  void add_to_sums(std::uint32_t accepted, std::size_t i) {
    if (accepted == 0) return;
    alignas(64) double states[Tableau::kMaxStages][kNumbers][P::kSize];
    const int count = method_.slope.count;
    for (int j = 0; j < count; ++j) {
      place(method_.stages[method_.slope.slopes[j]], i);
      for (std::size_t k = 0; k < kNumbers; ++k) P::load(places_.of[k] + i).store(states[j][k]);
    }
    for (std::size_t lane = 0; lane < P::kSize; ++lane) {
      if ((accepted >> lane & 1) == 0) continue;
      for (int j = 0; j < count; ++j) {
        const auto& at = states[j];
        const Vec3d x{at[0][lane], at[1][lane], at[2][lane]};
        const Vec3d gradient{at[3][lane], at[4][lane], at[5][lane]};
        const double h = h_[i + lane];
        const double t = t_[i + lane] + method_.stages[method_.slope.slopes[j]].c * h;
        add_to_sums(i + lane, x, gradient * (-method_.slope.weights[j] * h), t);
      }
    }
  }

  // The same of v at one place, whose gradient is `by_velocity`.
  KNEAD_INLINE void add_to_sums(std::size_t lane, const Vec3d& x, const Vec3d& by_velocity, double t) const {
    const CoefficientSums& sums = task_.sums;
    const Vec3d y = x - sums.center;
    GridPlace<double> place = place_in(sums.grid, y);
    if (by_cells_) {
      place.cell = {cell_[0][lane], cell_[1][lane], cell_[2][lane]};
      place.within = y * sums.grid.per_spacing - place.cell;
    }
    MaskValue<double> mask{1, {0, 0, 0}};
    if (!sums.mask.is_empty()) mask = evaluate_mask(sums.mask, y);
    const Vec3d by_curl = by_velocity * (mask.value * sums.grid.per_spacing / 216);
    const Vec3d by_value = cross(by_velocity, mask.gradient) * (1.0 / 216);
    if (sums.grid.end_numbers == nullptr) {
      return add_by_coefficients(sums.grid, place, by_curl, by_value, sums.planes, sums.plane);
    }
    add_by_coefficients(sums.grid, place, by_curl * (1 - t), by_value * (1 - t), sums.planes, sums.plane);
    add_by_coefficients(sums.grid, place, by_curl * t, by_value * t, sums.planes + 3 * sums.plane, sums.plane);
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
    auto accept = (!refused) & (remaining > P(0));
    P trial = h * step_rule::step_factor(error2, method_.error_order);
    if (task_.part_before_kink != nullptr && !by_cells_) {
      P(1.0).store(part_ + i);
      find_kinks(bits(accept), i);
      const P part = P::load(part_ + i);
      accept = accept & (part >= P(1));
      trial = select(part >= P(1), trial, maximum(h * part * P(kPartBeforeKink), P(kMaxStepOverKink)));
    }
    if (by_cells_) {
      // A step that the end of its cell has shortened says little of the next one.
      const P part = part_in_cell(i, signed_h);
      const auto is_within = (part >= P(1)) | (h <= P::load(shortest_ + i));
      const P before = P::load(trial_ + i);
      const P after = select(h < before, maximum(trial, before), trial);
      trial = select(refused, trial, select(is_within, after, before));
      const P most = select(is_within, P::load(most_ + i), h * part);
      select(accept & is_within, P(kNoLimit), most).store(most_ + i);
      accept = accept & is_within;
    }
    const auto arrived = accept & (h >= remaining);
    if constexpr (backwards) add_to_sums(bits(accept), i);
    for (std::size_t k = 0; k < kNumbers; ++k) {
      const P from = P::load(state_.of[k] + i);
      select(accept, mul_add(combine(method_.slope, k, i), signed_h, from), from).store(state_.of[k] + i);
      if (!method_.first_same_as_last) continue;
      const P last = P::load(k_[method_.stage_count - 1].of[k] + i);
      select(accept, last, P::load(k_[0].of[k] + i)).store(k_[0].of[k] + i);
    }
    select(arrived, end, select(accept, t + signed_h, t)).store(t_ + i);
    trial.store(trial_ + i);
    accepted_ |= bits(accept) << i;
  }

  const JacobianTask<n>& task_;
  const SegmentTask<double>& segment_;
  const Method<double>& method_;
  std::size_t next_ = 0;
  std::uint32_t busy_ = 0;      // lanes that hold a path line
  std::uint32_t unknown_ = 0;   // lanes whose k_0 is to be evaluated
  std::uint32_t accepted_ = 0;  // lanes whose last step was accepted
  bool is_incomplete_ = false;
  static constexpr double kNoLimit = 1e300;
  double reach_;           // the length that a step may pass
  bool by_cells_ = false;  // a step lies in one cell
  double beyond_ = 0;      // the part of a cell by which it may end beyond
  std::size_t point_[kJacobianLanes]{};
  int steps_[kJacobianLanes]{};
  alignas(64) double t_[kJacobianLanes]{};
  alignas(64) double h_[kJacobianLanes]{};
  alignas(64) double trial_[kJacobianLanes]{};
  alignas(64) double shortest_[kJacobianLanes]{};
  alignas(64) double times_[kJacobianLanes]{};
  alignas(64) double part_[kJacobianLanes]{};  // of a step before its first kink
  alignas(64) double most_[kJacobianLanes]{};  // the longest step that stays in the cell
  alignas(64) double cell_[3][kJacobianLanes]{};
  Bundle state_;
  Bundle places_;  // of a stage
  Bundle slopes_;
  Bundle k_[Tableau::kMaxStages];
};

template <class P, std::size_t n>
bool move_with_jacobians(const JacobianTask<n>& task) {
  return JacobianMover<P, n>(task).run();
}

template <class P>
bool carry_gradients_back(const JacobianTask<0>& task) {
  return JacobianMover<P, 0, true>(task).run();
}

template <class P, template <class> class M>
void add_gradients(JacobianKernels<0>& kernels, MotionKind kind) {
  kernels.fields[kind][kBall] = &find_gradients<P, KernelField<double, M, Ball>>;
  kernels.fields[kind][kCapsule] = &find_gradients<P, KernelField<double, M, Capsule>>;
  kernels.fields[kind][kHalfSpace] = &find_gradients<P, KernelField<double, M, HalfSpace>>;
  kernels.fields[kind][kSet] = &find_gradients<P, KernelField<double, M, SetPoints>>;
}

template <class P, template <class> class M, std::size_t n>
requires(n > 0) void add_gradients(JacobianKernels<n>& kernels, MotionKind kind) {
  kernels.fields[kind][kBall] = &find_rated_gradients<P, n, M, Ball>;
  kernels.fields[kind][kCapsule] = &find_rated_gradients<P, n, M, Capsule>;
  kernels.fields[kind][kHalfSpace] = &find_rated_gradients<P, n, M, HalfSpace>;
}

template <class P, std::size_t n>
JacobianKernels<n> jacobian_kernels_of() {
  JacobianKernels<n> kernels;
  add_gradients<P, Translation>(kernels, kTranslation);
  add_gradients<P, Rotation>(kernels, kRotation);
  add_gradients<P, Twist>(kernels, kTwist);
  add_gradients<P, Strain>(kernels, kStrain);
  if constexpr (n == 0) {
    kernels.grid = &find_grid_gradients<P>;
    kernels.carry_back = &carry_gradients_back<P>;
  }
  kernels.move = &move_with_jacobians<P, n>;
  return kernels;
}

}  // namespace knead::detail
