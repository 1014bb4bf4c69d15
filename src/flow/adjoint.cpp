// The gradient with respect to points and variables, carried back through a flow. Each segment is followed with its own
// Jacobian and the derivatives by its own variables, many points side by side; then the gradient goes back from segment
// to segment. Where a segment has many variables, it goes back through the steps of each path line instead.
#include "flow/tangents.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "flow/culling.h"
#include "flow/path_jacobian.h"
#include "flow/segment_map.h"
#include "flow/segment_mover.h"
#include "flow/tangent_line.h"
#include "flow/taped.h"
#include "flow/varying_fields.h"
#include "knead/error.h"
#include "math/geometry.h"

namespace knead::detail {
namespace {

// The passage of one point through one segment.
struct Passage {
  std::size_t segment = 0;
  unsigned parts = 0;  // that move it, as bits
  Vec3d begin;
  Vec3d end;
  std::array<Vec3d, 3> columns;    // of the Jacobian
  std::vector<TangentStep> steps;  // if numbers are wanted
};

// Returns one number after the other, the wanted ones as variables.
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

// The first numbers of a segment: begin and end.
constexpr std::size_t kEnds = 2;

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
    if (is_map(segment)) {
      map_.emplace(segment);
      return;
    }
    line_ = std::make_unique<const TangentLine>(segment, SegmentRates{}, options);
  }

  // Moves a point; returns whether the segment changes the gradient.
  bool move(Vec3d& x, Passage& passage) const {
    const Mat3d unit;
    TangentState state{x, unit.row0, unit.row1, unit.row2};
    const TangentState start = state;
    if (map_) {
      Mat3d jacobian;
      map_->move(state[0], jacobian);
      for (std::size_t k = 0; k < 3; ++k) state[1 + k] = jacobian.column(k);
    } else {
      passage.parts = line_->move(state, wanted_.empty() ? nullptr : &passage.steps);
      if (passage.parts == 0) return false;
    }
    passage.begin = x;
    passage.end = state[0];
    passage.columns = {state[1], state[2], state[3]};
    x = state[0];
    return state != start || !passage.steps.empty() || wants_end(0) || wants_end(1) || wants_lattice();
  }

  // Carries the gradient back, and adds its part with respect to the wanted numbers.
  void go_back(const Passage& passage, Vec3d& gradient, std::vector<double>& numbers, Tape& tape) const {
    if (wants_end(1)) numbers[1] += dot(gradient, velocity(passage, passage.end, segment_.end));
    if (passage.steps.empty()) {
      const auto& [x, y, z] = passage.columns;
      if (wants_lattice()) {
        const Mat3d jacobian{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
        map_->lattice()->add_gradient(passage.begin, jacobian, gradient, std::span(numbers).subspan(kEnds));
      }
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
  bool wants_lattice() const { return map_ && map_->lattice() != nullptr && wanted_.size() > kEnds; }

  Vec3d velocity(const Passage& passage, const Vec3d& x, double t) const {
    if (map_) return map_velocities(segment_, std::span(&x, 1), t).front();
    return line_->velocity(x, t, passage.parts);
  }

  const Segment& segment_;
  const WantedNumbers& wanted_;
  std::unique_ptr<const TangentLine> line_;  // null for a map in closed form
  std::optional<SegmentMap> map_;
};

// Points are summed in tasks, and these in turn. A task carries its points in chunks of neighbours, whose blocks are
// culled.
constexpr std::size_t kMaxTasks = 256;
constexpr std::size_t kMaxSums = std::size_t{1} << 26;  // of all tasks
constexpr std::size_t kPointsOfChunk = 1024;
constexpr std::size_t kMinPointsOfChunk = 64;
constexpr std::size_t kPointsOfCull = 64;
constexpr std::size_t kMaxPassages = std::size_t{1} << 20;  // that a chunk may hold
// With more variables than this a segment's gradient goes back through its steps.
constexpr std::size_t kMaxVariablesForwards = 4 * kTangents;

// A segment with a grid whose coefficients are wanted. The points go through it without derivatives, and come back with
// their gradient.
class GridGradient {
 public:
  GridGradient(const Segment& segment, const TangentOptions& options, const AdvectOptions& advect_options)
      : advect_options_(advect_options),
        there_(make_segment_mover(segment, advect_options)),
        inverse_(inverse(Flow{{segment}}).segments.front()),
        back_(inverse_, advect_options, {.jacobian_tolerance = options.relative_tolerance}),
        cells_(segment.grid),
        sets_(segment.grid.end_coefficients.empty() ? 1 : 2) {
    const Vec3d beside = Vec3d{1, 1, 1} * (kSplineReach * segment.grid.spacing);
    const auto [nx, ny, nz] = segment.grid.counts;
    const Vec3d size = Vec3d{nx - 1.0, ny - 1.0, nz - 1.0} * segment.grid.spacing;
    box_ = {segment.grid.origin - beside, segment.grid.origin + size + beside};
  }

  std::size_t sums() const { return 3 * sets_ * cells_.used().size(); }

  // Returns whether a coefficient acts at x, also if it is 0.
  bool reaches(const Vec3d& x) const { return contains(box_, x); }

  // Moves at most kPointsOfChunk points.
  void move(std::span<Vec3d> points) const {
    static_assert(kPointsOfChunk <= kGroup);
    std::vector<double> numbers(3 * kGroup);
    std::array<std::uint64_t, kBlocksPerGroup> members{};
    std::array<std::uint16_t, kBlocksPerGroup> blocks{};
    std::array<double, kBlocksPerGroup> moved{};
    std::vector<std::uint32_t> steps(kGroup);
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis * kGroup + i] = points[i][axis];
      members[i / kBlock] |= std::uint64_t{1} << i % kBlock;
    }
    LiveGroup group;
    group.points = {numbers.data(), numbers.data() + kGroup, numbers.data() + 2 * kGroup};
    group.members = members.data();
    group.blocks = blocks.data();
    for (std::size_t i = 0; i < points.size(); i += kBlock) {
      blocks[static_cast<std::size_t>(group.block_count++)] = static_cast<std::uint16_t>(i / kBlock);
    }
    group.steps = steps.data();
    group.moved = moved.data();
    group.stop.asked = advect_options_.progress;
    group.stop.ask = [](const void* progress, std::uint64_t /*evaluations*/) {
      return progress != nullptr && static_cast<const Progress*>(progress)->cancel.load();
    };
    const bool is_complete = there_(group).complete;
    stop_if_cancelled(advect_options_.progress);
    if (!is_complete) refuse_path_line();
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = {numbers[i], numbers[kGroup + i], numbers[2 * kGroup + i]};
    }
  }

  // Replaces the gradients at the ends of path lines by those at their beginnings.
  void go_back(std::span<Vec3d> ends, std::span<Vec3d> gradients, std::vector<double>& sums) const {
    back_.carry_back(ends, gradients, sums);
  }

  // Returns three numbers a coefficient.
  std::vector<double> coefficients(const std::vector<double>& sums) const { return cells_.from_planes(sums); }

 private:
  static constexpr double kSplineReach = 2;  // spacings beyond the nodes

  const AdvectOptions& advect_options_;
  SegmentMover there_;
  Segment inverse_;
  SegmentJacobians back_;
  GridCells cells_;
  std::size_t sets_;  // of coefficients
  Box box_;
};

// The derivatives of the numbers of a segment with respect to its variables.
using VariableRates = std::vector<std::span<const double>>;
// Of each segment: of its variables, or of its numbers where the gradient goes back through steps.
using Sums = std::vector<std::vector<double>>;

// Returns that the displacements of a lattice are wanted, its numbers after its ends; nothing of another segment.
WantedNumbers wanted_displacements(const Segment& segment) {
  const std::size_t count = segment.lattice.displacements.size();
  WantedNumbers wanted(count == 0 ? 0 : kEnds + 3 * count, true);
  std::fill_n(wanted.begin(), std::min(kEnds, wanted.size()), false);
  return wanted;
}

// Returns which numbers some variable changes.
WantedNumbers wanted_numbers(const VariableRates& rates) {
  WantedNumbers wanted;
  for (const std::span<const double> of_variable : rates) {
    wanted.resize(of_variable.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = wanted[i] || of_variable[i] != 0;
  }
  return wanted;
}

// Neighbouring points during the forward pass, and their gradient during the backward pass.
struct Chunk {
  std::vector<std::size_t> order;  // the numbers of the points
  std::vector<Vec3d> points;
  std::vector<Vec3d> gradient;
  std::vector<std::pair<Box, bool>> boxes;  // of kPointsOfCull points each; whether these have moved since
};

// The effect of a segment on some points of a chunk.
struct ChunkPassage {
  std::size_t segment = 0;
  std::vector<std::size_t> who;
  std::vector<Mat3d> jacobians;
  std::vector<Vec3d> tangents;    // as many as variables for each
  std::vector<Passage> by_steps;  // in their place
  std::vector<Vec3d> ends;        // through a grid whose coefficients are wanted
};

// One segment for chunks of points.
class SegmentGradient {
 public:
  // `by_coefficients`: the gradient with respect to these is wanted, and there are no rates.
  SegmentGradient(const Segment& segment, const VariableRates& rates, bool by_coefficients,
                  const TangentOptions& tangent_options, const AdvectOptions& options)
      : culling_(segment),
        variables_(rates.size()),
        wanted_(by_coefficients ? wanted_displacements(segment) : wanted_numbers(rates)) {
    if (by_coefficients && !segment.grid.is_empty()) {
      grid_ = std::make_unique<const GridGradient>(segment, tangent_options, options);
      return;
    }
    const bool by_limit_cylinders = !segment.parts.empty() && has_limit_cylinders(segment);
    if (is_map(segment) || by_limit_cylinders || variables_ > kMaxVariablesForwards) {
      by_steps_ = std::make_unique<const SegmentAdjoint>(segment, wanted_, tangent_options);
      return;
    }
    const WantedJacobian wanted{.jacobian_tolerance = tangent_options.relative_tolerance};
    for (std::size_t first = 0; first < std::max<std::size_t>(variables_, 1); first += kTangents) {
      SegmentRates some{};
      for (std::size_t k = 0; k < kTangents && first + k < variables_; ++k) some[k] = rates[first + k];
      maps_.push_back(std::make_unique<const SegmentJacobians>(segment, options, wanted, some));
    }
  }

  std::size_t sums() const {
    if (grid_ != nullptr) return grid_->sums();
    return by_steps_ != nullptr ? wanted_.size() : variables_;
  }
  bool goes_by_steps() const { return by_steps_ != nullptr; }

  // Returns the gradient with respect to the coefficients, three numbers for each.
  std::vector<double> coefficients(std::vector<double> sums) const {
    if (grid_ != nullptr) return grid_->coefficients(sums);
    if (!sums.empty()) sums.erase(sums.begin(), sums.begin() + kEnds);
    return sums;
  }

  ChunkPassage move(Chunk& chunk) const {
    ChunkPassage passage;
    for (std::size_t block = 0; block < chunk.boxes.size(); ++block) {
      const std::size_t begin = block * kPointsOfCull;
      const std::size_t end = std::min(begin + kPointsOfCull, chunk.points.size());
      auto& [box, has_moved] = chunk.boxes[block];
      if (has_moved) box = bounding_box(std::span(chunk.points).subspan(begin, end - begin));
      has_moved = false;
      const Surround ball{(box.min + box.max) * 0.5, norm(box.max - box.min) * (0.5 + 1e-12)};
      if (grid_ == nullptr && culling_.misses(ball)) continue;
      for (std::size_t i = begin; i < end; ++i) {
        if (chunk.gradient[i] == Vec3d{} || (grid_ != nullptr && !grid_->reaches(chunk.points[i]))) continue;
        passage.who.push_back(i);
      }
    }
    if (grid_ != nullptr) {
      move_through_grid(chunk, passage);
    } else {
      by_steps_ != nullptr ? move_by_steps(chunk, passage) : move_side_by_side(chunk, passage);
    }
    for (const std::size_t i : passage.who) chunk.boxes[i / kPointsOfCull].second = true;
    return passage;
  }

  void go_back(ChunkPassage& passage, Chunk& chunk, std::vector<double>& sums, Tape& tape) const {
    if (grid_ != nullptr) {
      std::vector<Vec3d> gradients;
      for (const std::size_t i : passage.who) gradients.push_back(chunk.gradient[i]);
      grid_->go_back(passage.ends, gradients, sums);
      for (std::size_t k = 0; k < gradients.size(); ++k) chunk.gradient[passage.who[k]] = gradients[k];
      return;
    }
    for (std::size_t k = 0; k < passage.who.size(); ++k) {
      Vec3d& gradient = chunk.gradient[passage.who[k]];
      if (by_steps_ != nullptr) {
        by_steps_->go_back(passage.by_steps[k], gradient, sums, tape);
        continue;
      }
      for (std::size_t v = 0; v < variables_; ++v) sums[v] += dot(gradient, passage.tangents[k * variables_ + v]);
      const Mat3d& jacobian = passage.jacobians[k];
      gradient = {dot(jacobian.column(0), gradient), dot(jacobian.column(1), gradient),
                  dot(jacobian.column(2), gradient)};
    }
  }

 private:
  void move_through_grid(Chunk& chunk, ChunkPassage& passage) const {
    for (const std::size_t i : passage.who) passage.ends.push_back(chunk.points[i]);
    grid_->move(passage.ends);
    for (std::size_t k = 0; k < passage.who.size(); ++k) chunk.points[passage.who[k]] = passage.ends[k];
  }

  void move_by_steps(Chunk& chunk, ChunkPassage& passage) const {
    std::vector<std::size_t> reached;
    for (const std::size_t i : passage.who) {
      Passage own;
      if (!by_steps_->move(chunk.points[i], own)) continue;
      reached.push_back(i);
      passage.by_steps.push_back(std::move(own));
    }
    passage.who = std::move(reached);
  }

  // Finds the points that the segment reaches, with the times from which on, and those that it moves in closed form.
  std::vector<JacobianStart> meet(const Chunk& chunk, ChunkPassage& passage, std::vector<Vec3d>& points) const {
    std::vector<JacobianStart> starts;
    std::vector<std::size_t> reached;
    for (const std::size_t i : passage.who) {
      Mat3d jacobian;
      Vec3d x = chunk.points[i];
      const std::optional<double> t = maps_.front()->meet(x, jacobian);
      if (!t && x == chunk.points[i]) continue;
      if (t) starts.push_back({reached.size(), *t});
      reached.push_back(i);
      points.push_back(x);
      passage.jacobians.push_back(jacobian);
    }
    passage.who = std::move(reached);
    passage.tangents.resize(passage.who.size() * variables_);
    return starts;
  }

  void move_side_by_side(Chunk& chunk, ChunkPassage& passage) const {
    std::vector<Vec3d> points;
    const std::vector<JacobianStart> starts = meet(chunk, passage, points);
    const std::vector<Vec3d> at_start = points;
    const std::vector<Mat3d> no_jacobians = passage.jacobians;
    for (std::size_t m = maps_.size(); m-- > 0;) {  // the first at last: its points and Jacobians count
      points = at_start;
      passage.jacobians = no_jacobians;
      const std::size_t count = maps_[m]->variables();
      std::vector<Vec3d> tangents(points.size() * count);
      maps_[m]->move(starts, points, passage.jacobians, tangents);
      for (std::size_t k = 0; k < points.size(); ++k) {
        const std::span<Vec3d> own = std::span(tangents).subspan(k * count, count);
        maps_[m]->add_shifts(chunk.points[passage.who[k]], points[k], passage.jacobians[k], own);
        std::copy(own.begin(), own.end(), passage.tangents.begin() + at(k * variables_ + m * kTangents));
      }
    }
    for (std::size_t k = 0; k < points.size(); ++k) chunk.points[passage.who[k]] = points[k];
  }

  static std::ptrdiff_t at(std::size_t i) { return static_cast<std::ptrdiff_t>(i); }

  Culling culling_;
  std::size_t variables_;
  WantedNumbers wanted_;
  std::vector<std::unique_ptr<const SegmentJacobians>> maps_;  // one for every kTangents variables
  std::unique_ptr<const SegmentAdjoint> by_steps_;
  std::unique_ptr<const GridGradient> grid_;  // of which coefficients that are 0 have a gradient, too
};

class FlowAdjoint {
 public:
  // `rates`: null for the gradient with respect to coefficients.
  FlowAdjoint(const Flow& flow, const std::vector<VariableRates>* rates, const TangentOptions& options)
      : options_(options) {
    advect_options_.tolerance = options.tolerance;
    advect_options_.precision = Precision::float64;
    advect_options_.progress = options.progress;
    for (std::size_t i = 0; i < flow.segments.size(); ++i) {
      segments_.push_back(std::make_unique<const SegmentGradient>(flow.segments[i],
                                                                  rates == nullptr ? VariableRates{} : (*rates)[i],
                                                                  rates == nullptr, options_, advect_options_));
    }
  }
  FlowAdjoint(const FlowAdjoint&) = delete;
  FlowAdjoint& operator=(const FlowAdjoint&) = delete;
  ~FlowAdjoint() = default;

  Sums zero_sums() const {
    Sums sums;
    for (const auto& segment : segments_) sums.emplace_back(segment->sums(), 0.0);
    return sums;
  }

  bool goes_by_steps(std::size_t segment) const { return segments_[segment]->goes_by_steps(); }
  std::vector<double> coefficients(std::size_t segment, std::vector<double> sums) const {
    return segments_[segment]->coefficients(std::move(sums));
  }

  // Returns the number of tasks: each has sums of its own.
  std::size_t most_tasks() const {
    std::size_t numbers = 1;
    for (const auto& segment : segments_) numbers += segment->sums();
    return std::clamp<std::size_t>(kMaxSums / numbers, 1, kMaxTasks);
  }

  std::size_t points_of_chunk() const {
    const std::size_t most = kMaxPassages / std::max<std::size_t>(segments_.size(), 1);
    return std::clamp(most / kPointsOfCull * kPointsOfCull, kMinPointsOfChunk, kPointsOfChunk);
  }

  // Replaces the gradient by that before the flow, and adds those with respect to the variables.
  void carry_back(Chunk& chunk, Sums& sums, Tape& tape) const {
    std::vector<ChunkPassage> passages;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      stop_if_cancelled(options_.progress);
      ChunkPassage passage = segments_[i]->move(chunk);
      passage.segment = i;
      if (!passage.who.empty()) passages.push_back(std::move(passage));
    }
    for (std::size_t i = passages.size(); i-- > 0;) {
      stop_if_cancelled(options_.progress);
      const std::size_t segment = passages[i].segment;
      segments_[segment]->go_back(passages[i], chunk, sums[segment], tape);
    }
    if (options_.progress != nullptr) options_.progress->done += segments_.size() * chunk.points.size();
  }

 private:
  TangentOptions options_;
  AdvectOptions advect_options_;
  std::vector<std::unique_ptr<const SegmentGradient>> segments_;
};

// Returns the numbers of the points, neighbours after one another.
std::vector<std::size_t> neighbours_in_turn(std::span<const Vec3d> points) {
  const ToUnit to_unit(bounding_box(points));
  std::vector<std::pair<std::uint64_t, std::size_t>> keys;
  for (std::size_t i = 0; i < points.size(); ++i) keys.emplace_back(morton_code(to_unit(points[i])), i);
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> order;
  order.reserve(keys.size());
  for (const auto& key : keys) order.push_back(key.second);
  return order;
}

Chunk chunk_of(std::span<const std::size_t> order, std::span<const Vec3d> points, std::span<const Vec3d> gradient) {
  Chunk chunk;
  chunk.order.assign(order.begin(), order.end());
  for (const std::size_t i : order) {
    chunk.points.push_back(points[i]);
    chunk.gradient.push_back(gradient[i]);
  }
  chunk.boxes.resize((order.size() + kPointsOfCull - 1) / kPointsOfCull, {Box{}, true});
  return chunk;
}

// Returns the gradient, and the sums of each segment.
FlowGradient sums_of(const FlowAdjoint& adjoint, std::span<const Vec3d> points, std::span<const Vec3d> gradient,
                     int threads) {
  FlowGradient result{std::vector<Vec3d>(points.size()), adjoint.zero_sums()};
  if (points.empty()) return result;
  const std::vector<std::size_t> order = neighbours_in_turn(points);
  const std::size_t of_chunk = adjoint.points_of_chunk();
  const std::size_t chunks = (points.size() + of_chunk - 1) / of_chunk;
  const std::size_t tasks = adjoint.most_tasks();
  const std::size_t of_task = (chunks + tasks - 1) / tasks * of_chunk;
  std::vector<Sums> sums_of_tasks((points.size() + of_task - 1) / of_task);
  parallel_for(points.size(), of_task, threads, [&](std::size_t begin, std::size_t end) {
    Tape tape;
    Sums& sums = sums_of_tasks[begin / of_task];
    sums = adjoint.zero_sums();
    for (std::size_t i = begin; i < end; i += of_chunk) {
      Chunk chunk = chunk_of(std::span(order).subspan(i, std::min(of_chunk, end - i)), points, gradient);
      adjoint.carry_back(chunk, sums, tape);
      for (std::size_t k = 0; k < chunk.order.size(); ++k) result.points[chunk.order[k]] = chunk.gradient[k];
    }
  });
  for (const Sums& sums : sums_of_tasks) {
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t n = 0; n < sums[i].size(); ++n) result.variables[i][n] += sums[i][n];
    }
  }
  return result;
}

}  // namespace

FlowGradient carry_back(const Flow& flow, const std::vector<VariableRates>& rates, std::span<const Vec3d> points,
                        std::span<const Vec3d> gradient, const TangentOptions& options) {
  const FlowAdjoint adjoint(flow, &rates, options);
  FlowGradient result = sums_of(adjoint, points, gradient, options.threads);
  for (std::size_t i = 0; i < rates.size(); ++i) {
    if (!adjoint.goes_by_steps(i)) continue;
    std::vector<double> of_variables(rates[i].size(), 0.0);
    for (std::size_t v = 0; v < of_variables.size(); ++v) {
      for (std::size_t n = 0; n < result.variables[i].size(); ++n) {
        of_variables[v] += rates[i][v][n] * result.variables[i][n];
      }
    }
    result.variables[i] = std::move(of_variables);
  }
  return result;
}

FlowGradient carry_back_to_coefficients(const Flow& flow, std::span<const Vec3d> points,
                                        std::span<const Vec3d> gradient, const TangentOptions& options) {
  const FlowAdjoint adjoint(flow, nullptr, options);
  FlowGradient result = sums_of(adjoint, points, gradient, options.threads);
  for (std::size_t i = 0; i < result.variables.size(); ++i) {
    result.variables[i] = adjoint.coefficients(i, std::move(result.variables[i]));
  }
  return result;
}

}  // namespace knead::detail
