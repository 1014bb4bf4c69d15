// Gestures along the surface: paint, lines drawn, handles painted.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "gestures/gesture_kinds.h"
#include "knead/flow/advect.h"
#include "knead/tool/paint.h"

namespace knead::studio {

namespace {

constexpr int kDabs = 6;  // that add up to the full depth
constexpr double kLeastPressure = 0.05;
constexpr double kRadiusSteps = 16;       // of the radius, under a pen
constexpr int kMostRays = 400;            // between two places of the pointer
constexpr double kProbe = 1e-3;           // of the radius: how far apart the points are that tell a normal
constexpr double kProbeTolerance = 1e-7;  // of the radius
constexpr double kLassoPiece = 3;         // pixels between two points of a lasso
constexpr double kPointSpacing = 0.25;    // of a drawn line, in radii

double pressure_of(const Pointer& pointer) { return std::clamp(pointer.pressure, kLeastPressure, 1.0); }

Pointer between(const Pointer& a, const Pointer& b, double t) {
  Pointer result = b;
  result.x = a.x + (b.x - a.x) * t;
  result.y = a.y + (b.y - a.y) * t;
  result.pressure = a.pressure + (b.pressure - a.pressure) * t;
  return result;
}

// The sample at a place of the surface as it was, where the stroke so far has brought it.
PaintSample carried(const SurfaceHit& hit, const PaintGesture& gesture) {
  const double outer = gesture.stroke.outer;
  const Vec3d u = any_orthogonal(hit.normal);
  const Vec3d v = cross(hit.normal, u);
  std::array<Vec3d, 3> points{hit.point, hit.point + u * (kProbe * outer), hit.point + v * (kProbe * outer)};
  AdvectOptions options;
  options.tolerance = kProbeTolerance * outer;
  options.precision = Precision::float64;
  options.threads = 1;
  advect(gesture.done, points, options);
  const Vec3d normal = cross(points[1] - points[0], points[2] - points[0]);
  return {points[0], norm(normal) > 0 ? normalized(normal) : hit.normal};
}

// The radius of a brush in steps, so that many dabs share one stroke.
double radius_under(const Pointer& pointer, const ToolSettings& settings) {
  if (settings.pressure != PenPressure::radius) return settings.radius;
  return settings.radius * std::max(std::ceil(kRadiusSteps * pressure_of(pointer)), 1.0) / kRadiusSteps;
}

// Goes on with another radius: the depth of a dab is relative to it.
void set_radius(double radius, PaintGesture& gesture) {
  PaintStroke& stroke = gesture.stroke;
  if (stroke.outer == radius) return;
  if (!stroke.samples.empty()) gesture.earlier.push_back(stroke);
  stroke.samples.clear();
  stroke.depth *= radius / stroke.outer;
  gesture.spacing *= radius / stroke.outer;
  stroke.outer = radius;
}

void add_dab(const SurfaceHit& hit, PaintGesture& gesture) {
  PaintStroke dab = gesture.stroke;
  dab.samples = {carried(hit, gesture)};
  gesture.stroke.samples.push_back(dab.samples.front());
  Flow flow = flow_of(dab);
  std::move(flow.segments.begin(), flow.segments.end(), std::back_inserter(gesture.done.segments));
}

}  // namespace

std::optional<PaintGesture> begin_paint(const Pointer& pointer, const Surroundings& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  const ToolSettings& settings = around.settings;
  PaintGesture gesture;
  const bool in = settings.paint_in != pointer.modifiers.ctrl;
  gesture.stroke.outer = settings.radius;
  gesture.stroke.falloff = settings.falloff;
  gesture.stroke.depth = settings.depth * settings.radius / kDabs * (in ? 1 : -1);
  gesture.spacing = dab_length(settings.falloff) * settings.radius / kDabs;
  set_radius(radius_under(pointer, settings), gesture);
  add_dab(*hit, gesture);
  gesture.last = pointer;
  gesture.last_point = hit->point;
  return gesture;
}

void move_paint(const Pointer& pointer, const Surroundings& around, PaintGesture& gesture) {
  const double way = std::hypot(pointer.x - gesture.last.x, pointer.y - gesture.last.y);
  const double fine = 0.25 * gesture.spacing / pixel_size(around.screen, gesture.last_point);  // pixels
  const int rays = std::clamp(static_cast<int>(std::ceil(way / std::max(fine, 0.5))), 1, kMostRays);
  const Pointer from = gesture.last;
  for (int i = 1; i <= rays; ++i) {
    const Pointer here = between(from, pointer, static_cast<double>(i) / rays);
    gesture.last = here;
    const auto hit = hit_at(here, around);
    if (!hit) continue;
    const bool by_depth = around.settings.pressure == PenPressure::depth;
    gesture.travelled += norm(hit->point - gesture.last_point) * (by_depth ? pressure_of(here) : 1);
    gesture.last_point = hit->point;
    if (gesture.travelled < gesture.spacing) continue;
    gesture.travelled = std::min(gesture.travelled - gesture.spacing, gesture.spacing);
    set_radius(radius_under(here, around.settings), gesture);
    add_dab(*hit, gesture);
  }
}

// A click is a dab of full depth.
void end_paint(PaintGesture& gesture) {
  if (gesture.stroke.samples.size() + gesture.earlier.size() > 1) return;
  gesture.stroke.samples.resize(kDabs, gesture.stroke.samples.front());
}

std::optional<DrawGesture> begin_draw(const Pointer& pointer, const Surroundings& around) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return std::nullopt;
  return DrawGesture{{hit->point}, around.settings.tool->use == ToolUse::curve};
}

void move_draw(const Pointer& pointer, const Surroundings& around, DrawGesture& gesture) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return;
  if (!gesture.is_curve) {
    gesture.points = {hit->point};
  } else if (norm(hit->point - gesture.points.back()) >= kPointSpacing * around.settings.radius) {
    gesture.points.push_back(hit->point);
  }
}

void end_draw(const DrawGesture& gesture, Placed& placed) {
  if (gesture.is_curve && gesture.points.size() > 1) {
    placed.curves.push_back(gesture.points);
  } else {
    placed.points.push_back(gesture.points.front());
  }
}

HandlePaintGesture begin_handle_paint(const Pointer& pointer, const Surroundings& around) {
  HandleMode mode = around.settings.handle;
  if (pointer.modifiers.ctrl) mode = mode == HandleMode::full ? HandleMode::zero : HandleMode::full;
  if (pointer.modifiers.shift) mode = HandleMode::erase;
  return {mode == HandleMode::erase ? std::uint8_t{0} : mode == HandleMode::full ? kFullHandle : kZeroHandle};
}

void move_handle_paint(const Pointer& pointer, const Surroundings& around, const HandlePaintGesture& gesture,
                       Placed& placed) {
  const auto hit = hit_at(pointer, around);
  if (!hit) return;
  const Snapshot& positions = around.state.positions;
  placed.handles.resize(positions.size());
  const double reach2 = around.settings.radius * around.settings.radius / 4;
  std::vector<Vec3d> centers{hit->point};
  for (const SymmetryImage& image : images_of(around.settings)) centers.push_back(image.motion(hit->point));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3d p = positions[i];
    const bool is_near = std::ranges::any_of(centers, [&](const Vec3d& c) { return norm2(p - c) <= reach2; });
    if (is_near) placed.handles[i] = gesture.handle;
  }
}

void extend_line(const Pointer& pointer, std::vector<Pixel>& line) {
  const Pixel here{pointer.x, pointer.y};
  const Pixel& last = line.back();
  if (std::hypot(here.x - last.x, here.y - last.y) >= kLassoPiece) line.push_back(here);
}

void end_lasso(const Surroundings& around, const LassoGesture& gesture, Placed& placed) {
  if (gesture.line.size() < 3) return;
  const Snapshot& positions = around.state.positions;
  placed.handles.resize(positions.size());
  std::vector<RigidMotion> motions{RigidMotion{}};
  for (const SymmetryImage& image : images_of(around.settings)) motions.push_back(image.motion);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3d p = positions[i];
    const bool is_marked = std::ranges::any_of(motions, [&](const RigidMotion& motion) {
      const auto pixel = pixel_of(around.screen, motion(p));
      return pixel && is_within(gesture.line, *pixel);
    });
    if (is_marked) placed.handles[i] = gesture.handle;
  }
}

}  // namespace knead::studio
