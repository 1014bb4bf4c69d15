// What hangs together below a barrel's outer plane, and how far from the axis. Internal to the tool room.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "knead/tool/barrel_reach.h"

namespace knead::tool_detail {

// The pieces of a shape where r < outer at the stroke's start. Two triangles hang together across a vertex
// there. `part` is the piece with the triangle whose corner is nearest to the centre.
struct BarrelPieces {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::vector<std::uint32_t> piece;  // of each triangle: a number, or kNone where it has nothing below
  std::uint32_t part = kNone;        // kNone where nothing is below
  double part_max = 0;               // the part's greatest distance from the axis
  double others = std::numeric_limits<double>::infinity();  // the least distance of a piece wholly beyond part_max
  std::size_t blocking = 0;                                 // triangles of pieces that are partly nearer than that
  double blocking_min = std::numeric_limits<double>::infinity();  // and how near
  std::size_t within = 0;                                         // triangles of pieces that are wholly nearer
  std::vector<Reach> later;  // merged: what triangles cover where a bend's turning normal brings r below outer
};

// The radius of the barrel is not looked at. Time: linear.
BarrelPieces barrel_pieces(const Barrel& barrel, std::span<const Vec3d> positions, std::span<const Triangle> triangles);

// Between part_max and others, about the middle, off `later` where that can be; nothing where a piece is in the way or
// there is no part.
std::optional<double> radius_in_gap(const BarrelPieces& pieces);

}  // namespace knead::tool_detail
