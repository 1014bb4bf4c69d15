// One path line through one segment, integrated adaptively. Internal to the flow room.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "knead/flow/contact.h"
#include "knead/flow/segment.h"
#include "knead/flow/tableau.h"
#include "knead/math/scalar.h"

namespace knead::detail {

// |dr/dt| at a resting point: how fast a region turns past it.
template <class S>
S turning_speed(const HalfSpace<S>& region, const Vec3<S>& d, double t) {
  if (region.turn_angle == S(0)) return S(0);
  const Vec3<S> n = normal_at(region, static_cast<S>(t));
  return std::abs(region.turn_angle * dot(cross(region.turn_axis, n), d));
}

template <class S>
S turning_speed(const Handles<S>& region, const Vec3<S>& d, double /*t*/) {
  return std::abs(region.turn_angle) * norm(cross(region.turn_axis, d));
}

template <class S>
S turning_speed(const CustomRegion& region, const Vec3<S>& /*d*/, double /*t*/) {
  return static_cast<S>(region.speed);
}

template <class S>
S turning_speed(const auto& /*region*/, const Vec3<S>& /*d*/, double /*t*/) {
  return S(0);
}

// The length over which r passes from one threshold to the other, where that depends on the place: between marked sets
// it is the way from the one past d to the other. Infinity where the thresholds are themselves lengths.
template <class S>
S local_width(const Handles<S>& region, const Vec3<S>& d, double t) {
  const HandlesDistances<S> distance = handles_distances(region, d, static_cast<S>(t));
  return distance.full.value + distance.zero.value;
}

template <class S>
S local_width(const auto& /*region*/, const Vec3<S>& /*d*/, double /*t*/) {
  return std::numeric_limits<S>::infinity();
}

// One field with its numbers in the scalar S. The point that started at x0 and has moved by D is at x0 + D.
template <class S, class M, class R>
struct SingleField {
  M motion;
  R region;
  Thresholds<S> thresholds;
  Vec3d center;
  Vec3<S> displacement;
  bool blended = false;

  Vec3<S> velocity(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    const auto s = static_cast<S>(t);
    const Vec3<S> d = Vec3<S>(x0 - center) + moved;
    if (!blended) return knead::velocity(motion, region, thresholds, d - displacement * s, s);
    return knead::velocity(motion, region, thresholds, d, s) * (S(1) - s) +
           knead::velocity(motion, region, thresholds, d - displacement, s) * s;
  }

  // A speed at which r may change besides that of the point relative to the tool's frame: by turning, or by the part of
  // a blended field whose weight is still small.
  S hidden_speed(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    const Vec3<S> d = Vec3<S>(x0 - center) + moved;
    if (!blended) return turning_speed(region, d - displacement * static_cast<S>(t), t);
    return std::max(norm(knead::velocity(motion, region, thresholds, d, S(0))),
                    norm(knead::velocity(motion, region, thresholds, d - displacement, S(0))));
  }

  S width(const Vec3d& x0, const Vec3<S>& moved, double t) const {
    return local_width(region, Vec3<S>(x0 - center) + moved - displacement * static_cast<S>(t), t);
  }
};

// Several fields, summed. Rare (a point set of several parts), so that an indirect call for each is no matter.
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
        direction_(segment.end >= segment.begin ? 1.0 : -1.0) {
    double reach = std::numeric_limits<double>::infinity();
    for (const Field& field : segment.fields) {
      if (std::holds_alternative<Handles<double>>(field.region)) continue;  // thresholds are no lengths there
      const bool capsule = std::holds_alternative<Capsule<double>>(field.region);
      reach = std::min(reach, (capsule ? kCapsuleReach : kReach) * (field.thresholds.outer - field.thresholds.inner));
    }
    reach_ = static_cast<S>(reach);
    if (segment.time_law == TimeLaw::swept) tool_velocity_ = Vec3<S>(segment.displacement);
    const auto* motion = std::get_if<Translation<double>>(&segment.fields.front().motion);
    carries_ = segment.fields.size() == 1 && segment.time_law == TimeLaw::swept && motion != nullptr &&
               motion->velocity == segment.displacement;
  }

  // The displacement, at the segment's end, of the point that is at x0 at the time t, when a tool reaches it.
  Vec3d run(const Vec3d& x0, double t, PathLineStats& stats) {
    x0_ = x0;
    moved_ = {};
    bool have_first = false;
    bool at_contact = true;  // v is 0 there; what follows must be integrated, not asked for again
    S trial = static_cast<S>(std::abs(segment_.end - t));
    while ((segment_.end - t) * direction_ > 0) {
      if (!have_first) evaluate_stage(0, t, {}, stats);
      if (k_[0] == Vec3<S>{} && !at_contact) {
        const std::optional<double> contact = next_contact(segment_, x0_ + Vec3d(moved_), t);
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
      if (!stats.complete) break;
    }
    return Vec3d(moved_);
  }

 private:
  // How much of the intermediate region's width a step may pass. The gradient of a capsule's v jumps on the planes
  // through its ends, which an estimate misses where a step's last stages alone are beyond one.
  static constexpr double kReach = 0.16;
  static constexpr double kCapsuleReach = 0.06;
  // Between marked sets nothing is out of an estimate's sight, for there v is nowhere 0 over a length.
  static constexpr double kLocalReach = 0.3;
  // The estimate sees the error of each step, not how the flow's stretch magnifies it afterwards, and is too small
  // where v is not smooth (at the inner threshold, and on the planes through a capsule's ends).
  static constexpr double kSafety = 0.02;
  // Steps are never shorter than this part of the longest, or of the segment: there the estimate is rounding, which no
  // step size mends.
  static constexpr S kShortest = std::is_same_v<S, float> ? S(1.0 / 16) : S(1e-7);
  static constexpr std::uint32_t kStepLimit = 1'000'000;

  void evaluate_stage(int stage, double t, const Vec3<S>& offset, PathLineStats& stats) {
    k_[stage] = kernel_.velocity(x0_, moved_ + offset, t);
    ++stats.evaluations;
  }

  Vec3<S> combine(const std::array<S, Tableau::kMaxStages>& weights, int count) const {
    Vec3<S> sum{};
    for (int j = 0; j < count; ++j) sum += k_[j] * weights[j];
    return sum;
  }

  // The longest step that jumps over nothing: neither the point nor the region passes the other by more than kReach or
  // kCapsuleReach of the intermediate region's width, or kLocalReach of that at the place.
  S longest_step(double t) const {
    const S hidden = kernel_.hidden_speed(x0_, moved_, t);
    const S speed = std::max(norm(k_[0] - tool_velocity_), norm(tool_velocity_)) + hidden;
    const S reach = std::min(reach_, static_cast<S>(kLocalReach) * kernel_.width(x0_, moved_, t));
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
  bool carries_ = false;

  Vec3d x0_{};
  Vec3<S> moved_{};
  std::array<Vec3<S>, Tableau::kMaxStages> k_{};
};

}  // namespace knead::detail
