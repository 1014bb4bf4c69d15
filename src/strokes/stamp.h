// The tool of a stamp: a closed mesh in its pose, its contacts with a surface, and its measures.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "knead/editor/tools.h"
#include "knead/mesh.h"
#include "knead/vec.h"

namespace knead::detail {

// Places are relative to the tool's origin; directions are unit vectors. The tool need not be convex or connected. If
// it passes through itself, a point inside any part is inside.
class StampTool {
 public:
  // Throws InvalidInput, beginning with "mesh" in quotes, for a mesh that is not closed or not oriented outwards.
  StampTool(const Mesh& mesh, const Mat3d& pose);

  const Box& box() const { return box_; }

  // The point at which a ray from a place inside leaves the tool.
  struct Front {
    double need = 0;  // the distance to it
    Vec3d normal;     // of the face there, a unit vector; the zero vector for a face without area
  };
  // Returns nothing if p is outside.
  std::optional<Front> front(const Vec3d& p, const Vec3d& direction) const;

  // Returns the normal of the face nearest to p, as in Front.
  Vec3d nearest_normal(const Vec3d& p) const;

  // Returns the vector from p to the nearest point of the surface; nothing if p is outside.
  std::optional<Vec3d> exit_vector(const Vec3d& p) const;

  // Returns the distance of p from the surface, inside or outside.
  double distance(const Vec3d& p) const;

  // Returns the distance of p from the surface if p is inside, else 0.
  double depth(const Vec3d& p) const;

  // Returns half the tool's largest width across a direction, to 0.02%.
  double half_width(const Vec3d& direction) const;

  // Returns the width of the narrowest strokes of the tool's front: on 95% of its area, seen along the direction, the
  // tool is wider. Measures at the depth `below` under the face, or halfway to the back where the tool is thinner, at
  // 128 places. Error: about a fifth.
  double narrowest_width(const Vec3d& direction, double below) const;

 private:
  Vec3d normal_of(std::uint32_t triangle) const;
  // Returns the third shortest chord through p; nothing if p is outside.
  std::optional<double> width_at(const Vec3d& p, std::span<const Vec3d> across) const;

  std::vector<Vec3d> positions_;
  std::vector<Triangle> triangles_;
  Box box_;
  SurfaceTree tree_;
};

// Where a stamp's tool meets the surface within a step.

// A place that moves with the surface: a vertex (three times the same), or a point of a triangle.
struct StampPlace {
  Triangle vertices{};
  std::array<double, 3> barycentric{1, 0, 0};

  Vec3d at(std::span<const Vec3d> positions) const {
    return positions[vertices[0]] * barycentric[0] + positions[vertices[1]] * barycentric[1] +
           positions[vertices[2]] * barycentric[2];
  }
};

struct Contact {
  StampPlace place;
  Vec3d point;     // where it was found
  double tau = 0;  // when the tool hits it: 0 at the step's beginning, 1 at its end, below 0 before
};

// A step: the tool's origin moves from `to - motion` to `to`. `spacing` is that of the samples on triangles.
struct StampStep {
  Vec3d to;
  Vec3d motion;
  double spacing = 0;
  int threads = 0;  // 0: all
};

// Returns places of the surface that the tool hits in the step, the earliest first. They are at least `spacing` apart,
// and every place that is hit is within `spacing` of one of them. The result is the same for every number of threads.
std::vector<Contact> find_contacts(const StampTool& tool, const LiveSurface& surface, const StampStep& step);

// Points that are `spacing` or more apart, in cubic cells of that size.
class Thinned {
 public:
  explicit Thinned(double spacing) : spacing_(spacing) {}

  // Takes p if it is far enough from all points taken before. Returns true if it was taken.
  bool take(const Vec3d& p);

 private:
  std::int64_t index(double x) const;
  bool is_near(const Vec3d& p, std::uint64_t key) const;

  double spacing_;
  std::unordered_map<std::uint64_t, std::vector<Vec3d>> cells_;
};

// A place of the surface inside the tool, and the shortest displacement to the outside.
struct Penetration {
  StampPlace place;
  Vec3d point;
  Vec3d way;
};

// Returns the places inside the tool at the step's end, the deepest first. The result is the same for every number of
// threads.
std::vector<Penetration> find_intrusions(const StampTool& tool, const LiveSurface& surface, const StampStep& step);

// Returns the places nearer than `distance` to the tool's surface at the step's end, inside or outside.
std::vector<StampPlace> find_touching(const StampTool& tool, const LiveSurface& surface, const StampStep& step,
                                      double distance);

// Returns the greatest depth of the surface inside the tool at the step's end; 0 if it is outside.
double deepest_penetration(const StampTool& tool, const LiveSurface& surface, const StampStep& step);

// Where a stamp's tool slides along the surface: the contacts as pins (method, end of section 9).

// Surface points inside the tool become pins that move to the nearest point outside. Points that the tool touched
// become pins that stay, so that the flow back does not fill the groove behind the tool.
class SlippingContacts {
 public:
  // The tool must outlive this. radius: of the pins.
  SlippingContacts(const StampTool& tool, double radius) : tool_(tool), radius_(radius) {}

  // Holds, from now on, the surface points nearer than `distance` to the tool at the step's end.
  void hold_what_touches(const LiveSurface& surface, const StampStep& step, double distance);

  // Returns the pins that push the surface out of the tool at the step's end; nothing if no point is inside.
  std::optional<PinsStroke> pins(const LiveSurface& surface, const StampStep& step);

 private:
  bool is_near(const Vec3d& point, const std::vector<Penetration>& moving) const;

  const StampTool& tool_;
  double radius_;
  std::vector<StampPlace> pressed_;  // where the tool has been; half as far apart as pins
};

}  // namespace knead::detail

// Stamping (paper, section 4.4; method, section 4): a closed tool presses its shape into the surface.
namespace knead {

// What a stamp did.
struct StampResult {
  double outer = 0;        // as given, or the default for this tool
  double step = 0;         // as given, or the default
  std::size_t steps = 0;   // collision tests along the whole path
  double penetration = 0;  // greatest depth of the surface inside the tool at the end
  bool stopped = false;    // apply returned false; penetration is then not measured
  std::vector<std::string> warnings;
};

// Moves the tool along the path and pushes the surface in front of it.
//
// - Each piece of the path is cut into steps of equal length, at most stroke.step. Pieces of length zero are skipped.
// - Each step finds the contacts once, between the current surface and the tool at the end of the step, and moves them
//   in four quarters. A place joins in the quarter in which the tool hits it. Without contacts a step moves nothing.
// - Every motion goes to surface.apply as a PointsStroke. It holds the contacts, the stroke's exponent and one
//   displacement for each quarter.
// - A stamp that slips does neither. At most twice in each step it moves the points inside the tool to the nearest
//   place outside, by a PinsStroke with the radius `outer`. Further pins hold the surface that it has pressed so far.
//   If stroke.outer is not given, they also hold the surface that touches the tool where the path begins, so that a
//   path may be pressed in pieces.
// - These strokes, applied in order, repeat the stamp bit for bit, for every number of threads (0: all).
// - If the tool already intersects the surface at the start of the path, the surface inside moves along but is not
//   pushed out, and a warning says so. If the stamp slips, the surface is pushed out step by step.
//
// Throws InvalidInput, beginning with the key in quotes, for an invalid stroke and for a tool that is not closed and
// oriented outwards; nothing has moved then. Cost, without apply: about 10 us for each vertex in the tool's box at each
// step, on one core.
StampResult stamp(const StampStroke& stroke, const Mesh& tool, const LiveSurface& surface, int threads = 0);

// Returns the greatest number of segments that a stamp becomes. Throws as stamp does.
std::size_t stamp_segments(const StampStroke& stroke, const Mesh& tool);

}  // namespace knead
