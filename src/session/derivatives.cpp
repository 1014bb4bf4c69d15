// Derivatives of a deformation with respect to the parameters of its session.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "flow/tangents.h"
#include "knead/error.h"
#include "knead/replay.h"

namespace knead {

namespace {

// The numbers of each segment of a flow, or their derivatives with respect to one parameter.
using FlowNumbers = std::vector<std::vector<double>>;

// Returns the scale of a parameter: of its value, or of its bounds.
double size_of(const Parameter& parameter) {
  const double value = std::abs(parameter.value);
  if (value > 0) return value;
  const double most = std::max(std::abs(parameter.least.value_or(0)), std::abs(parameter.greatest.value_or(0)));
  return most > 0 ? most : 1;
}

// The strokes of a session by the parameters that they name. A parameter's flow is that of its own strokes, so that it
// costs as much in a long session as in a short one.
class ParameterStrokes {
 public:
  // Removes the bounds of the session's parameters, because differences exceed them.
  ParameterStrokes(const Session& session, const SessionPart& part) : part_(part), whole_(session) {
    for (Parameter& parameter : whole_.parameters) {
      parameter.least.reset();
      parameter.greatest.reset();
    }
    const double until = part.until.value_or(kInfinity);
    std::map<std::string, std::size_t, std::less<>> numbers;
    for (std::size_t p = 0; p < session.parameters.size(); ++p) numbers[session.parameters[p].name] = p;
    for (const SessionStroke& stroke : session.strokes) {
      if (stroke.off || !(static_cast<double>(strokes_.size()) < until)) continue;
      strokes_.push_back({&stroke, named_by(stroke, numbers)});
    }
    strokes_of_.resize(session.parameters.size());
    for (std::size_t i = 0; i < strokes_.size(); ++i) {
      for (const std::size_t p : strokes_[i].parameters) strokes_of_[p].push_back(i);
    }
  }
  ParameterStrokes(const ParameterStrokes&) = delete;
  ParameterStrokes& operator=(const ParameterStrokes&) = delete;
  ~ParameterStrokes() = default;

  const Parameter& parameter(std::size_t p) const { return whole_.parameters[p]; }
  void set_value(std::size_t p, double value) { whole_.parameters[p].value = value; }

  // Returns the session with the values.
  Session whole() const { return with_values(whole_, {}); }

  std::size_t size() const { return strokes_.size(); }

  // Returns the strokes whose segments may change with a parameter, ascending: those that name it; all if a mask does.
  std::vector<std::size_t> of(std::size_t p) const {
    const auto masks = [&](std::size_t i) { return is_mask(i); };
    if (std::none_of(strokes_of_[p].begin(), strokes_of_[p].end(), masks)) return strokes_of_[p];
    std::vector<std::size_t> all(strokes_.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
  }

  // Returns the session with some strokes only, and all masks.
  struct Some {
    Session session;
    SessionPart part;
  };
  Some some(const std::vector<std::size_t>& chosen) const {
    Some result{{}, {part_.direction, std::nullopt}};
    result.session.name = whole_.name;
    std::set<std::size_t> parameters;
    auto next = chosen.begin();
    for (std::size_t i = 0; i < strokes_.size(); ++i) {
      const bool is_chosen = next != chosen.end() && *next == i;
      if (is_chosen) ++next;
      if (!is_chosen && !is_mask(i)) continue;
      result.session.strokes.push_back(*strokes_[i].stroke);
      parameters.insert(strokes_[i].parameters.begin(), strokes_[i].parameters.end());
      const double part = part_.until.value_or(kInfinity) - static_cast<double>(i);
      if (part < 1) result.part.until = static_cast<double>(result.session.strokes.size() - 1) + part;
    }
    for (const std::size_t p : parameters) result.session.parameters.push_back(whole_.parameters[p]);
    return result;
  }

 private:
  struct Named {
    const SessionStroke* stroke;
    std::set<std::size_t> parameters;
  };

  static std::set<std::size_t> named_by(const SessionStroke& stroke,
                                        const std::map<std::string, std::size_t, std::less<>>& numbers) {
    constexpr std::string_view kBegin = "\"$";
    std::set<std::size_t> result;
    for (const ParameterUse& use : stroke.uses) {
      const std::string_view text = use.text;
      for (std::size_t at = text.find(kBegin); at != std::string_view::npos; at = text.find(kBegin, at)) {
        at += kBegin.size();
        const auto found = numbers.find(text.substr(at, text.find('"', at) - at));
        if (found != numbers.end()) result.insert(found->second);
      }
    }
    return result;
  }

  bool is_mask(std::size_t i) const { return std::holds_alternative<MaskStroke>(strokes_[i].stroke->stroke); }

  SessionPart part_;
  Session whole_;
  std::vector<Named> strokes_;  // those of the part that are not off; they lie in the session given
  std::vector<std::vector<std::size_t>> strokes_of_;
};

// A stroke that does nothing at a value, such as a path of length 0, has no segments there, but has some at other
// values. The parameter is then moved by this fraction of its scale.
constexpr double kNudge = 1e-11;

void move_beside_nothing(ParameterStrokes& strokes, std::size_t p, int threads, const Progress* progress) {
  const std::vector<std::size_t> chosen = strokes.of(p);
  if (chosen.empty()) return;
  const ParameterStrokes::Some own = strokes.some(chosen);
  const Parameter& parameter = strokes.parameter(p);
  const double step = kNudge * size_of(parameter);
  const auto count = [&](double by) -> std::optional<std::size_t> {
    stop_if_cancelled(progress);
    try {
      return flow_of(with_values(own.session, {{parameter.name, parameter.value + by}}), own.part, threads)
          .segments.size();
    } catch (const InvalidInput&) {
      return std::nullopt;
    }
  };
  const std::optional<std::size_t> after = count(step);
  if (after && count(-step) == after && count(0) != after) strokes.set_value(p, parameter.value + step);
}

// The first steps of the differences, relative to the scale of the parameter. Smaller ones are tried if the flow does
// not exist at that distance, or has other segments there.
constexpr std::array<double, 6> kSteps{0.02, 0.005, 1e-3, 1e-4, 1e-5, 1e-6};
constexpr std::size_t kCentralLevels = 4;  // of halved steps: the error falls with the eighth power of the step
constexpr std::size_t kSidedLevels = 7;    // with the seventh
// Errors relative to the greatest derivative: the differences end at the first; a derivative must reach the second.
constexpr double kGoodAgreement = 1e-11;
constexpr double kRequiredAgreement = 1e-7;

double greatest_of(const FlowNumbers& numbers) {
  double most = 0;
  for (const std::vector<double>& of_segment : numbers) {
    for (const double number : of_segment) most = std::max(most, std::abs(number));
  }
  return most;
}

// a x + b y
FlowNumbers combined(double a, const FlowNumbers& x, double b, const FlowNumbers& y) {
  FlowNumbers result = x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t n = 0; n < x[i].size(); ++n) result[i][n] = a * x[i][n] + b * y[i][n];
  }
  return result;
}

struct Estimate {
  FlowNumbers derivatives;
  double error = kInfinity;  // relative to the greatest of them
};

// Richardson's extrapolation of differences whose step is halved from each to the next. `order`: of their error, which
// is a series in its powers.
Estimate extrapolated(std::vector<FlowNumbers> differences, int order) {
  Estimate estimate;
  double factor = 1;
  const std::size_t levels = differences.size();
  FlowNumbers before;
  for (std::size_t level = 1; level < levels; ++level) {
    factor *= 1 << order;
    before = differences.back();
    for (std::size_t i = levels - 1; i >= level; --i) {
      differences[i] = combined(factor / (factor - 1), differences[i], -1 / (factor - 1), differences[i - 1]);
    }
  }
  estimate.derivatives = std::move(differences.back());
  const double most = greatest_of(estimate.derivatives);
  const double change = greatest_of(combined(1, estimate.derivatives, -1, before));
  estimate.error = most > 0 ? change / most : change;
  return estimate;
}

// The flow of a parameter's strokes as a function of it.
class FlowOfParameter {
 public:
  // `segments`: of these strokes, in order.
  FlowOfParameter(ParameterStrokes::Some own, Parameter parameter, double size, int threads,
                  std::vector<const detail::SegmentNumbers*> segments, const Progress* progress)
      : own_(std::move(own)),
        parameter_(std::move(parameter)),
        size_(size),
        threads_(threads),
        segments_(std::move(segments)),
        progress_(progress) {}

  // Returns the derivatives at the parameter's value.
  FlowNumbers derivatives() const {
    const std::optional<FlowNumbers> here = at(0);
    Estimate best;
    for (const double step : kSteps) {
      for (const int side : {0, -1, 1}) {
        const std::optional<Estimate> estimate = here ? by(step * size_, side, *here) : std::nullopt;
        if (estimate && estimate->error < best.error) best = *estimate;
        if (best.error <= kGoodAgreement) return best.derivatives;
        if (side == 0 && estimate) break;
      }
    }
    if (best.error <= kRequiredAgreement) return best.derivatives;
    throw InvalidInput(
        Place{own_.session.name},
        fmt::format(
            "the flow has no derivative with respect to \"{}\" at {}: it chooses a whole number or the number of "
            "segments there, or is in a mask, a grid, a curve, a lattice's box, or what reads the surface",
            parameter_.name, parameter_.value));
  }

 private:
  // Returns nothing if there is no flow, or one with other segments.
  std::optional<FlowNumbers> at(double step) const {
    stop_if_cancelled(progress_);
    Flow flow;
    try {
      flow = flow_of(with_values(own_.session, {{parameter_.name, parameter_.value + step}}), own_.part, threads_);
    } catch (const InvalidInput&) {
      return std::nullopt;
    }
    if (flow.segments.size() != segments_.size()) return std::nullopt;
    FlowNumbers numbers;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      std::optional<std::vector<double>> of_segment = segments_[i]->of(flow.segments[i]);
      if (!of_segment) return std::nullopt;
      numbers.push_back(std::move(*of_segment));
    }
    return numbers;
  }

  // side: 0 for central differences, else the sign of the steps.
  std::optional<Estimate> by(double step, int side, const FlowNumbers& here) const {
    std::vector<FlowNumbers> differences;
    for (std::size_t level = 0; level < (side == 0 ? kCentralLevels : kSidedLevels); ++level, step *= 0.5) {
      const double signed_step = side < 0 ? -step : step;
      const std::optional<FlowNumbers> there = at(signed_step);
      const std::optional<FlowNumbers> other = side == 0 ? at(-step) : here;
      if (!there || !other) return std::nullopt;
      // The steps as they are after rounding.
      const double from = side == 0 ? parameter_.value - step : parameter_.value;
      const double width = (parameter_.value + signed_step) - from;
      differences.push_back(combined(1 / width, *there, -1 / width, *other));
    }
    return extrapolated(std::move(differences), side == 0 ? 2 : 1);
  }

  ParameterStrokes::Some own_;
  Parameter parameter_;
  double size_;
  int threads_;
  std::vector<const detail::SegmentNumbers*> segments_;
  const Progress* progress_;
};

void require_options(const DerivativeOptions& options) {
  constexpr double kMinTolerance = 1e-13;  // below it rounding is larger
  if (!(options.relative_tolerance >= kMinTolerance && options.relative_tolerance <= 1)) {
    throw InvalidInput(
        fmt::format("relative_tolerance must be from {} to 1, got {}", kMinTolerance, options.relative_tolerance));
  }
}

detail::TangentOptions options_for(std::span<const Vec3d> points, const DerivativeOptions& options) {
  const double diagonal = options.diagonal.value_or(reference_length(points));
  return {absolute_tolerance(options.relative_tolerance, diagonal), options.relative_tolerance, options.threads,
          options.progress};
}

void require_gradient(std::span<const Vec3d> points, std::span<const Vec3d> gradient) {
  require_finite(points);
  require_finite(gradient);
  if (gradient.size() != points.size()) {
    throw InvalidInput(
        fmt::format("the gradient must have a vector for each of {} points, got {}", points.size(), gradient.size()));
  }
}

// Returns the numbers of each stroke's segments in the flow of all, ascending.
std::vector<std::vector<std::size_t>> segments_of_strokes(const ParameterStrokes& strokes, Direction direction,
                                                          int threads, const Progress* progress) {
  std::vector<std::vector<std::size_t>> segments(strokes.size());
  std::size_t next = 0;
  for (std::size_t k = 0; k < strokes.size(); ++k) {
    stop_if_cancelled(progress);
    const std::size_t i = direction == Direction::backwards ? strokes.size() - 1 - k : k;
    const ParameterStrokes::Some own = strokes.some({i});
    segments[i].resize(flow_of(with_values(own.session, {}), own.part, threads).segments.size());
    for (std::size_t& segment : segments[i]) segment = next++;
  }
  return segments;
}

// The derivatives of a segment's numbers with respect to one parameter.
struct ParameterRates {
  std::size_t parameter = 0;
  std::vector<double> numbers;
};

bool is_zero(double rate) { return rate == 0; }

}  // namespace

struct SessionDerivatives::Parts {
  std::size_t parameters = 0;
  Flow flow;
  std::vector<std::vector<ParameterRates>> rates;  // of each segment, of the parameters on which it depends, ascending

  std::vector<double> rates_along(std::span<const double> direction, std::size_t segment) const {
    std::vector<double> sum;
    for (const auto& [parameter, numbers] : rates[segment]) {
      if (direction[parameter] == 0) continue;
      if (sum.empty()) sum.resize(numbers.size());
      for (std::size_t n = 0; n < numbers.size(); ++n) sum[n] += direction[parameter] * numbers[n];
    }
    return sum;
  }

  // Of each segment, of each of its parameters.
  std::vector<std::vector<std::span<const double>>> spans() const {
    std::vector<std::vector<std::span<const double>>> result;
    for (const std::vector<ParameterRates>& of_segment : rates) {
      result.emplace_back();
      for (const ParameterRates& of_parameter : of_segment) result.back().emplace_back(of_parameter.numbers);
    }
    return result;
  }

  // Adds the rates of a parameter, of the segments of some strokes.
  void add(std::size_t parameter, FlowNumbers numbers, const std::vector<std::size_t>& segments) {
    for (std::size_t k = 0; k < segments.size(); ++k) {
      if (std::all_of(numbers[k].begin(), numbers[k].end(), is_zero)) continue;
      rates[segments[k]].push_back({parameter, std::move(numbers[k])});
    }
  }
};

SessionDerivatives::SessionDerivatives(const Session& session, const SessionPart& part, int threads,
                                       const Progress* progress) {
  auto parts = std::make_unique<Parts>();
  parts->parameters = session.parameters.size();
  ParameterStrokes strokes(session, part);
  for (std::size_t p = 0; p < parts->parameters; ++p) move_beside_nothing(strokes, p, threads, progress);
  parts->flow = flow_of(strokes.whole(), part, threads);
  validate(parts->flow);
  std::vector<detail::SegmentNumbers> segments;
  for (const Segment& segment : parts->flow.segments) segments.emplace_back(segment, progress);
  parts->rates.resize(segments.size());
  const std::vector<std::vector<std::size_t>> of_strokes =
      segments_of_strokes(strokes, part.direction, threads, progress);
  for (std::size_t p = 0; p < parts->parameters; ++p) {
    const std::vector<std::size_t> own = strokes.of(p);
    if (own.empty()) continue;
    std::vector<std::size_t> numbers;
    std::vector<const detail::SegmentNumbers*> of_own;
    of_own.reserve(segments.size());
    for (const std::size_t i : own) numbers.insert(numbers.end(), of_strokes[i].begin(), of_strokes[i].end());
    std::sort(numbers.begin(), numbers.end());
    for (const std::size_t segment : numbers) of_own.push_back(&segments[segment]);
    const double size = size_of(session.parameters[p]);
    const FlowOfParameter flow(strokes.some(own), strokes.parameter(p), size, threads, std::move(of_own), progress);
    parts->add(p, flow.derivatives(), numbers);
  }
  parts_ = std::move(parts);
}

SessionDerivatives::~SessionDerivatives() = default;

std::size_t SessionDerivatives::segments() const { return parts_->flow.segments.size(); }

PointTangents SessionDerivatives::jvp(std::span<const Vec3d> points, std::span<const double> direction,
                                      const DerivativeOptions& options) const {
  require_options(options);
  require_finite(points);
  if (direction.size() != parts_->parameters ||
      !std::all_of(direction.begin(), direction.end(), [](double number) { return std::isfinite(number); })) {
    throw InvalidInput(
        fmt::format("a direction must have a finite number for each of {} parameters", parts_->parameters));
  }
  PointTangents result{{points.begin(), points.end()}, std::vector<Vec3d>(points.size())};
  if (points.empty()) return result;
  const detail::TangentOptions follow = options_for(points, options);
  for (std::size_t i = 0; i < segments(); ++i) {
    const std::vector<double> along = parts_->rates_along(direction, i);
    detail::advect_tangents(parts_->flow.segments[i], along, result.points, result.tangents, follow);
  }
  return result;
}

SessionGradient SessionDerivatives::vjp(std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                                        const DerivativeOptions& options) const {
  require_options(options);
  require_gradient(points, gradient);
  SessionGradient result{{}, std::vector<double>(parts_->parameters, 0)};
  if (points.empty()) return result;
  const detail::TangentOptions follow = options_for(points, options);
  detail::FlowGradient found = detail::carry_back(parts_->flow, parts_->spans(), points, gradient, follow);
  result.points = std::move(found.points);
  for (std::size_t i = 0; i < segments(); ++i) {
    const std::vector<ParameterRates>& of_segment = parts_->rates[i];
    for (std::size_t k = 0; k < of_segment.size(); ++k) {
      result.parameters[of_segment[k].parameter] += found.variables[i][k];
    }
  }
  return result;
}

FlowCoefficients coefficients_of(const Flow& flow) {
  FlowCoefficients result;
  for (const Segment& segment : flow.segments) {
    std::vector<Vec3d>& own = result.emplace_back();
    for (const SharedVectors* list :
         {&segment.lattice.displacements, &segment.grid.coefficients, &segment.grid.end_coefficients}) {
      own.insert(own.end(), list->begin(), list->end());
    }
  }
  return result;
}

PointTangents coefficient_jvp(const Flow& flow, std::span<const Vec3d> points, const FlowCoefficients& direction,
                              const DerivativeOptions& options) {
  validate(flow);
  require_options(options);
  require_finite(points);
  const auto fits = [](const Segment& segment, const std::vector<Vec3d>& own) {
    return own.size() == detail::count_coefficients(segment);
  };
  if (!std::equal(flow.segments.begin(), flow.segments.end(), direction.begin(), direction.end(), fits)) {
    throw InvalidInput("the direction must have a vector for each coefficient of each segment");
  }
  for (const std::vector<Vec3d>& own : direction) require_finite(own);
  PointTangents result{{points.begin(), points.end()}, std::vector<Vec3d>(points.size())};
  if (points.empty()) return result;
  const detail::TangentOptions follow = options_for(points, options);
  for (std::size_t i = 0; i < direction.size(); ++i) {
    const Segment& segment = flow.segments[i];
    if (direction[i].empty()) {
      detail::advect_tangents(segment, {}, result.points, result.tangents, follow);
    } else {
      detail::advect_tangents_by_coefficients(segment, direction[i], result.points, result.tangents, follow);
    }
  }
  return result;
}

CoefficientGradient coefficient_vjp(const Flow& flow, std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                                    const DerivativeOptions& options) {
  validate(flow);
  require_options(options);
  require_gradient(points, gradient);
  const detail::TangentOptions follow = points.empty() ? detail::TangentOptions{} : options_for(points, options);
  detail::FlowGradient found = detail::carry_back_to_coefficients(flow, points, gradient, follow);
  CoefficientGradient result{std::move(found.points), {}};
  for (const std::vector<double>& numbers : found.variables) {
    std::vector<Vec3d>& own = result.coefficients.emplace_back();
    for (std::size_t n = 0; n < numbers.size(); n += 3) own.push_back({numbers[n], numbers[n + 1], numbers[n + 2]});
  }
  return result;
}

}  // namespace knead
