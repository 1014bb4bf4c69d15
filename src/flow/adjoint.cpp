// Path lines followed forwards with their steps, and the gradient carried back through these.
#include "flow/tangents.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "flow/curve_map.h"
#include "flow/tangent_line.h"
#include "flow/taped.h"
#include "flow/varying_fields.h"
#include "knead/error.h"

namespace knead::detail {
namespace {

// One point's way through one segment.
struct Passage {
  std::size_t segment = 0;
  unsigned parts = 0;  // that move it, as bits
  Vec3d begin;
  Vec3d end;
  std::array<Vec3d, 3> columns;    // of the Jacobian
  std::vector<TangentStep> steps;  // if numbers are wanted
};

// Gives one number after the other: those that are wanted as variables.
class NextTaped {
 public:
  NextTaped(const WantedNumbers& wanted, Tape& tape) : wanted_(wanted), tape_(tape) {}

  Taped operator()(double number) {
    numbers_.push_back(wanted_[numbers_.size()] ? tape_.variable(number) : Taped(number));
    return numbers_.back();
  }
  const std::vector<Taped>& numbers() const { return numbers_; }

 private:
  const WantedNumbers& wanted_;
  Tape& tape_;
  std::vector<Taped> numbers_;
};

// The numbers of a segment on a tape, and the steps of a point back through its velocity.
class StepsBack {
 public:
  StepsBack(const TangentLine& line, const WantedNumbers& wanted, const Segment& segment, Tape& tape)
      : tape_(tape), next_(wanted, tape) {
    tape_.clear();
    next_(segment.begin);
    next_(segment.end);
    for (const auto& part : line.parts()) fields_.emplace_back(*part, next_);
    variables_ = tape_.size();  // NOLINT(cppcoreguidelines-prefer-member-initializer): after the fields
  }

  // From the gradient after the step to that before it: the transpose of the step's derivative. Adds up the gradient
  // with respect to the numbers.
  void go(const TangentStep& step, unsigned parts, Vec3d& gradient) {
    const Tableau& method = tableau(Integrator::tsitouras);
    std::array<Vec3d, Tableau::kMaxStages> by_place{};
    for (int i = method.stages - 1; i >= 0; --i) {
      Vec3d by_slope = gradient * (step.h * method.b[i]);
      for (int j = i + 1; j < method.stages; ++j) by_slope += by_place[j] * (step.h * method.a[j][i]);
      if (by_slope != Vec3d{}) by_place[i] = go_through(step.places[i], step.t + step.h * method.c[i], parts, by_slope);
    }
    for (const Vec3d& of_stage : by_place) gradient += of_stage;
  }

  void add_to(std::vector<double>& numbers) const {
    for (std::size_t n = 0; n < numbers.size(); ++n) numbers[n] += tape_.derivative(next_.numbers()[n]);
  }

 private:
  Vec3d go_through(const Vec3d& place, double t, unsigned parts, const Vec3d& by_velocity) {
    tape_.truncate(variables_);
    Vec3<Taped> x;
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis] = tape_.variable(place[axis]);
    Vec3<Taped> v;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if ((parts >> i & 1U) != 0) v += fields_[i].velocity(x, t);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) tape_.add(v[axis], by_velocity[axis]);
    tape_.carry_back(variables_);
    return {tape_.derivative(x.x), tape_.derivative(x.y), tape_.derivative(x.z)};
  }

  Tape& tape_;
  NextTaped next_;
  std::vector<VaryingFields<Taped>> fields_;  // of the parts
  std::size_t variables_ = 0;
};

// One segment forwards and backwards.
class SegmentAdjoint {
 public:
  SegmentAdjoint(const Segment& segment, const WantedNumbers& wanted, const TangentOptions& options)
      : segment_(segment), wanted_(wanted) {
    if (segment.curve.is_empty()) {
      line_ = std::make_unique<const TangentLine>(segment, SegmentRates{}, options);
    } else {
      curve_.emplace(without_acting_mask(segment));
    }
  }

  // Moves a point; returns whether the gradient changes on the way back.
  bool move(Vec3d& x, Passage& passage) const {
    const Mat3d unit;
    TangentState state{x, unit.row0, unit.row1, unit.row2};
    const TangentState start = state;
    if (curve_) {
      Mat3d jacobian;
      curve_->move(state[0], jacobian);
      for (std::size_t k = 0; k < 3; ++k) state[1 + k] = jacobian.column(k);
    } else {
      passage.parts = line_->move(state, wanted_.empty() ? nullptr : &passage.steps);
      if (passage.parts == 0) return false;
    }
    passage.begin = x;
    passage.end = state[0];
    passage.columns = {state[1], state[2], state[3]};
    x = state[0];
    return state != start || !passage.steps.empty() || wants_end(0) || wants_end(1);
  }

  // Carries the gradient back, and adds its part with respect to the wanted numbers.
  void go_back(const Passage& passage, Vec3d& gradient, std::vector<double>& numbers, Tape& tape) const {
    if (wants_end(1)) numbers[1] += dot(gradient, velocity(passage, passage.end, segment_.end));
    if (passage.steps.empty()) {
      const auto& [x, y, z] = passage.columns;
      gradient = {dot(x, gradient), dot(y, gradient), dot(z, gradient)};
    } else {
      StepsBack back(*line_, wanted_, segment_, tape);
      for (auto step = passage.steps.rbegin(); step != passage.steps.rend(); ++step) {
        back.go(*step, passage.parts, gradient);
      }
      back.add_to(numbers);
    }
    if (wants_end(0)) numbers[0] -= dot(gradient, velocity(passage, passage.begin, segment_.begin));
  }

 private:
  bool wants_end(std::size_t end) const { return !wanted_.empty() && wanted_[end]; }

  Vec3d velocity(const Passage& passage, const Vec3d& x, double t) const {
    if (curve_) return curve_velocities(segment_.curve, std::span(&x, 1), t).front();
    return line_->velocity(x, t, passage.parts);
  }

  const Segment& segment_;
  const WantedNumbers& wanted_;
  std::unique_ptr<const TangentLine> line_;  // null for a curve
  std::optional<CurveMap> curve_;
};

// Points are summed in blocks, and the blocks in turn.
constexpr std::size_t kMostBlocks = 256;
constexpr std::size_t kLeastPointsOfBlock = 16;

class FlowAdjoint {
 public:
  FlowAdjoint(const Flow& flow, const std::vector<WantedNumbers>& wanted, const TangentOptions& options)
      : wanted_(wanted), options_(options) {
    for (std::size_t i = 0; i < flow.segments.size(); ++i) {
      segments_.push_back(std::make_unique<const SegmentAdjoint>(flow.segments[i], wanted[i], options));
    }
  }

  std::vector<std::vector<double>> no_numbers() const {
    std::vector<std::vector<double>> numbers;
    for (const WantedNumbers& wanted : wanted_) numbers.emplace_back(wanted.size(), 0.0);
    return numbers;
  }

  // Returns the gradient with respect to the point, and adds that with respect to the numbers.
  Vec3d carry_back(Vec3d x, Vec3d gradient, std::vector<std::vector<double>>& numbers, Tape& tape) const {
    std::vector<Passage> passages;
    if (gradient != Vec3d{}) {
      for (std::size_t i = 0; i < segments_.size(); ++i) {
        Passage passage;
        passage.segment = i;
        if (segments_[i]->move(x, passage)) passages.push_back(std::move(passage));
      }
    }
    for (std::size_t i = passages.size(); i-- > 0;) {
      const Passage& passage = passages[i];
      segments_[passage.segment]->go_back(passage, gradient, numbers[passage.segment], tape);
      stop_if_cancelled(options_.progress);
    }
    if (options_.progress != nullptr) options_.progress->done += segments_.size();
    return gradient;
  }

 private:
  const std::vector<WantedNumbers>& wanted_;
  const TangentOptions& options_;
  std::vector<std::unique_ptr<const SegmentAdjoint>> segments_;
};

}  // namespace

FlowGradient carry_back(const Flow& flow, const std::vector<WantedNumbers>& wanted, std::span<const Vec3d> points,
                        std::span<const Vec3d> gradient, const TangentOptions& options) {
  const FlowAdjoint adjoint(flow, wanted, options);
  FlowGradient result{std::vector<Vec3d>(points.size()), adjoint.no_numbers()};
  const std::size_t of_block = std::max(kLeastPointsOfBlock, (points.size() + kMostBlocks - 1) / kMostBlocks);
  std::vector<std::vector<std::vector<double>>> blocks((points.size() + of_block - 1) / of_block);
  parallel_for(points.size(), of_block, options.threads, [&](std::size_t begin, std::size_t end) {
    Tape tape;
    std::vector<std::vector<double>>& numbers = blocks[begin / of_block];
    numbers = adjoint.no_numbers();
    for (std::size_t i = begin; i < end; ++i) {
      stop_if_cancelled(options.progress);
      result.points[i] = adjoint.carry_back(points[i], gradient[i], numbers, tape);
    }
  });
  for (const auto& block : blocks) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      for (std::size_t n = 0; n < block[i].size(); ++n) result.numbers[i][n] += block[i][n];
    }
  }
  return result;
}

}  // namespace knead::detail
