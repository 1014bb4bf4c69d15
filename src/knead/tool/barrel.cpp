#include "knead/tool/barrel.h"

#include <limits>
#include <vector>

#include "knead/field/region.h"
#include "knead/tool/barrel_reach.h"
#include "knead/tool/describe.h"

namespace knead {

namespace {

using tool_detail::crosses;
using tool_detail::merged_reaches;
using tool_detail::Reach;
using tool_detail::reach_of;
using tool_detail::Round;
using tool_detail::short_number_between;

void suggest(const std::vector<Reach>& merged, double radius, BarrelCheck& check) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  while (at + 1 < merged.size() && merged[at + 1].min <= radius) ++at;
  for (std::size_t i = at; i > 0 && !check.smaller; --i) {
    check.smaller = short_number_between(merged[i - 1].max, merged[i].min, merged[i].min, Round::down);
  }
  for (std::size_t i = at; i < merged.size() && !check.larger; ++i) {
    check.larger = short_number_between(merged[i].max, i + 1 < merged.size() ? merged[i + 1].min : kInfinity,
                                        merged[i].max, Round::up);
  }
}

// n(1) of a bend; a twist's normal rests.
Vec3d last_normal(const Field& field) { return normal_at(std::get<HalfSpace<double>>(field.region), 1.0); }

}  // namespace

std::optional<Barrel> barrel_of(const Stroke& stroke) {
  const auto* twist = std::get_if<TwistStroke>(&stroke);
  const auto* bend = std::get_if<BendStroke>(&stroke);
  if ((twist == nullptr || !twist->radius) && (bend == nullptr || !bend->radius)) return std::nullopt;
  if (reads_surface(stroke)) return std::nullopt;
  const Flow flow = flow_of(stroke);
  const Segment& segment = flow.segments.front();
  const Field& field = segment.fields.front();
  return Barrel{segment.barrel->point, segment.barrel->direction, segment.barrel->radius, field.thresholds.outer,
                last_normal(field)};
}

BarrelCheck check_barrel(const Barrel& barrel, std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  check_triangles(triangles, positions);
  BarrelCheck check;
  const bool turns = barrel.last_normal != barrel.normal;
  for (const Triangle& triangle : triangles) {
    if (crosses(reach_of(barrel, barrel.normal, positions, triangle), barrel.radius)) {
      ++check.crossing;
    } else if (turns && crosses(reach_of(barrel, barrel.last_normal, positions, triangle), barrel.radius)) {
      ++check.later;
    }
  }
  if (check.crossing > 0) suggest(merged_reaches(barrel, positions, triangles), barrel.radius, check);
  return check;
}

std::optional<double> nearest_radius(const BarrelCheck& check, double radius) {
  if (!check.smaller) return check.larger;
  if (!check.larger) return check.smaller;
  return radius - *check.smaller < *check.larger - radius ? check.smaller : check.larger;
}

}  // namespace knead
