// Where a stamp's tool meets the surface within a step. Internal to the tool room.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "knead/tool/live_surface.h"
#include "knead/tool/stamp_tool.h"

namespace knead::tool_detail {

// A place of the surface, which follows it as it moves: a vertex (three times the same), or a point of a triangle.
struct Place {
  Triangle vertices{};
  std::array<double, 3> barycentric{1, 0, 0};

  Vec3d at(std::span<const Vec3d> positions) const {
    return positions[vertices[0]] * barycentric[0] + positions[vertices[1]] * barycentric[1] +
           positions[vertices[2]] * barycentric[2];
  }
};

struct Contact {
  Place place;
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

// The places of the surface that the tool pushes in the step, the earliest first; any two are `spacing` or more apart,
// and every one that was found is within `spacing` of one of these. The same for every number of threads.
std::vector<Contact> find_contacts(const StampTool& tool, const LiveSurface& surface, const StampStep& step);

// Points that are `spacing` or more apart, in cubic cells of that size.
class Thinned {
 public:
  explicit Thinned(double spacing) : spacing_(spacing) {}

  // Whether p was taken, being as far from all before.
  bool take(const Vec3d& p);

 private:
  std::int64_t index(double x) const;
  bool is_near(const Vec3d& p, std::uint64_t key) const;

  double spacing_;
  std::unordered_map<std::uint64_t, std::vector<Vec3d>> cells_;
};

// A place of the surface inside the tool, and the shortest way out.
struct Intrusion {
  Place place;
  Vec3d point;
  Vec3d way;
};

// The places inside the tool at the step's end, the deepest first. The same for every number of threads.
std::vector<Intrusion> find_intrusions(const StampTool& tool, const LiveSurface& surface, const StampStep& step);

// The places nearer than `distance` to the tool's surface at the step's end, inside or outside.
std::vector<Place> find_touching(const StampTool& tool, const LiveSurface& surface, const StampStep& step,
                                 double distance);

// How deep the surface's deepest place lies inside the tool; the step's motion counts for nothing.
double deepest_penetration(const StampTool& tool, const LiveSurface& surface, const StampStep& step);

}  // namespace knead::tool_detail
