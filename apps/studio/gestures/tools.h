// The tools in the person's hand: which, how large, where placed.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knead/math/mat3.h"
#include "knead/mesh/mesh.h"
#include "knead/remesh/remesh.h"
#include "knead/tool/placement.h"
#include "knead/tool/stroke.h"

namespace knead::studio {

enum class ToolKind { ball, capsule, paint, points, curve, stamp, rotate, stretch, twist, bend, handles };
inline constexpr int kToolCount = 11;

// "Ball", "Capsule", ...: as a person reads it.
const char* name_of(ToolKind tool);

// Where a drag takes the tool.
enum class DragMode { view, surface, normal, axis };

enum class HandleMode { full, zero, erase, move };

// How a closed tool is held.
struct StampShape {
  std::string name;                  // as a person reads it
  std::string file;                  // in the document's folder of stamps
  std::shared_ptr<const Mesh> mesh;  // about its origin
};

// Where rotate, stretch, twist, bend and stamp are placed. x, y and z are unit vectors, perpendicular to each other; a
// bend turns about x, all else goes along z.
struct Placement {
  Vec3d center;
  Vec3d x{1, 0, 0};
  Vec3d y{0, 1, 0};
  Vec3d z{0, 0, 1};
  // Of twist and bend on the shape as it was when placed: the barrel, or why there is none.
  std::optional<BarrelPlacement> barrel{};

  friend bool operator==(const Placement& a, const Placement& b) {
    return a.center == b.center && a.x == b.x && a.y == b.y && a.z == b.z;
  }
};

// What is set at the panels and with keys. Lengths in the mesh's own units.
struct ToolSettings {
  ToolKind tool = ToolKind::ball;
  double radius = 1;          // the outer threshold, > 0
  double inner_ratio = 0.35;  // inner over outer threshold, in [0.01, 0.95]
  DragMode drag = DragMode::view;
  Vec3d axis{0, 0, 1};        // of DragMode::axis
  bool on_surface = true;     // drags begin on the surface where the pointer is on it; else in the target's plane
  double capsule_length = 1;  // half of it, relative to the radius
  double depth = 0.15;        // of paint, relative to the radius, > 0
  bool paint_in = false;      // else out; Ctrl inverts
  int exponent = 8;           // of points and handles; even, 4 or more
  double stamp_size = 0.5;    // the tool's half extent, relative to the radius
  HandleMode handle = HandleMode::full;
  bool uses_barrel = true;       // twist and bend move one part, found by Studio; else all below the plane
  std::array<bool, 3> mirror{};  // in x = 0, y = 0, z = 0
  bool remesh = false;           // when a drag ends
  RemeshSettings remesh_settings;
};

// What a person has put somewhere for the next drag.
struct Placed {
  std::vector<Vec3d> points;
  std::vector<std::vector<Vec3d>> curves;
  std::optional<Placement> placement;
  std::vector<std::uint8_t> handles;  // for each vertex: kFullHandle, kZeroHandle or 0; empty: none
  std::optional<StampShape> stamp;
};
inline constexpr std::uint8_t kFullHandle = 1;
inline constexpr std::uint8_t kZeroHandle = 2;

}  // namespace knead::studio
