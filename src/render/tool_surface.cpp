// Meshes of the surfaces r = level of regions, and the cache of those of point sets.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "knead/editor/render.h"
#include "mesh/polygonise.h"

namespace knead::render {
namespace {

constexpr std::size_t kMaxEntries = 32;  // two levels, both ends of the path, and their mirror images

const Vec3d* first_point(const PointSet<double>& set) {
  if (!set.points.empty()) return &set.points.front();
  for (const auto& curve : set.curves) {
    if (!curve.empty()) return &curve.front();
  }
  return nullptr;
}

bool is_shifted(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to, const Vec3d& shift, double tolerance) {
  return std::equal(from.begin(), from.end(), to.begin(), to.end(),
                    [&](const Vec3d& a, const Vec3d& b) { return norm(b - a - shift) <= tolerance; });
}

// Returns the translation from the first set to the second, if there is one.
std::optional<Vec3d> shift_between(const PointSet<double>& from, const PointSet<double>& to, double tolerance) {
  const Vec3d* const a = first_point(from);
  const Vec3d* const b = first_point(to);
  if (a == nullptr || b == nullptr || from.exponent != to.exponent) return std::nullopt;
  const Vec3d shift = *b - *a;
  const auto shifted = [&](const auto& x, const auto& y) { return is_shifted(x, y, shift, tolerance); };
  if (!shifted(from.points, to.points)) return std::nullopt;
  if (!std::equal(from.curves.begin(), from.curves.end(), to.curves.begin(), to.curves.end(), shifted)) {
    return std::nullopt;
  }
  return shift;
}

constexpr double kDot = 0.04;          // of the outer threshold: the radius of the balls that stand for r = 0
constexpr double kMarkDot = 0.011;     // of the box's diagonal: the radius of those that stand for marked points
constexpr std::size_t kMaxMarks = 80;  // of a set, that are drawn
constexpr int kHandlesCells = 32;      // of their grid: every evaluation looks at all points
constexpr double kNearFull = 0.25;     // of marked regions: the surfaces shown are r = this and r = 1 - this

struct ProfilePoint {
  double height = 0;  // along the axis
  double radius = 0;  // 0: on the axis
};

struct Line3 {
  Vec3d point;
  Vec3d direction;  // a unit vector
};

// Returns the profile turned about the line, without lids.
Mesh revolve(const std::vector<ProfilePoint>& profile, const Line3& axis, int side_count) {
  const auto sides = static_cast<std::uint32_t>(side_count);
  const Vec3d u = any_orthogonal(axis.direction);
  const Vec3d v = cross(axis.direction, u);
  Mesh mesh;
  std::vector<std::uint32_t> first;  // vertex of each profile point
  for (const ProfilePoint& p : profile) {
    first.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
    const Vec3d center = axis.point + axis.direction * p.height;
    for (std::uint32_t i = 0; i < (p.radius > 0 ? sides : 1); ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.positions.push_back(center + (u * std::cos(angle) + v * std::sin(angle)) * p.radius);
    }
  }
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const std::uint32_t next = (i + 1) % sides;
      const bool tip = profile[k + 1].radius <= 0;
      const bool foot = profile[k].radius <= 0;
      std::vector<std::uint32_t> face{first[k] + (foot ? 0 : i)};
      if (!foot) face.push_back(first[k] + next);
      face.push_back(first[k + 1] + (tip ? 0 : next));
      if (!tip) face.push_back(first[k + 1] + i);
      mesh.add_face(face);
    }
  }
  return mesh;
}

// Returns a capsule; a ball if half_axis is zero.
Mesh capsule(const Vec3d& center, const Vec3d& half_axis, double radius, int sides) {
  const int bands = 2 * std::max(3, 3 * sides / 16);
  const double half = norm(half_axis);
  std::vector<ProfilePoint> profile;
  for (int i = 0; i <= bands; ++i) {
    const double angle = std::numbers::pi * i / bands;
    const double offset = 2 * i < bands ? -half : half;
    if (2 * i == bands && half > 0) profile.push_back({-half, radius});
    profile.push_back({offset - radius * std::cos(angle), i == 0 || i == bands ? 0 : radius * std::sin(angle)});
  }
  return revolve(profile, {center, half > 0 ? half_axis / half : Vec3d{0, 0, 1}}, sides);
}

void append(const Mesh& part, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  std::vector<std::uint32_t> face;
  for (std::size_t f = 0; f < part.face_count(); ++f) {
    face.assign(part.face(f).begin(), part.face(f).end());
    for (std::uint32_t& vertex : face) vertex += first;
    mesh.add_face(face);
  }
}

// Returns the smallest and largest dot(direction, corner - origin), with a margin.
std::pair<double, double> extent_along(const Box& box, const Vec3d& origin, const Vec3d& direction) {
  double low = kInfinity;
  double high = -kInfinity;
  for (std::size_t i = 0; i < 8; ++i) {
    const double along = dot(direction, box.corner(i) - origin);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  const double margin = 0.04 * box.diagonal();
  return {low - margin, high + margin};
}

// Returns the part of the plane around the box, with sides along the projection of `along`.
Mesh plane_patch(const Vec3d& point, const Vec3d& normal, const Vec3d& along, const Box& around) {
  const Vec3d flat = along - normal * dot(normal, along);
  const Vec3d u = norm(flat) > 1e-6 ? normalized(flat) : any_orthogonal(normal);
  const Vec3d v = cross(normal, u);
  const auto [u_low, u_high] = extent_along(around, point, u);
  const auto [v_low, v_high] = extent_along(around, point, v);
  Mesh mesh;
  mesh.positions = {point + u * u_low + v * v_low, point + u * u_high + v * v_low, point + u * u_high + v * v_high,
                    point + u * u_low + v * v_high};
  mesh.add_face(std::array<std::uint32_t, 4>{0, 1, 2, 3});
  return mesh;
}

// Returns the part of the plane within the limit cylinder, an ellipse. The axis must not lie in the plane.
Mesh disc(const Vec3d& point, const Vec3d& normal, const LimitCylinder& limit_cylinder, int sides) {
  Mesh mesh = revolve({{0, 0}, {0, limit_cylinder.radius}}, {limit_cylinder.center, limit_cylinder.axis}, sides);
  for (Vec3d& p : mesh.positions) {
    p += limit_cylinder.axis * (dot(normal, point - p) / dot(normal, limit_cylinder.axis));
  }
  return mesh;
}

bool crosses(const LimitCylinder& limit_cylinder, const Vec3d& normal) {
  return std::abs(dot(limit_cylinder.axis, normal)) > 0.05;
}

// Returns a box around the surface r = level of the set: n elements reduce r by a factor of up to n^(1/m).
Box point_set_box(const PointSet<double>& set, double level) {
  Box box = bounding_box(set.points);
  for (const auto& curve : set.curves) {
    for (const Vec3d& p : curve) box.extend(p);
  }
  const auto count = static_cast<double>(set.points.size() + set.curves.size());
  const double radius = 1.3 * level * std::pow(count, 1.0 / set.exponent);
  box.min -= Vec3d{radius, radius, radius};
  box.max += Vec3d{radius, radius, radius};
  return box;
}

double length_of(const std::vector<Vec3d>& curve) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) length += norm(curve[i + 1] - curve[i]);
  return length;
}

// Returns a bound of |grad r| within the box and half its size beyond: 1 for points. For a curve r^-4 = 3/4 S with S
// the integral of |x - y|^-5. |grad S| <= 5 S / d at the distance d, so that |grad r| <= 5/4 r/d; and S is least if the
// curve leads straight away, where r/d = (16/3 / (1 - (1 + length/d)^-4))^(1/4). A sum of elements is at most as steep
// as they are.
double steepest(const PointSet<double>& set, const Box& box) {
  double bound = 1;
  for (const auto& curve : set.curves) {
    const double ratio = 1 + length_of(curve) / (2 * box.diagonal());
    bound = std::max(bound, 1.25 * std::pow(16.0 / 3 / (1 - std::pow(ratio, -4)), 0.25));
  }
  return bound;
}

// Returns some of the curve's points, such that the others are within the tolerance of the polyline through them
// (Douglas and Peucker 1973).
std::vector<Vec3d> straightened(const std::vector<Vec3d>& curve, double tolerance) {
  std::vector<bool> kept(curve.size(), false);
  kept.front() = kept.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> spans{{0, curve.size() - 1}};
  while (!spans.empty()) {
    const auto [first, last] = spans.back();
    spans.pop_back();
    double farthest = tolerance;
    std::size_t corner = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double distance = distance_to_segment(curve[i], curve[first], curve[last]);
      if (distance <= farthest) continue;
      farthest = distance;
      corner = i;
    }
    if (corner == first) continue;
    kept[corner] = true;
    spans.emplace_back(first, corner);
    spans.emplace_back(corner, last);
  }
  std::vector<Vec3d> result;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (kept[i]) result.push_back(curve[i]);
  }
  return result;
}

Mesh point_set_surface(PointSet<double> set, const Vec3d& center, double level, const SurfaceDetail& detail) {
  if (detail.straightening > 0) {
    for (auto& curve : set.curves) curve = straightened(curve, detail.straightening * level);
  }
  const Box box = point_set_box(set, level);
  const Vec3d size = box.max - box.min;
  PolygoniseOptions options;
  options.cell = std::max({size.x, size.y, size.z}) / detail.cells;
  options.lipschitz = steepest(set, box);
  options.relaxations = detail.relaxations;
  Mesh mesh = polygonise([&](const Vec3d& d) { return evaluate(set, d, 0.0).value - level; }, box, options);
  for (Vec3d& p : mesh.positions) p += center;
  return mesh;
}

// Returns the set with at most kMaxMarks points, at equal distances in its list.
PointSet<double> some_points(const PointSet<double>& set) {
  PointSet<double> some = set;
  const std::size_t stride = std::max<std::size_t>(1, (set.points.size() + kMaxMarks - 1) / kMaxMarks);
  some.points.clear();
  for (std::size_t i = 0; i < set.points.size(); i += stride) some.points.push_back(set.points[i]);
  return some;
}

// Returns the surface r = kNearFull, or r = 1 - kNearFull.
Mesh handles_surface(const Handles<double>& region, const Vec3d& center, bool is_zero, const SurfaceDetail& detail) {
  Box box = bounding_box(region.full.points);
  for (const Vec3d& p : region.zero.points) box.extend(p);
  const double margin = 0.5 * box.diagonal();
  box.min -= Vec3d{margin, margin, margin};
  box.max += Vec3d{margin, margin, margin};
  if (box.empty() || !(margin > 0)) return {};
  const Vec3d size = box.max - box.min;
  PolygoniseOptions options;
  options.cell = std::max({size.x, size.y, size.z}) / std::min(detail.cells, kHandlesCells);
  options.relaxations = detail.relaxations;
  Mesh mesh = polygonise(
      [&](const Vec3d& d) {
        const double r = evaluate(region, d, 0.0).value;
        return (is_zero ? 1 - r : r) - kNearFull;
      },
      box, options);
  for (Vec3d& p : mesh.positions) p += center;
  return mesh;
}

// One overload per region; `field` gives the scale of regions without one.
struct SurfaceOf {
  const Field& field;
  Vec3d center;
  double level = 0;
  const Box& around;
  const std::optional<LimitCylinder>& limit_cylinder;
  const SurfaceDetail& detail;

  double radius() const { return level > 0 ? level : kDot * field.thresholds.outer; }

  Mesh operator()(const Ball<double>& /*region*/) const { return capsule(center, {0, 0, 0}, radius(), detail.sides); }
  Mesh operator()(const Capsule<double>& region) const {
    return capsule(center, region.half_axis, radius(), detail.sides);
  }
  Mesh operator()(const HalfSpace<double>& region) const {
    const Vec3d point = center + region.normal * level;
    if (limit_cylinder && crosses(*limit_cylinder, region.normal))
      return disc(point, region.normal, *limit_cylinder, detail.sides);
    const Vec3d middle = around.empty() ? point : around.center();
    return plane_patch(middle - region.normal * dot(region.normal, middle - point), region.normal, region.turn_axis,
                       around);
  }
  Mesh operator()(const PointSet<double>& region) const {
    if (level > 0) return point_set_surface(region, center, level, detail);
    Mesh mesh;
    for (const Vec3d& p : region.points) append(capsule(center + p, {0, 0, 0}, radius(), detail.sides / 2), mesh);
    for (const auto& curve : region.curves) {
      for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
        append(capsule(center + (curve[i] + curve[i + 1]) * 0.5, (curve[i + 1] - curve[i]) * 0.5, radius(),
                       detail.sides / 2),
               mesh);
      }
    }
    return mesh;
  }
  // The sets themselves are r = 0 and r = 1: their points as small balls, within the surface where r is near to that.
  Mesh operator()(const Handles<double>& region) const {
    const Handles<double> some{some_points(region.full), some_points(region.zero), {}, {}, 0};
    const bool is_zero = level > 0;
    Mesh mesh = handles_surface(some, center, is_zero, detail);
    for (const Vec3d& p : (is_zero ? some.zero : some.full).points) {
      append(capsule(center + p, {0, 0, 0}, kMarkDot * around.diagonal(), detail.sides / 4), mesh);
    }
    return mesh;
  }
  Mesh operator()(const CustomRegion& /*region*/) const { return {}; }
};

}  // namespace

Mesh SurfaceCache::surface(const Field& field, double level, const SurfaceDetail& detail) {
  const auto& set = std::get<PointSet<double>>(field.region);
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    if (entry->level != level || entry->detail != detail) continue;
    const std::optional<Vec3d> shift = shift_between(entry->set, set, 1e-6 * level);
    if (!shift) continue;
    std::rotate(entry, entry + 1, entries_.end());
    Mesh mesh = entries_.back().mesh;
    const Vec3d by = *shift + (field.center - entries_.back().center);
    for (Vec3d& p : mesh.positions) p += by;
    return mesh;
  }
  ++made_;
  if (entries_.size() == kMaxEntries) entries_.erase(entries_.begin());
  entries_.push_back({set, field.center, level, detail, region_surface(field, field.center, level, {}, {}, detail)});
  return entries_.back().mesh;
}

Mesh region_surface(const Field& field, const Vec3d& center, double level, const Box& around,
                    const std::optional<LimitCylinder>& limit_cylinder, const SurfaceDetail& detail) {
  return std::visit(SurfaceOf{field, center, level, around, limit_cylinder, detail}, field.region);
}

Mesh limit_cylinder_surface(const LimitCylinder& limit_cylinder, const Field& field, const Box& around,
                            const SurfaceDetail& detail) {
  const auto& region = std::get<HalfSpace<double>>(field.region);
  const double low = extent_along(around, limit_cylinder.center, limit_cylinder.axis).first;
  const Vec3d top = field.center + region.normal * field.thresholds.outer;
  Mesh mesh = revolve({{low, limit_cylinder.radius}, {0, limit_cylinder.radius}},
                      {limit_cylinder.center, limit_cylinder.axis}, detail.sides);
  if (!crosses(limit_cylinder, region.normal)) return mesh;
  for (std::size_t i = mesh.positions.size() / 2; i < mesh.positions.size(); ++i) {
    Vec3d& p = mesh.positions[i];
    p += limit_cylinder.axis * (dot(region.normal, top - p) / dot(region.normal, limit_cylinder.axis));
  }
  return mesh;
}

}  // namespace knead::render
