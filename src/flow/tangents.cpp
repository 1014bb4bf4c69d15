// The numbers of a segment, and path lines with their derivatives by them.
#include "flow/tangents.h"

#include <algorithm>
#include <variant>

#include "flow/masked.h"
#include "flow/path_jacobian.h"
#include "flow/segment_map.h"
#include "flow/segment_mover.h"
#include "flow/tangent_line.h"
#include "flow/varying_fields.h"
#include "knead/error.h"
#include "knead/vec.h"

namespace knead::detail {
namespace {

constexpr std::size_t kPointsOfTask = 64;

bool is_alike(const PointSet<double>& a, const PointSet<double>& b) {
  const auto are_equal = [](const auto& one, const auto& other) { return one.size() == other.size(); };
  return a.points.size() == b.points.size() && a.exponent == b.exponent &&
         std::equal(a.curves.begin(), a.curves.end(), b.curves.begin(), b.curves.end(), are_equal);
}

bool is_alike(const LatticeMotion& a, const LatticeMotion& b) {
  return a.origin == b.origin && a.axes == b.axes && a.lengths == b.lengths && a.counts == b.counts &&
         a.degrees == b.degrees;
}

bool is_alike(const Field& a, const Field& b) {
  if (a.motion.index() != b.motion.index() || a.region.index() != b.region.index()) return false;
  if (a.thresholds.falloff != b.thresholds.falloff) return false;
  if (const auto* turn = std::get_if<Rotation<double>>(&a.motion)) {
    if (turn->zero_gauge != std::get<Rotation<double>>(b.motion).zero_gauge) return false;
  }
  if (const auto* set = std::get_if<PointSet<double>>(&a.region)) {
    return is_alike(*set, std::get<PointSet<double>>(b.region));
  }
  if (const auto* handles = std::get_if<Handles<double>>(&a.region)) {
    const auto& other = std::get<Handles<double>>(b.region);
    return is_alike(handles->full, other.full) && is_alike(handles->zero, other.zero);
  }
  return true;
}

bool is_alike(const Segment& a, const Segment& b) {
  const auto has_same_pin = [](const PinTurn& one, const PinTurn& other) { return one.pin == other.pin; };
  const auto fields = [](const Field& one, const Field& other) { return is_alike(one, other); };
  const auto parts = [](const Segment& one, const Segment& other) { return is_alike(one, other); };
  return std::equal(a.fields.begin(), a.fields.end(), b.fields.begin(), b.fields.end(), fields) &&
         a.time_law == b.time_law && a.limit_cylinder.has_value() == b.limit_cylinder.has_value() && a.mask == b.mask &&
         a.grid == b.grid && a.curve == b.curve && is_alike(a.lattice, b.lattice) &&
         std::equal(a.turns.begin(), a.turns.end(), b.turns.begin(), b.turns.end(), has_same_pin) &&
         std::equal(a.parts.begin(), a.parts.end(), b.parts.begin(), b.parts.end(), parts);
}

// Calls next(number) for the numbers of a segment's fields, or those of its pins at these times.
template <class Next>
void read_fields(const Segment& segment, const SegmentMask& mask, std::span<const double> pin_times,
                 const Progress* progress, Next& next) {
  const Varied<Next> varied(next);
  if (segment.time_law == TimeLaw::pinned) {
    const std::vector<PinPiece> pieces = exact_pins(segment, progress);
    for (const double t : pin_times) {
      for (const Field& field : fields_at(segment, pieces, t)) varied(field);
    }
  } else {
    varied(segment.displacement);
    for (const Field& field : segment.fields) varied(field);
  }
  if (!mask.acts) return;
  for (const Vec3d& offset : mask.offsets) varied(offset);
}

constexpr std::size_t kPointsAtATime = 1024;  // enough to refill the lanes of a kernel
constexpr std::size_t kEnds = 2;              // the first numbers of a segment: begin and end

// Of a map in closed form the begin and the end may vary, and the displacements of a lattice.
void carry_by_map(const Segment& segment, std::span<const double> rates, std::span<Vec3d> points,
                  std::span<Vec3d> tangents, const TangentOptions& options) {
  const SegmentMap map(segment);
  const auto shift = [&](std::size_t end, double t, double sign) {
    if (rates.empty() || rates[end] == 0) return;
    const std::vector<Vec3d> velocities = map_velocities(segment, points, t);
    for (std::size_t i = 0; i < points.size(); ++i) tangents[i] += velocities[i] * (sign * rates[end]);
  };
  shift(0, segment.begin, -1);
  parallel_for(points.size(), kPointsOfTask, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Mat3d jacobian;
      const Vec3d from = points[i];
      map.move(points[i], jacobian);
      tangents[i] = jacobian * tangents[i];
      if (map.lattice() != nullptr && !rates.empty()) {
        tangents[i] += map.lattice()->tangent(from, jacobian, rates.subspan(kEnds));
      }
    }
    if (options.progress != nullptr) options.progress->done += end - begin;
  });
  stop_if_cancelled(options.progress);
  shift(1, segment.end, 1);
}

void carry_one_by_one(const TangentLine& line, std::span<Vec3d> points, std::span<Vec3d> tangents,
                      const TangentOptions& options) {
  parallel_for(points.size(), kPointsOfTask, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      stop_if_cancelled(options.progress);
      TangentState state{points[i], tangents[i]};
      line.move(state);
      points[i] = state[0];
      tangents[i] = state[1];
    }
    if (options.progress != nullptr) options.progress->done += end - begin;
  });
}

}  // namespace

SegmentNumbers::SegmentNumbers(const Segment& segment, const Progress* progress)
    : segment_(segment), progress_(progress) {
  if (segment.time_law != TimeLaw::pinned) return;
  pin_times_ = times_of(exact_pins(segment, progress));
}

std::optional<std::vector<double>> SegmentNumbers::of(const Segment& segment) const {
  if (!is_alike(segment, segment_)) return std::nullopt;
  std::vector<double> numbers{segment.begin, segment.end};
  const auto next = [&](double number) {
    numbers.push_back(number);
    return Varying(number);
  };
  for (const Vec3d& d : segment.lattice.displacements) numbers.insert(numbers.end(), {d.x, d.y, d.z});
  const std::vector<Segment> parts = parts_of(segment);
  const std::vector<SegmentMask> masks = masks_of_parts(segment, parts);
  for (std::size_t i = 0; i < parts.size(); ++i) read_fields(parts[i], masks[i], pin_times_, progress_, next);
  return numbers;
}

std::size_t count_coefficients(const Segment& segment) {
  return segment.lattice.displacements.size() + segment.grid.coefficients.size() + segment.grid.end_coefficients.size();
}

void advect_tangents_by_coefficients(const Segment& segment, std::span<const Vec3d> rates, std::span<Vec3d> points,
                                     std::span<Vec3d> tangents, const TangentOptions& options) {
  if (!segment.lattice.is_empty()) {
    std::vector<double> numbers(kEnds, 0.0);
    for (const Vec3d& rate : rates) numbers.insert(numbers.end(), {rate.x, rate.y, rate.z});
    return advect_tangents(segment, numbers, points, tangents, options);
  }
  PotentialGrid grid = segment.grid;
  grid.growth = {};
  const std::size_t count = grid.coefficients.size();
  const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(count);
  grid.coefficients = SharedVectors({rates.begin(), middle});
  if (middle != rates.end()) grid.end_coefficients = SharedVectors({middle, rates.end()});
  const GridNodes<double> nodes(grid);
  TangentLine line(segment, {}, options);
  line.vary_grid(&nodes);
  carry_one_by_one(line, points, tangents, options);
}

void advect_tangents(const Segment& segment, std::span<const double> rates, std::span<Vec3d> points,
                     std::span<Vec3d> tangents, const TangentOptions& options) {
  if (is_map(segment)) return carry_by_map(segment, rates, points, tangents, options);
  if (!segment.parts.empty() && has_limit_cylinders(segment)) {
    // The parts of a sum that move a point depend on its place at the beginning.
    return carry_one_by_one(TangentLine(segment, {rates}, options), points, tangents, options);
  }
  AdvectOptions advect_options;
  advect_options.tolerance = options.tolerance;
  advect_options.progress = options.progress;
  const WantedJacobian wanted{.jacobian_tolerance = options.relative_tolerance};
  const SegmentJacobians map(segment, advect_options, wanted, {rates});
  parallel_for(points.size(), kPointsAtATime, options.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(options.progress);
    const std::span<Vec3d> some = points.subspan(begin, end - begin);
    const std::vector<Vec3d> before(some.begin(), some.end());
    std::vector<Mat3d> own_jacobians(some.size());
    std::vector<Vec3d> own(some.size() * map.variables());
    std::vector<JacobianStart> starts;
    for (std::size_t i = 0; i < some.size(); ++i) {
      if (const std::optional<double> t = map.meet(some[i], own_jacobians[i])) starts.push_back({i, *t});
    }
    map.move(starts, some, own_jacobians, own);
    for (std::size_t i = 0; i < some.size(); ++i) {
      tangents[begin + i] = own_jacobians[i] * tangents[begin + i];
      if (own.empty()) continue;
      map.add_shifts(before[i], some[i], own_jacobians[i], std::span(own).subspan(i, 1));
      tangents[begin + i] += own[i];
    }
    if (options.progress != nullptr) options.progress->done += end - begin;
  });
  stop_if_cancelled(options.progress);
}

}  // namespace knead::detail
