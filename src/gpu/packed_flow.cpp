// Packs segments into the numbers that the shaders read: fields, and grids of potentials.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <variant>
#include <vector>

#include "field/grid.h"
#include "flow/culling.h"
#include "flow/segment_mover.h"
#include "flow/step_rule.h"
#include "gpu/packed.h"
#include "knead/error.h"

namespace knead::gpu {

namespace {

using namespace layout;
using detail::GridCells;

// The limits of one call of a shader. Some drivers stop loops after 65535 rounds, of which an evaluation takes 20; a
// node takes 24 bytes, also the empty ones around a grid; and drivers stop calls that take seconds.
constexpr std::size_t kMaxGrids = 16;
constexpr std::size_t kMaxNodes = std::size_t{1} << 21;
constexpr std::size_t kMaxSegments = 64;
constexpr std::size_t kMaxSetPoints = 4096;

std::size_t padded_nodes(const PotentialGrid& grid) {
  std::size_t nodes = grid.end_coefficients.empty() ? 1 : 2;
  for (const int count : grid.counts) nodes *= static_cast<std::size_t>(count) + std::size_t{2} * detail::kEmptyNodes;
  return nodes;
}

// Fills one pack with grids.
class GridPacker {
 public:
  GridPacker(std::span<const Segment> segments, const AdvectOptions& options) : segments_(segments), options_(options) {
    packed_.count = static_cast<int>(segments.size());
    packed_.numbers.resize(segments.size() * kSegmentNumbers);
    packed_.places.resize(segments.size() * (kSegmentPlaces + kFieldBounds));
    packed_.table.resize(segments.size() * (kSegmentEntries + kFieldEntries));
  }

  PackedSegments run() {
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const GridCells cells(segments_[i].grid);
      put_segment(i, cells);
      put_grid(i, cells);
    }
    return std::move(packed_);
  }

 private:
  std::size_t table_of(std::size_t i) const { return segments_.size() * kSegmentEntries + i * kFieldEntries; }
  std::size_t bounds_at(std::size_t i) const { return segments_.size() * kSegmentPlaces + i * kFieldBounds; }

  void put_segment(std::size_t i, const GridCells& cells) {
    const Segment& segment = segments_[i];
    double* const numbers = packed_.numbers.data() + i * kSegmentNumbers;
    numbers[kReach] = detail::reach_of_step(segment);
    numbers[kTolerance] = detail::kErrorShare * options_.tolerance;
    numbers[kMin] = kMinMotion * segment.grid.spacing;
    numbers[kBegin] = segment.begin;
    numbers[kEnd] = segment.end;
    const std::size_t places = i * kSegmentPlaces;
    put(packed_.places, places, cells.center());
    packed_.places[places + 8] = 1 / segment.grid.spacing;
    std::int32_t* const entries = packed_.table.data() + i * kSegmentEntries;
    entries[0] = 1;
    entries[1] = static_cast<std::int32_t>(table_of(i));
    entries[3] = static_cast<std::int32_t>(i * kSegmentNumbers);
  }

  void put_grid(std::size_t i, const GridCells& cells) {
    const PotentialGrid& grid = segments_[i].grid;
    const std::size_t entry = table_of(i);
    const auto set = [&](int at, auto value) {
      packed_.table[entry + static_cast<std::size_t>(at)] = static_cast<std::int32_t>(value);
    };
    set(kFieldBegin, put_numbers(cells, grid.coefficients));
    if (!grid.end_coefficients.empty()) set(kEndNumbers, put_numbers(cells, grid.end_coefficients));
    const auto view = cells.view<double>();
    set(kRow, view.row);
    set(kPlane, view.plane);
    set(kFirstNode, view.first_node);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      set(kFirstCell + static_cast<int>(axis), view.first_cell[axis]);
      set(kLastCell + static_cast<int>(axis), view.last_cell[axis]);
    }
    set(kUsed, put_used(cells.used()));
    set(kBounds, bounds_at(i));
    put_box(bounds_at(i), detail::box_in_use(grid), grid.spacing);
  }

  std::size_t put_numbers(const GridCells& cells, const SharedVectors& coefficients) {
    const std::size_t begin = packed_.numbers.size();
    const std::vector<double> numbers = cells.numbers<double>(coefficients);
    packed_.numbers.resize(begin + numbers.size() / 3 * 4);
    for (std::size_t node = 0; node < numbers.size() / 3; ++node) {
      std::copy_n(numbers.data() + 3 * node, 3, packed_.numbers.data() + begin + 4 * node);
    }
    return begin;
  }

  // Packs 32 cells into an entry.
  std::size_t put_used(const std::vector<std::uint8_t>& used) {
    const std::size_t begin = packed_.table.size();
    std::vector<std::uint32_t> words((used.size() + 31) / 32);
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i] != 0) words[i / 32] |= std::uint32_t{1} << i % 32;
    }
    packed_.table.insert(packed_.table.end(), words.begin(), words.end());
    return begin;
  }

  // Writes the box of the cells in use; an empty one misses every point.
  void put_box(std::size_t at, const Box& nodes, double spacing) {
    const double size = nodes.empty() ? 0 : norm(nodes.min) + norm(nodes.max);
    const Vec3d margin = Vec3d{1, 1, 1} * ((2 + 1e-6) * spacing + 1e-12 * size);
    put(packed_.places, at, nodes.min - margin);
    put(packed_.places, at + 3, nodes.max + margin);
  }

  std::span<const Segment> segments_;
  const AdvectOptions& options_;
  PackedSegments packed_;
};

std::size_t points_of(const PointSet<double>& set) {
  std::size_t count = set.points.size();
  for (const std::vector<Vec3d>& curve : set.curves) count += curve.size();
  return count;
}

std::size_t set_points_of(const Segment& segment) {
  std::size_t count = 0;
  for (const Field& field : segment.fields) {
    if (const auto* set = std::get_if<PointSet<double>>(&field.region)) count += points_of(*set);
  }
  return count;
}

bool has_curves(const Field& field) {
  const auto* set = std::get_if<PointSet<double>>(&field.region);
  return set != nullptr && !set->curves.empty();
}

bool is_symmetric(const Mat3d& m) { return m.row0.y == m.row1.x && m.row0.z == m.row2.x && m.row1.z == m.row2.y; }

bool is_parallel(const Vec3d& a, const Vec3d& b) { return norm2(cross(a, b)) <= 1e-24; }

// The choice of closed_form.cpp. A translation carries its points and needs none.
template <class Other>
ClosedForm form_of(const Other& /*motion*/, const Field& /*field*/, const Segment& /*segment*/) {
  return kNoClosedForm;
}

ClosedForm form_of(const Rotation<double>& motion, const Field& field, const Segment& segment) {
  if (segment.displacement != Vec3d{}) return kNoClosedForm;
  if (std::holds_alternative<Ball<double>>(field.region)) {
    return motion.zero_gauge == RotationGauge::radial ? kTurningBall : kNoClosedForm;
  }
  const auto* space = std::get_if<HalfSpace<double>>(&field.region);
  const bool known = space != nullptr && (space->turn_angle == 0 || is_parallel(space->turn_axis, motion.axis));
  return known ? kTurningSpace : kNoClosedForm;
}

ClosedForm form_of(const Twist<double>& motion, const Field& field, const Segment& segment) {
  const auto* space = std::get_if<HalfSpace<double>>(&field.region);
  if (segment.displacement != Vec3d{} || space == nullptr || space->turn_angle != 0) return kNoClosedForm;
  return is_parallel(space->normal, motion.axis) ? kParallelTwist : kTurningSpace;
}

ClosedForm form_of(const Strain<double>& motion, const Field& field, const Segment& segment) {
  const bool known = std::holds_alternative<Ball<double>>(field.region) && is_symmetric(motion.matrix) &&
                     segment.displacement == Vec3d{} && !segment.limit_cylinder;
  return known ? kStretchedCore : kNoClosedForm;
}

ClosedForm form_of(const Segment& segment) {
  if (segment.fields.size() != 1 || segment.time_law != TimeLaw::swept) return kNoClosedForm;
  const Field& field = segment.fields.front();
  return std::visit([&](const auto& motion) { return form_of(motion, field, segment); }, field.motion);
}

// The twelve numbers of an inner motion, for the formulas of field.h.
void put_motion(std::vector<double>& to, std::size_t at, const Translation<double>& motion) {
  const Vec3d parallel = motion.axis * dot(motion.axis, motion.velocity);
  const Vec3d perpendicular = motion.velocity - parallel;
  put(to, at, motion.velocity);
  put(to, at + 3, (parallel + perpendicular * motion.gauge) * 0.5);
  put(to, at + 6, motion.axis);
  put(to, at + 9, cross(motion.axis, perpendicular) * (1 - motion.gauge));
}

void put_motion(std::vector<double>& to, std::size_t at, const Rotation<double>& motion) {
  const double rest = 1 - motion.gauge;
  const bool radial = motion.zero_gauge == RotationGauge::radial;
  put(to, at, motion.axis);
  to[at + 3] = motion.rate;
  to[at + 4] = motion.rate * (motion.gauge * 0.5 + (radial ? rest : 0));
  to[at + 5] = motion.rate * (-motion.gauge * 0.25 - (radial ? 0 : rest * 0.5));
  to[at + 6] = motion.rate * (radial ? rest : 0);
  to[at + 7] = motion.gauge;
}

void put_motion(std::vector<double>& to, std::size_t at, const Twist<double>& motion) {
  put(to, at, motion.axis);
  to[at + 3] = motion.rate;
  to[at + 4] = motion.rate * motion.gauge * 0.25;
  to[at + 5] = motion.rate * (-motion.gauge * 0.25 - (1 - motion.gauge) * 0.5);
  to[at + 7] = motion.gauge;
}

void put_motion(std::vector<double>& to, std::size_t at, const Strain<double>& motion) { put(to, at, motion.matrix); }

void put_motion(std::vector<double>& /*to*/, std::size_t /*at*/, const CustomMotion& /*motion*/) {}

// Fills one pack with fields.
class Packer {
 public:
  Packer(std::span<const Segment> segments, const AdvectOptions& options) : segments_(segments), options_(options) {
    std::size_t fields = 0;
    for (const Segment& segment : segments) fields += segment.fields.size();
    packed_.count = static_cast<int>(segments.size());
    packed_.numbers.resize(segments.size() * kSegmentNumbers + fields * kFieldNumbers);
    packed_.places.resize(segments.size() * kSegmentPlaces + fields * kFieldBounds);
    packed_.table.resize(segments.size() * kSegmentEntries + fields * kFieldEntries);
  }

  PackedSegments run() {
    std::size_t field = 0;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      put_segment(i, field);
      for (const Field& own : segments_[i].fields) put_field(segments_[i], own, field++);
    }
    return std::move(packed_);
  }

 private:
  std::size_t table_of(std::size_t field) const { return segments_.size() * kSegmentEntries + field * kFieldEntries; }
  std::size_t numbers_of(std::size_t field) const { return segments_.size() * kSegmentNumbers + field * kFieldNumbers; }
  std::size_t bounds_at(std::size_t field) const { return segments_.size() * kSegmentPlaces + field * kFieldBounds; }

  void put_segment(std::size_t i, std::size_t first_field) {
    const Segment& segment = segments_[i];
    const std::size_t numbers = i * kSegmentNumbers;
    put(packed_.numbers, numbers, segment.displacement);
    packed_.numbers[numbers + 3] = norm(segment.displacement);
    packed_.numbers[numbers + kReach] = std::min(detail::reach_of_step(segment), 1e30);
    packed_.numbers[numbers + kTolerance] = detail::kErrorShare * options_.tolerance;
    packed_.numbers[numbers + kMin] = least_motion(segment);
    packed_.numbers[numbers + kBegin] = segment.begin;
    packed_.numbers[numbers + kEnd] = segment.end;
    const ClosedForm form = form_of(segment);
    if (form == kStretchedCore) {
      const Mat3d& m = std::get<Strain<double>>(segment.fields.front().motion).matrix;
      put(packed_.numbers, numbers + layout::kStrain, exp(m * (segment.end - segment.begin)));
    }
    const std::size_t places = i * kSegmentPlaces;
    put(packed_.places, places, segment.fields.front().center);
    put(packed_.places, places + 3, segment.displacement);
    if (segment.limit_cylinder) {
      put(packed_.places, places + 8, segment.limit_cylinder->center);
      put(packed_.places, places + 11, segment.limit_cylinder->axis);
      packed_.places[places + 14] = segment.limit_cylinder->radius * segment.limit_cylinder->radius;
    }
    const std::size_t entry = i * kSegmentEntries;
    packed_.table[entry] = static_cast<std::int32_t>(segment.fields.size());
    packed_.table[entry + 1] = static_cast<std::int32_t>(table_of(first_field));
    packed_.table[entry + 2] =
        (detail::carries(segment) ? kCarries : 0) + (segment.limit_cylinder ? kHasCylinder : 0) + kClosedForm * form;
    packed_.table[entry + 3] = static_cast<std::int32_t>(numbers);
  }

  static double least_motion(const Segment& segment) {
    double least = kInfinity;
    for (const Field& field : segment.fields) {
      least = std::min(least, kMinMotion * (field.thresholds.outer - field.thresholds.inner));
    }
    return least;
  }

  void put_field(const Segment& segment, const Field& field, std::size_t index) {
    const std::size_t at = numbers_of(index);
    const double width = field.thresholds.outer - field.thresholds.inner;
    const double epsilon = options_.precision == Precision::float32 ? std::numeric_limits<float>::epsilon()
                                                                    : std::numeric_limits<double>::epsilon();
    std::vector<double>& numbers = packed_.numbers;
    put(numbers, at, field.center - segment.fields.front().center);
    numbers[at + kOuter] = field.thresholds.outer;
    numbers[at + kInner] = field.thresholds.inner;
    numbers[at + kFalloff] = field.thresholds.falloff;
    if (field.thresholds.falloff == kWideFalloff) numbers[at + kPerBump] = 1 / field.thresholds.bump;
    numbers[at + kInverseWidth] = (1 + 4 * epsilon) / width;  // rounded up, as in field.h
    std::visit([&](const auto& motion) { put_motion(numbers, at + kMotion, motion); }, field.motion);
    const std::size_t entry = table_of(index);
    packed_.table[entry + kFieldBegin] = static_cast<std::int32_t>(at);
    packed_.table[entry + kMotionKind] = static_cast<std::int32_t>(field.motion.index());
    packed_.table[entry + kRegionKind] = static_cast<std::int32_t>(field.region.index());
    packed_.table[entry + kBounds] = static_cast<std::int32_t>(bounds_at(index));
    put_bounds(packed_.places, bounds_at(index), field, segment);
    std::visit([&](const auto& region) { put_region(region, at + kRegion, entry); }, field.region);
    if (may_have_tree(field, segment)) put_tree(pack_tree(field, segment, options_), entry + kFirstSet);
  }

  void put_region(const Capsule<double>& region, std::size_t at, std::size_t /*entry*/) {
    put(packed_.numbers, at, region.half_axis);
    const double length2 = norm2(region.half_axis);
    packed_.numbers[at + 3] = length2 > 0 ? 1 / length2 : 0;
  }

  void put_region(const HalfSpace<double>& region, std::size_t at, std::size_t /*entry*/) {
    put(packed_.numbers, at, region.normal);
    put(packed_.numbers, at + 3, region.turn_axis);
    packed_.numbers[at + 6] = region.turn_angle;
  }

  void put_region(const PointSet<double>& region, std::size_t /*at*/, std::size_t entry) {
    put_set(region, entry + kFirstSet);
  }

  // A ball has no numbers of its own; kind_of refuses the others.
  template <class Other>
  void put_region(const Other& /*region*/, std::size_t /*at*/, std::size_t /*entry*/) {}

  void put_tree(const PackedTree& tree, std::size_t entry) {
    if (tree.nodes == 0) return;
    const auto first = static_cast<std::size_t>(packed_.table[entry]);  // in place of the set's own points
    for (std::size_t i = 0; i < tree.points.size(); ++i) put(packed_.numbers, first + 3 * i, tree.points[i]);
    packed_.table[entry + 5] = static_cast<std::int32_t>(packed_.table.size());
    packed_.table[entry + 6] = static_cast<std::int32_t>(packed_.numbers.size() + 1);  // after the allowed error
    packed_.table[entry + 7] = tree.nodes;
    packed_.numbers.push_back(tree.error_of_one);
    packed_.numbers.insert(packed_.numbers.end(), tree.numbers.begin(), tree.numbers.end());
    packed_.table.insert(packed_.table.end(), tree.entries.begin(), tree.entries.end());
  }

  std::int32_t put_points(const std::vector<Vec3d>& points) {
    const std::size_t begin = packed_.numbers.size();
    packed_.numbers.resize(begin + 3 * points.size());
    for (std::size_t i = 0; i < points.size(); ++i) put(packed_.numbers, begin + 3 * i, points[i]);
    return static_cast<std::int32_t>(begin);
  }

  void put_set(const PointSet<double>& set, std::size_t entry) {
    const std::int32_t points = put_points(set.points);
    const std::size_t curves = packed_.table.size();
    packed_.table.resize(curves + 2 * set.curves.size());
    packed_.table[entry] = points;
    packed_.table[entry + 1] = static_cast<std::int32_t>(set.points.size());
    packed_.table[entry + 2] = set.exponent;
    packed_.table[entry + 3] = static_cast<std::int32_t>(curves);
    packed_.table[entry + 4] = static_cast<std::int32_t>(set.curves.size());
    for (std::size_t k = 0; k < set.curves.size(); ++k) {
      packed_.table[curves + 2 * k] = put_points(set.curves[k]);
      packed_.table[curves + 2 * k + 1] = static_cast<std::int32_t>(set.curves[k].size());
    }
  }

  std::span<const Segment> segments_;
  const AdvectOptions& options_;
  PackedSegments packed_;
};

}  // namespace

PackedSegments pack_grids(std::span<const Segment> segments, const AdvectOptions& options) {
  return GridPacker(segments, options).run();
}

std::size_t count_packed_grids(std::span<const Segment> segments) {
  std::size_t nodes = 0;
  std::size_t length = 0;
  while (length < std::min(segments.size(), kMaxGrids)) {
    nodes += padded_nodes(segments[length].grid);
    if (length > 0 && nodes > kMaxNodes) break;
    ++length;
  }
  return length;
}

ShaderKind kind_of(const Segment& segment, const AdvectOptions& options) {
  if (!segment.parts.empty()) {
    throw InvalidInput("it is a sum, as of mirror images, which the GPU cannot evaluate; move the points with advect");
  }
  if (!segment.mask.is_empty()) {
    throw InvalidInput("it has a mask, which the GPU cannot evaluate; move the points with advect");
  }
  if (!segment.curve.is_empty() || !segment.lattice.is_empty()) {
    throw InvalidInput("it has a curve or a lattice, which the GPU cannot evaluate; move the points with advect");
  }
  if (changes_volume(segment)) {
    throw InvalidInput("it changes volumes on purpose, which the GPU cannot evaluate; move the points with advect");
  }
  ShaderKind kind;
  kind.in_double = options.precision == Precision::float64;
  kind.integrator = options.integrator;
  kind.pins = segment.time_law == TimeLaw::pinned;
  kind.turns = !segment.turns.empty();
  kind.grid = !segment.grid.is_empty();
  kind.grid_changes = !segment.grid.end_coefficients.empty();
  if (kind.pins || kind.grid) return kind;
  for (const Field& field : segment.fields) {
    if (std::holds_alternative<CustomMotion>(field.motion) || std::holds_alternative<CustomRegion>(field.region)) {
      throw InvalidInput(
          "a field is a function of the program's own, which a GPU cannot call; move the points with advect");
    }
    if (std::holds_alternative<Handles<double>>(field.region)) {
      throw InvalidInput("it moves handles, which the GPU cannot evaluate; move the points with advect");
    }
    if (field.thresholds.falloff == kWideFalloff && field.thresholds.inner > 0) {
      throw InvalidInput(
          "it moves a wide ball with a core, which the GPU cannot evaluate; move the points with advect");
    }
    kind.motions |= 1U << field.motion.index();
    kind.regions |= 1U << field.region.index();
    kind.falloff = kind.falloff || field.thresholds.falloff != kDefaultFalloff;
    kind.curves = kind.curves || has_curves(field);
    kind.trees = kind.trees || may_have_tree(field, segment);
  }
  kind.single = segment.fields.size() == 1;
  kind.blended = segment.time_law == TimeLaw::blended;
  kind.limit_cylinder = segment.limit_cylinder.has_value();
  return kind;
}

std::vector<PackedSegments> pack(std::span<const Segment> segments, const AdvectOptions& options) {
  if (segments.front().time_law == TimeLaw::pinned) return pack_pins(segments.front(), options);
  std::vector<PackedSegments> packs;
  const bool grids = !segments.front().grid.is_empty();
  packs.push_back(grids ? pack_grids(segments, options) : Packer(segments, options).run());
  return packs;
}

std::size_t pack_length(std::span<const Segment> segments, const AdvectOptions& options) {
  const ShaderKind kind = kind_of(segments.front(), options);
  if (kind.pins) return 1;
  std::size_t set_points = set_points_of(segments.front());
  std::size_t length = 1;
  while (length < std::min(segments.size(), kMaxSegments)) {
    set_points += set_points_of(segments[length]);
    if (set_points > kMaxSetPoints || !(kind_of(segments[length], options) == kind)) break;
    ++length;
  }
  return kind.grid ? count_packed_grids(segments.first(length)) : length;
}

}  // namespace knead::gpu
