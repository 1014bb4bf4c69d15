// Tools that are placed, then turned: rotate, stretch, twist, bend; and where a stamp stands.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "gestures/gesture_kinds.h"

namespace knead::studio {

namespace {

constexpr double kDegreesPerPixel = 0.5;
constexpr double kFacing = 0.4;  // sine of the angle between axis and view below which the axis faces the viewer
constexpr double kStretchPerPixel = 0.4;       // percent of the logarithm
constexpr double kStandOff = 0.02;             // of the stamp's size, between it and the surface
constexpr double kMinPercent = -99;            // that can be typed for a stretch
constexpr double kBendAngle = 90;              // degrees: the bend that a limit cylinder is placed for
constexpr int kDirections = 8;                 // that are tried about the place of a click
constexpr double kAsThin = 1.15;               // of the thinnest
constexpr double kNearly = 0.96;               // cosine of the angle below which two directions look the same
constexpr std::size_t kManyVertices = 20'000;  // whose edges show nothing more of a profile

// Returns degrees from the motion of the pointer across the visible axis, to the right positive for an axis that points
// up. If the axis points towards the viewer, or away, they are the angle round the centre.
double angle_of(const TurnGesture& gesture, const Pointer& to, const Vec3d& axis, const GestureContext& around) {
  const Pointer& from = gesture.start;
  const render::CameraFrame frame = render::camera_frame(around.screen.camera);
  const double right = dot(axis, frame.right);
  const double up = dot(axis, frame.up);
  const double length = std::hypot(right, up);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  if (length < kFacing) {
    const double angle = angle_round(around.screen, gesture.placement->center, axis, {from.x, from.y}, {to.x, to.y});
    return angle * 180 / std::numbers::pi;
  }
  return (dx * up + dy * right) / length * kDegreesPerPixel;
}

// Returns the amount for a typed number.
double amount_of_typed(double typed, const Turning& turning) {
  if (!turning.is_percent) return typed;
  return 100 * std::log1p(std::max(typed, kMinPercent) / 100);
}

// Three unit vectors, z given.
Placement frame_about(const Vec3d& center, const Vec3d& z, const Vec3d& towards_x) {
  const Vec3d flat = towards_x - z * dot(z, towards_x);
  const Vec3d x = norm(flat) > 1e-6 ? normalized(flat) : any_orthogonal(z);
  return {center, x, cross(z, x), z};
}

double half_extent(const Mesh& mesh) {
  double most = 0;
  for (const Vec3d& p : mesh.positions) most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return most;
}

double stamp_scale(const ToolSettings& settings, const StampShape& shape) {
  const double extent = half_extent(*shape.mesh);
  return extent > 0 ? settings.stamp_size * settings.radius / extent : 1;
}

// Returns the extent of the posed stamp from its origin in a direction.
double reach_along(const StampShape& shape, const Mat3d& pose, const Vec3d& direction) {
  double most = 0;
  for (const Vec3d& p : shape.mesh->positions) most = std::max(most, dot(pose * p, direction));
  return most;
}

Mat3d pose_of(const Placement& placement, double scale) {
  const Vec3d &x = placement.x, &y = placement.y, &z = placement.z;
  return Mat3d{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}} * scale;
}

struct FoundCylinder {
  Placement placement;
  double tip = 0;  // how far it goes
};

Placement turned(Placement placement, double angle) {
  const SinCos<double> by = sincos(angle);
  placement.y = normalized(rotate(placement.y, placement.x, by));
  placement.z = normalized(rotate(placement.z, placement.x, by));
  return placement;
}

// Returns placements along the limb on which this one lies, back to its joint; none without a limb. They lie in the
// plane of the picture if the limb nearly does, else along the limb itself.
std::vector<Placement> along_limb(const Placement& placement, std::span<const Vec3d> positions,
                                  std::span<const Triangle> triangles) {
  const auto nearer = [&](const Vec3d& a, const Vec3d& b) {
    return norm2(a - placement.center) < norm2(b - placement.center);
  };
  const auto nearest = std::min_element(positions.begin(), positions.end(), nearer);
  if (nearest == positions.end()) return {};
  const Limb limb = find_limb(positions, triangles, static_cast<std::uint32_t>(nearest - positions.begin()));
  if (!limb.has_neck) return {};
  // A limb that is clicked at its side also turns about its middle.
  const double along = std::max(dot(placement.center - limb.joint, limb.direction), 0.0);
  std::vector<Placement> places;
  for (int step = 0; step < kDirections; ++step) {
    const Placement here = step == 0 ? placement : turned(placement, 2 * std::numbers::pi * step / kDirections);
    if (dot(here.z, limb.direction) > kNearly) places.push_back(here);
  }
  for (const double part : {1.0, 0.75, 0.5, 0.25, 0.0}) {
    places.push_back(frame_about(limb.joint + limb.direction * (part * along), limb.direction, placement.x));
  }
  return places;
}

double tip_of(const CylinderPlacement& limit_cylinder, const Vec3d& from, std::span<const Vec3d> positions) {
  double most = 0;
  for (const Vec3d& p : positions) {
    const double along = dot(from - p, limit_cylinder.normal);
    const Vec3d d = p - limit_cylinder.center;
    const Vec3d across = d - limit_cylinder.normal * dot(d, limit_cylinder.normal);
    if (along > most && norm(across) <= limit_cylinder.radius) most = along;
  }
  return most;
}

// Returns the thinnest; among about equally thin ones that with the nearest tip; among these the first.
const Placement& best_of(const std::vector<FoundCylinder>& found) {
  const auto thinner = [](const FoundCylinder& a, const FoundCylinder& b) {
    return a.placement.limit_cylinder->thickness < b.placement.limit_cylinder->thickness;
  };
  const double least = std::min_element(found.begin(), found.end(), thinner)->placement.limit_cylinder->thickness;
  const FoundCylinder* best = nullptr;
  for (const FoundCylinder& one : found) {
    if (one.placement.limit_cylinder->thickness > kAsThin * least) continue;
    if (best == nullptr || one.tip < (1 - 1e-6) * best->tip) best = &one;
  }
  return best->placement;
}

// Returns the stroke with the zone of the settings.
std::optional<Stroke> plain_stroke(const ToolSettings& settings, const Placement& placement, double amount) {
  const Turning& turning = settings.tool->turning;
  if (amount == 0 || turning.stroke == nullptr) return std::nullopt;
  const bool has_limit_cylinder = placement.limit_cylinder && placement.limit_cylinder->problem.empty();
  const bool needs_limit_cylinder = turning.takes_limit_cylinder && settings.uses_limit_cylinder;
  if (needs_limit_cylinder && !has_limit_cylinder) return std::nullopt;
  Stroke stroke =
      turning.stroke(settings, placement, amount, needs_limit_cylinder ? &*placement.limit_cylinder : nullptr);
  set_falloff(stroke, settings.falloff);
  return stroke;
}

// The gizmo may have been moved, or the limit cylinder switched on or off, since the profile was made.
bool is_profiled(const ToolSettings& settings, const Placement& placement) {
  const std::optional<Stroke> stroke = plain_stroke(settings, placement, 1);
  return !stroke || (placement.profile && check_zone(*stroke, *placement.profile));
}

}  // namespace

StampStroke stamp_at(const ToolSettings& settings, const StampShape& shape, const Placement& placement) {
  StampStroke stroke;
  stroke.mesh = shape.file;
  stroke.pose = pose_of(placement, stamp_scale(settings, shape));
  stroke.contact = settings.stamp_contact;
  if (stroke.contact != StampContact::stick) return stroke;
  // The default of the session's format for a straight motion, but the same for all pieces of the path.
  stroke.outer = 1.5 * settings.stamp_size * settings.radius;
  stroke.step = *stroke.outer / 25;
  stroke.falloff = settings.falloff;
  return stroke;
}

std::optional<Placement> placement_at(const Pointer& pointer, const GestureContext& around, const PlacedTools& placed) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  const render::CameraFrame frame = render::camera_frame(around.screen.camera);
  const ToolSettings& settings = around.settings;
  if (settings.tool->use == ToolUse::stamp) {
    Placement result = frame_about(hit->point, hit->normal, frame.right);
    if (!placed.stamp) return result;
    const StampStroke stroke = stamp_at(settings, *placed.stamp, result);
    const double reach = reach_along(*placed.stamp, stroke.pose, -hit->normal);
    result.center += hit->normal * (reach + kStandOff * settings.stamp_size * settings.radius);
    return result;
  }
  const Facing facing = settings.tool->turning.facing;
  if (facing == Facing::viewer) return frame_about(hit->point, -frame.forward, frame.right);
  if (facing == Facing::surface) return frame_about(hit->point, hit->normal, frame.right);
  const Ray ray = ray_through(around.screen, pointer.x, pointer.y);
  const Vec3d middle = around.picker->middle(ray, around.state).value_or(hit->point);
  // Up in the picture, away from the shape's middle where that is down: towards the tip of what was clicked.
  return frame_about(middle, frame.up, frame.forward);
}

Placement on_part(const Placement& placement, bool bends, bool may_turn, std::span<const Vec3d> positions,
                  std::span<const Triangle> triangles, const Progress* progress) {
  const auto place = [&](Placement& here) {
    CylinderQuery query{here.center, here.z};
    if (bends) {
      query.axis = here.x;
      query.angle_deg = kBendAngle;
    }
    here.limit_cylinder = place_limit_cylinder(query, positions, triangles, progress);
    return here.limit_cylinder->problem.empty();
  };
  if (may_turn) {
    for (Placement& here : along_limb(placement, positions, triangles)) {
      if (place(here)) return here;
    }
  }
  Placement result = placement;
  std::vector<FoundCylinder> found;
  for (int i = 0; i < (may_turn ? kDirections : 1); ++i) {
    // 0, then to both sides in turn.
    const int step = i % 2 == 0 ? -i / 2 : (i + 1) / 2;
    Placement here = i == 0 ? placement : turned(placement, 2 * std::numbers::pi * step / kDirections);
    if (place(here)) found.push_back({here, tip_of(*here.limit_cylinder, here.center, positions)});
    if (i == 0) result = here;
  }
  return found.empty() ? result : best_of(found);
}

std::optional<Stroke> turning_stroke(const ToolSettings& settings, const Placement& placement, double amount) {
  std::optional<Stroke> stroke = plain_stroke(settings, placement, amount);
  if (!stroke || !settings.widens_zone || !placement.profile) return stroke;
  return with_safe_zone(*stroke, *placement.profile);
}

std::shared_ptr<const ZoneProfile> profile_at(const ToolSettings& settings, const Placement& placement,
                                              const ShapeState& state) {
  const std::optional<Stroke> stroke = plain_stroke(settings, placement, 1);
  if (!stroke || !settings.tool->turning.takes_limit_cylinder || state.mesh == nullptr) return nullptr;
  const std::vector<Triangle> triangles =
      state.positions.size() < kManyVertices ? triangulate(*state.mesh) : std::vector<Triangle>{};
  return std::make_shared<const ZoneProfile>(zone_profile(*stroke, state.positions.copy(), triangles));
}

std::optional<double> widened_zone(const ToolSettings& settings, const Placement& placement, double amount) {
  const std::optional<Stroke> plain = plain_stroke(settings, placement, amount);
  if (!plain || !settings.widens_zone || !placement.profile) return std::nullopt;
  const std::optional<ZoneCheck> check = check_zone(*plain, *placement.profile);
  return check && check->safe > check->width ? std::optional(check->safe) : std::nullopt;
}

TurnDrag turn_drag(const Screen& screen, const ToolSettings& settings, const PlacedTools& placed) {
  if (!placed.placement) return TurnDrag::sideways;
  const Vec3d axis = (*placed.placement).*settings.tool->turning.axis;
  const render::CameraFrame frame = render::camera_frame(screen.camera);
  const double right = std::abs(dot(axis, frame.right));
  const double up = std::abs(dot(axis, frame.up));
  if (std::hypot(right, up) < kFacing) return TurnDrag::round;
  return up >= right ? TurnDrag::sideways : TurnDrag::upright;
}

void TurnGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const bool is_click = std::hypot(pointer.x - start.x, pointer.y - start.y) < kClick * around.screen.unit;
  has_gone = has_gone || !is_click || pointer.typed;
  if (!placement || !has_gone) return;
  const Turning& turning = around.settings.tool->turning;
  if (turning.takes_limit_cylinder && !is_profiled(around.settings, *placement)) {
    placement->profile = profile_at(around.settings, *placement, around.state);
  }
  if (pointer.typed) {
    amount = amount_of_typed(*pointer.typed, turning);
    return;
  }
  if (turning.is_percent) {
    amount = (pointer.x - start.x + start.y - pointer.y) * kStretchPerPixel;
  } else {
    amount = angle_of(*this, pointer, (*placement).*turning.axis, around);
  }
  amount = snapped(amount, kSnapDegrees, pointer);
}

void TurnGesture::end(const GestureStep& step) const {
  if (placement && has_gone) return;
  const std::optional<Placement> here = placement_at(start, step.around, step.placed);
  if (here) step.placed.placement = here;
}

std::vector<Stroke> TurnGesture::strokes(const ShapeState& /*start*/, const ToolSettings& settings) const {
  std::optional<Stroke> stroke;
  if (placement) stroke = turning_stroke(settings, *placement, amount);
  return stroke ? std::vector<Stroke>{std::move(*stroke)} : std::vector<Stroke>{};
}

std::optional<Amount> TurnGesture::number(const ToolSettings& settings) const {
  if (!placement) return std::nullopt;
  if (!settings.tool->turning.is_percent) return Amount{AmountKind::angle, amount};
  return Amount{AmountKind::percent, 100 * std::expm1(amount / 100)};
}

void GizmoGesture::move(const GestureStep& step) {
  const auto& [pointer, around, placed] = step;
  const Pixel begin{from.x, from.y};
  const Pixel to{pointer.x, pointer.y};
  if (part == GizmoPart::center) {
    placed.placement = center_dragged(around.screen, start, begin, to);
    return;
  }
  const double snap = turns(part) ? kSnapDegrees : around.snap;
  amount = pointer.typed.value_or(snapped(dragged_by(around.screen, start, part, begin, to), snap, pointer));
  placed.placement = moved_by(start, part, amount);
}

std::optional<Amount> GizmoGesture::number() const {
  if (part == GizmoPart::center) return std::nullopt;
  return Amount{turns(part) ? AmountKind::angle : AmountKind::length, amount};
}

}  // namespace knead::studio
