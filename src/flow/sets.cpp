// The cells of point sets' fields, and the tree from which their lists are drawn.
#include "flow/sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "field/point_sums.h"
#include "flow/culling.h"
#include "flow/step_rule.h"
#include "knead/vec.h"

namespace knead::detail {

namespace {

constexpr double kMaxMaskedSpeed = 3;  // along a mask's border, by the tool's speed; a stroke beyond it gets a warning
constexpr double kCellsPerOuter = 6;   // of the narrowest field
constexpr double kMaxCells = 1 << 18;
constexpr double kTraceResolution = 1e-4;  // that of contact.cpp
constexpr double kRounding = 1e-4;         // of a cell's bounds; far above the rounding of S
constexpr std::uint32_t kMaxLeafPoints = kPointPack;

// Returns the factor by which r grows or falls at most if the true distance changes by the ratio.
double power_of_growth(double ratio, bool curves) { return curves ? ratio * std::sqrt(std::sqrt(ratio)) : ratio; }

Vec3d clamped(const Vec3d& p, const Box& box) {
  return {std::clamp(p.x, box.min.x, box.max.x), std::clamp(p.y, box.min.y, box.max.y),
          std::clamp(p.z, box.min.z, box.max.z)};
}

Box grown(const Box& box, double by) { return {box.min - Vec3d{by, by, by}, box.max + Vec3d{by, by, by}}; }

// The first s >= 0 at which d + s velocity is in the box, infinity if never.
double time_to_enter(const Box& box, const Vec3d& d, const Vec3d& velocity) {
  double enter = 0;
  double leave = kInfinity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (velocity[axis] == 0) {
      if (d[axis] < box.min[axis] || d[axis] > box.max[axis]) return kInfinity;
      continue;
    }
    const double low = (box.min[axis] - d[axis]) / velocity[axis];
    const double high = (box.max[axis] - d[axis]) / velocity[axis];
    enter = std::max(enter, std::min(low, high));
    leave = std::min(leave, std::max(low, high));
  }
  return enter <= leave ? enter : kInfinity;
}

// The first s >= 0 at which d + s velocity is no longer in the cube, infinity if never.
double time_to_leave(const Vec3d& center, double half, const Vec3d& d, const Vec3d& velocity) {
  double leave = kInfinity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (velocity[axis] == 0) continue;
    const double wall = center[axis] + (velocity[axis] > 0 ? half : -half);
    leave = std::min(leave, std::max(0.0, (wall - d[axis]) / velocity[axis]));
  }
  return leave;
}

}  // namespace

bool is_of_sets(const Segment& segment) {
  return segment.time_law == TimeLaw::swept &&
         std::all_of(segment.fields.begin(), segment.fields.end(), [](const Field& field) {
           return std::holds_alternative<Translation<double>>(field.motion) &&
                  std::holds_alternative<PointSet<double>>(field.region);
         });
}

template <class S>
SetCells<S>::SetCells(const Segment& segment, double tolerance, const SegmentMask& mask)
    : anchor_(segment.fields.front().center),
      displacement_(segment.displacement),
      duration_(segment.limit_cylinder ? 1 : std::abs(segment.end - segment.begin)) {
  const double error = kSumsShareOfTolerance * tolerance / static_cast<double>(segment.fields.size());
  for (const Field& field : segment.fields) parts_.push_back(make_part(field, error));
  for (std::size_t i = 0; mask.acts && i < parts_.size(); ++i) {
    parts_[i].field.mask = view_of<S>(segment.mask, segment.fields[i].center);
    parts_[i].field.offset = Vec3<S>(mask.offsets[i]);
  }
  lay_grid();
}

template <class S>
SetCells<S>::~SetCells() {
  for (int i = 0; i < cell_count(); ++i) delete cells_[i].load();
}

template <class S>
typename SetCells<S>::Part SetCells<S>::make_part(const Field& field, double error) const {
  const auto& motion = std::get<Translation<double>>(field.motion);
  const auto& set = std::get<PointSet<double>>(field.region);
  const bool listed = set.points.size() >= kMinListedPoints;
  Part part{{static_cast<Translation<S>>(motion),
             packed<S>(set),
             static_cast<Thresholds<S>>(field.thresholds),
             field.center,
             Vec3<S>(displacement_),
             false,
             {},
             {}},
            field.center - anchor_,
            bounding_box(set.points),
            0,
            0,
            field.thresholds.outer,
            PointTree(listed ? set.points : std::vector<Vec3d>{})};
  for (const auto& curve : set.curves) {
    for (const Vec3d& p : curve) part.box.extend(p);
  }
  part.radius = support_radius(set, part.outer) * (1 + kRounding);
  part.error = error / (norm(motion.velocity) * duration_);
  return part;
}

template <class S>
void SetCells<S>::lay_grid() {
  double outer = kInfinity;
  double speed = 0;  // an upper bound of that relative to the tool
  double width = kInfinity;
  for (const Part& part : parts_) {
    const double own_width = static_cast<double>(part.field.thresholds.outer) - part.field.thresholds.inner;
    const double arm = 0.5 * (part.radius + norm(part.box.max - part.box.min));
    outer = std::min(outer, part.outer);
    width = std::min(width, own_width);
    speed += norm(Vec3d(part.field.motion.velocity)) *
             (1 + greatest_slope(0, part.field.thresholds.falloff) / own_width * arm);
  }
  if (!parts_.front().field.mask.is_empty()) speed *= kMaxMaskedSpeed;
  speed += norm(displacement_);
  const double whole_path = speed * duration_;
  size_ = outer / kCellsPerOuter;
  const double step = 0.2 * width;  // path lines' steps pass 0.16 of it
  const bool stays = whole_path <= step;
  excursion_ = stays ? whole_path : step;
  for (const Part& part : parts_) {
    const Box support = grown(part.box, part.radius);
    box_.extend(support.min + part.offset);
    box_.extend(support.max + part.offset);
  }
  const Vec3d extent = box_.max - box_.min;
  const auto count = [&](double length) { return std::floor(length / size_) + 1; };
  while (count(extent.x) * count(extent.y) * count(extent.z) > kMaxCells) size_ *= 1.25;
  inverse_size_ = 1 / size_;
  home_ = stays ? 0.5 * size_ + whole_path : 0.75 * size_;
  radius_ = std::sqrt(3.0) * (stays ? 0.5 : 0.75) * size_ + excursion_;
  for (std::size_t axis = 0; axis < 3; ++axis) counts_[axis] = static_cast<int>(count(extent[axis]));
  cells_ = std::make_unique<std::atomic<const SetCell<S>*>[]>(counts_[0] * counts_[1] * counts_[2]);
}

template <class S>
bool SetCells<S>::holds(Place place, const Vec3d& d) const {
  if (place == nullptr) return false;
  const Vec3d from = d - place->center;
  return std::max({std::abs(from.x), std::abs(from.y), std::abs(from.z)}) <= home_;
}

template <class S>
typename SetCells<S>::Place SetCells<S>::cell_at(const Vec3d& d) const {
  const Vec3d from = (d - box_.min) * inverse_size_;
  int index = 0;
  Vec3d center;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(from[axis] >= 0 && from[axis] < counts_[axis])) return nullptr;
    const int i = static_cast<int>(from[axis]);
    index = index * counts_[axis] + i;
    center[axis] = box_.min[axis] + (i + 0.5) * size_;
  }
  const SetCell<S>* cell = cells_[index].load(std::memory_order_acquire);
  if (cell != nullptr) return cell;
  std::unique_ptr<SetCell<S>> made = make_cell(center);
  made->index = index;
  // Another thread may have made the same meanwhile.
  if (cells_[index].compare_exchange_strong(cell, made.get(), std::memory_order_acq_rel)) return made.release();
  return cell;
}

template <class S>
std::unique_ptr<SetCell<S>> SetCells<S>::make_cell(const Vec3d& center) const {
  auto cell = std::make_unique<SetCell<S>>();
  cell->center = center;
  for (const Part& part : parts_) add_part(part, *cell);
  return cell;
}

template <class S>
void SetCells<S>::add_part(const Part& part, SetCell<S>& cell) const {
  const Vec3d center = cell.center - part.offset;
  if (norm(center - clamped(center, part.box)) - radius_ >= part.radius) return;
  const PackedSet<S>& whole = part.field.region;
  const bool curves = !whole.curves->empty();
  const Vec3<S> d(center);
  const double nearest = std::sqrt(static_cast<double>(least_squared_distance(whole, d)));
  const RegionValue<S> at_center = evaluate(whole, d, S(0));
  const double r = static_cast<double>(at_center.value);
  const double least = nearest > radius_ ? r * power_of_growth(1 - radius_ / nearest, curves) : 0;
  if (least * (1 - kRounding) >= part.outer) return;
  // For points alone r rises at most as fast as the distance; from an element itself, where r = 0, by the radius.
  const double most = nearest > 0 ? r * power_of_growth(1 + radius_ / nearest, curves) : (curves ? kInfinity : radius_);
  cell.inside = cell.inside || most * (1 + kRounding) < part.outer;
  cell.fields.push_back(part.field);
  PackedSet<S>& set = cell.fields.back().region;
  if (part.tree.size() > 0 && std::isfinite(most)) {
    std::vector<WeightedPoint> list;
    const Thresholds<double> thresholds{part.field.thresholds.inner, part.outer, part.field.thresholds.falloff};
    const SumPlaces places{thresholds, whole.exponent, least, most, norm(center) + radius_};
    part.tree.list({center, radius_, r * (1 + kRounding), Vec3d(at_center.gradient), nearest, most * (1 + kRounding),
                    !curves, whole.exponent, sum_error_allowed(places, part.error, std::numeric_limits<S>::epsilon())},
                   list);
    if (4 * list.size() < 3 * part.tree.size()) {
      auto points = std::make_shared<PointPacks<S>>();
      for (const WeightedPoint& p : list) points->push_back(Vec3<S>(p.p), static_cast<S>(p.weight));
      set.points = std::move(points);
    }
  }
  // An upper bound of the distance from the nearest element. Where that is far smaller, evaluate() detects an overflow.
  set.scale = static_cast<S>(nearest + radius_);
}

// Returns the time that may pass before r of any field can be below outer, while d moves from the cell at the velocity.
template <class S>
double SetCells<S>::safe_advance(Place place, const Vec3d& d, const Vec3d& velocity) const {
  const double speed = norm(velocity);
  double safe = time_to_leave(place->center, home_, d, velocity);
  for (const SetField<S>& field : place->fields) {
    const Vec3<S> own(d + anchor_ - field.center);
    const double outer = field.thresholds.outer;
    const double width = outer - static_cast<double>(field.thresholds.inner);
    const double r = static_cast<double>(evaluate(field.region, own, S(0)).value);
    if (r < outer + kTraceResolution * width) return 0;
    double free = r - outer;
    if (!field.region.curves->empty()) {  // as in contact.cpp
      const double nearest = std::sqrt(static_cast<double>(least_squared_distance(field.region, own)));
      free = 0.8 * nearest * (1 - outer / r);
    }
    safe = std::min(safe, free / speed);
  }
  return std::max(safe, 1e-6 * size_ / speed);  // passes a wall in spite of rounding
}

template <class S>
std::optional<double> SetCells<S>::next_contact(Place& place, const Segment& segment, const Vec3d& x, double t) const {
  const double direction = segment.end >= segment.begin ? 1.0 : -1.0;
  const double advance = std::abs(segment.end - t);
  const Vec3d velocity = displacement_ * -direction;
  const Vec3d from = in_tool(x, t);
  for (double s = 0; s < advance;) {
    const Vec3d d = from + velocity * s;
    if (!holds(place, d)) place = cell_at(d);
    if (place != nullptr && place->inside) return t + direction * s;
    double safe = 0;
    if (place == nullptr) {
      safe = time_to_enter(box_, d, velocity);
      if (std::isfinite(safe)) safe += 1e-6 * size_ / norm(velocity);
    } else {
      safe = safe_advance(place, d, velocity);
      if (safe == 0) return t + direction * s;
    }
    if (!std::isfinite(safe)) return std::nullopt;  // the tool rests
    s += safe;
  }
  return std::nullopt;
}

template <class S>
bool SetCells<S>::keeps(Place& place, const Vec3d& x, double t) const {
  const Vec3d d = in_tool(x, t);
  if (holds(place, d)) return true;
  const Place before = place;
  place = cell_at(d);
  return place == before;
}

template class SetCells<float>;
template class SetCells<double>;

PointTree::PointTree(std::span<const Vec3d> points) : points_(points.begin(), points.end()) {
  nodes_.reserve(points_.size());
  if (!points_.empty()) build(0, static_cast<std::uint32_t>(points_.size()));
}

std::uint32_t PointTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  const std::span<Vec3d> own(points_.data() + begin, end - begin);
  Node node;
  node.begin = begin;
  node.end = end;
  for (const Vec3d& p : own) node.centroid += p;
  node.centroid = node.centroid / static_cast<double>(own.size());
  double greatest = 0;
  for (const Vec3d& p : own) {
    const double square = norm2(p - node.centroid);
    greatest = std::max(greatest, square);
    node.mean_square += square / static_cast<double>(own.size());
  }
  node.radius = std::sqrt(greatest);
  nodes_.push_back(node);
  if (own.size() <= kMaxLeafPoints) return index;
  const Box box = bounding_box(own);
  const Vec3d size = box.max - box.min;
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  // Whole packs on the left.
  const std::uint32_t middle = begin + ((end - begin) / 2 + kMaxLeafPoints - 1) / kMaxLeafPoints * kMaxLeafPoints;
  // A total order, so that all standard libraries sort alike.
  std::sort(own.begin(), own.end(), [axis](const Vec3d& p, const Vec3d& q) {
    return std::tie(p[axis], p.x, p.y, p.z) < std::tie(q[axis], q.x, q.y, q.z);
  });
  const std::uint32_t left = build(begin, middle);
  const std::uint32_t right = build(middle, end);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

// Returns an upper bound of r(x) / |x - p| for every x of the ball and p of the node; infinity if there is none.
// Let u be the direction from the node's centroid to the ball's centre, d their distance, and x = centre + delta. Then
// |x - centroid| >= d exp(u.delta/d - 0.78 (delta/d)^2) while |delta| <= d/2; and since r^-m is a sum of powers, by
// Jensen's inequality r(x) <= r exp(grad r.delta/r + (delta/nearest)^2/2). Together they are far sharper than the
// coarse bound, which changes both distances by the radius.
double PointTree::ratio_bound(const ListDemand& demand, const Node& node) {
  const Vec3d from = demand.center - node.centroid;
  const double distance = norm(from);
  const double least = distance - demand.radius;
  if (least <= node.radius) return kInfinity;
  const double spread = 1 - node.radius / least;
  const double coarse = demand.most / (least * spread);
  if (!demand.points_alone || 2 * demand.radius > demand.nearest) return coarse;
  const double at_nearest = demand.radius / demand.nearest;
  const double at_distance = demand.radius / distance;
  const Vec3d slope = demand.gradient / demand.r - from / (distance * distance);
  const double growth = norm(slope) * demand.radius + 0.5 * at_nearest * at_nearest + 0.78 * at_distance * at_distance;
  if (growth >= 1) return coarse;
  return std::min(coarse, demand.r / (distance * spread * (1 - growth)));  // exp(a) <= 1 / (1 - a)
}

// Makes the list with an error of at most `most_of_one` for each cluster. Returns the bound of the sum of all errors;
// stops if that exceeds demand.error.
double PointTree::list_by(const ListDemand& demand, double most_of_one, std::vector<WeightedPoint>& result) const {
  const double m = demand.exponent;
  double error = 0;
  std::array<std::uint32_t, 64> stack{};
  std::size_t height = 1;
  result.clear();
  while (height > 0 && error <= demand.error) {
    const Node& node = nodes_[stack[--height]];
    const double ratio = ratio_bound(demand, node);
    if (std::isfinite(ratio)) {
      double share = 0;
      positive_power(share, ratio * ratio, demand.exponent / 2);
      share *= node.end - node.begin;
      if (share <= most_of_one) {
        error += share;
        continue;
      }
      const double least = norm(demand.center - node.centroid) - node.radius - demand.radius;
      const double as_cluster = share * 0.5 * m * (m + 1) * node.mean_square / (least * least);
      if (as_cluster <= most_of_one && node.end - node.begin > 1) {
        error += as_cluster;
        result.push_back({node.centroid, static_cast<double>(node.end - node.begin)});
        continue;
      }
    }
    if (node.left == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) result.push_back({points_[i], 1.0});
      continue;
    }
    stack[height++] = node.right;
    stack[height++] = node.left;
  }
  return error;
}

void PointTree::list(const ListDemand& demand, std::vector<WeightedPoint>& result) const {
  result.clear();
  if (points_.empty()) return;
  double most_of_one = demand.error / 4;
  while (list_by(demand, most_of_one, result) > demand.error) most_of_one /= 4;
}

}  // namespace knead::detail
