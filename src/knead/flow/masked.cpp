#include "knead/flow/masked.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "knead/field/mask_grid.h"
#include "knead/flow/culling.h"
#include "knead/math/box.h"
#include "knead/math/mat3.h"

namespace knead::detail {

namespace {

constexpr std::size_t kMostBorder = 1500;  // parts of the border that are looked at
constexpr int kPlaces = 8;                 // along each axis of the box in which the support is looked at
constexpr std::array<double, 4> kMoments{0.125, 0.375, 0.625, 0.875};

bool rests(const Segment& segment) {
  const auto turns = [](const Field& field) {
    const auto* space = std::get_if<HalfSpace<double>>(&field.region);
    const auto* handles = std::get_if<Handles<double>>(&field.region);
    return (space != nullptr && space->turn_angle != 0) || (handles != nullptr && handles->turn_angle != 0);
  };
  return segment.displacement == Vec3d{} && std::none_of(segment.fields.begin(), segment.fields.end(), turns);
}

bool reaches(const Segment& segment) {
  Segment whole{segment.fields, segment.displacement, segment.time_law, std::nullopt, {}, 0, 1};
  const Culling culling(whole);
  const Box box = segment.mask.box();
  if (culling.misses({box.center(), 0.5 * box.diagonal()})) return false;
  const MaskGrid& grid = segment.mask.grid();
  const double size = grid.spacing * kBrickCells;
  const auto [nx, ny, nz] = grid.bricks;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      for (int x = 0; x < nx; ++x) {
        if (grid.start[static_cast<std::size_t>(x + nx * (y + ny * z))] == 0) continue;
        const Vec3d middle = grid.origin + Vec3d{x + 0.5, y + 0.5, z + 0.5} * size;
        if (!culling.misses({middle, 0.87 * size})) return true;
      }
    }
  }
  return false;
}

// A box beyond which a field is 0 from t = 0 to 1; all of space for regions without bounds.
Box support_of(const Field& field, const Vec3d& displacement) {
  constexpr double kFar = 1e300;
  Box box;
  double reach = field.thresholds.outer;
  if (std::holds_alternative<Ball<double>>(field.region)) {
    box.extend({0, 0, 0});
  } else if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) {
    box.extend(capsule->half_axis);
    box.extend(-capsule->half_axis);
  } else if (const auto* set = std::get_if<PointSet<double>>(&field.region)) {
    const Surround elements = surround_of(*set);
    box.extend(elements.center);
    reach = elements.radius + support_reach(*set, field.thresholds.outer);
  } else {
    return {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  }
  const Vec3d by{reach, reach, reach};
  box = {box.min + field.center - by, box.max + field.center + by};
  Box moved = box;
  moved.extend(box.min + displacement);
  moved.extend(box.max + displacement);
  return moved;
}

bool contains(const Box& box, const Vec3d& p) {
  return p.x >= box.min.x && p.y >= box.min.y && p.z >= box.min.z && p.x <= box.max.x && p.y <= box.max.y &&
         p.z <= box.max.z;
}

// At most so many, evenly through the list.
std::vector<const MaskBorder*> border_in(const MaskGrid& grid, const Box& box) {
  std::vector<const MaskBorder*> all;
  for (const MaskBorder& part : grid.border) {
    if (contains(box, part.place)) all.push_back(&part);
  }
  const std::size_t stride = (all.size() + kMostBorder - 1) / kMostBorder;
  if (stride <= 1) return all;
  std::vector<const MaskBorder*> some;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  return some;
}

// The least squares of one field: (of_border + of_region) offset = of_border A.
class Offset {
 public:
  Offset(const Segment& segment, const Field& field) : segment_(segment), field_(field) {}

  Vec3d find() {
    const Mask& mask = segment_.mask;
    const Box support = support_of(field_, segment_.displacement);
    const std::vector<const MaskBorder*> border = border_in(mask.grid(), support);
    Box around = mask.box();
    const double margin = 0.25 * around.diagonal();
    around = {around.min - Vec3d{margin, margin, margin}, around.max + Vec3d{margin, margin, margin}};
    if (support.max.x < 1e200) around = support;
    const std::span<const double> moments =
        rests(segment_) ? std::span<const double>(kMoments).first(1) : std::span<const double>(kMoments);
    for (const double t : moments) {
      for (const MaskBorder* part : border) add_border(*part, t);
    }
    if (!(trace(border_) > 0)) return {0, 0, 0};
    for (const double t : moments) add_region(around, t);
    return solve();
  }

 private:
  Vec3d from_center(const Vec3d& x, double t) const { return x - field_.center - segment_.displacement * t; }

  void add_border(const MaskBorder& part, double t) {
    const Vec3d d = from_center(part.place, t);
    const double w = blend_weight(region_value(field_, d, t).value, field_.thresholds).value;
    if (w == 0) return;
    const Vec3d a = std::visit([&](const auto& motion) { return evaluate(motion, d).potential; }, field_.motion);
    border_ = border_ + part.across * (w * w);
    right_ += (part.across * a) * (w * w);
  }

  void add_region(const Box& box, double t) {
    const Vec3d cell = (box.max - box.min) / kPlaces;
    const double volume = cell.x * cell.y * cell.z;
    for (int n = 0; n < kPlaces * kPlaces * kPlaces; ++n) {
      const Vec3d at{n % kPlaces + 0.5, n / kPlaces % kPlaces + 0.5, n / (kPlaces * kPlaces) + 0.5};
      const Vec3d x = box.min + Vec3d{at.x * cell.x, at.y * cell.y, at.z * cell.z};
      const RegionValue<double> r = region_value(field_, from_center(x, t), t);
      const double slope = blend_weight(r.value, field_.thresholds).derivative;
      if (slope == 0) continue;
      const Vec3d g = r.gradient * (slope * segment_.mask.at(x).value);
      const double square = norm2(g) * volume;
      region_ = region_ + Mat3d{Vec3d{square, 0, 0} - g * (g.x * volume), Vec3d{0, square, 0} - g * (g.y * volume),
                                Vec3d{0, 0, square} - g * (g.z * volume)};
    }
  }

  Vec3d solve() const {
    const double ridge = 1e-9 * (trace(border_) + trace(region_));
    const Mat3d left = border_ + region_ + Mat3d{{ridge, 0, 0}, {0, ridge, 0}, {0, 0, ridge}};
    const Vec3d a = cross(left.row1, left.row2);
    const Vec3d b = cross(left.row2, left.row0);
    const Vec3d c = cross(left.row0, left.row1);
    const double det = dot(left.row0, a);
    if (!(det > 0)) return {0, 0, 0};
    return (a * right_.x + b * right_.y + c * right_.z) / det;
  }

  const Segment& segment_;
  const Field& field_;
  Mat3d border_{{}, {}, {}};
  Mat3d region_{{}, {}, {}};
  Vec3d right_{0, 0, 0};
};

}  // namespace

SegmentMask mask_on(const Segment& segment) {
  SegmentMask result;
  result.acts = !segment.mask.is_empty() && reaches(segment);
  if (!result.acts) return result;
  for (const Field& field : segment.fields) result.offsets.push_back(Offset(segment, field).find());
  return result;
}

BorderSpeed border_speed(const Segment& segment, std::span<const Vec3d> points) {
  const SegmentMask mask = mask_on(segment);
  BorderSpeed result;
  if (!mask.acts) return result;
  const bool swept = segment.time_law == TimeLaw::swept;
  for (const Vec3d& x : points) {
    const MaskValue<double> m = segment.mask.at(x);
    for (const double t : {0.0, 0.5, 1.0}) {
      Vec3d with{0, 0, 0};
      Vec3d without{0, 0, 0};
      for (std::size_t i = 0; i < segment.fields.size(); ++i) {
        const Field& field = segment.fields[i];
        const Vec3d d = x - field.center - segment.displacement * (swept ? t : 0);
        const RegionValue<double> r = region_value(field, d, t);
        std::visit(
            [&](const auto& motion) {
              with += masked_velocity_where(r, motion, field.thresholds, d, m, mask.offsets[i]);
              without += velocity_where(r, motion, field.thresholds, d);
            },
            field.motion);
      }
      if (m.value > 0 && m.value < 1) result.at_border = std::max(result.at_border, norm(with));
      result.of_tool = std::max(result.of_tool, norm(without));
    }
  }
  return result;
}

}  // namespace knead::detail
