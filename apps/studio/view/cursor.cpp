#include "view/cursor.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "gestures/gesture_kinds.h"
#include "gestures/symmetry.h"

namespace knead::studio {

namespace {

constexpr int kPoints = 48;           // of a ring; a multiple of 2 kDash
constexpr int kDash = 2;              // steps of a dash, and of a gap
constexpr double kLongestStep = 0.4;  // of a ring, in its radii; without jumps a step has 2 pi / kPoints = 0.13
constexpr double kThickness = 1.1;    // half, in pixels
constexpr std::size_t kMaxImages = 32;

// The radii of the rings.
struct Radii {
  double outer = 0;
  double inner = 0;
};

std::optional<Radii> radii_of(const Studio& studio) {
  const ToolSettings& settings = studio.settings();
  switch (settings.tool->use) {
    case ToolUse::mask:
      if (settings.mask_mode != MaskMode::paint) return std::nullopt;
      return Radii{settings.radius, settings.inner_ratio * settings.radius};
    case ToolUse::pull:
      return Radii{settings.radius, settings.inner_ratio * settings.radius};
    case ToolUse::paint:
    case ToolUse::points:
    case ToolUse::curve:
      return Radii{settings.radius, falloff_facts(settings.falloff).half * settings.radius};  // where the weight is 1/2
    case ToolUse::pose:
      if (settings.pose == PoseMode::brush) return Radii{0.5 * settings.radius, 0};
      if (settings.auto_radius || !has_exact_pins(settings)) return std::nullopt;
      return Radii{settings.radius, 0};
    case ToolUse::handles:
      if (settings.handle == HandleMode::move) return std::nullopt;
      return Radii{0.5 * settings.radius, 0};
    case ToolUse::stamp:
    case ToolUse::turn:
      return std::nullopt;
  }
  return std::nullopt;
}

std::vector<Vec3d> flat_ring(const Vec3d& center, const Vec3d& normal, double radius) {
  return radius > 0 ? render::ring(center, normal, radius, kPoints) : std::vector<Vec3d>{};
}

// Draws pieces of `length` steps of a ring, each followed by a gap of `gap` steps. Steps that are longer than `most`
// are left out: there the ring jumps from one part of the shape to another.
void add_ring(const std::vector<Vec3d>& ring, std::size_t length, std::size_t gap, double most, render::Line line,
              std::vector<render::Line>& lines) {
  const auto add = [&] {
    if (line.points.size() > 1) lines.push_back(line);
    line.points.clear();
  };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3d& from = ring[i];
    const Vec3d& to = ring[(i + 1) % ring.size()];
    if (i % (length + gap) < length && norm(to - from) <= most) {
      if (line.points.empty()) line.points.push_back(from);
      line.points.push_back(to);
    } else {
      add();
    }
  }
  add();
}

std::vector<Vec3d> moved(std::vector<Vec3d> points, const RigidMotion& motion) {
  for (Vec3d& p : points) p = motion(p);
  return points;
}

}  // namespace

void SurfaceCursor::add_lines(const Studio& studio, std::vector<render::Line>& lines) {
  const ToolSettings& settings = studio.settings();
  const DocumentState& shown = studio.shown();
  const std::optional<Radii> radii = radii_of(studio);
  if (!radii || shown.opened == 0 || shown.looked_at) return;
  Vec3d place;
  const auto* const pull = studio.gesture() ? std::get_if<ImplicitGesture>(&studio.gesture()->kind) : nullptr;
  if (pull != nullptr) {
    place = pull->touched + (pull->stroke.path.back() - pull->stroke.path.front());
    key_ = {};
    rings_ = {flat_ring(place, pull->normal, radii->outer), flat_ring(place, pull->normal, radii->inner)};
  } else {
    if (!studio.pointer_is_over_view() || !shown.picker || !shown.picker->fits(shown.state)) return;
    const Ray ray = ray_through(studio.screen(), studio.pointer().x, studio.pointer().y);
    const auto hit = shown.picker->pick(ray, shown.state);
    if (!hit) return;
    place = hit->point;
    const Key key{hit->point, hit->normal, radii->outer, radii->inner, shown.version};
    if (!(key == key_)) {
      const auto ring = [&](double radius) {
        return radius > 0 ? shown.picker->ring_around(*hit, radius, kPoints, shown.state) : std::vector<Vec3d>{};
      };
      rings_ = {ring(radii->outer), ring(radii->inner)};
      key_ = key;
    }
  }
  const double thickness = kThickness * pixel_size(studio.screen(), place);
  std::vector<RigidMotion> motions{RigidMotion{}};
  for (const SymmetryImage& image : images_of(settings)) motions.push_back(image.motion);
  if (motions.size() > kMaxImages) motions.resize(kMaxImages);
  for (const RigidMotion& motion : motions) {
    const render::Line outer{.points = {}, .radius = thickness, .color = studio.preferences().outer_ring};
    const render::Line inner{.points = {}, .radius = thickness, .color = studio.preferences().inner_ring};
    add_ring(moved(rings_.outer, motion), kPoints, 0, kLongestStep * radii->outer, outer, lines);
    add_ring(moved(rings_.inner, motion), kDash, kDash, kLongestStep * radii->inner, inner, lines);
  }
}

}  // namespace knead::studio
