// Packs the bounds of fields, the pins of segments, and the trees of point sets into the numbers that the shaders read.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <variant>

#include "flow/culling.h"
#include "flow/pins.h"
#include "flow/segment_mover.h"
#include "flow/sets.h"
#include "flow/step_rule.h"
#include "gpu/packed.h"
#include "knead/vec.h"

namespace knead::gpu {

namespace {

using namespace layout;
using detail::OwnedPins;
using detail::PinPiece;
using detail::PointTree;

constexpr double kUnbounded = 1e300;
constexpr std::size_t kMaxPins = 4096;  // in a call of a shader, times pieces: graphics drivers stop calls of seconds
constexpr std::size_t kMinTreePoints = 1000;
constexpr double kRounding = 1e-6;    // several times that of float, so that a node's ball contains its points
constexpr std::size_t kSamples = 16;  // places at which the cost of a tree is estimated

// The support of a field during a segment.
struct FieldBounds {
  Vec3d from;
  Vec3d path;             // or a normal
  double radius = 0;      // around the path, or the position along the normal
  double per_path2 = -1;  // 1 / |path|^2, 0 for no path; -1: a normal
};

FieldBounds around_path(const Vec3d& from, const Vec3d& path, double radius) {
  return {from, path, radius, norm2(path) > 0 ? 1 / norm2(path) : 0.0};
}

FieldBounds bounds_of(const Field& field, const Segment& segment) {
  const bool blended = segment.time_law == TimeLaw::blended;
  const double begin = blended ? 0 : segment.begin;
  const double end = blended ? 1 : segment.end;
  const Vec3d displacement = displacement_of(segment, field);
  const Vec3d from = field.center + displacement * begin;
  const Vec3d path = displacement * (end - begin);
  const double outer = field.thresholds.outer;
  const double slack = 1e-6 * std::abs(outer) + 1e-12 * (norm(from) + norm(path));
  if (std::holds_alternative<Ball<double>>(field.region)) return around_path(from, path, outer + slack);
  if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) {
    return around_path(from, path, outer + norm(capsule->half_axis) * (1 + 1e-6) + slack);
  }
  if (const auto* set = std::get_if<PointSet<double>>(&field.region)) {
    const detail::Surround ball = detail::surround_of(*set);
    const double radius = ball.radius * (1 + 1e-6) + detail::support_radius(*set, outer) * (1 + 1e-4);
    return around_path(from + ball.center, path, radius + slack);
  }
  const auto* space = std::get_if<HalfSpace<double>>(&field.region);
  if (space == nullptr || space->turn_angle != 0) return {from, {}, kUnbounded, 0};
  return {dot(space->normal, path) > 0 ? from + path : from, space->normal, outer + slack, -1};
}

Vec3d middle_of(const Segment& segment) {
  Box box;
  for (const Field& pin : segment.fields) box.extend(pin.center);
  return box.center();
}

// Fills one pack with pieces of the segment's time, each as a segment of its own.
class PinPacker {
 public:
  PinPacker(const Segment& segment, const AdvectOptions& options)
      : segment_(segment), options_(options), middle_(middle_of(segment)), pins_(segment.fields.size()) {}

  PackedSegments run(std::span<const PinPiece> pieces) {
    packed_ = {};
    packed_.count = static_cast<int>(pieces.size());
    packed_.numbers.resize(pieces.size() * kSegmentNumbers);
    packed_.places.resize(pieces.size() * (kSegmentPlaces + pins_ * kFieldBounds));
    packed_.table.resize(pieces.size() * (kSegmentEntries + pins_ * kFieldEntries));
    Segment part = segment_;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      part.begin = pieces[i].begin;
      part.end = pieces[i].end;
      if (segment_.end < segment_.begin) std::swap(part.begin, part.end);
      const std::size_t table = pieces.size() * kSegmentEntries + i * pins_ * kFieldEntries;
      const std::size_t bounds = pieces.size() * kSegmentPlaces + i * pins_ * kFieldBounds;
      const OwnedPins<double> pins(part, pieces[i], middle_, false);
      put_part(part, pins, i, table);
      put_pins(part, pins, table, bounds);
    }
    return std::move(packed_);
  }

 private:
  void put_part(const Segment& part, const OwnedPins<double>& pins, std::size_t i, std::size_t table) {
    double speed = 0;
    for (const detail::ExactPin& pin : pins.exact) speed = std::max(speed, pin.speed);
    double* const numbers = packed_.numbers.data() + i * kSegmentNumbers;
    numbers[3] = speed;
    numbers[kReach] = detail::reach_of_step(part);
    numbers[kTolerance] = detail::kErrorShare * options_.tolerance;
    numbers[kMin] = kMinMotion * pins.field.radius;
    numbers[kPerRadius] = pins.field.per_radius;
    numbers[kMiddle] = pins.field.middle;
    numbers[kBegin] = part.begin;
    numbers[kEnd] = part.end;
    numbers[kPerHalf] = pins.field.per_half;
    put(packed_.places, i * kSegmentPlaces, middle_);
    std::int32_t* const entries = packed_.table.data() + i * kSegmentEntries;
    entries[0] = static_cast<std::int32_t>(pins_);
    entries[1] = static_cast<std::int32_t>(table);
    entries[3] = static_cast<std::int32_t>(i * kSegmentNumbers);
  }

  // Writes the pins' numbers, then those of the turns.
  void put_pins(const Segment& part, const OwnedPins<double>& pins, std::size_t table, std::size_t bounds) {
    const std::size_t begin = packed_.numbers.size();
    packed_.numbers.insert(packed_.numbers.end(), pins.numbers.begin(), pins.numbers.end());
    const std::size_t turns = packed_.numbers.size();
    packed_.numbers.insert(packed_.numbers.end(), pins.turn_numbers.begin(), pins.turn_numbers.end());
    for (std::size_t pin = 0; pin < pins_; ++pin) {
      std::int32_t* const entries = packed_.table.data() + table + pin * kFieldEntries;
      const std::size_t own_bounds = bounds + pin * kFieldBounds;
      entries[kFieldBegin] = static_cast<std::int32_t>(begin) + static_cast<std::int32_t>(pin) * pins.field.pins.stride;
      entries[kBounds] = static_cast<std::int32_t>(own_bounds);
      entries[kDegree] = pins.field.degree;
      entries[kFirstTurn] = static_cast<std::int32_t>(turns);
      entries[kTurns] = pins.field.turns.count;
      put_bounds(packed_.places, own_bounds, part.fields[pin], part);
    }
  }

  const Segment& segment_;
  const AdvectOptions& options_;
  Vec3d middle_;
  std::size_t pins_;
  PackedSegments packed_;
};

// Returns the allowed relative error of a sum where r < outer.
double error_allowed(const Field& field, const Segment& segment, const AdvectOptions& options) {
  const auto& set = std::get<PointSet<double>>(field.region);
  const double inner = field.thresholds.inner;
  const double outer = field.thresholds.outer;
  const detail::Surround ball = detail::surround_of(set);
  const double arm = norm(ball.center) + ball.radius + detail::support_radius(set, outer);
  const double duration = segment.limit_cylinder ? 1 : std::abs(segment.end - segment.begin);
  const double length = norm(std::get<Translation<double>>(field.motion).velocity) * duration;
  const double error =
      detail::kSumsShareOfTolerance * options.tolerance / static_cast<double>(segment.fields.size()) / length;
  const double epsilon = options.precision == Precision::float32 ? std::numeric_limits<float>::epsilon()
                                                                 : std::numeric_limits<double>::epsilon();
  return detail::sum_error_allowed({field.thresholds, set.exponent, inner, outer, arm}, error, epsilon);
}

// Returns the node after the subtree of each node.
std::vector<std::uint32_t> nodes_after(const PointTree& tree) {
  std::vector<std::uint32_t> after(tree.nodes().size());
  after[0] = static_cast<std::uint32_t>(after.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    const PointTree::Node& node = tree.nodes()[i];
    if (node.left == 0) continue;
    after[node.left] = node.right;
    after[node.right] = after[i];
  }
  return after;
}

// Returns the number of nodes and of groups of four points that the shader visits at d, where r is about `scale`.
std::size_t rounds_at(const PointTree& tree, const std::vector<std::uint32_t>& after, const Vec3d& d, double scale,
                      double error_of_one, int exponent) {
  std::size_t rounds = 0;
  for (std::uint32_t i = 0; i < after.size(); ++rounds) {
    const PointTree::Node& node = tree.nodes()[i];
    const double nearest = norm(d - node.centroid) - node.radius;
    const double term = std::pow(scale / nearest, exponent);
    const double remainder = term * 0.5 * exponent * (exponent + 1) * node.mean_square / (nearest * nearest);
    const bool is_far = nearest > 0 && std::min(term, remainder) <= error_of_one;
    if (!is_far && node.left == 0) rounds += (node.end - node.begin + 3) / 4;
    i = is_far || node.left == 0 ? after[i] : i + 1;
  }
  return rounds;
}

// Returns whether the tree is faster than all points, at places with r of about half of outer.
bool pays(const PointTree& tree, const std::vector<std::uint32_t>& after, double error_of_one, double outer,
          int exponent) {
  std::size_t rounds = 0;
  for (std::size_t k = 0; k < kSamples; ++k) {
    const auto side = [k](std::size_t bit) { return (k >> bit & 1) != 0 ? 0.5 : -0.5; };
    const Vec3d away = Vec3d{side(0), side(1), side(2)} * (outer / std::sqrt(3.0));
    const Vec3d& p = tree.points()[k * tree.size() / kSamples];
    rounds += rounds_at(tree, after, p + away, 0.5 * outer, error_of_one, exponent);
  }
  return rounds < kSamples * tree.size() / 4;
}

}  // namespace

void put(std::vector<double>& to, std::size_t at, const Vec3d& v) {
  to[at] = v.x;
  to[at + 1] = v.y;
  to[at + 2] = v.z;
}

void put(std::vector<double>& to, std::size_t at, const Mat3d& m) {
  put(to, at, m.row0);
  put(to, at + 3, m.row1);
  put(to, at + 6, m.row2);
}

void put_bounds(std::vector<double>& places, std::size_t at, const Field& field, const Segment& segment) {
  const FieldBounds bounds = bounds_of(field, segment);
  put(places, at, bounds.from);
  put(places, at + 3, bounds.path);
  places[at + 6] = bounds.radius;
  places[at + 7] = bounds.per_path2;
}

std::vector<PackedSegments> pack_pins(const Segment& segment, const AdvectOptions& options) {
  std::vector<PinPiece> pieces = detail::solve_pins(segment, options.tolerance, options.progress);
  if (segment.end < segment.begin) std::reverse(pieces.begin(), pieces.end());
  PinPacker packer(segment, options);
  const std::size_t length = std::max<std::size_t>(kMaxPins / segment.fields.size(), 1);
  std::vector<PackedSegments> packs;
  for (std::span<const PinPiece> rest = pieces; !rest.empty();) {
    const std::span<const PinPiece> next = rest.first(std::min(length, rest.size()));
    packs.push_back(packer.run(next));
    rest = rest.subspan(next.size());
  }
  return packs;
}

bool may_have_tree(const Field& field, const Segment& segment) {
  const auto* set = std::get_if<PointSet<double>>(&field.region);
  return set != nullptr && set->curves.empty() && set->points.size() >= kMinTreePoints &&
         segment.time_law == TimeLaw::swept && std::holds_alternative<Translation<double>>(field.motion);
}

PackedTree pack_tree(const Field& field, const Segment& segment, const AdvectOptions& options) {
  const auto& set = std::get<PointSet<double>>(field.region);
  const PointTree tree(set.points);
  const std::vector<std::uint32_t> after = nodes_after(tree);
  PackedTree packed;
  packed.error_of_one = error_allowed(field, segment, options) / static_cast<double>(tree.size());
  if (!pays(tree, after, packed.error_of_one, field.thresholds.outer, set.exponent)) return packed;
  packed.nodes = static_cast<std::int32_t>(after.size());
  packed.points.assign(tree.points().begin(), tree.points().end());
  const double m = set.exponent;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const PointTree::Node& node = tree.nodes()[i];
    const double radius = node.radius + kRounding * (node.radius + norm(node.centroid));
    packed.numbers.insert(packed.numbers.end(), {node.centroid.x, node.centroid.y, node.centroid.z, radius,
                                                 0.5 * m * (m + 1) * node.mean_square});
    for (const std::uint32_t number : {after[i], 3 * node.begin, 3 * node.end, node.right}) {
      packed.entries.push_back(static_cast<std::int32_t>(number));
    }
  }
  return packed;
}

}  // namespace knead::gpu
