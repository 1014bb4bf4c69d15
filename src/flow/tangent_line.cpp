// One path line with its derivatives.
#include "flow/tangent_line.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "flow/path_jacobian.h"
#include "flow/step_rule.h"

namespace knead::detail {
namespace {

constexpr double kMaxTangentStep = kMinBlendedStep;  // a first step does not see all of a blended segment
constexpr double kMinTangentStep = 1e-9;
constexpr int kStepsPerCancelCheck = 64;

void add(TangentState& to, const TangentState& slope, double h) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += slope[i] * h;
}

double turning_of(const Field& field) {
  if (const auto* space = std::get_if<HalfSpace<double>>(&field.region)) return std::abs(space->turn_angle);
  const auto* handles = std::get_if<Handles<double>>(&field.region);
  return handles != nullptr ? std::abs(handles->turn_angle) : 0;
}

}  // namespace

TangentLine::TangentLine(const Segment& segment, const SegmentRates& rates, const TangentOptions& options)
    : segment_(segment), options_(options), segments_(parts_of(segment)) {
  NextRates next(rates);
  for (std::size_t k = 0; k < kTangents; ++k) {
    for (const double rate : rates[k]) rounding_[k] = std::max(rounding_[k], kErrorOfRates * std::abs(rate));
  }
  for (std::size_t i = 0; i < kBeginAndEnd; ++i) ends_[i] = next(i == 0 ? segment.begin : segment.end);
  std::vector<SegmentMask> masks = masks_of_parts(segment, segments_);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    parts_.push_back(std::make_unique<const PartOfSegment>(segments_[i], std::move(masks[i]), options.progress));
    fields_.emplace_back(*parts_.back(), next);
    const double reach = reach_of_step(segments_[i]);
    if (std::isfinite(reach)) reach_ = std::min(reach_, reach);
    for (const Field& field : segments_[i].fields) {
      tool_speed_ = std::max(tool_speed_, norm(displacement_of(segments_[i], field)));
      turning_ = std::max(turning_, turning_of(field));
      turning_center_ = field.center;
    }
  }
}

unsigned TangentLine::move(TangentState& state, std::vector<TangentStep>* steps) const {
  const unsigned chosen = parts_around(segments_, state[0]);
  if (chosen == 0 || parts_.front()->holds(state[0])) return 0;
  shift(state, ends_[0], segment_.begin, -1, chosen);
  const std::optional<double> contact = next_contact(segment_, state[0], segment_.begin);
  if (contact) {
    integrate(state, *contact, segment_.end, chosen, steps);
  } else if (varies_grid_) {  // nothing flows there, and the derivative of v is linear in time
    const double middle = 0.5 * (segment_.begin + segment_.end);
    state[1] += slope({state[0]}, middle, 1)[1] * (segment_.end - segment_.begin);
  }
  shift(state, ends_[1], segment_.end, 1, chosen);
  return chosen;
}

// Adds the effect of a change of the segment's begin or end.
void TangentLine::shift(TangentState& state, const Varying& end, double t, double sign, unsigned chosen) const {
  if (end == Varying(end.v)) return;
  const Vec3d v = slope(state, t, chosen)[0];
  for (std::size_t k = 0; k < kTangents; ++k) state[1 + k] += v * (sign * end.g[k]);
}

TangentState TangentLine::slope(const TangentState& state, double t, unsigned chosen) const {
  VaryingVec3 x;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    x[axis] = Varying(state[0][axis], {state[1][axis], state[2][axis], state[3][axis]});
  }
  VaryingVec3 v;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if ((chosen >> i & 1U) != 0) v += fields_[i].velocity(x, t);
  }
  TangentState result{values_of(v)};
  for (std::size_t k = 0; k < kTangents; ++k) result[1 + k] = derivatives_of(v, k);
  for (std::size_t axis = 0; axis < 3; ++axis) {  // exactly parallel to the planes of a mirror
    const std::optional<double>& plane = segment_.mirrored_at[axis];
    if (plane && state[0][axis] == *plane) result[0][axis] = 0;
  }
  return result;
}

// Returns the error of a step per unit of time, in units of the allowed error.
double TangentLine::excess(const TangentState& state, const TangentState& first, const TangentState& error) const {
  double most = norm(error[0]) / options_.tolerance;
  for (std::size_t k = 1; k < state.size(); ++k) {
    const double size = std::max(norm(state[k]), norm(first[k]));
    const double allowed = std::max(options_.relative_tolerance * size, rounding_[k - 1]);
    if (allowed > 0) most = std::max(most, norm(error[k]) / allowed);
  }
  return most;
}

void TangentLine::find_kinks(const Vec3d& x, double t, unsigned chosen, std::vector<Kinks>& kinks) const {
  kinks.clear();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if ((chosen >> i & 1U) != 0) parts_[i]->append_kinks(x, t, kinks);
  }
}

double TangentLine::longest_step(const TangentState& state, const TangentState& first) const {
  const double turning = turning_ * norm(state[0] - turning_center_);
  const double speed = norm(first[0]) + tool_speed_ + turning;
  const double longest = segment_.grid.is_empty() ? kMaxTangentStep : 1;
  return speed > 0 ? std::min(longest, reach_ / speed) : longest;
}

void TangentLine::integrate(TangentState& state, double t, double end, unsigned chosen,
                            std::vector<TangentStep>* steps) const {
  const Tableau& method = tableau(Integrator::tsitouras);
  const double direction = end >= t ? 1 : -1;
  std::array<TangentState, Tableau::kMaxStages> k;
  TangentStep step;
  k[0] = slope(state, t, chosen);
  std::vector<Kinks> here;
  std::vector<Kinks> there;
  find_kinks(state[0], t, chosen, here);
  double h = 1e-3;
  for (int tries = 0; direction * (end - t) > 0; ++tries) {
    if (tries == kStepLimit || !std::isfinite(norm2(k[0][0]))) refuse_path_line();
    if (tries % kStepsPerCancelCheck == 0) stop_if_cancelled(options_.progress);
    const double longest = std::min(longest_step(state, k[0]), direction * (end - t));
    h = std::clamp(h, std::min(kMinTangentStep, longest), longest);
    const bool is_last = h == direction * (end - t);
    step.t = t;
    step.h = direction * h;
    step.places[0] = state[0];
    for (int i = 1; i < method.stages; ++i) {
      TangentState at = state;
      for (int j = 0; j < i; ++j) add(at, k[j], direction * h * method.a[i][j]);
      step.places[i] = at[0];
      k[i] = slope(at, t + direction * h * method.c[i], chosen);
    }
    TangentState next = state;
    TangentState error{};
    for (int i = 0; i < method.stages; ++i) {
      add(next, k[i], direction * h * method.b[i]);
      add(error, k[i], method.e[i]);
    }
    const double ratio = excess(state, k[0], error);
    const bool is_known = std::isfinite(ratio);
    const double factor = is_known ? std::clamp(0.9 / std::sqrt(std::sqrt(std::max(ratio, 1e-10))), 0.2, 4.0) : 0.2;
    if (!(ratio <= 1) && h > kMinTangentStep) {
      h *= factor;
      continue;
    }
    // The estimate does not see a kink that only the last stages have passed: a step ends before it, or is so short
    // that the kink does no harm.
    find_kinks(next[0], t + direction * h, chosen, there);
    double part = 1;
    for (std::size_t i = 0; i < here.size(); ++i) part = std::min(part, part_before_kink(here[i], there[i]));
    if (part < 1 && h > kMaxStepOverKink) {
      h = std::max(kPartBeforeKink * part * h, kMaxStepOverKink);
      continue;
    }
    if (steps != nullptr) steps->push_back(step);
    std::swap(here, there);
    state = next;
    t = is_last ? end : t + direction * h;
    k[0] = method.first_same_as_last ? k[static_cast<std::size_t>(method.stages) - 1] : slope(state, t, chosen);
    h *= factor;
  }
}

}  // namespace knead::detail
