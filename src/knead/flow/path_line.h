// One path line through one segment, integrated adaptively. Internal to the flow room.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "knead/flow/closed_form.h"
#include "knead/flow/contact.h"
#include "knead/flow/segment_mover.h"
#include "knead/flow/single_field.h"
#include "knead/flow/tableau.h"
#include "knead/math/scalar.h"

namespace knead::detail {

// Several fields, summed. Rare (those of point sets are in set_cells.h), so that an indirect call for each is no
// matter.
template <class S>
struct FieldSum {
  struct Part {
    std::function<Vec3<S>(const Vec3d&, const Vec3<S>&, double)> velocity;
    std::function<S(const Vec3d&, const Vec3<S>&, double)> hidden_speed;
    std::function<S(const Vec3d&, const Vec3<S>&, double)> width;
  };
  std::vector<Part> parts;

  Vec3<S> velocity(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    Vec3<S> sum{};
    for (const Part& part : parts) sum += part.velocity(x0, moved, t);
    return sum;
  }
  S hidden_speed(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    S greatest{0};
    for (const Part& part : parts) greatest = std::max(greatest, part.hidden_speed(x0, moved, t));
    return greatest;
  }
  S width(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    S least = std::numeric_limits<S>::infinity();
    for (const Part& part : parts) least = std::min(least, part.width(x0, moved, t));
    return least;
  }
};

// What PathLine asks of a segment's fields, where they are the same everywhere. SetCells is another such kernel.
template <class S, class F>
struct WholeField {
  F field;

  struct Place {};  // of one path line

  std::optional<double> next_contact(Place& /*place*/, const Segment& segment, const Vec3d& x, double t) const {
    return knead::next_contact(segment, x, t);
  }
  std::optional<Vec3d> closed_form(const Segment& segment, const Vec3d& x) const {
    return knead::closed_form(segment, x);
  }
  bool keeps(Place& /*place*/, const Vec3d& /*x*/, double /*t*/) const { return true; }
  Vec3<S> velocity(Place /*place*/, const Vec3d& x0, const Vec3<S>& moved, double t) const {
    return field.velocity(x0, moved, t);
  }
  S hidden_speed(Place /*place*/, const Vec3d& x0, const Vec3<S>& moved, double t) const {
    return field.hidden_speed(x0, moved, t);
  }
  S width(Place /*place*/, const Vec3d& x0, const Vec3<S>& moved, double t) const { return field.width(x0, moved, t); }
};

// The coefficients of a method in the scalar S.
template <class S>
struct Coefficients {
  std::array<std::array<S, Tableau::kMaxStages>, Tableau::kMaxStages> a{};
  std::array<S, Tableau::kMaxStages> b{};
  std::array<S, Tableau::kMaxStages> e{};

  explicit Coefficients(const Tableau& tableau) {
    for (std::size_t i = 0; i < b.size(); ++i) {
      b[i] = static_cast<S>(tableau.b[i]);
      e[i] = static_cast<S>(tableau.e[i]);
      for (std::size_t j = 0; j < b.size(); ++j) a[i][j] = static_cast<S>(tableau.a[i][j]);
    }
  }
};

struct PathLineStats {
  std::uint32_t accepted = 0;
  std::uint32_t rejected = 0;
  std::uint64_t evaluations = 0;
  bool complete = true;

  PathLineStats& operator+=(const PathLineStats& other) {
    accepted += other.accepted;
    rejected += other.rejected;
    evaluations += other.evaluations;
    complete = complete && other.complete;
    return *this;
  }
};

// Integrates one path line. The state is the displacement D since the beginning, so that rounding is relative to how
// far the point has moved; time is kept in double.
template <class S, class Kernel>
class PathLine {
 public:
  PathLine(const Segment& segment, const Kernel& kernel, const Tableau& tableau, const Coefficients<S>& coefficients,
           double tolerance)
      : segment_(segment),
        kernel_(kernel),
        tableau_(tableau),
        coefficients_(coefficients),
        tolerance_(static_cast<S>(kSafety * tolerance)),
        direction_(segment.end >= segment.begin ? 1.0 : -1.0),
        reach_(static_cast<S>(reach_of_step(segment))) {
    if (segment.time_law == TimeLaw::swept) tool_velocity_ = Vec3<S>(segment.displacement);
    tool_speed_ = norm(tool_velocity_);
    carries_ = carries(segment);
  }

  // The displacement over the segment of the point that is at x0 at its beginning.
  Vec3d displacement(const Vec3d& x0, PathLineStats& stats) {
    place_ = {};
    const std::optional<double> contact = kernel_.next_contact(place_, segment_, x0, segment_.begin);
    if (!contact) return {};
    if (const std::optional<Vec3d> known = kernel_.closed_form(segment_, x0)) return *known;
    return run(x0, *contact, stats);
  }

  // Whether the way of a tool at rest or swept is short from the segment's beginning, as far as its own motion goes.
  bool may_go_a_short_way() const { return tool_speed_ > S(0) && part_of_longest(tool_velocity_) <= S(kShortWay); }

  // The same displacement where the region of v keeps its shape and width, from the values of v where the path line
  // begins and at the end of Euler's step; nothing where these do not suffice.
  std::optional<Vec3d> short_way(const Vec3<S>& first, const Vec3<S>& second) const {
    const double duration = segment_.end - segment_.begin;
    if (carries_ && first == tool_velocity_) return segment_.displacement * duration;
    const S part = std::max(part_of_longest(first), part_of_longest(second));
    if (!(part <= S(kShortWay)) || !is_accurate(first, second, part)) return std::nullopt;
    return Vec3d((first + second) * (S(0.5) * static_cast<S>(duration)));
  }

 private:
  // The whole segment, of the longest step that begins with the velocity.
  S part_of_longest(const Vec3<S>& velocity) const {
    const S speed = std::max(norm(velocity - tool_velocity_), tool_speed_);
    return static_cast<S>(std::abs(segment_.end - segment_.begin)) * speed / reach_;
  }

  // Between marked sets nothing is out of an estimate's sight, for there v is nowhere 0 over a length.
  static constexpr double kLocalReach = 0.3;
  // Steps are never shorter than this part of the longest, or of the segment: there the estimate is rounding, which no
  // step size mends.
  static constexpr S kShortest = std::is_same_v<S, float> ? S(1.0 / 16) : S(1e-7);
  static constexpr std::uint32_t kStepLimit = 1'000'000;
  // The part of the longest step up to which Heun's method is tried.
  static constexpr double kShortWay = 1.0 / 16;

  // From the time t, when a tool reaches the point.
  Vec3d run(const Vec3d& x0, double t, PathLineStats& stats) {
    x0_ = x0;
    moved_ = {};
    evaluate_stage(0, t, {}, stats);
    if (goes_a_short_way(t, stats)) return Vec3d(moved_);
    bool have_first = true;
    bool at_contact = true;  // v is 0 there; what follows must be integrated, not asked for again
    S trial = static_cast<S>(std::abs(segment_.end - t));
    while ((segment_.end - t) * direction_ > 0) {
      if (!have_first) evaluate_stage(0, t, {}, stats);
      if (k_[0] == Vec3<S>{} && !at_contact) {
        const std::optional<double> contact = kernel_.next_contact(place_, segment_, x0_ + Vec3d(moved_), t);
        if (!contact) break;
        have_first = t == *contact;
        t = *contact;
        at_contact = true;
        continue;
      }
      at_contact = false;
      if (carries_ && k_[0] == tool_velocity_) {  // at rest in the rigid core: it stays there
        return Vec3d(moved_) + segment_.displacement * (segment_.end - t);
      }
      have_first = step(t, trial, stats);
      if (!kernel_.keeps(place_, x0_ + Vec3d(moved_), t)) have_first = false;
      if (!stats.complete) break;
    }
    return Vec3d(moved_);
  }

  bool goes_a_short_way(double t, PathLineStats& stats) {
    if (carries_ && k_[0] == tool_velocity_) return false;
    const double h = std::abs(segment_.end - t);
    const S part = static_cast<S>(h) / longest_step(t);
    if (!(part <= S(kShortWay))) return false;
    const S signed_h = static_cast<S>(direction_ * h);
    evaluate_stage(1, segment_.end, k_[0] * signed_h, stats);
    if (k_[0] == Vec3<S>{} && k_[1] == Vec3<S>{}) return false;  // the tool may have come and gone between
    // Where the way leads the tool may be faster: at its beginning a turning one may be all but at rest.
    const S part_there = std::max(part, static_cast<S>(h) * norm(k_[1] - tool_velocity_) / reach_);
    if (!(part_there <= S(kShortWay)) || !is_accurate(k_[0], k_[1], part_there)) return false;
    moved_ = (k_[0] + k_[1]) * (S(0.5) * signed_h);
    ++stats.accepted;
    return true;
  }

  // Where the whole way is a small part of what a step may pass, two evaluations of v suffice: Heun's method, whose
  // error is about that of Euler's, half the change of v, times that small part.
  bool is_accurate(const Vec3<S>& first, const Vec3<S>& second, S part) const {
    return norm(second - first) * S(0.5) * part <= tolerance_;
  }

  void evaluate_stage(int stage, double t, const Vec3<S>& offset, PathLineStats& stats) {
    k_[stage] = kernel_.velocity(place_, x0_, moved_ + offset, t);
    ++stats.evaluations;
  }

  Vec3<S> combine(const std::array<S, Tableau::kMaxStages>& weights, int count) const {
    Vec3<S> sum{};
    for (int j = 0; j < count; ++j) sum += k_[j] * weights[j];
    return sum;
  }

  // The longest step that jumps over nothing: neither the point nor the region passes the other by more than the
  // segment's reach, or kLocalReach of the intermediate region's width at the place.
  S longest_step(double t) const {
    const S hidden = kernel_.hidden_speed(place_, x0_, moved_, t);
    const S speed = std::max(norm(k_[0] - tool_velocity_), tool_speed_) + hidden;
    const S reach = std::min(reach_, static_cast<S>(kLocalReach) * kernel_.width(place_, x0_, moved_, t));
    const S longest = speed > S(0) ? reach / speed : std::numeric_limits<S>::infinity();
    if (segment_.time_law == TimeLaw::swept) return longest;
    const double from_end = std::min(t, 1 - t);
    return std::min(longest, static_cast<S>(std::max(0.5 * from_end, 1.0 / 32)));
  }

  // Tries one step from t, of at most `trial`; on success advances t and the state. Returns whether k_[0] is still
  // valid.
  bool step(double& t, S& trial, PathLineStats& stats) {
    const double remaining = std::abs(segment_.end - t);
    const S longest = longest_step(t);
    const S shortest = std::min(longest, S(1)) * kShortest;
    double h = std::min(std::max(trial, shortest), longest);
    const bool last = h >= remaining;
    if (last) h = remaining;
    const S signed_h = static_cast<S>(direction_ * h);
    for (int i = 1; i < tableau_.stages; ++i) {
      evaluate_stage(i, t + direction_ * h * tableau_.c[i], combine(coefficients_.a[i], i) * signed_h, stats);
    }
    const Vec3<S> slope = combine(coefficients_.b, tableau_.stages);
    const S error = norm(combine(coefficients_.e, tableau_.stages));
    const S noise = S(8) * std::numeric_limits<S>::epsilon() * norm(slope);
    const bool accept = error <= tolerance_ + noise || static_cast<S>(h) <= shortest;
    trial = static_cast<S>(h) * step_factor(error);
    stats.complete = (accept ? ++stats.accepted : ++stats.rejected) < kStepLimit && std::isfinite(error);
    if (!accept) return true;
    moved_ += slope * signed_h;
    t = last ? segment_.end : t + direction_ * h;
    if (!tableau_.first_same_as_last) return false;
    k_[0] = k_[tableau_.stages - 1];
    return true;
  }

  // The error per unit of time falls with the step's error_order-th power, whose root is taken by square roots only.
  S step_factor(S error) const {
    const S ratio = tolerance_ / std::max(error, tolerance_ * S(1e-4));
    const S root = tableau_.error_order == 2 ? std::sqrt(ratio) : std::sqrt(std::sqrt(ratio));
    return std::clamp(S(0.9) * root, S(0.2), S(5));
  }

  const Segment& segment_;
  const Kernel& kernel_;
  const Tableau& tableau_;
  const Coefficients<S>& coefficients_;
  S tolerance_;
  double direction_;
  S reach_{0};
  Vec3<S> tool_velocity_{};
  S tool_speed_{0};
  bool carries_ = false;

  typename Kernel::Place place_{};
  Vec3d x0_{};
  Vec3<S> moved_{};
  std::array<Vec3<S>, Tableau::kMaxStages> k_{};
};

}  // namespace knead::detail
