// Derivatives of a deformation with respect to the parameters of its session.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "flow/tangents.h"
#include "knead/derivatives.h"
#include "knead/error.h"

namespace knead {

namespace {

using detail::kTangents;

// The numbers of each segment of a flow, or their derivatives with respect to one parameter.
using FlowNumbers = std::vector<std::vector<double>>;

// About how much a parameter may change: its value, or its bounds.
double size_of(const Parameter& parameter) {
  const double value = std::abs(parameter.value);
  if (value > 0) return value;
  const double most = std::max(std::abs(parameter.least.value_or(0)), std::abs(parameter.greatest.value_or(0)));
  return most > 0 ? most : 1;
}

Session without_bounds(Session session) {
  for (Parameter& parameter : session.parameters) {
    parameter.least.reset();
    parameter.greatest.reset();
  }
  return session;
}

// A stroke that does nothing at a value, such as a path of length 0, has no segments there, but has some beside it:
// then the parameter is moved by this part of its size.
constexpr double kNudge = 1e-11;

Session beside_nothing(const Session& session, const SessionPart& part, int threads, const Progress* progress) {
  Session result = without_bounds(session);
  for (std::size_t p = 0; p < session.parameters.size(); ++p) {
    const Parameter& parameter = session.parameters[p];
    const auto at = [&](double step) {
      return with_values(result, {{parameter.name, parameter.value + step * size_of(parameter)}});
    };
    const auto count = [&](double step) -> std::optional<std::size_t> {
      stop_if_cancelled(progress);
      try {
        return flow_of(at(step), part, threads).segments.size();
      } catch (const InvalidInput&) {
        return std::nullopt;
      }
    };
    const std::optional<std::size_t> after = count(kNudge);
    if (after && count(-kNudge) == after && count(0) != after) result = at(kNudge);
  }
  return result;
}

// Of a parameter's own size: the first steps of its differences. Smaller ones are tried where a flow does not exist, or
// has other segments, so far away.
constexpr std::array<double, 6> kSteps{0.02, 0.005, 1e-3, 1e-4, 1e-5, 1e-6};
constexpr std::size_t kCentralLevels = 4;  // of halved steps: the error falls with the eighth power of the step
constexpr std::size_t kSidedLevels = 7;    // with the seventh
// Relative to the greatest derivative: what is good enough at once, and what a derivative has to reach.
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

// The flow of a session as a function of one parameter.
class FlowOfParameter {
 public:
  // The session has no bounds: differences pass them. `size`: of the parameter.
  FlowOfParameter(const Session& session, std::size_t parameter, double size, const SessionPart& part, int threads,
                  const std::vector<detail::SegmentNumbers>& segments, const Progress* progress)
      : session_(session),
        parameter_(session.parameters[parameter]),
        size_(size),
        part_(part),
        threads_(threads),
        segments_(segments),
        progress_(progress) {}

  // The derivatives at the parameter's value; all zero for a parameter that no stroke names.
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
        Place{session_.name},
        fmt::format(
            "the flow has no derivative with respect to \"{}\" at {}: it chooses a whole number or the number of "
            "segments there, or is in a mask, a grid, a curve, or what reads the surface",
            parameter_.name, parameter_.value));
  }

 private:
  // Nothing where there is no flow, or one that is not alike.
  std::optional<FlowNumbers> at(double step) const {
    stop_if_cancelled(progress_);
    Flow flow;
    try {
      flow = flow_of(with_values(session_, {{parameter_.name, parameter_.value + step}}), part_, threads_);
    } catch (const InvalidInput&) {
      return std::nullopt;
    }
    if (flow.segments.size() != segments_.size()) return std::nullopt;
    FlowNumbers numbers;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      std::optional<std::vector<double>> of_segment = segments_[i].of(flow.segments[i]);
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

  const Session& session_;
  Parameter parameter_;
  double size_;
  const SessionPart& part_;
  int threads_;
  const std::vector<detail::SegmentNumbers>& segments_;
  const Progress* progress_;
};

void require_options(const DerivativeOptions& options) {
  constexpr double kMinTolerance = 1e-13;  // below it rounding is larger
  if (!(options.relative_tolerance >= kMinTolerance && options.relative_tolerance <= 1)) {
    throw InvalidInput(
        fmt::format("relative_tolerance must be from {} to 1, got {}", kMinTolerance, options.relative_tolerance));
  }
}

}  // namespace

struct SessionDerivatives::Parts {
  std::size_t parameters = 0;
  Flow flow;
  std::vector<FlowNumbers> rates;  // of each parameter and segment; of one that does not change empty

  // Follows points, and their derivatives along up to kTangents directions in the space of the parameters.
  void follow(const std::vector<std::vector<double>>& directions, const detail::TangentPoints& points,
              const DerivativeOptions& options) const {
    const double diagonal = options.diagonal.value_or(reference_length(std::span<const Vec3d>(points.points)));
    detail::TangentOptions follow;
    follow.tolerance = absolute_tolerance(options.relative_tolerance, diagonal);
    follow.relative_tolerance = options.relative_tolerance;
    follow.threads = options.threads;
    follow.progress = options.progress;
    for (std::size_t i = 0; i < flow.segments.size(); ++i) {
      std::array<std::vector<double>, kTangents> along;
      for (std::size_t k = 0; k < directions.size(); ++k) along[k] = rates_along(directions[k], i);
      const detail::SegmentRates own{along[0], along[1], along[2]};
      detail::advect_tangents(flow.segments[i], own, points, follow);
    }
  }

  std::vector<double> rates_along(const std::vector<double>& direction, std::size_t segment) const {
    std::vector<double> sum;
    for (std::size_t p = 0; p < parameters; ++p) {
      const std::vector<double>& own = rates[p][segment];
      if (direction[p] == 0 || own.empty()) continue;
      if (sum.empty()) sum.resize(own.size());
      for (std::size_t n = 0; n < own.size(); ++n) sum[n] += direction[p] * own[n];
    }
    return sum;
  }
};

SessionDerivatives::SessionDerivatives(const Session& session, const SessionPart& part, int threads,
                                       const Progress* progress) {
  auto parts = std::make_unique<Parts>();
  parts->parameters = session.parameters.size();
  const Session beside = beside_nothing(session, part, threads, progress);
  parts->flow = flow_of(beside, part, threads);
  validate(parts->flow);
  std::vector<detail::SegmentNumbers> segments;
  for (const Segment& segment : parts->flow.segments) segments.emplace_back(segment, progress);
  for (std::size_t p = 0; p < session.parameters.size(); ++p) {
    const double size = size_of(session.parameters[p]);
    FlowNumbers rates = FlowOfParameter(beside, p, size, part, threads, segments, progress).derivatives();
    for (std::vector<double>& of_segment : rates) {
      if (std::all_of(of_segment.begin(), of_segment.end(), [](double rate) { return rate == 0; })) of_segment.clear();
    }
    parts->rates.push_back(std::move(rates));
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
  std::vector<Vec3d> none(2 * points.size());
  const auto [first, last] = std::pair(std::span(none).first(points.size()), std::span(none).last(points.size()));
  parts_->follow({{direction.begin(), direction.end()}}, {result.points, {result.tangents, first, last}}, options);
  return result;
}

std::vector<double> SessionDerivatives::vjp(std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                                            const DerivativeOptions& options) const {
  require_options(options);
  require_finite(points);
  require_finite(gradient);
  if (gradient.size() != points.size()) {
    throw InvalidInput(
        fmt::format("the gradient must have a vector for each of {} points, got {}", points.size(), gradient.size()));
  }
  std::vector<double> result(parts_->parameters, 0);
  for (std::size_t first = 0; first < result.size() && !points.empty(); first += kTangents) {
    const std::size_t count = std::min(kTangents, result.size() - first);
    std::vector<std::vector<double>> directions(count, std::vector<double>(result.size(), 0));
    for (std::size_t k = 0; k < count; ++k) directions[k][first + k] = 1;
    std::vector<Vec3d> moved(points.begin(), points.end());
    std::array<std::vector<Vec3d>, kTangents> tangents;
    for (std::vector<Vec3d>& of_one : tangents) of_one.resize(points.size());
    parts_->follow(directions, {moved, {tangents[0], tangents[1], tangents[2]}}, options);
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t i = 0; i < points.size(); ++i) result[first + k] += dot(gradient[i], tangents[k][i]);
    }
  }
  return result;
}

}  // namespace knead
