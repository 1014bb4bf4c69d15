// Masks on segments: where they act, the offsets of potentials, and the speed along a mask's border.
#include "flow/masked.h"

#include <algorithm>
#include <array>

#include "field/grid.h"
#include "field/mask_grid.h"
#include "flow/culling.h"
#include "flow/pins.h"
#include "flow/segment_mover.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

constexpr std::size_t kMaxBorderSamples = 400;
constexpr int kSamplesPerAxis = 6;  // of the box of a support
constexpr std::array<double, 3> kSampleTimes{0.5, 0.1, 0.9};
constexpr int kRounds = 12;
constexpr double kStep = 0.3;           // towards the solution of the next weighted least squares
constexpr double kRidge = 1e-6;         // keeps the offset in directions on which no sample depends
constexpr double kPinTolerance = 1e-3;  // of speeds, by the radius

// Returns whether v does not depend on the time.
bool is_steady(const Segment& segment) {
  const auto turns = [](const Field& field) {
    const auto* space = std::get_if<HalfSpace<double>>(&field.region);
    const auto* handles = std::get_if<Handles<double>>(&field.region);
    return (space != nullptr && space->turn_angle != 0) || (handles != nullptr && handles->turn_angle != 0);
  };
  return segment.displacement == Vec3d{} && std::none_of(segment.fields.begin(), segment.fields.end(), turns);
}

// Returns whether the mask is not 1 somewhere in the segment's support.
bool meets_mask(const Segment& segment) {
  Segment whole = segment;
  whole.begin = 0;
  whole.end = 1;
  const Culling culling(whole);
  const Box box = segment.mask.box();
  if (culling.misses({box.center(), 0.5 * box.diagonal()})) return false;
  const MaskGrid& grid = segment.mask.grid();
  const double size = grid.spacing * kBrickCells;
  const auto [nx, ny, nz] = grid.bricks;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        const int brick = x + nx * (y + ny * z);
        if (grid.start[static_cast<std::size_t>(brick)] == 0) continue;
        const Vec3d middle = grid.origin + Vec3d{x + 0.5, y + 0.5, z + 0.5} * size;
        if (!culling.misses({middle, 0.87 * size})) return true;
      }
    }
  }
  return false;
}

// Returns at most kMaxBorderSamples places of the border, at equal distances in its list.
std::vector<Vec3d> border_in(const MaskGrid& grid, const Box& box) {
  std::vector<Vec3d> all;
  for (const Vec3d& place : grid.border) {
    if (contains(box, place)) all.push_back(place);
  }
  const std::size_t stride = (all.size() + kMaxBorderSamples - 1) / kMaxBorderSamples;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all.size(); i += stride) all[kept++] = all[i];
  all.resize(kept);
  return all;
}

// Finds the offset of one field that minimises the sum of the eighth powers of the speeds at samples, which almost
// minimises the greatest speed. Iteratively reweighted least squares.
class Offset {
 public:
  Offset(const Segment& segment, const Field& field) : segment_(segment), field_(field) {}

  Vec3d find() {
    const Mask& mask = segment_.mask;
    const Box support = support_of(field_, segment_.displacement);
    const std::vector<Vec3d> border = border_in(mask.grid(), support);
    Box around = mask.box();
    const double margin = 0.25 * around.diagonal();
    around = {around.min - Vec3d{margin, margin, margin}, around.max + Vec3d{margin, margin, margin}};
    if (support.max.x < kFar) around = support;
    const std::span<const double> times(kSampleTimes);
    for (const double t : is_steady(segment_) ? times.first(1) : times) {
      for (const Vec3d& x : border) add(x, t);
      if (samples_.empty()) continue;  // the border is outside the support at this time
      add_box(around, t);
    }
    return samples_.empty() ? Vec3d{0, 0, 0} : least();
  }

 private:
  // v = v0 - across x offset.
  struct Sample {
    Vec3d v0;
    Vec3d across;
  };

  void add(const Vec3d& x, double t) {
    const Vec3d d = x - field_.center - segment_.displacement * t;
    const RegionValue<double> r = region_value(field_, d, t);
    const Weight<double> w = blend_weight(r.value, field_.thresholds);
    if (w.value == 0) return;
    const MaskValue<double> m = segment_.mask.at(x);
    const Vec3d across = m.gradient * w.value + r.gradient * (w.derivative * m.value);
    if (!(norm2(across) > 0)) return;
    const MotionValue<double> inner =
        std::visit([&](const auto& motion) { return evaluate(motion, d); }, field_.motion);
    samples_.push_back({inner.velocity * (w.value * m.value) + cross(across, inner.potential), across});
  }

  void add_box(const Box& box, double t) {
    constexpr int n = kSamplesPerAxis;
    const Vec3d cell = (box.max - box.min) / n;
    for (int i = 0; i < n * n * n; ++i) {
      const int row = i / n;
      const int layer = row / n;
      const Vec3d at{i % n + 0.5, row % n + 0.5, layer + 0.5};
      add(box.min + Vec3d{at.x * cell.x, at.y * cell.y, at.z * cell.z}, t);
    }
  }

  double greatest2(const Vec3d& offset) const {
    double most = 0;
    for (const Sample& s : samples_) most = std::max(most, norm2(s.v0 - cross(s.across, offset)));
    return most;
  }

  Vec3d least() const {
    Vec3d offset{0, 0, 0};
    Vec3d best = offset;
    double least2 = greatest2(offset);
    double most2 = least2;
    for (int round = 0; round < kRounds && most2 > 0; ++round) {
      offset += (weighted(offset, 1 / most2) - offset) * kStep;
      most2 = greatest2(offset);
      if (most2 >= least2) continue;
      least2 = most2;
      best = offset;
    }
    return best;
  }

  // Solves the least squares with each square weighted by the sixth power of its current speed.
  Vec3d weighted(const Vec3d& offset, double scale2) const {
    Mat3d left{{}, {}, {}};
    Vec3d right{0, 0, 0};
    for (const Sample& s : samples_) {
      const double part2 = norm2(s.v0 - cross(s.across, offset)) * scale2;
      const double weight = part2 * part2 * part2;
      const double square = norm2(s.across);
      left = left + (Mat3d{} * square + outer_product(s.across, -s.across)) * weight;
      right += cross(s.v0, s.across) * weight;
    }
    const double ridge = kRidge * trace(left);
    left = left + Mat3d{} * ridge;
    const Vec3d a = cross(left.row1, left.row2);
    const double det = dot(left.row0, a);
    if (!(det > 0)) return {0, 0, 0};
    right += offset * ridge;
    return (a * right.x + cross(left.row2, left.row0) * right.y + cross(left.row0, left.row1) * right.z) / det;
  }

  const Segment& segment_;
  const Field& field_;
  std::vector<Sample> samples_;
};

// Returns a vector potential mirrored in the planes that the bits of `image` select. It is mirrored like an axis of
// rotation.
Vec3d mirrored_potential(const std::vector<std::size_t>& planes, std::size_t image, Vec3d a) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if ((image >> i & 1U) == 0) continue;
    a[planes[i]] = -a[planes[i]];
    a = -a;
  }
  return a;
}

BorderSpeed border_speed_of_grid(const Segment& segment, std::span<const Vec3d> points) {
  const GridNodes<double> nodes(segment.grid);
  BorderSpeed result;
  for (const double t : {0.0, 0.5, 1.0}) {
    for (const Vec3d& x : points) {
      const MaskValue<double> m = segment.mask.at(x);
      const GridValue<double> value = evaluate_grid(nodes.view, x - nodes.cells.center(), t);
      const Vec3d with = value.velocity * m.value + cross(m.gradient, value.potential);
      if (m.value > 0 && m.value < 1) result.at_border = std::max(result.at_border, norm(with));
      result.of_tool = std::max(result.of_tool, norm(value.velocity));
    }
  }
  return result;
}

}  // namespace

SegmentMask mask_on(const Segment& segment) {
  SegmentMask result;
  result.acts = !segment.mask.is_empty() && meets_mask(segment);
  if (!result.acts || !segment.parts.empty()) return result;
  if (segment.time_law == TimeLaw::pinned) {                                  // no offsets: the potentials act as a sum
    result.offsets.resize(segment.fields.size() + 2 * segment.turns.size());  // as many as fields_at()
    return result;
  }
  for (const Field& field : segment.fields) result.offsets.push_back(Offset(segment, field).find());
  return result;
}

std::vector<SegmentMask> masks_on(const Segment& sum, const std::vector<Segment>& parts) {
  std::vector<SegmentMask> masks;
  masks.reserve(parts.size());
  for (const Segment& part : parts) masks.push_back(mask_on(part));
  std::vector<std::size_t> planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (sum.mirrored_at[axis]) planes.push_back(axis);
  }
  const auto has_all = [&](const SegmentMask& mask) {
    return mask.acts && mask.offsets.size() == masks.front().offsets.size();
  };
  if (parts.size() != std::size_t{1} << planes.size() || !std::all_of(masks.begin(), masks.end(), has_all)) {
    return masks;
  }
  for (std::size_t field = 0; field < masks.front().offsets.size(); ++field) {
    Vec3d mean{0, 0, 0};
    for (std::size_t i = 0; i < parts.size(); ++i) mean += mirrored_potential(planes, i, masks[i].offsets[field]);
    mean = mean / static_cast<double>(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) masks[i].offsets[field] = mirrored_potential(planes, i, mean);
  }
  return masks;
}

BorderSpeed border_speed(const Segment& segment, std::span<const Vec3d> points) {
  if (!segment.parts.empty()) {
    BorderSpeed greatest;
    for (const Segment& part : parts_of(segment)) {
      const BorderSpeed own = border_speed(part, points);
      greatest.at_border = std::max(greatest.at_border, own.at_border);
      greatest.of_tool = std::max(greatest.of_tool, own.of_tool);
    }
    return greatest;
  }
  const SegmentMask mask = mask_on(segment);
  BorderSpeed result;
  if (!mask.acts) return result;
  if (!segment.grid.is_empty()) return border_speed_of_grid(segment, points);
  const bool swept = segment.time_law == TimeLaw::swept;
  const bool pinned = segment.time_law == TimeLaw::pinned;
  std::vector<PinPiece> pieces;
  if (pinned) pieces = solve_pins(segment, kPinTolerance * segment.fields.front().thresholds.outer);
  for (const double t : {0.0, 0.5, 1.0}) {
    const std::vector<Field> fields = pinned ? fields_at(segment, pieces, t) : segment.fields;
    for (const Vec3d& x : points) {
      const MaskValue<double> m = segment.mask.at(x);
      Vec3d with{0, 0, 0};
      Vec3d without{0, 0, 0};
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const Vec3d d = x - fields[i].center - segment.displacement * (swept ? t : 0);
        const RegionValue<double> r = region_value(fields[i], d, t);
        std::visit(
            [&](const auto& motion) {
              with += masked_velocity_where(r, motion, fields[i].thresholds, d, m, mask.offsets[i]);
              without += velocity_where(r, motion, fields[i].thresholds, d);
            },
            fields[i].motion);
      }
      if (m.value > 0 && m.value < 1) result.at_border = std::max(result.at_border, norm(with));
      result.of_tool = std::max(result.of_tool, norm(without));
    }
  }
  return result;
}

}  // namespace knead::detail
