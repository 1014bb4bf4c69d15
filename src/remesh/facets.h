// The flat faces of parts, which CAD programs divide into few triangles, and the edges between them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knead/error.h"
#include "knead/vec.h"
#include "remesh/surface.h"

namespace knead::detail {

// Returns how far points of a plane may lie from it because their coordinates were rounded to float; a length.
double plane_tolerance(std::span<const Vec3d> positions);

// How two triangles meet at their edge.
enum class Bend : std::uint8_t {
  open,  // there is no second triangle, or the edge is locked
  flat,  // they lie in one plane, to the tolerance
  soft,  // the angle between their normals is at most that of a crease
  sharp
};

// Returns the bend of each edge, by the positions `before`. `progress` cancels.
std::vector<Bend> find_bends(const Surface& s, double angle_deg, double tolerance, const Progress* progress);

// Adds to `creases`, which has a 1 for each known crease, the edges between the flat faces of a part:
// - sharp edges between two faces of several triangles, or where most edges around are flat or sharp;
// - soft edges of a face that has three triangles, or is long and narrow (a strip of a fillet or of a hole);
// - soft edges between two vertices of creases.
// Other edges belong to a rough or curved surface. Removes flat edges. Returns 1 for each triangle of a face that has
// three of them, or is long and narrow.
std::vector<std::uint8_t> add_edges_of_parts(const Surface& s, const std::vector<Bend>& bends,
                                             std::vector<std::uint8_t>& creases);

// Flips edges in the flat faces of parts to those of a Delaunay triangulation, by the positions `before`.
class FlatFlips {
 public:
  explicit FlatFlips(Surface& s) : s_(s), tolerance_(0.5 * plane_tolerance(s.before)) {}

  // Returns true if the edge must stay: one of a boundary, of a feature, or between planes.
  bool is_border(std::uint32_t h) const;

  // The edges of this face may gain by a flip.
  void unsettle(std::uint32_t f) {
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) unsettled_.push_back(s_.edge[h]);
  }

  // Flips edges until none of those unsettled, and of those around them, gains by it. Calls flipped(h) after each flip
  // with the new diagonal. Returns the number of flips.
  template <class Flipped>
  std::size_t settle(const Flipped& flipped) {
    std::size_t flips = 0;
    while (!unsettled_.empty()) {
      const std::uint32_t h = s_.halfedge[unsettled_.back()];
      unsettled_.pop_back();
      if (!gains_by_flip(h)) continue;
      flip(s_, h);
      s_.edge_flags[s_.edge[h]] = 0;
      ++flips;
      unsettle(h / 3);
      unsettle(s_.opposite[h] / 3);
      flipped(h);
    }
    return flips;
  }

 private:
  bool gains_by_flip(std::uint32_t h) const;
  bool keeps_values(std::uint32_t h) const;

  Surface& s_;
  double tolerance_;
  std::vector<std::uint32_t> unsettled_;
};

}  // namespace knead::detail
