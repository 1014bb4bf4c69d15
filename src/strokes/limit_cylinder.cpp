// Limit cylinders: which radius separates a part from the rest, and whether a surface is torn.
#include "strokes/limit_cylinder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/region.h"
#include "mesh/edges.h"
#include "strokes/describe.h"
#include "strokes/slice.h"

namespace knead {

namespace {

using namespace detail;

void suggest(const std::vector<DistanceRange>& merged, double radius, CylinderCheck& check) {
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

std::optional<StrokeCylinder> limit_cylinder_of(const Stroke& stroke) {
  if (!detail::has_zone(stroke) || reads_surface(stroke)) return std::nullopt;
  const Flow flow = flow_of(stroke);
  const Segment& segment = flow.segments.front();
  if (!segment.limit_cylinder) return std::nullopt;
  const Field& field = segment.fields.front();
  return StrokeCylinder{segment.limit_cylinder->center, segment.limit_cylinder->axis, segment.limit_cylinder->radius,
                        field.thresholds.outer, last_normal(field)};
}

CylinderCheck check_limit_cylinder(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                   std::span<const Triangle> triangles) {
  check_triangles(triangles, positions);
  CylinderCheck check;
  const bool turns = limit_cylinder.last_normal != limit_cylinder.normal;
  for (const Triangle& triangle : triangles) {
    if (crosses(range_of(limit_cylinder, limit_cylinder.normal, positions, triangle), limit_cylinder.radius)) {
      ++check.crossing;
    } else if (turns && crosses(range_of(limit_cylinder, limit_cylinder.last_normal, positions, triangle),
                                limit_cylinder.radius)) {
      ++check.later;
    }
  }
  if (check.crossing > 0) suggest(merged_ranges(limit_cylinder, positions, triangles), limit_cylinder.radius, check);
  return check;
}

std::optional<double> nearest_radius(const CylinderCheck& check, double radius) {
  if (!check.smaller) return check.larger;
  if (!check.larger) return check.smaller;
  return radius - *check.smaller < *check.larger - radius ? check.smaller : check.larger;
}

namespace {

// still: the stroke does not move the vertex, whether it is in the limit cylinder or not.
enum class Kind : std::uint8_t { still, moved, unmoved, open };

double distance_from_axis(const StrokeCylinder& limit_cylinder, const Vec3d& x) {
  return norm(cross(limit_cylinder.normal, x - limit_cylinder.center));
}

Kind kind_of(const StrokeCylinder& limit_cylinder, const Vec3d& deformed, const Vec3d& inverse_image, double slack) {
  if (deformed == inverse_image) return Kind::still;
  if (distance_from_axis(limit_cylinder, inverse_image) > limit_cylinder.radius + slack) return Kind::unmoved;
  const bool would_move = distance_from_axis(limit_cylinder, deformed) < limit_cylinder.radius - slack &&
                          dot(limit_cylinder.normal, deformed - limit_cylinder.center) < limit_cylinder.outer - slack;
  return would_move ? Kind::moved : Kind::open;
}

template <class Visit>
void for_each_side(std::span<const Triangle> triangles, Visit visit) {
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) visit(triangle[i], triangle[(i + 1) % 3]);
  }
}

}  // namespace

std::vector<bool> limit_cylinder_members(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> deformed,
                                         std::span<const Vec3d> inverse_image, std::span<const Triangle> triangles,
                                         double slack) {
  std::vector<Kind> kinds;
  kinds.reserve(deformed.size());
  for (std::size_t i = 0; i < deformed.size(); ++i) {
    kinds.push_back(kind_of(limit_cylinder, deformed[i], inverse_image[i], slack));
  }
  DisjointSets pieces(deformed.size());  // of open vertices
  for_each_side(triangles, [&](std::uint32_t a, std::uint32_t b) {
    if (kinds[a] == Kind::open && kinds[b] == Kind::open) pieces.join(a, b);
  });
  std::vector<int> votes(deformed.size(), 0);  // of a piece's neighbours, kept at its smallest vertex
  const auto vote = [&](std::uint32_t voter, std::uint32_t open) {
    if (kinds[open] != Kind::open) return;
    if (kinds[voter] == Kind::moved) ++votes[pieces.find(open)];
    if (kinds[voter] == Kind::unmoved) --votes[pieces.find(open)];
  };
  for_each_side(triangles, [&](std::uint32_t a, std::uint32_t b) {
    vote(a, b);
    vote(b, a);
  });
  std::vector<bool> members(deformed.size());
  for (std::uint32_t i = 0; i < deformed.size(); ++i) {
    members[i] = kinds[i] == Kind::moved;
    if (kinds[i] != Kind::open) continue;
    const int sum = votes[pieces.find(i)];
    members[i] = sum > 0 || (sum == 0 && distance_from_axis(limit_cylinder, inverse_image[i]) <= limit_cylinder.radius);
  }
  return members;
}

}  // namespace knead

#include "math/elementary.h"

namespace knead::detail {

namespace {

using Corners = std::array<Vec3d, 3>;  // of a triangle

// A triangle cut by a plane has at most four corners.
struct Polygon {
  std::array<Vec3d, 4> corners;
  int count = 0;

  void add(const Vec3d& p) { corners[count++] = p; }
};

// Returns the part of the triangle with normal.d <= outer; empty if there is none. Places are relative to the centre.
Polygon clip(const Corners& triangle, const Vec3d& normal, double outer) {
  Polygon result;
  std::array<double, 3> above{};
  for (std::size_t i = 0; i < 3; ++i) above[i] = dot(normal, triangle[i]) - outer;
  if (!(std::min({above[0], above[1], above[2]}) < 0)) return result;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (above[i] <= 0) result.add(triangle[i]);
    if ((above[i] < 0 && above[j] > 0) || (above[i] > 0 && above[j] < 0)) {
      result.add(triangle[i] + (triangle[j] - triangle[i]) * (above[i] / (above[i] - above[j])));
    }
  }
  return result;
}

// Returns d without its component along the axis, rounded as advect does when it decides whether a point is inside.
Vec3d across_axis(const Vec3d& d, const Vec3d& axis) { return d - axis * dot(axis, d); }

// Returns whether the axis meets the polygon, from its corners across the axis: they wind about the axis in one sense.
// For a polygon seen edge-on the signs are rounding errors, but its edges then have its least distance.
bool is_pierced(const Polygon& across, const Vec3d& axis, double farthest) {
  constexpr double kEdgeOn = 1e-12;
  bool positive = false;
  bool negative = false;
  double area = 0;
  for (int i = 0; i < across.count; ++i) {
    const double turn = dot(axis, cross(across.corners[i], across.corners[(i + 1) % across.count]));
    positive = positive || turn > 0;
    negative = negative || turn < 0;
    area += turn;
  }
  return positive != negative && std::abs(area) > kEdgeOn * farthest * farthest;
}

DistanceRange distances(Polygon polygon, const Vec3d& axis) {
  for (int i = 0; i < polygon.count; ++i) polygon.corners[i] = across_axis(polygon.corners[i], axis);
  DistanceRange result{kInfinity, 0};
  for (int i = 0; i < polygon.count; ++i) {
    const double length = norm(polygon.corners[i]);
    result.max = std::max(result.max, length);
    result.min =
        std::min({result.min, length,
                  distance_to_segment(Vec3d{0, 0, 0}, polygon.corners[i], polygon.corners[(i + 1) % polygon.count])});
  }
  if (is_pierced(polygon, axis, result.max)) result.min = 0;
  return result;
}

}  // namespace

std::optional<DistanceRange> range_of(const StrokeCylinder& limit_cylinder, const Vec3d& normal,
                                      std::span<const Vec3d> positions, const Triangle& triangle) {
  const Corners corners{positions[triangle[0]] - limit_cylinder.center, positions[triangle[1]] - limit_cylinder.center,
                        positions[triangle[2]] - limit_cylinder.center};
  const Polygon polygon = clip(corners, normal, limit_cylinder.outer);
  if (polygon.count == 0) return std::nullopt;
  return distances(polygon, limit_cylinder.normal);
}

std::vector<DistanceRange> merged(std::vector<DistanceRange> all) {
  std::sort(all.begin(), all.end(), [](const DistanceRange& a, const DistanceRange& b) { return a.min < b.min; });
  std::vector<DistanceRange> result;
  for (const DistanceRange& range : all) {
    if (result.empty() || range.min > result.back().max) {
      result.push_back(range);
    } else {
      result.back().max = std::max(result.back().max, range.max);
    }
  }
  return result;
}

std::vector<DistanceRange> merged_ranges(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                         std::span<const Triangle> triangles) {
  std::vector<DistanceRange> all;
  for (const Triangle& triangle : triangles) {
    if (const auto range = range_of(limit_cylinder, limit_cylinder.normal, positions, triangle)) all.push_back(*range);
  }
  return merged(std::move(all));
}

std::optional<double> short_number_between(double low, double high, double target, Round round, int digits) {
  const int exponent = elementary::decimal_exponent(std::max(target, std::numeric_limits<double>::min()));
  for (; digits <= 15; ++digits) {
    const double scale = elementary::power_of_ten(digits - 1 - exponent);
    const double steps = target * scale;
    const double value = (round == Round::up     ? std::floor(steps) + 1
                          : round == Round::down ? std::ceil(steps) - 1
                                                 : std::floor(steps + 0.5)) /
                         scale;
    if (low < value && value < high) return value;
  }
  return std::nullopt;
}

namespace {

constexpr double kFree = 1.25;  // times the gap's inner end, where it has no outer one
constexpr int kDigits = 3;      // of a radius in a wide gap

std::vector<bool> vertices_below(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions) {
  std::vector<bool> below(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    below[i] = dot(limit_cylinder.normal, positions[i] - limit_cylinder.center) < limit_cylinder.outer;
  }
  return below;
}

// A piece is known by its smallest vertex.
std::vector<std::uint32_t> label(const std::vector<bool>& below, std::span<const Triangle> triangles) {
  DisjointSets sets(below.size());
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangle[i];
      const std::uint32_t b = triangle[(i + 1) % 3];
      if (below[a] && below[b]) sets.join(a, b);
    }
  }
  std::vector<std::uint32_t> result;
  result.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    const auto lowest = std::find_if(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return below[v]; });
    result.push_back(lowest == triangle.end() ? CylinderPieces::kNone : sets.find(*lowest));
  }
  return result;
}

std::uint32_t nearest_piece(const std::vector<std::uint32_t>& piece, const Vec3d& center,
                            std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  std::uint32_t nearest = CylinderPieces::kNone;
  double least2 = kInfinity;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (piece[i] == CylinderPieces::kNone) continue;
    double square = least2;
    for (const std::uint32_t v : triangles[i]) square = std::min(square, norm2(positions[v] - center));
    if (square < least2) {
      least2 = square;
      nearest = piece[i];
    }
  }
  return nearest;
}

// Of every piece, at its number.
std::vector<DistanceRange> piece_ranges(const std::vector<std::uint32_t>& piece,
                                        const std::vector<std::optional<DistanceRange>>& ranges, std::size_t vertices) {
  std::vector<DistanceRange> result(vertices, {kInfinity, 0});
  for (std::size_t i = 0; i < piece.size(); ++i) {
    if (piece[i] == CylinderPieces::kNone || !ranges[i]) continue;
    DistanceRange& whole = result[piece[i]];
    whole = {std::min(whole.min, ranges[i]->min), std::max(whole.max, ranges[i]->max)};
  }
  return result;
}

std::vector<DistanceRange> later_ranges(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                        std::span<const Triangle> triangles) {
  std::vector<DistanceRange> all;
  if (limit_cylinder.last_normal == limit_cylinder.normal) return all;
  for (const Triangle& triangle : triangles) {
    if (const auto range = range_of(limit_cylinder, limit_cylinder.last_normal, positions, triangle))
      all.push_back(*range);
  }
  return merged(std::move(all));
}

// Returns the free part of the gap (low, high) outside `taken`: the nearest piece whose ends have a large enough ratio,
// else the piece with the largest ratio; the whole gap if nothing is free.
DistanceRange free_part(double low, double high, const std::vector<DistanceRange>& taken) {
  constexpr double kWide = kFree * kFree;
  DistanceRange best{low, low};
  const auto consider = [&](double from, double to) {
    const double ratio = best.max / best.min;
    if (ratio < kWide && to > ratio * from) best = {from, to};
  };
  double from = low;
  for (const DistanceRange& range : taken) {
    consider(from, std::min(range.min, high));
    from = std::max(from, range.max);
  }
  consider(from, high);
  return best.min < best.max ? best : DistanceRange{low, high};
}

}  // namespace

CylinderPieces limit_cylinder_pieces(const StrokeCylinder& limit_cylinder, std::span<const Vec3d> positions,
                                     std::span<const Triangle> triangles) {
  CylinderPieces result;
  result.piece = label(vertices_below(limit_cylinder, positions), triangles);
  result.part = nearest_piece(result.piece, limit_cylinder.center, positions, triangles);
  if (result.part == CylinderPieces::kNone) return result;
  std::vector<std::optional<DistanceRange>> ranges;
  ranges.reserve(triangles.size());
  for (const Triangle& triangle : triangles)
    ranges.push_back(range_of(limit_cylinder, limit_cylinder.normal, positions, triangle));
  const std::vector<DistanceRange> whole = piece_ranges(result.piece, ranges, positions.size());
  result.part_max = whole[result.part].max;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (result.piece[i] == CylinderPieces::kNone || result.piece[i] == result.part || !ranges[i]) continue;
    const DistanceRange& other = whole[result.piece[i]];
    if (other.max <= result.part_max) {
      ++result.within;
    } else if (other.min > result.part_max) {
      result.others = std::min(result.others, other.min);
    } else {
      if (ranges[i]->min <= result.part_max) ++result.blocking;
      result.blocking_min = std::min(result.blocking_min, other.min);
    }
  }
  result.later = later_ranges(limit_cylinder, positions, triangles);
  return result;
}

std::optional<double> radius_in_gap(const CylinderPieces& pieces) {
  if (pieces.part == CylinderPieces::kNone || pieces.blocking > 0) return std::nullopt;
  const DistanceRange gap = free_part(pieces.part_max, pieces.others, pieces.later);
  const double middle = std::isinf(gap.max) ? kFree * gap.min : std::sqrt(gap.min * gap.max);
  return short_number_between(gap.min, gap.max, middle, Round::nearest, kDigits);
}

}  // namespace knead::detail

namespace knead {

namespace {

constexpr double kSpread = 1.6;   // times the thickness: the greatest extent of the part in the plane r = outer
constexpr double kMargin = 1.1;   // the distance of all other parts, divided by that of the part
constexpr double kStride = 0.25;  // of the thickness: from place to place
constexpr int kMaxPlaces = 200;

struct Shape {
  std::span<const Vec3d> positions;
  std::span<const Triangle> triangles;
};

// Checks that the part is joined to the rest in one place only, about as thick there as at the point. Returns the
// problem, or nothing.
std::string root_problem(const StrokeCylinder& limit_cylinder, const CylinderPieces& pieces, double thickness,
                         const Shape& shape) {
  const auto loops = slice(limit_cylinder.center + limit_cylinder.normal * limit_cylinder.outer, limit_cylinder.normal,
                           shape.positions, shape.triangles);
  const std::optional<SliceLoop> root = innermost(loops);
  if (!root || pieces.piece[root->triangle] != pieces.part) return "its root does not go around the line";
  if (root->extent > kSpread * thickness) {
    return fmt::format("it is {:.3g} thick at its root, against {:.3g} at the point", root->extent, thickness);
  }
  const auto roots = std::count_if(loops.begin(), loops.end(),
                                   [&](const SliceLoop& loop) { return pieces.piece[loop.triangle] == pieces.part; });
  return roots == 1 ? "" : fmt::format("it is joined to the rest in {} places", roots);
}

// Returns the part's height over the centre, towards the tip.
double length_of(const StrokeCylinder& limit_cylinder, const CylinderPieces& pieces, const Shape& shape) {
  double length = 0;
  for (std::size_t i = 0; i < shape.triangles.size(); ++i) {
    if (pieces.piece[i] != pieces.part) continue;
    for (const std::uint32_t v : shape.triangles[i]) {
      length = std::max(length, -dot(limit_cylinder.normal, shape.positions[v] - limit_cylinder.center));
    }
  }
  return length;
}

// Completes the proposal at its centre, or returns the problem there.
void try_place(CylinderPlacement& proposal, const Vec3d& last_normal, const Shape& shape) {
  const StrokeCylinder limit_cylinder{proposal.center, proposal.normal, 0, proposal.outer, last_normal};
  const CylinderPieces pieces = limit_cylinder_pieces(limit_cylinder, shape.positions, shape.triangles);
  const std::optional<double> radius = radius_in_gap(pieces);
  if (!radius || pieces.others < kMargin * pieces.part_max) {
    proposal.problem = "something else is as near to the line as the part's farthest point";
  } else if (length_of(limit_cylinder, pieces, shape) <= -proposal.inner) {
    proposal.problem = "it ends before the motion's inner region begins";
  } else {
    proposal.problem = root_problem(limit_cylinder, pieces, proposal.thickness, shape);
    proposal.radius = *radius;
  }
}

// Moves the proposal, with a zone of that width, from the point towards the tip, to the first suitable place.
CylinderPlacement first_place(const CylinderQuery& query, const Vec3d& direction, double thickness, double width,
                              const Shape& shape, const Progress* progress) {
  CylinderPlacement proposal{query.point, -direction, -kCenterFraction * width, (1 - kCenterFraction) * width, 0,
                             thickness,   {}};
  Vec3d last_normal = proposal.normal;
  if (query.axis != Vec3d{0, 0, 0}) {
    last_normal = rotate(proposal.normal, unit(query.axis), sincos(0.5 * query.angle_deg * kRadiansPerDegree));
  }
  std::string first_problem;
  for (int i = 0; i < kMaxPlaces; ++i) {
    stop_if_cancelled(progress);
    proposal.center = query.point + direction * (kStride * thickness * i);
    if (!innermost(slice(proposal.center, proposal.normal, shape.positions, shape.triangles))) break;  // past the tip
    try_place(proposal, last_normal, shape);
    if (proposal.problem.empty()) return proposal;
    if (i == 0) first_problem = proposal.problem;
  }
  proposal.problem = first_problem;
  return proposal;
}

}  // namespace

CylinderPlacement place_limit_cylinder(const CylinderQuery& query, std::span<const Vec3d> positions,
                                       std::span<const Triangle> triangles, const Progress* progress) {
  check_triangles(triangles, positions);
  require_finite("point", query.point);
  require_direction("direction", query.direction);
  require_finite("axis", query.axis);
  require_angle("angle_deg", query.angle_deg);
  const Shape shape{positions, triangles};
  const Vec3d direction = unit(query.direction);
  const std::optional<SliceLoop> around = innermost(slice(query.point, direction, positions, triangles));
  CylinderPlacement proposal;
  if (!around) {
    proposal.problem =
        "there is no limb at this point: nothing goes around it across the direction; choose a part such as a finger, "
        "an arm or a neck, between its ends";
    return proposal;
  }
  for (const double zone : {2.0, 1.2}) {
    proposal = first_place(query, direction, around->extent, zone * around->extent, shape, progress);
    if (proposal.problem.empty()) return proposal;
  }
  proposal.problem = fmt::format(
      "from the point to the tip there is no place where the part can be moved alone: at the point {}; choose a "
      "point nearer to the tip, or a direction along the middle of the part",
      proposal.problem);
  return proposal;
}

}  // namespace knead
