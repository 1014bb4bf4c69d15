#include "knead/gpu/packed_bounds.h"

#include <cmath>
#include <variant>

#include "knead/flow/culling.h"

namespace knead::gpu {

namespace {

// Reaches everything.
constexpr double kEverywhere = 1e300;

// Where a resting field's region, or a moving one's on its whole way, can be felt.
struct FieldBounds {
  Vec3d from;
  Vec3d way;          // or a normal
  double reach = 0;   // of the distance from the way, or along the normal
  double along = -1;  // 1 / |way|^2, 0 for no way; -1: a normal
};

FieldBounds along_the_way(const Vec3d& from, const Vec3d& way, double reach) {
  return {from, way, reach, norm2(way) > 0 ? 1 / norm2(way) : 0.0};
}

FieldBounds bounds_of(const Field& field, const Segment& segment) {
  const bool blended = segment.time_law == TimeLaw::blended;
  const double begin = blended ? 0 : segment.begin;
  const double end = blended ? 1 : segment.end;
  const Vec3d displacement = displacement_of(segment, field);
  const Vec3d from = field.center + displacement * begin;
  const Vec3d way = displacement * (end - begin);
  const double outer = field.thresholds.outer;
  const double slack = 1e-6 * std::abs(outer) + 1e-12 * (norm(from) + norm(way));
  if (std::holds_alternative<Ball<double>>(field.region)) return along_the_way(from, way, outer + slack);
  if (const auto* capsule = std::get_if<Capsule<double>>(&field.region)) {
    return along_the_way(from, way, outer + norm(capsule->half_axis) * (1 + 1e-6) + slack);
  }
  if (const auto* set = std::get_if<PointSet<double>>(&field.region)) {
    const detail::Surround ball = detail::surround_of(*set);
    const double reach = ball.radius * (1 + 1e-6) + detail::support_reach(*set, outer) * (1 + 1e-4);
    return along_the_way(from + ball.center, way, reach + slack);
  }
  const auto* space = std::get_if<HalfSpace<double>>(&field.region);
  if (space == nullptr || space->turn_angle != 0) return {from, {}, kEverywhere, 0};
  return {dot(space->normal, way) > 0 ? from + way : from, space->normal, outer + slack, -1};
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
  put(places, at + 3, bounds.way);
  places[at + 6] = bounds.reach;
  places[at + 7] = bounds.along;
}

}  // namespace knead::gpu
