// Where fields can be felt, as the numbers that the shaders read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/glsl.h"
#include "knead/flow.h"
#include "knead/vec.h"

namespace knead::gpu {

// Writes the three numbers of v, or the nine of m by rows, from `at` on.
void put(std::vector<double>& to, std::size_t at, const Vec3d& v);
void put(std::vector<double>& to, std::size_t at, const Mat3d& m);

// Writes layout::kFieldBounds numbers from `at` on: where the support of a field of the segment lies at all times from
// its begin to its end.
void put_bounds(std::vector<double>& places, std::size_t at, const Field& field, const Segment& segment);

// Segments as the numbers that the shaders read.

// Throws InvalidInput, saying which, where a field is one of the caller's own functions, of which a shader knows
// nothing.
ShaderKind kind_of(const Segment& segment, const AdvectOptions& options);

// What a point moves less than this part of the width of a field's transition, it does not move at all.
inline constexpr double kMinMotion = 1e-14;

// Segments of one kind, one after the other.
struct PackedSegments {
  int count = 0;
  std::vector<double> numbers;      // n[], to be rounded to float unless the kind is in double
  std::vector<double> places;       // e[]
  std::vector<std::int32_t> table;  // table[]
};

// Packs segments of one kind, as many as pack_length returns. Returns the packs of one shader's calls: several where
// the first segment has pins, none where options.progress->cancel was set. Throws InvalidInput where the equations of
// pins cannot be solved.
std::vector<PackedSegments> pack(std::span<const Segment> segments, const AdvectOptions& options);

// Returns how many of the segments, from the first on, are packed together: those of the first's kind, as far as one
// call of the shader should take, or one segment with pins.
std::size_t pack_length(std::span<const Segment> segments, const AdvectOptions& options);

// Segments with pins as the numbers that the shaders read.

// Solves the equations of a segment's pins and packs the pieces of its time, in the order in which path lines pass
// them. Returns a pack for each call of a shader; none where options.progress->cancel is set. Throws InvalidInput where
// the equations cannot be solved.
std::vector<PackedSegments> pack_pins(const Segment& segment, const AdvectOptions& options);

// A set's tree of clusters as the numbers that the shaders read.

// Whether pack_tree may be asked: of many points alone that move with a swept translation, as sets.h has it.
bool may_have_tree(const Field& field, const Segment& segment);

struct PackedTree {
  std::int32_t nodes = 0;             // 0: to add up all points takes no longer
  std::vector<Vec3d> points;          // in the tree's order
  double error_of_one = 0;            // what one point may take of the sum's relative error
  std::vector<double> numbers;        // kNodeNumbers a node
  std::vector<std::int32_t> entries;  // kNodeEntries a node; points by where they are beyond the set's first in n[]
};

// Of the field's set.
PackedTree pack_tree(const Field& field, const Segment& segment, const AdvectOptions& options);

// Segments whose field is a grid of potentials as the numbers that the shaders read.

// Packs segments with grids.
PackedSegments pack_grids(std::span<const Segment> segments, const AdvectOptions& options);

// Returns how many of the segments with grids, from the first on, are packed together: as far as one call of the
// shader should take, or one segment.
std::size_t count_packed_grids(std::span<const Segment> segments);

}  // namespace knead::gpu
