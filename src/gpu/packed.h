// Segments packed into the numbers that the shaders read. Internal to gpu.
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

// Writes layout::kFieldBounds numbers from `at` on: a bound of the support of a field from the segment's begin to its
// end.
void put_bounds(std::vector<double>& places, std::size_t at, const Field& field, const Segment& segment);

// Throws InvalidInput for segments that shaders cannot evaluate: with custom functions, masks or growth, and sums.
ShaderKind kind_of(const Segment& segment, const AdvectOptions& options);

// A point whose motion is below this part of the width of a field's transition keeps its bits.
inline constexpr double kMinMotion = 1e-14;

// The numbers of segments of one kind.
struct PackedSegments {
  int count = 0;
  std::vector<double> numbers;      // n[], to be rounded to float unless the kind is in double
  std::vector<double> places;       // e[]
  std::vector<std::int32_t> table;  // table[]
};

// Packs the first pack_length() segments. Returns the packs of one shader's calls: several if the first segment has
// pins, none if options.progress->cancel was set. Throws InvalidInput if the equations of pins cannot be solved.
std::vector<PackedSegments> pack(std::span<const Segment> segments, const AdvectOptions& options);

// Returns the number of segments, from the first on, that are packed together: those of the first's kind, within the
// limits of a shader's call, or one segment with pins.
std::size_t pack_length(std::span<const Segment> segments, const AdvectOptions& options);

// Solves the equations of a segment's pins and packs the pieces of its time, in the order of path lines. Returns and
// throws as pack().
std::vector<PackedSegments> pack_pins(const Segment& segment, const AdvectOptions& options);

// Returns whether pack_tree() accepts the field: a swept translation of many points without curves.
bool may_have_tree(const Field& field, const Segment& segment);

struct PackedTree {
  std::int32_t nodes = 0;             // 0: adding all points is as fast
  std::vector<Vec3d> points;          // in the tree's order
  double error_of_one = 0;            // the part of the sum's relative error that one point may cause
  std::vector<double> numbers;        // kNodeNumbers a node
  std::vector<std::int32_t> entries;  // kNodeEntries a node; points relative to the set's first one in n[]
};

// Packs the tree of clusters of the field's set.
PackedTree pack_tree(const Field& field, const Segment& segment, const AdvectOptions& options);

}  // namespace knead::gpu
