#include "gestures/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knead/error.h"

namespace knead::studio {

namespace {

constexpr double kOnPlane = 1e-9;  // of the radius: what counts as in a plane

double distance_to(const Symmetry::Plane& plane, const Vec3d& p) { return dot(p - plane.point, plane.normal); }

// Exact in the coordinate planes.
Vec3d in_plane(const Symmetry::Plane& plane, Vec3d p) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(plane.normal[axis]) == 1) {
      p[axis] = plane.point[axis];
      return p;
    }
  }
  return p - plane.normal * distance_to(plane, p);
}

Vec3d on_axis(const Symmetry& symmetry, const Vec3d& p) {
  const Vec3d axis = normalized(symmetry.axis);
  return symmetry.center + axis * dot(p - symmetry.center, axis);
}

}  // namespace

std::vector<Symmetry::Plane> mirror_planes(const ToolSettings& settings) {
  std::vector<Symmetry::Plane> planes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!settings.mirror[axis]) continue;
    Vec3d normal{0, 0, 0};
    normal[axis] = 1;
    planes.push_back({settings.symmetry.center, normal});
  }
  if (settings.symmetry.plane) planes.push_back(*settings.symmetry.plane);
  return planes;
}

std::optional<Mirror> mirror_of(const ToolSettings& settings) {
  if (settings.symmetry.turns > 1) return std::nullopt;
  Mirror mirror;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    // Of an axis plane only where it is on its axis counts, so that planes through the origin are written as their
    // names.
    Vec3d point = plane.point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(plane.normal[axis]) == 1) point = plane.normal * dot(plane.normal, plane.point);
    }
    mirror.push_back({plane.normal, point + Vec3d{0, 0, 0}});
  }
  try {
    validate(mirror);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  return mirror;
}

std::vector<SymmetryImage> images_of(const ToolSettings& settings) {
  const Symmetry& symmetry = settings.symmetry;
  const std::vector<Symmetry::Plane> planes = mirror_planes(settings);
  const bool is_exact = symmetry.center == Vec3d{0, 0, 0} && !symmetry.plane;
  std::vector<SymmetryImage> images;
  for (int turn = 0; turn < std::clamp(symmetry.turns, 1, kMaxTurns); ++turn) {
    const double angle = 2 * std::numbers::pi * turn / symmetry.turns;
    const RigidMotion turned = turn == 0 ? RigidMotion{} : rotation_about(symmetry.center, symmetry.axis, angle);
    for (unsigned mask = 0; mask < 1U << planes.size(); ++mask) {
      if (turn == 0 && mask == 0) continue;
      SymmetryImage image{turned};
      for (std::size_t i = 0; i < planes.size(); ++i) {
        if ((mask >> i & 1U) == 0) continue;
        image.motion = image.motion * reflection_in(planes[i].point, planes[i].normal);
        const Vec3d& n = planes[i].normal;
        if (turn == 0 && is_exact) image.planes |= n.x == 1 ? 1U : n.y == 1 ? 2U : 4U;
      }
      images.push_back(image);
    }
  }
  return images;
}

Vec3d snapped_to_symmetry(Vec3d p, const ToolSettings& settings) {
  const double near = 0.5 * settings.inner_ratio * settings.radius;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (std::abs(distance_to(plane, p)) < near) p = in_plane(plane, p);
  }
  if (settings.symmetry.turns < 2) return p;
  const Vec3d axial = on_axis(settings.symmetry, p);
  return norm(p - axial) < near ? axial : p;
}

Vec3d kept_in_symmetry(Vec3d p, const Vec3d& first, const ToolSettings& settings) {
  const double near = kOnPlane * settings.radius;
  for (const Symmetry::Plane& plane : mirror_planes(settings)) {
    if (std::abs(distance_to(plane, first)) <= near) p = in_plane(plane, p);
  }
  const bool is_on_axis = settings.symmetry.turns > 1 && norm(first - on_axis(settings.symmetry, first)) <= near;
  return is_on_axis ? on_axis(settings.symmetry, p) : p;
}

}  // namespace knead::studio
